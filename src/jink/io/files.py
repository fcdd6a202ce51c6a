"""Files in: CSV, Parquet, Arrow/Feather, JSON, JSON Lines, plain, .gz or .zst, told apart by content.

A `Table` knows its column names before it is read, so that only the columns that are needed get parsed.
Reading gives two frames: the rows, with their number in the file (`row`, from 0, as a DataFrame of the same
file would count them), and the rows that could not be read at all, with the reason.
"""

from __future__ import annotations

import glob
import io
import os
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from pathlib import Path

import polars as pl

from ..frozen import frozen
from . import ahead
from .archives import Member, files_inside, members
from .encodings import plain_text, western_text
from .errors import InputError, NoTable
from .formats import csv as csv_text
from .formats import json as json_text
from .rejected import unreadable
from .stages import stage
from .unpacking import gunzip, most_unpacked, too_large, zstd_size

HEAD = 1 << 16  # bytes that tell the format
Rows = tuple[pl.DataFrame, pl.DataFrame]

UNREADABLE = (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError)
MAGIC = {b"PAR1": "parquet", b"ARROW1": "arrow", b"\xff\xff\xff\xff": "arrow stream"}
GZIP, ZSTD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"
PACKED = b"PK\x03\x04"
FOREIGN = {
    PACKED: "a ZIP archive that cannot be read, or an Excel sheet (export that as CSV)",
    b"FEA1": "a Feather file of version 1 (write it again with version 2)",
    b"\x89HDF": "an HDF5 file (export it as Parquet or CSV)",
    b"BZh": "compressed with bzip2 (jink reads plain, .gz and .zst files)",
    b"\xfd7zXZ": "compressed with xz (jink reads plain, .gz and .zst files)",
    b"SQLi": "an SQLite database (export the table as Parquet or CSV)",
    b"ULog": "a PX4 log (ulog2csv of the package pyulog turns it into CSV)",
    b"#ROSBAG": "a ROS bag (export the topic as CSV)",
    b"\xd4\xc3\xb2\xa1": "a network capture (extract its messages first)",
    b"\x1a1": "a dump in Beast format (readsb or dump1090 turn it into SBS-1 or JSON)",
    b"\x1a2": "a dump in Beast format (readsb or dump1090 turn it into SBS-1 or JSON)",
    b"\x1a3": "a dump in Beast format (readsb or dump1090 turn it into SBS-1 or JSON)",
}

BESIDE = {
    b"%PDF": "a PDF document (export the table as CSV)",
    b"\x89PNG": "an image",
    b"\xff\xd8\xff": "an image",
}


@frozen
class Table:
    """One input file: its name, its columns, and how to read some of them; notes on its content, and the columns that
    its format fixes (role with a unit: name).
    """

    file: str
    format: str
    names: list[str]
    read: Callable[[Sequence[str]], Rows]
    notes: tuple[str, ...] = ()
    fixed: Mapping[str, str] = field(default_factory=dict)


def expand(inputs: Sequence[str | Path]) -> list[Path]:
    """Paths, folders and glob patterns to files, in the order given, each once; InputError for what does not exist."""
    found: dict[Path, None] = {}
    for given in inputs:
        path = Path(given)
        if path.is_dir():
            inside = files_inside(path)
            if not inside:
                raise InputError(f"{given} is a directory without files")
            found.update(dict.fromkeys(inside))
            continue
        # pipes such as <(command) are read once, from beginning to end
        if path.is_file() or path.is_fifo():
            found[path] = None
            continue
        matches = sorted(p for p in map(Path, glob.glob(str(given), recursive=True)) if p.is_file())
        if not matches:
            what = "no file matches the pattern" if glob.has_magic(str(given)) else "no such file:"
            raise InputError(f"{what} {given}")
        found.update(dict.fromkeys(matches))
    if not found:
        raise InputError("no input file was given")
    return list(found)


def open_tables(path: Path, left_out: list[str] | None = None) -> Iterator[Table]:
    """The table of a file, or those of all files in a ZIP archive, called `archive.zip/file`. Errors: InputError; notes
    and pictures that an archive holds beside tables are named in `left_out`, if that is given.
    """
    packed = members(path) if path.is_file() else []
    if len(packed) < 2:
        yield open_table(path)
        return
    for member in packed:
        try:
            table = _open_member(f"{name_of(path)}/{member.name}", member)
        except NoTable as error:
            if left_out is None:
                raise
            left_out.append(str(error).splitlines()[0])
            continue
        yield table


def _open_member(file: str, member: Member) -> Table:
    content = member.content()
    if content.startswith((GZIP, ZSTD)):
        content = _unpacked(file, content)
    if content.startswith(PACKED):
        raise InputError(f"{file} is an archive inside an archive (unpack the outer one), or an Excel sheet")
    if content:
        check_foreign(file, content[:16])
    return open_content(file, content)


def name_of(path: Path) -> str:
    """A file's name as text; bytes that are not UTF-8 are shown as `\\xff`."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


@stage("read")
def open_table(path: Path) -> Table:
    """Recognise a file's format by its first bytes and read its column names, or raise InputError."""
    file = name_of(path)
    if path.is_fifo():
        return _from_pipe(file, path)
    try:
        with path.open("rb") as handle:
            head = handle.read(16)
    except OSError as error:
        raise InputError(f"{file} cannot be opened: {error.strerror}") from None
    if not head:
        raise InputError(f"{file} is empty")
    if head.startswith((GZIP, ZSTD)):
        content = ahead.unpacked(path)
        return open_content(file, _unpacked(file, path.read_bytes()) if content is None else content)
    if head.startswith(PACKED) and len(packed := members(path)) == 1:
        return _open_member(file, packed[0])
    check_foreign(file, head)
    for magic, kind in MAGIC.items():
        if head.startswith(magic):
            # polars opens names that are UTF-8 alone
            return _columnar(file, path if file == str(path) else io.BytesIO(path.read_bytes()), kind)
    return open_content(file, path.read_bytes())


def check_foreign(file: str, head: bytes) -> None:
    """Errors: InputError for content that is known but not read; NoTable for what stands beside tables."""
    for error, known in ((InputError, FOREIGN), (NoTable, BESIDE)):
        for magic, what in known.items():
            if head.startswith(magic):
                raise error(f"{file} is {what}")
    if head[8:12] == b".FIT":
        raise InputError(f"{file} is a FIT file of a sports watch (export it as GPX or TCX)")


def _from_pipe(file: str, path: Path) -> Table:
    with path.open("rb") as handle:
        content = handle.read(most_unpacked() + 1)
    if not content:
        raise InputError(f"{file} is empty")
    if len(content) > most_unpacked():
        raise too_large(file)
    if content.startswith((GZIP, ZSTD)):
        content = _unpacked(file, content)
    check_foreign(file, content[:16])
    return open_content(file, content)


def _unpacked(file: str, packed: bytes) -> bytes:
    """The content of a .gz or .zst file; polars brings the zstd decoder, for text alone. Errors: InputError."""
    try:
        if packed.startswith(GZIP):
            return gunzip(file, packed)
        if zstd_size(packed) > most_unpacked():
            raise too_large(file)
        return "\n".join(pl.read_lines(io.BytesIO(packed))["line"].to_list()).encode()
    except (OSError, EOFError, zlib.error, pl.exceptions.PolarsError) as error:
        if "utf8" in str(error):
            raise InputError(
                f"{file} is compressed with zstd and holds no text in UTF-8; unpack it, or pack it as .gz"
            ) from None
        raise InputError(f"{file} is compressed and cannot be unpacked (truncated or damaged?): {error}") from None


def open_content(file: str, content: bytes) -> Table:
    """Recognise the format of a file's content. Errors: InputError."""
    for magic, kind in MAGIC.items():
        if content.startswith(magic):
            return _columnar(file, io.BytesIO(content), kind)
    if content.startswith((GZIP, ZSTD)):
        content = _unpacked(file, content)  # packed twice, or in an archive
    content, said = plain_text(content)
    start = content[:4096].lstrip()[:1]
    if not start and not content.strip():
        raise InputError(f"{file} is empty")
    from .formats.registry import FORMATS  # many files, which binary tables do not need

    head = content[:HEAD].lstrip()
    for known in FORMATS:
        if known.recognises(head):
            records = known.read(file, content)
            note = f"read as {known.title}"
            return Table(file, known.title, records.names, records.read, (note, *said, *records.notes), records.fixed)
    if start in (b"[", b"{"):
        return _json(file, content)
    if start == b"<":
        raise NoTable(f"{file} is XML or HTML of an unknown kind; jink reads GPX, KML and TCX of that sort")
    if content[257:262] == b"ustar":
        raise InputError(f"{file} is a tar archive (unpack it, or pack its files as ZIP)")
    if b"\x00" in content[:4096]:
        raise NoTable(
            f"{file} is a binary file of an unknown format; jink reads CSV, Parquet, Arrow/Feather, JSON and JSON Lines"
        )
    content, western = western_text(content)
    table = csv_text.CsvText(file, content)
    return Table(file, "csv", table.names, table.read, (*said, *western, *table.notes))


def _json(file: str, content: bytes) -> Table:
    """Objects whose first level names a position, or what nests deeper."""
    from .formats import nested

    text: json_text.JsonText | None = None
    try:
        text = json_text.JsonText(file, content)
    except InputError:
        records = None if content.lstrip().startswith(b"[") else _nested(file, content)
        if records is None:
            raise
        return records
    deep = "container" in text.types.values() and not nested.has_position(text.names)
    return (_nested(file, content) if deep else None) or Table(file, "json", text.names, text.read, text.notes)


def _nested(file: str, content: bytes) -> Table | None:
    from .formats import nested

    try:
        records = nested.read(file, content)
    except InputError:
        return None
    return records and Table(file, "json", records.names, records.read, records.notes)


def _columnar(file: str, source: Path | io.BytesIO, kind: str) -> Table:
    """Parquet and Arrow: the schema is known without reading the rows."""
    try:
        if kind == "parquet":
            names = list(pl.read_parquet_schema(source))
        elif kind == "arrow":
            names = list(pl.read_ipc_schema(source))
        else:
            names = pl.read_ipc_stream(source).columns
    except UNREADABLE as error:
        raise InputError(f"{file} is not a readable {kind} file (truncated or damaged?): {error}") from None

    def read(wanted: Sequence[str]) -> Rows:
        if isinstance(source, io.BytesIO):
            source.seek(0)
        try:
            if kind == "parquet":
                frame = pl.read_parquet(source, columns=list(wanted))
            elif kind == "arrow":
                frame = pl.read_ipc(source, columns=list(wanted))
            else:
                frame = pl.read_ipc_stream(source, columns=list(wanted))
        except UNREADABLE as error:
            raise InputError(f"{file} is not a readable {kind} file (truncated or damaged?): {error}") from None
        return frame.with_row_index("row"), unreadable()

    return Table(file, kind, names, read)
