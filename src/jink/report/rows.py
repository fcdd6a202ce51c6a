"""The rows of a tracks table as NumPy arrays: sorted by target, part and time, NaN where missing."""

import numpy as np
import polars as pl

from ..estimate import STATUS, Status
from ..frozen import frozen


@frozen
class TrackRows:
    """Rows of every target, contiguous per target, in the order of `names`.

    target (N,) index into names; part (N,); time (N,) seconds (since 1970 UTC if clock); status (N,) of
    :class:`~jink.estimate.Status`; first (T + 1,) start of each target's rows.
    """

    names: list[str]
    target: np.ndarray
    part: np.ndarray
    time: np.ndarray
    clock: bool
    status: np.ndarray
    first: np.ndarray
    frame: pl.DataFrame

    def __len__(self) -> int:
        return self.target.size

    def has(self, *names: str) -> bool:
        """Whether every one of these columns exists."""
        return all(name in self.frame.columns for name in names)

    def column(self, name: str) -> np.ndarray:
        """A numeric column as float64 (N,), NaN for nulls and where there is no such column."""
        if name not in self.frame.columns:
            return np.full(len(self), np.nan)
        values = self.frame[name].cast(pl.Float64, strict=False).fill_null(np.nan).to_numpy()
        return np.where(np.isfinite(values), values, np.nan)

    @property
    def modes(self) -> list[str]:
        """Names of the filter's modes, from the probability_ columns."""
        return [c.removeprefix("probability_") for c in self.frame.columns if c.startswith("probability_")]


def read_rows(tracks: pl.DataFrame) -> TrackRows:
    """Sort and convert a tracks table.

    Raises ValueError naming the columns that are missing: target, time and latitude, longitude or x, y are
    needed.
    """
    found = tracks.columns
    for needed in ("target", "time"):
        if needed not in found:
            raise ValueError(f"tracks: expected a column {needed!r}; found {', '.join(found) or 'none'}")
    if not ({"latitude", "longitude"} <= set(found) or {"x", "y"} <= set(found)):
        raise ValueError(f"tracks: expected columns latitude and longitude, or x and y; found {', '.join(found)}")
    clock, seconds = seconds_of(tracks["time"])
    part = pl.col("part").cast(pl.Int64).fill_null(0) if "part" in found else pl.lit(0, dtype=pl.Int64)
    frame = tracks.with_columns(
        pl.col("target").cast(pl.String).fill_null("(no name)"), part.alias("part"), seconds.alias("time")
    ).filter(pl.col("time").is_finite())
    if not frame.select(_in_order("target", "part", "time")).item():
        frame = frame.sort("target", "part", "time", maintain_order=True)
    names = frame["target"].unique(maintain_order=True)
    target = frame["target"].rle_id().to_numpy().astype(np.int64)
    first = np.searchsorted(target, np.arange(len(names) + 1))
    return TrackRows(
        names.to_list(),
        target,
        frame["part"].to_numpy(),
        frame["time"].to_numpy(),
        clock,
        status_of(frame),
        first,
        frame,
    )


def _in_order(*names: str) -> pl.Expr:
    """Whether no row stands before the one above it, as jink's own tables are."""
    order = pl.lit(True)
    for name in reversed(names):
        above = pl.col(name).shift(1)
        order = (pl.col(name) > above) | (pl.col(name) == above) & order
    return order.all(ignore_nulls=True)


def seconds_of(time: pl.Series) -> tuple[bool, pl.Series]:
    """(whether it is a date and time, float seconds)."""
    if time.dtype == pl.Date:
        time = time.cast(pl.Datetime("us"))
    if isinstance(time.dtype, pl.Datetime):
        return True, time.dt.epoch("us").cast(pl.Float64) / 1e6
    return False, time.cast(pl.Float64, strict=False)


def status_of(frame: pl.DataFrame) -> np.ndarray:
    if "status" not in frame.columns:
        return np.full(frame.height, Status.updated, dtype=np.uint8)
    text = frame["status"].cast(pl.String)
    return text.replace_strict(STATUS, list(Status), default=Status.none, return_dtype=pl.UInt8).to_numpy()
