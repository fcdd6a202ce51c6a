"""Manoeuvres of targets whose rows come one by one: the same as those of whole tracks."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..estimate import Estimate
from .manoeuvring import SLACK, Manoeuvres, Moving, Segments, Told, between


class ToldLive(NamedTuple):
    """What one row says: probabilities of a manoeuvre, horizontal and (with heights) vertical, and its segment."""

    probabilities: tuple[float, ...]
    segment: int | None


class Velocity(NamedTuple):
    """Time (s), and by direction the components of the velocity and their variance."""

    time: float
    components: tuple[tuple[float, ...], ...]
    variance: tuple[float, ...]


@dataclass(slots=True)
class Past:
    """The last rows of one target: velocities within the window, and the segment."""

    velocities: deque[Velocity] = field(default_factory=deque)
    segments: Segments | None = None

    def first(self, now: Velocity, new: bool, window: float) -> Velocity:
        """The velocity that the window begins at, `now` being one more."""
        if new:
            self.velocities.clear()
        self.velocities.append(now)
        while len(self.velocities) > 2 and self.velocities[0].time < now.time - window - SLACK:
            self.velocities.popleft()
        return self.velocities[0]


class Row(Protocol):
    """A row on its way: of which target, when, and whether nothing is said of it."""

    @property
    def target(self) -> Any:
        """With its `past`."""
        ...

    @property
    def time(self) -> float:
        """s"""
        ...

    @property
    def silent(self) -> bool:
        """Is nothing said of it?"""
        ...


def told_live(rows: Sequence[Row], estimate: Estimate, what: Manoeuvres) -> list[ToldLive]:
    """Of each row; the rows of one target stand in the order of time."""
    time = np.array([row.time for row in rows])
    moving = Moving.of(estimate, time, np.array([row.silent for row in rows]))
    components = [list(zip(*each.tolist(), strict=True)) for each in moving.velocity]
    variances = [each.tolist() for each in moving.variance]
    first = []
    for k, row in enumerate(rows):
        now = Velocity(row.time, tuple(c[k] for c in components), tuple(v[k] for v in variances))
        first.append(row.target.past.first(now, bool(moving.new[k]), what.window))
    both = Moving.joined([_moving(first, moving), moving])
    here = np.arange(len(rows))
    found = between(both, what, np.r_[here, here], np.r_[here, here + len(rows)])
    probabilities = list(zip(*[each[len(rows) :].tolist() for each in found], strict=True))
    if not any(estimate.non_manoeuvring):
        return [ToldLive(each, None) for each in probabilities]
    return [ToldLive(p, _segment(row, p[0], what)) for row, p in zip(rows, probabilities, strict=True)]


def columns(told: Sequence[ToldLive]) -> Told:
    """The rows' columns in a table."""
    each = [np.array(values) for values in zip(*[row.probabilities for row in told], strict=True)]
    segment = None if told[0].segment is None else np.array([row.segment for row in told], dtype=np.int32)
    return Told(each[0], each[1] if len(each) > 1 else None, segment)


def _segment(row: Row, probability: float, what: Manoeuvres) -> int:
    past = row.target.past
    segments, new = past.segments, row.silent or past.segments is None
    if new or segments is None:
        segments = past.segments = what.segments()
    return segments.next(probability, row.time, new)


def _moving(first: Sequence[Velocity], like: Moving) -> Moving:
    """Rows of the past; of their accelerations nothing is asked."""
    velocity = tuple(np.array([row.components[k] for row in first]).T for k in range(len(like.velocity)))
    variance = tuple(np.array([row.variance[k] for row in first]) for k in range(len(like.variance)))
    time = np.array([row.time for row in first])
    return Moving(time, like.new, like.mode, velocity, variance, like.acceleration, like.spread)
