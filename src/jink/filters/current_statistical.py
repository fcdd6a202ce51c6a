"""The "current" statistical model and its fuzzy limits: the estimated acceleration sets the acceleration noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from .._engine import native
from ..checks import positive
from ..models.motion import NativeMode
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .kalman import Kalman


@dataclass(frozen=True)
class FuzzyLimits:
    """The largest acceleration to expect, from the acceleration there is: a_max(a) = a_th min(1, exp(−k (1 −
    |a|/a_th))).

    threshold a_th (m/s²); up and down the exponents k₁ and k₂ for a ≥ 0 and a < 0; operating a_up (m/s²), up to which
    a_max(a) ≥ |a| must hold. Errors: ValueError for a_up ≥ a_th, or a k above a_th ln(a_th/a_up)/(a_th − a_up), where
    it does not hold. Source: Wang, Qin, Yang & Yang, Defence Technology 2010 no. 3; the stored text of the paper has
    lost its equations, and the membership was reconstructed from its words and figures (docs/current-statistical.md).
    """

    threshold: float = 100.0
    up: float = 0.97
    down: float = 0.97
    operating: float = 90.0

    def __post_init__(self) -> None:
        a_th, a_up = (
            positive("FuzzyLimits.threshold", self.threshold),
            positive("FuzzyLimits.operating", self.operating),
        )
        if a_up >= a_th:
            raise ValueError(
                f"FuzzyLimits.operating: expected a value below the threshold {a_th:g} m/s², the largest that "
                f"a_max reaches, got {a_up:g}"
            )
        bound = a_th * math.log(a_th / a_up) / (a_th - a_up)
        for name in ("up", "down"):
            k = positive(f"FuzzyLimits.{name}", getattr(self, name))
            if k > bound:
                raise ValueError(
                    f"FuzzyLimits.{name}: expected at most {bound:.4f}, got {k:g}; beyond it a_max(a) < |a| "
                    "somewhere below "
                    f"operating {a_up:g} m/s²"
                )

    def __call__(self, acceleration: float) -> float:
        """a_max (m/s²) at an acceleration."""
        k = self.up if acceleration >= 0 else self.down
        return self.threshold * min(1.0, math.exp(-k * (1.0 - abs(acceleration) / self.threshold)))


@dataclass(frozen=True, kw_only=True)
class CurrentStatistical:
    """Exponentially correlated acceleration about a mean that is its current estimate, state [p v a] per axis.

    x⁻ = Φ x + U â, which is constant acceleration; P⁻ = Φ P Φᵀ + 2α σ² Q₀(α), Φ and Q₀ Singer's with α =
    1/time_constant; σ² = (4−π)/π (a_max − a)² for a ≥ 0, (4−π)/π (a_min + a)² for a < 0, a the predicted acceleration
    of the axis.

    acceleration_max a_max, and a_min downwards (m/s², both positive; default the same), or ``limits``, which move with
    the acceleration; a margin a_max − |a| below ``least_margin`` times that limit counts as that much, so that an
    acceleration at or beyond it does not freeze the filter; time_constant (s); acceleration_prior_sd (m/s²) at the
    start, or on entering from a mode without acceleration. Errors: ValueError unless exactly one of acceleration_max
    and limits is given. Source: Zhou & Kumar, J. Guidance 7(5), 1984; limits: Wang et al. 2010.
    """

    acceleration_max: float | None = None
    acceleration_min: float | None = None
    limits: FuzzyLimits | None = None
    time_constant: float = 20.0
    acceleration_prior_sd: float = 30.0
    least_margin: float = 0.01
    name: ClassVar[str] = "current_statistical"
    manoeuvring: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if (self.acceleration_max is None) == (self.limits is None):
            raise ValueError("CurrentStatistical: give exactly one of acceleration_max and limits")
        positive("CurrentStatistical.time_constant", self.time_constant)
        positive("CurrentStatistical.acceleration_prior_sd", self.acceleration_prior_sd)
        positive("CurrentStatistical.least_margin", self.least_margin)
        for name in ("acceleration_max", "acceleration_min"):
            if getattr(self, name) is not None:
                positive(f"CurrentStatistical.{name}", getattr(self, name))

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        prior = [0.0, 0.0, self.acceleration_prior_sd**2] * axes
        return NativeMode(
            kind=native.MotionKind.current_statistical,
            axes=axes,
            parameters=[1.0] * axes + [float(self.time_constant)],
            prior_variance=prior,
        )

    def adaptation(self, axes: int) -> native.Adaptation:
        """How the engine sets its variance."""
        if self.limits is not None:
            f = self.limits
            limits = [f.threshold, f.up, f.down, self.least_margin]
            return native.Adaptation(kind=native.Adapt.fuzzy_limits, numbers=limits)
        up = float(self.acceleration_max or 0.0)
        down = up if self.acceleration_min is None else float(self.acceleration_min)
        return native.Adaptation(kind=native.Adapt.current_statistical, numbers=[up, down, self.least_margin])


def csaf(
    sensor: Sensor,
    *,
    acceleration_max: float = 90.0,
    time_constant: float = 20.0,
    acceleration_prior_sd: float = 30.0,
    outliers: Outliers | None = None,
    initial: TwoPoint | OnePoint | Prior | None = None,
) -> Kalman:
    """The "current" statistical adaptive filter: a Kalman filter on :class:`CurrentStatistical` with fixed limits."""
    motion: Any = CurrentStatistical(
        acceleration_max=acceleration_max,
        time_constant=time_constant,
        acceleration_prior_sd=acceleration_prior_sd,
    )
    return Kalman(motion, sensor, outliers=outliers, initial=initial)


def facs(
    sensor: Sensor,
    *,
    limits: FuzzyLimits | None = None,
    time_constant: float = 20.0,
    acceleration_prior_sd: float = 30.0,
    outliers: Outliers | None = None,
    initial: TwoPoint | OnePoint | Prior | None = None,
) -> Kalman:
    """The fuzzy adaptive "current" statistical filter: as :func:`csaf`, with limits that follow the acceleration."""
    motion: Any = CurrentStatistical(
        limits=limits or FuzzyLimits(),
        time_constant=time_constant,
        acceleration_prior_sd=acceleration_prior_sd,
    )
    return Kalman(motion, sensor, outliers=outliers, initial=initial)
