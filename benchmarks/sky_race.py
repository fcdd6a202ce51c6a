"""jink against other libraries' trackers on the same plots of the same skies: GOSPA, and CPU time per scan.

python -m benchmarks.sky_race [--quick] [--seed S] [--only SKY ...] [--peers NAME ...] [--seconds N] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from jink.metrics.sets import gospa
from jink.metrics.skies import Picture
from jink.scenarios.skies import SKIES, SkyRun

from . import peers
from .peers import many
from .peers.many import Live, Task
from .sky_measures import tracker_of
from .sky_rows import Row
from .table import markdown

# of each sky: runs, scans of a run, and the acceleration psd (m²/s³) that constant velocity does best with
SKIES_OF_RACE = {
    "sky-crossing": (200, 20, 0.005),
    "sky-four": (5, 81, 0.02),
    "sky-parallel-50": (5, 80, 2.0),
    "sky-parallel": (5, 80, 2.0),
    "sky-parallel-200": (5, 80, 2.0),
    "sky-dense": (4, 60, 30.0),
    "sky-denser": (4, 60, 30.0),
    "sky-regional": (2, 40, 20.0),
    "sky-regional-200-12s": (2, 40, 20.0),
}
SECONDS = 60.0  # of CPU that each library gets on each sky; what it did until then is compared
OURS, EXACT = "jink", "jink, jpda"


def ours(name: str, association: str = "marginal") -> Live:
    """jink's tracker as `benchmarks.skies` makes it."""
    sky = SKIES[name]
    tracker = tracker_of(sky, Row(name, name, 1, association=association))
    for x, variance in zip(*(sky.known or ((), ())), strict=True):
        tracker.add(0.0, x, np.diag(variance))

    def scan(t: float, plots: np.ndarray) -> Picture:
        picture = tracker.scan(t, plots)
        sure = picture.confirmed
        return Picture(picture.ids[sure], picture.positions[sure])

    return scan


def drive(make: Any, runs: list[SkyRun], scans: int, budget: float, c: float) -> tuple[dict[Any, float], list[float]]:
    """GOSPA² by run and scan, and the CPU seconds of each scan, until the budget is used up."""
    squares: dict[Any, float] = {}
    seconds: list[float] = []
    for number, run in enumerate(runs):
        scan = make()
        for k, (each, truth) in enumerate(zip(run.scans[:scans], run.truth[:scans], strict=True)):
            if sum(seconds) > budget:
                return squares, seconds
            begin = time.process_time()
            found = scan(each.time, each.z)
            seconds.append(time.process_time() - begin)
            squares[number, k] = gospa(truth.points, found.points, c).value ** 2
    return squares, seconds


def race(name: str, peers: dict[str, Any], seed: int, quick: bool, budget: float) -> dict[str, dict[str, Any]]:
    """Every library on one sky; each is compared with jink over the scans that it did within its time."""
    sky, (runs, scans, psd) = SKIES[name], SKIES_OF_RACE[name]
    made = list(sky.runs(1 if quick else runs, seed))
    task = Task(sky, psd)
    base, took = drive(lambda: ours(name), made, scans, math.inf, sky.cutoff)
    out = {OURS: {"gospa": _rms(base.values()), "ms": 1e3 * statistics.fmean(took), "scans": len(took)}}
    entrants = {EXACT: lambda: ours(name, "jpda")}
    for module in peers.values():
        entrants |= module.entrants(task)
    for label, make in entrants.items():
        squares, seconds = drive(make, made, scans, budget, sky.cutoff)
        same = _rms(base[k] for k in squares)
        beat = statistics.fmean(took[: len(seconds)])
        out[label] = {
            "gospa": _rms(squares.values()),
            "gospa ratio": _rms(squares.values()) / same,
            "ms": 1e3 * statistics.fmean(seconds),
            "time ratio": statistics.fmean(seconds) / beat,
            "scans": len(seconds),
        }
    return out


def _rms(squares: Any) -> float:
    return math.sqrt(statistics.fmean(squares))


def table_of(skies: dict[str, dict[str, dict[str, Any]]], versions: dict[str, str]) -> list[str]:
    """A Markdown table: a row per sky and library, and what jink did not win."""
    cells, lost = [], []
    for sky, found in skies.items():
        for label, f in found.items():
            ratio = "" if label == OURS else f"{f['gospa ratio']:.2f}"
            times = "" if label == OURS else f"{f['time ratio']:,.0f}"
            cells.append((sky, label, f"{f['gospa']:.4g}", ratio, f"{f['ms']:.3g}", times, str(f["scans"])))
            if label not in (OURS, EXACT) and f["gospa ratio"] <= 1.0:
                lost.append(f"MISS {sky}: {label} has the better GOSPA, {f['gospa ratio']:.3f} of jink's")
            wanted = "Stone Soup" in label and sky == "sky-regional"
            if wanted and f["time ratio"] < 1000:
                lost.append(f"MISS {sky}: {label} takes {f['time ratio']:.0f} × jink's time, wanted 1000")
    head = ("sky", "library", "GOSPA", "÷ jink's, same scans", "ms a scan", "÷ jink's, same scans", "scans")
    said = ", ".join(f"{name} {version}" for name, version in versions.items())
    return [*markdown(head, cells), "", said, "", *(lost or ["jink has the best GOSPA on every sky"])]


def measure(
    chosen: list[str],
    names: list[str],
    seed: int,
    quick: bool,
    budget: float,
    show: Callable[[str, Any], None] | None = None,
) -> tuple[Any, dict[str, str]]:
    """All chosen skies, each shown when it is done; libraries that are not installed are named with the reason."""
    loaded = {name: peers.load(name, many.__name__) for name in names}
    found = {name: module for name, (module, _) in loaded.items() if module is not None}
    results = {}
    for sky in chosen:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            results[sky] = race(sky, found, seed, quick, budget)
        if show:
            show(sky, results[sky])
    return results, {name: version for name, (_, version) in loaded.items()}


def main() -> None:
    """Race, print the table, keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one run of each sky")
    parser.add_argument("--seed", type=int, default=17)
    parser.add_argument("--only", nargs="*", choices=list(SKIES_OF_RACE), default=list(SKIES_OF_RACE))
    parser.add_argument("--peers", nargs="*", choices=many.PEERS, default=list(many.PEERS))
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of CPU for each library on each sky")
    parser.add_argument("--json")
    given = parser.parse_args()

    def show(sky: str, found: Any) -> None:
        print("\n".join(table_of({sky: found}, {})), file=sys.stderr, flush=True)

    results, versions = measure(given.only, given.peers, given.seed, given.quick, given.seconds, show)
    print("\n".join(table_of(results, versions)))
    if given.json:
        with open(given.json, "w", encoding="utf-8") as file:
            json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
