"""What the near-optimal reference knows: how the random families of targets are drawn."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np

from ..frozen import frozen
from .hypotheses import Array, Hypotheses


def uniform_levels(low: float, high: float, pieces: int) -> list[tuple[float, float]]:
    """A uniform distribution as Gaussians (mean, sd) with the moments of equal pieces."""
    width = (high - low) / pieces
    return [(low + (k + 0.5) * width, width / math.sqrt(12)) for k in range(pieces)]


def piecewise_noise(sd: float, T: float) -> Array:
    """σ² G Gᵀ of [p v], G = [T²/2, T]."""
    G = np.array([T * T / 2, T])
    return sd * sd * np.outer(G, G)


@frozen(kw_only=True)
class RandomAccelerations:
    """Each axis by itself: quiet for a geometric time, then an acceleration, constant for a geometric time.

    p' = p + T v + T²/2 (a + w), v' = v + T (a + w), a uniform in ±acceleration_limit. Times are means in s,
    accelerations in m/s²; process_noise_sd is that of w; state [p v a] per axis.
    """

    quiet_time: float = 40.0
    manoeuvre_time: float = 15.0
    acceleration_limit: float = 100.0
    process_noise_sd: float = 1.0
    per_axis: ClassVar[bool] = True
    measured: ClassVar[tuple[int, ...]] = (0,)
    size: ClassVar[int] = 3

    def levels(self) -> list[tuple[float, float]]:
        """Gaussians (m/s²) a newborn acceleration is drawn from."""
        return uniform_levels(-self.acceleration_limit, self.acceleration_limit, 2)

    def predict(self, h: Hypotheses, T: float) -> Hypotheses:
        """One scan on: x = F x, P = F P Fᵀ + Q."""
        F = np.array([[1, T, T * T / 2], [0, 1, T], [0, 0, 1]])
        x = (F @ h.x.reshape(3, -1)).reshape(h.x.shape)
        half = (F @ h.P.reshape(3, -1)).reshape(h.P.shape).swapaxes(0, 1)
        P = (F @ np.ascontiguousarray(half).reshape(3, -1)).reshape(h.P.shape)
        P[:2, :2] += piecewise_noise(self.process_noise_sd, T)[..., None, None]
        return replace(h, x=x, P=P)


@frozen(kw_only=True)
class RandomTurns:
    """Straight for a geometric time, then a coordinated turn to the left or right for a geometric time.

    p' = p + T S(ωT) v + T²/2 w, v' = R(ωT) v + T w, |ω| uniform. Times are means in s, rates in rad/s, noise
    in m/s²; state [px vx py vy ω], predicted by its first-order expansion (extended Kalman filter).
    """

    quiet_time: float = 40.0
    manoeuvre_time: float = 15.0
    turn_rate_low: float = math.radians(1)
    turn_rate_high: float = math.radians(6)
    process_noise_sd: float = 1.0
    per_axis: ClassVar[bool] = False
    measured: ClassVar[tuple[int, ...]] = (0, 2)
    size: ClassVar[int] = 5

    def levels(self) -> list[tuple[float, float]]:
        """Gaussians (rad/s) a newborn turn rate is drawn from."""
        right = uniform_levels(self.turn_rate_low, self.turn_rate_high, 2)
        return [*right, *((-mean, sd) for mean, sd in right)]

    def predict(self, h: Hypotheses, T: float) -> Hypotheses:
        """One scan on: x = f(x), P = F P Fᵀ + Q with F = ∂f/∂x."""
        w = h.x[4]
        angle, small = w * T, np.abs(w * T) < 1e-4
        safe = np.where(small, 1.0, w)
        c, s = np.cos(angle), np.sin(angle)
        A = np.where(small, T * (1 - angle * angle / 6), s / safe)
        B = np.where(small, T * angle / 2, (1 - c) / safe)
        dA = np.where(small, -angle * T * T / 3, (T * c - A) / safe)
        dB = np.where(small, T * T / 2, (T * s - B) / safe)
        vx, vy = h.x[1], h.x[3]
        slope = (dA * vx - dB * vy, T * (-s * vx - c * vy), dB * vx + dA * vy, T * (c * vx - s * vy))

        def through(m: Array, by_rate: bool) -> Array:
            px, mx, py, my, rate = m
            rows = [px + A * mx - B * my, c * mx - s * my, py + B * mx + A * my, s * mx + c * my, rate]
            if by_rate:
                rows[:4] = [row + g * rate for row, g in zip(rows, slope, strict=False)]
            return np.stack(rows)

        P = through(through(h.P, True).swapaxes(0, 1), True)
        noise = piecewise_noise(self.process_noise_sd, T)[..., None, None]
        P[:2, :2] += noise
        P[2:4, 2:4] += noise
        return replace(h, x=through(h.x, False), P=P)


Prior = RandomAccelerations | RandomTurns


# which prior judges which scenario; lee-2003's fixed manoeuvres: by one that believes in random ones
PRIORS: dict[str, Prior] = {
    "lee-2003": RandomAccelerations(),
    "random-accelerations": RandomAccelerations(),
    "random-turns": RandomTurns(),
}
