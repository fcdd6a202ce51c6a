"""Fields that tell their own unit: `513.863 M`, `35,000 ft`, `FL350`."""

from __future__ import annotations

import numpy as np
import polars as pl

from .columns import normal
from .sheet import Sheet
from .units import ANGLE, LENGTH, SPEED
from .values import EMPTY, numbers

WITH_UNIT = r"^(?P<number>[-+]?\d[\d.,]*) ?(?P<unit>[A-Za-z][A-Za-z/]*|°)$"
FLIGHT_LEVEL = r"^(?i:FL|F) ?(?P<level>\d{1,3})$"
LEVEL = "FL"
UNITS = {
    "altitude": LENGTH | {"fl": 100 * LENGTH["ft"]},
    "z": LENGTH,
    "speed": SPEED,
    "range": LENGTH,
    "x": LENGTH,
    "y": LENGTH,
    "azimuth": ANGLE,
    "elevation": ANGLE,
}
NEEDED = ("range", "x", "y", "azimuth", "elevation")  # without one there is no position


def read_units(sheet: Sheet) -> None:
    """Columns whose fields tell units, in SI units; what becomes of the fields that tell none is noted.

    Those have the unit of the column's name. Without one they have that of the others, if these are fewer and agree;
    else they are missing.
    """
    for role, units in UNITS.items():
        if role not in sheet or sheet.series(role).dtype != pl.String:
            continue
        text = sheet.series(role).str.strip_chars()
        number, unit = _parts(text, level=role == "altitude")
        found = unit.unique(maintain_order=True).drop_nulls().to_list()
        known = {name: units[unit_of(name)] for name in found if unit_of(name) in units}
        if not known:
            continue
        names, told = list(known), int(unit.is_in(list(known)).sum())
        there = ~(text.is_null() | text.str.to_lowercase().is_in(EMPTY))
        bare = (there & unit.is_null()).to_numpy()
        of_name = sheet.roles[role].unit
        most = told >= 0.5 * int(there.sum())
        of_bare = of_name or (np.nan if most or len(names) > 1 else known[names[0]])
        if LEVEL in names and len(names) == 1 and not most and of_name is None:
            of_bare = LENGTH["ft"]
        factor = unit.replace_strict(known, default=None, return_dtype=pl.Float64).fill_null(np.nan).to_numpy()
        factor = np.copysign(factor, of_name or 1.0)
        value, bad = numbers(number.fill_null(text), thousands=role == "altitude")
        bad |= unit.is_not_null().to_numpy() & np.isnan(factor)
        name = sheet.shown(role)
        sheet.put(role, value * np.where(bare, of_bare, factor), 1.0, name)
        sheet.own_units.add(role)
        rest = "" if not bare.any() else _rest(of_bare, of_name, names)
        every = "every field" if told == there.sum() else f"{told} of {there.sum()} fields"
        if names != [LEVEL] or told < there.sum():
            sheet.notes.append(f"{role} in column {name!r} has its unit in {every} ({', '.join(names)}){rest}")
        if role in NEEDED:
            none = bare & ~bad & np.isnan(of_bare)
            sheet.problems += [
                (f"{role} is not a number", bad, text),
                (f"{role} has no unit, as others have", none, text),
            ]
            continue
        sheet.notes += [f"{bad.sum()} unreadable fields in column {name!r} are taken as missing"] if bad.any() else []


def unit_of(text: str) -> str:
    """What a unit is called in `units.py`."""
    return "deg" if text == "°" else normal(text)


def _parts(text: pl.Series, level: bool) -> tuple[pl.Series, pl.Series]:
    """Number and unit of every field, null in those without a unit."""
    parts = text.str.extract_groups(WITH_UNIT).struct.unnest()
    number, unit = parts["number"], parts["unit"]
    if level:
        found = text.str.extract_groups(FLIGHT_LEVEL).struct.field("level")
        number, unit = number.fill_null(found), unit.set(found.is_not_null(), LEVEL)
    return number, unit


def _rest(of_bare: float, of_name: float | None, names: list[str]) -> str:
    """What becomes of fields without a unit."""
    if of_name is not None:
        return "; the others have that of the column's name"
    if np.isnan(of_bare):
        return "; the others are left out"
    return f"; the others are taken as {'ft' if LEVEL in names else names[0]}"
