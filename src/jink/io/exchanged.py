"""Latitude and longitude that are exchanged although both stay on the globe: reported speeds and courses tell."""

from __future__ import annotations

import numpy as np

from .errors import InputError
from .evidence import distances
from .sheet import Sheet
from .units import DEGREE
from .values import order_of

FEWEST = 20  # steps that have to agree
SAME_SPEED, SAME_COURSE = 0.05, 0.2  # relative, and rad
OTHER_SPEED, OTHER_COURSE = 0.1, 0.5


def not_exchanged(sheet: Sheet, seconds: np.ndarray) -> None:
    """Errors: InputError where exchanged columns move as reported, in speed and course, and those as named do not."""
    if not {"latitude", "longitude", "speed", "course"} <= sheet.roles.keys() or {"latitude", "longitude"} & sheet.told:
        return
    north, east = (
        sheet.numbers(role) * (sheet.roles[role].unit or DEGREE) / DEGREE for role in ("latitude", "longitude")
    )
    speed = sheet.numbers("speed") * (sheet.roles["speed"].unit or 1.0)
    course = sheet.numbers("course") * (sheet.roles["course"].unit or DEGREE)
    good = np.isfinite(north) & np.isfinite(east) & np.isfinite(seconds) & (speed > 0.0) & np.isfinite(course)
    rows = np.flatnonzero(good)
    rows = rows[order_of(sheet.codes()[rows], seconds[rows])]
    north, east, speed, course = north[rows], east[rows], speed[rows], course[rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        elapsed = np.where(np.diff(sheet.codes()[rows]) == 0, np.diff(seconds[rows]), np.nan)
        as_named = _disagree(north, east, elapsed, speed, course)
        if as_named is None or as_named[0] <= OTHER_SPEED or as_named[1] <= OTHER_COURSE:
            return
        exchanged = _disagree(east, north, elapsed, speed, course)
    if exchanged is not None and exchanged[0] < SAME_SPEED and exchanged[1] < SAME_COURSE:
        first, second = sheet.shown("latitude"), sheet.shown("longitude")
        raise InputError(
            f"{sheet.where}: columns {first!r} and {second!r} are exchanged: only so do positions move as the reported "
            f"speeds and courses say; --columns latitude={second},longitude={first} sets it, and "
            f"--columns latitude={first},longitude={second} takes them as they are named"
        )


def _disagree(
    north: np.ndarray, east: np.ndarray, elapsed: np.ndarray, speed: np.ndarray, course: np.ndarray
) -> tuple[float, float] | None:
    """How far speeds (relative) and courses (rad) of the steps are from the reported ones; None where too few move."""
    if north.size <= FEWEST or np.abs(north).max() > 90.0:
        return None
    moved = distances(north, east, "geographic")
    turned = (np.diff(east) + 180.0) % 360.0 - 180.0
    way = np.arctan2(turned * np.cos(np.radians(north[1:])), np.diff(north))
    known = (moved > 0) & (elapsed > 0) & np.isfinite(elapsed)
    if known.sum() < FEWEST:
        return None
    rate = np.abs(moved / elapsed / speed[1:] - 1.0)[known]
    off = np.abs((way - course[1:] + np.pi) % (2 * np.pi) - np.pi)[known]
    return float(np.median(rate)), float(np.median(off))
