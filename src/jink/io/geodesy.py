"""Frames of reference: the earth's surface laid flat along a track, and the tangent plane of a site.

**Developed frame.** Consecutive positions are joined by geodesics of the WGS84 ellipsoid; the legs are laid into
a plane one after the other, each turned by the angle between it and the one before. This is the development of
the path by parallel transport: distances along the path and turns are exact, a great circle becomes a straight
line, and nothing happens at a pole, at the date line or after ten thousand kilometres. The axes point east and
north at the first position; further on, true north is turned against them by the accumulated convergence γ of
the meridians, kept per row:

    true course = course in the frame + γ

An estimate goes back to latitude and longitude by one geodesic from the position of its own row (a few
metres, not thousands of kilometres), so the way there and back is exact to rounding.

The engine (`core/models/geodesic.hpp`) finds geodesics to 0.1 µm at any latitude: ahead of a place up to 40,000 km,
between places up to 12,000 km. Between places further apart, `pyproj.Geod` finds them (Karney 2013).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from .._engine import native
from ..frozen import frozen

EQUATOR, FLATTENING = native.earth_equator, native.earth_flattening  # of WGS84: half the axis in m
ECCENTRICITY2 = FLATTENING * (2.0 - FLATTENING)  # eccentricity squared
LONG = 1.2e7  # m: from here on `pyproj` finds geodesics between places
EXCURSION = 1e5  # m: a lone position this far out and back hangs beside the chain of legs instead of carrying it


@frozen
class DevelopedFrame:
    """Positions in the plane, (N,) each in metres; NaN where none was measured.

    The anchor of a row is the position its estimate is measured from: its own, or the last known one.
    """

    x: np.ndarray
    y: np.ndarray
    anchor_x: np.ndarray
    anchor_y: np.ndarray
    anchor_latitude: np.ndarray
    anchor_longitude: np.ndarray
    anchor_convergence: np.ndarray  # rad

    def rows(self, which: slice | np.ndarray) -> DevelopedFrame:
        """The frame of some rows."""
        return DevelopedFrame(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def to_geographic(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Latitude, longitude (degrees) and convergence γ (rad) of positions in the plane, row by row."""
        place = self.anchor_latitude, self.anchor_longitude, self.anchor_convergence
        latitude, longitude, convergence = native.geodesics_ahead(x, y, self.anchor_x, self.anchor_y, *place)
        return latitude, longitude, convergence


@frozen
class SiteFrame:
    """East, north and up at a site: latitude, longitude in degrees, altitude in metres (ellipsoid)."""

    latitude: float
    longitude: float
    altitude: float = 0.0

    @property
    def earth_radius(self) -> float:
        """Radius (m) of the sphere that fits the surface of the site's altitude: √(MN) and that altitude."""
        squared = EQUATOR**2 * (1.0 - ECCENTRICITY2)
        return float(np.sqrt(squared) / (1.0 - ECCENTRICITY2 * np.sin(np.radians(self.latitude)) ** 2)) + self.altitude

    def to_geographic(
        self, x: np.ndarray, y: np.ndarray, z: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
        """Latitude, longitude (degrees), convergence (rad) and altitude (m) of points in the site's frame.

        With `z` the point is taken where it is in space (east, north, up: a straight line of sight); without
        it, x and y are a distance and a direction along the ground.
        """
        if z is None:
            zero = np.broadcast_to(0.0, x.shape)
            latitude, longitude, convergence = native.geodesics_ahead(x, y, zero, zero, *self.beside(x), zero)
            return latitude, longitude, convergence, None
        latitude, longitude, altitude = self.from_space(x, y, z)
        return latitude, longitude, geodesics_between(*self.beside(x), latitude, longitude)[1], altitude

    def beside(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Latitude and longitude of the site, once for each row."""
        return np.broadcast_to(self.latitude, rows.shape), np.broadcast_to(self.longitude, rows.shape)

    def from_space(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Latitude, longitude (degrees) and altitude (m) of points (N,) in space, east, north and up."""
        to_space = _to_space()
        phi, lam = np.radians(self.latitude), np.radians(self.longitude)
        site = to_space.transform(self.longitude, self.latitude, self.altitude)
        sin, cos = np.sin, np.cos
        space = [
            site[0] - sin(lam) * x - sin(phi) * cos(lam) * y + cos(phi) * cos(lam) * z,
            site[1] + cos(lam) * x - sin(phi) * sin(lam) * y + cos(phi) * sin(lam) * z,
            site[2] + cos(phi) * y + sin(phi) * z,
        ]
        good = np.isfinite(space[0] + space[1] + space[2])
        out = np.full((3, x.size), np.nan)
        out[:, good] = to_space.transform(*(component[good] for component in space), direction="INVERSE")
        return out[1], out[0], out[2]


@cache
def _to_space() -> Any:
    """What turns longitude, latitude and altitude (degrees, m) into places in space (m from the earth's centre)."""
    from pyproj import Transformer

    return Transformer.from_pipeline("+proj=cart +ellps=WGS84")


def develop(latitude: np.ndarray, longitude: np.ndarray, first: np.ndarray) -> DevelopedFrame:
    """Lay tracks into the plane, each from (0, 0) at its first known position.

    latitude, longitude (N,) degrees, NaN: none; first (N,) bool marks the first row of each track, which has
    to be known.
    """
    table, far = native.legs(latitude, longitude, first, EXCURSION)
    before, beside = _excursions(latitude, longitude, far)
    chained = latitude
    if beside.size:
        chained = latitude.copy()
        chained[beside] = np.nan
        table, far = native.legs(chained, longitude, first, EXCURSION)
    start, turned, length = _joining(latitude, longitude, far[:, 0], far[:, 1])
    middle = start + 0.5 * turned
    table[:3, far[:, 1]] = length * np.sin(middle), length * np.cos(middle), turned
    native.laid(chained, longitude, first, table)
    frame = DevelopedFrame(*table)
    start, _, length = _joining(latitude, longitude, before, beside)
    course = start - frame.anchor_convergence[before]
    frame.x[beside] = frame.x[before] + length * np.sin(course)
    frame.y[beside] = frame.y[before] + length * np.cos(course)
    return frame


def legs(
    start: Sequence[tuple[float, float]], end: Sequence[tuple[float, float]]
) -> tuple[list[float], list[float], list[float]]:
    """Geodesics between places (latitude, longitude): their directions from north at the start (rad), by how much
    the meridian turns against them on the way (rad), and lengths (m).
    """
    (latitude, longitude), (to_latitude, to_longitude) = np.array(start, float).T, np.array(end, float).T
    directions, turns, lengths = geodesics_between(latitude, longitude, to_latitude, to_longitude).tolist()
    return directions, turns, lengths


def lines_of_sight(
    site: SiteFrame, latitude: np.ndarray, longitude: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From a site to places: length along the ground (m), direction from north at the site, and at the place (rad)."""
    start, turned, length = geodesics_between(*site.beside(latitude), latitude, longitude)
    return length, start, start + turned


def geodesics_between(
    latitude: np.ndarray, longitude: np.ndarray, to_latitude: np.ndarray, to_longitude: np.ndarray
) -> np.ndarray:
    """Directions from north at the start, turns of the meridian on the way (rad) and lengths (m) of geodesics: (3, N).

    All places (N,) in degrees.
    """
    found = native.geodesics_between(latitude, longitude, to_latitude, to_longitude)
    long = np.flatnonzero(found[2] > LONG)
    if long.size:
        from pyproj import Geod

        ends = longitude[long], latitude[long], to_longitude[long], to_latitude[long]
        ahead, back, length = (np.asarray(part) for part in Geod(ellps="WGS84").inv(*ends))
        found[:, long] = np.radians(ahead), np.radians((back - ahead) % 360.0 - 180.0), length
    return found


def _joining(latitude: np.ndarray, longitude: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The geodesics between rows (K,) and rows (K,)."""
    return geodesics_between(latitude[one], longitude[one], latitude[other], longitude[other])


def _excursions(latitude: np.ndarray, longitude: np.ndarray, far: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of long legs (K, 2) from row to row the lone positions far out and back, and the rows before them: such a leg,
    laid into the chain, would bend what follows.
    """
    out = np.flatnonzero(far[:-1, 1] == far[1:, 0])
    before, away, after = far[out, 0], far[out, 1], far[out + 1, 1]
    ends = (before, away), (away, after), (before, after)
    there, back, across = (_joining(latitude, longitude, one, other)[2] for one, other in ends)
    lone = across < 0.1 * np.minimum(there, back)
    lone &= ~np.isin(before, away[lone])
    return before[lone], away[lone]
