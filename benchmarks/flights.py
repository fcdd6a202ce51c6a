"""Real flights seen by ADS-B and by simulated radars: the filter under test, and one fitted rival per sensor.

Truth for the radars is a local cubic through the ADS-B positions within 10 s, which knows nothing of motion models.
Flights are split in two by their address: rivals are fitted on one half, everything is measured on the other.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from jink import Position
from jink.io.loading import Reading, load_files
from jink.learn.recorded import local_cubic
from jink.learn.recorded import sampled as sampled_rows
from jink.tracking.cleaning import Cleaning, clean
from jink.tracking.noise_level import noise_levels
from jink.tracking.placing import begin_with_height, place

SETTLED = 10  # scans of a track before its predictions count
# name: period (s), sd of x, y and altitude (m)
RADARS = {"terminal radar": (5.0, (50.0, 50.0, 10.0)), "en-route radar": (10.0, (150.0, 150.0, 10.0))}


@dataclass(frozen=True)
class Flight:
    """Measured positions z (n, 3) with covariance (n, 3, 3) at time (n,); true position, velocity and acceleration
    (NaN: unknown).
    """

    target: str
    time: np.ndarray
    z: np.ndarray
    covariance: np.ndarray
    truth: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


@dataclass(frozen=True)
class Tracks:
    """Targets laid end to end as one sensor sees them."""

    sensor: Position
    time: np.ndarray
    z: np.ndarray
    truth: np.ndarray
    offsets: np.ndarray
    covariance: np.ndarray | None = None
    acceleration: np.ndarray | None = None

    def batch(self) -> dict[str, Any]:
        """What a filter takes."""
        return {"time": self.time, "z": self.z, "offsets": self.offsets, "covariance": self.covariance}

    def with_predictions(self) -> Tracks:
        """A row without a measurement before each row: what is estimated there is the prediction."""
        z = np.repeat(self.z, 2, axis=0)
        z[::2] = np.nan
        covariance = None if self.covariance is None else np.repeat(self.covariance, 2, axis=0)
        truth = np.repeat(self.truth, 2, axis=0)
        return Tracks(self.sensor, np.repeat(self.time, 2), z, truth, 2 * self.offsets, covariance)


@cache
def flights(path: Path) -> tuple[Flight, ...]:
    """Those of a file that have altitudes, cleaned as `jink track` does, a new one after a minute without positions."""
    measurements = load_files([str(path)], Reading()).measurements
    cleaned = clean(measurements.rows, measurements.position, Cleaning(gap=60.0, min_points=120))
    groups = place(cleaned.rows, measurements.position, None)
    spatial = next(group for group in groups if group.axes == 3)
    noise = noise_levels(spatial, {}, "aircraft").covariance
    begin_with_height(spatial, noise)
    covariance = noise[:]
    targets = spatial.rows["target"]
    return tuple(
        Flight(
            targets[a],
            spatial.time[a:b],
            spatial.z[a:b],
            covariance[a:b],
            *local_cubic(spatial.time[a:b], spatial.z[a:b]),
        )
        for a, b in np.lib.stride_tricks.sliding_window_view(spatial.offsets, 2).tolist()
    )


def held_out(flight: Flight) -> bool:
    """Whether nothing may be fitted on it."""
    return zlib.crc32(flight.target.encode()) % 2 == 1


def sampled(flight: Flight, period: float, least: int) -> list[np.ndarray]:
    """Rows of a flight about a period apart, cut where the truth is unknown for long; pieces of at least so many."""
    known = np.isfinite(flight.truth).all(axis=1) & np.isfinite(flight.velocity).all(axis=1)
    return sampled_rows(flight.time, known, period, least)


def ads_b(some: list[Flight]) -> Tracks:
    """As received, with the noise `jink track` estimates; the next position itself is the truth of a prediction."""
    parts = [(f.time, f.z, f.z, f.acceleration) for f in some]
    return _joined(Position(sd=(30.0, 30.0, 5.0), axes=3), parts, np.concatenate([f.covariance for f in some]))


def radar(some: list[Flight], name: str, seed: int) -> Tracks:
    """The truth every so many seconds, with noise; a new track where it is unknown for a minute."""
    period, sd = RADARS[name]
    rng = np.random.default_rng(seed)
    parts = []
    for f in some:
        seen, last = [], -np.inf
        for k in np.flatnonzero(np.isfinite(f.truth).all(axis=1)):
            if f.time[k] >= last + period - 1e-6:
                seen.append(k)
                last = f.time[k]
        breaks = np.flatnonzero(np.diff(f.time[seen]) > 60.0) + 1
        for run in np.split(np.array(seen, int), breaks):
            if len(run) >= 2 * SETTLED:
                z = f.truth[run] + rng.standard_normal((len(run), 3)) * sd
                parts.append((f.time[run], z, f.truth[run], f.acceleration[run]))
    return _joined(Position(sd=sd, axes=3), parts)


def _joined(sensor: Position, parts: list, covariance: np.ndarray | None = None) -> Tracks:
    time, z, truth, acceleration = (np.concatenate(column) for column in zip(*parts, strict=True))
    offsets = np.r_[0, np.cumsum([len(part[0]) for part in parts])]
    return Tracks(sensor, time, z, truth, offsets, covariance, acceleration)
