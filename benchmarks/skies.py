"""Many targets in clutter: GOSPA, switches and time per scan on the registered skies, against what must be reached.

python -m benchmarks.skies [--quick] [--seed S] [--only ROW ...] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import jink
from jink.metrics.sets import gospa
from jink.metrics.skies import Picture, sky_figures
from jink.models.radar import Radar
from jink.scenarios.skies import SKIES, Sky, SkyRun


@dataclass(frozen=True)
class Row:
    """One line of the table: a sky, what is believed of it, how many runs, and the figure that must be reached."""

    label: str
    sky: str
    runs: int
    gospa: float
    switches: float = np.inf
    milliseconds: float = np.inf
    association: str = "marginal"
    clutter: float = 1.0  # believed, of the true one
    detection: float | None = None  # believed, where it is another than the true one


MUST = [
    Row("A crossing", "sky-crossing", 200, 1.90),
    Row("B four meet", "sky-four", 100, 3.25),
    Row("C parallel 50 m", "sky-parallel-50", 100, 99),
    Row("C parallel 100 m", "sky-parallel", 100, 101),
    Row("C parallel 200 m", "sky-parallel-200", 100, 97),
    Row("D 0.3 per km²", "sky-dense", 40, 118, 1),
    Row("D 1 per km²", "sky-denser", 40, 185),
    Row("E 200, 4 s", "sky-regional", 3, 1900, 2, 0.4),
    Row("E 200, 12 s", "sky-regional-200-12s", 3, 2600, 15, 0.4),
    Row("E 1000, 4 s", "sky-regional-1000-4s", 1, 4450, 15, 2.5),
    Row("E 1000, 12 s", "sky-regional-1000-12s", 1, 6300, 100, 8),
    Row("E 4000, 4 s", "sky-regional-4000-4s", 1, 10_700, 80, 15),
    Row("E 4000, 12 s", "sky-regional-4000-12s", 1, 16_300, 800, 90),
]
WRONG = [
    ("clutter × 3", {"clutter": 3.0}),
    ("clutter ÷ 3", {"clutter": 1 / 3}),
    *((f"Pd {p}", {"detection": p}) for p in (0.7, 0.98)),
]
OTHERS = ("gnn", "nearest", "pda", "jpda")


def filter_of(sky: Sky) -> Any:
    """A Kalman filter where targets fly straight, else an IMM of straight flight and two turns."""
    sensor = jink.Position(sd=sky.sd)
    straight = {"sky-crossing": 0.005, "sky-four": 0.02}
    if sky.name in straight:
        return jink.Kalman(jink.ConstantVelocity(acceleration_psd=straight[sky.name]), sensor)
    w = np.radians(2.5)
    turns = [jink.KnownTurn(turn_rate=rate, acceleration_psd=10.0) for rate in (w, -w)]
    return jink.IMM([jink.ConstantVelocity(acceleration_psd=1.0), *turns], sensor, jink.Sojourn([100.0, 40.0, 40.0]))


def tracker_of(sky: Sky, row: Row) -> jink.Tracker:
    """With the sky's own figures, or wrong ones where the row says so."""
    x0, x1, y0, y1 = sky.area
    per_scan = sky.clutter / (2 * sky.around) ** 2 * (x1 - x0) * (y1 - y0) if sky.around else sky.clutter
    radar = Radar(
        detection=row.detection or sky.detection,
        clutter_per_scan=row.clutter * per_scan,
        period=sky.interval,
        area=sky.area,
        learn_clutter=not sky.around,  # clutter that goes with the targets has no density to learn
    )
    return jink.Tracker(
        filter_of(sky),
        radar,
        targets=0.0 if sky.known else sky.targets,
        new_per_hour=sky.arrivals / sky.interval * 3600,
        stay=sky.life,
        speed_sd=sky.speed_sd,
        association=row.association,
    )


def tracked(sky: Sky, run: SkyRun, row: Row) -> tuple[list[Picture], list[float], int]:
    """Confirmed tracks of each scan, CPU seconds of each scan, and the most tracks that were alive."""
    tracker = tracker_of(sky, row)
    for x, variance in zip(*(sky.known or ((), ())), strict=True):
        tracker.add(0.0, x, np.diag(variance))
    pictures, seconds, living = [], [], 0
    for scan in run.scans:
        begin = time.process_time()
        picture = tracker.scan(scan.time, scan.z)
        seconds.append(time.process_time() - begin)
        sure = picture.confirmed
        pictures.append(Picture(picture.ids[sure], picture.positions[sure]))
        living = max(living, picture.report["living"])
    return pictures, seconds, living


def measure(row: Row, seed: int, runs: int) -> dict[str, Any]:
    """The figures of one row."""
    sky = SKIES[row.sky]
    truth, estimate, seconds, living = [], [], [], 0
    for run in sky.runs(runs, seed):
        pictures, took, most = tracked(sky, run, row)
        truth.append(run.truth)
        estimate.append(pictures)
        seconds += took
        living = max(living, most)
    found = sky_figures(truth, estimate, sky.cutoff)
    figures = {
        "gospa": found.gospa.value,
        "se": found.gospa.se,
        "switches": found.switches.value,
        "ids": found.identities,
        "held": found.completeness,
        "false": found.spurious,
        "ms": 1e3 * float(np.mean(seconds)),
        "worst ms": 1e3 * float(np.max(seconds)),
        "living": living,
    }
    if row.sky.startswith("sky-parallel"):
        figures |= side_by_side(truth, estimate, sky.cutoff)
    return figures


def side_by_side(truth: Any, estimate: Any, c: float) -> dict[str, float]:
    """Of two targets: mean lateral separation of their tracks over the true one where they are nearest, and share of
    runs in which the tracks have changed places from before to after.
    """
    apart, swapped, both = [], 0, 0
    for true, found in zip(truth, estimate, strict=True):
        pairs = []
        for a, b in zip(true, found, strict=True):
            match = gospa(a.points, b.points, c).pairs
            pairs.append(dict(zip(a.ids[match.truth], match.estimate, strict=True)))
            distance = float(np.linalg.norm(a.points[0] - a.points[1]))
            if len(pairs[-1]) == 2 and distance < 1.01 * min(np.linalg.norm(t.points[0] - t.points[1]) for t in true):
                i, j = (b.points[pairs[-1][k]] for k in (0, 1))
                apart.append(abs(i[1] - j[1]) / distance)
        first = {t: found[30].ids[k] for t, k in pairs[30].items()}
        last = {t: found[-1].ids[k] for t, k in pairs[-1].items()}
        if len(first) == 2 == len(last):
            both += 1
            swapped += first[0] == last[1] or first[1] == last[0]
    return {"separation": float(np.mean(apart)), "swaps %": 100.0 * swapped / max(both, 1)}


def rows(only: list[str], quick: bool) -> list[Row]:
    """What must be reached; wrong beliefs on D; the other rules on B, C and D."""
    every = list(MUST)
    dense = Row("D 0.3 per km²", "sky-dense", 40, np.inf)
    every += [replace(dense, label=f"D, {label}", **wrong) for label, wrong in WRONG]
    for name, letter in (("sky-four", "B"), ("sky-parallel", "C"), ("sky-dense", "D"), ("sky-regional", "E")):
        runs = 3 if letter == "E" else 40
        every += [Row(f"{letter}, {how}", name, runs, np.inf, association=how) for how in OTHERS]
    if quick:
        every = [replace(r, runs=max(1, r.runs // 10)) for r in every if "4000" not in r.sky]
    return [r for r in every if not only or any(r.label.startswith(o) for o in only)]


def main() -> None:
    """Measure, print a line per row, keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--json")
    given = parser.parse_args()
    results = {}
    for row in rows(given.only, given.quick):
        found = results[row.label] = measure(row, given.seed, row.runs)
        limits = (("gospa", row.gospa), ("switches", row.switches), ("ms", row.milliseconds))
        missed = [f"{name} > {limit:g}" for name, limit in limits if found[name] > limit]
        figures = "  ".join(f"{name} {value:.4g}" for name, value in found.items())
        print(f"{row.label:20s} {figures}  {'MISSED ' + ', '.join(missed) if missed else ''}", flush=True)
    if given.json:
        with open(given.json, "w", encoding="utf-8") as file:
            json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
