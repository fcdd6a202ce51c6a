"""Times in: date-times, ISO 8601 or other text, numbers since 1970 in any usual unit, dates as numbers, plain seconds.

What a name does not say is decided for the whole column: by the size of the numbers, by the speed that they imply
(`Motion`), and for text by what reads every value. What stays open is an error with both readings of one value.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl

from .dates import Reading, readings, times_of_day
from .errors import InputError
from .evidence import FASTEST, SLOWEST, Motion
from .units import TIME

# a number this large (median of the absolute values) counts these units since 1970; below 1e8: plain seconds
SIZES = ((1e17, "ns", 1e-9), (1e14, "us", 1e-6), (1e11, "ms", 1e-3), (1e8, "s", 1.0))
LATEST = 2.5e11  # s since 1970: the year 9892
EARLY = 631_152_000.0  # s since 1970: the year 1990, before which nobody logged positions
DAY = 86400.0
WILD = 1e100  # no unit makes this a time
# days since other beginnings: the least and the largest number from 1990 to 2040, and the number of 1970-01-01
DAYS = {
    "days since 1899-12-30 (as spreadsheets and Geolife count)": (32_874.0, 47_891.0, 25_569.0),
    "modified Julian days": (47_892.0, 66_154.0, 40_587.0),
    "MATLAB datenum": (726_834.0, 745_096.0, 719_529.0),
    "Julian days": (2_447_892.5, 2_466_154.5, 2_440_587.5),
}
DIGITS = ((14, 1e13, 1e14), (12, 1e11, 1e12))  # yyyymmddHHMMSS and yyyymmddHHMM as numbers


@dataclass(frozen=True)
class Conventions:
    """What the user says of times and axes: day_first, time_format (strftime), time_zone of times without one; axes
    `enu` or `ned`; azimuth clockwise from `north` or counter-clockwise from `east` (the x axis).
    """

    day_first: bool | None = None
    time_format: str | None = None
    time_zone: str | None = None
    axes: str | None = None
    azimuth: str | None = None

    def __post_init__(self) -> None:
        for name, value, known in (
            ("axes", self.axes, ("enu", "ned")),
            ("azimuth_from", self.azimuth, ("north", "east")),
        ):
            if value is not None and value not in known:
                raise InputError(f"{name} is {value!r}; expected {known[0]!r} or {known[1]!r}")


NONE = Conventions()


@dataclass(frozen=True)
class Times:
    """Seconds (since 1970 when `absolute`), NaN where unreadable, and what had to be assumed.

    `of_day`: seconds since midnight of days that are not known.
    """

    seconds: np.ndarray
    absolute: bool
    notes: list[str] = field(default_factory=list)
    of_day: bool = False


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
        seconds = _epoch_seconds(series.cast(pl.Datetime("us", zone)))
        return Times(seconds if zone else in_zone(seconds, None, how), True, [])
    if series.dtype in (pl.Duration, pl.Time):
        seconds = series.cast(pl.Int64).cast(pl.Float64).fill_null(float("nan")).to_numpy() * _tick(series.dtype)
        return Times(seconds, False, [], series.dtype == pl.Time)
    if series.dtype == pl.String:
        text = series.str.strip_chars()
        value = text.cast(pl.Float64, strict=False)
        if value.count() < 0.5 * text.count() and text.str.contains(r"^\d+,\d+$").sum() >= 0.5 * text.count():
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
    return _given_unit(value, given) if given is not None else _numeric_times(where, value, how, motion)


def _given_unit(value: np.ndarray, unit: float) -> Times:
    size = _size(value) * unit
    seconds = np.where(np.abs(value * unit) < LATEST, value * unit, np.nan)
    return Times(seconds, size >= 1e8, [])


def _size(value: np.ndarray) -> float:
    known = value[np.isfinite(value)]
    return float(np.quantile(np.abs(known), 0.5, method="lower")) if known.size else 0.0


def _numeric_times(where: str, value: np.ndarray, how: Conventions, motion: Motion | None) -> Times:
    """Numbers without a unit: dates written in digits, days, mixed units, or one unit for all."""
    dates = _digits(value, how)
    if dates is not None:
        return dates
    size = _size(value)
    for least, name, factor in SIZES:
        if size >= least:
            mixed = _mixed(value)
            if mixed is not None:
                return mixed
            if name == "s" and size < EARLY and motion is not None:
                since_start = _since_start(where, value, motion)
                if since_start is not None:
                    return since_start
            value = np.where(np.abs(value * factor) < LATEST, value, np.nan)
            note = [] if name == "s" else [f"times are taken as {name} since 1970"]
            return Times(value * factor, True, note)
    return _small(where, value, motion)


def _mixed(value: np.ndarray) -> Times | None:
    """Seconds and milliseconds (or finer) in one column, if all are then within ten years."""
    size = np.nan_to_num(np.abs(value))
    factor = np.select([size >= least for least, _, _ in SIZES], [f for _, _, f in SIZES], np.nan)
    units = [name for least, name, f in SIZES if (factor == f).any()]
    seconds = value * factor
    known = seconds[np.isfinite(seconds)]
    if len(units) < 2 or known.size < np.isfinite(value).sum() or np.ptp(known) > 10 * 365 * DAY:
        return None
    shares = ", ".join(f"{int((factor == f).sum())} in {name}" for _, name, f in SIZES if (factor == f).any())
    return Times(seconds, True, [f"times are in several units since 1970, each value in its own: {shares}"])


def _digits(value: np.ndarray, how: Conventions) -> Times | None:
    """20240115143000 and 202401151430 are dates, if every value is one."""
    known = np.isfinite(value)
    for digits, least, most in DIGITS:
        if known.any() and ((value[known] >= least) & (value[known] < most) & (value[known] % 1 == 0)).all():
            text = pl.Series(np.where(known, value, 0).astype("int64")).cast(pl.String)
            best = readings(text)
            if best and best[0].count == known.sum():
                seconds = in_zone(best[0].seconds, best[0].naive, how)
                return Times(seconds, True, [f"times of {digits} digits are read as dates (year first)"])
    return None


def _since_start(where: str, value: np.ndarray, motion: Motion) -> Times | None:
    """Numbers that would be dates before 1990 as seconds: finer units since a start, if only one is possible."""
    distance, elapsed = motion.steps(value)
    if distance.size < 3 or np.median(distance / elapsed) >= SLOWEST:
        return None
    pace = float(np.median(distance / elapsed))
    reported = motion.reported_speed()
    possible = []
    for name, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        speed = pace / factor
        fits = 0.2 < speed / reported < 5.0 if np.isfinite(reported) else 2 * SLOWEST <= speed <= FASTEST
        if fits:
            possible.append((name, factor, speed))
    if len(possible) == 1:
        name, factor, speed = possible[0]
        words = (
            f"times are taken as {name} since a start (median speed {speed:.3g} m/s; as s since 1970 {pace:.2g} m/s)"
        )
        return Times(value * factor, False, [f"{words}; --time-unit sets it"])
    first = float(value[np.isfinite(value)][0])
    date = (datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=first)).date()
    raise InputError(
        f"{where}: the time {first:.0f} can be {date} as seconds since 1970, where nothing moves, or "
        f"{first * 1e-6:.6g} s as microseconds since a start; give --time-unit us (or s, ms, ns)"
    )


def _small(where: str, value: np.ndarray, motion: Motion | None) -> Times:
    """Numbers below 1e8: plain seconds, unless they are times of day in digits, or the speed that they imply says days
    or finer units.
    """
    digits = _day_in_digits(value)
    if digits is not None:
        return digits
    if motion is None:
        return Times(value, False, [])
    distance, elapsed = motion.steps(value)
    if distance.size < 3:
        return Times(value, False, [])
    pace, reported = float(np.median(distance / elapsed)), motion.reported_speed()
    known = value[np.isfinite(value)]
    for words, (least, most, origin) in DAYS.items():
        if known.min() >= least and known.max() <= most:
            as_days = pace / DAY
            if np.isfinite(reported) and not 0.2 < as_days / reported < 5.0:
                continue
            if pace > FASTEST and as_days <= FASTEST:
                # a millisecond is the finest that a double holds of a day number; whole microseconds would be noise
                seconds = np.round((value - origin) * DAY, 3)
                said = f"times are taken as {words}: median speed {as_days:.3g} m/s, as plain seconds {pace:.3g} m/s"
                return Times(seconds, True, [said])
    if np.isfinite(reported):
        for name, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
            # the reported speed may be in any unit of speed, so a factor of four either way is the same speed
            if 0.24 < pace / factor / reported < 4.2 and pace < 0.05 * reported:
                words = f"times are taken as {name}: positions then move as fast as the reported speed says"
                return Times(value * factor, False, [f"{words}; --time-unit sets it"])
    return Times(value, False, [])


def _day_in_digits(value: np.ndarray) -> Times | None:
    """HHMMSS and HHMMSS.ss: over several minutes no number of seconds or minutes is 60 or more."""
    known = value[np.isfinite(value)]
    if known.size < 20 or known.min() < 0 or known.max() >= 240_000 or np.ptp(known // 100) < 2:
        return None
    second, minute = np.floor(known % 100), known // 100 % 100
    # plain seconds would fall on 60 to 99 in two of five cases: of 20 that never do one in 27,000 is left; but steps
    # such as 5,000 never do either, so several seconds (or minutes, over an hour) have to occur
    several = np.unique(second).size >= 5 or (np.unique(minute).size >= 5 and np.ptp(known // 10_000) >= 1)
    if (second >= 60).any() or (minute >= 60).any() or np.unique(known).size < 20 or not several:
        return None
    seconds = value // 10_000 * 3600 + value // 100 % 100 * 60 + value % 100
    return Times(seconds, False, ["times are read as hours, minutes and seconds of the day (HHMMSS)"], True)


def _text_times(where: str, text: pl.Series, how: Conventions) -> Times:
    """ISO 8601 first; then every other form, day first or month first as told, or as the whole column shows."""
    if how.time_format:
        return _formatted(where, text, how)
    iso, naive = _iso(text)
    wanted = text.count()
    if iso.count() >= 0.5 * wanted or wanted == 0:
        seconds = _epoch_seconds(iso)
        return Times(in_zone(seconds, naive, how), True, [] if not how.time_zone else [_zone_note(how)])
    of_day = times_of_day(text)
    if np.isfinite(of_day).sum() >= 0.5 * wanted:
        note = "times of day without a date are taken as seconds since midnight"
        return Times(of_day, False, [note], True)
    found = readings(text)
    if not found:
        return Times(_epoch_seconds(iso), True, [])
    chosen, why = _chosen(where, text, found, how)
    notes = [] if chosen.words in ("year first", "compact") else [f"times are read {chosen.words}, UTC{why}"]
    if how.time_zone:
        notes = [*[note.replace(", UTC", "") for note in notes], _zone_note(how)]
    return Times(in_zone(chosen.seconds, chosen.naive, how), True, notes)


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
    seconds = _epoch_seconds(read)
    naive = np.full(seconds.size, zone is None)
    return Times(in_zone(seconds, naive, how), True, [f"times are read as {form}"])


def in_zone(seconds: np.ndarray, naive: np.ndarray | None, how: Conventions) -> np.ndarray:
    """Wall-clock times without a zone (all, or those marked) in the user's zone to UTC; of an hour that comes twice
    the first.
    """
    if how.time_zone is None:
        return seconds
    wall = pl.Series(np.round(np.nan_to_num(seconds) * 1e6).astype("int64")).cast(pl.Datetime("us"))
    try:
        local = wall.dt.replace_time_zone(how.time_zone, ambiguous="earliest", non_existent="null")
    except pl.exceptions.PolarsError:
        raise InputError(f"--time-zone is {how.time_zone!r}; expected a name such as Europe/Berlin or UTC") from None
    there = np.where(np.isfinite(seconds), _epoch_seconds(local.dt.convert_time_zone("UTC")), np.nan)
    return there if naive is None else np.where(naive, there, seconds)


def _iso(text: pl.Series) -> tuple[pl.Series, np.ndarray]:
    """ISO 8601 with `T` or a blank, with a fraction or not, with Z, an offset or nothing (then UTC); and which have
    nothing.
    """
    plain = text.str.replace(r"^(\d{4}-\d{2}-\d{2}) ", "${1}T").str.replace(r"(?i) ?(utc|z)$", "+00:00")
    plain = plain.str.replace(r"([+-]\d{2})(\d{2})$", "${1}:${2}").str.replace(r"(T.*[+-]\d{2})$", "${1}:00")
    has_zone = plain.str.contains(r"T.*[+-]\d{2}:\d{2}$")
    zoned = pl.when(has_zone).then(plain).otherwise(plain + "+00:00")
    complete = pl.select(zoned).to_series().str.replace(r"^(\d{4}-\d{2}-\d{2})\+", "${1}T00:00:00+")
    complete = complete.str.replace(r"T(\d{2}:\d{2})\+", "T${1}:00+")
    read = complete.str.to_datetime("%Y-%m-%dT%H:%M:%S%.f%:z", time_unit="us", time_zone="UTC", strict=False)
    return read, ~has_zone.fill_null(True).to_numpy()


def _epoch_seconds(series: pl.Series) -> np.ndarray:
    micros = series.dt.timestamp("us")
    return micros.cast(pl.Float64).fill_null(float("nan")).to_numpy() * 1e-6


def _tick(kind: pl.DataType) -> float:
    return {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}[getattr(kind, "time_unit", "ns")]
