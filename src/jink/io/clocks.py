"""Times in: date-times, ISO 8601 or other text, numbers since 1970 in any usual unit, dates as numbers, plain seconds.

What a name does not say is decided for the whole column: by the size of the numbers, by the speed that they imply
(`Motion`), and for text by what reads every value. What stays open is an error with both readings of one value.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl

from .conventions import NONE, Conventions, Times, epoch_seconds, in_zone
from .dates import Reading, readings, times_of_day
from .errors import InputError
from .evidence import Motion
from .iso_times import uniform
from .numeric_times import DAY, LATEST, WILD, numeric_times, size_of
from .units import TIME

DECIMAL_COMMA = r"^\d+,\d+$"
THOUSANDS = r"^\d{1,3}(?:,\d{3}){2,}(?:\.\d+)?$"


def read_times(
    where: str,
    series: pl.Series,
    unit: float | None,
    time_unit: str | None,
    how: Conventions = NONE,
    motion: Motion | None = None,
) -> Times:
    """A column of times to seconds; `unit` is the name's, `time_unit` the user's. Without a zone: UTC."""
    if series.dtype in (pl.Categorical, pl.Enum):
        series = series.cast(pl.String)
    if isinstance(series.dtype, pl.Datetime) or series.dtype == pl.Date:
        zone = getattr(series.dtype, "time_zone", None)
        seconds = epoch_seconds(series)
        return Times(seconds if zone else in_zone(seconds, None, how), True, [])
    if series.dtype in (pl.Duration, pl.Time):
        seconds = series.cast(pl.Int64).cast(pl.Float64).fill_null(float("nan")).to_numpy() * _tick(series.dtype)
        return Times(seconds, False, [], series.dtype == pl.Time)
    if series.dtype == pl.String:
        if not how.time_format and (read := uniform(series)):
            return _of_iso(*read, how)
        text = series.str.strip_chars(" \t[]\"'")
        value = text.cast(pl.Float64, strict=False)
        if value.count() < 0.5 * text.count() and text.str.contains(THOUSANDS).sum() >= 0.5 * text.count():
            value = text.str.replace_all(",", "").cast(pl.Float64, strict=False)
        if value.count() < 0.5 * text.count() and text.str.contains(DECIMAL_COMMA).sum() >= 0.5 * text.count():
            value = text.str.replace(",", ".").cast(pl.Float64, strict=False)
        if how.time_format or value.count() < 0.5 * text.count():
            return _text_times(where, text, how)
        series = value
    if not series.dtype.is_numeric():
        return Times(np.full(len(series), np.nan), False, [])
    value = series.cast(pl.Float64).fill_null(float("nan")).to_numpy().copy()
    value[~(np.abs(value) < WILD)] = np.nan
    if how.time_format:
        return _text_times(where, series.cast(pl.Int64, strict=False).cast(pl.String), how)
    given = TIME[time_unit] if time_unit else unit
    times = _given_unit(value, given) if given is not None else numeric_times(where, value, how, motion)
    if series.dtype == pl.Float32 and times.absolute:
        apart = float(np.spacing(np.float32(np.nanmax(np.abs(value)))))
        raise InputError(
            f"{where}: the times are dates in floats of 32 bits, which are {apart:.3g} apart at this size, so that "
            "they are rounded by so much; expected 64 bits, as the source had them (a cast brings nothing back)"
        )
    return times


def _given_unit(value: np.ndarray, unit: float) -> Times:
    size = size_of(value) * unit
    seconds = np.where(np.abs(value * unit) < LATEST, value * unit, np.nan)
    return Times(seconds, size >= 1e8, [])


def _text_times(where: str, text: pl.Series, how: Conventions) -> Times:
    """ISO 8601 first; then every other form, day first or month first as told, or as the whole column shows."""
    if how.time_format:
        return _formatted(where, text, how)
    iso, naive = _iso(text)
    wanted = text.count()
    if iso.count() >= 0.5 * wanted or wanted == 0:
        return _of_iso(iso, naive, how)
    of_day = times_of_day(text)
    if np.isfinite(of_day).sum() >= 0.5 * wanted:
        note = "times of day without a date are taken as seconds since midnight"
        return Times(of_day, False, [note], True)
    found = readings(text)
    if not found:
        return Times(epoch_seconds(iso), True, [])
    chosen, why = _chosen(where, text, found, how)
    notes = [] if chosen.words in ("year first", "compact") else [f"times are read {chosen.words}, UTC{why}"]
    if how.time_zone:
        notes = [*[note.replace(", UTC", "") for note in notes], _zone_note(how)]
    return Times(in_zone(chosen.seconds, chosen.naive, how), True, notes)


def _of_iso(iso: pl.Series, naive: np.ndarray, how: Conventions) -> Times:
    return Times(in_zone(epoch_seconds(iso), naive, how), True, [_zone_note(how)] if how.time_zone else [])


def _zone_note(how: Conventions) -> str:
    return f"times without a zone are in {how.time_zone}"


def _chosen(where: str, text: pl.Series, found: list[Reading], how: Conventions) -> tuple[Reading, str]:
    """The reading that the user asks for, that is the only one, or in which the rows follow each other more closely."""
    if how.day_first is not None:
        wanted = "day first" if how.day_first else "month first"
        asked = [reading for reading in found if reading.words == wanted]
        if asked:
            return asked[0], " (as told)"
        if any(reading.words in ("day first", "month first") for reading in found):
            raise InputError(
                f"{where}: times such as {text.drop_nulls()[0]!r} cannot all be read {wanted}; "
                f"they can be read {found[0].words}"
            )
    first = found[0]
    others = [r for r in found[1:] if not np.array_equal(r.seconds, first.seconds, equal_nan=True)]
    if not others:
        return first, ""
    lengths = [_longest_step(reading.seconds) for reading in found]
    best = int(np.argmin(lengths))
    # only days that join at midnight tell: then one reading goes on and the other jumps by weeks
    if lengths[best] < DAY / 4 and all(length > 5 * DAY for i, length in enumerate(lengths) if i != best):
        days = ", ".join(f"{length / DAY:.3g}" for i, length in enumerate(lengths) if i != best)
        why = f" (the longest step is then {lengths[best]:.4g} s; read otherwise {days} days)"
        return found[best], why
    value = text.drop_nulls()[0]
    at = int(np.flatnonzero(text.is_not_null().to_numpy())[0])
    both = " or ".join(f"{_date(reading.seconds[at])} ({reading.words})" for reading in [first, *others])
    raise InputError(
        f"{where}: times such as {value!r} can be read day first or month first: {both}; "
        "give --day-first or --month-first, or --time-format, or write them as ISO 8601 (2024-05-31T12:00:00Z)"
    )


def _longest_step(seconds: np.ndarray) -> float:
    """The longest time between two instants that follow each other; infinite where there is but one day."""
    known = np.unique(seconds[np.isfinite(seconds)])
    days = np.unique(known // DAY)
    return float(np.diff(known).max()) if days.size > 1 else float("inf")


def _date(seconds: float) -> str:
    return (datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=float(seconds))).strftime("%Y-%m-%d %H:%M:%S")


def _formatted(where: str, text: pl.Series, how: Conventions) -> Times:
    """Text by the user's own strftime format."""
    form = str(how.time_format)
    try:
        read = text.str.to_datetime(form, time_unit="us", strict=False)
        if read.count() == 0:
            read = text.str.to_date(form, strict=False).cast(pl.Datetime("us"))
    except pl.exceptions.PolarsError as error:
        raise InputError(f"{where}: --time-format {form!r} cannot be used: {error}") from None
    if read.count() == 0:
        raise InputError(f"{where}: no time such as {text.drop_nulls()[0]!r} fits --time-format {form!r}")
    zone = getattr(read.dtype, "time_zone", None)
    seconds = epoch_seconds(read)
    naive = np.full(seconds.size, zone is None)
    return Times(in_zone(seconds, naive, how), True, [f"times are read as {form}"])


def _iso(text: pl.Series) -> tuple[pl.Series, np.ndarray]:
    """ISO 8601 with `T` or a blank, with a fraction or not, with Z, an offset or nothing (then UTC); and which have
    nothing.
    """
    quickly = uniform(text)
    if quickly is not None:
        return quickly
    plain = text.str.replace(r"^(\d{4}-\d{2}-\d{2}) ", "${1}T").str.replace(r"(?i) ?(utc|z)$", "+00:00")
    plain = plain.str.replace(r"([+-]\d{2})(\d{2})$", "${1}:${2}").str.replace(r"(T.*[+-]\d{2})$", "${1}:00")
    has_zone = plain.str.contains(r"T.*[+-]\d{2}:\d{2}$")
    zoned = pl.when(has_zone).then(plain).otherwise(plain + "+00:00")
    complete = pl.select(zoned).to_series().str.replace(r"^(\d{4}-\d{2}-\d{2})\+", "${1}T00:00:00+")
    complete = complete.str.replace(r"T(\d{2}:\d{2})\+", "T${1}:00+")
    read = complete.str.to_datetime("%Y-%m-%dT%H:%M:%S%.f%:z", time_unit="us", time_zone="UTC", strict=False)
    return read, ~has_zone.fill_null(True).to_numpy()


def _tick(kind: pl.DataType) -> float:
    return {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}[getattr(kind, "time_unit", "ns")]
