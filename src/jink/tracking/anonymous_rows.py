"""Rows of plots in scans, and rows of tracks made of them, as the filters and tables of `track` want them."""

from __future__ import annotations

import numpy as np
import polars as pl

from ..association.batch import Found, Scans, Turning
from ..catalogue.choose import EARTH_RADIUS
from ..io.errors import InputError
from ..io.geodesy import DevelopedFrame, SiteFrame, lines_of_sight
from ..io.kept import MARK
from ..io.measurements import Measurements
from .antenna import antenna_of
from .cleaning import measured_rows
from .placing import Placed, lay
from .unknown_height import VARIANCE

SECTORS = 16  # to a turn of the antenna, where nothing else is said


def placed_plots(measurements: Measurements, site: SiteFrame | None) -> Placed:
    """All plots with a position, by time. Places on the map are laid into the plane around their middle."""
    rows = measurements.rows.with_columns(measured_rows(measurements.rows, measurements.position))
    rows = (
        rows.filter("measured")
        .with_columns(target=pl.lit("0"), part=pl.lit(0, pl.Int32))
        .sort("time", maintain_order=True)
    )
    wanted = {"cartesian": ("z",), "polar": ("elevation", "altitude"), "geographic": ()}[measurements.position]
    third = next((name for name in wanted if name in rows.columns and rows[name].is_finite().all()), None)
    position = measurements.position
    if position == "geographic" and rows.height:
        site, rows = _in_the_plane(rows)
        position = "cartesian"
    return lay(rows, position, site, 3 if third else 2, third) if rows.height else _none(rows)


def heights_above(plots: Placed) -> np.ndarray | None:
    """How high above the radar the targets of plots (N,) are, NaN where a plot does not say it; None: no plot does."""
    rows, slant = plots.rows, plots.z[:, 0]
    low = plots.frame.altitude if isinstance(plots.frame, SiteFrame) else 0.0
    above = np.full(rows.height, np.nan)
    if "altitude" in rows.columns:
        above = rows["altitude"].to_numpy() - low
    if "elevation" in rows.columns:
        up = slant * np.sin(rows["elevation"].to_numpy())
        high = np.sqrt(slant**2 + EARTH_RADIUS * (EARTH_RADIUS + 2.0 * up)) - EARTH_RADIUS
        above = np.where(np.isfinite(high), high, above)
    return above if np.isfinite(above).any() else None


def scans_of(plots: Placed, period: float | None, sectors: int | None = None) -> Scans:
    """The plots in scans: rows of one time, or of one turn of an antenna.

    period (s) of a scan where every plot has a time of its own. sectors of a turn: 1 takes it whole, None takes 16
    where azimuths go with times; with another number the period need not be given. Errors: InputError where scans
    cannot be told.
    """
    time = plots.rows["time"].to_numpy()
    wanted = sectors not in (None, 1) or (sectors is None and period is not None)
    antenna = antenna_of(time, _azimuth(plots), period) if wanted else None
    if sectors not in (None, 1) and antenna is None:
        about = "" if period is None else f" in {period:g} s"
        raise InputError(
            f"sectors: azimuths of the plots do not go with their times, as with an antenna that turns{about}; "
            "leave --sectors out, or check --period and where the antenna stands (0, 0)"
        )
    turning = None
    if antenna is not None:
        period = antenna.period
        count = SECTORS if sectors is None else sectors
        turning = Turning(period, count, antenna.clockwise) if count > 1 else None
    if period is None and _distinct(time):
        found = antenna_of(time, _azimuth(plots))
        turn = (
            ""
            if found is None
            else f"; their azimuths go with their times, as with one that takes {found.period:.4g} s"
        )
        raise InputError(
            f"plots have {len(np.unique(time)):,} different times in {len(time):,} rows, so scans cannot be told; "
            f"give --period SECONDS, the time of one scan{turn}"
        )
    begin, middle = _scans(time, period)
    return Scans(middle, begin, plots.z, own=None if period is None else time, turning=turning)


def _azimuth(plots: Placed) -> np.ndarray:
    """Of each plot, from where the antenna stands (rad)."""
    if plots.components[0] == "range":
        return plots.z[:, 1]
    return np.arctan2(plots.z[:, 0], plots.z[:, 1])


def _none(rows: pl.DataFrame) -> Placed:
    empty = np.zeros(0)
    return Placed(rows, empty, np.zeros((0, 2)), np.zeros((0, 2)), empty, np.zeros(0, bool), 2, ("x", "y"), None)


def _in_the_plane(rows: pl.DataFrame) -> tuple[SiteFrame, pl.DataFrame]:
    """Distance and direction along the ground from the middle of all places (azimuthal equidistant)."""
    latitude, longitude = rows["latitude"].to_numpy(), rows["longitude"].to_numpy()
    around = np.exp(1j * np.radians(longitude)).mean()
    centre = float(np.median(latitude)), float(np.degrees(np.angle(around)))
    site = SiteFrame(*centre)
    length, course, _ = lines_of_sight(site, latitude, longitude)
    return site, rows.with_columns(x=length * np.sin(course), y=length * np.cos(course))


def _scans(time: np.ndarray, period: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Rows of one time are a scan; or, with a period, rows of one turn of the antenna, at their mean time."""
    if not len(time):
        return np.zeros(1, np.int64), time
    if period is not None:
        cut = _cut(time, period)
        turn = np.floor((time - cut) / period).astype(np.int64)
        begin = np.flatnonzero(np.r_[True, np.diff(turn) > 0])
        return np.r_[begin, len(time)], cut + (turn[begin] + 0.5) * period
    begin = np.flatnonzero(np.r_[True, np.diff(time) > 0])
    return np.r_[begin, len(time)], time[begin]


def _distinct(time: np.ndarray) -> bool:
    """Has nearly every row a time of its own?"""
    return len(time) > 20 and len(np.unique(time)) > 0.7 * len(time)


def _cut(time: np.ndarray, period: float) -> float:
    """A time between two turns: where within the period plots leave the longest gap."""
    phase = np.sort(np.mod(time - time[0], period))
    gap = np.diff(np.r_[phase, phase[0] + period])
    widest = int(np.argmax(gap))
    return float(time[0] + phase[widest] + gap[widest] / 2 - period)


def placed_tracks(plots: Placed, found: Found) -> Placed:
    """The rows of tracks, by track: where a plot is taken its row, else nothing measured."""
    new = np.r_[True, np.diff(found.id) != 0] if len(found.id) else np.zeros(0, bool)
    seen = found.plot >= 0
    at = np.where(seen, found.plot, 0)
    number = np.cumsum(new)

    def taken(values: np.ndarray) -> np.ndarray:
        out = values[at].copy()
        out[~seen] = np.nan
        return out

    source = plots.rows[at]
    first = plots.rows["time"][0] if plots.rows.height else 0.0
    absolute = found.time
    missing = pl.Series(~seen)
    carried = [name for name in source.columns if name.startswith(MARK)]
    said = [name for name in ("position_sd", "altitude_sd", "altitude") if name in source.columns]
    unknown = [VARIANCE] if VARIANCE in source.columns else []
    rows = source.select("file", "row", "source", *said, *unknown, *carried)
    rows = rows.with_columns(
        *[pl.when(missing).then(None).otherwise(pl.col(name)).alias(name) for name in ("row", *unknown, *carried)],
        target=pl.Series(number).cast(pl.String),
        part=pl.lit(0, pl.Int32),
        time=pl.Series(absolute),
        measured=pl.Series(seen),
    )
    starts = np.flatnonzero(new)
    since = absolute - first
    since -= np.repeat(since[starts], np.diff(np.r_[starts, len(since)])) if len(starts) else 0.0
    frame = plots.frame
    assert not isinstance(frame, DevelopedFrame)
    return Placed(
        rows,
        since,
        taken(plots.z),
        taken(plots.plane),
        taken(plots.height),
        new,
        plots.axes,
        plots.components,
        frame,
    )
