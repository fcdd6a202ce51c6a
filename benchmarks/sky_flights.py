"""Recorded flights seen by a simulated radar without identity: does the tracker give it back?

python -m benchmarks.sky_flights [--flights N] [--seed S] [--file FILE]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import jink
from jink.metrics.figure import Figure, spread
from jink.metrics.skies import Picture, sky_figures
from jink.scenarios.recorded import recorded

from .sky_rows import Limits, most

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "flights.parquet"
SD, PERIOD, DETECTION, FALSE, CUTOFF = 50.0, 4.0, 0.9, 200, 500.0
FIRST = 5  # scans in which tracks begin


def sky_of(file: Path, flights: int, seed: int) -> tuple[Any, Any, Any]:
    """Times (S,), truth (B, S, 2) and plots (B, S, 2), NaN where missed, of flights moved to places in one sky."""
    scenario = recorded(file, kind="aircraft").seen_by(SD, interval=PERIOD, detection=DETECTION, jitter=0.0)
    made = scenario.simulate(flights, seed)
    rng = np.random.default_rng(seed)
    shift = rng.uniform(-1e5, 1e5, (flights, 1, 2))
    truth = made.truth.position[..., :2]
    centre = truth.mean(axis=1, keepdims=True)
    return made.time[0], truth - centre + shift, made.z[..., :2] - centre + shift


def measure(seed: int, flights: int, file: Path = EXAMPLE) -> dict[str, float]:
    """Track with identity and without, and compare; switches per flight hour, shares, position errors (m)."""
    time, truth, seen = sky_of(file, flights, seed)
    rng = np.random.default_rng(seed + 1)
    low, high = np.nanmin(truth, axis=(0, 1)) - 1e4, np.nanmax(truth, axis=(0, 1)) + 1e4
    area = (low[0], high[0], low[1], high[1])
    filter = jink.default_filter("aircraft", jink.Position(sd=SD), interval=PERIOD)
    radar = jink.Radar(detection=DETECTION, clutter_per_scan=FALSE, area=area)
    tracker = jink.Tracker(filter, radar, targets=flights, new_per_hour=flights)
    pictures, there = [], []
    for k, t in enumerate(time):
        plots = seen[:, k][np.isfinite(seen[:, k, 0])]
        picture = tracker.scan(t, np.vstack([plots, rng.uniform(low, high, (rng.poisson(FALSE), 2))]))
        sure = picture.confirmed
        pictures.append(Picture(picture.ids[sure], picture.positions[sure]))
        there.append(Picture(np.arange(flights), truth[:, k]))
    figures = sky_figures([there[FIRST:]], [pictures[FIRST:]], CUTOFF)
    hours = flights * (time[-1] - time[FIRST]) / 3600
    with_identity = _with_identity(filter, time, truth, seen)
    without = figures.localisation / np.sqrt(figures.completeness * flights)
    return {
        "hours": float(hours),
        "scans": float(len(time)),
        "switches per hour": figures.switches.value / hours,
        "completeness": figures.completeness,
        "spurious": figures.spurious,
        "position": float(without),
        "with identity": with_identity,
        "ratio": float(without) / with_identity,
    }


def _with_identity(filter: Any, time: Any, truth: Any, seen: Any) -> float:
    """Root mean square position error (m) where it is within the cut-off, of tracks that are told whose a plot is."""
    flights = len(truth)
    offsets = np.arange(flights + 1) * len(time)
    batch = filter.filter(np.tile(time, flights), seen.reshape(-1, 2), offsets=offsets)
    known = batch.x[:, [list(batch.components).index(c) for c in ("px", "py")]].reshape(truth.shape)
    square = ((known - truth)[:, FIRST:] ** 2).sum(axis=2)
    return float(np.sqrt(np.nanmean(square[square < CUTOFF**2])))


def several(seed: int, quick: bool) -> dict[str, Figure]:
    """Four seeds of 200 flights (quick: two of 40), with standard errors."""
    runs = [measure(seed + 10 * k, 40 if quick else 200) for k in range(2 if quick else 4)]
    names = ("switches per hour", "completeness", "spurious", "ratio")
    values = {name: np.array([run[name] for run in runs]) for name in names}
    return {name: Figure(float(v.mean()), spread(v)) for name, v in values.items()}


ROWS: list[tuple[str, Callable[[int, bool], dict[str, Figure]], Limits]] = [
    ("example flights", several, {**most(switches_per_hour=1, ratio=1.10), "completeness": (0.97, np.inf)}),
]


def main() -> None:
    """Measure once and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=40)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--file", type=Path, default=EXAMPLE)
    given = parser.parse_args()
    f = measure(given.seed, given.flights, given.file)
    print(
        f"{given.flights} flights, {f['scans']:.0f} scans of {PERIOD:g} s, {f['hours']:.1f} flight hours, "
        f"{FALSE} false plots"
    )
    print(f"switches per flight hour {f['switches per hour']:.2f} (must 1)")
    print(f"completeness {100 * f['completeness']:.1f} % (must 97 %), spurious {100 * f['spurious']:.2f} %")
    print(
        f"position {f['position']:.1f} m, with identity {f['with identity']:.1f} m, ratio {f['ratio']:.3f} (must 1.10)"
    )


if __name__ == "__main__":
    main()
