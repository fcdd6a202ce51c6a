"""Columns as they were found to measurements in SI units; what cannot be read is named and set aside.

What a name does not say is decided for the whole table, said in a note, and can be given by the user:

- *time*, a number: by its size seconds, milliseconds, microseconds or nanoseconds since 1970, or plain
  seconds when below 1e8, unless the speed that follows says otherwise (`clocks.py`);
- *altitude* without a unit: feet in a table that also has `groundspeed` and `vertical_rate` (the `traffic`
  package and its kin decode ADS-B in feet, knots and feet per minute), or whose heights beyond 15 km are steps of
  25 feet; metres otherwise (OpenSky's `geoaltitude` and `baroaltitude`, GPS logs);
- *azimuth, elevation* without a unit: radians, or degrees as soon as one value cannot be radians (`axes.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import polars as pl

from .clock_faults import mend
from .codes import are_codes, zero_heights
from .columns import Columns, is_altitude, normal
from .conventions import NONE, Conventions, in_calendar
from .errors import InputError
from .kept import marked
from .meaning import understand
from .quality import (
    GROUND_SD,
    accuracies,
    dilution,
    grounded,
    on_the_ground,
    placeholders,
    rate_accuracies,
    refused,
    speeds,
)
from .rates import rates
from .sheet import Problem, Sheet
from .stages import stage
from .values import numbers, texts, unclear

FOOT = 0.3048
FARTHEST = 1e10  # m: nothing that is tracked is so far, and squares of more lose all digits
HIGHEST = 15_500.0  # m: higher than this only few aircraft fly
DIMENSIONS = {
    "geographic": ("latitude", "longitude", "altitude"),
    "cartesian": ("x", "y", "z"),
    "polar": ("range", "azimuth", "elevation", "altitude"),
}


@dataclass
class Measurements:
    """Measurements in SI units, one row per readable input row, and what was noticed on the way.

    `rows` has file, row, target, source, time (seconds, since 1970 when `absolute`), the position's
    components (NaN: missing), speed and the other rates that the table has (`rates.py`), position_sd and altitude_sd
    (as each row states; NaN: not stated), velocity_sd and vertical_rate_sd where the source states them, dilution (how
    much rougher a row is than the middle one) and grounded (the altitude was filled in on the ground); on_ground where
    a column says so. `rate_notes` are of interest where the rates are used. `of_day`: times count from midnight.
    """

    rows: pl.DataFrame
    rejected: list[pl.DataFrame]
    position: str
    absolute: bool
    named: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)
    rate_notes: list[str] = field(default_factory=list)
    of_day: bool = False


@stage("recognise")
def measure(
    file: str | None,
    frame: pl.DataFrame,
    columns: Columns,
    *,
    altitude_unit: str | None = None,
    time_unit: str | None = None,
    default_target: str = "0",
    check_coordinates: bool = True,
    conventions: Conventions = NONE,
    stream: bool = False,
    carried: Sequence[str] = (),
    some: bool = False,
) -> Measurements:
    """Convert the recognised columns of `frame`, which has `row` too; InputError if no time is readable.

    stream: the rows are a few of many, so that their values do not decide what columns mean. carried: columns that go
    through to the output. some: there are more rows, whose times may be readable.
    """
    where = file or "the table"
    clock = frame[columns.roles["time"].name]
    sheet, times = understand(where, frame, columns, conventions, time_unit, stream)
    if times.absolute:
        times = replace(times, seconds=in_calendar(times.seconds))
    if frame.height and not some and np.isnan(times.seconds).all():
        raise InputError(
            f"{where}: no time could be read in column {clock.name!r} (first value: {_first(clock)!r}); "
            "expected ISO 8601 date-times or numbers (seconds, or ms, us, ns since 1970); --time-format says how"
        )
    noticed, sheet.notes = sheet.notes, []
    problems: list[Problem] = [("time is missing or unreadable", np.isnan(times.seconds), clock)]
    target, target_note = _targets(sheet, default_target)
    if "target" in sheet:
        problems.append(("no identifier", target.is_null().to_numpy(), sheet.series("target")))
    values, unreadable = _positions(sheet, altitude_unit)
    seconds = times.seconds
    first, second = list(values.values())[:2]
    if times.absolute and not stream:
        seconds, notes = mend(seconds, sheet.codes(), first, second, sheet.position)
        noticed += notes
    _no_heights(sheet, values, seconds)
    radar = seen_by_radar(sheet, values)
    ground = grounded(sheet)
    ground_sd = np.full(frame.height, np.nan) if stream else _on_the_ground(sheet, values, seconds)
    if check_coordinates:
        problems += refused(sheet)
    problems += unreadable + sheet.problems
    problems += [(reason, bad, None) for reason, bad in _invalid(sheet.position, values, check_coordinates)]
    position_sd, altitude_sd = accuracies(sheet)
    speed = speeds(sheet)
    moving, rate_notes = rates(sheet, speed)
    whole = pl.repeat(file, frame.height, dtype=pl.String, eager=True).alias("file")
    rows = pl.DataFrame([whole, frame["row"]]).with_columns(
        target,
        _source(sheet, whole),
        pl.Series("time", seconds),
        *[pl.Series(name, value) for name, value in values.items()],
        pl.Series("speed", speed),
        *[pl.Series(name, value) for name, value in moving.items()],
        position_sd,
        *rate_accuracies(sheet, moving),
        *marked(frame, carried),
        pl.Series("dilution", dilution(sheet)),
        pl.Series("grounded", np.isfinite(ground_sd)),
        *([pl.Series("on_ground", ground)] if ground.any() else []),
        *([pl.Series("seen_by_radar", radar)] if radar.any() else []),
        pl.Series("altitude_sd", np.where(np.isnan(ground_sd), altitude_sd.to_numpy(), ground_sd)),
    )
    rejected, good = _reject(rows, problems)
    kept = rows.filter(pl.Series(good))
    named = {role: column.shown or column.name for role, column in sheet.roles.items()}
    notes = noticed + target_note + sheet.notes
    unused = [name for name in _unused(sheet, named) if name not in carried]
    return Measurements(kept, rejected, sheet.position, times.absolute, named, notes, unused, rate_notes, times.of_day)


def _unused(sheet: Sheet, named: dict[str, str]) -> list[str]:
    """Columns that nothing was read from; what was made from several is shown by their names."""
    used = {column.name for column in sheet.roles.values()}
    used |= {column.name for found in sheet.others.values() for column in found}
    return [name for name in sheet.names if name not in used and not any(name in shown for shown in named.values())]


def _positions(sheet: Sheet, altitude_unit: str | None) -> tuple[dict[str, np.ndarray], list[Problem]]:
    """The position's components in SI units (latitude and longitude in degrees), and unreadable values."""
    values: dict[str, np.ndarray] = {}
    problems: list[Problem] = []
    for name in (n for n in DIMENSIONS[sheet.position] if n in sheet):
        column = sheet.roles[name]
        number, bad = numbers(sheet.series(name), thousands=name == "altitude")
        height = name in ("altitude", "z")
        code = are_codes(number, height) if name not in ("latitude", "longitude") else np.zeros(number.size, bool)
        if code.any() and height:
            number = np.where(code, np.nan, number)
            sheet.notes.append(f"{int(code.sum())} heights in column {sheet.shown(name)!r} are codes for none")
        elif code.any():
            problems.append((f"{name} is a code for none", code, sheet.series(name)))
        unit = _unit(sheet, name, number, altitude_unit)
        with np.errstate(over="ignore"):
            values[name] = number * unit
        if name == "altitude" and bad.any():
            count = int(bad.sum())
            sheet.notes.append(f"{count} unreadable altitudes in column {column.name!r} are taken as missing")
        elif bad.any():
            either = bad & unclear(sheet.series(name))
            problems.append(
                (f"{name} has a comma that is a decimal one or one between thousands", either, sheet.series(name))
            )
            problems.append((f"{name} is not a number", bad & ~either, sheet.series(name)))
    if sheet.position == "geographic":
        _degrees(values)
    return values, problems


def seen_by_radar(sheet: Sheet, values: dict[str, np.ndarray]) -> np.ndarray:
    """Rows (N,) whose x and y are those of a radar at the origin: the table has its ranges and azimuths too."""
    none = np.zeros(sheet.frame.height, bool)
    if sheet.position != "cartesian":
        return none
    if "range" in sheet and "azimuth" in sheet:
        reach, _ = numbers(sheet.series("range"))
        reach = reach * (sheet.roles["range"].unit or 1.0)
        with np.errstate(invalid="ignore", over="ignore"):
            # a slant range is longer than the way along the ground
            along = np.hypot(values["x"], values["y"])
            same = np.isfinite(reach) & (along <= 1.001 * reach + 1.0) & (along >= 0.9 * reach)
        known = np.isfinite(reach)
        if known.any() and same[known].mean() > 0.9:
            sheet.notes.append("x and y are those of a radar at the origin: their noise is that of range and azimuth")
            return np.ones(sheet.frame.height, bool)
    for role in ("range", "azimuth"):
        if role in sheet:
            sheet.drop(role)
    return none


def _no_heights(sheet: Sheet, values: dict[str, np.ndarray], seconds: np.ndarray) -> None:
    """Heights of 0 that stand for none are missing."""
    if "altitude" not in values:
        return
    none = zero_heights(values["altitude"], sheet.codes(), seconds)
    if none.any():
        values["altitude"] = np.where(none, np.nan, values["altitude"])
        sheet.notes.append(f"{int(none.sum())} heights of 0 are no heights: no climb leads to those beside them")


def _on_the_ground(sheet: Sheet, values: dict[str, np.ndarray], seconds: np.ndarray) -> np.ndarray:
    """Fill in the heights of targets on the ground; their sds, (N,), NaN for all other rows."""
    ground = grounded(sheet)
    if "altitude" not in values or not ground.any():
        sheet.drop("on_ground")
        return np.full(ground.size, np.nan)
    values["altitude"], sd = on_the_ground(values["altitude"], ground, sheet.codes(), seconds)
    filled = np.isfinite(sd)
    if filled.any():
        sheet.notes.append(
            f"{int(filled.sum())} rows on the ground have the heights that were reported last and next in the air, "
            f"with an sd of {GROUND_SD:g} m, or more where nothing was reported near the ground"
        )
    else:
        sheet.drop("on_ground")
    return sd


def _targets(sheet: Sheet, default: str) -> tuple[pl.Series, list[str]]:
    if "target" not in sheet:
        note = (
            f"no identifier column was recognised: all rows are taken as target {default!r}; "
            "--columns target=... names one"
        )
        return pl.repeat(default, sheet.frame.height, dtype=pl.String, eager=True).alias("target"), [note]
    return target_names(sheet.series("target")).alias("target"), []


def target_names(series: pl.Series) -> pl.Series:
    """Identifiers as text, null where there is none; whole numbers without a point."""
    if series.dtype.is_float():
        whole = series.is_finite() & (series == series.round())
        series = series.fill_nan(None)
        if whole.filter(series.is_not_null()).all():
            series = series.cast(pl.Int64, strict=False)
    text = texts(series).str.strip_chars()
    # the first ones tell most tables
    if series.dtype == pl.String and all(some.str.contains(r"^\d+\.0+$").all() for some in (text.head(100), text)):
        text = text.str.replace(r"\.0+$", "")
    return text.set(text == "", None)


def _source(sheet: Sheet, file: pl.Series) -> pl.Series:
    """Who measured: the sensor's column where most rows have one, otherwise the file."""
    if "source" in sheet and "source" not in sheet.told and sheet.series("source").count() < sheet.frame.height / 2:
        sheet.notes.append(f"column {sheet.shown('source')!r} is empty in most rows, so it names no sensor")
        sheet.drop("source")
    if "source" in sheet:
        return texts(sheet.series("source")).fill_null("unknown").alias("source")
    return (file.fill_null("data") if file.null_count() else file).alias("source")


def _unit(sheet: Sheet, name: str, value: np.ndarray, altitude_unit: str | None) -> float:
    """The unit of a column in SI units; where it had to be assumed, a note says so."""
    column = sheet.roles[name]
    if name in ("altitude", "z") and altitude_unit is not None and name not in sheet.own_units:
        down = name == "z" and (column.unit or 1.0) < 0.0
        return {"ft": FOOT, "m": 1.0}[altitude_unit] * (-1.0 if down else 1.0)
    if column.unit is not None:
        return column.unit
    if name != "altitude" and not (name == "z" and is_altitude(column.name)):
        return 1.0
    names = {normal(n) for n in sheet.frame.columns} | {normal(n) for n in sheet.names}
    known = value[np.isfinite(value)]
    why = "SI by default"
    feet = {"groundspeed", "vertical_rate"} <= names
    if feet:
        why = "the table also has groundspeed and vertical_rate, as decoded ADS-B in feet and knots"
    elif known.size and known.max() > HIGHEST and not (known % 25 != 0).any():
        feet, why = True, f"up to {known.max():g} in steps of 25, as transponders report"
    unit = "feet" if feet else "metres"
    sheet.notes.append(
        f"altitude in column {sheet.shown(name)!r} is taken as {unit} ({why}); --altitude-unit ft|m changes it"
    )
    return FOOT if feet else 1.0


def _degrees(values: dict[str, np.ndarray]) -> None:
    """Turn latitude and longitude back to degrees, longitude within ±180."""
    for name in ("latitude", "longitude"):
        values[name] = np.degrees(values[name])
    with np.errstate(invalid="ignore"):
        gone = placeholders(values["latitude"], values["longitude"])
        beyond = np.abs(values["longitude"]) > 180.0
        beyond &= ~gone
        values["longitude"][beyond & (values["longitude"] <= 360.0)] -= 360.0


def _invalid(position: str, values: dict[str, np.ndarray], check: bool) -> list[tuple[str, np.ndarray]]:
    """Impossible coordinates by reason. Half a position counts as one; a missing altitude does not."""
    found: list[tuple[str, np.ndarray]] = []
    with np.errstate(invalid="ignore"):
        if position == "geographic" and check:
            latitude, longitude = values["latitude"], values["longitude"]
            found.append(("latitude beyond ±90°", np.abs(latitude) > 90.0))
            gone = placeholders(latitude, longitude)
            found.append(("181° says that no longitude is available (AIS)", gone & (np.abs(latitude) <= 90.0)))
            found.append(("longitude beyond ±360°", np.abs(longitude) > 180.0))
            found.append(("latitude and longitude exactly 0", (latitude == 0.0) & (longitude == 0.0)))
            found.append(("only one of latitude and longitude is given", np.isnan(latitude) != np.isnan(longitude)))
        for name, value in values.items():
            found.append((f"{name} is beyond {FARTHEST:g}", np.abs(value) > FARTHEST))
        if position == "polar" and check:
            found.append(("range is negative", values["range"] < 0.0))
    return [(reason, bad) for reason, bad in found if bad.any()]


def _reject(rows: pl.DataFrame, problems: list[Problem]) -> tuple[list[pl.DataFrame], np.ndarray]:
    """Split off rows with a problem, each with its first reason and the value that was there."""
    good = np.ones(rows.height, bool)
    rejected = []
    for reason, bad, raw in problems:
        bad = bad & good
        if not bad.any():
            continue
        good &= ~bad
        mask = pl.Series(bad)
        part = rows.select("file", "row", "target").filter(mask).with_columns(reason=pl.lit(reason))
        if raw is not None:
            part = part.with_columns(texts(raw.filter(mask)).str.slice(0, 80).alias("value"))
        rejected.append(part)
    return rejected, good


def _first(series: pl.Series) -> object:
    known = series.drop_nulls().head(1)
    if not len(known):
        return None
    # a moment beyond the years of Python's datetime has a text all the same
    return texts(known)[0] if known.dtype.is_temporal() else known[0]
