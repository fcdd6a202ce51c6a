"""Hostile but legal data for ``python -m benchmarks.torture``: sensors, truths and measurements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from jink.models.sensor import Bearing, Polar, Position, PositionVelocity

Array = np.ndarray
FAR = (1e3, 1e6, 1e12, 1e100, 1e154, 1e155, 1e200, 1e300)  # sizes of outliers
MISSING, PARTLY, OUTLYING, REPEATED = 0.1, 0.05, 0.02, 0.05


def _angle(sd: float) -> float:
    return float(np.clip(1e-3 * sd, 1e-9, 1.0))


SENSORS: dict[str, Callable[[float], Any]] = {
    "position-1": lambda sd: Position(sd=sd, axes=1),
    "position-2": lambda sd: Position(sd=sd, axes=2),
    "position-3": lambda sd: Position(sd=sd, axes=3),
    "position-velocity-2": lambda sd: PositionVelocity(sd=sd, velocity_sd=sd, axes=2),
    "position-velocity-3": lambda sd: PositionVelocity(sd=sd, velocity_sd=0.1 * sd, axes=3),
    "bearing": lambda sd: Bearing(sd=_angle(sd)),
    "polar-2": lambda sd: Polar(range_sd=sd, azimuth_sd=_angle(sd)),
    "polar-rate-2": lambda sd: Polar(range_sd=sd, azimuth_sd=_angle(sd), range_rate_sd=sd),
    "polar-rate-3": lambda sd: Polar(range_sd=sd, azimuth_sd=_angle(sd), elevation_sd=_angle(sd), range_rate_sd=sd),
    "polar-height": lambda sd: Polar(range_sd=sd, azimuth_sd=_angle(sd), height_sd=sd, earth_radius=6.371e6),
    "polar-converted": lambda sd: Polar(
        range_sd=sd, azimuth_sd=_angle(sd), elevation_sd=_angle(sd), method="converted"
    ),
}


@dataclass(frozen=True)
class Rows:
    """Tracks laid end to end, of one length: time (N,), z (N, m), offsets (B + 1,), covariance (N, m) or None."""

    time: Array
    z: Array
    offsets: Array
    covariance: Array | None

    def batch(self) -> dict[str, Any]:
        """Arguments of ``filter`` and ``smooth``."""
        return {"time": self.time, "z": self.z, "offsets": self.offsets, "covariance": self.covariance}


def hostile(sensor: Any, sd: float, step: float, tracks: int, scans: int, rng: np.random.Generator) -> Rows:
    """Targets that manoeuvre, hover over the site, stand still or jump, seen with gaps, outliers and repeated times."""
    time = _times(step, tracks, scans, rng)
    truth = _truth(time, sensor.axes or 2, sd, rng)
    with np.errstate(all="ignore"):
        z = np.asarray(sensor.observe(truth))
    sds = np.sqrt(np.diag(sensor.noise))
    z = np.where(np.isfinite(z), z, 0.0) + sds * rng.standard_normal(z.shape)
    if "range" in sensor.components:
        z[..., 0] = np.abs(z[..., 0])
        z[rng.random(z.shape[:2]) < 0.01, 0] = 0.0
    if "elevation" in sensor.components:
        z[rng.random(z.shape[:2]) < 0.01, 2] = np.pi / 2
    far = rng.random(z.shape) < OUTLYING
    z[far] = rng.choice(FAR, far.sum()) * rng.choice([-1.0, 1.0], far.sum())
    z[rng.random(z.shape[:2]) < MISSING] = np.nan
    z[rng.random(z.shape) < PARTLY] = np.nan
    z = z.reshape(tracks * scans, -1)
    own = rng.random() < 0.25
    covariance = (sds * 10.0 ** rng.uniform(-3, 3, z.shape)) ** 2 if own else None
    return Rows(time.reshape(-1), z, np.arange(tracks + 1) * scans, covariance)


def _times(step: float, tracks: int, scans: int, rng: np.random.Generator) -> Array:
    """Steps around ``step``, some of them 0, some a hundred times as long, none beyond 10⁴ s."""
    steps = step * rng.uniform(0.5, 1.5, (tracks, scans))
    steps[rng.random(steps.shape) < 0.01] *= 100.0
    steps[rng.random(steps.shape) < REPEATED] = 0.0
    return np.cumsum(np.minimum(steps, 1e4), axis=1)


def _truth(time: Array, axes: int, sd: float, rng: np.random.Generator) -> Any:
    """Position and velocity (B, n, axes): a quarter each flies through the site, turns, stands on the site, jumps."""
    tracks, scans = time.shape
    speed = 10.0 ** rng.uniform(-2, 3.5, (tracks, 1, 1))
    course = rng.standard_normal((tracks, 1, axes))
    course /= np.linalg.norm(course, axis=2, keepdims=True)
    elapsed = (time - time.mean(axis=1, keepdims=True))[:, :, None]
    position, velocity = speed * course * elapsed, np.broadcast_to(speed * course, (tracks, scans, axes)).copy()
    kind = np.arange(tracks) % 4
    rate = 0.05
    turning = kind == 1
    phase = rate * elapsed[turning]
    phases = phase + np.arange(axes) * np.pi / 2
    position[turning] = 1e3 + speed[turning] / rate * np.sin(phases)
    velocity[turning] = speed[turning] * np.cos(phases)
    position[kind == 2] = 0.0
    velocity[kind == 2] = 0.0
    jumps = np.cumsum(rng.standard_normal(position[kind == 3].shape) * 10.0 * max(sd, 1.0), axis=1)
    position[kind == 3] += jumps
    return SimpleNamespace(position=position, velocity=velocity)
