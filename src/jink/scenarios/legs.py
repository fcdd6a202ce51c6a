"""Truth made of legs with constant acceleration and turn rate: closed forms, exact at every time."""

from __future__ import annotations

import numpy as np

from ..checks import Array
from .truth import Kinematics, find, rows_of


class Legs:
    """v' = ω J v + a in the plane and v' = a in height, with ω and a constant on every leg; J turns by +90°.

    start (B, K) begin of the legs in s; position, velocity (B, axes) at the first; command (B, K, axes)
    acceleration in m/s²; noise the same or None, process noise that nobody commanded; turn_rate (B, K) in
    rad/s, counter-clockwise, or None; velocity_step (B, K, axes) jumps at the begin of a leg, or None. B may
    be 1 for arrays that all runs share.

    With θ = ω τ, τ the time since the leg began, and the plane as complex numbers: v = e^{iθ} v₀ + τ (s₁ + i
    c₁) a,  p = p₀ + τ (s₁ + i c₁) v₀ + τ² (c₂ + i s₂) a, s₁ = sin θ / θ, c₁ = (1 − cos θ)/θ, c₂ = (1 − cos
    θ)/θ², s₂ = (θ − sin θ)/θ².
    """

    def __init__(
        self,
        start: Array,
        position: Array,
        velocity: Array,
        command: Array,
        *,
        noise: Array | None = None,
        turn_rate: Array | None = None,
        velocity_step: Array | None = None,
    ) -> None:
        self.start, self.command, self.turn_rate = start, command, turn_rate
        self.acceleration = command if noise is None else command + noise
        legs, axes = self.acceleration.shape[1:]
        given = (start, position, velocity, self.acceleration, turn_rate, velocity_step)
        self.runs = max(len(array) for array in given if array is not None)
        self._p = np.empty((self.runs, legs, axes))
        self._v = np.empty((self.runs, legs, axes))
        p, v = (np.broadcast_to(array, (self.runs, axes)) for array in (position, velocity))
        for leg in range(legs):
            if velocity_step is not None:
                v = v + velocity_step[:, leg]
            self._p[:, leg], self._v[:, leg] = p, v
            if leg + 1 < legs:
                tau = start[:, leg + 1] - start[:, leg]
                rate = None if turn_rate is None else turn_rate[:, leg]
                p, v, _ = _move(p, v, self.acceleration[:, leg], rate, tau)

    def at(self, time: Array) -> Kinematics:
        """Kinematics at the times (B, n)."""
        leg = find(self.start, time)
        tau = time - rows_of(self.start, leg)
        rate = None if self.turn_rate is None else rows_of(self.turn_rate, leg)
        p, v, a = (rows_of(array, leg) for array in (self._p, self._v, self.acceleration))
        return Kinematics(*_move(p, v, a, rate, tau))

    def breaks(self) -> Array:
        """(B, K) begin of the legs."""
        return self.start

    def commanded(self, time: Array) -> tuple[Array, Array]:
        """Mean commanded acceleration (B, n, axes) and turn rate (B, n) since the time before; first 0."""
        rate = self.turn_rate if self.turn_rate is not None else np.zeros((1, self.command.shape[1]))
        both = [self._integral(self.command, time), self._integral(rate[..., None], time)]
        elapsed = np.diff(time, axis=1)[..., None]
        means = [np.diff(total, axis=1, prepend=total[:, :1]) for total in both]
        for mean in means:
            np.divide(mean[:, 1:], elapsed, out=mean[:, 1:], where=elapsed != 0)
        # the difference of two sums is rounded; within one leg the value itself is exact
        before, now = (find(self.start, each) for each in (time[:, :-1], time[:, 1:]))
        within = (before == now) | ((before + 1 == now) & (rows_of(self.start, now) == time[:, 1:]))
        for mean, value in zip(means, (self.command, rate[..., None]), strict=True):
            mean[:, 1:] = np.where(within[..., None], rows_of(value, before), mean[:, 1:])
        return means[0], means[1][..., 0]

    def _integral(self, value: Array, time: Array) -> Array:
        length = np.diff(self.start, axis=1)[..., None]
        whole = np.cumsum(value[:, :-1] * length, axis=1)
        whole = np.concatenate([np.zeros_like(whole[:, :1] if whole.size else value[:, :1]), whole], axis=1)
        leg = find(self.start, time)
        return rows_of(whole, leg) + rows_of(value, leg) * (time - rows_of(self.start, leg))[..., None]


def _move(p: Array, v: Array, a: Array, rate: Array | None, tau: Array) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration after tau (...) from p, v, a (..., axes)."""
    t = tau[..., None]
    if rate is None:
        p, v, a = np.broadcast_arrays(p + t * (v + 0.5 * t * a), v + t * a, a)
        return p, v, a
    position, velocity = p + t * (v + 0.5 * t * a), v + t * a
    acceleration = np.broadcast_to(a, velocity.shape).copy()
    theta = rate * tau
    half = np.sinc(theta / (2 * np.pi))
    c2, s2 = 0.5 * half * half, _excess(theta)
    along = np.sinc(theta / np.pi) + 1j * theta * c2
    vc, ac = (array[..., 0] + 1j * array[..., 1] for array in (v, a))
    after = np.exp(1j * theta) * vc + tau * along * ac
    moved = tau * (along * vc + tau * (c2 + 1j * s2) * ac)
    turned = 1j * rate * after + ac
    position[..., 0], position[..., 1] = p[..., 0] + moved.real, p[..., 1] + moved.imag
    velocity[..., 0], velocity[..., 1] = after.real, after.imag
    acceleration[..., 0], acceleration[..., 1] = turned.real, turned.imag
    return position, velocity, acceleration


def _excess(theta: Array) -> Array:
    """(θ − sin θ)/θ², by its series below 0.5 where the difference cancels."""
    square = theta * theta
    series = theta / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72 * (1 - square / 110))))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(np.abs(theta) < 0.5, series, (theta - np.sin(theta)) / square)
