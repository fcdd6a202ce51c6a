"""The parts of a filter besides motion models, sensor and chain, in the form the native engine takes."""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from .._engine import native
from ..checks import Array
from ..frozen import frozen

# the largest layer of a network, and the most membership functions of an ANFIS, that the engine runs
LARGEST_LAYER = 128


@frozen(kw_only=True)
class Parts:
    """What makes a filter other than an IMM.

    interaction of the modes; side, a motion model whose acceleration modes build on; proposal, which modes are alive;
    start, the initial probabilities if they are not those of all modes; chain, the transition's size if it is not that
    of all modes; scores, a network that weighs; detection of onsets; aid, a learned correction.
    """

    interaction: native.Interaction = native.Interaction.imm
    side: Any = None
    proposal: native.Proposal = field(default_factory=native.Proposal)
    start: Array | None = None
    chain: int | None = None
    scores: native.Adaptation = field(default_factory=native.Adaptation)
    detection: native.Detection = field(default_factory=native.Detection)

    def into(self, declaration: native.Declaration, axes: int) -> None:
        """Write these into what the engine takes."""
        declaration.interaction, declaration.proposal = self.interaction, self.proposal
        declaration.scores, declaration.detection = self.scores, self.detection
        declaration.side = [] if self.side is None else [native_mode(self.side, axes)]


def native_mode(motion: Any, axes: int) -> native.Mode:
    """A motion model with what sets its noise and its known acceleration, if anything does.

    Errors: TypeError where it builds on a motion model of your own.
    """
    inner = getattr(motion, "motion", None)
    if inner is not None and not hasattr(inner, "native"):
        raise TypeError(
            f"{type(motion).__name__}.motion: expected one of jink's motion models, got {type(inner).__name__}"
        )
    mode = motion.native(axes)
    if hasattr(motion, "adaptation"):
        mode.adaptation = motion.adaptation(axes)
    if hasattr(motion, "level"):
        mode.level, mode.around_side, mode.in_sd = motion.level(axes)
    return mode


def adapts(motion: Any) -> bool:
    """Does something choose the noise of this motion model anew in each scan?"""
    return hasattr(motion, "adaptation") and motion.adaptation(1).kind != native.Adapt.none


def is_fixed(mode: native.Mode) -> bool:
    """Does a mode have the same noise in every scan and no known acceleration of its own?"""
    adaptive = mode.adaptation.kind != native.Adapt.none or mode.kind == native.MotionKind.two_stage
    return not adaptive and not mode.level


def uniform(count: int, of: int) -> Array:
    """Equal probabilities of the first ``count`` of ``of`` slots."""
    return np.where(np.arange(of) < count, 1.0 / count, 0.0)
