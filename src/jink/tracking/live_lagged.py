"""Estimates with a lag beside the current ones: where a target was some rows ago, by all that came since."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import polars as pl

from ..estimate import Estimate
from ..frozen import frozen
from ..io.errors import InputError
from ..io.geodesy import DevelopedFrame, SiteFrame
from .lag import Lag
from .live_manoeuvres import Past, columns, told_live
from .manoeuvring import Manoeuvres
from .output import tracks_table
from .placing import Placed
from .unseen_heights import with_unseen

PREFIX = "lagged_"
LEFT_OUT = ("target", "part", "file", "status", "altitude_status")  # said by the current row, or by that of long ago
NOT_AGAIN = ("measured_", "nis", "probability_")
OUTPUTS = ("x", "P", "mode_probability")


class Behind(NamedTuple):
    """A row that has been: since its part began (s), its time, number and place of its frame, what became of it, and
    how far off measured heights before and after it are (s).
    """

    since: float
    time: float
    row: int
    anchor: tuple[float, ...] | None
    status: int
    unseen: tuple[float, float] = (0.0, math.inf)


@dataclass(slots=True)
class Delayed:
    """The last rows of one target, the first of them so many scans ago as the lag, and what was said of them."""

    rows: deque[Behind] = field(default_factory=deque)
    past: Past = field(default_factory=Past)

    def after(self, now: Behind, scans: int) -> Behind | None:
        """The row of so many scans ago; None where the part has fewer."""
        self.rows.append(now)
        if len(self.rows) > scans + 1:
            self.rows.popleft()
        if len(self.rows) <= scans:
            return None
        then = self.rows[0]
        again = next((row.time for row in self.rows if not row.unseen[0]), math.inf)
        return then if not then.unseen[0] else then._replace(unseen=(then.unseen[0], again - then.time))


@frozen
class Later:
    """A row on which a lagged estimate is said, as `told_live` takes it."""

    target: Delayed
    time: float
    silent: bool = False


class Laggards:
    """Filters with a lag, one for each slot of a pool."""

    def __init__(self, filter: Any, scans: int) -> None:
        if getattr(filter, "not_smoothed", ""):
            raise InputError(f"lag: {type(filter).__name__} cannot be smoothed: {filter.not_smoothed}")
        self.filter, self.scans = filter, scans
        self.each: dict[int, Any] = {}

    def update(self, slots: Sequence[int], t: Sequence[float], z: Sequence[Sequence[float]]) -> dict[str, np.ndarray]:
        """x, P and mode_probability of the scan so long ago, one for each row."""
        found = []
        for slot, time, row in zip(slots, t, z, strict=True):
            if slot not in self.each:
                self.each[slot] = self.filter.start(1, lag=self.scans)
            found.append(self.each[slot].update(time, np.array([row])))
        return {name: np.concatenate([each.results[name] for each in found]) for name in OUTPUTS}

    def release(self, slot: int) -> None:
        """The slot's target has gone."""
        self.each.pop(slot, None)


def scans_of(lag: Lag | None) -> int:
    """Scans of a live lag, 0 for none. Errors: InputError for one in seconds."""
    if lag is None:
        return 0
    if lag.scans is None:
        raise InputError(f"lag is {lag}; a stream takes a number of scans, such as 2")
    return lag.scans


def lagged_table(
    estimate: Estimate,
    rows: Sequence[Behind | None],
    targets: Sequence[Delayed],
    *,
    axes: int,
    site: SiteFrame | None,
    absolute: bool,
    manoeuvres: Manoeuvres,
    climbs: tuple[float, float],
    ground: float,
) -> pl.DataFrame | None:
    """Columns `lagged_…` beside the current rows, null where a part is shorter than the lag; None where all are."""
    there = [k for k, row in enumerate(rows) if row is not None]
    known = [row for row in rows if row is not None]
    if not there:
        return None
    status = np.array([row.status for row in known], dtype=np.uint8)
    nothing = {"nis": np.full(len(known), np.nan), "nis_dof": np.zeros(len(known)), "status": status}
    some = replace(estimate, results={name: estimate.results[name][there] for name in OUTPUTS} | nothing)
    later = [Later(targets[k], row.since) for k, row in zip(there, known, strict=True)]
    told = columns(told_live(later, some, manoeuvres))
    placed = with_unseen(_placed(known, axes, site), [row.unseen for row in known], climbs)
    table = tracks_table(placed, some, absolute, told, ground)
    dropped = [name for name in table.columns if name in LEFT_OUT or name.startswith(NOT_AGAIN)]
    named = table.drop(dropped).rename(lambda name: PREFIX + name)
    every = pl.DataFrame({"k": pl.Series(range(len(rows)), dtype=pl.Int64)})
    return every.join(named.with_columns(k=pl.Series(there, dtype=pl.Int64)), on="k", how="left").drop("k")


def _placed(rows: Sequence[Behind], axes: int, site: SiteFrame | None) -> Placed:
    """The rows in the frames that their targets had got to."""
    count = len(rows)
    nothing = np.full((count, axes), np.nan)
    table = pl.DataFrame(
        {
            "target": [""] * count,
            "part": [0] * count,
            "time": [row.time for row in rows],
            "file": [""] * count,
            "row": pl.Series([row.row for row in rows], dtype=pl.UInt32),
        }
    )
    anchors = [row.anchor for row in rows if row.anchor is not None]
    names, frame = ("x", "y", "z")[:axes], site
    if len(anchors) == count:
        places = np.array(anchors)
        names, frame = ("x", "y", "altitude")[:axes], DevelopedFrame(places[:, 0], places[:, 1], *places.T)
    first, none = np.arange(count) == 0, np.full(count, np.nan)
    return Placed(table, np.zeros(count), nothing, nothing[:, :2], none, first, axes, names, frame)
