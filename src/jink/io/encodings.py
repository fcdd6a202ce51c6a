"""Text files in other encodings than UTF-8, and what a receiver's memory leaves behind the text."""

from __future__ import annotations

MARKS = (
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
HEAD = 512  # bytes that tell text of two bytes a letter


def plain_text(content: bytes) -> tuple[bytes, tuple[str, ...]]:
    """Text of two or four bytes a letter in UTF-8, without a byte-order mark, and without zeros at its end; notes."""
    for mark, encoding in MARKS:
        if content.startswith(mark):
            return content.decode(encoding, errors="replace").encode(), ()
    head = content[:HEAD]
    for encoding, zeros, letters in (("utf-16-le", head[1::2], head[::2]), ("utf-16-be", head[::2], head[1::2])):
        if len(zeros) > 8 and not any(zeros) and all(letters):
            return content.decode(encoding, errors="replace").encode(), ("read as UTF-16 without a byte-order mark",)
    content = content.removeprefix(b"\xef\xbb\xbf")
    if content.endswith(b"\x00") and b"\x00" not in head:
        whole = content.rstrip(b"\x00")
        if b"\x00" not in whole:
            count = len(content) - len(whole)
            return whole, (f"{count} zero bytes at the end are no rows (a recorder that was switched off?)",)
    return content, ()


def western_text(content: bytes) -> tuple[bytes, tuple[str, ...]]:
    """Windows-1252 in UTF-8: text whose letters beyond ASCII are mostly no UTF-8; and a note."""
    if content.isascii():
        return content, ()
    try:
        content.decode()
    except UnicodeDecodeError:
        text = content.decode(errors="replace")
        bad = text.count("\ufffd")
        if 2 * bad > sum(not letter.isascii() for letter in text):
            return content.decode("cp1252", errors="replace").encode(), ("read as Windows-1252 (it is no UTF-8)",)
    return content, ()
