"""Figures of a sky's runs, each with a standard error from the spread over runs."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

import jink
from jink.metrics.figure import Figure, spread
from jink.metrics.sets import gospa
from jink.metrics.skies import Picture, sky_figures
from jink.models.radar import Radar
from jink.scenarios.skies import SKIES, Sky, SkyRun

from .sky_rows import Row

Numbers = dict[str, list[float]]  # of each figure its value in each run


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
    radar = Radar(
        detection=row.detection or sky.detection,
        clutter_per_scan=row.clutter * sky.false_per_scan,
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


def tracked(sky: Sky, run: SkyRun, row: Row) -> tuple[list[Picture], list[float], list[int]]:
    """Of each scan its confirmed tracks, its CPU seconds, and how many tracks were alive."""
    tracker = tracker_of(sky, row)
    for x, variance in zip(*(sky.known or ((), ())), strict=True):
        tracker.add(0.0, x, np.diag(variance))
    pictures, seconds, living = [], [], []
    for scan in run.scans:
        begin = time.process_time()
        picture = tracker.scan(scan.time, scan.z)
        seconds.append(time.process_time() - begin)
        sure = picture.confirmed
        pictures.append(Picture(picture.ids[sure], picture.positions[sure]))
        living.append(picture.report["living"])
    return pictures, seconds, living


def measure(row: Row, seed: int) -> Numbers:
    """Every figure of the row, run by run."""
    sky = SKIES[row.sky]
    numbers: Numbers = {}
    for run in sky.runs(row.runs, seed):
        pictures, seconds, living = tracked(sky, run, row)
        each = of_run(run.truth, pictures, sky.cutoff)
        third = len(living) // 3
        each |= {
            "ms": 1e3 * float(np.mean(seconds)),
            "worst ms": 1e3 * float(np.max(seconds)),
            "living": float(np.max(living)),
            "growth": float(np.mean(living[-third:])) / max(float(np.mean(living[third:-third])), 1.0),
        }
        if row.sky.startswith("sky-parallel"):
            each |= side_by_side(run.truth, pictures, sky.cutoff)
        for name, value in each.items():
            numbers.setdefault(name, []).append(value)
    return numbers


def of_run(truth: Sequence[Picture], pictures: Sequence[Picture], c: float) -> dict[str, float]:
    """GOSPA, switches, ids per target, shares of targets held and of tracks that are false, in one run."""
    found = sky_figures([truth], [pictures], c)
    return {
        "gospa": found.gospa.value,
        "switches": found.switches.value,
        "ids": found.identities,
        "held": found.completeness,
        "false": found.spurious,
    }


def side_by_side(truth: Sequence[Picture], pictures: Sequence[Picture], c: float) -> dict[str, float]:
    """Of two targets: mean lateral separation of their tracks over the true one, in the last ten scans in which they
    are nearest and in all of these, and whether the tracks have changed places from before to after; NaN where there
    are no two tracks.
    """
    distances = [float(np.linalg.norm(t.points[0] - t.points[1])) for t in truth]
    abreast = [k for k, distance in enumerate(distances) if distance < 1.01 * min(distances)]
    pairs, apart = [], dict.fromkeys(abreast, math.nan)
    for k, (a, b) in enumerate(zip(truth, pictures, strict=True)):
        match = gospa(a.points, b.points, c).pairs
        pairs.append(dict(zip(a.ids[match.truth], match.estimate, strict=True)))
        if len(pairs[-1]) == 2 and k in apart:
            i, j = (b.points[pairs[-1][n]] for n in (0, 1))
            apart[k] = abs(i[1] - j[1]) / distances[k]
    first = {t: pictures[30].ids[k] for t, k in pairs[30].items()}
    last = {t: pictures[-1].ids[k] for t, k in pairs[-1].items()}
    swapped = float(first[0] == last[1] or first[1] == last[0]) if len(first) == 2 == len(last) else math.nan
    ratios = np.array(list(apart.values()))
    return {"separation": _mean(ratios[-10:]), "separation throughout": _mean(ratios), "swaps": swapped}


def _mean(v: np.ndarray) -> float:
    v = v[np.isfinite(v)]
    return float(v.mean()) if len(v) else math.nan


def figures(numbers: Numbers, against: Numbers | None = None) -> dict[str, Figure]:
    """Root mean square of GOSPA, the largest of times and of living tracks, means of the rest; with standard errors.

    The error of a largest value is the spread of the runs' largest ones, not divided by √runs. ratio: GOSPA over that
    of the same runs in ``against``, by the delta method.
    """
    out = {}
    for name, values in numbers.items():
        v = np.array(values)
        v = v[np.isfinite(v)]
        if name == "gospa":
            out[name] = _root_mean_square(v)
        elif name in ("worst ms", "living"):
            out[name] = Figure(float(v.max()), float(v.std(ddof=1)) if len(v) > 1 else math.nan)
        else:
            out[name] = Figure(float(v.mean()) if len(v) else math.nan, spread(v))
    if against is not None:
        a, b = (np.array(n["gospa"]) ** 2 for n in (numbers, against))
        ratio = math.sqrt(a.mean() / b.mean())
        out["ratio"] = Figure(ratio, spread(ratio / 2 * (a / a.mean() - b / b.mean())))
    return out


def _root_mean_square(v: np.ndarray) -> Figure:
    value = math.sqrt(float((v**2).mean()))
    return Figure(value, spread(v**2) / (2 * value) if value > 0 else 0.0)
