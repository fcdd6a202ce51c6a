"""The targets of a stream: their filters' slots, the places their frames have got to, and their last rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import polars as pl

from ..estimate import Estimate
from ..frozen import frozen
from ..io.geodesy import legs
from .live_lagged import Behind, Delayed, Laggards
from .live_manoeuvres import Past, ToldLive, told_live
from .live_order import Order
from .live_watch import Watch
from .manoeuvring import Manoeuvres

OUTPUTS = ("x", "P", "mode_probability", "nis", "nis_dof", "status")
Anchor = tuple[float, float, float, float, float]  # x, y, latitude, longitude, convergence


class Pool:
    """Live filters of all targets that one filter follows; each has a slot."""

    def __init__(self, filter: Any, manoeuvres: Manoeuvres, axes: int, apart: bool = False, lag: int = 0) -> None:
        self.filter, self.manoeuvres, self.axes = filter, manoeuvres, axes
        self.laggards = Laggards(filter, lag) if lag else None
        try:
            self.slots = None if apart else filter.slots()
        except (AttributeError, TypeError):  # along each axis by itself, or models of the user's own
            self.slots = None
        self.singles: dict[int, Any] = {}
        self.next = 0
        self.velocity = [filter.components.index(name) for name in ("vx", "vy")]

    def take(self) -> int:
        """A slot for a new target."""
        if self.slots is not None:
            return self.slots.take()
        self.next += 1
        self.singles[self.next] = self.filter.start(1)
        return self.next

    def release(self, slot: int) -> None:
        """The slot's target has gone."""
        if self.laggards is not None:
            self.laggards.release(slot)
        if self.slots is not None:
            self.slots.release(slot)
        else:
            del self.singles[slot]

    def update(self, slots: list[int], t: list[float], z: list[list[float]]) -> Estimate:
        """One estimate per row; the rows of one slot stand in the order of time."""
        if self.slots is not None:
            return self.slots.update(slots, t, z)
        rows = [self.singles[slot].update(time, np.array([each])) for slot, time, each in zip(slots, t, z, strict=True)]
        results = {name: np.concatenate([row.results[name] for row in rows]) for name in OUTPUTS}
        return replace(rows[0], results=results)


@dataclass(slots=True)
class Followed:
    """One target: where its filter is, the place its frame has got to, and what it was last told.

    positioned, vertical: when its position and its height were last measured. slot: of its pool, None after it was
    not seen for longer than the gap. fresh: whether it was seen since the targets were last looked through; heard:
    the stream's clock then, or when it last was. place: the position last reported, since when (s); left: the one
    before, and for how long it was reported (s).
    """

    pool: Pool
    slot: int | None
    axes: int
    part: int
    began: float
    last: float
    positioned: float
    vertical: float = 0.0
    heard: float = 0.0
    fresh: bool = True
    first: list[float] = field(default_factory=list)
    rows: int = 0
    waiting: int = 0  # rows that the filter has not seen yet
    place: tuple[float, ...] = ()
    since: float = 0.0
    left: tuple[tuple[float, ...], float] = ((), 0.0)
    where: tuple[float, float] | None = None  # latitude and longitude last seen
    anchor: Anchor | None = None
    speed: float = 0.0
    past: Past = field(default_factory=Past)
    delayed: Delayed = field(default_factory=Delayed)
    order: Order = field(default_factory=Order)
    watch: Watch = field(default_factory=Watch)
    parts: int = 1


@dataclass(slots=True)
class Entry:
    """One row on its way to its filter.

    before, here: the target's last place and the row's (latitude, longitude; None: not known). silent: the row is told
    to the filter again, and nothing is said of it. table: the rows it is one of, where these are not the last ones.
    unseen: seconds since a height was measured.
    """

    target: Followed
    name: str
    pool: Pool
    slot: int
    time: float
    z: list[float]
    index: int
    row: int
    table: pl.DataFrame | None = None
    before: tuple[float, float] | None = None
    here: tuple[float, float] | None = None
    silent: bool = False
    anchor: Anchor | None = None
    told: ToldLive | None = None
    behind: Behind | None = None
    delayed: Delayed = field(default_factory=Delayed)
    unseen: float = 0.0


@frozen
class Answered:
    """Entries and their estimates, row by row; lagged: those of the scans that their `behind` are."""

    entries: list[Entry]
    estimate: Estimate
    lagged: Estimate | None = None


def answer_entries(entries: list[Entry]) -> list[Answered]:
    """Tell the filters these rows, in their order; targets are changed as the estimates say."""
    _lay(entries)
    pools: dict[int, list[Entry]] = {}
    for entry in entries:
        pools.setdefault(id(entry.pool), []).append(entry)
    out = []
    for mine in pools.values():
        pool = mine[0].pool
        given = [e.slot for e in mine], [e.time for e in mine], [e.z for e in mine]
        estimate = pool.update(*given)
        lagged = None if pool.laggards is None else replace(estimate, results=pool.laggards.update(*given))
        _remember(mine, estimate, pool)
        said = [k for k, entry in enumerate(mine) if not entry.silent]
        if len(said) < len(mine):
            estimate, lagged = _some(estimate, said), None if lagged is None else _some(lagged, said)
        if said:
            out.append(Answered([mine[k] for k in said], estimate, lagged))
    return out


def _some(estimate: Estimate, rows: list[int]) -> Estimate:
    return replace(estimate, results={name: value[rows] for name, value in estimate.results.items()})


def _lay(entries: list[Entry]) -> None:
    """Move the frames of targets on by one leg for each position."""
    moved = [(e.before, e.here) for e in entries if e.before is not None and e.here is not None]
    along = iter(zip(*legs(*zip(*moved, strict=True)), strict=True)) if moved else iter(())
    for entry in entries:
        target = entry.target
        if entry.here is not None and not entry.silent:
            if entry.before is None:
                target.anchor = (0.0, 0.0, *entry.here, 0.0)
            else:
                ahead, turned, length = next(along)
                x, y, _, _, convergence = target.anchor or (0.0, 0.0, *entry.before, 0.0)
                course = ahead - convergence
                target.anchor = (
                    x + length * math.sin(course),
                    y + length * math.cos(course),
                    *entry.here,
                    convergence + turned,
                )
            entry.z[0], entry.z[1] = target.anchor[:2]
        entry.anchor = target.anchor


def _remember(entries: list[Entry], estimate: Estimate, pool: Pool) -> None:
    """What the next row of each target needs of this one."""
    x = estimate.x
    speeds = np.hypot(x[:, pool.velocity[0]], x[:, pool.velocity[1]]).tolist()
    told, status = told_live(entries, estimate, pool.manoeuvres), estimate.status.tolist()
    for k, entry in enumerate(entries):
        target = entry.target
        target.waiting -= 1
        entry.told = told[k]
        if not entry.silent:
            target.speed = speeds[k]
            if pool.laggards is not None:
                now = Behind(
                    entry.time, target.began + entry.time, entry.row, entry.anchor, status[k], (entry.unseen, math.inf)
                )
                entry.delayed, entry.behind = target.delayed, target.delayed.after(now, pool.laggards.scans)
