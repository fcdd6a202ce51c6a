"""Motion models as the stepwise filters see them: named components, and a linearisation over many tracks."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from .._engine import native
from ..checks import positive
from ..models.motion import KnownTurn, component_names
from .functions import Array, StepFunction, jacobian_by_differences, regression


class Mode(Protocol):
    """One motion model: its components, their prior variances (NaN where none given), its linearisation."""

    owner: str
    components: tuple[str, ...]
    prior: Array
    known_turn: float | None

    def linearise(self, dt: Array, x: Array, P: Array, u: Array | None) -> tuple[Array, Array, Array]:
        """x⁻ (B, n), F (B, n, n) and Q (B, n, n), so that P⁻ = F P Fᵀ + Q."""
        ...


class LibraryMode:
    """One of jink's motion models, run by the engine."""

    def __init__(self, motion: Any, axes: int, unscented: bool) -> None:
        self.owner = type(motion).__name__
        self._native, self._unscented = motion.native(axes), unscented
        self.components = component_names([motion], axes)
        self.prior = np.array(self._native.prior_variance)
        self.known_turn = float(motion.turn_rate) if isinstance(motion, KnownTurn) else None

    def linearise(self, dt: Array, x: Array, P: Array, u: Array | None) -> tuple[Array, Array, Array]:
        """As :class:`Mode`."""
        return native.linearise_motion(self._native, self._unscented, dt, x, P, u)


class OwnMode:
    """A motion model of the user's own: f(x, dt), Q(dt); optionally jacobian, G, components, prior_variance.

    Over no time nothing moves: the functions are not asked about dt = 0.
    """

    known_turn: float | None = None

    def __init__(self, motion: Any, axes: int, unscented: bool) -> None:
        self.owner = type(motion).__name__
        for name in ("f", "Q"):
            if not callable(getattr(motion, name, None)):
                raise TypeError(
                    f"motions: expected a motion model of jink or one with f(x, dt) and Q(dt), got {self.owner}"
                )
        self.components = _components(motion, self.owner, axes)
        self.prior = _prior(motion, self.owner, self.components)
        n = len(self.components)
        self._unscented = unscented
        self._f = StepFunction(f"{self.owner}.f", motion.f, (n,), n)
        self._Q = StepFunction(f"{self.owner}.Q", motion.Q, (n, n), None)
        self._jacobian = self._G = None
        if callable(getattr(motion, "jacobian", None)):
            self._jacobian = StepFunction(f"{self.owner}.jacobian", motion.jacobian, (n, n), n)
        if callable(getattr(motion, "G", None)):
            self._G = StepFunction(f"{self.owner}.G", motion.G, (n, axes), None)

    def linearise(self, dt: Array, x: Array, P: Array, u: Array | None) -> tuple[Array, Array, Array]:
        """As :class:`Mode`."""
        n = len(self.components)
        if u is not None and self._G is None:
            raise ValueError(
                f"input: expected a motion with G(dt), which says how a known acceleration moves it; "
                f"{self.owner} has none"
            )
        rows = np.flatnonzero(dt != 0)
        if len(rows) == len(dt) and len(dt):
            return self._move(dt, x, P, u)
        ahead, F, Q = x.copy(), np.tile(np.eye(n), (len(dt), 1, 1)), np.zeros((len(dt), n, n))
        if len(rows):
            ahead[rows], F[rows], Q[rows] = self._move(dt[rows], x[rows], P[rows], None if u is None else u[rows])
        return ahead, F, Q

    def _move(self, dt: Array, x: Array, P: Array, u: Array | None) -> tuple[Array, Array, Array]:
        Q = self._Q(x, dt)
        if self._unscented:
            ahead, F, spread = regression(lambda points: self._at(points, dt), x, P)
            Q = Q + spread
        else:
            ahead = self._f(x, dt)
            F = (
                self._jacobian(x, dt)
                if self._jacobian
                else jacobian_by_differences(lambda points: self._at(points, dt), x, P)
            )
        if u is not None and self._G is not None:
            ahead = ahead + (self._G(x, dt) @ u[:, :, None])[:, :, 0]
        return ahead, F, Q

    def _at(self, points: Array, dt: Array) -> Array:
        return self._f(points, np.tile(dt, len(points) // len(dt)))


def own_size(motion: Any) -> int:
    """How many components a model of the user's own has, by its Q."""
    failure = ""
    for step in (1.0, np.array([1.0])):
        try:
            return int(np.shape(motion.Q(step))[-1])
        except Exception as error:
            failure = f"{type(error).__name__}: {error}"
    raise ValueError(f"{type(motion).__name__}.Q: expected a square matrix for dt = 1.0; {failure}")


def _components(motion: Any, owner: str, axes: int) -> tuple[str, ...]:
    given = getattr(motion, "components", None)
    if given is None:
        n = own_size(motion)
        per = {2 * axes: "pv", 3 * axes: "pva"}.get(n)
        if per is None:
            raise ValueError(
                f"{owner}: the state has {n} components in {axes} axes; name them in an attribute components, "
                'such as ("px", "vx", "py", "vy", "turn_rate")'
            )
        return tuple(f"{c}{axis}" for axis in "xyz"[:axes] for c in per)
    names = tuple(given)
    if not names or len(set(names)) != len(names) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"{owner}.components: expected different names, got {given!r}")
    if len(names) > native.largest_own:
        raise ValueError(f"{owner}.components: expected at most {native.largest_own}, got {len(names)}")
    return names


def _prior(motion: Any, owner: str, components: Sequence[str]) -> Array:
    given = dict(getattr(motion, "prior_variance", None) or {})
    for name in given:
        if name not in components:
            raise ValueError(f"{owner}.prior_variance: expected some of {', '.join(components)}, got {name!r}")
    return np.array(
        [positive(f"{owner}.prior_variance[{c!r}]", given[c]) if c in given else np.nan for c in components]
    )
