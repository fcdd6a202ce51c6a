"""Tracks of some targets of a large table, with the pace, noise and filter that hold for all of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import polars as pl

from ..filters import memory
from ..filters.row_noise import Repeated
from ..frozen import frozen
from ..io.errors import InputError
from ..io.kept import MARK
from ..io.measurements import Measurements
from .batch import tables_of
from .prepare import Group, Known, Prepared, Settings, prepare
from .stretches import pieces
from .summary import CLEANED
from .tally import Tally, complete, slim

BUSY = 500_000  # rows of tracks whose checks need the room of what is kept for the next ones
NEEDED = (
    "file",
    "row",
    "target",
    "part",
    "time",
    "on_ground",
    "lasting",
)  # columns of measurements that tables take over


def learned_schema(prepared: Prepared, settings: Settings, absolute: bool) -> dict[str, Any]:
    """The columns of all tables, from the first parts of each group."""
    schema: dict[str, Any] = {}
    for group in prepared.groups:
        first = next(pieces(group.placed.offsets, 1)).rows
        some = replace(
            group,
            placed=group.placed.some(first),
            covariance=None if group.covariance is None else group.covariance.some(first),
        )
        table = next(tables_of(some, settings, absolute))
        schema |= {name: kind for name, kind in table.schema.items() if name not in schema}
    return schema


@frozen
class Ready:
    """The groups of one share, cleaned, placed and with their filters; absolute: their times are dates."""

    groups: list[Group]
    absolute: bool


@dataclass
class Shares:
    """Tracks of one share after the other; `tally` says what was done.

    known: what holds for all shares (None: as the first one shows it); schema: the columns of all tables (none: those
    of the first one); keep: takes rejected rows; remedy: what the user can do where a share has a column of its own.
    """

    settings: Settings
    keep: Callable[[pl.DataFrame], None]
    remedy: str
    known: Known | None = None
    schema: dict[str, Any] = field(default_factory=dict)
    tally: Tally = field(default_factory=Tally)

    def tables(self, measurements: Measurements) -> Iterator[pl.DataFrame]:
        """The tracks of a share, with the same columns in every table. Errors: InputError."""
        yield from self.tracks(self.ready(measurements))

    def ready(self, measurements: Measurements) -> Ready:
        """A share before its tracks: its rows are taken. Errors: InputError."""
        self.tally.note(measurements.notes)
        prepared = prepare(measurements, self.settings, self.known)
        self.reject([*measurements.rejected, *prepared.cleaned.rejected])
        self.tally.cleaning.update({k: v for k, v in prepared.cleaned.counts.items() if k in CLEANED})
        if self.known is None and prepared.groups:
            self.known = Known.of(prepared, some=True)
        prepared.cleaned.rows = prepared.cleaned.rows.clear()
        groups = [_lean(group) for group in prepared.groups]
        measurements.rows = measurements.rows.clear()
        return Ready(groups, measurements.absolute)

    def tracks(self, share: Ready) -> Iterator[pl.DataFrame]:
        """The tracks of a share that is ready; its rows are let go."""
        groups = share.groups
        if not groups or self.known is None:
            return
        parts = [(group.placed.axes, int(group.placed.new.sum())) for group in groups]
        checked: list[pl.DataFrame] = []
        for table in self._in_order(groups, share.absolute):
            table = self._aligned(table)
            checked.append(slim(table))
            self.tally.add(table)
            yield table
        groups.clear()  # the checks take as much memory again
        if sum(table.height for table in checked) > BUSY:
            memory.give_back()
        self.tally.close(checked, parts, self.settings.kind, self.known)

    def reject(self, frames: Sequence[pl.DataFrame]) -> None:
        """Keep rows that are in no track."""
        for frame in frames:
            if frame.height:
                whole = complete(frame)
                self.keep(whole)
                self.tally.refuse(whole)

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
            raise InputError(f"the column {new[0]!r} is in some tracks alone; {self.remedy}")
        missing = [pl.lit(None, kind).alias(name) for name, kind in self.schema.items() if name not in table.columns]
        return table.with_columns(missing).select(list(self.schema))


def _lean(group: Group) -> Group:
    """Without what tables do not take over."""
    placed = replace(group.placed, rows=_needed(group.placed.rows))
    level = replace(group.level, covariance=group.level.covariance.some(slice(1)))
    repeated = Repeated.of(group.covariance)
    covariance = None if repeated else group.covariance
    return replace(group, placed=placed, level=level, covariance=covariance, repeated=repeated)


def _needed(rows: pl.DataFrame) -> pl.DataFrame:
    return rows.select(name for name in rows.columns if name in NEEDED or name.startswith(MARK))
