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


# of a row: time (s), the components of the velocity by direction, and the variance of one component of each direction
Velocity = list[float]


@dataclass(slots=True)
class Past:
    """The last rows of one target: velocities within the window, and the segment."""

    velocities: deque[Velocity] = field(default_factory=deque)
    segments: Segments | None = None

    def first(self, now: Velocity, new: bool, window: float) -> Velocity:
        """The velocity that the window begins at, `now` being one more."""
        known = self.velocities
        if new:
            known.clear()
        known.append(now)
        earliest = now[0] - window - SLACK
        while len(known) > 2 and known[0][0] < earliest:
            known.popleft()
        return known[0]


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
    values = np.column_stack([time, *(part.T for part in moving.velocity), *moving.variance]).tolist()
    begins, window = moving.new.tolist(), what.window
    first = [row.target.past.first(now, new, window) for row, now, new in zip(rows, values, begins, strict=True)]
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
    values, at = np.array(first).T, 1
    velocity = []
    for part in like.velocity:
        velocity.append(values[at : at + len(part)])
        at += len(part)
    known = like.acceleration, like.spread
    return Moving(values[0], like.new, like.mode, tuple(velocity), tuple(values[at:]), *known)
