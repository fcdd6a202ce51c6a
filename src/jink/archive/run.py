"""Files to a folder of tracks: divide every file by target, settle what holds for all, track every bucket."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl

from ..frozen import frozen
from ..io.errors import InputError
from ..io.files import expand, name_of
from ..io.loading import Reading
from ..io.pieces import row_count
from ..io.rejected import SCHEMA
from ..tracking.batch import implausible, nothing_left
from ..tracking.large import FIXED, PER_ROW
from ..tracking.prepare import Settings
from ..tracking.tally import Tally
from . import job as names
from .access import locked, made, room
from .errors import Stopped
from .folder import MANIFEST
from .gathering import check_same, places
from .job import Job, versions
from .manifest import Plan, agreed_inputs, fingerprint, finish, in_words, manifest_of
from .mapping import map_file
from .progress import Progress, Say
from .reducing import grounds_of, reduce_bucket
from .settling import Settled, settle
from .store import WORK, Store
from .workers import Cluster, Here, Processes, Workers

SHARE = 500_000  # rows of a bucket, about: more need more memory, fewer more files
FEWEST, MOST = 8, 4096  # buckets
LEAST_PIECE = 100_000  # rows
SPARE_REJECTED = f"{WORK}/rejected.parquet"  # of a folder, until they are whole


@frozen
class How:
    """memory: bytes of all processes together; processes: how many; strict: an input that cannot be read stops the
    run; append: add inputs to a folder; cluster: the address of a scheduler of dask, or a client.
    """

    memory: int
    processes: int | None = None
    strict: bool = False
    append: bool = False
    cluster: Any = None

    @property
    def count(self) -> int:
        """The number of processes."""
        if self.processes:
            return self.processes
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

    def workers(self) -> Workers:
        """Who does the work."""
        if isinstance(self.cluster, str):
            return Cluster.at(self.cluster)
        if self.cluster is not None:
            return Cluster(self.cluster)
        return Here() if self.count == 1 else Processes(self.count)


def track_archive(
    inputs: Sequence[str | Path], where: str, reading: Reading, settings: Settings, how: How, say: Say
) -> tuple[dict[str, Any], list[str]]:
    """The summary, and what was written. A run that was stopped goes on; a complete one says again what it said.
    Errors: InputError.
    """
    began = clock.perf_counter()
    store = Store(where)
    made(store)
    with locked(store), room(store):
        plan, complete = _planned(store, inputs, reading, settings, how)
        if complete is not None:
            return complete["summary"], complete["written"]
        files = tuple((each["path"], each["file"]) for each in plan.inputs)
        job = Job(files, reading, replace(settings, threads=1), plan.buckets, plan.piece, store, versions())
        with closing(how.workers()) as workers:
            said = _map(job, workers, how, say)
            say({"event": "settle"})
            settled = settle(job, said, plan.first)
            done = _reduce(job, settled, said, workers, say)
        summary = _summary(job, settled, said, done)
        rejected = _write_rejected(job, said, done)
        summary |= {"buckets": plan.buckets, "settled": settled.words, "seconds": clock.perf_counter() - began}
        written = [where, *rejected]
        finish(store, _manifest(plan, said, done, summary) | {"written": written})
        store.sweep()
    return summary, written


def _planned(
    store: Store, inputs: Sequence[str | Path], reading: Reading, settings: Settings, how: How
) -> tuple[Plan, dict[str, Any] | None]:
    """The plan, and the manifest where nothing is left to do. Errors: InputError."""
    store.sweep()
    before = Plan.read(store)
    paths = _inputs(inputs, store)
    words = in_words(reading, settings)
    given = [fingerprint(path, name_of(path)) for path in paths]
    if before is None:
        if how.append:
            raise Stopped(f"--append: {store.where} holds no archive")
        plan = _new_plan(paths, given, words, how)
        plan.write(store)
        return plan, None
    before.check_alike(Plan(words, [], 0, 0, 0), store.where)
    agreed = agreed_inputs(before, given, how.append, store.where)
    plan = replace(before, inputs=agreed)
    if len(agreed) == len(before.inputs):
        return plan, manifest_of(store)
    # from here on the folder is not complete
    store.remove(MANIFEST)
    plan.write(store)
    return plan, None


def _inputs(inputs: Sequence[str | Path], store: Store) -> list[Path]:
    """All input files but those of the archive itself."""
    paths = expand(inputs)
    if store.local:
        own = store.path("").absolute()
        paths = [path for path in paths if own not in path.absolute().parents]
    if not paths:
        raise InputError("no input file was given")
    return paths


def _new_plan(paths: Sequence[Path], given: list[dict[str, Any]], words: dict[str, str], how: How) -> Plan:
    """Buckets and pieces so large that each process keeps to its part of the memory."""
    rows = sum(map(row_count, paths))
    most = max(LEAST_PIECE, (how.memory // how.count - FIXED) // PER_ROW)
    buckets = max(FEWEST, -(-rows // min(SHARE, most)))
    if buckets > MOST:
        raise Stopped(
            f"{rows:,} rows need {buckets:,} buckets of {min(SHARE, most):,} rows, of {MOST:,} at most; "
            "give more --memory, or make several archives"
        )
    return Plan(words, given, buckets, most, len(given))


def _map(job: Job, workers: Workers, how: How, say: Say) -> list[dict[str, Any]]:
    """What every file says, in their order. Errors: InputError."""
    said: dict[int, dict[str, Any]] = {}
    known = [job.said(names.mapped(number)) for number in range(len(job.files))]
    progress = Progress(say, "map", len(job.files), sum(row_count(Path(path)) for path, _ in job.files))
    left = []
    for number, each in enumerate(known):
        if each is None:
            left.append(number)
        else:
            said[number] = each
            progress.step(each["rows"], kept=True)
    _check_files(said.values(), how.strict)
    for each in workers.run((map_file, (job, number)) for number in left):
        said[each["number"]] = each
        progress.step(each["rows"])
        if each["error"]:
            say({"event": "file_skipped", "file": each["file"], "why": each["error"]})
        _check_files([*[first for first in said.values() if first["parts"]][:1], each], how.strict)
    return [said[number] for number in range(len(job.files))]


def _check_files(said: Any, strict: bool) -> None:
    """Errors: InputError where a file cannot be read and nothing may be skipped, or files do not go together."""
    parts: list[dict[str, Any]] = []
    for each in said:
        if strict and each["error"]:
            raise InputError(each["error"])
        parts += each["parts"]
    for part in parts[1:]:
        check_same(parts[0], part)


def _reduce(job: Job, settled: Settled, said: list[dict[str, Any]], workers: Workers, say: Say) -> list[dict[str, Any]]:
    """What every bucket says. Those that an earlier run tracked, and that got no new rows, are kept."""
    rows = sum(each["rows"] for each in said)
    progress = Progress(say, "reduce", job.buckets, rows)
    done: dict[int, dict[str, Any]] = {}
    left = []
    for bucket in range(job.buckets):
        before = job.said(names.reduced(bucket))
        same = before is not None and before["grounds"] == grounds_of(settled)
        if before and same and all(place.number < before["files"] for place in places(said, bucket)):
            done[bucket] = before
            progress.step(before["rows"], kept=True)
        else:
            left.append(bucket)
    tasks = ((reduce_bucket, (job, settled, bucket, places(said, bucket), len(said))) for bucket in left)
    for each in workers.run(tasks):
        done[each["bucket"]] = each
        progress.step(each["rows"])
    return [done[bucket] for bucket in range(job.buckets)]


def _summary(job: Job, settled: Settled, said: list[dict[str, Any]], done: list[dict[str, Any]]) -> dict[str, Any]:
    """What was done and found. Errors: InputError where no track is left or plausible."""
    tally = Tally()
    for each in done:
        tally.merge(Tally.of_json(each["tally"]))
    tally.rows = sum(each["rows"] for each in said)
    for frame in _rejected_of_files(job, said):
        tally.refuse(frame)
    if not tally.counts["accepted"]:
        raise InputError(nothing_left(tally.rows, tally.refused.most_common()))
    kind = settled.kind
    summary, hopeless = tally.summary(
        [each["file"] for each in said if not each["error"]],
        kind.measurements(pl.DataFrame(schema=kind.columns)),
        settled.known,
        job.settings,
    )
    if hopeless:
        raise InputError(implausible(hopeless, tally.counts["targets"]))
    words = settled.words
    summary["notes"] = [
        *kind.notes,
        *summary["notes"],
        f"usual step, noise and filter are those of {words['targets']:,} of {words['of_targets']:,} targets",
        *(f"left out: {each['error'].splitlines()[0]}" for each in said if each["error"]),
    ]
    return summary


def _rejected_of_files(job: Job, said: list[dict[str, Any]]) -> Iterator[pl.DataFrame]:
    """Rows, and whole files, that could not be read."""
    for number, each in enumerate(said):
        if each["error"]:
            row = {"file": each["file"], "reason": "the file cannot be read", "value": each["error"]}
            yield pl.DataFrame([row | {"row": None, "target": None}], schema=SCHEMA)
        elif (content := job.store.get(names.unread(number))) is not None:
            yield pl.read_ipc(content)


def _write_rejected(job: Job, said: list[dict[str, Any]], done: list[dict[str, Any]]) -> list[str]:
    """All rows that are in no track, beside the folder; the name of the file, where there are any."""
    import pyarrow.parquet as pq

    schema = pl.DataFrame(schema=SCHEMA).to_arrow(compat_level=pl.CompatLevel.oldest()).schema
    count = 0

    def frames() -> Iterator[pl.DataFrame]:
        yield from _rejected_of_files(job, said)
        for each in done:
            if each["rejected"] and (content := job.store.get(names.left_out(each["bucket"]))) is not None:
                yield pl.read_ipc(content)

    def write(handle: Any) -> None:
        nonlocal count
        with pq.ParquetWriter(handle, schema) as writer:
            for frame in frames():
                count += frame.height
                writer.write_table(frame.to_arrow(compat_level=pl.CompatLevel.oldest()).cast(schema))

    beside, name = job.store.beside()
    target = f"{name}.rejected.parquet"
    if beside.local:
        job.store.put(SPARE_REJECTED, write)
        os.replace(job.store.path(SPARE_REJECTED), beside.path(target))
    else:
        beside.put(target, write)
    if count:
        return [job.store.named(".rejected.parquet")]
    beside.remove(target)
    return []


def _manifest(plan: Plan, said: list[dict[str, Any]], done: list[dict[str, Any]], summary: Any) -> dict[str, Any]:
    return {
        "format": plan.format,
        "versions": plan.versions,
        "settings": plan.settings,
        "inputs": [
            each | {"rows": of["rows"], "error": of["error"]} for each, of in zip(plan.inputs, said, strict=True)
        ],
        "buckets": [{name: each[name] for name in ("bucket", "rows", "accepted", "bytes")} for each in done],
        "settled": summary["settled"],
        "summary": summary,
    }
