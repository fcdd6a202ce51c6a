"""A filter of one axis on positions of two or three: every axis is a track of its own."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import Array, whole
from ..estimate import Estimate, Status
from ..frozen import frozen
from ..models.sensor import Position
from .bank import Bank
from .source import BatchSource

AXES = "xyz"
# what is said of a row whose axes differ: the first of these that one of them has
ORDER = (Status.none, Status.restarted, Status.initialised, Status.gated, Status.updated, Status.predicted)


@dataclass(repr=False, eq=False)
class AxesEstimate(Estimate):
    """Estimates of axes that know nothing of each other: P is block diagonal, modes are those of x, then of y (and z).

    A target manoeuvres where it does along any axis: 1 − Π (1 − pₐ).
    """

    axes: int = 1

    @property
    def manoeuvring(self) -> Array:
        """Probability (N,) that the target manoeuvres along an axis; NaN where modes do not tell."""
        mu = self.mode_probability
        if not any(self.non_manoeuvring):
            return np.full(mu.shape[:-1], np.nan)
        quiet = np.where(self.non_manoeuvring, mu, 0.0).reshape(*mu.shape[:-1], self.axes, -1).sum(axis=-1)
        return np.clip(1.0 - quiet.prod(axis=-1), 0.0, 1.0)


class RowOptions(TypedDict, total=False):
    """What can be told of rows that run along each axis by themselves."""

    offsets: ArrayLike | None
    covariance: ArrayLike | None
    input: ArrayLike | None
    threads: int | None
    outputs: Sequence[str] | None


class AxisByAxis:
    """``filter``, which has one axis, on ``axes`` of them, each as a track of its own.

    Estimates have the components of all axes. NIS and log-likelihoods are sums over axes; of statuses that differ the
    first of none, restarted, initialised, gated, updated, predicted counts. Of a row's covariance the variances are
    used. A file holds the filter of one axis. Errors: ValueError for a filter of other measurements than one position.
    Source: the reading under which lee-2003's table comes out.
    """

    def __init__(self, filter: Bank, axes: int) -> None:
        if not of_one_axis(filter):
            raise ValueError(f"filter: expected one whose sensor measures x alone, got {filter!r}")
        self.filter_, self.axes = filter, whole("axes", axes, 2, 3)
        sensor: Any = filter.sensors[0]
        noise = float(sensor.noise[0, 0])
        self.sensors = (Position(sd=noise**0.5, axes=self.axes),)
        self.motions, self.outliers, self.initial = filter.motions, filter.outliers, filter.initial
        self.coast, self.declaration = getattr(filter, "coast", None), None
        self.counts_rows, self.not_smoothed, self.fitted = filter.counts_rows, filter.not_smoothed, filter.fitted
        self.columns = self.axes
        named = [f"{name[:-1]}{axis}" for axis in AXES[: self.axes] for name in filter.components]
        self.components: tuple[str, ...] = tuple(named)
        many = len(filter.modes) > 1
        self.modes: tuple[str, ...] = tuple(
            f"{axis}_{mode}" if many else mode for axis in AXES[: self.axes if many else 1] for mode in filter.modes
        )
        self.non_manoeuvring: tuple[bool, ...] = tuple(filter.non_manoeuvring) * (self.axes if many else 1)

    def __repr__(self) -> str:
        return f"AxisByAxis({self.filter_!r}, {self.axes})"

    def described(self) -> dict[str, object]:
        """The filter of one axis."""
        return self.filter_.described()

    def save(self, path: str | os.PathLike[str], **more: object) -> None:
        """Write the filter of one axis, as its own ``save`` does."""
        self.filter_.save(path, **more)

    def filter(self, time: ArrayLike, z: ArrayLike, **options: Unpack[RowOptions]) -> Estimate:
        """As :meth:`jink.IMM.filter`, without ``initial`` and ``out``."""
        return self._run(self.filter_.filter, time, z, **options)

    def smooth(
        self,
        time: ArrayLike,
        z: ArrayLike,
        *,
        lag: int | None = None,
        lag_seconds: float | None = None,
        **options: Unpack[RowOptions],
    ) -> Estimate:
        """As :meth:`jink.IMM.smooth`, without ``initial`` and ``out``."""
        return self._run(partial(self.filter_.smooth, lag=lag, lag_seconds=lag_seconds), time, z, **options)

    def start(
        self, n: int | None = None, *, lag: int = 0, state: bytes | None = None, outputs: Sequence[str] | None = None
    ) -> LiveAxes:
        """Track live, as :meth:`jink.IMM.start`."""
        live = self.filter_.start((n or 1) * self.axes, lag=lag, state=state, outputs=outputs)
        return LiveAxes(self, live, n)

    def _run(
        self,
        verb: Any,
        time: ArrayLike,
        z: ArrayLike,
        *,
        offsets: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        input: ArrayLike | None = None,
        threads: int | None = None,
        outputs: Sequence[str] | None = None,
        **other: Any,
    ) -> Estimate:
        if given := next((name for name, value in other.items() if value is not None), ""):
            raise TypeError(f"{given}: a filter that runs along each axis by itself does not take this argument")
        rows = self._columns(z)
        ends = np.array([0, len(rows)]) if offsets is None else np.asarray(offsets)
        estimate = verb(
            np.concatenate([np.asarray(time)] * self.axes),
            rows.T.reshape(-1, 1),
            offsets=np.r_[ends, *(ends[1:] + k * len(rows) for k in range(1, self.axes))],
            covariance=self._apart(variances(covariance)),
            input=self._apart(None if input is None else np.asarray(input, dtype=float)),
            threads=threads,
            outputs=outputs,
        )
        apart = self.by_axis(estimate)
        source = AxesSource(self, estimate.source)
        return replace(self.joined(apart), source=source)

    def _columns(self, z: ArrayLike) -> Array:
        rows = np.asarray(z, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != self.axes:
            raise ValueError(f"z: expected shape (N, {self.axes}), one column per axis, got {rows.shape}")
        return rows

    def _apart(self, rows: Array | None) -> Array | None:
        return None if rows is None else np.ascontiguousarray(rows.T).reshape(-1, 1)

    def by_axis(self, estimate: Estimate) -> dict[str, Array]:
        """Results (N, axes, …) of an estimate whose tracks are axes."""
        return {k: v.reshape(self.axes, -1, *v.shape[1:]).swapaxes(0, 1) for k, v in estimate.results.items()}

    def joined(self, apart: dict[str, Array]) -> AxesEstimate:
        """One estimate of results (N, axes, …)."""
        n = next(iter(apart.values())).shape[0]
        out: dict[str, Any] = {}
        for name, value in apart.items():
            if name == "P":
                size = value.shape[-1]
                out[name] = np.zeros((n, self.axes * size, self.axes * size))
                for k in range(self.axes):
                    out[name][:, k * size : (k + 1) * size, k * size : (k + 1) * size] = value[:, k]
            elif name == "status":
                out[name] = _status(value)
            elif name == "time" or (name == "mode_probability" and value.shape[-1] == 1):
                out[name] = value[:, 0]
            elif name in ("x", "mode_probability", "pit"):
                out[name] = value.reshape(n, -1)
            else:
                out[name] = _summed(value)
        return AxesEstimate(self.components, self.modes, out, self.non_manoeuvring, self.axes)


@frozen
class AxesSource:
    """Rows of which every axis is a track: first all tracks along x, then along y (and z)."""

    of: AxisByAxis
    apart: BatchSource

    @property
    def time(self) -> Array:
        """Of each row, s."""
        return self.apart.time[: len(self.apart.time) // self.of.axes]

    @property
    def offsets(self) -> NDArray[np.int64]:
        """Where targets begin, and the end."""
        return self.apart.offsets[: (len(self.apart.offsets) - 1) // self.of.axes + 1]

    def part(self, first: int, end: int) -> AxesSource:
        """Some of the targets."""
        bounds, size = self.offsets, len(self.time)
        rows = np.arange(bounds[first], bounds[end])
        ends = bounds[first : end + 1] - bounds[first]
        axes = range(self.of.axes)
        batch = self.apart.batch.only(
            np.concatenate([rows + k * size for k in axes]), np.r_[ends, *(ends[1:] + k * ends[-1] for k in axes[1:])]
        )
        return replace(self, apart=replace(self.apart, batch=batch))

    def at(self, times: list[Array]) -> Estimate:
        """As :meth:`jink.Estimate.at`, along each axis."""
        found = self.apart.at(times * self.of.axes)
        assert isinstance(found.source, BatchSource)
        return replace(self.of.joined(self.of.by_axis(found)), source=AxesSource(self.of, found.source))


class LiveAxes:
    """Live targets whose axes are tracks; see :meth:`AxisByAxis.start`."""

    def __init__(self, of: AxisByAxis, live: Any, n: int | None) -> None:
        self._of, self._live, self._single, self.n = of, live, n is None, n or 1

    def update(
        self, t: ArrayLike, z: ArrayLike, *, covariance: ArrayLike | None = None, input: ArrayLike | None = None
    ) -> Estimate:
        """All targets at time t, one for all or (n,): z (n, axes)."""
        rows = self._of._columns(np.atleast_2d(np.asarray(z, dtype=float)))
        noise, known = variances(covariance), None if input is None else np.asarray(input, dtype=float)
        estimate = self._live.update(
            self._times(t),
            rows.reshape(-1, 1),
            covariance=None if noise is None else noise.reshape(-1, 1),
            input=None if known is None else known.reshape(-1, 1),
        )
        return self._joined(estimate)

    def predict(self, t: ArrayLike) -> Estimate:
        """Where the targets will be at time t; the live state is not touched."""
        return self._joined(self._live.predict(self._times(t)))

    def begin(self, target: int, x: ArrayLike, P: ArrayLike, time: float) -> None:
        """Start one target from a given state of all axes at a time; covariances between axes are left out."""
        size = len(self._of.filter_.components)
        x, P = np.asarray(x, dtype=float), np.asarray(P, dtype=float)
        for k in range(self._of.axes):
            own = slice(k * size, (k + 1) * size)
            self._live.begin(target * self._of.axes + k, x[own], P[own, own], time)

    def reset(self, target: int) -> None:
        """Forget one target; its next position starts a new one."""
        for k in range(self._of.axes):
            self._live.reset(target * self._of.axes + k)

    def save(self) -> bytes:
        """The state as bytes."""
        return self._live.save()

    def restore(self, state: bytes) -> None:
        """Take up a saved state."""
        self._live.restore(state)

    def _times(self, t: ArrayLike) -> Any:
        times = np.atleast_1d(np.asarray(t))
        return np.repeat(times, self._of.axes) if len(times) > 1 else times

    def _joined(self, estimate: Estimate) -> Estimate:
        apart = {k: v.reshape(self.n, self._of.axes, *v.shape[1:]) for k, v in estimate.results.items()}
        joined = self._of.joined(apart)
        if self._single:
            joined.results = {name: value[0] for name, value in joined.results.items()}
        return joined


def of_one_axis(filter: Any) -> bool:
    """Does this filter take one measured position, x alone?"""
    sensors = getattr(filter, "sensors", ())
    return len(sensors) == 1 and tuple(getattr(sensors[0], "components", ())) == ("x",)


def on_axes(filter: Any, sensor: Any) -> Any:
    """The filter for a sensor: one of one axis runs along each axis of the sensor; others stay as they are."""
    several = sensor.position_only and (sensor.axes or 2) > 1
    return AxisByAxis(filter, sensor.axes) if several and of_one_axis(filter) else filter


def variances(covariance: ArrayLike | None) -> Array | None:
    """Variances (N, axes), from covariances (N, axes, axes) or as given."""
    if covariance is None:
        return None
    noise = np.asarray(covariance, dtype=float)
    return np.einsum("...ii->...i", noise) if noise.ndim == 3 else noise


def _summed(value: Array) -> Array:
    """The sum over axes of what is known; NaN where nothing is."""
    if value.dtype.kind != "f":
        return value.sum(axis=1)
    return np.where(np.isnan(value).all(axis=1), np.nan, np.nansum(value, axis=1))


def _status(value: np.ndarray) -> np.ndarray:
    out = np.zeros(len(value), dtype=np.uint8)
    for status in reversed(ORDER):
        out[(value == status).any(axis=1)] = status
    return out
