"""Two radars that see the same targets, one of them biased; and a burst of false plots."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from functools import partial

import numpy as np

import jink
from jink.metrics.figure import Figure, spread
from jink.metrics.sets import gospa
from jink.metrics.skies import Picture
from jink.models.radar import Radar
from jink.scenarios.skies import SKIES
from jink.scenarios.sky_paths import regional

from .sky_measures import figures, filter_of, of_run
from .sky_rows import Limits, most

BURST = 100_000
CODED = 0.5  # share of the targets' plots that tell a code
SETTLING = 10  # scans of both radars before duplicates are counted


def duplicates(truth: Picture, found: Picture, c: float) -> tuple[int, int]:
    """Tracks that are the second or a later one within c/2 of a target that has one; and all tracks."""
    pairs = gospa(truth.points, found.points, c).pairs
    rest = np.setdiff1d(np.arange(len(found.ids)), pairs.estimate)
    held = truth.points[pairs.truth]
    near = [bool(len(held)) and ((held - found.points[k]) ** 2).sum(axis=1).min() < (c / 2) ** 2 for k in rest]
    return int(np.sum(near)), len(found.ids)


def two_radars(seed: int, quick: bool, bias: float) -> dict[str, Figure]:
    """200 aircraft, each radar every 4 s, two seconds apart; the plots of one are off by ``bias`` sds in x and in y.

    bias error: of the offset that `jink.radar_bias` finds from plots with codes, in sds.
    """
    sky = SKIES["sky-regional"]
    numbers: dict[str, list[float]] = {}
    for number in range(2 if quick else 5):
        truths = regional(200, 2.0, 80)(np.random.default_rng((seed, number, 5)))
        rng = np.random.default_rng((seed, number, 6))
        radar = Radar(sd=sky.sd, detection=sky.detection, clutter_per_scan=sky.clutter, area=sky.area)
        sensors = {"one": radar, "other": radar}
        tracker = jink.Tracker(filter_of(sky), sensors, targets=200, new_per_hour=180, stay=2000.0)
        truth, pictures, double, every = [], [], 0, 0
        told: list[tuple[float, np.ndarray, np.ndarray]] = []
        for k, (ids, x) in enumerate(truths):
            scan = sky._scan(rng, k, ids, x)
            z = scan.z + (bias * sky.sd if k % 2 else 0.0)
            picture = tracker.scan(2.0 * k, z, "other" if k % 2 else "one")
            told.append((2.0 * k, z, np.where(rng.random(len(z)) < CODED, scan.origin, -1)))
            sure = picture.confirmed
            truth.append(Picture(ids, x[:, [0, 2]]))
            pictures.append(Picture(picture.ids[sure], picture.positions[sure]))
            if k >= 2 * SETTLING:
                more, all_ = duplicates(truth[-1], pictures[-1], sky.cutoff)
                double, every = double + more, every + all_
        off = jink.radar_bias(*_joined(told[::2]), *_joined(told[1::2])).offset / sky.sd - bias
        each = {"duplicates": double / every, "bias error": float(np.abs(off).max())} | of_run(
            truth, pictures, sky.cutoff
        )
        for name, value in each.items():
            numbers.setdefault(name, []).append(value)
    return figures(numbers)


def _joined(told: list[tuple[float, np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, plots and codes of all scans of one radar."""
    time = np.concatenate([np.full(len(z), t) for t, z, _ in told])
    return time, np.concatenate([z for _, z, _ in told]), np.concatenate([c for _, _, c in told])


def burst(seed: int, quick: bool) -> dict[str, Figure]:
    """One scan of 100,000 false plots over an aircraft in 18 × 16 km, or the one after it.

    The longer one's seconds, the megabytes by which the process grew, and the share of runs in which the report says
    that gates were bounded.
    """
    sky = SKIES["sky-dense"]
    low, high = np.array(sky.area[::2]), np.array(sky.area[1::2])
    seconds, said, megabytes = [], [], []
    for number in range(2 if quick else 5):
        run = sky.run(number, seed)
        radar = Radar(clutter_per_scan=sky.clutter, area=sky.area)
        tracker = jink.Tracker(filter_of(sky), radar, targets=1, new_per_hour=360)
        rng = np.random.default_rng((seed, number))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        took, crowded = [], []
        for k, scan in enumerate(run.scans[:12]):
            more = rng.uniform(low, high, (BURST if k == 8 else 0, 2))
            begin = time.process_time()
            picture = tracker.scan(scan.time, np.vstack([scan.z, more]))
            took.append(time.process_time() - begin)
            crowded.append(picture.report["crowded"])
        seconds.append(max(took[8:10]))
        said.append(float(crowded[8]))
        megabytes.append((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
    longest, largest = np.array(seconds), np.array(megabytes)
    return {
        "seconds": Figure(float(longest.max()), float(longest.std(ddof=1))),
        "megabytes": Figure(float(largest.max()), float(largest.std(ddof=1))),
        "said": Figure(float(np.mean(said)), spread(np.array(said))),
    }


ROWS: list[tuple[str, Callable[[int, bool], dict[str, Figure]], Limits]] = [
    ("two radars, no bias", partial(two_radars, bias=0.0), most(duplicates=0.03, bias_error=0.1)),
    ("two radars, bias 0.5 sd", partial(two_radars, bias=0.5), most(duplicates=0.03, bias_error=0.1)),
    ("two radars, bias 1 sd", partial(two_radars, bias=1.0), {}),
    ("burst of 100,000 plots", burst, {**most(seconds=2.0, megabytes=1000.0), "said": (1.0, 1.0)}),
]
