"""The jobs that are timed: what moves, what is measured, and with which matrices it is filtered.

Every library gets the same numbers: a state [px vx py vy] at the first scan with its covariance, then a
predict and an update per scan (the first scan is an update only). SI units.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEP = 1.0
POSITION_SD = 25.0
VELOCITY_PRIOR_SD = 200.0
ACCELERATION_SD = (0.5, 5.0, 30.0)
STAY = 0.97
REGION = 50e3


@dataclass(frozen=True)
class Case:
    """B tracks of S scans, flat and ragged as jink takes them, with the matrices other libraries want."""

    tracks: int
    scans: int
    time: Array  # (B*S,) s
    z: Array  # (B*S, 2) m
    offsets: NDArray[np.int64]  # (B+1,)
    x0: Array  # (B, 4) state at the first scan
    P0: Array  # (4, 4)
    F: Array  # (4, 4)
    Q: Array  # (M, 4, 4)
    H: Array  # (2, 4)
    R: Array  # (2, 2)
    transition: Array  # (M, M)
    mode_probability: Array  # (M,)

    @property
    def updates(self) -> int:
        """Number of track-updates, B*S."""
        return self.tracks * self.scans

    def measurements(self) -> Array:
        """The measurements as (B, S, 2)."""
        return self.z.reshape(self.tracks, self.scans, 2)

    def first(self, tracks: int, scans: int | None = None) -> Case:
        """The same case cut to its first tracks (and scans)."""
        scans = scans or self.scans
        rows = (np.arange(tracks)[:, None] * self.scans + np.arange(scans)).ravel()
        return replace(
            self,
            tracks=tracks,
            scans=scans,
            time=self.time[rows],
            z=self.z[rows],
            offsets=np.arange(tracks + 1, dtype=np.int64) * scans,
            x0=self.x0[:tracks],
        )


def regular(tracks: int, scans: int, seed: int = 1) -> Case:
    """Position measurements once a second: the case every peer can be asked to do."""
    time = np.tile(np.arange(scans) * STEP, tracks)
    return _case(tracks, scans, time, np.random.default_rng(seed))


def irregular(tracks: int, scans: int, seed: int = 2, missing: float = 0.1) -> Case:
    """Such targets seen at irregular times (steps of 0.2 to 1.8 s), a share of the measurements missing."""
    generator = np.random.default_rng(seed)
    steps = generator.uniform(0.2, 1.8, (tracks, scans)) * STEP
    steps[:, 0] = 0.0
    case = _case(tracks, scans, steps.cumsum(axis=1).ravel(), generator)
    gone = generator.random(tracks * scans) < missing
    gone[case.offsets[:-1]] = gone[case.offsets[:-1] + 1] = False
    case.z[gone] = np.nan
    return case


def polar(case: Case, range_sd: float, azimuth_sd: float) -> Array:
    """Range (m) and azimuth (rad, clockwise from y) of the case's targets, with fresh noise.

    The case's own noise (25 m) stays in as a small wobble of the target; only the cost is of interest.
    """
    generator = np.random.default_rng(3)
    distance = np.hypot(case.z[:, 0], case.z[:, 1]) + range_sd * generator.standard_normal(len(case.z))
    azimuth = np.arctan2(case.z[:, 0], case.z[:, 1]) + azimuth_sd * generator.standard_normal(len(case.z))
    return np.column_stack([distance, azimuth])


def _case(tracks: int, scans: int, time: Array, generator: np.random.Generator) -> Case:
    position, velocity = _truth(tracks, scans, time.reshape(tracks, scans), generator)
    z = position + POSITION_SD * generator.standard_normal(position.shape)
    x0 = np.empty((tracks, 4))
    x0[:, 0::2] = position[:, 0] + POSITION_SD * generator.standard_normal((tracks, 2))
    x0[:, 1::2] = velocity[:, 0] + VELOCITY_PRIOR_SD * generator.standard_normal((tracks, 2))
    modes = len(ACCELERATION_SD)
    transition = np.full((modes, modes), (1 - STAY) / (modes - 1))
    np.fill_diagonal(transition, STAY)
    return Case(
        tracks=tracks,
        scans=scans,
        time=time,
        z=z.reshape(-1, 2),
        offsets=np.arange(tracks + 1, dtype=np.int64) * scans,
        x0=x0,
        P0=np.diag([POSITION_SD**2, VELOCITY_PRIOR_SD**2] * 2),
        F=np.kron(np.eye(2), [[1.0, STEP], [0.0, 1.0]]),
        Q=np.stack([sd**2 * np.kron(np.eye(2), _unit_noise()) for sd in ACCELERATION_SD]),
        H=np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0]]),
        R=POSITION_SD**2 * np.eye(2),
        transition=transition,
        mode_probability=np.full(modes, 1 / modes),
    )


def _unit_noise() -> Array:
    gain = np.array([STEP**2 / 2, STEP])
    return np.outer(gain, gain)


def _truth(tracks: int, scans: int, time: Array, generator: np.random.Generator) -> tuple[Array, Array]:
    """Targets at 100..300 m/s that now and then hold an acceleration of up to 20 m/s² for some 20 scans."""
    heading = generator.uniform(0, 2 * np.pi, tracks)
    speed = generator.uniform(100, 300, tracks)
    velocity = np.empty((tracks, scans, 2))
    position = np.empty((tracks, scans, 2))
    velocity[:, 0] = speed[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    position[:, 0] = generator.uniform(-REGION, REGION, (tracks, 2))
    acceleration = np.zeros((tracks, 2))
    for k in range(1, scans):
        fresh = generator.random(tracks) < 0.05
        level = generator.uniform(-20, 20, (tracks, 2)) * (generator.random(tracks) < 0.4)[:, None]
        acceleration = np.where(fresh[:, None], level, acceleration)
        step = (time[:, k] - time[:, k - 1])[:, None]
        position[:, k] = position[:, k - 1] + step * velocity[:, k - 1] + step**2 / 2 * acceleration
        velocity[:, k] = velocity[:, k - 1] + step * acceleration
    return position, velocity
