"""Which way axes and angles run, and their units, where names leave it open: degrees in x and y, radians, NED."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .columns import is_altitude, normal
from .evidence import FASTEST, SLOWEST
from .rates import turn_rates
from .sheet import Sheet
from .units import ANGLE

DIRECTED = ("north", "east", "up", "down")  # names that say their direction themselves
FAST_PLOT = 1000.0  # m/s: a radar's targets are slower


def turn_axes(sheet: Sheet) -> None:
    """Bring north, east, down to east, north, up, and azimuth from the x axis to azimuth from north."""
    if sheet.position == "cartesian" and sheet.how.axes == "ned":
        x, y = sheet.roles["x"], sheet.roles["y"]
        if not normal(x.name).startswith(DIRECTED):
            sheet.roles["x"], sheet.roles["y"] = y, x
        z = sheet.roles.get("z")
        upwards = z is not None and (
            "altitude" in sheet.told or is_altitude(z.name) or "up" in normal(z.name).split("_")
        )
        if z is not None and (z.unit is None or z.unit > 0) and not upwards:
            sheet.roles["z"] = replace(z, unit=-(z.unit or 1.0))
        turn_rates(sheet)
        sheet.notes.append(f"axes are north, east, down: {x.name} points north, {y.name} east")


def maybe_degrees(sheet: Sheet, seconds: np.ndarray) -> None:
    """x and y that are longitude and latitude become such: they hardly move as metres, and as degrees they do.

    seconds (N,): the times as far as they are known.
    """
    x, y = sheet.roles["x"], sheet.roles["y"]
    if sheet.position != "cartesian" or x.unit is not None or y.unit is not None or {"x", "y"} & sheet.told:
        return
    east, north = sheet.numbers("x"), sheet.numbers("y")
    known = np.isfinite(east) & np.isfinite(north)
    if known.sum() < 4 or np.abs(east[known]).max() > 180.0 or np.abs(north[known]).max() > 90.0:
        return
    metres, degrees = sheet.motion(east, north), sheet.motion(north, east, "geographic")
    slow, fast = metres.speed(seconds), degrees.speed(seconds)
    reported = degrees.reported_speed()
    extent = max(np.ptp(east[known]), np.ptp(north[known]))
    if np.isfinite(reported) and np.isfinite(fast):
        # within a factor that knots or km/h for m/s explain
        same = 0.24 < fast / reported < 4.2 and slow < 0.1 * reported
    else:
        same = extent < 2.0 and slow < SLOWEST and SLOWEST <= fast <= FASTEST and degrees.gets_somewhere(seconds)
    if not same:
        return
    sheet.position = "geographic"
    sheet.roles["longitude"], sheet.roles["latitude"] = replace(x, unit=ANGLE["deg"]), replace(y, unit=ANGLE["deg"])
    if "z" in sheet:
        sheet.roles["altitude"] = sheet.roles["z"]
    sheet.drop("x", "y", "z")
    sheet.notes.append(
        f"columns {x.name!r} and {y.name!r} are taken as longitude and latitude in degrees: as metres they hardly move "
        f"({slow:.2g} m/s, as degrees {fast:.3g} m/s); --columns x={x.name},y={y.name} takes them as metres"
    )


def angle_units(sheet: Sheet, seconds: np.ndarray) -> None:
    """Azimuth and elevation without a unit: both in degrees as soon as one of them cannot be radians, else radians."""
    if sheet.position != "polar":
        return
    open_ = [name for name in ("azimuth", "elevation") if name in sheet and sheet.roles[name].unit is None]
    if open_:
        unit, why = _angle_unit(sheet, open_, seconds)
        for name in open_:
            column = sheet.roles[name]
            sheet.roles[name] = replace(column, unit=ANGLE["deg"] if unit == "degrees" else 1.0)
            sheet.notes.append(
                f"{name} in column {sheet.shown(name)!r} is taken as {unit} ({why}); "
                f"--columns {name}_deg={column.name} sets it"
            )
    if sheet.how.grid_turn is not None:
        column = sheet.roles["azimuth"]
        turn = sheet.how.grid_turn
        sheet.put("azimuth", sheet.numbers("azimuth") * (column.unit or 1.0) + turn, 1.0, sheet.shown("azimuth"))
        sheet.notes.append(
            f"azimuth in column {sheet.shown('azimuth')!r} counts from the north of {sheet.how.crs}, "
            f"{np.degrees(turn):+.2f} degrees from true north"
        )
    if sheet.how.azimuth == "east":
        column = sheet.roles["azimuth"]
        turned = 0.5 * np.pi - sheet.numbers("azimuth") * (column.unit or 1.0)
        sheet.put("azimuth", turned, 1.0, sheet.shown("azimuth"))
        sheet.notes.append(f"azimuth in column {sheet.shown('azimuth')!r} counts counter-clockwise from the x axis")


def _angle_unit(sheet: Sheet, open_: list[str], seconds: np.ndarray) -> tuple[str, str]:
    """Degrees or radians for all angles of the table, and why."""
    named = [sheet.roles[n].unit for n in ("azimuth", "elevation") if n in sheet and n not in open_]
    if ANGLE["deg"] in named:
        return "degrees", "as the other angle"
    if 1.0 in named:
        return "radians", "as the other angle"
    for name, limit, words in (("azimuth", 2 * np.pi, "2 pi"), ("elevation", 0.5 * np.pi, "pi / 2")):
        if name in open_:
            value = np.abs(sheet.numbers(name))
            if (value[np.isfinite(value)] > limit + 1e-9).any():
                beyond = f"values beyond {words}"
                return "degrees", beyond if len(open_) == 1 else f"{beyond} in column {sheet.shown(name)!r}"
    column = sheet.roles["range"]
    distance, azimuth = sheet.numbers("range") * (column.unit or 1.0), sheet.numbers("azimuth")
    fast, slow = (sheet.motion(distance, azimuth * unit).speed(seconds) for unit in (1.0, ANGLE["deg"]))
    if fast > FAST_PLOT and slow <= FAST_PLOT:
        return "degrees", f"median speed {slow:.3g} m/s, as radians {fast:.3g} m/s"
    return "radians", "no value beyond 2 pi"
