"""A bucket to tracks: the same steps as for a table in memory, into one Parquet file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import IO, Any

import numpy as np
import polars as pl

from ..filters import memory
from ..io.values import codes_of, short, taken
from ..tracking.shares import Shares
from . import job as names
from .gathering import Place, gather, packed
from .gathering import shares as shares_of
from .job import Job
from .settling import Settled

PART = 150_000  # rows that are tracked at once, of whole targets: what they take stays near the processor
KEPT = 1 << 27  # bytes of results that wait for the next ones: those of one piece of rows
REMEDY = "state it in the input (a column of altitudes for all), or track these files apart"


def reduce_bucket(job: Job, settled: Settled, bucket: int, where: Sequence[Place], files: int) -> dict[str, Any]:
    """Track one bucket; what `names.reduced` says of it. where: its rows; files: of how many. Errors: InputError."""
    job.check()
    lost: list[pl.DataFrame] = []
    shares = Shares(job.settings, lost.append, REMEDY, settled.known, dict(settled.schema))
    size = 0
    with memory.at_most(KEPT):
        tables = _tables(job, settled, where, shares)
        first = next(tables, None)
        if first is not None:
            size = job.store.put(names.tracks(bucket), lambda handle: _write(first, tables, handle))
    if not size:
        job.store.remove(names.tracks(bucket))
    if lost:
        job.store.put(names.left_out(bucket), pl.concat(lost).write_ipc)
    done = {
        "bucket": bucket,
        "files": files,
        "grounds": grounds_of(settled),
        "rows": shares.tally.rows,
        "accepted": shares.tally.counts["accepted"],
        "bytes": size,
        "rejected": bool(lost),
        "tally": shares.tally.as_json(),
    }
    job.say(names.reduced(bucket), done)
    return done


def _tables(job: Job, settled: Settled, where: Sequence[Place], shares: Shares) -> Iterator[pl.DataFrame]:
    """The tracks of a bucket by target; of a large one, only some targets are in memory at a time."""
    for between in shares_of(job.store, where, job.piece):
        if between is not None:
            # a large bucket needs the room of what was kept of those before
            memory.give_back()
        for some in whole_targets(gather(job.store, settled.kind, where, between), PART):
            shares.tally.rows += some.height
            if some.height > PART:
                # a busy target needs larger pieces than those that were kept
                memory.give_back()
            measured = settled.kind.measurements(some)
            # a part of one busy target is let go as soon as it is cleaned
            del some
            yield from shares.tables(measured)


def whole_targets(rows: pl.DataFrame, most: int) -> Iterator[pl.DataFrame]:
    """Parts of at most so many rows, or of one target, by the targets' names; rows of a target keep their order. The
    table is taken, and may end up empty.
    """
    codes = codes_of(rows["target"])
    if (codes[1:] < codes[:-1]).any():
        rows = taken(rows, np.argsort(short(codes), kind="stable"))
    sizes = np.bincount(codes)
    sizes = sizes[sizes > 0]
    starts = np.r_[0, np.cumsum(sizes)]
    for first, end in packed(sizes, most):
        size = starts[end] - starts[first]
        # who takes a part holds it alone, so that its memory ends with it; an empty slice would hold it too
        held = [rows.head(size)]
        rows = rows.slice(size) if end < sizes.size else rows.clear()
        yield held.pop()


def grounds_of(settled: Settled) -> str:
    """The grounds below which no height runs, which files that are added may lower."""
    return repr(sorted(settled.known.grounds.items()))


def _write(first: pl.DataFrame, rest: Iterator[pl.DataFrame], handle: IO[bytes]) -> None:
    """Parquet with a group of rows per table, so that the bytes depend on the rows alone."""
    import pyarrow.parquet as pq

    table = first.to_arrow(compat_level=pl.CompatLevel.oldest())
    with pq.ParquetWriter(handle, table.schema, **parquet_options(table.schema)) as writer:
        writer.write_table(table)
        for frame in rest:
            writer.write_table(frame.to_arrow(compat_level=pl.CompatLevel.oldest()))


def parquet_options(schema: Any) -> dict[str, Any]:
    """How columns are packed: a dictionary of real numbers costs most of the writing, their compression most of the
    rest, and both save nothing.
    """
    import pyarrow as pa

    texts = [each.name for each in schema if pa.types.is_dictionary(each.type) or "string" in str(each.type)]
    packing = {each.name: "none" if pa.types.is_floating(each.type) else "snappy" for each in schema}
    return {"compression": packing, "use_dictionary": texts, "write_statistics": ["target", "time"]}
