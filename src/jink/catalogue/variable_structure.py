"""Variable-structure IMMs over five noise levels, each three times the one before: a fortieth to twice the kind's
acceleration.

The forty levels of choi-2001 (`CHOI_2001`), of which neighbours differ by a few per cent, follow a target that changes
slowly; one whose acceleration sets in at once has left long before they have climbed (docs/variable-structure.md).
"""

from __future__ import annotations

import numpy as np

from ..filters.variable_structure import (
    ActiveDigraph,
    AdaptiveGrid,
    DigraphSwitching,
    line_transition,
    noise_levels,
)
from ..models.motion import ConstantVelocity
from .purpose import Named, Purpose

LEVELS, LEAST, MOST = 5, 1 / 40, 2.0  # of the kind's acceleration
STAY = 0.95  # from one scan to the next
REACH = 2  # digraph switching: places from the likeliest level to the farthest alive
ALIVE = 3


def vsmm_ds(purpose: Purpose) -> Named:
    """Digraph switching: the likeliest level and those up to two places from it."""
    levels = _levels(purpose)
    chain = line_transition(len(levels), REACH, stay=STAY)
    filter = DigraphSwitching(levels, purpose.seen, chain, outliers=purpose.outliers)
    return Named(filter=filter, words=f"digraph switching, {_words(levels)}, up to {REACH} places apart")


def vsmm_ad(purpose: Purpose) -> Named:
    """Active digraph: the three levels most likely next."""
    levels = _levels(purpose)
    chain = line_transition(len(levels), stay=STAY)
    filter = ActiveDigraph(levels, purpose.seen, chain, alive=ALIVE, outliers=purpose.outliers)
    return Named(filter=filter, words=f"active digraph, {_words(levels)}, {ALIVE} alive")


def vsmm_ag(purpose: Purpose) -> Named:
    """Adaptive grid: three points that move along the levels, at least one and a half levels apart."""
    levels = _levels(purpose)
    filter = AdaptiveGrid(levels, purpose.seen, least_step=1.5, outliers=purpose.outliers)
    return Named(filter=filter, words=f"adaptive grid, {_words(levels)}, 3 points")


def _levels(purpose: Purpose) -> list[ConstantVelocity]:
    return noise_levels((purpose.acceleration * np.geomspace(LEAST, MOST, LEVELS)) ** 2)


def _words(levels: list[ConstantVelocity]) -> str:
    return (
        f"{len(levels)} noise levels from {levels[0].acceleration_sd:.3g} to "
        f"{levels[-1].acceleration_sd:.3g} m/s², each {(MOST / LEAST) ** (1 / (LEVELS - 1)):.2g} times the one before"
    )
