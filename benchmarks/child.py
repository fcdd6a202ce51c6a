"""One measurement in a process of its own: `python -m benchmarks.child TASK --size quick` prints JSON."""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import peers, race, reference
from .cases import Case, regular
from .peers import many


@dataclass(frozen=True)
class Size:
    """How much is run: tracks × scans for jink, fewer for slower libraries; rounds of every race."""

    tracks: int
    scans: int
    repetitions: int
    slow_tracks: int = 10  # libraries that take some 100 µs per update
    some_tracks: int = 1000  # of filters that are only compared with one another
    array_tracks: int = 2000  # libraries that work through NumPy arrays: their fastest batch
    training: float = 1.0  # share of every training's steps


FULL = Size(tracks=10_000, scans=200, repetitions=5)
QUICK = Size(tracks=10_000, scans=50, repetitions=3, slow_tracks=4, some_tracks=400, array_tracks=500, training=0.1)
TINY = Size(tracks=3, scans=5, repetitions=1, slow_tracks=1, some_tracks=3, array_tracks=2, training=0.01)
SIZES = {"full": FULL, "quick": QUICK, "tiny": TINY}
ARRAYS = {"simdkalman", "kalbee"}
COMPILED = {"dynamax"}


def run_engine(size: Size) -> dict[str, Any]:
    """jink's own jobs against one another: seconds per update, by job."""
    from . import engine

    laps = race.run_race(engine.jobs(size.tracks, size.scans), size.repetitions)
    return {name: lap.costs for name, lap in laps.items()}


def run_adaptive(size: Size) -> dict[str, Any]:
    """The adaptive filters and the plain ones they are held against: seconds per update, by job."""
    from . import adaptive

    laps = race.run_race(adaptive.jobs(size.some_tracks, size.scans), size.repetitions)
    return {name: lap.costs for name, lap in laps.items()}


def run_gradients(size: Size) -> dict[str, Any]:
    """The log-likelihood with and without its derivatives: seconds per update, by job."""
    from . import gradients

    tracks, scans = (gradients.TRACKS, gradients.SCANS) if size is not TINY else (size.tracks, size.scans)
    laps = race.run_race(gradients.jobs(tracks, scans), 3 * size.repetitions)
    return {name: lap.costs for name, lap in laps.items()}


def run_ratios(size: Size) -> dict[str, Any]:
    """Ratios that have limits: costs of both jobs of each."""
    from . import ratios

    if size is TINY:
        return {"ratios": ratios.measure(size.repetitions, size.tracks, size.scans)}
    return {"ratios": ratios.measure(size.repetitions + 2)}


def run_structure(size: Size) -> dict[str, Any]:
    """Variable structures against all forty modes: seconds per update, and position RMSE with its standard error."""
    from . import structure

    laps = race.run_race(structure.jobs(size.some_tracks // 5 or 1, size.scans), size.repetitions)
    rms = structure.accuracy(size.some_tracks, size.scans, size.some_tracks)
    return {"costs": {name: lap.costs for name, lap in laps.items()}, "rms": rms}


def run_learning(size: Size) -> dict[str, Any]:
    """Trainings: seconds by the wall clock and of processor time, by name."""
    from . import learning

    return learning.measure(size.training, 1 if size.training < 1 else 3)


def run_peers(size: Size, keys: tuple[str, ...] = peers.PEERS) -> dict[str, Any]:
    """jink against each peer: job → library → costs and difference from the textbook, or why not."""
    from . import engine

    modules = {key: peers.load(key) for key in keys}
    cases = {"kalman": regular(size.tracks, size.scans), "imm": regular(size.tracks, size.scans)}
    cases["live"] = regular(1, 10 * size.scans)
    out: dict[str, Any] = {"versions": {key: version for key, (_, version) in modules.items()}}
    for name in peers.JOBS:
        out[name] = _race_peers(name, cases[name], getattr(engine, name), modules, size)
    return out


def run_skies(size: Size) -> dict[str, Any]:
    """Trackers of many targets on whole skies: sky → library → GOSPA and milliseconds per scan, and versions."""
    from . import sky_race

    tiny = size is TINY
    skies = list(sky_race.SKIES_OF_RACE)[: 1 if tiny else None]
    names = [] if tiny else list(many.PEERS)
    seconds = sky_race.SECONDS if size is FULL else 5.0
    results, versions = sky_race.measure(skies, names, 17, size is not FULL, seconds)
    return {"skies": results, "versions": versions}


def run_doppler(size: Size) -> dict[str, Any]:
    """The Optimized Kalman Filter's simulated radar: setting → filter → errors, training and time per update."""
    from . import doppler

    tiny = size is TINY
    return doppler.measure(list(doppler.SETTINGS)[: 1 if tiny else None], 0, size.training)


def run_fresh(size: Size) -> dict[str, Any]:
    """The first row with every output, where the results' memory comes fresh from the system each time."""
    from . import engine

    jobs = {"imm, every output": engine.imm(regular(size.tracks, size.scans), engine.EVERYTHING)}
    return {name: lap.costs for name, lap in race.run_race(jobs, size.repetitions).items()}


def run_threads(size: Size) -> dict[str, Any]:
    """The first row on one and on two threads, by the wall clock and on all cores."""
    from . import engine

    case = regular(size.tracks, size.scans)
    jobs = {str(threads): engine.imm(case, threads=threads) for threads in (1, 2)}
    return {name: lap.costs for name, lap in race.run_race(jobs, 8 * size.repetitions, time.perf_counter).items()}


def run_memory(size: Size, outputs: str) -> dict[str, Any]:
    """Peak memory of one batch call: bytes that came in, that went out, and by how much the process grew."""
    from . import engine

    chosen = getattr(engine, outputs)
    case = _cheap_case(size.tracks, size.scans)
    small = case.first(min(8, size.tracks))
    engine.imm(small, chosen).run(None)
    estimator = engine._imm()
    before = _resident_bytes()
    estimate = estimator.filter(case.time, case.z, offsets=case.offsets, threads=1, outputs=chosen)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    produced = sum(np.asarray(getattr(estimate, name)).nbytes for name in chosen)
    return {
        "in": case.time.nbytes + case.z.nbytes + case.offsets.nbytes,
        "out": produced,
        "grown": peak - before,
    }


def _race_peers(name: str, case: Case, ours: Any, modules: dict[str, Any], size: Size) -> dict[str, Any]:
    jobs = {"jink": ours(case)}
    out: dict[str, Any] = {"jink": {"difference": _check(name, case, ours), "note": ""}}
    for key, (module, version) in modules.items():
        if module is None:
            out[key] = {"missing": version}
        elif name in module.CANNOT:
            out[key] = {"cannot": module.CANNOT[name]}
        else:
            make = getattr(module, name)
            try:
                jobs[key] = make(_cut(case, name, key, size))
                out[key] = {"difference": _check(name, case, make), "note": jobs[key].note}
            except Exception as error:
                jobs.pop(key, None)
                out[key] = {"cannot": f"{type(error).__name__}: {error}"}
    for key, lap in race.run_race(jobs, size.repetitions).items():
        out[key]["costs"] = lap.costs
    return out


def _cut(case: Case, name: str, key: str, size: Size) -> Case:
    """The part of the case a peer gets: per-update costs are compared, slow libraries get fewer tracks."""
    if name == "live":
        return case.first(1, min(case.scans, 2 * size.scans))
    if key in COMPILED:
        return case
    return case.first(min(case.tracks, size.array_tracks if name == "kalman" and key in ARRAYS else size.slow_tracks))


def _check(name: str, case: Case, make: Any) -> float:
    """Difference of a library's states from the textbook filter's, on the first two tracks."""
    small = case.first(1 if name == "live" else min(2, case.tracks), min(case.scans, 100))
    expected = reference.kalman(small) if name == "kalman" else reference.imm(small)[0]
    job = make(small)
    return race.difference(job.run(job.prepare()), expected[0, -1] if name == "live" else expected)


def _cheap_case(tracks: int, scans: int) -> Case:
    """A case whose making leaves no peak of memory behind it: positions are noise alone."""
    case = regular(1, scans)
    generator = np.random.default_rng(0)
    z = generator.standard_normal((tracks * scans, 2))
    time = np.empty(tracks * scans)
    time.reshape(tracks, scans)[:] = case.time
    offsets = np.arange(tracks + 1, dtype=np.int64) * scans
    return replace(case, tracks=tracks, time=time, z=z, offsets=offsets, x0=np.zeros((tracks, 4)))


def _resident_bytes() -> int:
    statm = Path("/proc/self/statm")
    if not statm.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(statm.read_text().split()[1]) * resource.getpagesize()


def main(arguments: list[str] | None = None) -> int:
    """Run one task and print its result as one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "task",
        choices=[
            "engine",
            "adaptive",
            "structure",
            "learning",
            "gradients",
            "ratios",
            "peers",
            "skies",
            "doppler",
            "fresh",
            "threads",
            "memory",
        ],
    )
    parser.add_argument("--size", choices=SIZES, default="full")
    parser.add_argument("--outputs", choices=["STATES", "EVERYTHING"], default="STATES")
    options = parser.parse_args(arguments)
    size = SIZES[options.size]
    if options.task not in ("threads", "memory", "learning"):
        race.pin_to_one_core()
    if options.task == "memory":
        result = run_memory(size, options.outputs)
    else:
        tasks = {
            "engine": run_engine,
            "adaptive": run_adaptive,
            "structure": run_structure,
            "gradients": run_gradients,
            "ratios": run_ratios,
            "peers": run_peers,
            "skies": run_skies,
            "doppler": run_doppler,
            "fresh": run_fresh,
            "threads": run_threads,
            "learning": run_learning,
        }
        result = tasks[options.task](size)
    print(json.dumps(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
