"""The values of any column as numbers or as text, whatever its type."""

from __future__ import annotations

import numpy as np
import polars as pl

from .conventions import YEARS

EMPTY = ["", "na", "n/a", "nan", "null", "none", "-", "ground"]
THOUSANDS = r"^[+-]?\d{1,3}(?:,\d{3})+(?:\.\d+)?$"
POINTS = r"^[+-]?\d{1,3}(?:\.\d{3})+(?:,\d+)?$"  # 1.234,5: points between thousands
# a number and a unit in one field: 513.863 M
WITH_UNIT = r"^([+-]?\d+(?:\.\d+)?) ?(?:m|M|ft|FT|km/h|KM/H|kt|kts|kn|deg|°|m/s)$"


def numbers(series: pl.Series, thousands: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Any column as floats (NaN: missing or unreadable) and which values were there but no numbers.

    A comma is a decimal one; where all could be either (1,234), it is read only with `thousands`, as that, or if others
    of the column tell (1,234.5).
    """
    if series.dtype == pl.Null:
        return np.full(len(series), np.nan), np.zeros(len(series), bool)
    if series.dtype in (pl.Categorical, pl.Enum):
        series = series.cast(pl.String)
    if series.dtype == pl.String:
        text = series.str.strip_chars().str.replace("\u2212", "-")
        empty = text.is_null() | text.str.to_lowercase().is_in(EMPTY)
        value = text.cast(pl.Float64, strict=False)
        bad = ~empty & (value.is_null() | value.is_nan())
        if bad.any():
            value = _written_otherwise(text, value, bad, thousands)
            bad = ~empty & (value.is_null() | value.is_nan())
        return value.fill_null(float("nan")).to_numpy(), bad.to_numpy()
    if series.dtype.is_numeric():
        return series.cast(pl.Float64).fill_null(float("nan")).to_numpy(), np.zeros(len(series), bool)
    return np.full(len(series), np.nan), series.is_not_null().to_numpy()


def unclear(series: pl.Series) -> np.ndarray:
    """Fields (N,) whose comma may be a decimal one or one between thousands."""
    if series.dtype != pl.String:
        return np.zeros(len(series), bool)
    return series.str.strip_chars().str.contains(r"^[+-]?\d{1,3},\d{3}$").fill_null(False).to_numpy()


def _written_otherwise(text: pl.Series, value: pl.Series, bad: pl.Series, thousands: bool) -> pl.Series:
    """Numbers with a decimal comma, with commas or points between thousands, or with a unit behind them."""
    pointed = text.str.contains(r"\.")
    if (bad & text.str.contains(POINTS)).any() and text.filter(pointed).str.contains(POINTS).all():
        plain = text.str.replace_all(".", "", literal=True).str.replace(",", ".", literal=True)
        return plain.cast(pl.Float64, strict=False)
    comma = bad & text.str.contains(r"^[+-]?\d+(?:,\d+)+(?:\.\d+)?$")
    either = comma.any() and text.filter(comma).str.contains(THOUSANDS).all()
    told = text.filter(comma).str.contains(r",.*[,.]").any()
    if comma.any() and (thousands or told or not either):
        plain = text.str.replace_all(",", "" if either else ".")
        value = value.zip_with(~comma, plain.cast(pl.Float64, strict=False))
    unit = bad & text.str.contains(WITH_UNIT)
    if unit.any():
        value = value.zip_with(~unit, text.str.extract(WITH_UNIT, 1).cast(pl.Float64, strict=False))
    return value


def texts(series: pl.Series) -> pl.Series:
    """Any column as text; missing stays missing. Of dates that no calendar can write, the number."""
    if isinstance(series.dtype, pl.Datetime) and not _in_calendar(series):
        return series.cast(pl.Int64).cast(pl.String)
    try:
        return series.cast(pl.String)
    except pl.exceptions.PolarsError:
        return pl.Series(series.name, [None if value is None else str(value) for value in series], dtype=pl.String)


def _in_calendar(series: pl.Series) -> bool:
    """Whether all dates can be written: polars panics at one that cannot."""
    a_second = {"ms": 10**3, "us": 10**6, "ns": 10**9}[getattr(series.dtype, "time_unit", None) or "us"]
    ticks = series.cast(pl.Int64) // a_second
    first, last = map(int, YEARS)
    return bool(ticks.is_between(first, last).all())


def codes_of(series: pl.Series) -> np.ndarray:
    """A number per text (N,) uint32, in the order of the texts; 0 for what is missing."""
    # where the rows of a text stand together, each of its runs is looked at once
    if 4 * len(series.head(1000).rle()) < min(len(series), 1000):
        runs = series.rle().struct.unnest()
        return np.repeat(_each_code(runs["value"]), runs["len"].to_numpy())
    return _each_code(series)


def numbered(series: pl.Series) -> tuple[list[str], np.ndarray]:
    """Different texts in the order in which they come, and the number of each row's (N,); none is missing."""
    codes = codes_of(series)
    first = np.zeros(int(codes.max(initial=0)) + 1, np.int64)
    # the first row is written last
    first[codes[::-1]] = np.arange(codes.size - 1, -1, -1)
    order = np.argsort(first[1:])
    number = np.empty(order.size, np.int64)
    number[order] = np.arange(order.size)
    return series[first[1:][order]].to_list(), number[codes - 1]


def _each_code(series: pl.Series) -> np.ndarray:
    known = series.unique().drop_nulls().sort()
    return (series.cast(pl.Enum(known)).to_physical().cast(pl.UInt32) + 1).fill_null(0).to_numpy()


def order_of(codes: np.ndarray, time: np.ndarray) -> np.ndarray:
    """The rows (N,) by code and time; of equal ones the first comes first. NaN comes last."""
    order = np.argsort(short(codes), kind="stable")
    code, inside = codes[order], time[order]
    # mostly the rows of each code are in order of time
    late = ~(inside[1:] >= inside[:-1])
    return np.lexsort((time, short(codes))) if (late & (code[1:] == code[:-1])).any() else order


def taken(frame: pl.DataFrame, which: np.ndarray) -> pl.DataFrame:
    """These rows of a table in this order. It is emptied column by column, so that none is there twice but one."""
    places = pl.Series(which, dtype=pl.UInt32)
    return pl.DataFrame([frame.drop_in_place(name)[places] for name in frame.columns])


def short(codes: np.ndarray) -> np.ndarray:
    """The same numbers in 16 bits, where they are that small: NumPy sorts those by their digits, thrice as fast."""
    return codes.astype(np.uint16) if codes.max(initial=0) < 2**16 else codes
