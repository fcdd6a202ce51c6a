"""Recorded flights seen by a simulated radar without identity: does the tracker give it back?

python -m benchmarks.sky_flights [--flights N] [--seed S] [--file FILE]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import jink
from jink.metrics.skies import Picture, sky_figures
from jink.scenarios.recorded import recorded

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "flights.parquet"
SD, PERIOD, DETECTION, FALSE = 50.0, 4.0, 0.9, 200


def sky_of(file: Path, flights: int, seed: int) -> tuple[Any, Any, Any]:
    """Times (S,), truth (B, S, 2) and plots (B, S, 2), NaN where missed, of flights moved to places in one sky."""
    scenario = recorded(file, kind="aircraft").seen_by(SD, interval=PERIOD, detection=DETECTION, jitter=0.0)
    made = scenario.simulate(flights, seed)
    rng = np.random.default_rng(seed)
    shift = rng.uniform(-1e5, 1e5, (flights, 1, 2))
    truth = made.truth.position[..., :2]
    centre = truth.mean(axis=1, keepdims=True)
    return made.time[0], truth - centre + shift, made.z[..., :2] - centre + shift


def main() -> None:
    """Track with identity and without, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=40)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--file", type=Path, default=EXAMPLE)
    given = parser.parse_args()
    time, truth, seen = sky_of(given.file, given.flights, given.seed)
    rng = np.random.default_rng(given.seed + 1)
    low, high = np.nanmin(truth, axis=(0, 1)) - 1e4, np.nanmax(truth, axis=(0, 1)) + 1e4
    area = (low[0], high[0], low[1], high[1])
    filter = jink.default_filter("aircraft", jink.Position(sd=SD), interval=PERIOD)
    tracker = jink.Tracker(
        filter,
        jink.Radar(detection=DETECTION, clutter_per_scan=FALSE, area=area),
        targets=given.flights,
        new_per_hour=given.flights,
    )
    pictures, there = [], []
    for k, t in enumerate(time):
        plots = seen[:, k][np.isfinite(seen[:, k, 0])]
        picture = tracker.scan(t, np.vstack([plots, rng.uniform(low, high, (rng.poisson(FALSE), 2))]))
        sure = picture.confirmed
        pictures.append(Picture(picture.ids[sure], picture.positions[sure]))
        there.append(Picture(np.arange(given.flights), truth[:, k]))
    first = 5  # scans in which tracks begin
    figures = sky_figures([there[first:]], [pictures[first:]], 500.0)
    hours = given.flights * (time[-1] - time[first]) / 3600
    batch = filter.filter(
        np.tile(time, given.flights), seen.reshape(-1, 2), offsets=np.arange(given.flights + 1) * len(time)
    )
    known = batch.x[:, [list(batch.components).index(c) for c in ("px", "py")]].reshape(truth.shape)
    square = ((known - truth)[:, first:] ** 2).sum(axis=2)
    with_identity = float(np.sqrt(np.nanmean(square[square < 500.0**2])))
    pairs = figures.completeness * given.flights
    without = figures.localisation / np.sqrt(pairs)
    print(
        f"{given.flights} flights, {len(time)} scans of {PERIOD:g} s, {hours:.1f} flight hours, {FALSE} false plots a scan"
    )
    print(f"switches per flight hour {figures.switches.value / hours:.2f} (must 1)")
    print(f"completeness {100 * figures.completeness:.1f} % (must 97 %), spurious {100 * figures.spurious:.2f} %")
    print(
        f"position {without:.1f} m, with identity {with_identity:.1f} m, ratio {without / with_identity:.3f} (must 1.10)"
    )


if __name__ == "__main__":
    main()
