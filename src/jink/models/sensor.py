"""Sensors: what is measured, and how uncertain that is.

``sd`` are standard deviations, ``covariance`` a full matrix; either may be overridden row by row when filtering. A
sensor of your own is any object with ``rows`` (components), ``axes``, ``h(x)`` (vectorised over tracks), ``R`` and
optionally ``jacobian(x)`` and ``residual(z, h)``; see :mod:`jink.stepwise`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log, pi
from typing import Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from .._engine import native
from ..checks import (
    Array,
    PerAxis,
    by_hints,
    covariance,
    exactly_one,
    numbers,
    one_of,
    packed,
    per_axis,
    positive,
    whole,
)
from ..frozen import frozen
from .observed import Moving, Observed, from_site, in_axes, to_positions
from .outliers import Outliers

# what the engine takes of a sensor
NativeSensor = native.Sensor
SensorKind, Vertical = native.SensorKind, native.Vertical


def _axes(axes: int) -> int:
    return whole("axes", axes, 1, 3)


def _noise(sd: list[float] | None, matrix: ArrayLike | None, rows: int) -> tuple[bool, list[float]]:
    """(correlated, variances or packed covariance)"""
    if sd is not None:
        return False, [s * s for s in sd]
    full = covariance("covariance", matrix if matrix is not None else [], rows)
    if np.count_nonzero(full - np.diag(np.diag(full))) == 0:
        return False, [float(v) for v in np.diag(full)]
    return True, packed(full)


@frozen(kw_only=True)
class Position(Observed):
    """Cartesian position, z = p + v, v ~ N(0, R); sd (m; one, or one per axis) or covariance (axes by axes).

    Errors: ValueError unless exactly one of sd and covariance is given.
    """

    sd: PerAxis | None = None
    covariance: ArrayLike | None = None
    axes: int = 2
    cartesian: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _axes(self.axes)
        exactly_one("Position", sd=self.sd, covariance=self.covariance)
        self.native()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the columns of z."""
        return tuple("xyz"[: self.axes])

    def native(self, outliers: Outliers | None = None) -> NativeSensor:
        """What the engine runs."""
        sd = None if self.sd is None else per_axis("sd", self.sd, self.axes)
        correlated, noise = _noise(sd, self.covariance, self.axes)
        extent = _extents(outliers, "p" * self.axes)
        return NativeSensor(
            kind=SensorKind.position,
            axes=self.axes,
            rows=self.axes,
            noise=noise,
            correlated=correlated,
            log_extent=extent,
        )

    def observe(self, truth: Moving) -> Array:
        """The position, (..., axes)."""
        return in_axes(truth.position, self.axes).copy()

    def positions(self, z: Array) -> Array:
        """What is measured."""
        return z

    def extents(self, horizontal: float, vertical: float, speed: float) -> tuple[float, ...]:
        """How far apart measurements can lie, by component."""
        return (horizontal, horizontal, vertical)[: self.axes]


@frozen(kw_only=True)
class PositionVelocity(Observed):
    """Cartesian position and velocity (ADS-B, GPS), z = [p…, v…] + noise; sd (m), velocity_sd (m/s), or covariance.

    For AIS speed and course see :meth:`from_speed_course`. Where the velocity is missing it updates with the position
    alone.
    """

    sd: PerAxis | None = None
    velocity_sd: PerAxis | None = None
    covariance: ArrayLike | None = None
    axes: int = 2
    cartesian: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _axes(self.axes)
        exactly_one("PositionVelocity", sd=self.sd, covariance=self.covariance)
        if (self.sd is None) != (self.velocity_sd is None):
            raise ValueError("PositionVelocity: expected both sd and velocity_sd, or neither")
        self.native()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the columns of z."""
        return (*tuple("xyz"[: self.axes]), *(f"v{a}" for a in "xyz"[: self.axes]))

    def native(self, outliers: Outliers | None = None) -> NativeSensor:
        """What the engine runs."""
        sd = None
        if self.sd is not None and self.velocity_sd is not None:
            sd = per_axis("sd", self.sd, self.axes) + per_axis("velocity_sd", self.velocity_sd, self.axes)
        correlated, noise = _noise(sd, self.covariance, 2 * self.axes)
        extent = _extents(outliers, "p" * self.axes + "v" * self.axes)
        return NativeSensor(
            kind=SensorKind.position_velocity,
            axes=self.axes,
            rows=2 * self.axes,
            noise=noise,
            correlated=correlated,
            log_extent=extent,
        )

    def observe(self, truth: Moving) -> Array:
        """Position and velocity, (..., 2 axes)."""
        return np.concatenate([in_axes(truth.position, self.axes), in_axes(truth.velocity, self.axes)], axis=-1)

    def positions(self, z: Array) -> Array:
        """The first half of what is measured."""
        return z[..., : self.axes]

    def velocities(self, z: Array) -> Array | None:
        """The second half of what is measured."""
        return z[..., self.axes :]

    def extents(self, horizontal: float, vertical: float, speed: float) -> tuple[float, ...]:
        """How far apart measurements can lie, by component; velocities of opposite targets differ by twice the
        speed.
        """
        return (*(horizontal, horizontal, vertical)[: self.axes], *(2 * speed,) * self.axes)

    @staticmethod
    @by_hints
    def from_speed_course(
        position: ArrayLike,
        speed: ArrayLike,
        course: ArrayLike,
        *,
        sd: float,
        speed_sd: float,
        course_sd: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """z (N, 4) and covariance (N, 4, 4) from positions (N, 2), speeds (m/s) and courses (rad clockwise from +y).

        The velocity's covariance is that of (speed, course) turned along and across the course:
        along speed_sd², across (speed · course_sd)² + a floor of speed_sd² · course_sd².
        """
        p = np.asarray(position, dtype=float)
        s, c = np.asarray(speed, dtype=float), np.asarray(course, dtype=float)
        if p.ndim != 2 or p.shape[1] != 2 or s.shape != (len(p),) or c.shape != (len(p),):
            raise ValueError(
                f"position: expected (N, 2) with speed and course (N,), got {p.shape}, {s.shape} and {c.shape}"
            )
        along = np.stack([np.sin(c), np.cos(c)], axis=-1)
        across = np.stack([np.cos(c), -np.sin(c)], axis=-1)
        R = np.zeros((len(p), 4, 4))
        R[:, 0, 0] = R[:, 1, 1] = positive("sd", sd) ** 2
        lateral = (s * s + speed_sd**2) * positive("course_sd", course_sd) ** 2 + 1e-12
        R[:, 2:, 2:] = positive("speed_sd", speed_sd) ** 2 * along[:, :, None] * along[:, None, :]
        R[:, 2:, 2:] += lateral[:, None, None] * across[:, :, None] * across[:, None, :]
        missing = ~np.isfinite(s * c)
        R[missing, 2:, 2:] = np.eye(2)
        return np.concatenate([p, s[:, None] * along], axis=1), R


@frozen
class Bearing(Observed):
    """Azimuth (rad) of the target from a site: clockwise from +y (north), or with reference="east" counter-clockwise
    from +x.

    A bearing alone starts no track: give ``initial=jink.Prior(...)`` or a second sensor.
    """

    sd: float
    site: Sequence[float] = (0.0, 0.0)
    axes: int = 2
    reference: Literal["north", "east"] = "north"
    locates: ClassVar[bool] = False

    def __post_init__(self) -> None:
        self.native()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the columns of z."""
        return ("azimuth",)

    def native(self, outliers: Outliers | None = None) -> NativeSensor:
        """What the engine runs."""
        noise = [positive("sd", self.sd) ** 2]
        return NativeSensor(
            kind=SensorKind.bearing,
            axes=_plane("Bearing", self.axes),
            rows=1,
            noise=noise,
            log_extent=_extents(outliers, "a"),
            from_north=_reference(self.reference),
            site=_site(self.site),
        )

    def observe(self, truth: Moving) -> Array:
        """The azimuth, (..., 1)."""
        return from_site(truth, self.components, self.axes, self.site, self.reference)

    def extents(self, horizontal: float, vertical: float, speed: float) -> tuple[float, ...]:
        """The azimuth can differ by a full circle."""
        return (2 * pi,)


@frozen(kw_only=True)
class Polar(Observed):
    """Radar: range (m), azimuth (rad), optionally elevation (rad) or height (m), optionally range rate (m/s), from a
    site.

    Columns of z in that order. Azimuth is clockwise from +y (north), or with reference="east" counter-clockwise from
    +x. With a height the range is a slant range. Heights are above the plane z = 0, or with ``earth_radius`` R (m)
    above a sphere that touches this plane at the origin: h = sqrt(x² + y² + (R + z)²) − R.

    method="ekf" linearises at the prediction (or ``linearisation="ukf"`` of the filter); method="converted" turns each
    measurement into an unbiased Cartesian one with its own covariance (Longbin, Xiaoquan, Yizu, Kang & Bar-Shalom, IEEE
    Trans. AES-34(3), 1998), without the range rate.
    """

    range_sd: float
    azimuth_sd: float
    elevation_sd: float | None = None
    height_sd: float | None = None
    range_rate_sd: float | None = None
    site: Sequence[float] = (0.0, 0.0, 0.0)
    earth_radius: float | None = None
    axes: int | None = None
    method: Literal["ekf", "converted"] = "ekf"
    reference: Literal["north", "east"] = "north"

    def __post_init__(self) -> None:
        if self.elevation_sd is not None and self.height_sd is not None:
            raise ValueError("Polar: give elevation_sd or height_sd, not both")
        if self.earth_radius is not None and self.height_sd is None:
            raise ValueError("Polar: earth_radius bends the height; expected height_sd with it")
        spatial = self.elevation_sd is not None or self.height_sd is not None
        if self.axes is None:
            object.__setattr__(self, "axes", 3 if spatial else 2)
        if self.axes == 2 and spatial:
            raise ValueError("Polar: elevation_sd and height_sd need a vertical axis; expected axes=3, got axes=2")
        one_of("method", self.method, ("ekf", "converted"))
        if self.method == "converted" and self.range_rate_sd is not None:
            raise ValueError("Polar: method='converted' cannot use a range rate; expected method='ekf'")
        if self.method == "converted" and self.axes == 3 and not spatial:
            raise ValueError("Polar: method='converted' in 3 axes needs elevation_sd or height_sd")
        self.native()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the columns of z."""
        names = ["range", "azimuth"]
        names += ["elevation"] if self.elevation_sd is not None else ["height"] if self.height_sd is not None else []
        return (*names, "range_rate") if self.range_rate_sd is not None else tuple(names)

    def native(self, outliers: Outliers | None = None) -> NativeSensor:
        """What the engine runs."""
        sds = {"range": self.range_sd, "azimuth": self.azimuth_sd, "elevation": self.elevation_sd}
        sds |= {"height": self.height_sd, "range_rate": self.range_rate_sd}
        noise = [positive(f"{name}_sd", 0.0 if sds[name] is None else sds[name]) ** 2 for name in self.components]  # pyright: ignore[reportArgumentType]
        kinds = {"range": "p", "height": "p", "azimuth": "a", "elevation": "a", "range_rate": "v"}
        converted = self.method == "converted"
        axes = _plane("Polar", self.axes or 2)
        extent = _extents(outliers, "p" * axes if converted else "".join(kinds[c] for c in self.components))
        return NativeSensor(
            kind=SensorKind.polar,
            axes=axes,
            rows=len(noise),
            noise=noise,
            log_extent=extent,
            vertical=self._vertical,
            range_rate=self.range_rate_sd is not None,
            from_north=_reference(self.reference),
            converted=converted,
            site=_site(self.site),
            radius=positive("earth_radius", self.earth_radius) if self.earth_radius is not None else 0.0,
        )

    @property
    def _vertical(self) -> Vertical:  # pyright: ignore[reportInvalidTypeForm]
        if self.elevation_sd is not None:
            return Vertical.elevation
        return Vertical.none if self.height_sd is None else Vertical.height

    def observe(self, truth: Moving) -> Array:
        """The components, (..., m)."""
        return from_site(truth, self.components, self.axes or 2, self.site, self.reference, self.earth_radius)

    def positions(self, z: Array) -> Array:
        """In three axes where there is an elevation or a height; without, ranges are taken as those along the
        ground.
        """
        return to_positions(z, self.components, self.site, self.reference, self.earth_radius)

    def extents(self, horizontal: float, vertical: float, speed: float) -> tuple[float, ...]:
        """How far apart measurements can lie, by component; converted ones are positions."""
        if self.method == "converted":
            return (horizontal, horizontal, vertical)[: self.axes]
        whole = {
            "range": horizontal,
            "azimuth": 2 * pi,
            "elevation": 2 * pi,
            "height": vertical,
            "range_rate": 2 * speed,
        }
        return tuple(whole[name] for name in self.components)


def _reference(reference: str) -> bool:
    return one_of("reference", reference, ("north", "east")) == "north"


def _plane(owner: str, axes: int) -> int:
    return whole(f"{owner}: axes", axes, 2, 3)


def _site(site: Sequence[float]) -> list[float]:
    values = numbers("site", site, "coordinates in metres").reshape(-1).tolist()
    if len(values) not in (2, 3) or not np.all(np.isfinite(values)):
        raise ValueError(f"site: expected 2 or 3 coordinates in metres, got {site!r}")
    return values + [0.0] * (3 - len(values))


def _extents(outliers: Outliers | None, kinds: str) -> list[float]:
    """Logarithm of each component's uniform extent; kinds p position, v velocity, a angle."""
    if outliers is None:
        return [0.0] * len(kinds)
    if isinstance(outliers.extent, Sequence):
        if len(outliers.extent) != len(kinds):
            raise ValueError(
                f"Outliers.extent: expected one number or {len(kinds)} of them, got {len(outliers.extent)}"
            )
        return [log(positive("Outliers.extent", e)) for e in outliers.extent]
    each = {"p": log(outliers.extent), "v": log(outliers.velocity_extent), "a": log(2 * pi)}
    return [each[kind] for kind in kinds]


class OwnSensor(Protocol):
    """The least that a user's own sensor must have; :mod:`jink.stepwise` says what more it can have."""

    R: Any

    def h(self, x: Any) -> Any:
        """What is measured of the states x (B, n), (B, m)."""
        ...


Sensor = Position | PositionVelocity | Bearing | Polar
AnySensor = Sensor | OwnSensor  # what a filter takes

SENSORS: dict[str, type] = {s.__name__: s for s in (Position, PositionVelocity, Bearing, Polar)}
