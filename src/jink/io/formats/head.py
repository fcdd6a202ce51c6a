"""What stands around a CSV table: `sep=;`, comments, lines before the header, repeated headers, separators at ends."""

from __future__ import annotations

import csv
import re

from ...frozen import frozen
from ..columns import normal
from ..roles import POSITIONS, ROLES

SEPARATORS = ",;\t|"
LINES = 40  # lines among which the header is looked for
COMMENTS = ("#", "//", "%")


@frozen
class Body:
    """The table itself: header and rows without what stood around them, the separator, and what was left out."""

    content: bytes
    separator: str
    notes: tuple[str, ...]


def body(content: bytes) -> Body:
    """Find the table in a text."""
    notes: list[str] = []
    if b"\n" not in content and b"\r" in content:
        content = content.replace(b"\r", b"\n")
    content = content.strip(b"\r\n")
    separator = None
    found = re.match(rb"\"?sep=(.)\"?[ \t]*\r?\n", content)
    if found:
        separator = found[1].decode("latin-1")
        content = content[found.end() :].lstrip(b"\r\n")
    skipped = _before_header(content, separator)
    if skipped:
        lines = content.split(b"\n", skipped)
        content = lines[skipped]
        notes.append(f"{skipped} lines before the header are skipped")
    first = first_line(content).decode("utf-8", errors="replace").rstrip("\r")
    if separator is None:
        separator = max(SEPARATORS, key=first.count)
        if first.count(separator) == 0 and len(first.split()) > 2 and _blanks(content):
            content = b"\n".join(b"\t".join(line.split()) for line in content.splitlines())
            separator = "\t"
            first = first_line(content).decode("utf-8", errors="replace")
    content = _without(content, first, separator.encode(), notes)
    return Body(_even_ends(content, separator.encode()), separator, tuple(notes))


def _first_lines(content: bytes) -> list[str]:
    lines = content[: _end_of_line(content, LINES)].split(b"\n")
    return [line.decode("utf-8", errors="replace").strip("\r") for line in lines]


def _end_of_line(content: bytes, lines: int) -> int:
    """Where the first lines end, so many of them; nothing of the others is copied."""
    end = -1
    for _ in range(lines):
        end = content.find(b"\n", end + 1)
        if end < 0:
            return len(content)
    return end


def first_line(content: bytes) -> bytes:
    """Up to the first line's end."""
    return content[: _end_of_line(content, 1)]


def _before_header(content: bytes, separator: str | None) -> int:
    """How many lines come before the header: comments, or lines of another kind before one that names positions."""
    lines = _first_lines(content)
    comments = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith(COMMENTS)), 0)
    if comments:
        sign = separator or max(SEPARATORS, key=lines[comments].count)
        last, first = lines[comments - 1].split(sign), lines[comments].split(sign)
        # a header may begin with a comment's sign itself: then the line after it is a row
        own = len(last) == len(first) > 1 and any(map(is_number, first))
        return comments - 1 if own else comments
    if _names_position(lines[0], separator):
        return 0
    for i, line in enumerate(lines[1:], 1):
        if _names_position(line, separator):
            return i
    return 0


def _names_position(line: str, separator: str | None) -> bool:
    """Whether a line has the names of a position and no numbers."""
    for sign in separator or SEPARATORS:
        fields = _fields(line.replace("\x00", ""), sign) if sign in line else []
        names = {re.sub(r"_(deg|m|km|ft|rad)$", "", normal(field)) for field in fields}
        pairs = [[set(ROLES[role][1]) for role in roles] for roles in POSITIONS.values()]
        if any(all(names & known for known in pair) for pair in pairs) and not any(map(is_number, fields)):
            return True
    return False


def _fields(line: str, sign: str) -> list[str]:
    """The fields of a line, none where it is no CSV."""
    try:
        return next(csv.reader([line], delimiter=sign), [])
    except csv.Error:
        return []


def _blanks(content: bytes) -> bool:
    """Whether all first lines have the same number of words, so that blanks separate columns."""
    counts = {len(line.split()) for line in _first_lines(content) if line.strip()}
    return len(counts) == 1


def _without(content: bytes, header: str, sign: bytes, notes: list[str]) -> bytes:
    """Leave out comments between rows and headers that repeat."""
    start = header[:1].encode("utf-8", errors="replace")
    repeated = content.count(b"\n" + header.encode("utf-8", errors="replace"))
    comments = content.count(b"\n#") if start != b"#" else 0
    if not repeated and not comments:
        return content
    # a row may begin with such a sign too: then it has as many fields as the header
    fields = first_line(content).count(sign)
    kept, again, remarks = [], 0, 0
    for number, line in enumerate(content.split(b"\n")):
        if number and line.rstrip(b"\r").decode("utf-8", errors="replace") == header:
            again += 1
        elif number and comments and line.startswith(b"#") and line.count(sign) != fields:
            remarks += 1
        else:
            kept.append(line)
    if again:
        notes.append(f"{again} repeated headers are skipped")
    if remarks:
        notes.append(f"{remarks} comments between rows are skipped")
    return b"\n".join(kept)


def _even_ends(content: bytes, separator: bytes) -> bytes:
    """A separator that ends every row but not the header, or the header but not the rows."""
    pieces = content[: _end_of_line(content, 2)].split(b"\n")
    if len(pieces) > 1 and _rows_are_named(pieces[0], pieces[1], separator.decode()):
        return b"row_name" + separator + content
    if len(pieces) < 2 or b'"' in pieces[0] + pieces[1]:
        return content
    header, row = (piece.rstrip(b"\r") for piece in pieces[:2])
    more = row.count(separator) - header.count(separator)
    if more == 1 and row.endswith(separator):
        return header + separator + content[len(pieces[0]) :]
    if more == -1 and header.endswith(separator):
        return header[: -len(separator)] + content[len(pieces[0]) :]
    return content


def _rows_are_named(header: bytes, row: bytes, sign: str) -> bool:
    """Whether a row begins with its number, which the header has no name for, as R writes tables."""
    names, fields = (_fields(line.decode("utf-8", errors="replace").strip("\r"), sign) for line in (header, row))
    return len(fields) == len(names) + 1 > 2 and fields[0].strip() == "1" and bool(fields[-1].strip())


def is_number(text: str) -> bool:
    """Whether a field is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
