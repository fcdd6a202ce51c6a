"""A scenario: truth as a function of continuous time, a sensor and a scan schedule."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from ..checks import Array, unknown
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import Position, Sensor
from .legs import Legs
from .sensing import RADARS, Observation, Schedule
from .truth import Kinematics, Truth

CHUNK_ROWS = 200_000  # scans that are simulated at once: bounds the memory of large Monte Carlo experiments


class Rows(TypedDict):
    """What ``filter(**rows)`` takes: time (N,) s, z (N, m), offsets (B + 1,) of the runs."""

    time: Array
    z: Array
    offsets: NDArray[np.int64]


@frozen(kw_only=True)
class Simulation:
    """Some runs of a scenario: run b, scan s.

    runs (B,) their numbers; time (B, S) s; z (B, S, m) measurements, NaN where missed; truth (B, S, axes)
    each; input (B, S, axes) commanded acceleration and turn_rate (B, S) since the scan before, where the
    truth has such (else None).
    """

    scenario: Scenario
    seed: int
    runs: np.ndarray
    time: Array
    z: Array
    truth: Kinematics
    input: Array | None = None
    turn_rate: Array | None = None

    def batch(self) -> Rows:
        """time, z and offsets for ``filter(**simulation.batch())``: all runs laid end to end."""
        B, S, m = self.z.shape
        return {"time": self.time.reshape(-1), "z": self.z.reshape(-1, m), "offsets": np.arange(B + 1) * S}


@frozen(kw_only=True)
class Scenario:
    """truth(draws) is the motion of the runs of draws; observation and schedule say how it is seen.

    axes of the truth; kind for `jink track`; source, where the scenario comes from; acceleration (m/s²): the most that
    its source assumes the targets to pull, None where it does not say.
    """

    name: str
    summary: str
    truth: Callable[[Draws], Truth]
    observation: Observation
    schedule: Schedule
    axes: int = 2
    kind: str = "aircraft"
    source: str = ""
    acceleration: float | None = None

    def simulate(self, runs: int | Sequence[int] | np.ndarray = 1, seed: int = 0) -> Simulation:
        """Runs 0 … runs − 1, or those with the given numbers; a run is the same in whatever company.

        Errors: ValueError for no runs or a negative seed.
        """
        numbers = _numbers(runs)
        truth = self.truth(Draws(seed, numbers, "truth"))
        time = self.schedule.times(Draws(seed, numbers, "schedule"))
        shared = len(time) == 1 and truth.runs == 1
        own = time if shared else np.broadcast_to(time, (len(numbers), time.shape[1]))
        kinematics = _at(truth, own)
        command = truth.commanded(own) if isinstance(truth, Legs) else (None, None)
        full = kinematics.repeated(len(numbers))
        return Simulation(
            scenario=self,
            seed=int(seed),
            runs=numbers,
            time=np.ascontiguousarray(np.broadcast_to(time, (len(numbers), time.shape[1]))),
            z=self.observation.measure(full, seed, numbers),
            truth=full,
            input=_repeated(command[0], len(numbers)),
            turn_rate=_repeated(command[1], len(numbers)),
        )

    def chunks(self, runs: int, seed: int = 0, *, size: int | None = None) -> Iterator[Simulation]:
        """The same runs in pieces of `size` runs (by default some 200,000 scans), in bounded memory."""
        numbers = _numbers(runs)
        step = size or max(1, CHUNK_ROWS // self.schedule.count)
        for first in range(0, len(numbers), step):
            yield self.simulate(numbers[first : first + step], seed)

    def seen_by(
        self,
        sensor: str | float | Sensor | Observation,
        *,
        interval: float | None = None,
        jitter: float | None = None,
        detection: float | None = None,
        outlier_share: float | None = None,
        outlier_scale: float | None = None,
        bias: Sequence[float] | None = None,
    ) -> Scenario:
        """The same truth seen otherwise.

        sensor a radar's name (see RADARS), a position noise in m, a sensor of :mod:`jink.models.sensor` or an
        Observation; interval and jitter in s; detection, outlier_share, outlier_scale and bias of the observation.
        """
        observation, usual, usual_jitter = self._observation(sensor)
        schedule = self.schedule
        if interval is not None:
            schedule = schedule.every(interval)
        elif usual is not None:
            schedule = schedule.every(usual, usual_jitter)
        if jitter is not None:
            schedule = replace(schedule, jitter=jitter)
        told = {
            "detection": detection,
            "outlier_share": outlier_share,
            "outlier_scale": outlier_scale,
            "bias": bias,
        }
        changes = {name: value for name, value in told.items() if value is not None}
        return replace(self, observation=replace(observation, **changes), schedule=schedule)

    def _observation(self, sensor: str | float | Sensor | Observation) -> tuple[Observation, float | None, float]:
        if isinstance(sensor, Observation):
            return sensor, None, 0.0
        if isinstance(sensor, str):
            if sensor not in RADARS:
                raise ValueError(unknown("sensor", sensor, RADARS))
            return RADARS[sensor]
        if isinstance(sensor, int | float):
            return Observation(sensor=Position(sd=float(sensor), axes=self.axes)), None, 0.0
        return Observation(sensor=sensor), None, 0.0


def _numbers(runs: int | Sequence[int] | np.ndarray) -> np.ndarray:
    if isinstance(runs, int | np.integer):
        if not 1 <= runs < 2**40:
            raise ValueError(f"runs: expected at least 1, got {runs}")
        return np.arange(int(runs))
    try:
        numbers = np.asarray(runs, dtype=np.int64)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"runs: expected a number of runs, or the numbers of some, got {runs!r}") from None
    if numbers.ndim != 1 or numbers.size == 0:
        raise ValueError(f"runs: expected a number of at least 1, or the numbers of some runs, got {runs!r}")
    return numbers


def _at(truth: Truth, time: Array) -> Kinematics:
    """A truth that all runs share is asked once for all their times."""
    if truth.runs > 1 or len(time) == 1:
        return truth.at(time)
    found = truth.at(time.reshape(1, -1))
    return Kinematics(*(a.reshape(*time.shape, -1) for a in found))


def _repeated(array: Array | None, runs: int) -> Array | None:
    return None if array is None else np.broadcast_to(array, (runs, *array.shape[1:]))
