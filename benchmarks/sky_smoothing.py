"""What smoothing finished tracks is worth on whole skies: with the plots' marginals, or with the assigned plots alone.

python -m benchmarks.sky_smoothing [--runs N] [--seed S] [--only SKY ...]
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

from jink.association.batch import Found, Scans, track_scans
from jink.association.smoothing import Taken, smoothed
from jink.metrics.figure import Figure, spread
from jink.metrics.sets import gospa
from jink.scenarios.skies import SKIES, Sky, SkyRun

from .sky_measures import tracker_of
from .sky_rows import Row

SKIES_OF_IT = ("sky-four", "sky-parallel", "sky-parallel-200", "sky-dense", "sky-denser", "sky-regional")
WAYS = ("filtered", "assigned plots", "marginals")


def scans_of(run: SkyRun) -> Scans:
    """All plots of a run."""
    begin = np.r_[0, np.cumsum([len(scan.z) for scan in run.scans])]
    return Scans(np.array([scan.time for scan in run.scans]), begin, np.vstack([scan.z for scan in run.scans]))


def assigned(found: Found) -> Found:
    """The likeliest plot of each row, for sure."""
    assert found.taken is not None
    begin = np.r_[0, np.cumsum(found.plot >= 0)].astype(np.int64)
    plot = found.plot[found.plot >= 0]
    return replace(found, taken=Taken(begin, plot, np.ones(len(plot)), found.taken.spread))


def of_run(sky: Sky, run: SkyRun) -> list[tuple[float, float]]:
    """Mean square of position errors of matched confirmed tracks, and mean GOSPA², of each way."""
    tracker: Any = tracker_of(sky, Row(sky.name, sky.name, 1))
    scans = scans_of(run)
    found = track_scans(tracker, scans, keep=True)
    ways = (found, smoothed(tracker, scans, assigned(found)), smoothed(tracker, scans, found))
    return [_errors(sky, run, each) for each in ways]


def _errors(sky: Sky, run: SkyRun, found: Found) -> tuple[float, float]:
    points = np.column_stack([found.estimate["px"], found.estimate["py"]])
    squares, values = [], []
    for k, truth in enumerate(run.truth):
        here = points[(found.scan == k) & found.confirmed]
        match = gospa(truth.points, here, sky.cutoff)
        values.append(match.value**2)
        pairs = match.pairs
        squares += list(((truth.points[pairs.truth] - here[pairs.estimate]) ** 2).sum(axis=1))
    return float(np.mean(squares)), float(np.mean(values))


def main() -> None:
    """Print a line for each sky."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--only", nargs="*", default=SKIES_OF_IT)
    given = parser.parse_args()
    print("root mean square position error of matched tracks (m), and GOSPA (m); ± standard error over runs")
    for name in given.only:
        sky = SKIES[name]
        runs = max(2, given.runs // 5) if "regional" in name else given.runs
        all_runs = np.array([of_run(sky, run) for run in sky.runs(runs, given.seed)])
        said = []
        for k, way in enumerate(WAYS):
            error, value = (_root(all_runs[:, k, c]) for c in (0, 1))
            said.append(f"{way} {error.value:.4g} ± {error.se:.2g}, {value.value:.4g} ± {value.se:.2g}")
        print(f"{name}: " + "; ".join(said), flush=True)


def _root(squares: np.ndarray) -> Figure:
    value = float(np.sqrt(squares.mean()))
    return Figure(value, spread(squares) / (2 * value))


if __name__ == "__main__":
    main()
