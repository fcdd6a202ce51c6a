"""Times in: date-times, ISO 8601 or slashed text, numbers since 1970 in any usual unit, plain seconds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import polars as pl

from .columns import TIME
from .errors import InputError

# a number this large (median of the absolute values) counts these units since 1970; below 1e8: plain seconds
SIZES = ((1e17, "ns", 1e-9), (1e14, "us", 1e-6), (1e11, "ms", 1e-3), (1e8, "s", 1.0))
LATEST = 2.5e11  # s since 1970: the year 9892
FORMATS = ("%d/%m/%Y %H:%M:%S%.f", "%m/%d/%Y %H:%M:%S%.f", "%Y/%m/%d %H:%M:%S%.f", "%d.%m.%Y %H:%M:%S%.f")


@dataclass(frozen=True)
class Times:
    """Seconds (since 1970 when `absolute`), NaN where unreadable, and what had to be assumed."""

    seconds: np.ndarray
    absolute: bool
    notes: list[str]


def read_times(where: str, series: pl.Series, unit: float | None, time_unit: str | None) -> Times:
    """A column of times to seconds; `unit` is the name's, `time_unit` the user's. Without a zone: UTC."""
    if series.dtype in (pl.Categorical, pl.Enum):
        series = series.cast(pl.String)
    if isinstance(series.dtype, pl.Datetime) or series.dtype == pl.Date:
        return Times(_epoch_seconds(series.cast(pl.Datetime("us", getattr(series.dtype, "time_zone", None)))), True, [])
    if series.dtype in (pl.Duration, pl.Time):
        return Times(
            series.cast(pl.Int64).cast(pl.Float64).fill_null(float("nan")).to_numpy() * _tick(series.dtype),
            False,
            [],
        )
    if series.dtype == pl.String:
        text = series.str.strip_chars()
        value = text.cast(pl.Float64, strict=False)
        if value.count() < 0.5 * text.count():
            return _text_times(where, text)
        series = value
    if not series.dtype.is_numeric():
        return Times(np.full(len(series), np.nan), False, [])
    value = series.cast(pl.Float64).fill_null(float("nan")).to_numpy().copy()
    value[~np.isfinite(value)] = np.nan
    return _numeric_times(value, TIME[time_unit] if time_unit else unit)


def _numeric_times(value: np.ndarray, unit: float | None) -> Times:
    known = value[np.isfinite(value)]
    size = float(np.quantile(np.abs(known), 0.5, method="lower")) if known.size else 0.0
    if unit is not None:
        seconds = np.where(np.abs(value * unit) < LATEST, value * unit, np.nan)
        return Times(seconds, size * unit >= 1e8, [])
    for least, name, factor in SIZES:
        if size >= least:
            value = np.where(np.abs(value * factor) < LATEST, value, np.nan)
            note = [] if name == "s" else [f"times are taken as {name} since 1970"]
            return Times(value * factor, True, note)
    return Times(value, False, [])


def _text_times(where: str, text: pl.Series) -> Times:
    """ISO 8601 first; then slashed dates, day first or month first, whichever reads every value."""
    iso = _iso(text)
    wanted = text.count()
    if iso.count() >= 0.5 * wanted or wanted == 0:
        return Times(_epoch_seconds(iso), True, [])
    read = {form: text.str.to_datetime(form, time_unit="us", strict=False) for form in FORMATS}
    best = max(series.count() for series in read.values())
    fitting = [form for form, series in read.items() if series.count() == best]
    if best == 0:
        return Times(_epoch_seconds(iso), True, [])
    first = read[fitting[0]]
    if len(fitting) > 1 and any(not first.equals(read[form], null_equal=True) for form in fitting[1:]):
        raise InputError(
            f"{where}: times such as {text.drop_nulls()[0]!r} can be read day first or month first; "
            "write them as ISO 8601 (2024-05-31T12:00:00Z)"
        )
    return Times(_epoch_seconds(first), True, [f"times are read as {fitting[0].removesuffix('%.f')}, UTC"])


def _iso(text: pl.Series) -> pl.Series:
    """ISO 8601 with `T` or a blank, with a fraction or not, with Z, an offset or nothing (then UTC)."""
    plain = text.str.replace(r"^(\d{4}-\d{2}-\d{2}) ", "${1}T").str.replace(r"(?i) ?(utc|z)$", "+00:00")
    plain = plain.str.replace(r"([+-]\d{2})(\d{2})$", "${1}:${2}").str.replace(r"(T.*[+-]\d{2})$", "${1}:00")
    zoned = pl.when(plain.str.contains(r"T.*[+-]\d{2}:\d{2}$")).then(plain).otherwise(plain + "+00:00")
    complete = pl.select(zoned).to_series().str.replace(r"^(\d{4}-\d{2}-\d{2})\+", "${1}T00:00:00+")
    complete = complete.str.replace(r"T(\d{2}:\d{2})\+", "T${1}:00+")
    return complete.str.to_datetime("%Y-%m-%dT%H:%M:%S%.f%:z", time_unit="us", time_zone="UTC", strict=False)


def _epoch_seconds(series: pl.Series) -> np.ndarray:
    micros = series.dt.timestamp("us")
    return micros.cast(pl.Float64).fill_null(float("nan")).to_numpy() * 1e-6


def _tick(kind: pl.DataType) -> float:
    return {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}[getattr(kind, "time_unit", "ns")]
