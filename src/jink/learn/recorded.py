"""Recorded tracks as truth: what the targets did, smoothed, and how radars that are drawn at random would see it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..models.tracks import Tracks

BREAK = 60.0  # s without a true position: a new track begins
REACH = 10.0  # s: the local cubic sees this far back and ahead
LONG = 40  # positions it uses at most
LEAST = 12  # positions that it needs
SHORTEST = 30  # plots of a track
PERIOD = (0.8, 13.0)  # s
ALIKE, POLAR = (4.0, 300.0), ((10.0, 150.0), (0.03, 0.15))  # m in all directions; m of range and degrees of azimuth
ROUND, DISTANCE = 0.4, (20e3, 150e3)  # share of sensors that err alike in all directions; m to the others
GROSS, SCALE, WITH_GROSS = 0.01, 20.0, 0.6  # share and size of gross errors; share of sensors that have them
HEIGHT_SD = 10.0  # m
COMPONENTS = ("px", "py", "vx", "vy", "ax", "ay")


@frozen(eq=False)
class Flown:
    """True position, velocity and acceleration (n, axes) at time (n,) of a target; NaN: unknown."""

    target: str
    time: Array
    position: Array
    velocity: Array
    acceleration: Array

    @property
    def known(self) -> np.ndarray:
        """Rows whose position and velocity are known (n,)."""
        return np.asarray(np.isfinite(self.position + self.velocity).all(axis=1))


@frozen(kw_only=True)
class Radar:
    """period (s), sd (m) of range, and of azimuth (rad) if it does not err alike in all directions; share of gross
    errors; axes: 2 without heights, 3 with them.
    """

    period: float
    sd: float
    azimuth_sd: float | None = None
    gross: float = 0.0
    axes: int = 2


def flown(tracks: Tracks) -> list[Flown]:
    """What the targets of recorded tracks did, as far as the local cubic knows it."""
    assert tracks.owner is not None
    found = []
    for k in range(len(tracks)):
        rows = tracks.at(k)
        time = tracks.time[rows]
        found.append(Flown(str(tracks.owner[k]), time, *local_cubic(time, tracks.z[rows])))
    return found


def drawn(rng: np.random.Generator, axes: int) -> Radar:
    """A radar of any period and noise within the ranges above."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    period = between(*PERIOD)
    alike = rng.random() < ROUND
    sd, azimuth = (between(*ALIKE), None) if alike else (between(*POLAR[0]), np.radians(between(*POLAR[1])))
    gross = GROSS if rng.random() < WITH_GROSS else 0.0
    return Radar(period=period, sd=sd, azimuth_sd=azimuth, gross=gross, axes=axes)


def seen(some: Sequence[Flown], radar: Radar, rng: np.random.Generator) -> Tracks:
    """Every flight by such a radar at a place of its own; truth in ``COMPONENTS``."""
    parts, owners = [], []
    for flight in some:
        for rows in sampled(flight.time, flight.known, radar.period, SHORTEST):
            parts.append((flight.time[rows], *_plots(flight.position[rows], radar, rng), _truth(flight, rows)))
            owners.append(flight.target)
    if not parts:
        raise ValueError(f"no track has {SHORTEST} known positions {radar.period:.3g} s apart")
    time, z, covariance, truth = (np.concatenate(column) for column in zip(*parts, strict=True))
    offsets = np.r_[0, np.cumsum([len(part[0]) for part in parts])]
    return Tracks(time, z, offsets, covariance, truth=truth, components=COMPONENTS, owner=np.array(owners))


def _truth(flight: Flown, rows: np.ndarray) -> Array:
    kinds = flight.position, flight.velocity, flight.acceleration
    return np.concatenate([each[rows, :2] for each in kinds], axis=1)


def _plots(place: Array, radar: Radar, rng: np.random.Generator) -> tuple[Array, Array]:
    """Measured positions (n, axes) and their covariance (n, axes, axes)."""
    n, bearing, distance = len(place), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(*DISTANCE)
    line = place[:, :2] - place[:, :2].mean(axis=0) + distance * np.array([np.sin(bearing), np.cos(bearing)])
    reach = np.hypot(*line.T)
    along = line / reach[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    sideways = np.full(n, radar.sd) if radar.azimuth_sd is None else radar.azimuth_sd * reach
    sd = np.stack([np.full(n, radar.sd), sideways], axis=1)
    noise = sd * rng.standard_normal((n, 2)) * np.where(rng.random(n) < radar.gross, SCALE, 1.0)[:, None]
    z, covariance = place[:, : radar.axes].copy(), np.zeros((n, radar.axes, radar.axes))
    for k, axis in enumerate((along, across)):
        z[:, :2] += noise[:, k, None] * axis
        covariance[:, :2, :2] += sd[:, k, None, None] ** 2 * axis[:, :, None] * axis[:, None, :]
    if radar.axes == 3:
        z[:, 2] += HEIGHT_SD * rng.standard_normal(n)
        covariance[:, 2, 2] = HEIGHT_SD**2
    return z, covariance


def sampled(time: Array, known: np.ndarray, period: float, least: int) -> list[np.ndarray]:
    """Rows with a known truth about a period apart, cut where it is unknown for longer than ``BREAK``.

    least: rows of a piece; shorter ones are left out.
    """
    at, last = [], -np.inf
    for k in np.flatnonzero(known):
        if time[k] >= last + period - 1e-6:
            at.append(k)
            last = time[k]
    breaks = np.flatnonzero(np.diff(time[at]) > BREAK) + 1
    return [run for run in np.split(np.array(at, int), breaks) if len(run) >= least]


def local_cubic(time: Array, z: Array) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration of the least-squares cubic through the sane positions within REACH.

    NaN where they are too few or one-sided.
    """
    position, velocity, acceleration = (np.full(z.shape, np.nan) for _ in range(3))
    parts = [(slice(0, 2), _sane(time, z[:, :2], 400.0))]
    if z.shape[1] > 2:
        parts.append((slice(2, 3), _sane(time, z[:, 2:], 60.0)))
    for columns, sane in parts:
        t, points = time[sane], z[sane, columns]
        first, last = np.searchsorted(t, time - REACH), np.searchsorted(t, time + REACH, side="right")
        good = np.flatnonzero((last - first >= LEAST) & (last - first <= LONG))
        if not good.size:
            continue
        index = np.minimum(first[good, None] + np.arange(LONG), len(t) - 1)
        used = np.arange(LONG) < (last - first)[good, None]
        s = (t[index] - time[good, None]) / REACH
        X = s[..., None] ** np.arange(4) * used[..., None]
        fit = np.linalg.solve(X.swapaxes(1, 2) @ X + 1e-9 * np.eye(4), X.swapaxes(1, 2) @ points[index])
        fit[~(((s < -0.5) & used).sum(axis=1) >= 2) | ~(((s > 0.5) & used).sum(axis=1) >= 2)] = np.nan
        position[good, columns], velocity[good, columns] = fit[:, 0], fit[:, 1] / REACH
        acceleration[good, columns] = 2.0 * fit[:, 2] / REACH**2
    return position, velocity, acceleration


def _sane(time: Array, z: Array, limit: float) -> np.ndarray:
    """Whether a position lies within limit (m) of the line through the medians of the five before and after."""
    sane = np.zeros(len(z), bool)
    known = np.flatnonzero(np.isfinite(z).all(axis=1))
    if len(known) < 11:
        return sane
    window = np.lib.stride_tricks.sliding_window_view(np.column_stack([time, z])[known], 11, axis=0)
    before, after = np.median(window[..., :5], axis=-1), np.median(window[..., 6:], axis=-1)
    here = window[..., 5]
    part = ((here - before)[:, :1]) / (after - before)[:, :1]
    off = np.abs(here - before - part * (after - before)).max(axis=1)
    sane[known[5:-5]] = off < limit
    return sane
