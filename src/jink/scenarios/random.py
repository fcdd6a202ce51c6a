"""Families with random parameters in every run, switching at whole seconds, with process noise.

Quiet times and manoeuvres alternate, both of geometric length, the quiet one first; within a second
acceleration and turn rate are constant, so the truth is exact between scans too.
"""

from __future__ import annotations

from math import radians, sqrt

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import Position
from .legs import Legs
from .scenario import Scenario
from .sensing import Observation, Schedule
from .truth import find, rows_of


@frozen(kw_only=True)
class RandomAccelerations:
    """On each of two axes by itself: quiet, then a constant acceleration uniform in ± acceleration, …

    quiet_mean, manoeuvre_mean (s) of the geometric lengths; acceleration, noise_sd (m/s², process noise,
    constant over a second); headings: the axes are turned by an angle of its own for every run. Starts as
    lee-2003 does.
    """

    quiet_mean: float = 40.0
    manoeuvre_mean: float = 15.0
    acceleration: float = 100.0
    noise_sd: float = 1.0
    duration: int = 180
    headings: bool = False

    def __call__(self, draws: Draws) -> Legs:
        phase = _phases(draws, self.quiet_mean, self.manoeuvre_mean, self.duration, 2)
        levels = draws.uniform(-self.acceleration, self.acceleration, 2, self.duration // 2 + 1)
        noise = self.noise_sd * draws.normal(self.duration, 2)
        command = np.swapaxes(_of_phase(levels, phase), 1, 2)
        if self.headings:
            angle = draws.uniform(0.0, 2 * np.pi)[:, None]
            c, s, (x, y) = np.cos(angle), np.sin(angle), (command[..., 0], command[..., 1])
            command = np.stack([c * x - s * y, s * x + c * y], axis=-1)
        start = np.full((1, 2), 22400.0 * sqrt(0.5)), np.full((1, 2), 15.0 * sqrt(0.5))
        return Legs(np.arange(float(self.duration))[None, :], *start, command, noise=noise)


@frozen(kw_only=True)
class RandomTurns:
    """Straight legs and coordinated turns alternate; the turn rate is uniform in ± slowest … fastest (rad/s).

    speed (m/s) at a random heading; straight_mean, turn_mean (s) of the geometric lengths; noise_sd (m/s²)
    process noise, constant over a second. climb_rate > 0: every other leg or so climbs or descends at a rate
    uniform in ± climb_rate (m/s), which it reaches with vertical_acceleration (m/s²).
    """

    speed: float = 250.0
    straight_mean: float = 40.0
    turn_mean: float = 15.0
    slowest: float = radians(1.0)
    fastest: float = radians(6.0)
    noise_sd: float = 1.0
    duration: int = 180
    climb_rate: float = 0.0
    vertical_acceleration: float = 3.0

    def __call__(self, draws: Draws) -> Legs:
        axes, turns = 3 if self.climb_rate else 2, self.duration // 2 + 1
        phase = _phases(draws, self.straight_mean, self.turn_mean, self.duration, 1)
        rate = draws.sign(1, turns) * draws.uniform(self.slowest, self.fastest, 1, turns)
        heading = draws.uniform(0.0, 2 * np.pi)
        noise = self.noise_sd * draws.normal(self.duration, axes)
        position, velocity = np.zeros((len(draws), axes)), np.zeros((len(draws), axes))
        velocity[:, 0], velocity[:, 1] = self.speed * np.cos(heading), self.speed * np.sin(heading)
        command = np.zeros((1, self.duration, axes))
        if self.climb_rate:
            position[:, 2] = 5000.0
            command = np.broadcast_to(command, (len(draws), self.duration, axes)).copy()
            command[..., 2] = self._climbs(draws, phase[:, 0])
        seconds = np.arange(float(self.duration))[None, :]
        return Legs(seconds, position, velocity, command, noise=noise, turn_rate=_of_phase(rate, phase)[:, 0])

    def _climbs(self, draws: Draws, phase: np.ndarray) -> Array:
        """(B, K) vertical accelerations that reach each leg's climb rate."""
        rates = draws.uniform(-self.climb_rate, self.climb_rate, self.duration + 2)
        rates = np.where(draws.uniform(0, 1, self.duration + 2) < 0.5, 0.0, rates)
        wanted = np.take_along_axis(rates, phase, axis=1)
        now, out = np.zeros(len(draws)), np.empty(wanted.shape)
        for k in range(wanted.shape[1]):
            out[:, k] = np.clip(wanted[:, k] - now, -self.vertical_acceleration, self.vertical_acceleration)
            now = now + out[:, k]
        return out


def _phases(draws: Draws, quiet_mean: float, manoeuvre_mean: float, duration: int, channels: int) -> np.ndarray:
    """(B, channels, K) number of the phase that second k lies in; odd ones are manoeuvres."""
    count = duration // 2 + 1
    lengths = np.stack(
        [draws.geometric(quiet_mean, channels, count), draws.geometric(manoeuvre_mean, channels, count)],
        axis=-1,
    )
    begins = np.cumsum(lengths.reshape(len(draws) * channels, -1), axis=1)
    begins = np.concatenate([np.zeros((len(begins), 1)), begins[:, :-1]], axis=1)
    seconds = np.broadcast_to(np.arange(float(duration)), (len(begins), duration))
    if len(begins) == 1:
        return find(begins, seconds).reshape(1, 1, duration)
    return find(begins, seconds).reshape(len(draws), channels, duration)


def _of_phase(levels: Array, phase: np.ndarray) -> Array:
    """(B, channels, K) the manoeuvre's level in odd phases, 0 in even ones."""
    flat = rows_of(levels.reshape(-1, levels.shape[-1]), np.reshape(phase // 2, (-1, phase.shape[-1])))
    return np.where(phase % 2 == 1, flat.reshape(phase.shape), 0.0)


def families() -> list[Scenario]:
    """The random families that have a near-Bayes reference, and their variants."""
    second = Schedule(start=1.0, interval=1.0, count=180)

    def scenario(
        name: str, summary: str, truth: RandomAccelerations | RandomTurns, sd: float, axes: int = 2
    ) -> Scenario:
        seen = Observation(sensor=Position(sd=sd, axes=axes))
        return Scenario(
            name=name,
            summary=summary,
            truth=truth,
            observation=seen,
            schedule=second,
            axes=axes,
            kind="fighter",
            acceleration=getattr(truth, "acceleration", None),
        )

    return [
        scenario(
            "random-accelerations",
            "constant accelerations up to 10 g along the axes",
            RandomAccelerations(),
            500.0,
        ),
        scenario(
            "random-accelerations-turned",
            "the same along axes at a random heading",
            RandomAccelerations(headings=True),
            500.0,
        ),
        scenario("random-turns", "straight legs and level turns of 1–6°/s at 250 m/s", RandomTurns(), 50.0),
        scenario(
            "random-turns-climbing",
            "the same, climbing and descending",
            RandomTurns(climb_rate=25.0),
            50.0,
            axes=3,
        ),
    ]
