"""Fair timing: one process, one core, interleaved repetitions, process CPU time, medians."""

from __future__ import annotations

import gc
import os
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Job:
    """Work to be timed.

    prepare: makes a fresh filter (not timed); run: does the job with it (timed) and returns the states,
    shape (B, S, 4), or the last state (4,); updates: track-updates in one run; note: how
    the job differs, if it does.
    """

    run: Callable[[Any], Any]
    updates: int
    prepare: Callable[[], Any] = lambda: None
    note: str = ""


@dataclass(frozen=True)
class Lap:
    """Seconds per update of one job, one value per repetition."""

    costs: tuple[float, ...]

    @property
    def median(self) -> float:
        """Median cost, s."""
        return statistics.median(self.costs)


@dataclass(frozen=True)
class Ratio:
    """How many times dearer one job was than another, from the repetitions they ran side by side in."""

    median: float
    low: float
    high: float


def pin_to_one_core() -> None:
    """Keep this process, and what it starts, on one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def run_race(
    jobs: Mapping[str, Job], repetitions: int, clock: Callable[[], float] = time.process_time
) -> dict[str, Lap]:
    """Warm every job up, then time `repetitions` rounds of all of them, each starting with another one."""
    for job in jobs.values():
        job.run(job.prepare())
    costs: dict[str, list[float]] = {name: [] for name in jobs}
    names = list(jobs)
    gc.collect()
    gc.disable()
    try:
        for round_ in range(repetitions):
            first = round_ % len(names)
            for name in names[first:] + names[:first]:
                costs[name].append(_time(jobs[name], clock))
    finally:
        gc.enable()
    return {name: Lap(tuple(values)) for name, values in costs.items()}


def compare(slow: Lap, fast: Lap) -> Ratio:
    """The ratio slow/fast round by round: median, least and most."""
    ratios = [a / b for a, b in zip(slow.costs, fast.costs, strict=True)]
    return Ratio(statistics.median(ratios), min(ratios), max(ratios))


def difference(states: Any, reference: np.ndarray) -> float:
    """Largest difference of states, relative to the largest value of that component over the track."""
    states = np.asarray(states, dtype=float)
    scale = np.abs(reference).max(axis=-2, keepdims=True) if reference.ndim > 1 else np.abs(reference)
    return float((np.abs(states - reference) / scale).max())


def _time(job: Job, clock: Callable[[], float]) -> float:
    prepared = job.prepare()
    begin = clock()
    result = job.run(prepared)
    cost = (clock() - begin) / job.updates
    del result
    return cost
