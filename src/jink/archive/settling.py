"""What holds for all buckets, decided once: usual step, noise, filter and columns, from a sample of whole targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import polars as pl

from ..frozen import frozen
from ..io.errors import InputError
from ..io.values import taken
from ..tracking.batch import nothing_left
from ..tracking.prepare import EVIDENCE, Known, drawn, prepare
from ..tracking.shares import learned_schema
from ..tracking.summary import words_for
from . import job as names
from .errors import Stopped
from .gathering import Kind, gather, kind_of, places
from .hashing import bucket_of
from .job import Job


@frozen
class Settled:
    """What reducers are told: the kind of the rows, what the sample shows, the columns of the tracks, and in words."""

    kind: Kind
    known: Known
    schema: dict[str, Any]
    words: dict[str, Any]


def settle(job: Job, said: Sequence[dict[str, Any]], first: int) -> Settled:
    """Decide it; first: the number of files that may decide, those of the first run. Errors: InputError."""
    deciding = said[:first]
    if not any(each["parts"] for each in deciding):
        reasons = "\n".join(f"  {each['error']}" for each in said if each["error"])
        raise InputError(f"no input file can be read:\n{reasons}")
    kind = kind_of(said)
    _check_kept(job, kind)
    counts = _counts(job, deciding)
    if not counts.height:
        raise InputError(nothing_left(sum(each["rows"] for each in deciding), ()))
    chosen = drawn(counts) if int(counts["rows"].sum()) > EVIDENCE else None
    sample = kind.measurements(_sample(job, kind, counts if chosen is None else chosen, deciding))
    rows = sample.rows.height
    prepared = prepare(sample, replace(job.settings, threads=None))
    known = Known.of(prepared, some=chosen is not None or len(deciding) < len(said))
    schema = learned_schema(prepared, job.settings, kind.absolute)
    words = {
        "targets": counts.height if chosen is None else chosen.height,
        "of_targets": counts.height,
        "rows": rows,
        "of_rows": int(counts["rows"].sum()),
        "usual_step_seconds": known.pace.step,
        "gap_seconds": known.pace.gap,
        "noise": [line | {"axes": axes} for axes, level in known.levels.items() for line in level.sources],
        "filter": {f"{axes} axes": words_for(filter) for axes, (_, filter) in known.filters.items()},
    }
    return Settled(kind, known, schema, words)


def _counts(job: Job, said: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """Every target and its number of rows."""
    found = pl.DataFrame(schema={"target": pl.String, "rows": pl.UInt32})
    for number, each in enumerate(said):
        if each["parts"]:
            content = job.store.get(names.targets(number))
            assert content is not None
            found = pl.concat([found, pl.read_ipc(content)]).group_by("target").agg(pl.col("rows").sum())
    return found.sort("target")


def _sample(job: Job, kind: Kind, chosen: pl.DataFrame, said: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """The rows of the chosen targets, in the order of the files, as a table in memory would have them."""
    wanted = bucket_of(chosen["target"], job.buckets).unique().sort().to_list()
    found = []
    for bucket in wanted:
        rows = gather(job.store, kind, places(said, bucket))
        found.append(rows.join(chosen.select("target"), on="target", how="semi", maintain_order="left"))
    whole = pl.concat(found)
    found.clear()
    files = list(dict.fromkeys(p["file"] for each in said for p in each["parts"]))
    place = pl.col("file").replace_strict(files, range(len(files)), return_dtype=pl.UInt32)
    return taken(whole, whole.select(pl.arg_sort_by(place, "row")).to_series().to_numpy())


def _check_kept(job: Job, kind: Kind) -> None:
    from ..io.kept import MARK

    for name in job.reading.keep or ():
        if MARK + name not in kind.columns:
            raise Stopped(f"keep: there is no column {name!r} in any input")
