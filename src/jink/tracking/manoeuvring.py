"""Whether a target manoeuvres: the probability that its acceleration exceeds a threshold of its kind.

The acceleration is the mean over a window of the kind, told by the velocity's change, whichever mode explains it. Modes
say how sure that is. A straight mode whose noise has density q lets the mean over T vary by q/T; what errors of the
velocity may have made is taken off. In the other modes the mode's own acceleration counts too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .._engine import native
from ..catalogue.targets import kind_of
from ..estimate import Status
from ..frozen import frozen
from ..models.non_manoeuvring import straight_noise

GRAVITY = 9.80665  # m/s²
ON, OFF = 0.6, 0.4  # manoeuvre probability at which a new segment begins and ends
SLACK = 1e-6  # s: of times that are taken for equal


@frozen
class Manoeuvres:
    """What counts as a manoeuvre, and what straight flight is.

    threshold (m/s²): horizontal and vertical; window (s): over which the acceleration is a mean; straight (m²/s³):
    noise density of the filter's straight modes, horizontal and vertical; centred: the window lies around a row, not
    before it, as smoothed estimates allow.
    """

    threshold: tuple[float, float]
    window: float
    straight: tuple[float, float] = (0.0, 0.0)
    centred: bool = False

    @classmethod
    def of(cls, filter: Any, kind: str, g: float | None = None, *, centred: bool = False) -> Manoeuvres:
        """Of a filter and a kind of target; g: a threshold instead of the kind's."""
        known = kind_of(kind)
        level, up = known.manoeuvre_g if g is None else (g, g)
        axes = getattr(filter, "axes", 2) or 2
        motions, straight = getattr(filter, "motions", ()), getattr(filter, "non_manoeuvring", ())
        noise = straight_noise(motions, straight, axes)
        return cls((level * GRAVITY, up * GRAVITY), known.manoeuvre_seconds, noise, centred)

    def segments(self) -> Segments:
        """What numbers stretches: they last half a window at least."""
        return Segments(0.5 * self.window, self.centred)


@frozen
class Moving:
    """What tells manoeuvres, row by row: time (N,) s; new (N,) where nothing before counts; mode (N,) probability of
    the modes that manoeuvre; by direction (horizontal, vertical): velocity (k, N) with variance (N,) of one component,
    acceleration and its variance likewise, None where the state has none.
    """

    time: np.ndarray
    new: np.ndarray
    mode: np.ndarray
    velocity: tuple[np.ndarray, ...]
    variance: tuple[np.ndarray, ...]
    acceleration: tuple[np.ndarray | None, ...]
    spread: tuple[np.ndarray | None, ...]

    @classmethod
    def of(cls, estimate: Any, time: np.ndarray, new: np.ndarray) -> Moving:
        """From an estimate with x, variances, mode_probability and status; a restart is a new beginning."""
        status = np.asarray(estimate.status)
        begins = new | (status == Status.restarted) | (status == Status.initialised)
        x, diagonal = estimate.x.T, [estimate.covariance(name, name) for name in estimate.components]
        names = {name: k for k, name in enumerate(estimate.components)}
        directions = [("x", "y"), ("z",)] if "vz" in names else [("x", "y")]

        def each(letter: str, values: Any) -> list[np.ndarray | None]:
            some = [[names[letter + a] for a in axes if letter + a in names] for axes in directions]
            # side by side in memory, since each is read often
            return [np.stack([values[i] for i in k]) if k else None for k in some]

        velocity = [v for v in each("v", x) if v is not None]
        variance = [v.mean(axis=0) for v in each("v", diagonal) if v is not None]
        spread = [None if v is None else v.mean(axis=0) for v in each("a", diagonal)]
        parts = (tuple(velocity), tuple(variance), tuple(each("a", x)), tuple(spread))
        return cls(np.asarray(time), begins, np.asarray(estimate.manoeuvring), *parts)

    def some(self, rows: slice) -> Moving:
        """Some of the rows."""

        def cut(parts: tuple[Any, ...]) -> tuple[Any, ...]:
            return tuple(None if part is None else part[..., rows] for part in parts)

        moved, known = (cut(self.velocity), cut(self.variance)), (cut(self.acceleration), cut(self.spread))
        return Moving(self.time[rows], self.new[rows], self.mode[rows], *moved, *known)

    @classmethod
    def joined(cls, parts: Sequence[Moving]) -> Moving:
        """Rows that follow each other."""

        def end_to_end(each: list[tuple[Any, ...]]) -> tuple[Any, ...]:
            return tuple(None if some[0] is None else np.concatenate(some, axis=-1) for some in zip(*each, strict=True))

        return cls(
            np.concatenate([p.time for p in parts]),
            np.concatenate([p.new for p in parts]),
            np.concatenate([p.mode for p in parts]),
            end_to_end([p.velocity for p in parts]),
            end_to_end([p.variance for p in parts]),
            end_to_end([p.acceleration for p in parts]),
            end_to_end([p.spread for p in parts]),
        )


def probabilities(moving: Moving, what: Manoeuvres) -> list[np.ndarray]:
    """Horizontal and, where there are heights, vertical probability (N,) of a manoeuvre; NaN where the modes do not
    tell manoeuvres apart, and before a track starts.
    """
    return between(moving, what, *_window(moving, what))


def between(moving: Moving, what: Manoeuvres, first: np.ndarray, last: np.ndarray) -> list[np.ndarray]:
    """With the numbers (M,) of the rows that each row's window begins and ends at: a = (v(last) − v(first)) / T
    is held against the threshold, in straight modes and in the others.
    """
    out = []
    for k, velocity in enumerate(moving.velocity):
        shown = velocity, moving.variance[k], moving.acceleration[k], moving.spread[k]
        limits = what.window, what.straight[k], what.threshold[k]
        out.append(np.asarray(native.manoeuvring(moving.time, first, last, moving.mode, *shown, *limits)))
    return out


def _window(moving: Moving, what: Manoeuvres) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the rows (N,) that a row's window begins and ends at: at least one row back (or on), as far as the
    track goes.
    """
    reach = (0.5 if what.centred else 1.0) * what.window + SLACK
    return native.windows(moving.time, moving.new, reach, reach if what.centred else 0.0)


@dataclass
class Segments:
    """Numbers the stretches in which a target manoeuvres or does not, since its part began.

    A stretch begins where the probability passes `ON` or `OFF`, and counts once it has lasted `least` seconds; with
    `back` it counts from where it began, for which later rows must be known. Rows of one part may come in pieces.
    """

    least: float
    back: bool = False
    level: int = 0  # of the last row, and since when (s)
    since: float = 0.0
    counted: int = 0  # the level of the last stretch that counts
    count: int = 0

    def numbers(self, probability: np.ndarray, time: np.ndarray, new: np.ndarray, ahead: int = 0) -> np.ndarray:
        """Number of the stretch of each row (N - ahead,). Rows that are not `new` follow those given before; the last
        `ahead` rows come again.
        """
        if not probability.size:
            return np.zeros(0, np.int32)
        goes_on = not new[0]
        if goes_on:
            probability, time = np.r_[float(self.level), probability], np.r_[self.since, time]
            new = np.r_[True, new]
        level = _levels(probability, new)
        starts = np.r_[True, (level[1:] != level[:-1]) | new[1:]]
        run = np.cumsum(starts) - 1
        first = np.flatnonzero(starts)
        last = np.r_[first[1:], level.size] - 1
        lasted = (time[last] - time[first])[run] if self.back else time - time[first[run]]
        counts, counted = (lasted >= self.least) | new, level.copy()
        if goes_on:
            counted[0] = self.counted
        counted = counted[np.maximum.accumulate(np.where(counts, np.arange(level.size), 0))]
        change = np.cumsum(np.r_[False, counted[1:] != counted[:-1]] & ~new)
        begins = np.flatnonzero(new)
        base = np.repeat(change[begins], np.diff(np.r_[begins, new.size]))
        number = change - base
        if goes_on:
            number[: begins[1] if begins.size > 1 else number.size] += self.count
        end = number.size - ahead - 1
        self.level, self.since = int(level[end]), float(time[first[run[end]]])
        self.counted, self.count = int(counted[end]), int(number[end])
        return number[int(goes_on) : end + 1].astype(np.int32)

    def next(self, probability: float, time: float, new: bool) -> int:
        """The number of one more row of a part; as `numbers`, without `back`."""
        level = 1 if probability > ON else 0 if probability < OFF or new else self.level
        if new:
            self.level, self.since, self.counted, self.count = level, time, level, 0
        elif level != self.level:
            self.level, self.since = level, time
        if level != self.counted and time - self.since >= self.least:
            self.counted, self.count = level, self.count + 1
        return self.count


def _levels(probability: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Whether a target manoeuvres (N,), 0 or 1, with hysteresis."""
    clear = np.where(probability > ON, 1, np.where(probability < OFF, 0, -1))
    clear[new & (clear < 0)] = 0
    return clear[np.maximum.accumulate(np.where(clear >= 0, np.arange(clear.size), 0))]


class Told(NamedTuple):
    """Columns of a table of tracks: probabilities (N,) of a manoeuvre, the vertical one None without heights, and
    segments (N,); None where the modes do not tell manoeuvres apart.
    """

    horizontal: np.ndarray
    vertical: np.ndarray | None
    segment: np.ndarray | None


def told(estimate: Any, time: np.ndarray, new: np.ndarray, what: Manoeuvres) -> Told:
    """Of whole parts that are laid end to end."""
    return told_of(Moving.of(estimate, time, new), new, what, any(estimate.non_manoeuvring))


def told_of(moving: Moving, new: np.ndarray, what: Manoeuvres, tells: bool) -> Told:
    """The same of what moves; tells: whether the modes tell manoeuvres apart."""
    found = probabilities(moving, what)
    segment = what.segments().numbers(found[0], moving.time, new) if tells else None
    return Told(found[0], found[1] if len(found) > 1 else None, segment)
