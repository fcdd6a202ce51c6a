"""What a table says of motion, in SI units: speed and course, velocities along axes, vertical rate, range rate.

Course counts clockwise from north (rad); x is east, y north, z up. A column of courses without a unit is in degrees as
soon as one value cannot be radians. A vertical rate without a unit is in feet a minute in a table of decoded ADS-B
(which has `groundspeed` too), and in metres a second elsewhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .codes import are_codes
from .columns import normal
from .roles import RATES
from .sheet import Sheet
from .units import DEGREE, FOOT_PER_MINUTE

FASTEST = 20_000.0  # m/s: more is no velocity, but a code for none
SIGNED = ("velocity_z", "vz", "vel_z", "v_z")  # vertical rates that follow the z axis
DIRECTED = ("east", "north", "e", "n", "ve", "vn")  # last words of names that say their direction themselves


def rates(sheet: Sheet, speed: np.ndarray) -> tuple[dict[str, np.ndarray], list[str]]:
    """The table's rates by role beside `speed` (m/s), which is known already, NaN where not available; and what had to
    be assumed.
    """
    found: dict[str, np.ndarray] = {}
    notes: list[str] = []
    for role in RATES[1:]:
        if role not in sheet:
            continue
        if role == "course":
            value = _course(sheet, notes)
        else:
            if role == "vertical_rate":
                _vertical_unit(sheet, notes)
            value = sheet.numbers(role)
            value = np.where(are_codes(value), np.nan, value) * (sheet.roles[role].unit or 1.0)
            value = np.where(np.abs(value) < FASTEST, value, np.nan)
        if np.isfinite(value).any():
            found[role] = value
        else:
            sheet.drop(role)
    if "course" in found and not np.isfinite(speed).any():
        # a direction alone is no velocity
        del found["course"]
        sheet.drop("course")
    if ("velocity_x" in found) != ("velocity_y" in found):
        lone = "velocity_x" if "velocity_x" in found else "velocity_y"
        del found[lone]
        sheet.drop(lone)
    return found, notes


def turn_rates(sheet: Sheet) -> None:
    """Velocities of a table whose axes are north, east, down."""
    x, y = sheet.roles.get("velocity_x"), sheet.roles.get("velocity_y")
    if x and y and normal(x.name).split("_")[-1] not in DIRECTED:
        sheet.roles["velocity_x"], sheet.roles["velocity_y"] = y, x
    up = sheet.roles.get("vertical_rate")
    if up and normal(up.name) in SIGNED:
        sheet.roles["vertical_rate"] = replace(up, unit=-(up.unit or 1.0))


def _course(sheet: Sheet, notes: list[str]) -> np.ndarray:
    """Radians; AIS says 360 (and 511 for a heading) where there is none."""
    column = sheet.roles["course"]
    value = sheet.numbers("course")
    known = value[np.isfinite(value)]
    unit = column.unit
    if unit is None:
        degrees = bool((np.abs(known) > 2 * np.pi + 1e-6).any())
        unit = DEGREE if degrees else 1.0
        why = "values beyond 2 pi" if degrees else "no value beyond 2 pi"
        sheet.roles["course"] = replace(column, unit=unit)
        notes.append(
            f"course in column {sheet.shown('course')!r} is taken as {'degrees' if degrees else 'radians'} ({why}); "
            f"--columns course_deg={column.name} sets it"
        )
    if unit == DEGREE:
        limit = 360.0 if normal(column.name) == "cog" else 360.0 + 1e-9
        value = np.where((value < limit) & (value > -360.0), value, np.nan)
    return value * unit


def _vertical_unit(sheet: Sheet, notes: list[str]) -> None:
    column = sheet.roles["vertical_rate"]
    names = {normal(name) for name in sheet.names}
    if column.unit is not None or normal(column.name) != "vertical_rate" or "groundspeed" not in names:
        return
    sheet.roles["vertical_rate"] = replace(column, unit=FOOT_PER_MINUTE)
    notes.append(
        f"vertical rate in column {sheet.shown('vertical_rate')!r} is taken as feet a minute (the table also has "
        f"groundspeed, as decoded ADS-B); --columns vertical_rate_mps={column.name} sets it"
    )
