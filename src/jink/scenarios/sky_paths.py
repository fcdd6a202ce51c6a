"""The truth of whole skies: of each scan the ids (n,) and states (n, 4) x, vx, y, vy in m and m/s."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..checks import Array

Rng = np.random.Generator
Truth = list[tuple[NDArray[np.int64], Array]]
SIDE = 4e5  # m, of the regional square


def _straight(T: float) -> Array:
    return np.asarray(np.kron(np.eye(2), np.array([[1.0, T], [0.0, 1.0]])), float)


def _noise(q: float, T: float) -> Array:
    """Cholesky factor of white acceleration noise over T."""
    white = np.asarray(np.kron(np.eye(2), np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])), float)
    return np.asarray(np.linalg.cholesky(q * white), float)


def turned(x: Array, rate: Array | float, T: float) -> Array:
    """States (n, 4) after T seconds at turn rates (n,) rad/s, anticlockwise; exact."""
    w = np.broadcast_to(np.asarray(rate, float), len(x))
    angle = w * T
    # sin(wT)/w and (1 − cos(wT))/w without a division by zero
    along = T * np.sinc(angle / np.pi)
    across = T * np.sin(angle / 2) * np.sinc(angle / 2 / np.pi)
    s, c, (px, vx, py, vy) = np.sin(angle), np.cos(angle), x.T
    return np.column_stack(
        [px + along * vx - across * vy, c * vx - s * vy, py + across * vx + along * vy, s * vx + c * vy]
    )


def crossing(rng: Rng) -> Truth:
    """Two targets with white noise of 0.005 m²/s³ cross after ten scans of 1 s."""
    x, F, L = np.array([[0.0, 1, 0, 1], [0, 1, 20, -1]]), _straight(1.0), _noise(0.005, 1.0)
    truth: Truth = [(np.arange(2), x)]
    for _ in range(20):
        x = x @ F.T + rng.standard_normal((2, 4)) @ L.T
        truth.append((np.arange(2), x))
    return truth


def four(rng: Rng) -> Truth:
    """Four targets drawn about (150, 150) m at scan 41 of 81 and followed both ways; the first ends at scan 41."""
    F, L, half = _straight(1.0), _noise(0.02, 1.0), 40
    back = np.linalg.inv(F)
    x = np.zeros((2 * half + 1, 4, 4))
    x[half] = np.array([150.0, 0, 150, 0]) + np.sqrt(0.1) * rng.standard_normal((4, 4))
    for k in range(1, half + 1):
        x[half + k] = x[half + k - 1] @ F.T + rng.standard_normal((4, 4)) @ L.T
        x[half - k] = (x[half - k + 1] + rng.standard_normal((4, 4)) @ L.T) @ back.T
    return [(np.arange(4), s) if k < half else (np.arange(1, 4), s[1:]) for k, s in enumerate(x)]


def parallel(distance: float) -> Callable[[Rng], Truth]:
    """Two aircraft at 200 m/s close in on each other to a distance, fly side by side for 100 s and turn away."""

    def paths(rng: Rng) -> Truth:
        truth: Truth = []
        x = np.zeros((2, 4))
        for t in 4.0 * np.arange(80):
            if t <= 260:
                phase = np.pi * t / 160
                off = distance / 2 + (1000 * (1 + np.cos(phase)) if t < 160 else 0.0)
                rate = -1000 * np.pi / 160 * np.sin(phase) if t < 160 else 0.0
                along = 2000 + 200 * t
                x = np.array([[along, 200, 15000 + off, rate], [along, 200, 15000 - off, -rate]])
            else:
                turning = np.clip(290 - (t - 4), 0.0, 4.0)
                w = np.radians(1.5) * np.array([1.0, -1.0])
                x = turned(turned(x, w, turning), 0.0, 4.0 - turning)
            truth.append((np.arange(2), x))
        return truth

    return paths


def dense(rng: Rng) -> Truth:
    """One aircraft at 150 m/s: a minute straight, half a turn at 3°/s, a minute straight, half a turn back."""
    truth: Truth = []
    x = np.array([[4000.0, 150, 3000, 0]])
    for t in 4.0 * np.arange(60):
        truth.append((np.arange(1), x))
        rate = np.radians(3.0) * (float(60 <= t < 120) - float(180 <= t < 240))
        x = turned(x, rate, 4.0)
    return truth


def regional(count: int, interval: float, scans: int) -> Callable[[Rng], Truth]:
    """Aircraft at 120 to 250 m/s, straight for a mean of 120 s, then 1 to 3°/s either way for 15 to 60 s, and so on.

    Who leaves the square is replaced by a new one anywhere in it.
    """

    def paths(rng: Rng) -> Truth:
        def fresh(n: int) -> Array:
            speed, heading = rng.uniform(120, 250, n), rng.uniform(0, 2 * np.pi, n)
            place = rng.uniform(0, SIDE, (2, n))
            return np.column_stack([place[0], speed * np.cos(heading), place[1], speed * np.sin(heading)])

        x, ids, following = fresh(count), np.arange(count), count
        rate, left = np.zeros(count), rng.exponential(120, count)
        truth: Truth = [(ids.copy(), x.copy())]
        for second in range(1, int(interval) * (scans - 1) + 1):
            x = turned(x, rate, 1.0)
            left -= 1
            straight, turning = (left <= 0) & (rate != 0), (left <= 0) & (rate == 0)
            rate[straight], left[straight] = 0.0, rng.exponential(120, straight.sum())
            n = turning.sum()
            rate[turning] = np.radians(rng.uniform(1, 3, n)) * rng.choice([-1, 1], n)
            left[turning] = rng.uniform(15, 60, n)
            gone = ((x[:, [0, 2]] < 0) | (x[:, [0, 2]] > SIDE)).any(axis=1)
            if n := int(gone.sum()):
                x[gone], rate[gone], left[gone] = fresh(n), 0.0, rng.exponential(120, n)
                ids[gone] = np.arange(following, following + n)
                following += n
            if second % int(interval) == 0:
                truth.append((ids.copy(), x.copy()))
        return truth

    return paths
