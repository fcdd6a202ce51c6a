"""Tracks of tables that are larger than memory: share by share, each with the pace, noise and filter of a sample.

The same targets tell the same of a table that is tracked in memory (`prepare.EVIDENCE`), so the tracks are the same.
"""

from __future__ import annotations

import re
import time as clock
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import polars as pl

from ..io.errors import InputError
from ..io.files import expand, name_of
from ..io.loading import Reading
from ..io.measurements import Measurements
from ..io.pieces import pieced, row_count, same_kind
from ..io.rejected import SCHEMA
from ..io.spill import SAMPLE, Source, Spill, check_alike
from .batch import implausible, nothing_left, tables_of
from .output import NisCounts
from .plausibility import Seen, as_dicts, findings
from .prepare import EVIDENCE, Group, Known, Prepared, Settings, drawn, prepare
from .stretches import pieces
from .summary import CLEANED, plain, reasons, words_for

PER_ROW = 800  # bytes of memory that a row takes from its reading to its track
FIXED = 450_000_000  # bytes that the packages, a piece of the input and the tables on their way take
PIECE = 500_000  # rows that are read at once
FEWEST = 100_000  # rows of a share: smaller ones save nothing
SLIM = ("target", "part", "time", "status", "speed", "acceleration_x", "acceleration_y", "measured_x", "measured_y")
KNOWN = ("x", "nis")  # columns of which the checks ask whether there is a value
NEEDED = ("file", "row", "target", "part", "time")  # columns of measurements that tables take over

Progress = Callable[[str, int, int], None]


def fits(inputs: Sequence[str | Path], memory: int) -> bool:
    """Whether all files together can be tracked in so many bytes of memory."""
    return FIXED + PER_ROW * sum(map(row_count, expand(inputs))) <= memory


@dataclass
class Large:
    """Files of which only a share is in memory at a time.

    `tables()` gives the tracks, in the order of their targets; then `summary()` says what was done, and `rejected()`
    has the rows that are in no track.
    """

    spill: Spill
    settings: Settings
    memory: int
    progress: Progress
    known: Known | None = None
    sample: Measurements | None = None
    schema: dict[str, Any] = field(default_factory=dict)
    began: float = field(default_factory=clock.perf_counter)
    counts: Counter[str] = field(default_factory=Counter)
    cleaning: Counter[str] = field(default_factory=Counter)
    status: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    notes: dict[str, str] = field(default_factory=dict)
    seen: list[Seen] = field(default_factory=list)
    nis: NisCounts = field(default_factory=NisCounts)
    lost: int = 0
    ends: list[Any] = field(default_factory=list)

    @classmethod
    def of(
        cls,
        inputs: Sequence[str | Path],
        how: Reading,
        settings: Settings,
        memory: int,
        folder: Path,
        progress: Progress,
    ) -> Large | None:
        """Made ready; None where the files cannot be divided: a format that is read whole, or rows without identity."""
        sources = []
        for path in expand(inputs):
            read = pieced(path, PIECE)
            if read is None:
                return None
            sources.append(Source.of(path, read, how))
        if any("target" not in source.opened.columns.roles for source in sources):
            return None
        return cls(Spill(folder, sources), settings, memory, progress)

    @property
    def files(self) -> list[str]:
        """The names of the inputs."""
        return [source.opened.file for source in self.spill.sources]

    def tables(self) -> Iterator[pl.DataFrame]:
        """All tracks, with the same columns in every table. Errors: InputError where none is left or plausible."""
        self.spill.count()
        self.progress("reading", 1, 2)
        sample = drawn(self.spill.counts)
        if sample is None and self.spill.counts["rows"].sum() <= EVIDENCE:
            sample = self.spill.counts.select("target")
        most = max(FEWEST, (self.memory - FIXED) // PER_ROW)
        shares = self.spill.divide(most, sample)
        self._keep_rejected(self.spill.unreadable)
        self.progress("reading", 2, 2)
        if sample is not None:
            self.sample = self.spill.share(SAMPLE)
            prepared = prepare(replace(self.sample), self.settings)
            self.known = Known.of(prepared)
            self._learn_schema(prepared)
        for number, measurements in enumerate(self.spill.shares(shares)):
            yield from self._share(measurements)
            self.progress("smoothing" if self.settings.smoothing is not None else "filtering", number + 1, shares)
        if not self.counts["accepted"]:
            raise InputError(nothing_left(self.spill.rows, self.refused.most_common()))

    def _learn_schema(self, prepared: Prepared) -> None:
        """The columns of all tables, from the first parts of each group."""
        assert self.sample is not None
        for group in prepared.groups:
            first = next(pieces(group.placed.offsets, 1)).rows
            some = replace(
                group,
                placed=group.placed.some(first),
                covariance=None if group.covariance is None else group.covariance[first],
            )
            table = next(tables_of(some, self.settings, self.sample.absolute))
            self.schema |= {name: kind for name, kind in table.schema.items() if name not in self.schema}

    def _share(self, measurements: Measurements) -> Iterator[pl.DataFrame]:
        if self.sample is not None:
            check_alike(self.sample, measurements, (same_kind(self.sample.notes), same_kind(measurements.notes)))
        absolute = measurements.absolute
        self._note(measurements)
        prepared = prepare(measurements, self.settings, self.known)
        self._keep_rejected([*measurements.rejected, *prepared.cleaned.rejected])
        self.cleaning.update({k: v for k, v in prepared.cleaned.counts.items() if k in CLEANED})
        if not prepared.groups:
            return
        if self.known is None:
            self.known = Known.of(prepared)
        prepared.cleaned.rows = prepared.cleaned.rows.clear()
        groups = [replace(g, placed=replace(g.placed, rows=g.placed.rows.select(NEEDED))) for g in prepared.groups]
        prepared.groups.clear()
        slim: list[pl.DataFrame] = []
        for table in self._in_order(groups, absolute):
            table = self._aligned(table)
            known = [pl.col(name).is_not_null().replace(False, None) for name in KNOWN if name in table.columns]
            slim.append(table.select(*(name for name in SLIM if name in table.columns), *known))
            self._count(table)
            yield table
        whole = pl.concat(slim)
        self.seen.append(Seen.of(whole, self.settings.kind))
        self.counts["targets"] += whole["target"].n_unique()
        self.counts["parts"] += sum(int(group.placed.new.sum()) for group in groups)
        self.ends += [whole["time"].min(), whole["time"].max()]
        for group in groups:
            self.counts[f"axes {group.placed.axes}"] += int(group.placed.new.sum())

    def _in_order(self, groups: list[Group], absolute: bool) -> Iterator[pl.DataFrame]:
        """Tables by target and time; parts of two and three axes are put together first."""
        if len(groups) == 1:
            yield from tables_of(groups[0], self.settings, absolute)
            return
        tables = [table for group in groups for table in tables_of(group, self.settings, absolute)]
        yield pl.concat(tables, how="diagonal").sort("target", "time", maintain_order=True)

    def _aligned(self, table: pl.DataFrame) -> pl.DataFrame:
        if not self.schema:
            self.schema = dict(table.schema)
        new = [name for name in table.columns if name not in self.schema]
        if new:
            raise InputError(f"the column {new[0]!r} is in some tracks alone; a larger --memory tracks them together")
        missing = [pl.lit(None, kind).alias(name) for name, kind in self.schema.items() if name not in table.columns]
        return table.with_columns(missing).select(list(self.schema))

    def _count(self, table: pl.DataFrame) -> None:
        self.counts["accepted"] += table.height
        self.status.update(dict(table["status"].cast(pl.String).value_counts().iter_rows()))
        self.nis.add(table)

    def _note(self, measurements: Measurements) -> None:
        """Notes of all shares; where several count the same, their sum."""
        for note in measurements.notes:
            kind = re.sub(r"\d[\d,.]*", "#", note)
            here, before = (re.match(r"(\d+)( .*)", text) for text in (note, self.notes.get(kind, "")))
            self.notes[kind] = f"{int(before[1]) + int(here[1])}{here[2]}" if here and before else note

    def _keep_rejected(self, frames: Sequence[pl.DataFrame]) -> None:
        for frame in frames:
            if not frame.height:
                continue
            complete = frame.select(
                (pl.col(name) if name in frame.columns else pl.lit(None)).cast(kind).alias(name)
                for name, kind in SCHEMA.items()
            )
            complete.write_ipc(self.spill.folder / f"rejected-{self.lost}.arrow")
            self.refused.update(dict(reasons(complete)))
            self.lost += 1

    def rejected(self) -> Iterator[pl.DataFrame]:
        """The rows that are in no track."""
        for number in range(self.lost):
            yield pl.read_ipc(self.spill.folder / f"rejected-{number}.arrow")

    def summary(self) -> dict[str, Any]:
        """What was done and found. Errors: InputError where no track is plausible."""
        known = self.known
        assert known is not None
        consistency = self.nis.shares()
        noise = [line | {"axes": axes} for axes, level in known.levels.items() for line in level.sources]
        found, hopeless = findings(Seen.together(self.seen), noise, self.settings.kind, consistency)
        if hopeless and self.settings.check:
            raise InputError(implausible(found, self.counts["targets"]))
        named = self.spill.sources[0].opened.columns.named()
        notes = list(self.notes.values())
        flat, deep = self.counts["axes 2"], self.counts["axes 3"]
        if flat and self.sample is not None and self.sample.position != "polar":
            notes.append(f"{flat if deep else 'all'} parts have no altitude and are tracked in the plane (2-D)")
        notes.append("the table is larger than --memory: it was divided by target, and the noise is that of a sample")
        return {
            "files": [name_of(source.path) for source in self.spill.sources],
            "rows": self.spill.rows,
            "accepted": self.counts["accepted"],
            "rejected": dict(self.refused.most_common()),
            "targets": self.counts["targets"],
            "parts": self.counts["parts"],
            "start": plain(min(self.ends)),
            "end": plain(max(self.ends)),
            "columns": self.sample.named if self.sample else named,
            "unused_columns": self.sample.unused if self.sample else [],
            "notes": notes,
            "cleaning": dict(self.cleaning),
            "noise": noise,
            "filter": {f"{axes} axes": words_for(filter) for axes, (_, filter) in known.filters.items()},
            "status": dict(self.status.most_common()),
            "consistency": consistency,
            **self.settings.said(),
            "gap_seconds": known.pace.gap,
            "seconds": clock.perf_counter() - self.began,
            "warnings": as_dicts(found, self.counts["targets"]),
        }
