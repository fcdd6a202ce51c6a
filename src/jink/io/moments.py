"""The instant of each measurement: which column tells it, with which date, and how old the position was by then."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import polars as pl

from .clocks import DECIMAL_COMMA, read_times
from .columns import listed, normal
from .conventions import Times
from .dates import OF_DAY, readings
from .errors import InputError
from .evidence import Motion
from .numeric_times import DAY, EARLY
from .sheet import WILD, Sheet
from .values import numbers, short, texts

APPLE_EPOCH = 978_307_200.0  # s: 2001-01-01
GPS_EPOCH = 315_964_800.0  # s: 1980-01-06, where GPS weeks begin
WEEK = 604_800.0
# s since 1970 of each leap second since GPS began
LEAPS = (
    *(362_793_600, 394_329_600, 425_865_600, 489_024_000, 567_993_600, 631_152_000, 662_688_000, 709_948_800),
    *(741_484_800, 773_020_800, 820_454_400, 867_715_200, 915_148_800, 1_136_073_600, 1_230_768_000),
    *(1_341_100_800, 1_435_708_800, 1_483_228_800),
)
OF_WEEK = {
    *(
        "tow",
        "gps_tow",
        "itow",
        "time_of_week",
        "gms",
        "gps_seconds",
        "gps_second",
        "seconds_of_week",
        "gps_sow",
        "sow",
    ),
}
SNAPSHOT = 600.0  # s: a position older than this when it was reported says that the two clocks are not the same


def of_week(name: str) -> bool:
    """Whether a column is called seconds (or milliseconds) of the GPS week."""
    known = normal(name)
    return any(known == each or known.startswith(each + "_") for each in OF_WEEK)


def doubtful_time(series: pl.Series, codes: np.ndarray) -> bool:
    """Whether a column holds the second of the minute: whole numbers to 63 that start over."""
    if _is_text(series):
        return False
    value = numbers(series)[0]
    known = np.isfinite(value)
    if known.sum() < 4 or (value[known] < 0).any() or (value[known] > 63).any() or (value[known] % 1).any():
        return False
    order = np.flatnonzero(known)[np.argsort(short(codes[known]), kind="stable")]
    back = (np.diff(value[order]) < 0) & (np.diff(codes[order]) == 0)
    repeated = np.unique(np.column_stack([codes[order], value[order]]), axis=0).shape[0] < order.size
    return int(back.sum()) >= (1 if repeated else 2)


def choose_time(sheet: Sheet) -> None:
    """Another column where the usual one is the second of the minute; years, months and days put together."""
    if "time" not in sheet.told and doubtful_time(sheet.series("time"), sheet.codes()):
        _not_the_second(sheet)


def with_parts(sheet: Sheet) -> None:
    """Year, month, day and what there is of hour, minute and second in columns of their own become one text."""
    if "year" not in sheet or sheet.roles["time"].name != sheet.roles["year"].name:
        return
    parts = ("year", "month", "day", "hour", "minute", "second")
    there = [part for part in parts if part in sheet]
    value = {part: sheet.numbers(part) if part in there else np.zeros(sheet.frame.height) for part in parts}
    whole, fraction = np.floor(value["second"]), value["second"] % 1.0
    table = pl.DataFrame({part: value[part] for part in parts[:5]} | {"second": whole})
    table = table.with_columns(pl.all().fill_nan(None).cast(pl.Int64, strict=False).cast(pl.String).str.zfill(2))
    micros = pl.Series("f", np.round(np.nan_to_num(fraction) * 1e6)).cast(pl.Int64).cast(pl.String).str.zfill(6)
    text = (
        table.with_columns(micros)
        .select(
            pl.concat_str(
                [
                    pl.concat_str("year", "month", "day", separator="-"),
                    pl.lit(" "),
                    pl.concat_str("hour", "minute", "second", separator=":"),
                    pl.lit("."),
                    pl.col("f"),
                ]
            )
        )
        .to_series()
    )
    shown = " + ".join(sheet.shown(part) for part in there)
    sheet.put("time", text, None, shown)
    sheet.notes.append(f"times are put together from the columns {shown.replace(' + ', ', ')}")
    sheet.drop(*parts)


def with_nanoseconds(sheet: Sheet) -> None:
    """Whole seconds in one column and nanoseconds in another, as ROS writes time stamps."""
    if "nanosecond" not in sheet:
        return
    second, nano = sheet.numbers("time"), sheet.numbers("nanosecond")
    known = np.isfinite(second) & np.isfinite(nano)
    fits = known.any() and (second[known] % 1 == 0).all() and (nano[known] >= 0).all() and (nano[known] < 1e9).all()
    if fits and (second[known] < 1e10).all():
        shown = f"{sheet.shown('time')} + {sheet.shown('nanosecond')}"
        sheet.put("time", second + 1e-9 * nano, None, shown)
    sheet.drop("nanosecond")


def _not_the_second(sheet: Sheet) -> None:
    name = sheet.roles["time"].name
    for other in sheet.others.get("time", ()):
        series = sheet.frame[other.name]
        if series.count() and not doubtful_time(series, sheet.codes()):
            sheet.roles["time"] = other
            sheet.notes.append(
                f"column {name!r} is the second of the minute (0 to 63, starting over), so times are those of column "
                f"{other.name!r}; --columns time=... names another"
            )
            return
    value = sheet.numbers("time")
    raise InputError(
        f"{sheet.where}: column {name!r} holds whole numbers from {np.nanmin(value):.0f} to {np.nanmax(value):.0f} "
        "that start over: it is the second of the minute, as in AIS messages, and there is no other column of times.\n"
        f"  Found: {listed([c for c in sheet.frame.columns if c != 'row'])}\n  Name one: --columns time=..."
    )


def with_date(sheet: Sheet) -> None:
    """Date and time of day in two columns become one text; a time that is complete leaves the date alone."""
    clock = _clock_text(sheet.series("time"))
    if clock is None:
        sheet.drop("date")
        return
    date = _date_text(sheet)
    if date is None:
        sheet.drop("date")
        return
    names = f"{sheet.shown('date')} + {sheet.shown('time')}"
    sheet.put("time", date + " " + clock, None, names)
    sheet.drop("date")


def _clock_text(series: pl.Series) -> pl.Series | None:
    """Times of day as text (HH:MM:SS), also from HHMMSS.ss; None for anything else."""
    if series.dtype == pl.Time:
        return series.cast(pl.String)
    text = texts(series).str.strip_chars()
    if text.count() and text.str.contains(OF_DAY).sum() >= 0.5 * text.count():
        return text
    value = numbers(series)[0]
    known = value[np.isfinite(value)]
    compact = known.size and (known >= 0).all() and (known < 240_000).all() and (known > 60).any()
    if compact and ((known % 100 >= 60).any() or (known // 100 % 100 >= 60).any()) and known.max() <= 86_400.0:
        return _from_seconds(value)
    if not compact or (known % 100 >= 60).any() or (known // 100 % 100 >= 60).any():
        return None
    whole, _, fraction = (text.str.extract(r"^(\d+)", 1), None, text.str.extract(r"\.(\d+)$", 1))
    whole = whole.str.zfill(6)
    clock = whole.str.slice(0, 2) + ":" + whole.str.slice(2, 2) + ":" + whole.str.slice(4, 2)
    return clock + "." + fraction.fill_null("0")


def _from_seconds(value: np.ndarray) -> pl.Series:
    """Seconds of the day as text."""
    micros = np.round(np.nan_to_num(value) * 1e6).astype("int64")
    text = [
        f"{m // 3_600_000_000:02d}:{m // 60_000_000 % 60:02d}:{m % 60_000_000 / 1e6:09.6f}" for m in micros.tolist()
    ]
    return pl.Series([one if known else None for one, known in zip(text, np.isfinite(value), strict=True)])


def _date_text(sheet: Sheet) -> pl.Series | None:
    """The date column as text that `dates.readings` knows; six digits as ddmmyy (GPS) unless that is no date."""
    series = sheet.series("date")
    if isinstance(series.dtype, pl.Datetime) or series.dtype == pl.Date:
        return series.cast(pl.Date).cast(pl.String)
    text = texts(series).str.strip_chars().str.replace(r"\.0$", "")
    text = text.str.replace(r"[T ]00:00(:00(\.0+)?)?Z?$", "")
    short = text.drop_nulls()
    if len(short) and short.str.contains(r"^\d{5,6}$").all():
        return _six_digits(sheet, text.str.zfill(6))
    text = text.str.replace(r"^(\d{4})(\d{2})(\d{2})$", "${1}-${2}-${3}")
    return text if readings(text) else None


def _six_digits(sheet: Sheet, text: pl.Series) -> pl.Series:
    """ddmmyy, mmddyy or yymmdd to ISO dates: the first by custom of GPS receivers, if only one is a date or as told."""
    parts = [text.str.slice(start, 2) for start in (0, 2, 4)]
    orders = {"ddmmyy": (2, 1, 0), "yymmdd": (0, 1, 2)}
    if sheet.how.day_first is False:
        orders = {"mmddyy": (2, 0, 1)}
    good = {}
    for words, (year, month, day) in orders.items():
        iso = "20" + parts[year] + "-" + parts[month] + "-" + parts[day]
        found = readings(iso)
        if found and found[0].count == text.count():
            good[words] = iso
    if len(good) == 2 and sheet.how.day_first is None:
        first, second = ((words, iso.drop_nulls()[0]) for words, iso in good.items())
        now = np.datetime64("now").astype("datetime64[D]")
        likely = {words: iso for words, iso in good.items() if np.datetime64(iso.drop_nulls()[0]) <= now + 1}
        if len(likely) != 1:
            raise InputError(
                f"{sheet.where}: dates such as {text.drop_nulls()[0]!r} can be read {first[0]} ({first[1]}) or "
                f"{second[0]} ({second[1]}); give --day-first for {first[0]}, or --columns time=... another column"
            )
        good = likely
    if not good:
        return text
    words = next(iter(good))
    sheet.notes.append(f"dates in column {sheet.shown('date')!r} are read as {words}")
    return good[words]


def read_moments(sheet: Sheet, time_unit: str | None, motion: Motion | None) -> Times:
    """The seconds of every row's measurement: GPS weeks, the time of the position or its age are taken into account."""
    column = sheet.roles["time"]
    times = _of_week(sheet) or read_times(sheet.where, sheet.series("time"), column.unit, time_unit, sheet.how, motion)
    sheet.notes += [*times.notes, *_another_beginning(sheet, times)]
    if "time" in sheet.told:
        sheet.drop("position_time")
    if "position_time" in sheet:
        times = _of_position(sheet, times, time_unit)
    if "age" in sheet:
        times = _less_age(sheet, times)
    return times


def _another_beginning(sheet: Sheet, times: Times) -> list[str]:
    """What is to be said of seconds that may count since 1980 (GPS) or since 2001 (Apple): nothing in them decides."""
    column, known = sheet.roles["time"], times.seconds[np.isfinite(times.seconds)]
    if not times.absolute or not known.size or not sheet.series("time").dtype.is_numeric() or "week" in sheet:
        return []
    middle, now = float(np.median(known)), datetime.now(UTC).timestamp()
    for origin, words, may in (
        (GPS_EPOCH - len(LEAPS), "GPS (since 1980-01-06)", "gps" in normal(column.name).split("_")),
        (APPLE_EPOCH, "Apple (since 2001-01-01)", middle < now - APPLE_EPOCH and middle > EARLY),
    ):
        other = middle + origin
        if may and other < now + DAY:
            date, otherwise = (datetime.fromtimestamp(each, UTC).date() for each in (middle, other))
            return [
                f"times in column {sheet.shown('time')!r} count from 1970 ({date}); if they are seconds of {words}, "
                f"dates are {otherwise}: add {origin:.0f} s to the column"
            ]
    return []


def _of_week(sheet: Sheet) -> Times | None:
    """GPS week and seconds of the week to UTC."""
    if "week" not in sheet:
        return None
    column = next(
        (each for each in (sheet.roles["time"], *sheet.others.get("time", ())) if of_week(each.name)),
        sheet.roles["time"],
    )
    sheet.roles["time"] = column
    week, second = sheet.numbers("week"), sheet.numbers("time") * (column.unit or 1.0)
    known = second[np.isfinite(second)]
    week_known = week[np.isfinite(week)]
    fits = known.size and week_known.size and (week_known > 0).all() and (week_known < 5000).all()
    if not fits or not of_week(column.name):
        sheet.drop("week")
        return None
    note = "times are GPS weeks and seconds, turned to UTC"
    if column.unit is None and known.max() >= WEEK:
        second = second * 1e-3
    if np.nanmax(week) < 1024:
        week, note = week + 2048, f"{note}; weeks below 1024 are counted from 2019-04-07"
    gps = GPS_EPOCH + week * WEEK + second
    leap = np.searchsorted(np.array(LEAPS, float) + np.arange(len(LEAPS)) + 1, gps, side="right")
    sheet.drop("week")
    return Times(gps - leap, True, [note])


def _of_position(sheet: Sheet, times: Times, time_unit: str | None) -> Times:
    """The column that says when the position was measured goes before the time of the row."""
    column = sheet.roles["position_time"]
    found = read_times(sheet.where, sheet.series("position_time"), column.unit, time_unit, sheet.how)
    behind = np.abs(times.seconds - found.seconds)
    known = np.isfinite(behind)
    if known.mean() < 0.5 or found.absolute != times.absolute or np.median(behind[known]) > SNAPSHOT:
        sheet.drop("position_time")
        return times
    rest = int((~np.isfinite(found.seconds) & np.isfinite(times.seconds)).sum())
    note = f"the time of a position is that of column {column.name!r}, not of the row ({sheet.shown('time')!r})"
    sheet.notes.append(note + (f"; {rest} rows without it keep the row's" if rest else ""))
    seconds = np.where(np.isfinite(found.seconds), found.seconds, times.seconds)
    return Times(seconds, times.absolute, [], times.of_day)


def _less_age(sheet: Sheet, times: Times) -> Times:
    """A snapshot's time less the age of the position in it."""
    column = sheet.roles["age"]
    age = sheet.numbers("age") * (column.unit or 1.0)
    if not (np.isfinite(age) & (age >= 0)).any():
        sheet.drop("age")
        return times
    sheet.notes.append(f"the time of a position is {sheet.shown('time')!r} less its age in column {column.name!r}")
    # both are rounded, mostly to tenths: without this a position would have two times a rounding error apart
    seconds = np.where(np.isfinite(age), np.round(times.seconds - age, 3), times.seconds)
    return Times(seconds, times.absolute, [], times.of_day)


def _is_text(series: pl.Series) -> bool:
    """Whether the first values are text and no numbers, so that the others need not be tried."""
    if series.dtype != pl.String:
        return False
    first = series.drop_nulls().head(100)
    return first.str.strip_chars().cast(pl.Float64, strict=False).count() == 0


def with_midnights(seconds: np.ndarray, codes: np.ndarray) -> tuple[np.ndarray, int]:
    """Times of day go on after midnight: 86,400 s more for every step back of more than half a day."""
    order = np.flatnonzero(np.isfinite(seconds))
    order = order[np.argsort(short(codes[order]), kind="stable")]
    value = seconds[order]
    new = np.r_[True, np.diff(codes[order]) != 0]
    back = np.r_[False, np.diff(value) < -43_200.0] & ~new
    forth = np.r_[False, np.diff(value) > 43_200.0] & ~new
    days = np.cumsum(back.astype(int) - forth.astype(int))
    days -= np.repeat(days[new], np.diff(np.r_[np.flatnonzero(new), days.size])) if days.size else 0
    out = seconds.copy()
    out[order] += 86_400.0 * days
    return out, int(back.sum())


def wants_motion(series: pl.Series) -> bool:
    """Whether the size of the numbers leaves open what they count."""
    if series.dtype == pl.String and series.str.contains(DECIMAL_COMMA).sum() >= 0.5 * series.count():
        series = series.str.replace(",", ".")
    if _is_text(series):
        return False
    value = numbers(series)[0]
    known = np.abs(value[np.abs(value) < WILD])
    return known.size >= 0.5 * series.count() and known.size > 0 and float(np.median(known)) < EARLY
