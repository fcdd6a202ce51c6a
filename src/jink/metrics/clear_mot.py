"""CLEAR-MOT: one figure for what is missed, false or exchanged, and one for how far off the rest is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..checks import by_hints, positive
from .figure import Figure, ratio
from .sets import pairs_within
from .skies import Picture


class ClearMot(NamedTuple):
    """Figures over all runs and scans, with standard errors over runs; shares are of Σ targets.

    mota = 1 − Σ (misses + false positives + mismatches) / Σ targets, at most 1; motp = Σ d / Σ matches, in the unit of
    the points, 0 is best; misses, false_positives and mismatches are the three shares.
    """

    mota: Figure
    motp: Figure
    misses: Figure
    false_positives: Figure
    mismatches: Figure


@by_hints
def clear_mot(truth: Iterable[Sequence[Picture]], estimate: Iterable[Sequence[Picture]], c: float) -> ClearMot:
    """Runs of scans; matches are nearer than c.

    Matches of the scan before are kept while they are nearer than c; the rest is paired at the least Σ (d − c). A
    mismatch is a target whose track is another than its last one. Source: Bernardin & Stiefelhagen, "Evaluating
    multiple object tracking performance: the CLEAR MOT metrics", EURASIP J. Image and Video Processing 2008.
    Errors: ValueError where there is no run.
    """
    positive("c", c)
    counts = np.array([_of_run(a, b, c) for a, b in zip(truth, estimate, strict=True)], float)
    if not len(counts):
        raise ValueError("truth: expected at least one run")
    targets, tracks, matches, distance, mismatches = counts.T
    misses, false = targets - matches, tracks - matches
    wrong = ratio(misses + false + mismatches, targets)
    return ClearMot(
        mota=Figure(1.0 - wrong.value, wrong.se),
        motp=ratio(distance, matches),
        misses=ratio(misses, targets),
        false_positives=ratio(false, targets),
        mismatches=ratio(mismatches, targets),
    )


def _of_run(truth: Sequence[Picture], estimate: Sequence[Picture], c: float) -> tuple[float, ...]:
    targets = tracks = matches = mismatches = 0
    distance = 0.0
    now: dict[int, int] = {}
    last: dict[int, int] = {}
    for true, found in zip(truth, estimate, strict=True):
        row = {int(each): k for k, each in enumerate(true.ids)}
        column = {int(each): k for k, each in enumerate(found.ids)}

        def far(target: int, track: int, true=true, found=found, row=row, column=column) -> float:
            return float(np.linalg.norm(true.points[row[target]] - found.points[column[track]]))

        now = {i: j for i, j in now.items() if i in row and j in column and far(i, j) < c}
        free = [k for each, k in row.items() if each not in now]
        rest = [k for each, k in column.items() if each not in now.values()]
        if free and rest:
            pairs = pairs_within(true.points[free], found.points[rest], c, 1.0)
            for i, j in zip(pairs.truth, pairs.estimate, strict=True):
                target, track = int(true.ids[free[i]]), int(found.ids[rest[j]])
                mismatches += last.get(target, track) != track
                now[target] = track
        last |= now
        targets, tracks, matches = targets + len(row), tracks + len(column), matches + len(now)
        distance += sum(far(i, j) for i, j in now.items())
    return targets, tracks, matches, distance, mismatches
