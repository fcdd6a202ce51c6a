"""What targets report of motion beside positions, as a filter takes it: velocities in the frame of the positions.

A speed without a course measures the velocity along the way that the last positions show, and nothing across it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from .._engine import native
from ..filters import memory
from ..filters.row_noise import RowNoise
from ..frozen import frozen
from ..io.geodesy import DevelopedFrame
from ..io.rates import FASTEST
from .noise_level import NoiseLevel
from .placing import Placed
from .scatter import MEDIAN, grouped_quantile, rough_velocity, steps

RATES = {"velocity": slice(0, 2), "vertical_rate": slice(2, 3)}  # and their components
FAR = 6.0  # sds from the motion that positions show: such a report is wrong


@frozen
class Rates:
    """Velocities in the frame of the positions, rows by components vx, vy and vz (NaN: not reported).

    accuracy (N, 2): sds (m/s) of velocity and vertical rate that the source states, NaN where it does not.
    way (N, 2): unit vectors along which vx and vy were measured, None where both are; slack (N,): what an uncertain way
    adds along it (m/s). fresh (N,): the report differs from the one before. off (N,): how far it is from the motion
    that positions show (m/s); usual: the same of most fresh reports.
    """

    velocity: np.ndarray
    way: np.ndarray | None
    slack: np.ndarray
    fresh: np.ndarray
    accuracy: np.ndarray
    off: np.ndarray
    usual: float = 0.0

    @classmethod
    def none(cls, placed: Placed) -> Rates:
        """Of rows that report nothing."""
        count = placed.rows.height
        missing = np.full(count, np.nan)
        nothing = np.full((count, 3), np.nan), None, np.zeros(count), np.ones(count, bool), np.full((count, 2), np.nan)
        return cls(*nothing, missing)

    def some(self, rows: np.ndarray) -> Rates:
        """Rows of it."""
        way = None if self.way is None else self.way[rows]
        slack, fresh, accuracy, off = (each[rows] for each in (self.slack, self.fresh, self.accuracy, self.off))
        return Rates(self.velocity[rows], way, slack, fresh, accuracy, off, self.usual)

    @property
    def stated(self) -> dict[str, float]:
        """The usual sds that the source states, of the rates for which it does."""
        usual: dict[str, float] = {}
        for column, name in enumerate(("velocity", "vertical_rate")):
            known = self.accuracy[np.isfinite(self.accuracy[:, column]) & np.isfinite(self.velocity[:, 2 * column])]
            if len(known):
                usual[name] = float(np.median(known[:, column]))
        return usual


def rates_of(placed: Placed, level: NoiseLevel) -> Rates | None:
    """The reported velocities of rows with a position; None where there are none. level: the noise of positions."""
    rows, count = placed.rows, placed.rows.height
    known = placed.measured

    def column(name: str) -> np.ndarray:
        if name not in rows.columns:
            return np.full(count, np.nan)
        return rows[name].to_numpy() if known.all() else np.where(known, rows[name].to_numpy(), np.nan)

    speed, course, slack, way = column("speed"), column("course"), np.zeros(count), None
    speed = np.where(np.abs(speed) < FASTEST, speed, np.nan)
    east, north = column("velocity_x"), column("velocity_y")
    if not np.isfinite(east).any() and np.isfinite(course).any():
        east, north = speed * np.sin(course), speed * np.cos(course)
    if np.isfinite(east).any():
        turned = placed.frame.anchor_convergence if isinstance(placed.frame, DevelopedFrame) else np.zeros(count)
        cos, sin = np.cos(turned), np.sin(turned)
        east, north = east * cos - north * sin, east * sin + north * cos
    elif np.isfinite(speed).any():
        way, slack = _way(placed, level.covariance, speed)
        east, north = speed * way[:, 0], speed * way[:, 1]
    up = column("vertical_rate") if placed.axes == 3 else np.full(count, np.nan)
    velocity = np.column_stack([east, north, up])
    if not np.isfinite(velocity).any():
        return None
    others = [column(name) for name in ("velocity_x", "velocity_y", "vertical_rate") if name in rows.columns]
    accuracy = np.column_stack([column("velocity_sd"), column("vertical_rate_sd")])
    fresh, off = _fresh([speed, course, *others], placed.new), _off(placed, velocity, way, level)
    usual = off[fresh & np.isfinite(off)]
    return Rates(velocity, way, slack, fresh, accuracy, off, float(MEDIAN * np.median(usual)) if usual.size else 0.0)


def _fresh(report: Sequence[np.ndarray], new: np.ndarray) -> np.ndarray:
    """Rows whose report is not that of the row before, in no quantity: receivers fill old ones in."""
    same = np.ones(new.size - 1, bool)
    for each in report:
        missing = np.isnan(each)
        same &= (each[1:] == each[:-1]) | (missing[1:] & missing[:-1])
    return new | np.r_[True, ~same]


def _way(placed: Placed, noise: RowNoise, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (N, 2) along which the last positions lead, and what their error makes of the speed (m/s).

    Each part's own noise and steps say how far back the way begins, so that no other target changes it.
    """
    known = placed.measured
    # of all rows a view is enough
    rows = slice(None) if known.all() else known
    part, plane, parts = np.cumsum(placed.new)[rows] - 1, placed.plane[rows], int(placed.new.sum())
    starts = np.diff(part, prepend=-1) != 0
    usual = np.nan_to_num(grouped_quantile(steps(plane, starts), part, parts, 0.5, least=1))
    error = 1.5 * np.nan_to_num(grouped_quantile(_across(noise)[rows], part, parts, 0.5, least=1))
    reach = np.clip(np.ceil(20.0 * error / np.maximum(usual, 1e-9)), 1, 10).astype(np.int64)
    some = part[starts]
    found, angle = native.ways(np.ascontiguousarray(plane), starts, reach[some], error[some])
    way, slack = np.full((placed.rows.height, 2), np.nan), np.zeros(placed.rows.height)
    way[rows], slack[rows] = found, 0.5 * np.nan_to_num(speed[rows]) * np.minimum(angle, 1.0)
    return way, slack


def _across(noise: RowNoise) -> np.ndarray:
    """The least sd (N,) of horizontal positions: that across the motion, where time stamps err along it."""
    xx, yy, xy = noise.variance(0), noise.variance(1), noise.covariance(0, 1)
    return np.sqrt(np.maximum(0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy), 0.0))


def joined(
    placed: Placed,
    noise: RowNoise,
    rates: Rates,
    sds: Mapping[str, float],
    fresh_only: Collection[str] = (),
    stated: Mapping[str, float] | None = None,
    names: Collection[str] | None = None,
) -> tuple[Placed, RowNoise]:
    """Measurements of position and velocity (N, 2 axes), and their noise.

    noise: of positions. sds: the usual ones; a row is as much rougher as what its source states is larger than what it
    usually states (`stated`). names: the rates that are measured (None: those of `sds`); fresh_only: those whose
    repeated reports are left out. Reports far from the motion that positions show are left out.
    """
    axes, count = placed.axes, placed.rows.height
    names = sds if names is None else names
    z = memory.empty((count, 2 * axes))
    z[:, :axes], z[:, axes:] = placed.z[:, :axes], rates.velocity[:, :axes]
    velocity = z[:, axes:]
    for name, columns in RATES.items():
        if name not in names:
            velocity[:, columns] = np.nan
        elif name in fresh_only:
            velocity[~rates.fresh, columns] = np.nan
    velocity[rates.off > FAR * max(rates.usual, sds.get("velocity", 0.0)), :2] = np.nan
    sd, up = (
        _sd(rates.accuracy[:, column], sds.get(name, 1.0), (stated or {}).get(name))
        for column, name in enumerate(RATES)
    )
    xx = yy = sd**2 + rates.slack**2
    correlated = {}
    if rates.way is not None:
        xx, yy, correlated[axes, axes + 1] = native.along_the_way(xx, rates.way, rates.velocity)
    both = noise.beside((xx, yy, np.full(count, up**2))[:axes], correlated)
    components = (*placed.components[:axes], *("vx", "vy", "vz")[:axes])
    return replace(placed, z=z, components=components), both


def _sd(accuracy: np.ndarray, usual: float, stated: float | None) -> np.ndarray | float:
    """Of reports whose source states `accuracy` (N,), and usually states `stated`."""
    return usual if stated is None else usual * np.nan_to_num(accuracy / stated, nan=1.0)


def _off(placed: Placed, velocity: np.ndarray, way: np.ndarray | None, level: NoiseLevel) -> np.ndarray:
    """The difference (N,) in m/s of each reported velocity from the one that positions show, along its way."""
    known, shown = placed.measured, level.velocity
    if shown is None:
        shown = rough_velocity(placed.time[known], placed.plane[known], placed.starts(known), usual=level.step)
    if not known.all():
        some, shown = shown, np.full((known.size, 2), np.nan)
        shown[known] = some
    return np.asarray(native.off(velocity, shown, way))
