"""The rules that all filters share, checked, in the form the native engine takes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._engine import native
from ..checks import Array, numbers, one_of, positive
from ..models.coasting import Coasting
from ..models.outliers import Outliers
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import stationary, transition_rule
from .parts import Parts


def declared_rules(
    modes: int,
    initial: TwoPoint | OnePoint | Prior,
    outliers: Outliers | None,
    parts: Parts | None,
    *,
    transition: Any,
    transition_step: float | None,
    mode_probability: ArrayLike | None,
    mixing: str,
    linearisation: str,
    coast: float | None,
    coasting: Coasting | None,
) -> native.Declaration:
    """Chain, initial probabilities, linearisation, mixing, outliers, coasting, start. Errors name the argument."""
    chain = parts.chain if parts and parts.chain else modes
    continuous, matrix = transition_rule(transition, transition_step, chain)
    one_of("linearisation", linearisation, ("ekf", "ukf"))
    one_of("mixing", mixing, ("prior", "unbiased"))
    if outliers is not None and not isinstance(outliers, Outliers):
        raise TypeError(f"outliers: expected jink.Outliers, got {type(outliers).__name__}")
    if not isinstance(initial, TwoPoint | OnePoint | Prior):
        raise TypeError(f"initial: expected jink.TwoPoint, OnePoint or Prior, got {type(initial).__name__}")
    velocity_sd = 1000.0 if isinstance(initial, Prior) else positive("initial.velocity_sd", initial.velocity_sd)
    start = parts.start if parts else None
    if start is None:
        start = _probabilities(mode_probability, modes, continuous, matrix)
    declaration = native.Declaration()
    declaration.continuous, declaration.transition = continuous, matrix.ravel().tolist()
    declaration.initial_probability = start.tolist()
    declaration.unscented, declaration.unbiased_mixing = linearisation == "ukf", mixing == "unbiased"
    if outliers is not None:
        declaration.outlier_share, declaration.restart_after = outliers.share, int(outliers.restart_after)
        declaration.hindsight = bool(outliers.hindsight)
    declaration.coast = 0.0 if coast is None else positive("coast", coast)
    if coasting is not None:
        if not isinstance(coasting, Coasting):
            raise TypeError(f"coasting: expected jink.Coasting, got {type(coasting).__name__}")
        declaration.coasting = coasting.native()
    declaration.start = _start_of(initial)
    declaration.velocity_variance = velocity_sd * velocity_sd
    return declaration


def _start_of(initial: TwoPoint | OnePoint | Prior) -> native.Start:
    if isinstance(initial, OnePoint):
        return native.Start.one_point
    if isinstance(initial, TwoPoint) and initial.bounded:
        return native.Start.bounded_two_point
    return native.Start.two_point


def _probabilities(given: ArrayLike | None, modes: int, continuous: bool, matrix: Array) -> Array:
    if given is None:
        return stationary(continuous, matrix)
    p = numbers("mode_probability", given)
    if p.shape != (modes,) or np.any(~(p >= 0)) or not np.isclose(p.sum(), 1):
        raise ValueError(f"mode_probability: expected {modes} probabilities that sum to one, got {given!r}")
    return p
