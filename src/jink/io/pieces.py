"""Files in pieces of bounded size: Parquet and Arrow by rows, CSV and JSON Lines (plain or .gz) by blocks of lines.

Other formats are read whole (`files.py`).
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO

import polars as pl

from ..frozen import frozen
from .errors import InputError
from .files import UNREADABLE, Rows, Table, name_of, open_content
from .formats.csv import CsvText
from .formats.json import JsonText
from .rejected import unreadable

BLOCK = 1 << 25  # bytes of text that are parsed at once
HEAD = 1 << 18
GZIP = b"\x1f\x8b"


@frozen
class Pieced:
    """A table that is read in pieces: its first piece as a `Table`, and all of them for some columns."""

    table: Table
    read: Callable[[Sequence[str]], Iterator[Rows]]


def row_count(path: Path) -> int:
    """About how many rows a file has; 0 where that takes reading it."""
    if path.is_fifo() or name_of(path) != str(path):
        return 0
    try:
        with path.open("rb") as handle:
            head = handle.read(HEAD)
        if head.startswith(b"PAR1"):
            return int(pl.scan_parquet(path).select(pl.len()).collect().item())
        if head.startswith(b"ARROW1"):
            return int(pl.scan_ipc(path).select(pl.len()).collect().item())
        size, packed = path.stat().st_size, 1.0
        if head.startswith(GZIP):
            text = zlib.decompressobj(wbits=31).decompress(head, 1 << 24)
            packed, head = len(text) / len(head), text
        lines = head.count(b"\n") or head.count(b"},") or 1
        return int(size * packed * lines / max(len(head), 1))
    except (*UNREADABLE, zlib.error):
        return 0


def pieced(path: Path, rows: int) -> Pieced | None:
    """The file in pieces of about so many rows; None where its format is read whole. Errors: InputError."""
    file = name_of(path)
    if path.is_fifo() or file != str(path):
        return None
    with path.open("rb") as handle:
        head = handle.read(16)
    if head.startswith((b"PAR1", b"ARROW1")):
        return _by_rows(file, path, pl.scan_parquet if head.startswith(b"PAR1") else pl.scan_ipc, rows)
    if head.startswith((b"\x28\xb5\x2f\xfd", b"PK\x03\x04", b"\xff\xfe", b"\xfe\xff")):
        return None
    return _by_lines(file, path)


def _by_rows(file: str, path: Path, scan: Callable[[Path], pl.LazyFrame], rows: int) -> Pieced:
    try:
        lazy = scan(path)
        names, count = lazy.collect_schema().names(), int(scan(path).select(pl.len()).collect().item())
    except UNREADABLE as error:
        raise InputError(f"{file} is not readable (truncated or damaged?): {error}") from None

    def slices(wanted: Sequence[str]) -> Iterator[Rows]:
        for start in range(0, max(count, 1), rows):
            try:
                frame = scan(path).select(list(wanted)).slice(start, rows).collect()
            except UNREADABLE as error:
                raise InputError(f"{file} is not readable (truncated or damaged?): {error}") from None
            yield frame.with_row_index("row", offset=start), unreadable()

    return Pieced(Table(file, "parquet", names, lambda wanted: next(slices(wanted))), slices)


def _by_lines(file: str, path: Path) -> Pieced | None:
    """CSV with a header in its first line, or JSON Lines; None for any other text."""
    first = next(_blocks(file, path), b"").removeprefix(b"\xef\xbb\xbf")
    if not first.strip() or b"\x00" in first[:4096]:
        return None
    try:
        table = open_content(file, first)
    except InputError:
        return None
    header = first.split(b"\n", 1)[0] + b"\n"
    if table.format == "json" and first.lstrip().startswith(b"{"):
        make, header = JsonText, b""
    elif table.format == "csv" and CsvText(file, header + b"\n").names == table.names and not table.notes:
        make = CsvText
    else:
        return None
    names = table.names

    def parsed(wanted: Sequence[str]) -> Iterator[Rows]:
        start = 0
        for number, block in enumerate(_blocks(file, path)):
            block = block.removeprefix(b"\xef\xbb\xbf")
            text = make(file, block if number == 0 else header + block)
            if make is JsonText and set(text.names) - set(names):
                new = sorted(set(text.names) - set(names))[0]
                raise InputError(
                    f"{file}: the column {new!r} begins after the first {BLOCK:,} bytes; "
                    "a larger --memory reads the file whole"
                )
            here = [name for name in wanted if name in text.names]
            # what a column holds is not decided by one block
            frame, bad = text.read(here, typed=False) if isinstance(text, CsvText) else text.read(here)
            frame = frame.with_columns(pl.lit(None).alias(name) for name in wanted if name not in here)
            count = frame.height + bad.height
            shift = pl.col("row") + start
            yield frame.select("row", *wanted).with_columns(shift), bad.with_columns(shift)
            start += count

    return Pieced(table, parsed)


def _blocks(file: str, path: Path) -> Iterator[bytes]:
    """The text of a file in blocks of whole lines; a quoted field that goes on in the next line is not cut."""
    rest = b""
    with path.open("rb") as handle:
        for part in _text(file, handle):
            rest += part
            cut = rest.rfind(b"\n") + 1
            tries = 0
            while cut and rest.count(b'"', 0, cut) % 2 and tries < 1000:
                cut, tries = rest.rfind(b"\n", 0, cut - 1) + 1, tries + 1
            if not cut or tries == 1000:
                cut = rest.rfind(b"\n") + 1
            if cut:
                yield rest[:cut]
                rest = rest[cut:]
            elif len(rest) > 4 * BLOCK:
                raise InputError(f"{file}: a line is longer than {4 * BLOCK:,} bytes")
    if rest.strip():
        yield rest


def _text(file: str, handle: IO[bytes]) -> Iterator[bytes]:
    """The content, unpacked if need be."""
    head = handle.read(2)
    handle.seek(0)
    if head != GZIP:
        while part := handle.read(BLOCK):
            yield part
        return
    unpack = zlib.decompressobj(wbits=31)
    try:
        while packed := handle.read(1 << 20):
            while packed:
                yield unpack.decompress(packed, BLOCK)
                packed = unpack.unconsumed_tail
                if unpack.eof:
                    packed = unpack.unused_data.lstrip(b"\x00")
                    if packed or handle.peek(1):  # type: ignore[attr-defined]
                        unpack = zlib.decompressobj(wbits=31)
    except zlib.error as error:
        raise InputError(f"{file} is compressed and cannot be unpacked (truncated or damaged?): {error}") from None
    if not unpack.eof:
        raise InputError(f"{file} is compressed and cannot be unpacked (truncated or damaged?): it ends too early")


def same_kind(notes: Sequence[str]) -> frozenset[str]:
    """What notes say of units, without the numbers that differ from piece to piece."""
    return frozenset(re.sub(r" \(.*?\)", "", note) for note in notes if " taken as " in note and "--" in note)
