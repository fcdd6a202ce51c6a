"""What a composition has beyond motion models, a sensor and a chain, in the form the native engine takes it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..checks import Array

# kind, network layers, in logarithms, numbers
Adaptation = tuple[int, list[int], bool, list[float]]
FIXED: Adaptation = (0, [], False, [])
CURRENT_STATISTICAL, FUZZY_LIMITS, FUZZY_RULES, NETWORK = 1, 2, 3, 4  # kinds of adaptation
MIXED, APART, FIRST_ORDER, SECOND_ORDER = range(4)  # how modes interact
DIGRAPH, ACTIVE, GRID, DIMENSION = 1, 2, 3, 4  # how modes are proposed


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """Which modes are alive: kind, slots, the modes a track starts with (-1 none), neighbours of each mode, numbers."""

    kind: int
    slots: int
    start: list[float]
    neighbours: list[list[int]] = field(default_factory=list)
    numbers: list[float] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Parts:
    """interaction of the modes; side, a motion model whose acceleration modes build on; proposal; start, the initial
    probabilities if they are not those of all modes; chain, the transition's size if it is not that of all modes;
    scores, a network that weighs; detect (window, shortest, threshold); aid, a learned correction."""

    interaction: int = MIXED
    side: Any = None
    proposal: Proposal | None = None
    start: Array | None = None
    chain: int | None = None
    scores: Adaptation = FIXED
    detect: tuple[int, int, float] = (0, 1, 0.0)
    aid: tuple[int, int, int, int, list[int], list[float]] = (0, 0, 0, 0, [], [])

    def native(self, axes: int) -> tuple[Any, ...]:
        """What the engine takes after the rules that all filters have."""
        p = self.proposal
        propose = (p.kind, p.slots, p.start, p.neighbours, p.numbers) if p else (0, 0, [], [], [])
        side = [] if self.side is None else [native_mode(self.side, axes)]
        return (self.interaction, side, propose, self.scores, self.detect, self.aid)


def native_mode(motion: Any, axes: int) -> tuple[Any, ...]:
    """A motion model with what sets its noise and its known acceleration, if anything does.

    Errors: TypeError where it builds on a motion model of your own.
    """
    inner = getattr(motion, "motion", None)
    if inner is not None and not hasattr(inner, "native"):
        raise TypeError(
            f"{type(motion).__name__}.motion: expected one of jink's motion models, got {type(inner).__name__}"
        )
    adaptation = motion.adaptation(axes) if hasattr(motion, "adaptation") else FIXED
    level, around = motion.level(axes) if hasattr(motion, "level") else ([], False)
    return (*motion.native(axes), adaptation, level, around)


TWO_STAGE = 7  # kind of motion: its noise depends on the covariance


def is_fixed(motion: Any, axes: int) -> bool:
    """Has this one of jink's motion models the same noise, and no known acceleration of its own, in every scan?"""
    kind, *_, adaptation, level, _ = native_mode(motion, axes)
    return not adaptation[0] and not level and kind != TWO_STAGE


def uniform(count: int, of: int) -> Array:
    """Equal probabilities of the first ``count`` of ``of`` slots."""
    return np.where(np.arange(of) < count, 1.0 / count, 0.0)
