"""Motion models: x(k) = f(x(k-1), T) + G u + w, w ~ N(0, Q(T)); state interleaved per axis, turn_rate last.

Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, chapters 6 and
11.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.special import spherical_jn

Array = NDArray[np.float64]
AXES = "xyz"


def per_axis(value: float | list[float] | tuple[float, ...] | Array, axes: int) -> Array:
    """One noise level per axis, from a scalar or a sequence."""
    return np.broadcast_to(np.asarray(value, float), (axes,)).copy()


class Motion:
    """A model by its blocks: `letters` are the components kept per axis ("pv" or "pva")."""

    name = ""
    letters = "pv"
    turning = False  # has the component turn_rate

    def __init__(self, axes: int):
        self.axes = axes
        names = [letter + AXES[a] for a in range(axes) for letter in self.letters]
        self.components = tuple(names + ["turn_rate"] * self.turning)
        self.n = len(self.components)

    def index(self, name: str) -> int:
        return self.components.index(name)

    def input_matrix(self, dt: float) -> Array:
        """G (n, axes): a known acceleration moves position by T^2/2 and velocity by T, and no other
        component.
        """
        G = np.zeros((self.n, self.axes))
        for a in range(self.axes):
            G[self.index("p" + AXES[a]), a] = dt**2 / 2
            G[self.index("v" + AXES[a]), a] = dt
        return G

    def prior_variance(self, component: str) -> float:
        """Variance with which a component starts when nothing is known of it."""
        raise KeyError(component)

    def f(self, x: Array, dt: float) -> Array:
        return x @ self.F(x, dt).T

    def noise(self, x: Array, dt: float) -> Array:
        """Q of a step that begins at the estimate x, which adaptive models look at."""
        return self.Q(dt)

    def F(self, x: Array, dt: float) -> Array:
        raise NotImplementedError

    def Q(self, dt: float) -> Array:
        raise NotImplementedError


def white_acceleration(dt: float, sd: float | None, psd: float | None) -> Array:
    """Q of one axis [p v]: sd^2 G G' with G = [T^2/2, T], or psd [T^3/3 T^2/2; T^2/2 T]."""
    if (sd is None) == (psd is None):
        raise ValueError("exactly one of sd and psd")
    if sd is not None:
        G = np.array([dt**2 / 2, dt])
        return sd**2 * np.outer(G, G)
    assert psd is not None
    return psd * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])


class AccelerationNoise(Motion):
    """What the models with [p v] per axis share: their process noise is white acceleration."""

    def __init__(self, axes, acceleration_sd=None, acceleration_psd=None):
        super().__init__(axes)
        self.sd = None if acceleration_sd is None else per_axis(acceleration_sd, axes)
        self.psd = None if acceleration_psd is None else per_axis(acceleration_psd, axes)

    def Q(self, dt):
        blocks = [
            white_acceleration(dt, None if self.sd is None else self.sd[a], None if self.psd is None else self.psd[a])
            for a in range(self.axes)
        ]
        return block_diag(*blocks)


class ConstantVelocity(AccelerationNoise):
    name = "constant_velocity"

    def F(self, x, dt):
        return block_diag(*[np.array([[1, dt], [0, 1]])] * self.axes)


class ConstantAcceleration(Motion):
    """Wiener process acceleration: continuous white jerk, or an independent increment per step."""

    name = "constant_acceleration"
    letters = "pva"

    def __init__(self, axes, jerk_psd=None, acceleration_increment_sd=None, acceleration_prior_sd=10.0):
        super().__init__(axes)
        self.psd = None if jerk_psd is None else per_axis(jerk_psd, axes)
        self.sd = None if acceleration_increment_sd is None else per_axis(acceleration_increment_sd, axes)
        self.acceleration_prior_sd = per_axis(acceleration_prior_sd, axes)

    def prior_variance(self, component):
        return self.acceleration_prior_sd[AXES.index(component[1])] ** 2 if component[0] == "a" else np.nan

    def F(self, x, dt):
        return block_diag(*[np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])] * self.axes)

    def Q(self, dt):
        if self.sd is not None:
            G = np.array([dt**2 / 2, dt, 1.0]) * (dt > 0)  # no step, no increment
            return block_diag(*[sd**2 * np.outer(G, G) for sd in self.sd])
        assert self.psd is not None
        T = dt
        unit = np.array([[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]])
        return block_diag(*[psd * unit for psd in self.psd])


@lru_cache(maxsize=4096)
def singer_exact(dt: float, time_constant: float) -> tuple[Array, Array]:
    """Phi and Q/(2 alpha sigma^2) of one axis by Singer's closed forms in 80 digits (Singer 1970; Bar-Shalom
    8.2.3).
    """
    with localcontext() as context:
        context.prec = 80
        T, a = Decimal(dt), 1 / Decimal(time_constant)
        e, ee, aT = (-a * T).exp(), (-2 * a * T).exp(), a * T
        Phi = [[1, T, (aT - 1 + e) / a**2], [0, 1, (1 - e) / a], [0, 0, e]]
        q11 = (1 - ee + 2 * aT + 2 * aT**3 / 3 - 2 * aT**2 - 4 * aT * e) / (2 * a**5)
        q12 = (ee + 1 - 2 * e + 2 * aT * e - 2 * aT + aT**2) / (2 * a**4)
        q13 = (1 - ee - 2 * aT * e) / (2 * a**3)
        q22 = (4 * e - 3 - ee + 2 * aT) / (2 * a**3)
        q23 = (ee + 1 - 2 * e) / (2 * a**2)
        q33 = (1 - ee) / (2 * a)
        Q = [[q11, q12, q13], [q12, q22, q23], [q13, q23, q33]]
        return np.array(Phi, dtype=float), np.array(Q, dtype=float)


class Singer(Motion):
    """Acceleration is a first-order Markov process of sd sigma and time constant 1/alpha: Q = 2 alpha sigma^2
    Q0.
    """

    name = "singer"
    letters = "pva"

    def __init__(self, axes, acceleration_sd, time_constant):
        super().__init__(axes)
        self.sd = per_axis(acceleration_sd, axes)
        self.time_constant = per_axis(time_constant, axes)

    def prior_variance(self, component):
        return self.sd[AXES.index(component[1])] ** 2 if component[0] == "a" else np.nan

    def F(self, x, dt):
        return block_diag(*[singer_exact(float(dt), float(tau))[0] for tau in self.time_constant])

    def Q(self, dt):
        return block_diag(
            *[
                2 / tau * sd**2 * singer_exact(float(dt), float(tau))[1]
                for sd, tau in zip(self.sd, self.time_constant, strict=True)
            ]
        )


def turn_matrix(w: float, dt: float) -> Array:
    """The turn of [px vx py vy] at rate w: sin(wT)/w = T sinc(wT), (1-cos wT)/w = T sin(wT/2) sinc(wT/2)."""
    theta = w * dt
    S = dt * np.sinc(theta / np.pi)
    C = dt * np.sin(theta / 2) * np.sinc(theta / 2 / np.pi)
    s, c = np.sin(theta), np.cos(theta)
    return np.array([[1, S, 0, -C], [0, c, 0, -s], [0, C, 1, S], [0, s, 0, c]])


def turn_derivative(w: float, dt: float) -> Array:
    """d turn_matrix / d w, finite through w = 0: d(sin(wT)/w)/dw = -T^2 j1(wT), j1 the spherical Bessel
    function.
    """
    theta = w * dt
    dS = -(dt**2) * np.sign(theta) * spherical_jn(1, abs(theta))
    dC = dt**2 * (np.sinc(theta / np.pi) - np.sinc(theta / 2 / np.pi) ** 2 / 2)
    s, c = dt * np.sin(theta), dt * np.cos(theta)
    return np.array([[0, dS, 0, -dC], [0, -s, 0, -c], [0, dC, 0, dS], [0, c, 0, -s]])


class KnownTurn(AccelerationNoise):
    """A turn of the horizontal velocity at a given rate (rad/s, counter-clockwise); the vertical is constant
    velocity.
    """

    name = "known_turn"

    def __init__(self, axes, turn_rate, acceleration_sd=None, acceleration_psd=None):
        super().__init__(axes, acceleration_sd, acceleration_psd)
        self.turn_rate = turn_rate

    def F(self, x, dt):
        vertical = [np.array([[1, dt], [0, 1]])] * (self.axes - 2)
        return block_diag(turn_matrix(self.turn_rate, dt), *vertical)


class CoordinatedTurn(AccelerationNoise):
    """A turn at an unknown rate, the last state component (Bar-Shalom 11.7): linearised for the EKF by its
    Jacobian.
    """

    name = "coordinated_turn"
    turning = True

    def __init__(
        self,
        axes,
        acceleration_sd=None,
        acceleration_psd=None,
        turn_rate_sd=None,
        turn_rate_psd=None,
        turn_rate_prior_sd=0.1,
    ):
        super().__init__(axes, acceleration_sd, acceleration_psd)
        self.turn_rate_sd, self.turn_rate_psd = turn_rate_sd, turn_rate_psd
        self.turn_rate_prior_sd = turn_rate_prior_sd

    def prior_variance(self, component):
        return self.turn_rate_prior_sd**2 if component == "turn_rate" else np.nan

    def transition(self, w: float, dt: float) -> Array:
        vertical = [np.array([[1, dt], [0, 1]])] * (self.axes - 2)
        return block_diag(turn_matrix(w, dt), *vertical, np.eye(1))

    def f(self, x, dt):
        return self.transition(x[-1], dt) @ x

    def F(self, x, dt):
        J = self.transition(x[-1], dt)
        J[:4, -1] = turn_derivative(x[-1], dt) @ x[:4]
        return J

    def Q(self, dt):
        if self.turn_rate_sd is not None:
            turn = self.turn_rate_sd**2 * (dt > 0)  # once per step, whatever its length
        else:
            turn = self.turn_rate_psd * dt
        return block_diag(super().Q(dt), np.array([[turn]]))
