"""Compressed content in memory, of bounded size: a few bytes may hold many."""

from __future__ import annotations

import os
import zlib

from .errors import InputError

LEAST = 2_000_000_000
SURE = 500_000_000  # bytes of content that show how much the rest expands
EXPANDS = 400  # times: a CSV whose rows are all the same expands 300 times
BLOCK = 1 << 17  # bytes that a block of zstd holds at most
SKIPPED = range(0x184D2A50, 0x184D2A60)  # magic numbers of frames without content
ZSTD = 0xFD2FB528


def most_unpacked() -> int:
    """How many bytes a compressed file may hold that is read whole: a quarter of the machine's memory."""
    try:
        return max(LEAST, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 4)
    except (AttributeError, ValueError, OSError):
        return LEAST


def too_large(file: str, held: int | None = None) -> InputError:
    """What is said of a file with more; held: how much of it was seen."""
    most = most_unpacked()
    if held is not None and held < most:
        return InputError(f"{file} unpacks to more than {EXPANDS} times its size, as no table does")
    return InputError(
        f"{file} unpacks to more than {most / 1e9:.1f} GB, a quarter of this machine's memory; unpack it, or divide it"
    )


def gunzip(file: str, packed: bytes) -> bytes:
    """All members of a gzip file, a third faster than the standard library's own way. Errors: InputError for a file
    with more than `most_unpacked` bytes, EOFError and zlib.error for a damaged one.
    """
    pieces: list[bytes] = []
    held, size, most = 0, len(packed), most_unpacked()
    while packed:
        member = zlib.decompressobj(wbits=31)
        # a first piece shows how much the content expands
        for length in (SURE, most + 1 - held):
            pieces.append(member.decompress(packed, length))
            held += len(pieces[-1])
            if held > most or (held >= SURE and held > EXPANDS * size):
                raise too_large(file, min(held, most))
            packed = member.unconsumed_tail
            if member.eof or not packed:
                break
        if not member.eof:
            raise EOFError("the compressed data ends too early")
        packed = member.unused_data.lstrip(b"\x00")
    return pieces[0] if len(pieces) == 1 else b"".join(pieces)


def zstd_size(packed: bytes) -> int:
    """How many bytes the frames of a zstd file hold at most (RFC 8878, section 3.1), found without unpacking them."""
    total, at = 0, 0
    while at + 4 <= len(packed):
        magic = int.from_bytes(packed[at : at + 4], "little")
        if magic in SKIPPED:
            at += 8 + int.from_bytes(packed[at + 4 : at + 8], "little")
            continue
        if magic != ZSTD or at + 5 > len(packed):
            break
        descriptor = packed[at + 4]
        single, checked = descriptor & 0x20, descriptor & 4
        size = (1 if single else 0, 2, 4, 8)[descriptor >> 6]
        at += 5 + (0 if single else 1) + (0, 1, 2, 4)[descriptor & 3] + size
        last = False
        while not last and at + 3 <= len(packed):
            block = int.from_bytes(packed[at : at + 3], "little")
            last, kind, held = bool(block & 1), block >> 1 & 3, block >> 3
            total += min(held, BLOCK) if kind < 2 else BLOCK
            at += 3 + (1 if kind == 1 else held)
        at += 4 if checked else 0
    return total
