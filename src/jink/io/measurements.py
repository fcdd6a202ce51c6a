"""Columns as they were found to measurements in SI units; what cannot be read is named and set aside.

What a name does not say is decided for the whole table, said in a note, and can be given by the user:

- *time*, a number: by its size seconds, milliseconds, microseconds or nanoseconds since 1970, or plain
  seconds when below 1e8;
- *altitude* without a unit: feet in a table that also has `groundspeed` and `vertical_rate` (the `traffic`
  package and its kin decode ADS-B in feet, knots and feet per minute), metres otherwise (OpenSky's
  `geoaltitude` and `baroaltitude`, GPS logs);
- *azimuth, elevation* without a unit: radians, or degrees as soon as one value is beyond ±2π.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import polars as pl

from .clocks import read_times
from .columns import ANGLE, Column, Columns, normal
from .errors import InputError
from .values import numbers, texts

Problem = tuple[str, np.ndarray, pl.Series | None]  # reason, rows, the column whose values are to be shown

FOOT = 0.3048
FARTHEST = 1e10  # m: nothing that is tracked is so far, and squares of more lose all digits
DIMENSIONS = {
    "geographic": ("latitude", "longitude", "altitude"),
    "cartesian": ("x", "y", "z"),
    "polar": ("range", "azimuth", "elevation", "altitude"),
}
# metres: 95 % horizontal bound (estimated position uncertainty) of NACp, containment radius of NIC,
# 95 % vertical bound of GVA (RTCA DO-260B)
NACP = {
    11: 3.0,
    10: 10.0,
    9: 30.0,
    8: 92.6,
    7: 185.2,
    6: 555.6,
    5: 926.0,
    4: 1852.0,
    3: 3704.0,
    2: 7408.0,
    1: 18520.0,
}
NIC = {
    11: 7.5,
    10: 25.0,
    9: 75.0,
    8: 185.2,
    7: 370.4,
    6: 1111.2,
    5: 1852.0,
    4: 3704.0,
    3: 7408.0,
    2: 14816.0,
    1: 37040.0,
}
GVA = {2: 45.0, 1: 150.0}
RAYLEIGH_95 = math.sqrt(-2.0 * math.log(0.05))  # radius of the 95 % circle of a circular Gaussian of sd 1
RAYLEIGH_NIC = math.sqrt(-2.0 * math.log(1e-5))  # NIC's radius is left once in 1e5 (the weakest integrity level, SIL 2)


@dataclass
class Measurements:
    """Measurements in SI units, one row per readable input row, and what was noticed on the way.

    `rows` has file, row, target, source, time (seconds, since 1970 when `absolute`), the position's
    components (NaN: missing), speed, position_sd and altitude_sd (from ADS-B accuracy categories; NaN: not
    stated).
    """

    rows: pl.DataFrame
    rejected: list[pl.DataFrame]
    position: str
    absolute: bool
    named: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def measure(
    file: str | None,
    frame: pl.DataFrame,
    columns: Columns,
    *,
    altitude_unit: str | None = None,
    time_unit: str | None = None,
    default_target: str = "0",
    check_coordinates: bool = True,
) -> Measurements:
    """Convert the recognised columns of `frame`, which has `row` too; InputError if no time is readable."""
    where = file or "the table"
    clock = frame[columns.roles["time"].name]
    times = read_times(where, clock, columns.roles["time"].unit, time_unit)
    if frame.height and np.isnan(times.seconds).all():
        raise InputError(
            f"{where}: no time could be read in column {clock.name!r} (first value: {_first(clock)!r}); "
            "expected ISO 8601 date-times or numbers (seconds, or ms, us, ns since 1970)"
        )
    problems: list[Problem] = [("time is missing or unreadable", np.isnan(times.seconds), clock)]
    target, target_note = _targets(frame, columns, default_target)
    if "target" in columns.roles:
        problems.append(("no identifier", target.is_null().to_numpy(), frame[columns.roles["target"].name]))
    values, notes, unreadable = _positions(frame, columns, altitude_unit)
    problems += unreadable
    problems += [(reason, bad, None) for reason, bad in _invalid(columns.position, values, check_coordinates)]
    rows = pl.DataFrame(
        {"file": pl.repeat(file, frame.height, dtype=pl.String, eager=True), "row": frame["row"]}
    ).with_columns(
        target,
        _source(frame, columns, file),
        pl.Series("time", times.seconds),
        *[pl.Series(name, value) for name, value in values.items()],
        pl.Series("speed", _speed(frame, columns)),
        *_accuracies(frame, columns),
    )
    rejected, good = _reject(rows, problems)
    notes = times.notes + target_note + notes
    kept = rows.filter(pl.Series(good))
    return Measurements(kept, rejected, columns.position, times.absolute, columns.named(), notes)


def _positions(
    frame: pl.DataFrame, columns: Columns, altitude_unit: str | None
) -> tuple[dict[str, np.ndarray], list[str], list[Problem]]:
    """The position's components in SI units (latitude and longitude in degrees), notes, unreadable values."""
    values: dict[str, np.ndarray] = {}
    notes: list[str] = []
    problems: list[Problem] = []
    for name in (n for n in DIMENSIONS[columns.position] if n in columns.roles):
        column = columns.roles[name]
        number, bad = numbers(frame[column.name])
        unit, note = _unit(name, column, number, columns, altitude_unit)
        notes += note
        with np.errstate(over="ignore"):
            values[name] = number * unit
        if name == "altitude" and bad.any():
            count = int(bad.sum())
            notes.append(f"{count} unreadable altitudes in column {column.name!r} are taken as missing")
        elif bad.any():
            problems.append((f"{name} is not a number", bad, frame[column.name]))
    if columns.position == "geographic":
        _degrees(values)
    return values, notes, problems


def _targets(frame: pl.DataFrame, columns: Columns, default: str) -> tuple[pl.Series, list[str]]:
    if "target" not in columns.roles:
        note = (
            f"no identifier column was recognised: all rows are taken as target {default!r}; "
            "--columns target=... names one"
        )
        return pl.repeat(default, frame.height, dtype=pl.String, eager=True).alias("target"), [note]
    series = frame[columns.roles["target"].name]
    if series.dtype.is_float():
        whole = series.is_finite() & (series == series.round())
        series = series.fill_nan(None)
        if whole.filter(series.is_not_null()).all():
            series = series.cast(pl.Int64, strict=False)
    text = texts(series).str.strip_chars()
    return text.set(text == "", None).alias("target"), []


def _source(frame: pl.DataFrame, columns: Columns, file: str | None) -> pl.Series:
    """Who measured: the sensor's column where there is one, otherwise the file."""
    if "source" in columns.roles:
        return texts(frame[columns.roles["source"].name]).fill_null("unknown").alias("source")
    return pl.repeat(file or "data", frame.height, dtype=pl.String, eager=True).alias("source")


def _unit(
    name: str, column: Column, value: np.ndarray, columns: Columns, altitude_unit: str | None
) -> tuple[float, list[str]]:
    """The unit of a column in SI units and, where it had to be assumed, a note that says so."""
    if name == "altitude" and altitude_unit is not None:
        return {"ft": FOOT, "m": 1.0}[altitude_unit], []
    if column.unit is not None:
        return column.unit, []
    if name == "altitude":
        names = {normal(n) for n in columns.names}
        feet = {"groundspeed", "vertical_rate"} <= names
        why = (
            "the table also has groundspeed and vertical_rate, as decoded ADS-B in feet and knots"
            if feet
            else "SI by default"
        )
        unit = "feet" if feet else "metres"
        return FOOT if feet else 1.0, [
            f"altitude in column {column.name!r} is taken as {unit} ({why}); --altitude-unit ft|m changes it"
        ]
    if name in ("azimuth", "elevation"):
        known = np.abs(value[np.isfinite(value)])
        degrees = bool((known > 2 * math.pi + 1e-9).any())
        unit = "degrees (values beyond 2 pi)" if degrees else "radians (no value beyond 2 pi)"
        return ANGLE["deg"] if degrees else 1.0, [
            f"{name} in column {column.name!r} is taken as {unit}; --columns {name}_deg={column.name} sets it"
        ]
    return 1.0, []


def _degrees(values: dict[str, np.ndarray]) -> None:
    """Turn latitude and longitude back to degrees, longitude within ±180."""
    for name in ("latitude", "longitude"):
        values[name] = np.degrees(values[name])
    with np.errstate(invalid="ignore"):
        beyond = np.abs(values["longitude"]) > 180.0
        values["longitude"][beyond & (values["longitude"] <= 360.0)] -= 360.0


def _invalid(position: str, values: dict[str, np.ndarray], check: bool) -> list[tuple[str, np.ndarray]]:
    """Impossible coordinates by reason. Half a position counts as one; a missing altitude does not."""
    found: list[tuple[str, np.ndarray]] = []
    with np.errstate(invalid="ignore"):
        if position == "geographic" and check:
            latitude, longitude = values["latitude"], values["longitude"]
            found.append(("latitude beyond ±90°", np.abs(latitude) > 90.0))
            found.append(("longitude beyond ±360°", np.abs(longitude) > 180.0))
            found.append(("latitude and longitude exactly 0", (latitude == 0.0) & (longitude == 0.0)))
            found.append(("only one of latitude and longitude is given", np.isnan(latitude) != np.isnan(longitude)))
        for name, value in values.items():
            found.append((f"{name} is beyond {FARTHEST:g}", np.abs(value) > FARTHEST))
        if position == "polar" and check:
            found.append(("range is negative", values["range"] < 0.0))
    return [(reason, bad) for reason, bad in found if bad.any()]


def _speed(frame: pl.DataFrame, columns: Columns) -> np.ndarray:
    if "speed" not in columns.roles:
        return np.full(frame.height, np.nan)
    return numbers(frame[columns.roles["speed"].name])[0] * (columns.roles["speed"].unit or 1.0)


def _accuracies(frame: pl.DataFrame, columns: Columns) -> list[pl.Series]:
    """Sds (m) that ADS-B accuracy categories stand for; NACp before NIC, NaN where unknown."""

    def looked_up(role: str, table: dict[int, float], divisor: float) -> np.ndarray:
        if role not in columns.roles:
            return np.full(frame.height, np.nan)
        category = numbers(frame[columns.roles[role].name])[0]
        steps = np.full(16, np.nan)
        steps[list(table)] = np.array(list(table.values())) / divisor
        known = np.isfinite(category) & (category >= 0) & (category < 16)
        return np.where(known, steps[np.where(known, category, 0).astype(int)], np.nan)

    horizontal = looked_up("nacp", NACP, RAYLEIGH_95)
    horizontal = np.where(np.isnan(horizontal), looked_up("nic", NIC, RAYLEIGH_NIC), horizontal)
    return [pl.Series("position_sd", horizontal), pl.Series("altitude_sd", looked_up("gva", GVA, 1.96))]


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
    known = series.drop_nulls()
    return known[0] if len(known) else None
