"""From what columns are called to what they hold: names first, then values; what is inferred is said in notes.

Order matters: the target tells whose times start over, times and positions tell each other's units by the speed that
they imply.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl

from .axes import angle_units, maybe_degrees, turn_axes
from .clocks import read_times
from .columns import Column, Columns, normal
from .conventions import Conventions, Times
from .coordinates import angles, from_minutes, pair, scale, signs
from .errors import InputError
from .exchanged import not_exchanged
from .identity import choose_target, unique_per_row
from .moments import (
    choose_time,
    doubtful_time,
    read_moments,
    wants_motion,
    with_date,
    with_midnights,
    with_nanoseconds,
    with_parts,
)
from .projections import degrees, maybe_mercator, srid, unprojected
from .quality import placeholders
from .roles import POSITIONS
from .sheet import Sheet
from .units import DEGREE, SEMICIRCLE
from .units_in_fields import read_units
from .values import numbers, texts

HEMISPHERES = {"latitude": ("north_south", "NS"), "longitude": ("east_west", "EW")}
GROUND = r"(?i)^\s*(ground|gnd|on ground)\s*$"


def doubtful(frame: pl.DataFrame, columns: Columns) -> list[str]:
    """Names of further columns that are to be read, because those that were found may not hold what they are called."""
    roles, others = columns.roles, columns.others
    wanted: list[str] = []
    if "target" in others and unique_per_row(frame[roles["target"].name]):
        wanted += [column.name for column in others["target"]]
    if "time" in others and "time" not in columns.given:
        codes = np.zeros(frame.height, int)
        if "week" in roles or doubtful_time(frame[roles["time"].name], codes):
            wanted += [column.name for column in others["time"]]
    if "altitude" in others and columns.position == "geographic" and _says_nothing(frame[roles["altitude"].name]):
        wanted += [column.name for column in others["altitude"]]
    return [name for name in dict.fromkeys(wanted) if name not in frame.columns]


def understand(
    where: str, frame: pl.DataFrame, columns: Columns, how: Conventions, time_unit: str | None, stream: bool = False
) -> tuple[Sheet, Times]:
    """The table with every role settled, and its times; of a stream by names and by what each field says alone.

    Errors: InputError for what stays ambiguous.
    """
    sheet = Sheet.of(where, frame, columns, how)
    beside = " and ".join(POSITIONS[sheet.position])
    sheet.notes += [
        f"column {name!r} is not used: --columns names it {role}, which has no use beside {beside}"
        for role, name in columns.idle.items()
    ]
    with_parts(sheet)
    with_nanoseconds(sheet)
    if not stream:
        choose_target(sheet)
        choose_time(sheet)
    if "date" in sheet:
        with_date(sheet)
    read_units(sheet)
    if sheet.position == "geographic":
        _geographic(sheet)
    turn_axes(sheet)
    unprojected(sheet)
    if stream:
        angle_units(sheet, np.zeros(0))
        return sheet, read_moments(sheet, time_unit, None)
    if sheet.position == "geographic":
        _rescale(sheet)
    open_units = sheet.position == "polar" or (sheet.position == "cartesian" and sheet.roles["x"].unit is None)
    if open_units:
        column = sheet.roles["time"]
        rough = read_times(where, sheet.series("time"), column.unit, time_unit, how).seconds
        if sheet.position == "cartesian":
            maybe_degrees(sheet, rough)
            maybe_mercator(sheet, rough)
        else:
            angle_units(sheet, rough)
    motion = None
    if sheet.roles["time"].unit is None and time_unit is None and wants_motion(sheet.series("time")):
        motion = _motion(sheet)
    times = read_moments(sheet, time_unit, motion)
    if times.of_day:
        seconds, count = with_midnights(times.seconds, sheet.codes())
        if count:
            sheet.notes.append(f"times go on after midnight ({count} times)")
        times = replace(times, seconds=seconds)
    if "altitude" in sheet and sheet.position == "geographic":
        _second_altitude(sheet)
    not_exchanged(sheet, times.seconds)
    return sheet, times


def _motion(sheet: Sheet):
    """The positions as evidence of how fast targets go."""
    names = {"geographic": ("latitude", "longitude"), "cartesian": ("x", "y"), "polar": ("range", "azimuth")}
    first, second = names[sheet.position]

    def in_si(role: str) -> np.ndarray:
        unit = sheet.roles[role].unit or 1.0
        return sheet.numbers(role) * (unit / DEGREE if sheet.position == "geographic" else unit)

    return sheet.motion(in_si(first), in_si(second))


def _geographic(sheet: Sheet) -> None:
    """Latitude and longitude as signed degrees, whatever they were written as."""
    if "place" in sheet:
        _split(sheet)
    for role in ("latitude", "longitude"):
        _from_text(sheet, role)
        _with_minutes(sheet, role)
    sheet.drop("place")
    for role, (mark, letters) in HEMISPHERES.items():
        if mark in sheet:
            _hemisphere(sheet, role, mark, letters)


def _split(sheet: Sheet) -> None:
    name = sheet.roles["place"].name
    found = pair(sheet.series("place"), normal(name)) if sheet.series("place").dtype == pl.String else None
    if found is None:
        value = sheet.series("place").drop_nulls()
        raise InputError(
            f"{sheet.where}: column {name!r} holds no pairs of latitude and longitude (first value: "
            f"{value[0] if len(value) else None!r}); --columns latitude=...,longitude=... names two columns"
        )
    latitude, longitude, order = found
    code = srid(sheet.series("place"))
    if code is not None:
        north, east = degrees(code, numbers(longitude)[0], numbers(latitude)[0])
        sheet.put("latitude", north, DEGREE, name)
        sheet.put("longitude", east, DEGREE, name)
        sheet.notes.append(f"column {name!r} has coordinates of {code}")
        return
    sheet.put("latitude", latitude, DEGREE, name)
    sheet.put("longitude", longitude, DEGREE, name)
    sheet.notes.append(f"column {name!r} is split into latitude and longitude ({order})")


def _from_text(sheet: Sheet, role: str) -> None:
    """Letters and degree signs in the fields; a comma in them is a decimal one."""
    series = sheet.series(role)
    if series.dtype != pl.String:
        return
    comma = series.str.contains(r"^\s*[+-]?\d{1,3},\d+\s*$")
    if comma.any():
        series = series.str.replace(",", ".")
        sheet.put(role, series, sheet.roles[role].unit, sheet.shown(role))
    plain = series.str.strip_chars().cast(pl.Float64, strict=False)
    if plain.count() >= 0.5 * series.count() or sheet.roles[role].unit != DEGREE:
        return
    read = angles(series)
    if read is not None:
        sheet.put(role, read, DEGREE, sheet.shown(role))
        sheet.notes.append(
            f"{role} in column {sheet.shown(role)!r} is text with letters, minutes or seconds, and is read as such"
        )


def _with_minutes(sheet: Sheet, role: str) -> None:
    """Whole degrees, minutes and perhaps seconds in columns of their own."""
    finer = [f"{role}_minutes", f"{role}_seconds"]
    if finer[0] not in sheet:
        sheet.drop(*finer)
        return
    there = [name for name in finer if name in sheet]
    value = sheet.numbers(role)
    known = value[np.isfinite(value)]
    if known.size and not (known % 1).any() and sheet.roles[role].unit == DEGREE:
        size = np.abs(value)
        for name, parts in zip(finer, (60.0, 3600.0), strict=True):
            if name in sheet:
                size = size + sheet.numbers(name) / parts
        # of -0 degrees text alone knows the sign
        south = texts(sheet.series(role)).str.strip_chars().str.starts_with("-").fill_null(False).to_numpy()
        shown = " + ".join(sheet.shown(name) for name in (role, *there))
        sheet.put(role, np.where(south, -size, size), DEGREE, shown)
        sheet.notes.append(f"{role} is put together from columns {shown}")
    sheet.drop(*finer)


def _hemisphere(sheet: Sheet, role: str, mark: str, letters: str) -> None:
    sign = signs(sheet.series(mark), letters)
    if sign is None:
        sheet.drop(mark)
        return
    value = np.abs(sheet.numbers(role)) * sign
    sheet.put(role, value, sheet.roles[role].unit, f"{sheet.shown(role)} + {sheet.shown(mark)}")
    sheet.notes.append(f"the sign of {role} is that of column {sheet.shown(mark)!r} ({letters[0]} or {letters[1]})")
    sheet.drop(mark)


def _rescale(sheet: Sheet) -> None:
    """Numbers beyond 90 and 180: degrees and minutes in one number, or fractions of a degree counted as integers."""
    pairs = [sheet.roles[role] for role in ("latitude", "longitude")]
    if any(column.unit != DEGREE or normal(column.name).endswith(("deg", "degrees")) for column in pairs):
        return
    latitude, longitude = sheet.numbers("latitude"), sheet.numbers("longitude")
    known = np.isfinite(latitude) & np.isfinite(longitude)
    north, east = np.abs(latitude[known]), np.abs(longitude[known])
    _exchanged(sheet, north, east)
    _maybe_radians(sheet, north, east)
    kind, fits = scale(north, east)
    if kind == "minutes":
        for role, value in (("latitude", latitude), ("longitude", longitude)):
            sheet.put(role, from_minutes(value), DEGREE, sheet.shown(role))
        sheet.notes.append("latitude and longitude are read as degrees and minutes in one number (ddmm.mmmm)")
    if kind != "scaled":
        return
    first = f"{latitude[np.isfinite(latitude)][0]:.0f}"
    if normal(pairs[0].name) == "position_lat":
        fits = [(SEMICIRCLE, "semicircles, as FIT files count")]
    # AIS's codes for no position are at home in one unit alone
    coded = [each for each in fits if placeholders(latitude * each[0], longitude * each[0]).any()]
    fits = coded if len(coded) == 1 else fits
    if len(fits) > 1 and (np.abs(longitude) > 180e5).any():
        fits = fits[:1] if (np.abs(latitude) * fits[1][0] > 90).any() else fits
    if len(fits) > 1:
        readings = " or ".join(f"{float(first) * factor:.6f}° in {words}" for factor, words in fits)
        raise InputError(
            f"{sheet.where}: the latitude {first} can be {readings}; --columns latitude_e7={pairs[0].name},"
            f"longitude_e7={pairs[1].name} (or _e6, _e5, _e4min, _semicircles) sets it"
        )
    factor, words = fits[0]
    for role in ("latitude", "longitude"):
        sheet.roles[role] = replace(sheet.roles[role], unit=factor * DEGREE)
    sheet.notes.append(f"latitude and longitude are taken as {words} (no other unit keeps them on the globe)")
    _millimetres(sheet)


def _exchanged(sheet: Sheet, north: np.ndarray, east: np.ndarray) -> None:
    """Latitudes beyond 90 beside longitudes within 90: the columns are exchanged. north, east: sizes without a sign."""
    # a few such rows are wrong rows; that all of them are is another matter, 91 (AIS: none) apart
    if north.size > 3 and ((north > 91.0) & (north <= 180.0) & (east <= 90.0)).mean() > 0.9:
        first, second = sheet.shown("latitude"), sheet.shown("longitude")
        raise InputError(
            f"{sheet.where}: the latitudes in column {first!r} lie beyond 90 and the longitudes in {second!r} within, "
            f"so the two are exchanged; --columns latitude={second},longitude={first} sets it"
        )


def _maybe_radians(sheet: Sheet, north: np.ndarray, east: np.ndarray) -> None:
    """All positions within pi / 2 and pi of 0° N 0° E: a place in the ocean, or radians; reported speeds decide."""
    if north.max(initial=0.0) > 0.5 * np.pi or east.max(initial=0.0) > np.pi:
        return
    if np.count_nonzero((north != 0.0) | (east != 0.0)) < 4:
        return
    names = [sheet.shown(role) for role in ("latitude", "longitude")]
    mend = f"--columns latitude_rad={names[0]},longitude_rad={names[1]}"
    sheet.notes.append(f"all positions are within pi / 2 and pi of 0 N 0 E; if they are radians, {mend} says so")


def _millimetres(sheet: Sheet) -> None:
    """Devices that count degrees in 1e-7 count heights in millimetres."""
    if "altitude" not in sheet or sheet.roles["altitude"].unit is not None:
        return
    height = sheet.numbers("altitude")
    known = height[np.isfinite(height)]
    if known.size and (known % 1 == 0).all() and np.median(np.abs(known)) > 9000.0:
        sheet.roles["altitude"] = replace(sheet.roles["altitude"], unit=1e-3)
        sheet.notes.append(
            f"altitude in column {sheet.shown('altitude')!r} is taken as millimetres, as such devices count"
        )


def _says_nothing(series: pl.Series) -> bool:
    """Whether a column of heights is missing in most rows, or 0 in all."""
    value = numbers(series)[0]
    known = value[np.isfinite(value)]
    return known.size < 0.5 * value.size or not (known != 0).any()


def _second_altitude(sheet: Sheet) -> None:
    """Another column of heights where the usual one is missing or 0."""
    column = sheet.roles["altitude"]
    if (
        "altitude" in sheet.told
        or column.name not in sheet.frame.columns
        or not _says_nothing(sheet.series("altitude"))
    ):
        return
    first = sheet.series("altitude")
    if first.dtype == pl.String and first.str.contains(GROUND).any():
        return
    for other in sheet.others.get("altitude", ()):
        if not _says_nothing(sheet.frame[other.name]) or sheet.frame[other.name].count() > 2 * first.count():
            sheet.roles["altitude"] = Column(other.name, other.unit)
            sheet.notes.append(
                f"column {column.name!r} is missing in most rows, or 0, so altitude is that of column {other.name!r}"
            )
            return
