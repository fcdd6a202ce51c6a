"""Whole skies: several targets at once, seen with misses and false plots, and no plot says whose it is.

A :class:`Sky` is a truth and how it is seen. A run depends on nothing but the seed and its number. The families follow
published experiments where their summary says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..checks import Array, unknown
from ..frozen import frozen
from ..metrics.skies import Picture
from .sky_paths import crossing, dense, four, parallel, regional

Rng = np.random.Generator
Truth = list[tuple[NDArray[np.int64], Array]]  # of each scan: ids (n,) and states (n, 4) x, vx, y, vy


class SkyScan(NamedTuple):
    """One scan: its time (s), plots z (m, 2) in metres, and of each plot the target's id, −1 for a false one."""

    time: float
    z: Array
    origin: NDArray[np.int64]


@frozen
class SkyRun:
    """One run: its scans, and what was there in each."""

    scans: list[SkyScan]
    truth: list[Picture]
    velocity: list[Array]


@frozen(kw_only=True)
class Sky:
    """paths(rng) draws the truth. sd (m) of a plot in each axis, detection probability, clutter: false plots per scan.

    around: each target has false plots of its own, in a box of this half side (m), instead of the whole area's.
    cutoff: the c of GOSPA that suits it (m). targets: about how many are there at once. known: states and variances
    (n, 4) that are known before the first scan. life: mean seconds that a target stays.
    """

    name: str
    summary: str
    paths: Callable[[Rng], Truth]
    interval: float
    sd: float
    clutter: float
    area: tuple[float, float, float, float]
    cutoff: float
    targets: float
    detection: float = 0.9
    around: float = 0.0
    speed_sd: float = 150.0
    life: float = 1000.0
    arrivals: float = 0.0  # new targets per scan, about
    known: tuple[Array, Array] | None = None
    source: str = ""
    first: int = field(default=0)  # scans before it have no plots

    @property
    def false_per_scan(self) -> float:
        """False plots per scan over the whole area, at the density that they have where they are."""
        if not self.around:
            return self.clutter
        x0, x1, y0, y1 = self.area
        return self.clutter * (x1 - x0) * (y1 - y0) / (2 * self.around) ** 2

    def run(self, number: int, seed: int = 0) -> SkyRun:
        """Run ``number`` of this seed."""
        truth_rng, seen_rng = (
            np.random.default_rng(np.random.SeedSequence((seed, number, stream))) for stream in (0, 1)
        )
        truth = self.paths(truth_rng)
        scans = [self._scan(seen_rng, k, ids, x) for k, (ids, x) in enumerate(truth)]
        pictures = [Picture(ids, x[:, [0, 2]]) for ids, x in truth]
        return SkyRun(scans[self.first :], pictures[self.first :], [x[:, [1, 3]] for _, x in truth][self.first :])

    def runs(self, count: int, seed: int = 0) -> Iterator[SkyRun]:
        """Runs 0 … count − 1, one at a time."""
        return (self.run(number, seed) for number in range(count))

    def _scan(self, rng: Rng, k: int, ids: NDArray[np.int64], x: Array) -> SkyScan:
        seen = rng.random(len(ids)) < self.detection
        z = x[:, [0, 2]] + self.sd * rng.standard_normal((len(ids), 2))
        if self.around:
            count = rng.integers(0, round(2 * self.clutter) + 1, len(ids))
            centre = np.repeat(x[:, [0, 2]], count, axis=0)
            false = centre + rng.uniform(-self.around, self.around, centre.shape)
        else:
            low, high = np.array(self.area[::2]), np.array(self.area[1::2])
            false = rng.uniform(low, high, (rng.poisson(self.clutter), 2))
        plots = np.vstack([z[seen], false])
        origin = np.concatenate([ids[seen], np.full(len(false), -1)])
        order = rng.permutation(len(plots))
        return SkyScan(self.interval * k, plots[order], origin[order])


def _skies() -> list[Sky]:
    square = 4e5
    fixed = [
        Sky(
            name="sky-crossing",
            summary="two targets cross; their start is known",
            paths=crossing,
            interval=1.0,
            sd=sqrt(0.75),
            clutter=4.5,
            around=10.0,
            area=(-15.0, 40.0, -15.0, 40.0),
            cutoff=5.0,
            targets=2,
            speed_sd=1.0,
            life=1e9,
            known=(np.array([[0.0, 1, 0, 1], [0, 1, 20, -1]]), np.tile([1.5, 0.5, 1.5, 0.5], (2, 1))),
            source="Stone Soup, tutorial 8",
            first=1,
        ),
        Sky(
            name="sky-four",
            summary="four targets come within a metre of each other in the middle scan, when one of them ends",
            paths=four,
            interval=1.0,
            sd=1.0,
            clutter=10.0,
            area=(0.0, 300.0, 0.0, 300.0),
            cutoff=10.0,
            targets=4,
            speed_sd=1.0,
            life=100.0,
            arrivals=0.005,
            source="García-Fernández, Williams, Granström & Svensson, IEEE Trans. AES 54(4), 2018",
        ),
    ]
    apart = [
        Sky(
            name=f"sky-parallel-{d}" if d != 100 else "sky-parallel",
            summary=f"two aircraft side by side, {d} m apart, that never cross",
            paths=parallel(float(d)),
            interval=4.0,
            sd=50.0,
            clutter=21.0,
            area=(0.0, 70e3, 0.0, 30e3),
            cutoff=300.0,
            targets=2,
            life=800.0,
            arrivals=0.08,
        )
        for d in (50, 100, 200)
    ]
    clutter = [
        Sky(
            name="sky-dense" if per_km2 == 0.3 else "sky-denser",
            summary=f"one aircraft that turns in {per_km2:g} false plots per km²",
            paths=dense,
            interval=4.0,
            sd=50.0,
            clutter=288.0 * per_km2,
            area=(0.0, 18e3, 0.0, 16e3),
            cutoff=300.0,
            targets=1,
            life=800.0,
            arrivals=0.4,
        )
        for per_km2 in (0.3, 1.0)
    ]
    wide = [
        Sky(
            name="sky-regional" if (count, interval) == (200, 4.0) else f"sky-regional-{count}-{interval:.0f}s",
            summary=f"{count} aircraft and as many false plots a scan in a square of 400 km, {interval:g} s",
            paths=regional(count, interval, scans),
            interval=interval,
            sd=100.0,
            clutter=float(count),
            area=(0.0, square, 0.0, square),
            cutoff=500.0,
            targets=count,
            life=500.0 * interval,
            arrivals=2e-3 * count * interval,
        )
        for count, scans in ((200, 40), (1000, 40), (4000, 25))
        for interval in (4.0, 12.0)
    ]
    return fixed + apart + clutter + wide


SKIES: dict[str, Sky] = {sky.name: sky for sky in _skies()}


def sky_called(name: str) -> Sky:
    """The sky of this name. Errors: ValueError naming the nearest and all."""
    if name not in SKIES:
        raise ValueError(unknown("sky", name, SKIES))
    return SKIES[name]
