"""How well many targets were tracked: GOSPA over runs and scans, switches of identity, completeness."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..checks import Array, by_hints
from .figure import Figure, ratio_influence, spread
from .sets import gospa


class Picture(NamedTuple):
    """One scan: the targets or tracks that are there, ids (n,) and points (n, axes)."""

    ids: NDArray[np.int64]
    points: Array


class SkyFigures(NamedTuple):
    """What many runs come to; distances in the unit of the points.

    gospa, localisation, missed, false: root mean squares over runs and scans, √mean(value²) and of its parts. switches
    and identities per run: how often a target's track changes, and tracks per target (both in the sense of CLEAR-MOT,
    Bernardin & Stiefelhagen 2008: the last match is kept while it is within c). completeness: share of targets and
    scans with a track; spurious: share of tracks and scans without a target (SIAP, Votruba et al. 2001).
    """

    gospa: Figure
    localisation: float
    missed: float
    false: float
    switches: Figure
    identities: float
    completeness: float
    spurious: float


class _Run:
    """What is summed over the scans of one run."""

    def __init__(self, c: float) -> None:
        self.c = c
        self.parts = np.zeros(3)
        self.scans = self.targets = self.tracks = self.paired = self.switches = 0
        self.last: dict[int, int] = {}
        self.had: dict[int, set[int]] = {}

    def add(self, truth: Picture, estimate: Picture) -> None:
        found = gospa(truth.points, estimate.points, self.c)
        self.parts += (found.localisation, found.missed, found.false)
        self.scans += 1
        self.targets += len(truth.ids)
        self.tracks += len(estimate.ids)
        self.paired += len(found.pairs.truth)
        now = self._kept(truth, estimate)
        taken = set(now.values())
        for i, j in zip(found.pairs.truth, found.pairs.estimate, strict=True):
            target, track = int(truth.ids[i]), int(estimate.ids[j])
            if target in now or track in taken:
                continue
            self.switches += self.last.get(target, track) != track
            now[target] = track
            taken.add(track)
        for target, track in now.items():
            self.had.setdefault(target, set()).add(track)
        self.last |= now

    def _kept(self, truth: Picture, estimate: Picture) -> dict[int, int]:
        """Matches of the scan before that still are within the cut-off."""
        place = {int(track): k for k, track in enumerate(estimate.ids)}
        kept: dict[int, int] = {}
        taken: set[int] = set()
        for point, each in zip(truth.points, truth.ids, strict=True):
            target = int(each)
            track = self.last.get(target)
            if track is None or track not in place or track in taken:
                continue
            if np.sum((point - estimate.points[place[track]]) ** 2) < self.c**2:
                kept[target] = track
                taken.add(track)
        return kept


@by_hints
def sky_figures(truth: Iterable[Sequence[Picture]], estimate: Iterable[Sequence[Picture]], c: float) -> SkyFigures:
    """Runs of scans, both in the same order; c is the cut-off of GOSPA (p = α = 2)."""
    runs: list[_Run] = []
    for true, found in zip(truth, estimate, strict=True):
        runs.append(_Run(c))
        for a, b in zip(true, found, strict=True):
            runs[-1].add(a, b)
    if not sum(run.scans for run in runs):
        raise ValueError("truth: expected at least one run of at least one scan")
    parts, scans = np.array([r.parts for r in runs]), np.array([float(r.scans) for r in runs])
    mean_square, influence = ratio_influence(parts.sum(axis=1), scans)
    value = math.sqrt(mean_square)
    localisation, missed, false = np.sqrt(parts.sum(axis=0) / scans.sum())
    switches = np.array([float(r.switches) for r in runs])
    had = [len(tracks) for r in runs for tracks in r.had.values()]
    targets, tracks, paired = (sum(getattr(r, name) for r in runs) for name in ("targets", "tracks", "paired"))
    return SkyFigures(
        gospa=Figure(value, spread(influence) / (2 * value) if value > 0 else 0.0),
        localisation=float(localisation),
        missed=float(missed),
        false=float(false),
        switches=Figure(float(switches.mean()), spread(switches)),
        identities=float(np.mean(had)) if had else math.nan,
        completeness=paired / targets if targets else math.nan,
        spurious=(tracks - paired) / tracks if tracks else 0.0,
    )
