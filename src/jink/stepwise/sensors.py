"""Sensors as the stepwise filters see them: a residual and a linearisation over a batch of tracks."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from typing import Any, Protocol

import numpy as np

from .._engine import native
from ..checks import covariance, positive
from ..models.outliers import Outliers
from ..models.sensor import SensorKind
from .components import Seen, union
from .functions import Array, ModelError, call, checked, jacobian_by_differences, regression
from .modes import Mode


@dataclass
class Fix:
    """Positions to start tracks from: which rows have one, or a velocity; p, v (B, axes), their P, V."""

    position: Array
    velocity: Array
    p: Array
    v: Array
    P: Array
    V: Array

    def take(self, rows: Any) -> "Fix":
        """Some rows."""
        return Fix(*(a[rows] for a in (self.position, self.velocity, self.p, self.v, self.P, self.V)))


class Look(Protocol):
    """What jink's sensors and one's own have in common; h and its Jacobian are of states in ``state``."""

    owner: str
    rows: int
    R: Array
    log_extent: Array
    state: tuple[str, ...]
    needs: tuple[str, ...]
    linear: bool
    starts: bool

    def h(self, X: Array) -> Array:
        """What is measured of states X (B, k)."""
        ...

    def jacobian(self, X: Array) -> Array | None:
        """dh/dX (B, m, k), or None if there is none."""
        ...

    def residual(self, z: Array, h: Array) -> Array:
        """z − h, angles to the nearest turn."""
        ...

    def convert(self, z: Array, R: Array, present: Array) -> tuple[Array, Array, Array]:
        """The measurement as h sees it."""
        ...

    def fix(self, z: Array, R: Array, present: Array) -> Fix:
        """The position a track may start from."""
        ...


class LibrarySensor:
    """One of jink's sensors, run by the engine."""

    def __init__(self, sensor: Any, outliers: Outliers | None) -> None:
        self.owner = type(sensor).__name__
        n = self._native = sensor.native(outliers)
        self.axes, self.rows, self._converted = n.axes, n.rows, n.converted
        # what is converted is seen as a position
        position = native.Sensor(kind=SensorKind.position, axes=n.axes, rows=n.axes, noise=[], log_extent=[])
        self._seen = position if n.converted else n
        self.state = tuple(f"{c}{axis}" for axis in "xyz"[: self.axes] for c in "pv")
        self.linear = n.kind in (SensorKind.position, SensorKind.position_velocity) or n.converted
        needs_velocity = n.range_rate or n.kind == SensorKind.position_velocity
        self.needs = self.state if needs_velocity else self.state[::2]
        located = n.kind == SensorKind.polar and (self.axes == 2 or n.vertical != native.Vertical.none)
        self.starts = n.kind in (SensorKind.position, SensorKind.position_velocity) or located
        self.R = np.zeros((self.rows, self.rows))
        if n.correlated:
            lower = np.tril_indices(self.rows)
            self.R[lower] = self.R.T[lower] = n.noise
        else:
            np.fill_diagonal(self.R, n.noise)
        self.log_extent = np.array(n.log_extent)
        angles = {"azimuth", "elevation"} if not n.converted else set()
        self._angles = [r for r, name in enumerate(sensor.components) if name in angles]

    def h(self, X: Array) -> Array:
        """As :class:`Look`."""
        return native.observe_sensor(self._seen, X)[0]

    def jacobian(self, X: Array) -> Array:
        """As :class:`Look`."""
        return native.observe_sensor(self._seen, X)[1]

    def residual(self, z: Array, h: Array) -> Array:
        """As :class:`Look`."""
        y = z - h
        for r in self._angles:
            y[:, r] -= 2 * np.pi * np.rint(y[:, r] / (2 * np.pi))
        return y

    def convert(self, z: Array, R: Array, present: Array) -> tuple[Array, Array, Array]:
        """As :class:`Look`."""
        if not self._converted:
            return z, R, present
        fix = self.fix(z, R, present)
        return fix.p, fix.P, np.tile(fix.position[:, None], (1, self.axes))

    def fix(self, z: Array, R: Array, present: Array) -> Fix:
        """As :class:`Look`."""
        position, velocity, *rest = native.position_of(self._native, z, R, present)
        return Fix(position > 0, velocity > 0, *rest)


class OwnSensor:
    """A sensor of the user's own: h(x), R; optionally rows, jacobian, residual, position, state, extent.

    Without ``position`` it cannot start a track: that takes a :class:`jink.Prior` or another sensor.
    """

    linear = False

    def __init__(self, sensor: Any, modes: Sequence[Mode], axes: int, outliers: Outliers | None) -> None:
        self.owner, self._sensor, self._axes = type(sensor).__name__, sensor, axes
        self.starts: bool = callable(getattr(sensor, "position", None))
        try:
            R = np.asarray(sensor.R, dtype=float)
        except (AttributeError, TypeError, ValueError):
            R = np.zeros(())
        if R.ndim not in (1, 2):
            raise ValueError(f"{self.owner}.R: expected variances (m,) or a covariance (m, m)")
        self.rows = int(getattr(sensor, "rows", len(R)))
        self.R = covariance(f"{self.owner}.R", R if R.ndim == 2 else np.diag(R), self.rows)
        self.state = self.needs = self._state(modes)
        self.log_extent = self._extent(outliers)

    def _state(self, modes: Sequence[Mode]) -> tuple[str, ...]:
        given = getattr(self._sensor, "state", None)
        if given is not None:
            return tuple(given)
        if len({mode.components for mode in modes}) > 1:
            raise ValueError(
                f"{self.owner}: the modes have different states ({', '.join(union(modes))} together); "
                'name the components that h(x) takes in an attribute state, such as ("px", "vx", "py", "vy")'
            )
        return modes[0].components

    def _extent(self, outliers: Outliers | None) -> Array:
        if outliers is None:
            return np.zeros(self.rows)
        extent = getattr(self._sensor, "extent", outliers.extent)
        if np.shape(extent) != (self.rows,):
            raise ValueError(
                f"{self.owner}.extent: expected {self.rows} numbers because the filter has outliers: "
                "how far each component may lie"
            )
        return np.array([log(positive(f"{self.owner}.extent", e)) for e in np.atleast_1d(extent)])

    def h(self, X: Array) -> Array:
        """As :class:`Look`."""
        name = f"{self.owner}.h"
        value = call(name, self._sensor.h, X.copy())
        if self.rows == 1 and np.shape(value) == (len(X),):
            value = np.asarray(value)[:, None]
        return checked(name, value, (len(X), self.rows), f"x {X.shape}")

    def jacobian(self, X: Array) -> Array | None:
        """As :class:`Look`."""
        function = getattr(self._sensor, "jacobian", None)
        if function is None:
            return None
        name, shape = f"{self.owner}.jacobian", (len(X), self.rows, X.shape[1])
        value = np.asarray(call(name, function, X.copy()), dtype=float)
        return checked(
            name, np.broadcast_to(value, shape) if value.shape == shape[1:] else value, shape, f"x {X.shape}"
        )

    def residual(self, z: Array, h: Array) -> Array:
        """As :class:`Look`."""
        function = getattr(self._sensor, "residual", None)
        if function is None:
            return z - h
        name = f"{self.owner}.residual"
        return checked(name, call(name, function, z.copy(), h.copy()), z.shape, f"z and h {z.shape}")

    def convert(self, z: Array, R: Array, present: Array) -> tuple[Array, Array, Array]:
        """As :class:`Look`."""
        return z, R, present

    def fix(self, z: Array, R: Array, present: Array) -> Fix:
        """As :class:`Look`: where every component is present, if the sensor has ``position``."""
        tracks, axes, name = len(z), self._axes, f"{self.owner}.position"
        found = np.asarray(present.all(axis=1) & self.starts)
        p, P = np.zeros((tracks, axes)), np.zeros((tracks, axes, axes))
        rows = np.flatnonzero(found)
        if len(rows):
            value = call(name, self._sensor.position, z[rows], R[rows])
            if not isinstance(value, tuple) or len(value) != 2:
                raise ModelError(f"{name}: expected a position and its covariance, got {type(value).__name__}")
            p[rows] = checked(name, value[0], (len(rows), axes), f"z {z[rows].shape}")
            P[rows] = checked(name, value[1], (len(rows), axes, axes), f"z {z[rows].shape}")
        return Fix(
            found,
            np.zeros(tracks, dtype=bool),
            p,
            np.zeros((tracks, axes)),
            P,
            np.zeros((tracks, axes, axes)),
        )


class View:
    """One mode as one sensor sees it."""

    def __init__(self, look: Look, mode: Mode, unscented: bool) -> None:
        self._look, self._unscented = look, unscented and not look.linear
        self._seen = Seen(mode, look.state)
        for k in self._seen.unknown:
            if look.state[k] in look.needs:
                raise ValueError(
                    f"{look.owner}: the measurement depends on {look.state[k]}; expected it among the components of "
                    f"{mode.owner}, which are {', '.join(mode.components)}"
                )

    def linearise(
        self, x: Array, P: Array, z: Array, present: Array, unscented: bool = True
    ) -> tuple[Array, Array, Array]:
        """Residual y (B, m), H (B, m, n) and what to add to R (B, m, m); zero where nothing is present."""
        tracks, n = x.shape
        rows = np.flatnonzero(present.any(axis=1))
        y, H = np.zeros(z.shape), np.zeros((tracks, z.shape[1], n))
        added = np.zeros((tracks, z.shape[1], z.shape[1]))
        if len(rows):
            some = slice(None) if len(rows) == tracks else rows
            y[some], H[some], added[some] = self._linearise(
                x[some], P[some], z[some], present[some], self._unscented and unscented
            )
        return y, H, added

    def _linearise(
        self, x: Array, P: Array, z: Array, present: Array, unscented: bool
    ) -> tuple[Array, Array, Array | float]:
        X, J = (x, None) if self._seen.same else self._seen(x)
        h = self._look.h(X)
        y = self._look.residual(np.where(present, z, h), h)

        def away(points: Array) -> Array:
            values = self._look.h(points if self._seen.same else self._seen(points)[0])
            return self._look.residual(values, np.tile(h, (len(points) // len(h), 1)))

        if unscented:
            mean, H, added = regression(away, x, P)
            return y - mean, H, added
        H = self._look.jacobian(X)
        if H is None:
            return y, jacobian_by_differences(away, x, P), 0.0
        return y, H if J is None else H @ J, 0.0
