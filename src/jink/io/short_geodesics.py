"""Geodesics of the WGS84 ellipsoid by series where they are short, and by `pyproj.Geod` (Karney 2013) where not.

Between two places: Gauss's mid-latitude formulas. With φ, λ in rad, Δ the differences, at the middle latitude
η² = e'² cos² φ, V² = 1 + η², t = tan φ, N = c / V, and s, α the length and the direction at the middle,

    s sin α = N Δλ cos φ (1 − Δλ² sin² φ / 24 + (1 + η² − 9 η² t²) Δφ² / 24 V⁴)
    s cos α = N Δφ / V² (1 − (2 + 3 t² + 2 η²) Δλ² cos² φ / 24 + η² (1 − t² + η² + 4 η² t²) Δφ² / 8 V⁴)
    Δα      = Δλ sin φ (1 + (1 + η²) Δλ² cos² φ / 12 + (3 + 8 η² + 5 η⁴) Δφ² / 24 V⁴)

From a place ahead: Legendre's series, with u, v the way north and east over N at the start,

    Δφ = V² (u − 3 η² t u² / 2 − t v² / 2 − (1 + 3 t² + η² − 9 η² t²) u v² / 6 − η² (1 − t² + η² − 5 η² t²) u³ / 2)
    Δλ = (v + t u v − t² v³ / 3 + (1 + 3 t² + η²) u² v / 3) / cos φ
    Δα = t v + (1 + 2 t² + η²) u v / 2 − t (1 + 2 t² + η²) v³ / 6 + t (5 + 6 t² + η² − 4 η⁴) u² v / 6

Source: Torge, Müller, Geodesy, 4th edition, section 6.3. Within the limits below they differ from `pyproj` by less than
a micrometre.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

EQUATOR, FLATTENING = 6_378_137.0, 1.0 / 298.257223563  # of WGS84: half the axis in m
POLAR = EQUATOR / (1.0 - FLATTENING)  # m: the radius of curvature at a pole, c
SECOND = 1.0 / (1.0 - FLATTENING) ** 2 - 1.0  # the second eccentricity squared, e'²
BETWEEN, AHEAD = 1e4, 1e3  # m: longer geodesics go to pyproj
NORTHERNMOST = {"between": 80.0, "ahead": 75.0}  # degrees: beyond, they go to pyproj too
BLOCK = 1 << 14  # rows at once: few enough for the processor's cache


@lru_cache(1)
def geod() -> Any:
    """The ellipsoid of `pyproj`."""
    from pyproj import Geod

    return Geod(ellps="WGS84")


def wrapped(degrees: Any) -> Any:
    """Angles from -180 to 180."""
    return (degrees + 180.0) % 360.0 - 180.0


def geodesics_between(
    latitude: np.ndarray, longitude: np.ndarray, to_latitude: np.ndarray, to_longitude: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """East and north parts (m) of geodesics in the meridian of their middle, and by how much it turns on the way (rad).

    All (N,) in degrees. The direction at the start is that of the middle less half of the turn.
    """
    out = np.empty((3, latitude.size))
    for rows in _blocks(latitude.size):
        _between(latitude[rows], longitude[rows], to_latitude[rows], to_longitude[rows], out[:, rows])
    return out[0], out[1], out[2]


def _between(
    latitude: np.ndarray, longitude: np.ndarray, to_latitude: np.ndarray, to_longitude: np.ndarray, out: np.ndarray
) -> None:
    middle = np.radians(0.5 * (latitude + to_latitude))
    dphi, dlam = np.radians(to_latitude - latitude), np.radians(wrapped(to_longitude - longitude))
    sin, cos, t2, eta, v2 = _curvature(middle)
    n = POLAR / np.sqrt(v2)
    square, east, north = (dphi / v2) ** 2, (dlam * cos) ** 2, (dlam * sin) ** 2
    out[0] = n * dlam * cos * (1.0 + (square * (1.0 + eta - 9.0 * eta * t2) - north) / 24.0)
    inner = square * eta * (1.0 - t2 + eta + 4.0 * eta * t2) / 8.0
    out[1] = n * dphi / v2 * (1.0 - east * (2.0 + 3.0 * t2 + 2.0 * eta) / 24.0 + inner)
    inner = square * (3.0 + 8.0 * eta + 5.0 * eta * eta) / 24.0
    out[2] = dlam * sin * (1.0 + (1.0 + eta) * east / 12.0 + inner)
    short = (np.abs(out[0]) + np.abs(out[1]) < BETWEEN) & (np.abs(latitude) < NORTHERNMOST["between"])
    if not short.all():
        far = ~short
        ahead, back, length = geod().inv(longitude[far], latitude[far], to_longitude[far], to_latitude[far])
        turned = np.radians(wrapped(np.asarray(back) + 180.0 - ahead))
        at_middle = np.radians(ahead) + 0.5 * turned
        out[:, far] = length * np.sin(at_middle), length * np.cos(at_middle), turned


def geodesics_ahead(
    latitude: np.ndarray, longitude: np.ndarray, east: np.ndarray, north: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where geodesics end that start with these east and north parts (m): latitude, longitude (degrees), and by how
    much the meridian turns on the way (rad). All (N,).
    """
    out = np.empty((3, latitude.size))
    for rows in _blocks(latitude.size):
        _ahead(latitude[rows], longitude[rows], east[rows], north[rows], out[:, rows])
    return out[0], out[1], out[2]


def _ahead(latitude: np.ndarray, longitude: np.ndarray, east: np.ndarray, north: np.ndarray, out: np.ndarray) -> None:
    short = (np.abs(east) + np.abs(north) < AHEAD) & (np.abs(latitude) < NORTHERNMOST["ahead"])
    sin, cos, t2, eta, v2 = _curvature(np.radians(latitude))
    t, n = sin / cos, POLAR / np.sqrt(v2)
    u, v = north / n, east / n
    uv, uu, vv = u * v, u * u, v * v
    high = uv * v * (1.0 + 3.0 * t2 + eta - 9.0 * eta * t2) / 6.0 + 0.5 * eta * uu * u * (
        1.0 - t2 + eta - 5.0 * eta * t2
    )
    out[0] = latitude + np.degrees(v2 * (u - t * (1.5 * eta * uu + 0.5 * vv) - high))
    out[1] = longitude + np.degrees((v + t * uv + v * (uu * (1.0 + 3.0 * t2 + eta) - t2 * vv) / 3.0) / cos)
    round_about = 1.0 + 2.0 * t2 + eta
    high = uu * (5.0 + 6.0 * t2 + eta - 4.0 * eta * eta) - vv * round_about
    out[2] = t * v + 0.5 * uv * round_about + t * v * high / 6.0
    beyond = np.abs(out[1]) > 180.0
    if beyond.any():
        out[1, beyond] = wrapped(out[1, beyond])
    if not short.all():
        far = ~short
        azimuth = np.degrees(np.arctan2(east[far], north[far]))
        length = np.hypot(east[far], north[far])
        lon, lat, back = geod().fwd(longitude[far], latitude[far], azimuth, length)
        out[:, far] = lat, lon, np.radians(wrapped(np.asarray(back) + 180.0 - azimuth))


def _curvature(latitude: np.ndarray) -> tuple[np.ndarray, ...]:
    """sin φ, cos φ, tan² φ, η² and V² = 1 + η² (φ in rad)."""
    sin, cos = np.sin(latitude), np.cos(latitude)
    square = cos * cos
    eta = SECOND * square
    return sin, cos, sin * sin / np.maximum(square, 1e-30), eta, 1.0 + eta


def _blocks(count: int) -> list[slice]:
    return [slice(k, min(k + BLOCK, count)) for k in range(0, count, BLOCK)]
