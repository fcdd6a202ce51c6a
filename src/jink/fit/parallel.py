"""Fits of several filters on the same data, some at a time, in processes of their own, each with its share of the time
left.
"""

from __future__ import annotations

import math
import os
import signal
import threading
import time as clock
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from multiprocessing import parent_process
from typing import Any

from ..filters.loading import built
from ..frozen import frozen
from ..io.own_code import loaded
from ..models.tracks import Tracks
from .objectives import Objective
from .optimise import Found, OutOfTime, Search
from .parameters import Parameters


@frozen
class Job:
    """A filter to be fitted: its name, its description, the names of the parameters that are free."""

    name: str
    body: dict[str, Any]
    free: Sequence[str]
    code: str = ""  # "file.py:name", whose module has what the description names

    def made(self) -> Any:
        """The filter of the description."""
        if self.code:
            loaded(self.code)
        return built(self.body, own=bool(self.code))


@frozen
class Outcome:
    """What was found, or why nothing was."""

    found: Found | None
    failed: str = ""


Report = Callable[[str, int, int], None]


def run_jobs(
    jobs: Sequence[Job],
    tracks: Tracks,
    objective: Objective,
    *,
    seed: int = 0,
    deadline: float = math.inf,
    workers: int = 1,
    progress: Report | None = None,
) -> tuple[dict[str, Outcome], bool]:
    """Outcomes by name, and whether it was interrupted. A job gets (time left) × workers / (jobs left); deadline on the
    monotonic clock.

    With one worker jobs run in this process. Ctrl-C ends the running fits, which keep the best so far, and begins no
    other.
    """
    if workers <= 1:
        return _one_by_one(jobs, tracks, objective, seed, deadline, progress)
    return _in_processes(jobs, tracks, objective, seed, deadline, min(workers, len(jobs)), progress)


def share(deadline: float, left: int, workers: int) -> float:
    """Seconds for the next of so many jobs."""
    return max(deadline - clock.monotonic(), 0.0) * min(workers, left) / max(left, 1)


def fitted(
    job: Job, tracks: Tracks, objective: Objective, seed: int, seconds: float, stop: Callable[[], bool]
) -> Outcome:
    """One fit from one start, ended early by ``stop``."""

    def heard(words: str, stage: int, stages: int) -> None:
        if stop():
            raise OutOfTime

    try:
        every = Parameters(job.made(), free=["*"])
        fixed = [name for name in every.names if name not in job.free]
        parameters = Parameters(job.made(), free=job.free, fixed=fixed)
        deadline = clock.monotonic() + seconds
        return Outcome(
            Search(parameters, objective, tracks, starts=1, seed=seed, deadline=deadline, report=heard).run()
        )
    except ValueError as error:
        return Outcome(None, str(error))


def _one_by_one(
    jobs: Sequence[Job],
    tracks: Tracks,
    objective: Objective,
    seed: int,
    deadline: float,
    progress: Report | None,
) -> tuple[dict[str, Outcome], bool]:
    outcomes: dict[str, Outcome] = {}
    try:
        for job in jobs:
            seconds = share(deadline, len(jobs) - len(outcomes), 1)
            if seconds <= 0.0:
                break
            outcomes[job.name] = outcome = fitted(job, tracks, objective, seed, seconds, lambda: False)
            if progress:
                progress(job.name, len(outcomes), len(jobs))
            if outcome.found is not None and outcome.found.interrupted:
                return outcomes, True
    except KeyboardInterrupt:
        return outcomes, True
    return outcomes, False


def _in_processes(
    jobs: Sequence[Job],
    tracks: Tracks,
    objective: Objective,
    seed: int,
    deadline: float,
    workers: int,
    progress: Report | None,
) -> tuple[dict[str, Outcome], bool]:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    context = get_context("spawn")  # forking a process with threads may lock it up
    stop, number = context.Event(), context.Value("i", 0)
    outcomes: dict[str, Outcome] = {}
    waiting, running, interrupted = list(jobs), {}, False
    begin = (tracks, objective, seed, stop, number, workers)
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=begin) as pool:
        while waiting or running:
            try:
                while waiting and len(running) < workers and not stop.is_set():
                    seconds = share(deadline, len(waiting) + len(running), workers)
                    if seconds <= 0.0:
                        waiting.clear()
                        break
                    running[pool.submit(_work, waiting[0], seconds)] = waiting[0].name
                    waiting.pop(0)
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    outcomes[running.pop(future)] = _result(future)
                    if progress:
                        progress(", ".join(running.values()) or "done", len(outcomes), len(jobs))
            except KeyboardInterrupt:
                stop.set()
                interrupted = True
                waiting.clear()
    order = [job.name for job in jobs if job.name in outcomes]
    return {name: outcomes[name] for name in order}, interrupted


def _result(future: Future[Outcome]) -> Outcome:
    error = future.exception()
    return Outcome(None, f"{type(error).__name__}: {error}") if error else future.result()


_given: tuple[Any, ...] = ()  # in a worker: what all jobs share


def _begin(tracks: Tracks, objective: Objective, seed: int, stop: Any, number: Any, workers: int) -> None:
    """A worker of its own cores, deaf to Ctrl-C, which the first process hears."""
    global _given
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with number.get_lock():
        mine, number.value = number.value, number.value + 1
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[mine % len(cores) :: workers] or cores)
    _given = (tracks, objective, seed, stop)


def _end_with_parent() -> None:
    """A worker whose first process was killed would wait for work for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work(job: Job, seconds: float) -> Outcome:
    tracks, objective, seed, stop = _given
    return fitted(job, tracks, objective, seed, seconds, stop.is_set)
