"""Motion models: how a target may move between two measurements, and how uncertain that is.

Each is a frozen description; the axes (1 to 3) come from the sensor. States are interleaved per axis, ``px vx (ax) py
vy (ay) ...``, a turn rate last. Process noise is given in one of the field's parameterisations, which the parameter's
name says: ``acceleration_sd`` (constant over a step, G = [T²/2, T]) or ``acceleration_psd`` (white), and so on. A
number holds for all axes; a sequence gives one per axis.

A model of your own is any object with ``f(x, dt)`` (vectorised over tracks), ``Q(dt)`` and optionally ``jacobian(x,
dt)``; see :mod:`jink.stepwise`.
"""

from collections.abc import Sequence
from typing import Any, ClassVar, Protocol

from .._engine import native
from ..checks import PerAxis, exactly_one, number, per_axis, positive
from ..frozen import frozen

# what the engine takes of a motion model
NativeMode = native.Mode
MotionKind, NoiseKind = native.MotionKind, native.NoiseKind


def _variances(name: str, value: PerAxis, axes: int) -> list[float]:
    """Per-axis variances of an ``_sd`` parameter, or per-axis densities of a ``_psd`` one."""
    values = per_axis(name, value, axes, zero=True)
    return [v * v for v in values] if name.endswith("_sd") else values


def _kind(name: str) -> native.NoiseKind:
    return NoiseKind.continuous if name.endswith("_psd") else NoiseKind.piecewise


@frozen(kw_only=True)
class ConstantVelocity:
    """Constant velocity with random accelerations, state [p v] per axis.

    F = [1 T; 0 1];  acceleration_sd σ: Q = σ² G Gᵀ, G = [T²/2, T];  acceleration_psd q: Q = q [T³/3 T²/2; T²/2 T].
    Units m/s² and m²/s³. Errors: ValueError unless exactly one noise is given.
    Source: Bar-Shalom, Li & Kirubarajan 2001, §6.2.2 (white), §6.3.2 (piecewise constant).
    """

    acceleration_sd: PerAxis | None = None
    acceleration_psd: PerAxis | None = None
    name: ClassVar[str] = "constant_velocity"
    manoeuvring: ClassVar[bool] = False

    def __post_init__(self) -> None:
        self._noise()

    def _noise(self) -> tuple[str, PerAxis]:
        name = exactly_one(
            type(self).__name__, acceleration_sd=self.acceleration_sd, acceleration_psd=self.acceleration_psd
        )
        return name, getattr(self, name)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        name, value = self._noise()
        return NativeMode(
            kind=MotionKind.constant_velocity,
            noise=_kind(name),
            axes=axes,
            parameters=_variances(name, value, axes),
            prior_variance=[0.0] * (2 * axes),
        )


@frozen(kw_only=True)
class ConstantAcceleration:
    """Constant acceleration with random changes, state [p v a] per axis.

    F = [1 T T²/2; 0 1 T; 0 0 1];  jerk_psd q: Q = q [T⁵/20 T⁴/8 T³/6; T⁴/8 T³/3 T²/2; T³/6 T²/2 T];
    acceleration_increment_sd σ: Q = σ² G Gᵀ, G = [T²/2, T, 1], the change of the acceleration in one scan, whatever its
    length. acceleration_prior_sd (m/s²) is the acceleration's sd when a track starts, and when an IMM enters this mode
    from one without acceleration. Source: Bar-Shalom, Li & Kirubarajan 2001, §6.2.3, §6.3.3.
    """

    jerk_psd: PerAxis | None = None
    acceleration_increment_sd: PerAxis | None = None
    acceleration_prior_sd: PerAxis = 10.0
    name: ClassVar[str] = "constant_acceleration"
    manoeuvring: ClassVar[bool] = True

    def __post_init__(self) -> None:
        self._noise()

    def _noise(self) -> tuple[str, PerAxis]:
        name = exactly_one(
            type(self).__name__,
            jerk_psd=self.jerk_psd,
            acceleration_increment_sd=self.acceleration_increment_sd,
        )
        return name, getattr(self, name)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        name, value = self._noise()
        prior = [
            v for a in per_axis("acceleration_prior_sd", self.acceleration_prior_sd, axes) for v in (0.0, 0.0, a * a)
        ]
        return NativeMode(
            kind=MotionKind.constant_acceleration,
            noise=_kind(name),
            axes=axes,
            parameters=_variances(name, value, axes),
            prior_variance=prior,
        )


@frozen(kw_only=True)
class Singer:
    """Exponentially correlated acceleration, state [p v a] per axis.

    ȧ = −a/τ + w with stationary sd ``acceleration_sd`` σ (m/s²) and ``time_constant`` τ (s); Φ and Q exact, by series
    where the closed form cancels (T/τ < 1). Source: Singer, IEEE Trans. AES-6(4), 1970; Bar-Shalom, Li & Kirubarajan
    2001, §8.2.
    """

    acceleration_sd: PerAxis
    time_constant: float
    name: ClassVar[str] = "singer"
    manoeuvring: ClassVar[bool] = True

    def __post_init__(self) -> None:
        positive("time_constant", self.time_constant)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        variances = _variances("acceleration_sd", self.acceleration_sd, axes)
        prior = [v for a in variances for v in (0.0, 0.0, max(a, 1e-300))]
        return NativeMode(
            kind=MotionKind.singer,
            axes=axes,
            parameters=[*variances, float(self.time_constant)],
            prior_variance=prior,
        )


@frozen(kw_only=True)
class CoordinatedTurn:
    """Horizontal turn at an unknown rate ω, state [px vx py vy (pz vz) ω]; the vertical is a constant velocity of its
    own.

    p' = p + T S(ωT) v, v' = R(ωT) v (rotation, positive counter-clockwise), exact Jacobian, finite and accurate through
    ω = 0. Noise: acceleration_sd or acceleration_psd as for :class:`ConstantVelocity`; turn_rate_sd (rad/s, the change
    in one scan) or turn_rate_psd (rad²/s³, white turn acceleration: variance psd·T). turn_rate_prior_sd (rad/s) holds
    when a track starts and when an IMM enters this mode. Source: Bar-Shalom, Li & Kirubarajan 2001, §11.7.1 to 11.7.2.
    """

    acceleration_sd: PerAxis | None = None
    acceleration_psd: PerAxis | None = None
    turn_rate_sd: float | None = None
    turn_rate_psd: float | None = None
    turn_rate_prior_sd: float = 0.1
    name: ClassVar[str] = "coordinated_turn"
    manoeuvring: ClassVar[bool] = True

    def __post_init__(self) -> None:
        self._noise()
        positive("turn_rate_prior_sd", self.turn_rate_prior_sd)

    def _noise(self) -> tuple[str, PerAxis, str, float]:
        owner = type(self).__name__
        name = exactly_one(owner, acceleration_sd=self.acceleration_sd, acceleration_psd=self.acceleration_psd)
        turn = exactly_one(owner, turn_rate_sd=self.turn_rate_sd, turn_rate_psd=self.turn_rate_psd)
        return name, getattr(self, name), turn, getattr(self, turn)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        name, value, turn, turn_value = self._noise()
        _needs_a_plane(self, axes)
        parameters = [*_variances(name, value, axes), *_variances(turn, turn_value, 1)]
        return NativeMode(
            kind=MotionKind.coordinated_turn,
            noise=_kind(name),
            turn_noise=_kind(turn),
            axes=axes,
            parameters=parameters,
            prior_variance=[0.0] * (2 * axes) + [self.turn_rate_prior_sd**2],
        )


@frozen
class KnownTurn:
    """Horizontal turn at a known rate (rad/s, positive counter-clockwise), state [p v] per axis; linear.

    Noise as for :class:`ConstantVelocity`. Source: Bar-Shalom, Li & Kirubarajan 2001, §11.7.1.
    """

    turn_rate: float
    acceleration_sd: PerAxis | None = None
    acceleration_psd: PerAxis | None = None
    name: ClassVar[str] = "known_turn"

    def __post_init__(self) -> None:
        if not abs(number("turn_rate", self.turn_rate)) < 100:
            raise ValueError(f"turn_rate: expected rad/s, got {self.turn_rate!r}")
        self._noise()

    @property
    def manoeuvring(self) -> bool:
        """False at a rate of zero, which is straight flight."""
        return self.turn_rate != 0.0

    def _noise(self) -> tuple[str, PerAxis]:
        name = exactly_one(
            type(self).__name__, acceleration_sd=self.acceleration_sd, acceleration_psd=self.acceleration_psd
        )
        return name, getattr(self, name)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        name, value = self._noise()
        _needs_a_plane(self, axes)
        return NativeMode(
            kind=MotionKind.known_turn,
            noise=_kind(name),
            axes=axes,
            parameters=[*_variances(name, value, axes), float(self.turn_rate)],
            prior_variance=[0.0] * (2 * axes),
        )


def _needs_a_plane(motion: object, axes: int) -> None:
    if axes < 2:
        raise ValueError(f"{type(motion).__name__}: turns in a plane, but the sensor has 1 axis; expected 2 or 3")


class NativeMotion(Protocol):
    """A motion model that the engine runs: those here, and those whose noise rules or a network choose."""

    def native(self, axes: int) -> NativeMode:
        """What the engine runs."""
        ...


class OwnMotion(Protocol):
    """The least that a user's own motion model must have; :mod:`jink.stepwise` says what more it can have."""

    def f(self, x: Any, dt: Any) -> Any:
        """The states x (B, n) after dt (B,) seconds."""
        ...

    def Q(self, dt: Any) -> Any:
        """The covariance (B, n, n) of the process noise."""
        ...


AnyMotion = NativeMotion | OwnMotion  # what a filter takes
Motion = ConstantVelocity | ConstantAcceleration | Singer | CoordinatedTurn | KnownTurn

MOTIONS: dict[str, type] = {
    m.__name__: m for m in (ConstantVelocity, ConstantAcceleration, Singer, CoordinatedTurn, KnownTurn)
}


def name_of(motion: object) -> str:
    """What a mode is called in an estimate, before names that repeat are numbered."""
    return str(getattr(motion, "name", type(motion).__name__))


def manoeuvres(motion: object) -> bool:
    """Does a motion model say that a target in it manoeuvres?"""
    return bool(getattr(motion, "manoeuvring", False))


def mode_names(motions: Sequence[object]) -> tuple[str, ...]:
    """One name per mode; a repeated one is numbered: constant_velocity, constant_velocity_2."""
    names: list[str] = []
    for motion in motions:
        name = name_of(motion)
        seen = sum(1 for n in names if n == name or (n.rpartition("_")[0] == name and n.rpartition("_")[2].isdigit()))
        names.append(name if not seen else f"{name}_{seen + 1}")
    return tuple(names)


def component_names(motions: Sequence[Any], axes: int) -> tuple[str, ...]:
    """The components an estimate is reported in: the union over the modes, per axis, then the turn rate."""
    modes = [m.native(axes) for m in motions]
    per = ("p", "v", "a") if any(m.has_acceleration for m in modes) else ("p", "v")
    names = tuple(f"{c}{axis}" for axis in "xyz"[:axes] for c in per)
    return (*names, "turn_rate") if any(m.has_turn_rate for m in modes) else names
