"""Fuzzy process noise: Sugeno rules over the residual and its change set the noise of a mode in each scan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._engine import native
from ..frozen import frozen
from ..models.fuzzy import PUBLISHED, FuzzyRules
from ..models.motion import ConstantVelocity, NativeMode, NativeMotion, manoeuvres, name_of
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import Transition
from .imm import IMM


@frozen
class FuzzyNoise:
    """A motion model whose noise variance comes from rules, along each axis or along and across the track.

    r = z − H x⁻ is the residual of the scan, Δr its change since the scan before. Without ``across`` each axis has its
    own q = rules(r, Δr). With ``across`` both turn with the predicted velocity v: e = v/√(|v|² + tr P_v),
    q∥ = rules(r e, Δr e), q⊥ = across(|r⊥|, Δr r⊥/|r⊥|), r⊥ = r − (r e) e, and the acceleration's covariance is
    q⊥ I + (q∥ − q⊥) e eᵀ. r⊥ has no sign: a turn to the left is as one to the right, and a turned plane has a turned
    answer.

    The rules take the place of the motion's own variance (acceleration_sd² or a density), which holds until the first
    measurement. q(k) uses the residual of scan k, so it is found before P⁻ = F P Fᵀ + G q Gᵀ. After a start or a miss
    Δr is 0; a miss, or a measurement rejected as an outlier, keeps the last q. Errors: ValueError for ``across`` with
    another motion than a constant velocity of equal noise along its axes. Source: Lee, Joo & Park 2003, eq. 12–19.
    """

    motion: NativeMotion
    rules: FuzzyRules
    across: FuzzyRules | None = None
    remembers = True

    def __post_init__(self) -> None:
        for name in ("rules", "across"):
            given = getattr(self, name)
            if not isinstance(given, FuzzyRules) and (given is not None or name == "rules"):
                raise TypeError(f"FuzzyNoise.{name}: expected FuzzyRules, got {type(given).__name__}")
        if self.across is None:
            return
        if not isinstance(self.motion, ConstantVelocity):
            raise ValueError(
                f"FuzzyNoise.across: expected the motion ConstantVelocity, got {type(self.motion).__name__}; other "
                "models have rules along each axis only"
            )
        _, value = self.motion._noise()
        if np.size(value) > 1 and len(set(np.ravel(value).tolist())) > 1:
            raise ValueError(f"FuzzyNoise.across: expected a motion with one noise for all axes, got {value!r}")

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
        mode = self.motion.native(axes)
        if self.across is None:
            return mode
        return NativeMode(
            kind=native.MotionKind.velocity_along_track,
            noise=mode.noise,
            axes=axes,
            parameters=mode.parameters,
            prior_variance=mode.prior_variance,
        )

    def adaptation(self, axes: int) -> native.Adaptation:
        """How the engine sets its variance: c₁, 1/s₁, c₂, 1/s₂, w of each rule, those across the track last."""
        tables = [self.rules] if self.across is None else [self.rules, self.across]
        return native.Adaptation(
            kind=native.Adapt.fuzzy_rules,
            sizes=[] if self.across is None else [len(table) for table in tables],
            numbers=[number for table in tables for number in _numbers(table)],
        )

    def check_units(self, sensor_sd: float) -> None:
        """Errors: ValueError where the rules were made for residuals of another sensor (sd in m)."""
        self.rules.check_units(sensor_sd)
        if self.across is not None:
            self.across.check_units(sensor_sd)

    def level(self, axes: int) -> tuple[list[float], bool, bool]:
        """The motion model's known acceleration, if any."""
        level = getattr(self.motion, "level", None)
        return level(axes) if level is not None else ([], False, False)


def _numbers(rules: FuzzyRules) -> list[float]:
    c, s = np.asarray(rules.centres), np.asarray(rules.spreads)
    return np.column_stack([c[:, 0], 1 / s[:, 0], c[:, 1], 1 / s[:, 1], np.asarray(rules.variances)]).ravel().tolist()


def fuzzy_imm(
    sensor: Sensor,
    rules: Sequence[FuzzyRules] | str = "lee-2003",
    transition: Transition = 0.97,
    *,
    across: Sequence[FuzzyRules] | str | None = None,
    mode_probability: ArrayLike | None = None,
    outliers: Outliers | None = None,
    initial: TwoPoint | OnePoint | Prior | None = None,
) -> IMM:
    """IMM of constant velocities with fuzzy noise: one mode per rule table, or a published set by its name.

    across: the same for rules across the track; ``rules`` then hold along it. mode_probability: by default 0.6 for the
    first, the rest equal, as published. Errors: ValueError for an unknown set, rules in other units than metres, or
    another number of tables across the track than along it. Source: Lee, Joo & Park 2003.
    """
    rules = _tables("rules", rules)
    others = [None] * len(rules) if across is None else _tables("across", across)
    if len(others) != len(rules):
        raise ValueError(f"across: expected one rule table for each of the {len(rules)} modes, got {len(others)}")
    motions: list[Any] = []
    for table, other in zip(rules, others, strict=True):
        start = float(np.sqrt(np.mean(table.variances)))
        motions.append(FuzzyNoise(ConstantVelocity(acceleration_sd=start), table, other))
    if mode_probability is None and len(motions) > 1:
        mode_probability = [0.6] + [0.4 / (len(motions) - 1)] * (len(motions) - 1)
    return IMM(motions, sensor, transition, mode_probability=mode_probability, outliers=outliers, initial=initial)


def _tables(name: str, given: Sequence[FuzzyRules] | str) -> Sequence[FuzzyRules]:
    if not isinstance(given, str):
        return given
    if given not in PUBLISHED:
        raise ValueError(f"{name}: expected rule tables or one of {', '.join(PUBLISHED)}, got {given!r}")
    return PUBLISHED[given]
