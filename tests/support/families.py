"""Truth and measurements of the three families the references are judged on, in plain NumPy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
T = 1.0


@dataclass
class Runs:
    """All (runs, scans, 2); input is the known acceleration since the scan before."""

    position: Array
    velocity: Array
    measured: Array
    input: Array
    sd: float


def _move(start: Array, input_: Array, sd: float, noise_sd: float, rng: np.random.Generator) -> Runs:
    """p' = p + T v + T²/2 (u + w), v' = v + T (u + w), w of sd 1 m/s² (noise_sd), z = p + sd."""
    runs, scans, axes = input_.shape
    position, velocity = np.empty((runs, scans, axes)), np.empty((runs, scans, axes))
    position[:, 0], velocity[:, 0] = start[:2], start[2:]
    noise = noise_sd * rng.standard_normal((runs, scans, axes))
    for k in range(1, scans):
        total = input_[:, k] + noise[:, k]
        position[:, k] = position[:, k - 1] + T * velocity[:, k - 1] + T * T / 2 * total
        velocity[:, k] = velocity[:, k - 1] + T * total
    measured = position + sd * rng.standard_normal(position.shape)
    return Runs(position, velocity, measured, input_, sd)


LEE_START = np.array([22.4e3, 22.4e3, 15.0, 15.0]) / np.sqrt(2)


def lee(runs: int, seed: int, scans: int = 180) -> Runs:
    """F1: the fixed manoeuvres of Lee et al. 2003."""
    u = np.zeros((scans + 1, 2))
    u[40:61, 0], u[80:91, 1], u[120:141, 0] = 10.0, 60.0, -30.0
    every = np.broadcast_to(u[:scans], (runs, scans, 2)).copy()
    return _move(LEE_START, every, 500.0, 1.0, np.random.default_rng(seed))


def random_accelerations(runs: int, seed: int, scans: int = 180) -> Runs:
    """F2: per axis quiet for 40 s on average, then a constant acceleration in ±100 m/s² for 15 s."""
    rng = np.random.default_rng(seed)
    u = np.zeros((runs, scans, 2))
    level, busy = np.zeros((runs, 2)), np.zeros((runs, 2), bool)
    for k in range(1, scans):
        change = rng.random((runs, 2)) < np.where(busy, 1 / 15, 1 / 40)
        busy = busy ^ change
        level = np.where(busy, np.where(change, rng.uniform(-100, 100, (runs, 2)), level), 0.0)
        u[:, k] = level
    return _move(LEE_START, u, 500.0, 1.0, rng)


def random_turns(runs: int, seed: int, scans: int = 180) -> tuple[Runs, Array]:
    """F3: 250 m/s, straight for 40 s on average, then ±(1…6)°/s for 15 s; also the rates (runs, scans)."""
    rng = np.random.default_rng(seed)
    course = rng.uniform(0, 2 * np.pi, runs)
    position, velocity = np.zeros((runs, scans, 2)), np.empty((runs, scans, 2))
    velocity[:, 0] = 250 * np.stack([np.cos(course), np.sin(course)], -1)
    rate, busy, rates = np.zeros(runs), np.zeros(runs, bool), np.zeros((runs, scans))
    for k in range(1, scans):
        change = rng.random(runs) < np.where(busy, 1 / 15, 1 / 40)
        busy = busy ^ change
        fresh = np.deg2rad(rng.uniform(1, 6, runs)) * rng.choice([-1, 1], runs)
        rate = np.where(busy, np.where(change, fresh, rate), 0.0)
        position[:, k], velocity[:, k] = _turn(position[:, k - 1], velocity[:, k - 1], rate)
        w = rng.standard_normal((runs, 2))
        position[:, k] += T * T / 2 * w
        velocity[:, k] += T * w
        rates[:, k] = rate
    measured = position + 50.0 * rng.standard_normal(position.shape)
    return Runs(position, velocity, measured, np.zeros_like(position), 50.0), rates


def _turn(p: Array, v: Array, rate: Array) -> tuple[Array, Array]:
    half = rate * T / 2
    return p + T * np.sinc(half / np.pi)[:, None] * _rotate(v, half), _rotate(v, 2 * half)


def _rotate(v: Array, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]], -1)
