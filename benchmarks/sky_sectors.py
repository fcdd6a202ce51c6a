"""An antenna that turns: its plots taken turn by turn and sector by sector, on the same plots.

python -m benchmarks.sky_sectors [--runs N] [--seed S]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

import jink
from jink.association.batch import Found, Scans, Turning, track_scans
from jink.association.turns import track_turns
from jink.metrics.figure import Figure
from jink.metrics.skies import Picture, sky_figures
from jink.scenarios.skies import SKIES, Sky, SkyRun

from .sky_measures import filter_of

SKY_NAMES = ("sky-regional", "sky-regional-200-12s")
COUNTS = (1, 4, 16)
FINE = 400  # steps of a turn


class Turned(NamedTuple):
    """Plots by time, and the truth at the middle of each turn."""

    time: np.ndarray
    z: np.ndarray
    truth: list[Picture]


def turned(sky: Sky, run: SkyRun, rng: np.random.Generator) -> Turned:
    """The run's targets as an antenna in the middle of the area sees them, each when the antenna points at it.

    A target that crosses the cut between two turns is seen twice in one of them, or not at all.
    """
    period, turns = sky.interval, len(run.truth) - 1
    x0, x1, y0, y1 = sky.area
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    looks, halves = [], [([], []) for _ in range(turns)]
    for target, first, places, velocities in _paths(run):
        fine = np.arange(len(places) * FINE - FINE + 1) / FINE
        there = _between(fine, places, velocities, period) - middle
        for k in range(len(places) - 1):
            halves[first + k][0].append(target)
            halves[first + k][1].append(there[k * FINE + FINE // 2])
        turn = first + fine - np.unwrap(np.arctan2(there[:, 0], there[:, 1]) % (2 * np.pi)) / (2 * np.pi)
        seen = np.flatnonzero(np.floor(turn[1:]) > np.floor(turn[:-1])) + 1
        seen = seen[rng.random(len(seen)) < sky.detection]
        plots = there[seen] + sky.sd * rng.standard_normal((len(seen), 2))
        looks.append(np.column_stack([period * (first + fine[seen]), plots]))
    for k in range(turns):
        plots = rng.uniform([x0, y0], [x1, y1], (rng.poisson(sky.clutter), 2)) - middle
        azimuth = np.arctan2(plots[:, 0], plots[:, 1]) % (2 * np.pi)
        looks.append(np.column_stack([period * (k + azimuth / (2 * np.pi)), plots]))
    every = np.vstack(looks)
    every = every[np.argsort(every[:, 0], kind="stable")]
    truth = [Picture(np.array(ids, np.int64), np.array(points).reshape(-1, 2)) for ids, points in halves]
    return Turned(every[:, 0], every[:, 1:], truth)


def _paths(run: SkyRun) -> Iterator[tuple[int, int, np.ndarray, np.ndarray]]:
    """Of each target its id, its first scan, its places and its velocities."""
    kept: dict[int, tuple[int, list[np.ndarray], list[np.ndarray]]] = {}
    for k, (truth, velocity) in enumerate(zip(run.truth, run.velocity, strict=True)):
        for target, place, v in zip(truth.ids.tolist(), truth.points, velocity, strict=True):
            _, places, velocities = kept.setdefault(target, (k, [], []))
            places.append(place), velocities.append(v)
    for target, (first, places, velocities) in kept.items():
        yield target, first, np.array(places), np.array(velocities)


def _between(fine: np.ndarray, places: np.ndarray, velocities: np.ndarray, period: float) -> np.ndarray:
    """Hermite's cubic through places with these velocities, at times in scans."""
    k = np.minimum(fine.astype(int), max(len(places) - 2, 0))
    after = np.minimum(k + 1, len(places) - 1)
    s = (fine - k)[:, None]
    a, b, u, v = places[k], places[after], period * velocities[k], period * velocities[after]
    return (1 + 2 * s) * (1 - s) ** 2 * a + s * (1 - s) ** 2 * u + s**2 * (3 - 2 * s) * b - s**2 * (1 - s) * v


def found_in(sky: Sky, plots: Turned, sectors: int) -> tuple[Found, float]:
    """The tracks, and CPU seconds a turn."""
    x0, x1, y0, y1 = sky.area
    wide, high = (x1 - x0) / 2, (y1 - y0) / 2
    radar = jink.Radar(detection=sky.detection, clutter_per_scan=sky.false_per_scan, area=(-wide, wide, -high, high))
    tracker = jink.Tracker(
        filter_of(sky),
        radar,
        targets=sky.targets,
        new_per_hour=sky.arrivals / sky.interval * 3600,
        stay=sky.life,
        speed_sd=sky.speed_sd,
    )
    period, turns = sky.interval, len(plots.truth)
    begin = np.searchsorted(plots.time, period * np.arange(turns + 1))
    begin[-1] = len(plots.time)
    turning = Turning(period, sectors) if sectors > 1 else None
    scans = Scans(period * (np.arange(turns) + 0.5), begin, plots.z, own=plots.time, turning=turning)
    before = time.process_time()
    found = (track_turns if turning else track_scans)(tracker, scans)
    return found, (time.process_time() - before) / turns


def at_the_middle(sky: Sky, found: Found, turns: int) -> list[Picture]:
    """Confirmed tracks of each turn, each moved by its velocity to the middle of the turn; one row of each counts."""
    middle = sky.interval * (found.scan + 0.5)
    e = found.estimate
    late = (middle - found.time)[:, None]
    places = np.column_stack([e["px"], e["py"]]) + late * np.column_stack([e["vx"], e["vy"]])
    pictures = []
    for k in range(turns):
        rows = np.flatnonzero((found.scan == k) & found.confirmed)
        _, last = np.unique(found.id[rows][::-1], return_index=True)
        rows = rows[::-1][last]
        pictures.append(Picture(found.id[rows], places[rows]))
    return pictures


def _with_error(figure: Figure) -> str:
    return f"{figure.value:.4g} ± {figure.se:.2g}"


def main() -> None:
    """Print GOSPA, identity switches, held and false shares, ids a target, and times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--only", nargs="*", default=SKY_NAMES)
    given = parser.parse_args()
    print("sky, sectors: GOSPA, switches a run, held, false, ids a target, ms of CPU a turn")
    for name in given.only:
        sky = SKIES[name]
        rng = np.random.default_rng(given.seed)
        every = [turned(sky, run, rng) for run in sky.runs(given.runs, given.seed)]
        for count in COUNTS:
            found = [found_in(sky, plots, count) for plots in every]
            pictures = [at_the_middle(sky, f, len(p.truth)) for (f, _), p in zip(found, every, strict=True)]
            f = sky_figures([p.truth for p in every], pictures, sky.cutoff)
            ms = 1e3 * float(np.mean([seconds for _, seconds in found]))
            shares = f"{f.completeness:.4f}, {f.spurious:.4f}, {f.identities:.3f}"
            print(f"{name}, {count}: {_with_error(f.gospa)}, {_with_error(f.switches)}, {shares}, {ms:.3g}", flush=True)


if __name__ == "__main__":
    main()
