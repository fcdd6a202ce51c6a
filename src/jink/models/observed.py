"""What can be asked of every sensor, and the geometry of those that look from a site."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Protocol

import numpy as np

from ..checks import Array


class Moving(Protocol):
    """Position (m) and velocity (m/s), (..., axes) each."""

    @property
    def position(self) -> Array: ...

    @property
    def velocity(self) -> Array: ...


class Observed:
    """Answers for a sensor that has ``components``, ``axes`` and ``native``; a sensor replaces what is different with
    it.

    cartesian: it measures positions and velocities in metres, so that its noise is the same everywhere; locates: one
    measurement tells a position.
    """

    cartesian: ClassVar[bool] = False
    locates: ClassVar[bool] = True

    @property
    def noise(self) -> Array:
        """Covariance (m, m) of a measurement."""
        native = self.native()  # type: ignore[attr-defined]
        if not native.correlated:
            return np.diag(np.array(native.noise))
        lower = np.zeros((native.rows, native.rows))
        lower[np.tril_indices(native.rows)] = native.noise
        return lower + np.tril(lower, -1).T

    @property
    def position_only(self) -> bool:
        """Is z the position itself, each axis for itself?"""
        return self.cartesian and len(self.components) == self.axes  # type: ignore[attr-defined]

    def observe(self, truth: Moving) -> Array:
        """h of the truth without noise, (..., m); at height 0 where it has none, without the height that no component
        is of.
        """
        raise NotImplementedError

    def positions(self, z: Array) -> Array:
        """Measurements (..., m) as positions (..., axes) in m. Errors: ValueError where one measurement tells none."""
        raise ValueError(f"{type(self).__name__} does not measure positions")

    def velocities(self, z: Array) -> Array | None:
        """Measurements (..., m) as velocities (..., axes) in m/s, None where they are none."""
        return None

    def extents(self, horizontal: float, vertical: float, speed: float) -> tuple[float, ...]:
        """How far apart measurements of targets can lie, by component, where these lie within so many m and are no
        faster (m/s).
        """
        raise NotImplementedError


def in_axes(values: Array, axes: int) -> Array:
    """(..., axes) of vectors: cut, or filled up with zeros."""
    missing = axes - values.shape[-1]
    if missing <= 0:
        return values[..., :axes]
    return np.concatenate([values, np.zeros((*values.shape[:-1], missing))], -1)


def height_above(p: Array, radius: float | None) -> Array:
    """Height (...,) of points (..., 3) over a sphere that touches z = 0 at the origin; None: over z = 0."""
    x, y, z = p[..., 0], p[..., 1], p[..., 2]
    if radius is None:
        return z
    excess = x * x + y * y + z * (z + 2.0 * radius)
    return excess / (np.sqrt(excess + radius * radius) + radius)


def _below_height(x: Array, y: Array, height: Array, radius: float) -> Array:
    """The way back: z of points at x, y that are so high over the sphere."""
    excess = height * (height + 2.0 * radius) - x * x - y * y
    return excess / (np.sqrt(np.maximum(excess + radius * radius, 0.0)) + radius)


def from_site(
    truth: Moving,
    components: Sequence[str],
    axes: int,
    site: Sequence[float],
    reference: str,
    radius: float | None = None,
) -> Array:
    """Range, azimuth, elevation, height or range rate of a truth, as named, seen from a site."""
    p, v = in_axes(truth.position, axes), in_axes(truth.velocity, axes)
    origin = np.zeros(axes)
    origin[: min(len(site), axes)] = list(site)[:axes]
    d = p - origin
    distance, ground = np.linalg.norm(d, axis=-1), np.hypot(d[..., 0], d[..., 1])
    values: dict[str, Any] = {
        "range": distance,
        "azimuth": np.arctan2(d[..., 0], d[..., 1]) if reference == "north" else np.arctan2(d[..., 1], d[..., 0]),
        "range_rate": (d * v).sum(axis=-1) / np.maximum(distance, 1e-9),
    }
    if axes == 3:
        values |= {"elevation": np.arctan2(d[..., 2], ground), "height": height_above(p, radius)}
    return np.stack([values[name] for name in components], axis=-1)


def to_positions(
    z: Array, components: Sequence[str], site: Sequence[float], reference: str, radius: float | None = None
) -> Array:
    """The way back: positions (..., axes) of range, azimuth and, if it is there, elevation or height."""
    x, y, up = [*map(float, site), 0.0][:3]
    columns = dict(zip(components, np.moveaxis(z, -1, 0), strict=True))
    first, second = np.cos(columns["azimuth"]), np.sin(columns["azimuth"])
    if reference == "north":
        first, second = second, first
    distance = columns["range"]
    ground, height = distance, None
    if "elevation" in columns:
        ground, height = distance * np.cos(columns["elevation"]), distance * np.sin(columns["elevation"])
    elif "height" in columns:
        height = columns["height"] - up
        # each step is (range / radius)² closer
        for _ in range(4 if radius else 0):
            ground = np.sqrt(np.maximum(distance**2 - height**2, 0.0))
            height = _below_height(x + ground * first, y + ground * second, columns["height"], radius or 0.0) - up
        ground = np.sqrt(np.maximum(distance**2 - height**2, 0.0))
    parts = [x + ground * first, y + ground * second]
    return np.stack(parts if height is None else [*parts, up + height], axis=-1)
