"""Fuzzy process noise: Sugeno rules over the residual and its change set the noise of a mode in each scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._engine import native
from ..models.fuzzy import PUBLISHED, FuzzyRules
from ..models.motion import ConstantVelocity, NativeMode, NativeMotion, manoeuvres, name_of
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import Transition
from .imm import IMM


@dataclass(frozen=True)
class FuzzyNoise:
    """A motion model whose noise variance along each axis comes from rules: q = rules(r, Δr).

    r = z − H x⁻ is the residual of the scan, Δr its change since the scan before.
    The rules take the place of the motion's own variance (acceleration_sd² or a density), which holds until the first
    measurement. q(k) uses the residual of scan k, so it is found before P⁻ = F P Fᵀ + q G Gᵀ. After a start or a miss
    Δr is 0; a miss, or a measurement rejected as an outlier, keeps the last q. Source: Lee, Joo & Park 2003, eq. 12–19.
    """

    motion: NativeMotion
    rules: FuzzyRules
    remembers = True

    @property
    def name(self) -> str:
        """The name of this mode in an estimate."""
        return f"fuzzy_{name_of(self.motion)}"

    @property
    def manoeuvring(self) -> bool:
        """Does a target in the motion model manoeuvre?"""
        return manoeuvres(self.motion)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        return self.motion.native(axes)

    def adaptation(self, axes: int) -> native.Adaptation:
        """How the engine sets its variance: c₁, 1/s₁, c₂, 1/s₂, w of each rule."""
        c, s = np.asarray(self.rules.centres), np.asarray(self.rules.spreads)
        table = np.column_stack([c[:, 0], 1 / s[:, 0], c[:, 1], 1 / s[:, 1], np.asarray(self.rules.variances)])
        return native.Adaptation(kind=native.Adapt.fuzzy_rules, numbers=table.ravel().tolist())

    def check_units(self, sensor_sd: float) -> None:
        """Errors: ValueError where the rules were made for residuals of another sensor (sd in m)."""
        self.rules.check_units(sensor_sd)

    def level(self, axes: int) -> tuple[list[float], bool, bool]:
        """The motion model's known acceleration, if any."""
        level = getattr(self.motion, "level", None)
        return level(axes) if level is not None else ([], False, False)


def fuzzy_imm(
    sensor: Sensor,
    rules: Sequence[FuzzyRules] | str = "lee-2003",
    transition: Transition = 0.97,
    *,
    mode_probability: ArrayLike | None = None,
    outliers: Outliers | None = None,
    initial: TwoPoint | OnePoint | Prior | None = None,
) -> IMM:
    """IMM of constant velocities with fuzzy noise: one mode per rule table, or a published set by its name.

    mode_probability: by default 0.6 for the first, the rest equal, as published. Errors: ValueError for an unknown set,
    or rules in other units than metres. Source: Lee, Joo & Park 2003.
    """
    if isinstance(rules, str):
        if rules not in PUBLISHED:
            raise ValueError(f"rules: expected rule tables or one of {', '.join(PUBLISHED)}, got {rules!r}")
        rules = PUBLISHED[rules]
    motions: list[Any] = []
    for table in rules:
        start = float(np.sqrt(np.mean(table.variances)))
        motions.append(FuzzyNoise(ConstantVelocity(acceleration_sd=start), table))
    if mode_probability is None and len(motions) > 1:
        mode_probability = [0.6] + [0.4 / (len(motions) - 1)] * (len(motions) - 1)
    return IMM(motions, sensor, transition, mode_probability=mode_probability, outliers=outliers, initial=initial)
