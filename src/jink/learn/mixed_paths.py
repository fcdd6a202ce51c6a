"""Targets of all kinds, for training that is not to memorise a few paths."""

from __future__ import annotations

from math import pi

import numpy as np

from ..checks import Array
from ..metrics.draws import Draws
from ..models.sensor import Position
from ..scenarios import Observation, Scenario, Schedule
from ..scenarios.legs import Legs

SPEED, ACCELERATION, RATE = 250.0, 90.0, pi / 5  # m/s, m/s², rad/s: as far as choi-2001's targets go


def broad(scans: int = 20, sd: float = 1.0) -> Scenario:
    """Lines, circles, circles that become lines with a jump of the velocity, and bursts of acceleration, a quarter
    each.

    Speed, course, radius, rate and time of the changes are uniform; directions are too, so none of choi-2001's paths is
    among them but by chance.
    """

    def truth(draws: Draws) -> Legs:
        B = len(draws)
        kind = draws.runs % 4
        rate = np.zeros((B, scans))
        command, jump = np.zeros((2, B, scans, 2))
        turning = draws.sign() * draws.uniform(0.1 * RATE, RATE)
        change = np.floor(draws.uniform(5, 15))
        before = np.arange(scans) < change[:, None]
        rate[kind == 1] = turning[kind == 1, None]
        rate[kind == 2] = np.where(before, turning[:, None], 0.0)[kind == 2]
        velocity = _directed(draws, draws.uniform(0, SPEED))
        jumping = _directed(draws, draws.uniform(0, 1.5 * SPEED))
        at = (np.arange(scans) == change[:, None]) & (kind == 2)[:, None]
        jump[at] = jumping[kind == 2]
        command[kind == 3] = _bursts(draws, scans)[kind == 3]
        start = np.broadcast_to(np.arange(scans, dtype=float), (1, scans))
        return Legs(start, np.zeros((1, 2)), velocity, command, turn_rate=rate, velocity_step=jump)

    return Scenario(
        name="broad",
        summary="lines, circles, circles that become lines, bursts",
        truth=truth,
        axes=2,
        kind="fighter",
        observation=Observation(sensor=Position(sd=sd, axes=2)),
        schedule=Schedule(start=1.0, interval=1.0, count=scans),
    )


def _directed(draws: Draws, length: Array) -> Array:
    course = draws.uniform(-pi, pi)
    return length[:, None] * np.column_stack([np.cos(course), np.sin(course)])


def _bursts(draws: Draws, scans: int) -> Array:
    """Accelerations (B, scans, 2) that last 1 to 4 scans, with quiet stretches of 1 to 5 between."""
    B = len(draws)
    out, now = np.zeros((B, scans, 2)), np.floor(draws.uniform(1, 6))
    for _ in range(scans // 2):
        last = np.floor(draws.uniform(1, 5))
        size = _directed(draws, draws.uniform(0.1 * ACCELERATION, ACCELERATION))
        inside = (np.arange(scans) >= now[:, None]) & (np.arange(scans) < (now + last)[:, None])
        out = np.where(inside[..., None], size[:, None, :], out)
        now = now + last + np.floor(draws.uniform(1, 6))
    return out
