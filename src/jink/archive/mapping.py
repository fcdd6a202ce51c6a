"""An input file to measurements in one Arrow file: its rows, as they are everywhere read, sorted by bucket."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from ..io.errors import InputError
from ..io.files import name_of
from ..io.loading import load_tables
from ..io.measurements import Measurements
from ..io.pieces import pieced, row_count, same_kind
from ..io.rejected import together
from ..io.spill import Source, check_alike
from ..io.values import short, taken
from . import job as names
from .errors import Stopped
from .hashing import bucket_of
from .job import Job

SOMETIMES = ("on_ground",)  # columns that measurements have where a row is so


def map_file(job: Job, number: int) -> dict[str, Any]:
    """Divide one file; what `names.mapped` says of it. A file that cannot be read says why. Errors: Stopped."""
    job.check()
    done = job.said(names.mapped(number))
    if done is not None:
        return done
    path = Path(job.files[number][0])
    shown = job.files[number][1]
    said: dict[str, Any] = {"number": number, "file": shown, "rows": 0, "parts": [], "error": None}
    try:
        # the first table says whether the file can be read at all
        parts = (_named(*part, name_of(path), shown) for part in _parts(job, path))
        first = next(parts)
        job.store.put(names.slices(number), lambda handle: _write(job, number, [first], parts, said, handle))
    except Stopped:
        raise
    except InputError as error:
        said |= {"rows": 0, "parts": [], "error": str(error).replace(name_of(path), shown)}
    job.say(names.mapped(number), said)
    return said


def _parts(job: Job, path: Path) -> Iterator[tuple[Measurements, int]]:
    """Measurements of the file, whole or in pieces, and the number of rows that were read. Errors: InputError."""
    if row_count(path) > job.piece and (read := pieced(path, job.piece)) is not None:
        yield from _pieces(job, Source.of(path, read, job.reading))
        return
    left_out: list[str] = []
    held: tuple[Measurements, int] | None = None
    for _, measured, rows in load_tables(path, job.reading, left_out):
        if held:
            yield held
        held = measured, rows
    if not held:
        raise InputError("\n".join(left_out))
    held[0].notes += [f"left out: {reason}" for reason in left_out]
    yield held


def _named(measured: Measurements, rows: int, path: str, shown: str) -> tuple[Measurements, int]:
    """With the name of the file as it was given."""
    for name in ("file", "source"):
        if name == "file" or "source" not in measured.named:
            text = measured.rows[name].first()
            new = None if text is None else shown + str(text).removeprefix(path)
            measured.rows = measured.rows.with_columns(pl.lit(new, pl.String).alias(name))
    found = [
        frame.with_columns(file=pl.lit(shown) + pl.col("file").str.strip_prefix(path)) for frame in measured.rejected
    ]
    measured.rejected = found
    measured.notes = [note.replace(path, shown) for note in measured.notes]
    return measured, rows


def _pieces(job: Job, source: Source) -> Iterator[tuple[Measurements, int]]:
    """A file that is too large to be measured at once; its pieces must be read alike."""
    if source.pieced.table.format == "csv":
        source.count()
    first: Measurements | None = None
    for frame, bad in source.pieced.read(source.wanted):
        part = source.opened.measured(source.typed(frame), some=True)
        # all pieces have the columns that some have where a row says so
        missing = [name for name in SOMETIMES if name in source.opened.columns.roles and name not in part.rows.columns]
        part.rows = part.rows.with_columns(pl.lit(False).alias(name) for name in missing)
        part.rejected.append(bad.with_columns(file=pl.lit(source.opened.file)))
        first = first or replace(part, rows=part.rows.clear(), rejected=[])
        check_alike(first, part, (same_kind(first.notes), same_kind(part.notes)))
        yield part, frame.height + bad.height


def _write(job: Job, number: int, begun: list[Any], rest: Iterator[Any], said: dict[str, Any], handle: Any) -> None:
    """The slices of all parts into an open file; what they are into `said`."""
    import pyarrow as pa

    options = pa.ipc.IpcWriteOptions(compression="lz4")
    counts, rejected, writer, batch, schema = [], [], None, 0, None
    while begun or (begun := [part] if (part := next(rest, None)) else []):
        measured, rows = begun.pop()
        counts.append(measured.rows.group_by("target").len("rows"))
        rejected.append(together(measured.rejected))
        part, frame = _stripped(measured)
        said["rows"] += rows
        measured.rows = measured.rows.clear()
        bucket = bucket_of(frame["target"], job.buckets).to_numpy()
        buckets, sizes = np.unique(bucket, return_counts=True)
        frame = taken(frame, np.argsort(short(bucket), kind="stable"))
        table = frame.to_arrow(compat_level=pl.CompatLevel.oldest())
        if writer is None or schema is None:
            schema = table.schema
            writer = pa.ipc.new_file(handle, schema, options=options)
        elif set(table.column_names) == set(schema.names):
            table = table.select(schema.names)
        if table.schema != schema:
            raise InputError(f"{said['file']}: its parts have different columns: {_both(schema, table.schema)}")
        part["slices"], part["rows"], start = {}, {}, 0
        for bucket, size in zip(buckets.tolist(), sizes.tolist(), strict=True):
            slice = table.slice(start, size).combine_chunks()
            writer.write_batch(slice.to_batches()[0])
            part["slices"][str(bucket)], part["rows"][str(bucket)] = batch, size
            batch, start = batch + 1, start + size
        said["parts"].append(part)
    assert writer is not None
    writer.close()
    named = pl.concat(counts).group_by("target").agg(pl.col("rows").sum()).sort("target")
    job.store.put(names.targets(number), named.write_ipc)
    lost = pl.concat(rejected)
    if lost.height:
        job.store.put(names.unread(number), lost.write_ipc)


def _stripped(measured: Measurements) -> tuple[dict[str, Any], pl.DataFrame]:
    """What holds for all rows of a part, and the rows without it."""
    frame = measured.rows
    # without a column of sensors, the source is the file too
    same = {
        name: frame[name].first() for name in ("file", "source") if name == "file" or "source" not in measured.named
    }
    part = {
        "file": same["file"],
        "same": same,
        "position": measured.position,
        "absolute": measured.absolute,
        "named": measured.named,
        "notes": measured.notes,
        "unused": measured.unused,
        "rate_notes": measured.rate_notes,
        "head": packed(frame.clear()),
    }
    return part, frame.drop(same)


def packed(frame: pl.DataFrame) -> str:
    """An empty table as text."""
    buffer = io.BytesIO()
    frame.write_ipc(buffer)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def unpacked(text: str) -> pl.DataFrame:
    """As `packed` wrote it."""
    return pl.read_ipc(io.BytesIO(base64.b64decode(text)))


def _both(one: Any, other: Any) -> str:
    return " and ".join(", ".join(f"{field.name} {field.type}" for field in schema) for schema in (one, other))
