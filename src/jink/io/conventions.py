"""What the user says of times and axes, and what reading a column of times gives."""

from __future__ import annotations

from dataclasses import field

import numpy as np
import polars as pl

from ..frozen import frozen
from .errors import InputError


@frozen
class Conventions:
    """What the user says of times and axes: day_first, time_format (strftime), time_zone of times without one; axes
    `enu` or `ned`; azimuth clockwise from `north` or from `grid` north, or counter-clockwise from `east` (the x axis);
    crs: the projection of x and y, or of grid north; grid_turn: azimuth (rad) of grid north, once it is known.
    """

    day_first: bool | None = None
    time_format: str | None = None
    time_zone: str | None = None
    axes: str | None = None
    azimuth: str | None = None
    crs: str | None = None
    grid_turn: float | None = None

    def __post_init__(self) -> None:
        for name in ("time_format", "time_zone"):
            value = getattr(self, name)
            if value is not None and not (isinstance(value, str) and value.isprintable()):
                raise InputError(f"{name} is {value!r}; expected a text that can be printed")
        for name, value, known in (
            ("axes", self.axes, ("enu", "ned")),
            ("azimuth_from", self.azimuth, ("north", "east", "grid")),
        ):
            if value is not None and value not in known:
                raise InputError(f"{name} is {value!r}; expected {' or '.join(map(repr, known))}")


NONE = Conventions()
YEARS = -6.21e10, 2.5e11  # s since 1970: the years 2 and 9892; what writes dates knows no others


@frozen
class Times:
    """Seconds (since 1970 when `absolute`), NaN where unreadable, and what had to be assumed.

    `of_day`: seconds since midnight of days that are not known.
    """

    seconds: np.ndarray
    absolute: bool
    notes: list[str] = field(default_factory=list)
    of_day: bool = False


def in_zone(seconds: np.ndarray, naive: np.ndarray | None, how: Conventions) -> np.ndarray:
    """Wall-clock times without a zone (all, or those marked) in the user's zone to UTC; of an hour that comes twice
    the first.
    """
    if how.time_zone is None:
        return seconds
    wall = pl.Series(np.round(np.nan_to_num(in_calendar(seconds)) * 1e6).astype("int64")).cast(pl.Datetime("us"))
    try:
        local = wall.dt.replace_time_zone(how.time_zone, ambiguous="earliest", non_existent="null")
    except pl.exceptions.PolarsError:
        raise InputError(f"--time-zone is {how.time_zone!r}; expected a name such as Europe/Berlin or UTC") from None
    there = np.where(np.isfinite(seconds), epoch_seconds(local.dt.convert_time_zone("UTC")), np.nan)
    return there if naive is None else np.where(naive, there, seconds)


def in_calendar(seconds: np.ndarray) -> np.ndarray:
    """Seconds since 1970, NaN for instants that no calendar can write."""
    with np.errstate(invalid="ignore"):
        return np.where((seconds > YEARS[0]) & (seconds < YEARS[1]), seconds, np.nan)


def epoch_seconds(series: pl.Series) -> np.ndarray:
    """A column of dates or date-times as seconds since 1970, also of those that no calendar can write."""
    if series.dtype == pl.Date:
        days = series.cast(pl.Int32).cast(pl.Float64).fill_null(float("nan")).to_numpy()
        return days * 86_400.0
    unit = getattr(series.dtype, "time_unit", "us")
    ticks = series.cast(pl.Int64) // 1000 if unit == "ns" else series.cast(pl.Int64)
    micros = ticks.cast(pl.Float64).fill_null(float("nan")).to_numpy()
    return micros * 1e-6 if unit != "ms" else micros * 1e3 * 1e-6
