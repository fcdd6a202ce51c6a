"""Around manoeuvres: how large and long errors get, when manoeuvres are noticed and how often in vain."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import Array, by_hints
from ..frozen import frozen
from .errors import squared
from .figure import Figure, jackknife, ratio

Bools = NDArray[np.bool_]
BEFORE, AFTER = 5, 30  # scans around an event


@by_hints
def manoeuvring(acceleration: ArrayLike, threshold: float) -> Bools:
    """(runs, scans): is |true acceleration| (runs, scans, axes) above the threshold (m/s²)?"""
    return np.linalg.norm(np.asarray(acceleration, dtype=float), axis=2) > threshold


@by_hints
def events(busy: ArrayLike, kind: Literal["onset", "end"]) -> NDArray[np.intp]:
    """(events, 3): run, scan and the scan of the next change (or the number of scans) of every onset, or end.

    busy (runs, scans). An onset's scan is the first that manoeuvres, an end's the first that no longer does.
    """
    if kind not in ("onset", "end"):
        raise ValueError(f"kind: expected 'onset' or 'end', got {kind!r}")
    b = np.asarray(busy, dtype=bool)
    runs, scans = np.nonzero(b[:, 1:] != b[:, :-1])
    scans = scans + 1
    last_of_run = np.append(runs[1:] != runs[:-1], True)[: len(runs)]
    following = np.where(last_of_run, b.shape[1], np.append(scans[1:], 0)[: len(runs)])
    mine = b[runs, scans] == (kind == "onset")
    return np.stack([runs, scans, following], axis=1)[mine]


def aligned(
    error: ArrayLike,
    busy: ArrayLike,
    kind: Literal["onset", "end"],
    *,
    before: int = BEFORE,
    after: int = AFTER,
) -> Array:
    """|e|² (events, before + after) around each event, whose scan is column ``before``.

    NaN outside the run and after the next change.
    """
    square, found = squared(error), events(busy, kind)
    column = found[:, 1:2] + np.arange(-before, after)
    there = (column >= 0) & (column < found[:, 2:3])
    return np.where(there, square[found[:, :1], np.where(there, column, 0)], np.nan)


@frozen
class Response:
    """What an onset (or end) does to the error: peak of the RMSE over events; settling in scans, inf if never.

    over_time (before + after,): RMSE over events, aligned; level: the RMSE it has settled at or below;
    events: how many.
    """

    peak: Figure
    settling: Figure
    over_time: Array
    level: float
    events: int


@by_hints
def response(
    error: ArrayLike,
    busy: ArrayLike,
    kind: Literal["onset", "end"],
    *,
    before: int = BEFORE,
    after: int = AFTER,
    tolerance: float = 0.5,
    level: float | None = None,
) -> Response:
    """Peak error and settling time after manoeuvre onsets or ends.

    c[j] = √(mean over events of |e|² j scans after the event), of events that see no other change until then.
    Peak: max c[j], j ≥ 0. Settling: the first j ≥ 0 from which on c stays ≤ level, by default (1 + tolerance)
    times the RMSE in the ``before`` scans before the events; inf if it never does within ``after`` scans.
    Standard errors by a jackknife over runs. Source: overshoot and settling time of a step response.
    """
    square = squared(error)
    runs = events(busy, kind)[:, 0]
    rows = aligned(error, busy, kind, before=before, after=after)
    settled = level if level is not None else (1 + tolerance) * math.sqrt(_mean(rows[:, :before]))

    def curve(chosen: Array) -> Array:
        mine = rows[np.isin(runs, chosen.astype(int))]
        count = np.isfinite(mine).sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.sqrt(np.nansum(mine, axis=0) / np.where(count, count, np.nan))

    def peak(chosen: Array) -> float:
        c = curve(chosen)[before:]
        return float(np.nanmax(c)) if np.isfinite(c).any() else math.nan

    def settling(chosen: Array) -> float:
        return settling_time(curve(chosen)[before:], settled)

    numbers = np.arange(len(square), dtype=float)
    return Response(jackknife(peak, numbers), jackknife(settling, numbers), curve(numbers), settled, len(rows))


def _mean(values: Array) -> float:
    there = np.isfinite(values)
    return float(values[there].mean()) if there.any() else math.nan


def settling_time(curve: Array, level: float) -> float:
    """The first index from which on the curve stays at or below the level; inf if never, NaN without either."""
    known = np.flatnonzero(np.isfinite(curve))
    if not len(known) or not math.isfinite(level):
        return math.nan
    above = known[curve[known] > level]
    if not len(above):
        return 0.0
    return math.inf if above[-1] == known[-1] else float(above[-1] + 1)


@frozen
class Detection:
    """How manoeuvres are noticed.

    delay: mean scans from onset to notice, of the noticed; noticed: share of onsets noticed before they end;
    false_alarms: share of quiet scans that are taken for manoeuvres.
    """

    delay: Figure
    noticed: Figure
    false_alarms: Figure


@by_hints
def detection(
    probability: ArrayLike, busy: ArrayLike, *, threshold: float = 0.5, grace: int = 10, first: int = 5
) -> Detection:
    """How a manoeuvre probability (runs, scans) notices manoeuvres, busy (runs, scans) bool being the truth.

    Noticed at the first scan j ≥ onset, before the end, where the probability reaches the threshold; delay
    j − onset. False alarms: scans ≥ first that are quiet, and have been for ``grace`` scans, with the probability
    at or above the threshold. Times are in scans. Errors: ValueError for different shapes.
    """
    sums = noticed(probability, busy, threshold=threshold, grace=grace, first=first)
    return Detection(*(ratio(*sums[name]) for name in ("detection_delay", "noticed", "false_alarms")))


def noticed(
    probability: ArrayLike, busy: ArrayLike, *, threshold: float = 0.5, grace: int = 10, first: int = 5
) -> dict[str, tuple[Array, Array]]:
    """Sum and count of every run, (runs,) each, behind the figures of :func:`detection`."""
    p, b = np.asarray(probability, dtype=float), np.asarray(busy, dtype=bool)
    if p.shape != b.shape or p.ndim != 2:
        raise ValueError(f"probability: expected (runs, scans) as busy, {b.shape}, got {p.shape}")
    says = p >= threshold
    found = events(b, "onset")
    column = np.arange(p.shape[1])
    hits = says[found[:, 0]] & (column >= found[:, 1:2]) & (column < found[:, 2:3])
    seen = hits.any(axis=1)
    delay = np.where(seen, hits.argmax(axis=1) - found[:, 1], 0)
    runs = len(p)

    def per_run(values: ArrayLike) -> Array:
        return np.bincount(found[:, 0], np.asarray(values, dtype=float), runs).astype(float)

    last_busy = np.maximum.accumulate(np.where(b, column, -grace - 1), axis=1)
    quiet = (column - last_busy > grace) & (column >= first) & np.isfinite(p)
    return {
        "detection_delay": (per_run(delay), per_run(seen)),
        "noticed": (per_run(seen), per_run(np.ones(len(found)))),
        "false_alarms": ((says & quiet).sum(axis=1).astype(float), quiet.sum(axis=1).astype(float)),
    }
