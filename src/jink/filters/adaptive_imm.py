"""The adaptive IMM: its modes have known accelerations around an estimate that another filter makes."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import ClassVar, Unpack

from numpy.typing import ArrayLike

from .._engine import native
from ..checks import PerAxis, items, numbers, per_axis, positive
from ..frozen import frozen
from ..models.motion import AnyMotion, ConstantVelocity, NativeMode, NativeMotion, manoeuvres, name_of
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import Transition
from .imm import IMM, IMMOptions
from .parts import Parts
from .plain import MODES


@frozen(kw_only=True)
class AugmentedAcceleration:
    """Constant velocity driven by an acceleration that is a random walk, state [p v a] per axis: the optimal augmented
    filter.

    p, v: F = [1 T; 0 1], G = [T²/2, T];  x⁺ = F x + G a + G w, w of acceleration_sd σ (m/s²);  a⁺ = a + step, of
    bias_sd √Qa (m/s²) in one scan, whatever its length. bias_prior_sd √Pa0 (m/s²) at the start.
    Source: Friedland, IEEE Trans. AC-14(4), 1969 (bias = acceleration).
    """

    acceleration_sd: PerAxis
    bias_sd: PerAxis
    bias_prior_sd: PerAxis
    name: ClassVar[str] = "augmented_acceleration"
    manoeuvring: ClassVar[bool] = True
    _kind: ClassVar[native.MotionKind] = native.MotionKind.augmented

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        own = type(self).__name__
        noise = [v * v for v in per_axis(f"{own}.acceleration_sd", self.acceleration_sd, axes, zero=True)]
        bias = [v * v for v in per_axis(f"{own}.bias_sd", self.bias_sd, axes, zero=True)]
        prior = [v for a in per_axis(f"{own}.bias_prior_sd", self.bias_prior_sd, axes) for v in (0.0, 0.0, a * a)]
        return NativeMode(kind=self._kind, axes=axes, parameters=[*noise, *bias], prior_variance=prior)


@frozen(kw_only=True)
class TwoStageAcceleration(AugmentedAcceleration):
    """The two-stage estimator of the same acceleration: one filter without it, one that finds it from the innovations.

    M⁻ = M + Qa, U = F V + G;  x = x̄ + V b. That is the augmented filter with the noise Qa [U; 1][U; 1]ᵀ in place of Qa
    on the acceleration alone; jink runs it in this form (U = P_xa/M). Both are equal for Qa = 0; for Qa > 0 the
    two-stage estimator is not optimal. With cross-axis measurement noise each axis still has its own U. Source:
    Friedland 1969; Alouani, Xia, Rice & Blair, IEEE Trans. AC-38(5), 1993; as used by Lee, Joo & Park 2003, eq. 3–6.
    """

    name: ClassVar[str] = "two_stage_acceleration"
    not_smoothed: ClassVar[str] = (
        "its noise depends on the covariance it is added to; smooth a jink.AugmentedAcceleration"
    )
    _kind: ClassVar[native.MotionKind] = native.MotionKind.two_stage


Estimator = AugmentedAcceleration | TwoStageAcceleration


@frozen
class AccelerationLevel:
    """A motion model with a known acceleration (m/s², one number or one per axis): x⁻ = f(x) + G u.

    estimated: the level counts from the acceleration that an :class:`AdaptiveIMM` estimates beside its modes, u =
    â(k−1) + level; in_sd: and in units of the estimate's own standard deviation, u = â(k−1) + level √P_aa(k−1). Errors:
    ValueError for in_sd without estimated.
    """

    motion: NativeMotion
    acceleration: PerAxis
    estimated: bool = False
    in_sd: bool = False

    def __post_init__(self) -> None:
        if not all(map(isfinite, _numbers(self.acceleration))):
            raise ValueError(f"AccelerationLevel.acceleration: expected finite numbers, got {self.acceleration!r}")
        for name in ("estimated", "in_sd"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"AccelerationLevel.{name}: expected True or False, got {getattr(self, name)!r}")
        if self.in_sd and not self.estimated:
            raise ValueError(
                "AccelerationLevel.in_sd: expected estimated=True too, whose standard deviation is the unit, got False"
            )

    @property
    def remembers(self) -> bool:
        """Does the motion model adapt to residuals?"""
        return bool(getattr(self.motion, "remembers", False))

    def check_units(self, sensor_sd: float) -> None:
        """Errors: ValueError where the motion model was made for residuals of another sensor (sd in m)."""
        if check := getattr(self.motion, "check_units", None):
            check(sensor_sd)

    @property
    def name(self) -> str:
        """The name of this mode in an estimate."""
        return name_of(self.motion) if self.manoeuvring == manoeuvres(self.motion) else "acceleration_level"

    @property
    def manoeuvring(self) -> bool:
        """Does a target in this mode manoeuvre?"""
        still = not self.estimated and not any(_numbers(self.acceleration))
        return manoeuvres(self.motion) or not still

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        return self.motion.native(axes)

    def adaptation(self, axes: int) -> native.Adaptation:
        """How the motion model adapts."""
        adaptation = getattr(self.motion, "adaptation", None)
        return adaptation(axes) if adaptation is not None else native.Adaptation()

    def level(self, axes: int) -> tuple[list[float], bool, bool]:
        """The known acceleration of each axis, whether it counts from the estimate, and whether in its deviations."""
        values = _numbers(self.acceleration)
        if len(values) not in (1, axes):
            raise ValueError(
                f"AccelerationLevel.acceleration: expected one number or one for each of {axes} axes, got {len(values)}"
            )
        return ([values[0]] * axes if len(values) == 1 else values), self.estimated, self.in_sd


def _numbers(value: PerAxis) -> list[float]:
    return numbers("AccelerationLevel.acceleration", value).reshape(-1).tolist()


def symmetric_levels(
    motion: NativeMotion, steps: Sequence[float], axes: int, *, estimated: bool = True, in_sd: bool = False
) -> list[AccelerationLevel]:
    """Modes at zero and at ± each step (m/s², or standard deviations) along each axis: 1 + 2 · steps · axes of them.

    Errors: ValueError for steps that are not positive and rising.
    """
    if not steps or any(b <= a for a, b in zip([0.0, *steps], steps, strict=False)):
        raise ValueError(f"steps: expected positive accelerations in rising order, got {list(steps)}")
    levels = [[0.0] * axes]
    for axis in range(axes):
        for step in steps:
            for sign in (-1.0, 1.0):
                levels.append([sign * step if a == axis else 0.0 for a in range(axes)])
    if axes == 1:
        levels.sort()
    return [AccelerationLevel(motion, level, estimated, in_sd) for level in levels]


class AdaptiveIMM(IMM):
    """IMM whose modes' known accelerations lie around an estimate of the acceleration: uⱼ(k) = â(k−1) + εⱼ.

    motions, some of them :class:`AccelerationLevel` with ``estimated=True``; estimator, the filter that runs beside
    them on the same measurements, :class:`TwoStageAcceleration` or :class:`AugmentedAcceleration` (its state is no part
    of the estimate). The other arguments are those of :class:`jink.IMM`. Source: Munir & Atherton, IEE Proc. RSN
    142(1), 1995; Lee, Joo & Park 2003, eq. 7-1.
    """

    arguments = ("estimator", *MODES)

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: Sensor | Sequence[Sensor],
        transition: Transition,
        *,
        estimator: Estimator,
        **options: Unpack[IMMOptions],
    ) -> None:
        if not isinstance(estimator, AugmentedAcceleration):
            raise TypeError(
                f"estimator: expected AugmentedAcceleration or TwoStageAcceleration, got {type(estimator).__name__}"
            )
        if not any(getattr(m, "estimated", False) for m in items("motions", motions, "motion models")):
            raise ValueError(
                "motions: expected at least one AccelerationLevel with estimated=True; without one, nothing adapts"
            )
        self.estimator = estimator
        super().__init__(motions, sensor, transition, **options)

    def _parts(self) -> Parts:
        return Parts(side=self.estimator)


def aimm(
    levels: Sequence[float],
    sensor: Sensor,
    transition: Transition = 0.97,
    *,
    acceleration_sd: float,
    estimator: Estimator,
    in_sd: bool = False,
    mode_probability: ArrayLike | None = None,
    outliers: Outliers | None = None,
    initial: TwoPoint | OnePoint | Prior | None = None,
) -> AdaptiveIMM:
    """The adaptive IMM of the papers: constant velocities at symmetric ``levels`` (m/s²) around the estimate.

    levels such as (−40, 0, 40); along each axis of the sensor; in_sd: in units of the estimate's standard deviation,
    such as (−2, 0, 2). mode_probability: by default 0.6 for the level zero, the rest equal. Errors: ValueError for
    levels that are not symmetric about zero (an even number cannot be).
    """
    rising = sorted(float(v) for v in levels)
    if len(rising) % 2 == 0 or any(abs(a + b) > 1e-12 * abs(a) for a, b in zip(rising, rising[::-1], strict=True)):
        raise ValueError(
            "levels: expected an odd number of accelerations symmetric about zero, such as (-40, 0, 40), got "
            f"{tuple(levels)}"
        )
    axes = int(getattr(sensor, "axes", None) or 2)
    positive("acceleration_sd", acceleration_sd, zero=True)
    motions = symmetric_levels(
        ConstantVelocity(acceleration_sd=acceleration_sd), rising[len(rising) // 2 + 1 :], axes, in_sd=in_sd
    )
    if mode_probability is None:
        centre = next(i for i, m in enumerate(motions) if not any(_numbers(m.acceleration)))
        rest = 0.4 / max(len(motions) - 1, 1)
        mode_probability = [0.6 if i == centre else rest for i in range(len(motions))]
    return AdaptiveIMM(
        motions,
        sensor,
        transition,
        estimator=estimator,
        mode_probability=mode_probability,
        outliers=outliers,
        initial=initial,
    )
