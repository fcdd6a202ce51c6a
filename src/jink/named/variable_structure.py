"""Variable-structure IMMs over forty noise levels, in the proportions of choi-2001: variances 1, 6, … 196 for 40 m/s²."""

from __future__ import annotations

from ..filters.variable_structure import (
    CHOI_2001,
    ActiveDigraph,
    AdaptiveGrid,
    DigraphSwitching,
    line_transition,
    noise_levels,
)
from ..motion import ConstantVelocity
from .purpose import Named, Purpose

STAY = 0.95  # from one scan to the next
ALIVE = 3


def vsmm_ds(purpose: Purpose) -> Named:
    """Digraph switching: the likeliest level and its two neighbours."""
    levels = _levels(purpose)
    filter = DigraphSwitching(
        levels, purpose.seen, line_transition(len(levels), stay=STAY), outliers=purpose.outliers
    )
    return Named(filter=filter, words=f"digraph switching, {_words(levels)}, 3 alive")


def vsmm_ad(purpose: Purpose) -> Named:
    """Active digraph: the three levels most likely next."""
    levels = _levels(purpose)
    chain = line_transition(len(levels), stay=STAY)
    filter = ActiveDigraph(levels, purpose.seen, chain, alive=ALIVE, outliers=purpose.outliers)
    return Named(filter=filter, words=f"active digraph, {_words(levels)}, {ALIVE} alive")


def vsmm_ag(purpose: Purpose) -> Named:
    """Adaptive grid: three points that move along the levels."""
    levels = _levels(purpose)
    filter = AdaptiveGrid(levels, purpose.seen, outliers=purpose.outliers)
    return Named(filter=filter, words=f"adaptive grid, {_words(levels)}, 3 points")


def _levels(purpose: Purpose) -> list[ConstantVelocity]:
    unit = (purpose.acceleration / 40) ** 2
    return noise_levels([unit * variance for variance in CHOI_2001])


def _words(levels: list[ConstantVelocity]) -> str:
    return (
        f"{len(levels)} noise levels from {levels[0].acceleration_sd:.3g} to "
        f"{levels[-1].acceleration_sd:.3g} m/s², equally spaced in variance"
    )
