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

from ..catalogue.targets import kind_of
from ..estimate import Status
from ..models.non_manoeuvring import straight_noise

GRAVITY = 9.80665  # m/s²
ON, OFF = 0.6, 0.4  # manoeuvre probability at which a new segment begins and ends
UNSURE = 1e12  # (m/s²)²: the variance of an acceleration of which nothing is known
SLACK = 1e-6  # s: of times that are taken for equal
BLOCK = 4_000  # rows at once: few enough for the processor's cache
SHORT = 1e-3  # s: over less than that a velocity does not change


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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
    def of(
        cls, estimate: Any, time: np.ndarray, new: np.ndarray, variances: Sequence[np.ndarray] | None = None
    ) -> Moving:
        """From an estimate with x, P, mode_probability and status; a restart is a new beginning. variances: of the
        components, (N,) each, where they were taken out of P before.
        """
        status = np.asarray(estimate.status)
        begins = new | (status == Status.restarted) | (status == Status.initialised)
        x, diagonal = estimate.x.T, np.einsum("nii->in", estimate.P) if variances is None else variances
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
    """The same with the numbers (N,) of the rows that each row's window begins and ends at."""
    out = [np.empty(first.size) for _ in moving.velocity]
    for begin in range(0, first.size, BLOCK):
        rows = slice(begin, min(begin + BLOCK, first.size))
        # windows that end at their own row need no search for it
        own = last[rows.start] == rows.start and (np.diff(last[rows]) == 1).all()
        end = rows if own else last[rows]
        elapsed = moving.time[end] - moving.time[first[rows]]
        for k, found in enumerate(out):
            found[rows] = _of_direction(moving, what, k, rows, first[rows], end, elapsed)
    return out


def _of_direction(
    moving: Moving, what: Manoeuvres, k: int, rows: slice, first: np.ndarray, last: Any, elapsed: np.ndarray
) -> np.ndarray:
    """T⁻¹ (v(last) - v(first)) against the threshold, in straight modes and in the others."""
    T, mode = np.where(elapsed < SHORT, what.window, elapsed), moving.mode[rows]
    velocity, before, after = moving.velocity[k], moving.variance[k][first], moving.variance[k][last]
    change = (velocity[:, last] - velocity[:, first]) / T
    unsure = np.where(elapsed < SHORT, UNSURE, np.minimum((before + after) / T**2, UNSURE))
    noise = what.straight[k] * T
    # the square of a change that errors of the velocity made is their variance: it is taken off in the mean, so that
    # what is left counts the less, the larger it is beside the threshold
    r = what.threshold[k]
    square = (change**2).sum(axis=0)
    straight = np.sqrt(np.maximum(square - unsure * velocity.shape[0], 0.0)) / (1.0 + unsure / r**2)
    mean, variance = change, unsure
    acceleration, spread = moving.acceleration[k], moving.spread[k]
    if acceleration is not None and spread is not None:
        mean, variance = _in_manoeuvres(acceleration[:, rows], spread[rows], mode, change, unsure)
    size, dimensions = np.sqrt((mean**2).sum(axis=0)), velocity.shape[0]
    quiet = exceeds(straight, noise / T**2, r, dimensions)
    return (1.0 - mode) * quiet + mode * exceeds(size, variance, r, dimensions)


def _in_manoeuvres(
    acceleration: np.ndarray, spread: np.ndarray, mode: np.ndarray, change: np.ndarray, unsure: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and variance of a component in the modes that manoeuvre. In the straight ones the acceleration is zero, so
    theirs are those of the mixture without it; the change of the velocity is weighed by its variance.
    """
    share = np.maximum(mode, 1e-6)
    own = acceleration / share
    square = (acceleration**2).mean(axis=0)
    variance = np.clip((spread + square) / share - (own**2).mean(axis=0), 1e-9, UNSURE)
    weight = variance / (variance + unsure)
    return own + weight * (change - own), np.minimum(variance, unsure)


def _window(moving: Moving, what: Manoeuvres) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the rows (N,) that a row's window begins and ends at: at least one row back (or on), as far as the
    track goes.
    """
    rows = np.arange(moving.time.size)
    if not rows.size:
        return rows, rows
    starts = np.flatnonzero(np.r_[True, moving.new[1:]])
    length = np.diff(np.r_[starts, rows.size])
    low, high = np.repeat(starts, length), np.repeat(starts + length - 1, length)
    # tracks laid behind each other in time, so that one search serves all
    began = moving.time[starts]
    most = float((moving.time[high[starts]] - began).max()) + 4.0 * what.window + 1.0
    key = moving.time - np.repeat(began, length) + most * np.repeat(np.arange(starts.size), length)
    reach = (0.5 if what.centred else 1.0) * what.window + SLACK
    first = np.searchsorted(key, key - reach)
    first = np.clip(first, low, np.maximum(rows - 1, low))
    if not what.centred:
        return first, rows
    last = np.searchsorted(key, key + reach, side="right") - 1
    return first, np.clip(last, np.minimum(rows + 1, high), high)


def exceeds(mean: np.ndarray, variance: np.ndarray, threshold: float, dimensions: int) -> np.ndarray:
    """P(|a| > threshold) (N,) of a normal vector of one or two components, each of this variance, whose mean has this
    size.

    Of two components |a|²/variance is noncentral χ², and a power of it is nearly normal (to .02). Source: Sankaran,
    Biometrika 50, 1963.
    """
    variance = np.maximum(variance, 1e-6 * threshold**2)
    if dimensions == 1:
        sd = np.sqrt(variance)
        return _beyond((threshold - mean) / sd) + _beyond((threshold + mean) / sd)
    away, x = mean**2 / variance, threshold**2 / variance
    one, two, three = 2.0 + away, 2.0 + 2.0 * away, 2.0 + 3.0 * away
    h = 1.0 - 2.0 / 3.0 * one * three / two**2
    p = two / one**2
    m = (h - 1.0) * (1.0 - 3.0 * h)
    centre = 1.0 + h * p * (h - 1.0 - 0.5 * (2.0 - h) * m * p)
    return _beyond(((x / one) ** h - centre) / (h * np.sqrt(2.0 * p) * (1.0 + 0.5 * m * p)))


def _beyond(z: np.ndarray) -> np.ndarray:
    """P(n > z) of a standard normal n, by a logistic function: to 2e-4."""
    z = np.clip(z, -8.0, 8.0)
    return 1.0 / (1.0 + np.exp(z * (1.5976 + 0.07056 * z * z)))


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
