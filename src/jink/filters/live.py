"""Many live targets at once."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, items, numbers, real
from ..estimate import Estimate
from ..times import seconds
from . import memory
from .rows import array_of, indices, measurements, row_noise, sensor_index

OUTPUTS = ("x", "P", "mode_probability", "log_likelihood", "nis", "nis_dof", "time", "status")


class LiveEstimate(Protocol):
    """One target's estimate, as one update of a live target gives it."""

    @property
    def time(self) -> float:
        """Of the scan, s."""
        ...

    @property
    def x(self) -> Array:
        """Mean (n,)."""
        ...

    @property
    def P(self) -> Array:
        """Covariance (n, n)."""
        ...

    @property
    def mode_probability(self) -> Array:
        """Of each mode (M,)."""
        ...

    @property
    def log_likelihood(self) -> float:
        """Of the scan's measurement."""
        ...

    @property
    def nis(self) -> float:
        """Of the scan's innovation, NaN where there is none."""
        ...

    @property
    def nis_dof(self) -> float:
        """How many components were measured."""
        ...

    @property
    def status(self) -> str:
        """One of :data:`jink.STATUS`."""
        ...

    @property
    def doubt(self) -> float:
        """Probability that the measurement is an outlier, where the next one decides; else 0."""
        ...

    @property
    def decided(self) -> str | None:
        """The status of the measurement before, if it was in doubt until now: updated or gated."""
        ...

    @property
    def components(self) -> tuple[str, ...]:
        """Names of x."""
        ...

    def __getitem__(self, component: str, /) -> float:
        """One component's estimate, by name."""
        ...

    def sd(self, component: str) -> float:
        """One component's standard deviation, by name."""
        ...


class LiveTarget(Protocol):
    """One target, followed scan by scan."""

    def update(
        self,
        t: Any,
        z: ArrayLike | None,
        sensor: int = 0,
        covariance: ArrayLike | None = None,
        input: ArrayLike | None = None,
    ) -> LiveEstimate:
        """One measurement at time t; a missing one is None, a missing component NaN or None."""
        ...

    def predict(self, t: Any) -> LiveEstimate:
        """The estimate expected at time t; the live state is not touched."""
        ...

    def begin(self, x: ArrayLike, P: ArrayLike, time: float) -> None:
        """Start from a given state at a time."""
        ...

    def reset(self) -> None:
        """Forget the target; the next position starts a new one."""
        ...

    def save(self) -> bytes:
        """The state as bytes, the same on every machine."""
        ...

    def restore(self, state: bytes) -> None:
        """Take up a saved state."""
        ...


class LiveBatch:
    """n targets, updated together scan by scan. NaN marks a target without a measurement in this scan."""

    def __init__(
        self,
        live: Any,
        n: int,
        estimate: Callable[[dict[str, Any]], Estimate],
        *,
        components: int,
        modes: int,
        columns: int,
        sensors: int,
        axes: int,
        outputs: Sequence[str] | None,
        again: tuple[Any, int, int, Sequence[str] | None],
    ) -> None:
        self._again = again
        self._live, self.n, self._estimate = live, n, estimate
        self._columns, self._sensors, self._axes = columns, sensors, axes
        wanted = OUTPUTS if outputs is None else items("outputs", outputs, "names of outputs")
        unknown = [name for name in wanted if not isinstance(name, str) or name not in OUTPUTS]
        if unknown:
            raise ValueError(f"outputs: {unknown[0]!r} is not one of {', '.join(OUTPUTS)}")
        shapes = {"x": (n, components), "P": (n, components, components), "mode_probability": (n, modes)}
        self._shapes = {name: shapes.get(name, (n,)) for name in OUTPUTS if name in wanted and name != "status"}
        self._last = np.full(n, -np.inf)

    def update(
        self,
        t: ArrayLike,
        z: ArrayLike,
        *,
        sensor: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        input: ArrayLike | None = None,
    ) -> Estimate:
        """All targets at time t, one for all or (n,): z (n, m); covariance (n, m) variances or (n, m, m); input (n,
        axes).
        """
        rows = measurements(z, self._columns)
        if len(rows) != self.n:
            raise ValueError(f"z: expected {self.n} rows, one per target, got {len(rows)}")
        if np.isinf(rows).any():
            raise ValueError("z: has infinite values; a missing component is NaN or None")
        times = self._times(t)
        which = None
        if sensor is not None:
            given = indices("sensor", sensor)
            which = sensor_index(np.broadcast_to(given, (self.n,)) if given.ndim == 0 else given, self.n, self._sensors)
        noise = row_noise(covariance, self.n, self._columns)
        known = None if input is None else array_of("input", input, (self.n, self._axes))
        return self._call(times, rows, which, noise, known, predict_only=False)

    def follow(self, t: ArrayLike, z: ArrayLike, *, covariance: ArrayLike | None = None) -> Estimate:
        """Scan after scan, each as an :meth:`update` of all targets: t (K,); z (K n, m), covariance and the estimate
        scan by scan. For jink's own models.
        """
        times, rows = np.ascontiguousarray(np.asarray(seconds(t), dtype=float)), measurements(z, self._columns)
        if times.ndim != 1 or not times.size or not np.isfinite(times).all():
            raise ValueError("t: expected finite times, one for each scan")
        if len(rows) != times.size * self.n:
            raise ValueError(f"z: expected {times.size * self.n} rows, one per scan and target, got {len(rows)}")
        if np.isinf(rows).any():
            raise ValueError("z: has infinite values; a missing component is NaN or None")
        if np.any(times[0] < self._last) or np.any(np.diff(times) < 0):
            raise ValueError("t: lies before the last update; updates must come in order of time")
        noise = row_noise(covariance, len(rows), self._columns)
        self._last = np.full(self.n, times[-1])
        results, status = self._results(times.size)
        self._live.follow(times, rows, noise, [*(results.get(name) for name in OUTPUTS[:-1]), status])
        return self._estimate({**results, "status": status})

    def predict(self, t: ArrayLike) -> Estimate:
        """Where the targets will be at time t, one for all or (n,); the live state is not touched."""
        empty = np.empty((0, self._columns))
        return self._call(
            np.atleast_1d(np.asarray(seconds(t), dtype=float)), empty, None, None, None, predict_only=True
        )

    def begin(self, target: int, x: ArrayLike, P: ArrayLike, time: float) -> None:
        """Start one target from a given state at a time."""
        mean, spread = (np.ascontiguousarray(numbers(name, value)) for name, value in (("x", x), ("P", P)))
        self._live.begin(target, mean, spread, real("time", time))

    def reset(self, target: int) -> None:
        """Forget one target; its next position starts a new one."""
        self._live.reset(target)

    def save(self) -> bytes:
        """The state as bytes, the same on every machine."""
        return self._live.save()

    def restore(self, state: bytes) -> None:
        """Go on from a saved state."""
        self._live.restore(state)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled as its filter and its state; the past that a lag looks back on is not part of it."""
        return started_many, (*self._again, self.save(), self._last)

    def _times(self, t: ArrayLike) -> np.ndarray:
        times = np.ascontiguousarray(np.atleast_1d(np.asarray(seconds(t), dtype=float)))
        if times.shape not in ((1,), (self.n,)) or not np.isfinite(times).all():
            raise ValueError(f"t: expected one finite time, or {self.n}, one for each target")
        if np.any(times < self._last):
            raise ValueError("t: lies before the last update; updates must come in order of time")
        self._last = np.array(np.broadcast_to(times, (self.n,)))
        return times

    def _call(self, times: Any, rows: Any, which: Any, noise: Any, known: Any, *, predict_only: bool) -> Estimate:
        results, status = self._results(1)
        slots = [*(results.get(name) for name in OUTPUTS[:-1]), status]
        self._live.update(times, rows, which, noise, known, slots, predict_only)
        return self._estimate({**results, "status": status})

    def _results(self, scans: int) -> tuple[dict[str, Any], np.ndarray]:
        """Arrays for the results of so many scans, and for their status."""
        empty = np.empty if scans == 1 else memory.empty
        shapes = {name: (scans * shape[0], *shape[1:]) for name, shape in self._shapes.items()}
        return {name: empty(shape) for name, shape in shapes.items()}, np.empty(scans * self.n, dtype=np.uint8)


def started(filter: Any, lag: int, state: bytes) -> Any:
    """One live target from a copy of its state."""
    return filter.start(lag=lag, state=state)


def started_many(
    filter: Any, n: int, lag: int, outputs: Sequence[str] | None, state: bytes, last: np.ndarray
) -> LiveBatch:
    """Live targets from a copy of their state."""
    live = filter.start(n, lag=lag, state=state, outputs=outputs)
    live._last = last.copy()
    return live
