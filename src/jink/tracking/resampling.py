"""Tracks at even times: rows between the measurements, predicted (or smoothed) from these, with their own sds.

A filter meets the even times as rows without a measurement, so a gap is bridged by its own prediction, whose sd grows.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl

from .._engine import native
from ..filters.row_noise import RowNoise
from ..frozen import frozen
from ..io.errors import InputError
from ..io.geodesy import DevelopedFrame
from ..io.units import TIME
from ..times import duration
from .placing import Placed

MOST = 20_000_000  # rows: more does not fit into memory
CLOSE = 1e-6  # s: times that are one


@frozen
class Resampled:
    """Measurements with rows at even times between them: covariance by row, and which rows are at even times."""

    placed: Placed
    covariance: RowNoise | None
    even: np.ndarray


def parse_every(given: float | str | None) -> float | None:
    """`1s`, `500ms`, `1min` or a number of seconds. Errors: InputError."""
    if given is None:
        return None
    value = duration(str(given).strip(), TIME)
    if np.isnan(value):
        raise InputError(f"every is {given!r}; expected a time such as 1s, 500ms or 1min")
    return value


def noise_of_steps(filter: Any) -> bool:
    """Is the process noise of a mode that of a step from row to row, so that rows between others change it?

    It is where two steps from rest, F Q Fᵀ + Q, have another noise than one of twice the time.
    """
    return any(_of_steps(mode.native(filter.sensors[0].axes)) for mode in filter.motions if hasattr(mode, "native"))


def _of_steps(mode: Any) -> bool:
    states = len(mode.prior_variance)
    x, P = np.zeros((2, states)), np.zeros((2, states, states))
    _, F, Q = native.linearise_motion(mode, False, np.array([1.0, 2.0]), x, P, None)
    return not np.allclose(F[0] @ Q[0] @ F[0].T + Q[0], Q[1], rtol=1e-6, atol=1e-12 * Q[1].max())


def resampled(placed: Placed, covariance: RowNoise | None, step: float) -> Resampled:
    """Rows at the multiples of `step` (s) within each part, beside the measured ones. Errors: InputError."""
    clock = placed.rows["time"].to_numpy()
    starts, ends = placed.offsets[:-1], placed.offsets[1:] - 1
    first = np.ceil(clock[starts] / step - CLOSE).astype(np.int64)
    last = np.floor(clock[ends] / step + CLOSE).astype(np.int64)
    count = np.maximum(last - first + 1, 0)
    if count.sum() > MOST:
        raise InputError(f"every is {step:g} s, which makes {count.sum():,} rows; expected at most {MOST:,}")
    of = np.repeat(np.arange(starts.size), count)
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    times = (first[of] + number) * step
    # the row that each even time follows, within its part
    part = np.cumsum(placed.new) - 1
    shift = (clock.max() - clock.min() + 1.0) * np.arange(starts.size)
    after = np.searchsorted(clock + shift[part], times + shift[of] + CLOSE, side="right") - 1
    after = np.clip(after, starts[of], ends[of])
    there = np.abs(clock[after] - times) <= CLOSE
    even = np.zeros(clock.size, bool)
    even[after[there]] = True
    new_times, new_after = times[~there], after[~there]
    source = np.r_[np.arange(clock.size), new_after]
    extra = np.r_[np.zeros(clock.size, bool), np.ones(new_after.size, bool)]
    order = np.lexsort((np.r_[clock, new_times], part[source]))
    source, extra, at = source[order], extra[order], np.r_[clock, new_times][order]
    return Resampled(
        _at(placed, source, extra, at),
        None if covariance is None else covariance.some(source),
        np.where(extra, True, even[source]),
    )


def _at(placed: Placed, source: np.ndarray, extra: np.ndarray, clock: np.ndarray) -> Placed:
    """Rows by their numbers; those that are extra have no measurement, and times of their own."""
    begin = placed.rows["time"].to_numpy() - placed.time
    some = placed.some(source)
    missing = pl.Series(extra)
    gone = [name for name in ("file", "row") if name in some.rows.columns]
    rows = some.rows.with_columns(
        pl.Series("time", clock),
        pl.lit(False).alias("measured") if extra.all() else pl.col("measured") & ~missing,
        *[pl.when(missing).then(None).otherwise(pl.col(name)).alias(name) for name in gone],
    )
    z, plane, height = some.z.copy(), some.plane.copy(), some.height.copy()
    z[extra], plane[extra], height[extra] = np.nan, np.nan, np.nan
    frame = some.frame
    if isinstance(frame, DevelopedFrame):
        frame = replace(frame, x=plane[:, 0], y=plane[:, 1])
    return replace(
        some,
        rows=rows,
        time=np.where(extra, clock - begin[source], some.time),
        z=np.ascontiguousarray(z),
        plane=plane,
        height=height,
        new=some.new & ~extra,
        frame=frame,
    )
