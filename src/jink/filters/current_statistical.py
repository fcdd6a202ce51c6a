"""The "current" statistical model and its fuzzy limits: the estimated acceleration sets the acceleration noise."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from .._engine import native
from ..checks import one_of, positive
from ..frozen import frozen
from ..models.motion import NativeMode
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .kalman import Kalman

MEMBERSHIPS = {"exponential": native.Adapt.fuzzy_limits, "triangular": native.Adapt.straight_limits}


@frozen
class FuzzyLimits:
    """The largest acceleration to expect, from the acceleration there is: a_max(a) = a_th M(a).

    membership "exponential": M(a) = min(1, exp(−k (1 − |a|/a_th))); "triangular", its predecessor: straight lines
    between the same ends, M(a) = min(1, e⁻ᵏ + (1 − e⁻ᵏ) |a|/a_th). threshold a_th (m/s²) and operating a_up, up to
    which a_max(a) ≥ |a| must hold; threshold_down and operating_down, −a₋th and −a₋up of the paper, for a < 0
    (positive; default the same); up and down the exponents k₁ and k₂ for a ≥ 0 and a < 0. Errors: ValueError for a_up ≥
    a_th, or an exponential k above a_th ln(a_th/a_up)/(a_th − a_up), where it does not hold. Source: Wang, Qin, Yang &
    Yang, Defence Technology 2010 no. 3; the stored text of the paper has lost its equations, and both memberships were
    reconstructed from its words (docs/current-statistical.md).
    """

    threshold: float = 100.0
    up: float = 0.97
    down: float = 0.97
    operating: float = 90.0
    threshold_down: float | None = None
    operating_down: float | None = None
    membership: str = "exponential"

    def __post_init__(self) -> None:
        one_of("FuzzyLimits.membership", self.membership, MEMBERSHIPS)
        for side, k in (("", "up"), ("_down", "down")):
            names = f"threshold{side}", f"operating{side}"
            for name in (*names, k):
                if getattr(self, name) is not None or not name.endswith("_down"):
                    positive(f"FuzzyLimits.{name}", getattr(self, name))
            a_th, a_up = self.side(side == "")
            if a_up >= a_th:
                raise ValueError(
                    f"FuzzyLimits.{names[1]}: expected a value below the threshold {a_th:g} m/s², the largest that "
                    f"a_max reaches, got {a_up:g}"
                )
            bound = a_th * math.log(a_th / a_up) / (a_th - a_up)
            if self.membership == "exponential" and getattr(self, k) > bound:
                raise ValueError(
                    f"FuzzyLimits.{k}: expected at most {bound:.4f}, got {getattr(self, k):g}; beyond it a_max(a) < "
                    f"|a| somewhere below {names[1]} {a_up:g} m/s²"
                )

    def side(self, upwards: bool) -> tuple[float, float]:
        """Threshold and operating limit (m/s²) upwards or downwards, both positive."""
        if upwards:
            return self.threshold, self.operating
        down, operating = self.threshold_down, self.operating_down
        return (
            self.threshold if down is None else down,
            self.operating if operating is None else operating,
        )

    def __call__(self, acceleration: float) -> float:
        """a_max (m/s²) at an acceleration."""
        a_th, k = self.side(acceleration >= 0)[0], self.up if acceleration >= 0 else self.down
        share = abs(acceleration) / a_th
        if self.membership == "triangular":
            return a_th * min(1.0, math.exp(-k) + (1.0 - math.exp(-k)) * share)
        return a_th * min(1.0, math.exp(-k * (1.0 - share)))

    def numbers(self) -> list[float]:
        """As the engine reads a direction's limits."""
        return [float(v) for v in (self.side(True)[0], self.side(False)[0], self.up, self.down)]


@frozen
class LimitWidening:
    """Limits that widen in a scan whose measured position the filter did not expect.

    NIS is the squared residual over its variance, along each direction that has limits. Up to 1, its mean, the limits
    are what they are; between 1 and ``nis`` the variance grows in proportion to that of the margin ``times`` · a_th +
    |a|, which it has from ``nis`` on. So the filter stays calm while the target is, and follows an onset. It remembers
    nothing: a scan without a position has the limits as they are. Errors: ValueError for nis ≤ 1.
    """

    nis: float = 14.0
    times: float = 2.0

    def __post_init__(self) -> None:
        if positive("LimitWidening.nis", self.nis) <= 1.0:
            raise ValueError(f"LimitWidening.nis: expected more than 1, the mean of the NIS, got {self.nis:g}")
        positive("LimitWidening.times", self.times)


@frozen(kw_only=True)
class CurrentStatistical:
    """Exponentially correlated acceleration about a mean that is its current estimate, state [p v a] per axis.

    x⁻ = Φ x + U â, which is constant acceleration; P⁻ = Φ P Φᵀ + 2α σ² Q₀(α), Φ and Q₀ Singer's with α =
    1/time_constant; σ² = (4−π)/π (a_max − a)² for a ≥ 0, (4−π)/π (a_min + a)² for a < 0, a the predicted acceleration
    of the axis.

    acceleration_max a_max, and a_min downwards (m/s², both positive; default the same), or ``limits``, which move with
    the acceleration; with ``across`` the limits turn with the velocity v: ``limits`` along it (down is braking),
    ``across`` for the rest of the acceleration, and Q ∝ σ⊥² I + s (σ∥² − σ⊥²) v vᵀ/|v|², s = |v|²/(|v|² + tr P_v);
    ``widening`` of either where a position comes as a surprise. A margin a_max − |a| below ``least_margin`` times that
    limit counts as that much, so that an acceleration at or beyond it does not freeze the filter; time_constant (s);
    acceleration_prior_sd (m/s²) at the start, or on entering from a mode without acceleration. Errors: ValueError
    unless exactly one of acceleration_max and limits is given, or for ``across`` without limits or of another
    membership. Source: Zhou & Kumar, J. Guidance 7(5), 1984; limits: Wang et al. 2010.
    """

    acceleration_max: float | None = None
    acceleration_min: float | None = None
    limits: FuzzyLimits | None = None
    across: FuzzyLimits | None = None
    widening: LimitWidening | None = None
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
        self._check_parts()

    def _check_parts(self) -> None:
        for name, kind in (("limits", FuzzyLimits), ("across", FuzzyLimits), ("widening", LimitWidening)):
            given = getattr(self, name)
            if given is not None and not isinstance(given, kind):
                raise TypeError(f"CurrentStatistical.{name}: expected {kind.__name__}, got {type(given).__name__}")
        if self.across is None:
            return
        if self.limits is None:
            raise ValueError("CurrentStatistical.across: expected limits too, which hold along the velocity, got none")
        if self.across.membership != self.limits.membership:
            raise ValueError(
                f"CurrentStatistical.across: expected the membership of limits, {self.limits.membership}, got "
                f"{self.across.membership}"
            )

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        prior = [0.0, 0.0, self.acceleration_prior_sd**2] * axes
        turned = self.across is not None
        return NativeMode(
            kind=native.MotionKind.statistical_along_track if turned else native.MotionKind.current_statistical,
            axes=axes,
            parameters=[1.0] * axes + [float(self.time_constant)],
            prior_variance=prior,
        )

    def adaptation(self, axes: int) -> native.Adaptation:
        """How the engine sets its variance."""
        ends = [float(self.least_margin)]
        if self.widening is not None:
            ends += [float(self.widening.nis), float(self.widening.times)]
        if self.limits is not None:
            across = [] if self.across is None else self.across.numbers()
            kind = MEMBERSHIPS[self.limits.membership]
            return native.Adaptation(kind=kind, numbers=[*self.limits.numbers(), *across, *ends])
        up = float(self.acceleration_max or 0.0)
        down = up if self.acceleration_min is None else float(self.acceleration_min)
        return native.Adaptation(kind=native.Adapt.current_statistical, numbers=[up, down, 0.0, 0.0, *ends])


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
    across: FuzzyLimits | None = None,
    widening: LimitWidening | None = None,
    time_constant: float = 20.0,
    acceleration_prior_sd: float = 30.0,
    outliers: Outliers | None = None,
    initial: TwoPoint | OnePoint | Prior | None = None,
) -> Kalman:
    """The fuzzy adaptive "current" statistical filter: as :func:`csaf`, with limits that follow the acceleration."""
    motion: Any = CurrentStatistical(
        limits=limits or FuzzyLimits(),
        across=across,
        widening=widening,
        time_constant=time_constant,
        acceleration_prior_sd=acceleration_prior_sd,
    )
    return Kalman(motion, sensor, outliers=outliers, initial=initial)
