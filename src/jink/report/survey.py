"""A folder of tracks in numbers: every target in a line, targets over time, rows per cell of a map, consistency.

One group of rows is in memory at a time, so the folder may be of any size.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import polars as pl

from ..archive.tracked import Tracks
from ..checks import Array
from ..estimate import Status
from ..frozen import frozen
from .consistency import BINS, Consistency, consistency
from .plan import EARTH_RADIUS, plan_points
from .rows import seconds_of, status_of

SPANS = 240  # of time, in which targets are counted
CELLS = 360  # of the map, along its longer side
_SAMPLE = 1_000_000  # rows that decide what the map shows
_TAIL = 0.0005  # of the sample on each side; the map shows the rest and a margin
_MARGIN = 0.04
_COLUMNS = ("target", "time", "status", "nis", "nis_dof")


@frozen
class Extent:
    """What a map shows: metres east and north; frame as of :func:`~jink.report.plan.plan_coordinates`, or None."""

    east: tuple[float, float]
    north: tuple[float, float]
    frame: dict[str, float] | None

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns) of its cells, which are square."""
        width, height = self.east[1] - self.east[0], self.north[1] - self.north[0]
        cell = max(width, height) / CELLS
        return max(1, math.ceil(height / cell)), max(1, math.ceil(width / cell))

    def place(self, frame: pl.DataFrame) -> tuple[Array, Array]:
        """East and north of the rows of a table, in metres."""
        return _place(frame, self.frame)

    def counted(self, frame: pl.DataFrame) -> tuple[Array, int]:
        """(rows per cell (R, C) from the south-west, rows that are outside)."""
        east, north = self.place(frame)
        known = np.isfinite(east) & np.isfinite(north)
        counts, _, _ = np.histogram2d(north[known], east[known], bins=self.shape, range=(self.north, self.east))
        return counts, int(known.sum() - counts.sum())


@frozen(kw_only=True)
class Survey:
    """targets: target, rows, begin, end (seconds), gated, compared, inside (rows of NIS in its 95 % band).

    active (SPANS,): targets that have rows in each span between begin and end; density (R, C): rows per cell;
    outside: rows beyond the map; check: consistency of all rows.
    """

    targets: pl.DataFrame
    clock: bool
    begin: float
    end: float
    active: Array
    extent: Extent
    density: Array
    outside: int
    check: Consistency


def survey(tracks: Tracks, say: Callable[[str], None] | None = None) -> Survey:
    """Read the folder once. say: told how far it is."""
    clock, begin, end = _span(tracks)
    columns = _position_columns(tracks)
    extent = _extent(tracks, columns)
    density, outside, active = np.zeros(extent.shape), 0, np.zeros(SPANS)
    lines: list[pl.DataFrame] = []
    checks: list[Consistency] = []
    for number, bucket in enumerate(tracks.buckets):
        seen, some = [], []
        for frame in tracks.frames(bucket, [*_COLUMNS, *columns]):
            counts, beyond = extent.counted(frame)
            density += counts
            outside += beyond
            line, check, spans = _lines(frame, begin, end)
            some.append(line)
            checks.append(check)
            seen.append(spans)
        lines.append(_joined(some))
        active += np.bincount(pl.concat(seen).unique()["span"].to_numpy(), minlength=SPANS)
        if say is not None:
            say(f"bucket {number + 1} of {len(tracks.buckets)}")
    return Survey(
        targets=pl.concat(lines).sort("target"),
        clock=clock,
        begin=begin,
        end=end,
        active=active,
        extent=extent,
        density=density,
        outside=outside,
        check=_together(checks),
    )


def _span(tracks: Tracks) -> tuple[bool, float, float]:
    """(whether times are dates, first and last second of all rows)."""
    found = [time for bucket in tracks.buckets for span in tracks.spans(bucket) for time in span]
    clock, seconds = seconds_of(pl.Series([min(found), max(found)]))
    return clock, float(seconds[0]), float(seconds[1])


def _position_columns(tracks: Tracks) -> tuple[str, str]:
    """Latitude and longitude, or x and y."""
    there = next(tracks.frames(tracks.buckets[0])).columns
    return ("latitude", "longitude") if {"latitude", "longitude"} <= set(there) else ("x", "y")


def _extent(tracks: Tracks, columns: tuple[str, str]) -> Extent:
    """Where nearly all rows of the first buckets are: a fair sample, for buckets go by a hash of the name."""
    frames, rows = [], 0
    for bucket in tracks.buckets:
        for frame in tracks.frames(bucket, columns):
            frames.append(frame.drop_nulls())
            rows += frames[-1].height
        if rows >= _SAMPLE:
            break
    sample = pl.concat(frames)
    frame = _frame(sample) if columns[0] == "latitude" else None
    sides = []
    for values in _place(sample, frame):
        low, high = np.nanquantile(values, (_TAIL, 1.0 - _TAIL)) if values.size else (0.0, 1.0)
        sides.append((float(low), float(high)))
    margin = _MARGIN * max(max(high - low for low, high in sides), 1.0)
    east, north = ((low - margin, high + margin) for low, high in sides)
    return Extent(east, north, frame)


def _frame(sample: pl.DataFrame) -> dict[str, float]:
    """The origin in the middle of the sample."""
    latitude, longitude = (sample[name].to_numpy() for name in ("latitude", "longitude"))
    turn = np.exp(1j * np.radians(longitude)).mean() if longitude.size else 1.0
    middle = float(np.clip(np.median(latitude), -85.0, 85.0)) if latitude.size else 0.0
    return {"latitude": middle, "longitude": float(np.degrees(np.angle(turn))), "radius": EARTH_RADIUS}


def _place(table: pl.DataFrame, frame: dict[str, float] | None) -> tuple[Array, Array]:
    if frame is None:
        return table["x"].cast(pl.Float64).to_numpy(), table["y"].cast(pl.Float64).to_numpy()
    latitude, longitude = (table[name].cast(pl.Float64).to_numpy() for name in ("latitude", "longitude"))
    return plan_points(frame, latitude, longitude)


def _lines(frame: pl.DataFrame, begin: float, end: float) -> tuple[pl.DataFrame, Consistency, pl.DataFrame]:
    """(a line per target, consistency, the spans in which each target has rows)."""
    frame = frame.with_columns(pl.col("target").cast(pl.String), seconds_of(frame["time"])[1].alias("time"))
    names = frame["target"].unique(maintain_order=True)
    number = frame["target"].replace_strict(names, pl.int_range(len(names), eager=True)).to_numpy().astype(np.int64)
    status = status_of(frame)
    check = consistency(
        number, len(names), _numbers(frame, "nis"), _numbers(frame, "nis_dof"), status == Status.updated
    )
    ends = frame.group_by("target", maintain_order=True).agg(
        rows=pl.len(), begin=pl.col("time").min(), end=pl.col("time").max()
    )
    gated = np.bincount(number[status == Status.gated], minlength=len(names))
    line = ends.with_columns(gated=pl.Series(gated), compared=pl.Series(check.compared), inside=pl.Series(check.inside))
    share = (pl.col("time") - begin) / max(end - begin, 1e-9) * SPANS
    spans = frame.select("target", span=share.floor().clip(0, SPANS - 1).cast(pl.Int32)).unique()
    return line, check, spans


def _numbers(frame: pl.DataFrame, name: str) -> Array:
    if name not in frame.columns:
        return np.full(frame.height, np.nan)
    return frame[name].cast(pl.Float64).fill_null(np.nan).to_numpy()


def _joined(lines: list[pl.DataFrame]) -> pl.DataFrame:
    """A line per target, where groups of rows may have parted one."""
    sums: list[Any] = [pl.col(name).sum() for name in ("gated", "compared", "inside")]
    ends = [pl.col("rows").sum(), pl.col("begin").min(), pl.col("end").max()]
    return pl.concat(lines).group_by("target").agg(*ends, *sums)


def _together(checks: list[Consistency]) -> Consistency:
    """That of all rows; per target it is in the lines, so the arrays have one element."""

    def total(name: str) -> Array:
        return np.array([sum(int(getattr(check, name).sum()) for check in checks)])

    compared = total("compared")
    ratios = [check.mean_ratio * int(check.compared.sum()) for check in checks if check.compared.any()]
    histogram = np.sum([check.histogram for check in checks], axis=0) if checks else np.zeros(BINS)
    ratio = sum(ratios) / compared[0] if compared[0] else math.nan
    bands = {dof: band for check in checks for dof, band in check.bands.items()}
    return Consistency(compared, total("inside"), total("below"), total("above"), histogram, ratio, bands)
