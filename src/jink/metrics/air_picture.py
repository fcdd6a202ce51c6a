"""Attributes of a single integrated air picture (SIAP): is every target in it, once, where it is, under one number?"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..checks import Array, by_hints, positive
from .figure import Figure, ratio
from .skies import Picture


class Siap(NamedTuple):
    """Figures over all runs and scans, each with the standard error from the spread over runs.

    With J targets, of which J_T have a track, and N tracks, of which N_A have a target, sums over scans:

    completeness Σ J_T / Σ J; ambiguity Σ N_A / Σ J_T (1 is best); spuriousness Σ (N − N_A) / Σ N; position_accuracy
    Σ d / Σ N_A in the unit of the points; id_change_rate Σ_j (U_j − 1) / Σ_j T_j per second, U_j the least number of
    tracks that cover all of target j that any track covers, and T_j the seconds that it is covered; longest_segment
    Σ_j L_j / Σ_j life_j, L_j the seconds of the longest stretch of target j on one track.
    """

    completeness: Figure
    ambiguity: Figure
    spuriousness: Figure
    position_accuracy: Figure
    id_change_rate: Figure
    longest_segment: Figure


class _Sums(NamedTuple):
    """Of one run: the numerators and denominators of the figures."""

    held: float
    targets: float
    assigned: float
    tracks: float
    distance: float
    changes: float
    covered: float
    longest: float
    life: float


@by_hints
def siap(
    truth: Iterable[Sequence[Picture]],
    estimate: Iterable[Sequence[Picture]],
    c: float,
    times: Iterable[Sequence[float]],
) -> Siap:
    """Runs of scans; a track belongs to the target nearest to it, if that is nearer than c; times (s) of each scan.

    A target may have several tracks. Source: Votruba, Nisley, Rothrock & Zombro, "Single Integrated Air Picture (SIAP)
    metrics implementation", SIAP SE TF 2001. Errors: ValueError where there is no run, or scans do not fit.
    """
    positive("c", c)
    runs = [_of_run(a, b, c, t) for a, b, t in zip(truth, estimate, times, strict=True)]
    if not runs:
        raise ValueError("truth: expected at least one run")
    sums = {name: np.array([getattr(run, name) for run in runs], float) for name in _Sums._fields}
    return Siap(
        completeness=ratio(sums["held"], sums["targets"]),
        ambiguity=ratio(sums["assigned"], sums["held"]),
        spuriousness=ratio(sums["tracks"] - sums["assigned"], sums["tracks"]),
        position_accuracy=ratio(sums["distance"], sums["assigned"]),
        id_change_rate=ratio(sums["changes"], sums["covered"]),
        longest_segment=ratio(sums["longest"], sums["life"]),
    )


def _of_run(truth: Sequence[Picture], estimate: Sequence[Picture], c: float, times: Sequence[float]) -> _Sums:
    held = targets = assigned = tracks = distance = 0.0
    there: dict[int, list[int]] = {}  # of each target the scans in which it is
    stretches: dict[int, dict[int, list[list[int]]]] = {}  # of each target and track: first and last scan
    for k, (true, found, _) in enumerate(zip(truth, estimate, times, strict=True)):
        target, far = _nearest(true.points, found.points)
        mine = np.flatnonzero(far < c)
        for each in true.ids:
            there.setdefault(int(each), []).append(k)
        for i in mine:
            of = stretches.setdefault(int(true.ids[target[i]]), {}).setdefault(int(found.ids[i]), [])
            if of and of[-1][1] == k - 1:
                of[-1][1] = k
            else:
                of.append([k, k])
        held += len(np.unique(target[mine]))
        targets, tracks = targets + len(true.ids), tracks + len(found.ids)
        assigned, distance = assigned + len(mine), distance + float(far[mine].sum())
    changes = covered = longest = life = 0.0
    for each, scans in there.items():
        life += times[scans[-1]] - times[scans[0]]
        all_ = [(a, b) for of in stretches.get(each, {}).values() for a, b in of]
        if all_:
            changes += _least_cover(all_) - 1
            covered += _covered(all_, times)
            longest += max(times[b] - times[a] for a, b in all_)
    return _Sums(held, targets, assigned, tracks, distance, changes, covered, longest, life)


def _nearest(points: Array, tracks: Array) -> tuple[np.ndarray, Array]:
    """Of each track the row of the nearest target and how far it is; infinitely far where there is none."""
    if not len(points) or not len(tracks):
        return np.zeros(len(tracks), int), np.full(len(tracks), math.inf)
    square = ((tracks[:, None] - points[None]) ** 2).sum(axis=2)
    row = square.argmin(axis=1)
    return row, np.sqrt(square[np.arange(len(tracks)), row])


def _least_cover(stretches: list[tuple[int, int]]) -> int:
    """The least number of stretches that hold every scan that any of them holds: always the one that ends last."""
    count, k, last = 0, min(a for a, _ in stretches), max(b for _, b in stretches)
    while k <= last:
        ends = [b for a, b in stretches if a <= k <= b]
        if ends:
            count += 1
            k = max(ends)
        k += 1
    return count


def _covered(stretches: list[tuple[int, int]], times: Sequence[float]) -> float:
    """Seconds between scans that one track holds both of."""
    steps = {k for a, b in stretches for k in range(a, b)}
    return float(sum(times[k + 1] - times[k] for k in sorted(steps)))
