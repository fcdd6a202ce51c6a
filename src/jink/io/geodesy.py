"""Frames of reference: the earth's surface laid flat along a track, and the tangent plane of a site.

**Developed frame.** Consecutive positions are joined by geodesics of the WGS84 ellipsoid (`pyproj.Geod`); the
legs are laid into a plane one after the other, each turned by the angle between it and the one before. This
is the development of the path by parallel transport: distances along the path and turns are exact, a great
circle becomes a straight line, and nothing happens at a pole, at the date line or after ten thousand
kilometres. The axes point east and north at the first position; further on, true north is turned against them
by the accumulated convergence γ of the meridians, kept per row:

    true course = course in the frame + γ

An estimate goes back to latitude and longitude by one geodesic from the position of its own row (a few
metres, not thousands of kilometres), so the way there and back is exact to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .short_geodesics import EQUATOR, FLATTENING, geod, geodesics_ahead, geodesics_between, wrapped

ECCENTRICITY2 = FLATTENING * (2.0 - FLATTENING)  # of WGS84: eccentricity squared
EXCURSION = 1e5  # m: a lone position this far out and back hangs beside the chain of legs instead of carrying it


@dataclass(frozen=True)
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
        east, north = x - self.anchor_x, y - self.anchor_y
        return _ahead(self.anchor_latitude, self.anchor_longitude, self.anchor_convergence, east, north)


@dataclass(frozen=True)
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
        here = np.full(x.shape, self.latitude), np.full(x.shape, self.longitude)
        if z is None:
            return *_ahead(*here, np.zeros(x.shape), x, y), None
        latitude, longitude, altitude = self._from_space(x, y, z)
        good = np.isfinite(latitude)
        convergence = np.full(x.shape, np.nan)
        ahead, back, _ = geod().inv(here[1][good], here[0][good], longitude[good], latitude[good])
        convergence[good] = np.radians(wrapped(np.asarray(back) + 180.0 - ahead))
        return latitude, longitude, convergence, altitude

    def _from_space(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        from pyproj import Transformer

        to_space = Transformer.from_pipeline("+proj=cart +ellps=WGS84")
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


def develop(latitude: np.ndarray, longitude: np.ndarray, first: np.ndarray) -> DevelopedFrame:
    """Lay tracks into the plane, each from (0, 0) at its first known position.

    latitude, longitude (N,) degrees, NaN: none; first (N,) bool marks the first row of each track, which has
    to be known.
    """
    count = latitude.size
    known = np.flatnonzero(np.isfinite(latitude) & np.isfinite(longitude))
    start = np.zeros(count, bool)  # the first known position of each track
    track = np.cumsum(first) - 1
    start[known[np.r_[True, np.diff(track[known]) > 0]] if known.size else known] = True
    chain = known[~_excursions(latitude[known], longitude[known], start[known])]
    x, y, convergence = np.zeros(count), np.zeros(count), np.zeros(count)
    x[chain], y[chain], convergence[chain] = _lay(latitude[chain], longitude[chain], start[chain])
    link = np.full(count, -1)
    link[chain] = chain
    anchor = np.maximum.accumulate(link) if count else link
    beside = np.setdiff1d(known, chain, assume_unique=True)
    if beside.size:
        ahead, _, length = geod().inv(
            longitude[anchor[beside]], latitude[anchor[beside]], longitude[beside], latitude[beside]
        )
        course = np.radians(ahead) - convergence[anchor[beside]]
        x[beside] = x[anchor[beside]] + length * np.sin(course)
        y[beside] = y[anchor[beside]] + length * np.cos(course)
    unknown = np.ones(count, bool)
    unknown[known] = False
    anchored = x[anchor], y[anchor], latitude[anchor], longitude[anchor], convergence[anchor]
    return DevelopedFrame(np.where(unknown, np.nan, x), np.where(unknown, np.nan, y), *anchored)


def legs(
    start: Sequence[tuple[float, float]], end: Sequence[tuple[float, float]]
) -> tuple[list[float], list[float], list[float]]:
    """Geodesics between places (latitude, longitude): their directions from north at the start (rad), by how much
    the meridian turns against them on the way (rad), and lengths (m).
    """
    one, other = np.array(start), np.array(end)
    ahead, back, length = geod().inv(one[:, 1], one[:, 0], other[:, 1], other[:, 0])
    turned = np.radians(wrapped(back + 180.0 - ahead))
    return np.radians(ahead).tolist(), turned.tolist(), np.asarray(length).tolist()


def lines_of_sight(
    site: SiteFrame, latitude: np.ndarray, longitude: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From a site to places: length along the ground (m), direction from north at the site, and at the place (rad)."""
    out = np.full((3, latitude.size), np.nan)
    good = np.isfinite(latitude) & np.isfinite(longitude)
    here = np.full(good.sum(), site.longitude), np.full(good.sum(), site.latitude)
    ahead, back, length = geod().inv(*here, longitude[good], latitude[good])
    out[:, good] = length, np.radians(ahead), np.radians(np.asarray(back) + 180.0)
    return out[0], out[1], out[2]


def _excursions(latitude: np.ndarray, longitude: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Lone positions far out and back: such a leg, laid into the chain, would bend what follows."""
    away = np.zeros(latitude.size, bool)
    inner = np.flatnonzero(~start[1:-1] & ~start[2:]) + 1
    if not inner.size:
        return away
    rough = np.hypot(np.diff(latitude), wrapped(np.diff(longitude)) * np.cos(np.radians(latitude[1:]))) * 111_000.0
    inner = inner[(rough[inner - 1] > EXCURSION) & (rough[inner] > EXCURSION)]
    if not inner.size:
        return away
    legs = [
        geod().inv(longitude[a], latitude[a], longitude[b], latitude[b])[2]
        for a, b in ((inner - 1, inner), (inner, inner + 1), (inner - 1, inner + 1))
    ]
    away[inner[legs[2] < 0.1 * np.minimum(legs[0], legs[1])]] = True
    away[1:] &= ~away[:-1]
    return away


def _lay(latitude: np.ndarray, longitude: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions and convergence of chained legs; each track starts from (0, 0), axes east and north."""
    if latitude.size < 2:
        return np.zeros(latitude.size), np.zeros(latitude.size), np.zeros(latitude.size)
    again = start[1:]
    # a track's first leg goes nowhere
    latitude_before = np.where(again, latitude[1:], latitude[:-1])
    longitude_before = np.where(again, longitude[1:], longitude[:-1])
    east, north, turned = geodesics_between(latitude_before, longitude_before, latitude[1:], longitude[1:])
    convergence = _running(np.r_[0.0, turned], start)
    turn = convergence[:-1] + 0.5 * turned
    sin, cos = np.sin(turn), np.cos(turn)
    x = _running(np.r_[0.0, east * cos - north * sin], start)
    y = _running(np.r_[0.0, east * sin + north * cos], start)
    return x, y, convergence


def _running(steps: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Cumulative sums that begin again at every start, where the step is 0."""
    begins = np.flatnonzero(start)
    total = np.empty_like(steps)
    # one sum for all would round a track by what the tracks before it have
    for low, high in zip(begins.tolist(), [*begins[1:].tolist(), steps.size], strict=True):
        np.cumsum(steps[low:high], out=total[low:high])
    return total


def _ahead(
    latitude: np.ndarray, longitude: np.ndarray, convergence: np.ndarray, east: np.ndarray, north: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Follow geodesics by their components in a turned frame: latitude, longitude, convergence there."""
    good = np.isfinite(east) & np.isfinite(north) & np.isfinite(latitude)
    turned, right, up = convergence[good], east[good], north[good]
    sin, cos = np.sin(turned), np.cos(turned)
    out = np.full((3, latitude.size), np.nan)
    way = right * cos + up * sin, up * cos - right * sin
    out[0, good], out[1, good], more = geodesics_ahead(latitude[good], longitude[good], *way)
    out[2, good] = turned + more
    return out[0], out[1], out[2]
