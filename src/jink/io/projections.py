"""Coordinates of map projections (UTM, Web Mercator, national grids) to latitude and longitude; where grid north is.

x and y of a projection are not the plane's: speeds are too large by its scale, 1 / cos(latitude) in Web Mercator.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import polars as pl

from .conventions import Conventions
from .errors import InputError
from .geodesy import geodesics_between
from .sheet import Sheet
from .units import DEGREE

AHEAD = 100.0  # m: so far along grid north its direction is measured
LARGE = 1e6  # m: beyond the reach of a radar, so that x and y are a map's
MERCATOR = "EPSG:3857"
MERCATOR_EDGE = 20_048_967.0  # m: 85.06 degrees north in Web Mercator
EARTH = 6_378_137.0  # m: the sphere of Web Mercator
LIKE = 0.03  # how near the reported speeds come to those of Web Mercator
APART = 0.05  # by how much Web Mercator must stretch the speeds to be told


@lru_cache(maxsize=8)
def _to_degrees(code: str) -> tuple[Any, float]:
    """What turns x and y of a projection into longitude and latitude, and the projection's unit in metres.

    Errors: InputError for a name that pyproj does not know.
    """
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError, ProjError

    try:
        crs = CRS.from_user_input(code)
        if not crs.is_projected:
            raise InputError(f"--crs {code} is {crs.name}, which has no x and y in metres; expected a projection")
        back = Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    except (CRSError, ProjError):
        raise InputError(
            f"--crs is {code!r}; expected a projection that pyproj knows, such as EPSG:3857 (Web Mercator) or "
            "EPSG:32632 (UTM zone 32 north)"
        ) from None
    return back, float(crs.axis_info[0].unit_conversion_factor)


def degrees(code: str, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Latitude and longitude (degrees) of x and y in the projection's unit; NaN where it has none."""
    longitude, latitude = _to_degrees(code)[0].transform(x, y)
    known = np.isfinite(longitude) & np.isfinite(latitude)
    return np.where(known, latitude, np.nan), np.where(known, longitude, np.nan)


def grid_north(code: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Azimuth (rad, clockwise from true north) of the projection's y axis at x and y."""
    step = AHEAD / _to_degrees(code)[1]
    latitude, longitude = degrees(code, x, y)
    above, right = degrees(code, x, y + step)
    azimuth = geodesics_between(latitude, longitude, above, right)[0]
    return np.where(np.isfinite(azimuth), azimuth, 0.0)


def unprojected(sheet: Sheet) -> None:
    """x and y of the user's projection become latitude and longitude; velocities along them turn to true north."""
    code = sheet.how.crs
    if code is None or sheet.how.azimuth == "grid":
        return
    if sheet.position != "cartesian":
        raise InputError(f"{sheet.where}: --crs {code} is for x and y, but this table has {sheet.position} positions")
    metre = _to_degrees(code)[1]
    x, y = (
        sheet.numbers(name) * (1.0 if (unit := sheet.roles[name].unit) is None else unit / metre) for name in ("x", "y")
    )
    latitude, longitude = degrees(code, x, y)
    shown = sheet.shown("x"), sheet.shown("y")
    _turn_velocities(sheet, grid_north(code, x, y))
    sheet.put("latitude", latitude, DEGREE, shown[1])
    sheet.put("longitude", longitude, DEGREE, shown[0])
    if "z" in sheet:
        sheet.roles["altitude"] = sheet.roles["z"]
    sheet.drop("x", "y", "z")
    sheet.position = "geographic"
    sheet.notes.append(f"columns {shown[0]!r} and {shown[1]!r} are coordinates of {code}")


def _turn_velocities(sheet: Sheet, turn: np.ndarray) -> None:
    """Velocities along the grid's axes to those along east and north."""
    if "velocity_x" not in sheet or "velocity_y" not in sheet:
        return
    names = sheet.shown("velocity_x"), sheet.shown("velocity_y")
    vx, vy = (sheet.numbers(name) * (sheet.roles[name].unit or 1.0) for name in ("velocity_x", "velocity_y"))
    sheet.put("velocity_x", vx * np.cos(turn) + vy * np.sin(turn), 1.0, names[0])
    sheet.put("velocity_y", vy * np.cos(turn) - vx * np.sin(turn), 1.0, names[1])


def maybe_mercator(sheet: Sheet, seconds: np.ndarray) -> None:
    """x and y as large as a map's: Web Mercator if the reported speeds say so; otherwise a note says what may be.

    seconds (N,): the times as far as they are known.
    """
    if sheet.position != "cartesian" or sheet.how.crs is not None or {"x", "y"} & sheet.told:
        return
    x, y = (sheet.numbers(name) * (sheet.roles[name].unit or 1.0) for name in ("x", "y"))
    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < 4 or max(np.median(np.abs(x[known])), np.median(np.abs(y[known]))) < LARGE:
        return
    if max(np.abs(x[known]).max(), np.abs(y[known]).max()) > MERCATOR_EDGE:
        return
    stretched = math.cosh(float(np.median(y[known])) / EARTH)
    motion = sheet.motion(x, y)
    reported, fast = motion.reported_speed(), motion.speed(seconds)
    names = sheet.shown("x"), sheet.shown("y")
    if np.isfinite(reported) and reported > 0.0 and stretched > 1.0 + APART:
        if abs(fast / reported / stretched - 1.0) < LIKE:
            sheet.how = replace(sheet.how, crs=MERCATOR)
            unprojected(sheet)
            sheet.notes[-1] += (
                f" (Web Mercator): as metres they move {fast / reported:.3g} times as fast as the reported speed, and "
                f"Web Mercator stretches by {stretched:.3g} there; --columns x={names[0]},y={names[1]} takes metres"
            )
        return
    sheet.notes.append(
        f"columns {names[0]!r} and {names[1]!r} are as large as a map's coordinates and are taken as metres. In Web "
        f"Mercator (--crs {MERCATOR}) speeds would be {stretched:.3g} times too large; --crs names any projection"
    )


def with_grid(how: Conventions, site: Any, several: bool) -> Conventions:
    """How far grid north is from true north at a site (`latitude`, `longitude`), if azimuths count from grid north.

    The grid is that of `crs`, or of UTM. Errors: InputError.
    """
    if how.azimuth != "grid":
        return how
    if several or site is None:
        raise InputError(
            "azimuths from grid north need one --site: it tells how far grid north is from true north. "
            "Plots of several radars are turned to true north before"
        )
    code = how.crs or utm_zone(site.latitude, site.longitude)
    from pyproj import Transformer

    back, _ = _to_degrees(code)
    forth = Transformer.from_crs("EPSG:4326", back.source_crs, always_xy=True)
    x, y = forth.transform(site.longitude, site.latitude)
    turn = float(grid_north(code, np.array([x]), np.array([y]))[0])
    return replace(how, crs=code, grid_turn=turn)


def utm_zone(latitude: float, longitude: float) -> str:
    """The EPSG code of the UTM zone (WGS 84) of a place."""
    zone = int((longitude + 180.0) // 6.0) % 60 + 1
    return f"EPSG:{32600 if latitude >= 0.0 else 32700}".removesuffix("00") + f"{zone:02d}"


def srid(series: pl.Series) -> str | None:
    """The projection that all places of a column name: `SRID=3857;POINT(...)`; None for none, or degrees."""
    found = series.str.extract(r"(?i)^\s*SRID=(\d+);").drop_nulls().unique().to_list()
    return f"EPSG:{found[0]}" if len(found) == 1 and found[0] not in ("4326", "0") else None
