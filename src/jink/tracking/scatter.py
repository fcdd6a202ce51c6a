"""How much measurements scatter, from themselves: third differences cancel motion and leave noise.

Over four successive times the weights  w_i = 1 / prod_{j≠i}(t_i − t_j)  annihilate any parabola, so

    d = Σ w_i z_i / √(Σ w_i²)

is the noise, with its own variance, whatever the steps (plus jerk, which is small against noise when reports
are frequent). Its median absolute value × 1.4826 is the standard deviation, untouched by outliers and
manoeuvres as long as they are a minority. A target that reports itself (ADS-B, AIS, GPS) is a source of its
own: transponders differ by a factor of eight.

In the plane the difference is taken along and across the direction of motion. Along it a target also seems
displaced by the error of its *time stamp*: at 200 m/s a tenth of a second is 20 m. So a source has two
figures, `position_sd` (from across) and `time_sd` (what along has more), and a measurement's covariance is
position_sd² I + time_sd² v vᵀ. For ADS-B with whole-second stamps this is the difference between 2 m and 15 m
across the track, where turns show.
"""

from __future__ import annotations

import numpy as np

from .._engine import native

MEDIAN, TAIL = (
    1.4826,
    1.0 / 1.6449,
)  # sd of a Gaussian over the 50 % and the 90 % quantile of its absolute values
WIDEST = 3.0  # usual steps: beyond, motion does not cancel
LEAST = 20  # differences needed for an estimate
ROUNDING = 1e-7  # m or rad: changes below it are of the arithmetic, not of a sensor
BLOCK = 4_000  # rows that are looked at together: few enough for the cache
MOVING = 5.0  # m/s: slower targets have no direction to speak of


def third_differences(
    time: np.ndarray, value: np.ndarray, new: np.ndarray, usual: float | None = None, spacing: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Noise-only combinations of four successive values of one track, and the index of the second.

    time (N,) s; value (N,) or (N, m); new (N,) marks the first row of each track; spacing: only every so many rows of
    a track are looked at. Windows with a step beyond three times the usual one (s; None: the median) are left out:
    there, motion would no longer cancel. So are windows in which nothing changes: a receiver at rest holds its
    position, a level flight its height, and neither shows noise.
    """
    time, values = np.ascontiguousarray(time), np.ascontiguousarray(value if value.ndim == 2 else value[:, None])
    usual = native.usual_step(time, new, spacing) if usual is None else usual
    longest = WIDEST * max(usual, 1e-9)
    found, index = native.third_differences(time, values, new, longest, ROUNDING, spacing)
    return found if value.ndim == 2 else found[:, 0], index


def component_sd(
    time: np.ndarray, value: np.ndarray, new: np.ndarray, group: np.ndarray, groups: int, usual: float | None = None
) -> np.ndarray:
    """Standard deviation of one measured component by group (G,), at least its step of quantisation over √12.

    group (N,) numbers the source (or target) of each row below `groups`; NaN where there was too little. A value that
    only repeats, as the height of a level flight does, says nothing of its error; one that changes now and then has
    at least the step.
    """
    difference, index = third_differences(time, value, new, usual)
    sd = MEDIAN * grouped_quantile(np.abs(difference), group[index], groups, 0.5)
    step = np.diff(value, prepend=np.nan)
    step[new] = np.nan
    # a steady climb has steps of any size, but what they differ by is no less than the step of quantisation
    change = np.abs(np.diff(step, prepend=np.nan))
    change[change < ROUNDING] = np.nan
    resolution = grouped_quantile(change, group, groups, 0.01, least=1) / np.sqrt(12.0)
    resolution[np.bincount(group, minlength=groups) < LEAST + 3] = np.nan
    return np.fmax(np.where(sd < ROUNDING, np.nan, sd), resolution)


def plane_scatter(
    time: np.ndarray,
    plane: np.ndarray,
    velocity: np.ndarray,
    new: np.ndarray,
    group: np.ndarray,
    groups: int,
    usual: float | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Scatter of positions (m) and of time stamps (s) by group, (G,) each; NaN where there was too little.

    plane (N, 2) m, velocity (N, 2) m/s (rough), group (N,) as in `component_sd`. The position's figure comes
    from the median, the time stamps' from the 90 % quantile: they are rounded and delayed, and their errors
    have shoulders, not tails.
    """
    difference, index = third_differences(time, plane, new, usual)
    of = group[index]
    across, along, speed = native.across_and_along(difference, index, np.ascontiguousarray(velocity), MOVING)
    count = np.bincount(of, minlength=groups)
    moving = np.bincount(of, weights=np.isfinite(speed), minlength=groups) > np.maximum(0.2 * count, LEAST)
    position = MEDIAN * grouped_quantile(across, of, groups, 0.5)
    stamps = TAIL * grouped_quantile(along, of, groups, 0.9)
    own = position * grouped_quantile(1.0 / speed, of, groups, 0.5)
    either = MEDIAN * grouped_quantile(np.abs(difference), of, groups, 0.5)
    typical = MEDIAN * grouped_quantile(along, of, groups, 0.5)  # turns make the 90 % quantile of slow sensors grow
    timed = moving & (typical > 1.5 * own) & (stamps > own)
    step = steps(plane, new)
    least = 1e-3 + 1e-3 * np.nan_to_num(grouped_quantile(step, group, groups, 0.5))
    with np.errstate(invalid="ignore"):
        time_sd = np.where(timed, np.sqrt(np.maximum(stamps**2 - own**2, 0.0)), 0.0)
        return np.maximum(np.where(timed, position, either), least), time_sd


def steps(plane: np.ndarray, new: np.ndarray) -> np.ndarray:
    """How far (m) each position (N, 2) is from the one before; NaN for first rows of tracks (N,)."""
    step = np.full(len(plane), np.nan)
    for begin in range(1, len(plane), BLOCK):
        east, north = np.diff(plane[begin - 1 : begin + BLOCK], axis=0).T
        np.hypot(east, north, out=step[begin : begin + BLOCK])
    step[new] = np.nan
    return step


def grouped_quantile(value: np.ndarray, group: np.ndarray, groups: int, share: float, least: int = LEAST) -> np.ndarray:
    """Quantile of the known values of every group (G,); NaN where fewer than `least` are known.

    value (N,) or (N, m), group (N,).
    """
    value, group = np.ascontiguousarray(value), np.ascontiguousarray(group)
    return np.asarray(native.grouped_quantile(value, group, groups, share, least))


def rough_velocity(
    time: np.ndarray, plane: np.ndarray, new: np.ndarray, seconds: float = 2.0, usual: float | None = None
) -> np.ndarray:
    """Velocity (N, 2) in m/s: the median of a step back, one forward and a wide one, so no jump decides it.

    A step reaches over about `seconds` at the usual rate (one row in `usual` s; None: as the median step says), at
    least one row; 0 where a track is a single position.
    """
    count = time.size
    if count < 2:
        return np.zeros((count, 2))
    time, plane = np.ascontiguousarray(time), np.ascontiguousarray(plane)
    usual = native.usual_step(time, new, 1) if usual is None else usual
    reach = int(np.clip(np.ceil(seconds / max(usual, 1e-9)), 1, 50))
    return np.asarray(native.rough_velocity(time, plane, new, reach))
