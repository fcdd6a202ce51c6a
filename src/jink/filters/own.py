"""A whole filter of your own: two functions on arrays, run like any other filter."""

from __future__ import annotations

import copy
import os
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array
from ..estimate import Estimate, Status
from ..models.sensor import Sensor
from .own_state import State, checked_state, merged, names_of, part_of, probed
from .plain import VERSION, plain, write
from .predicted_density import Density
from .rows import measurements, row_noise, track_offsets

OUTPUTS = ("x", "P", "mode_probability", "log_likelihood", "log_likelihood_scan", "nis", "nis_dof", "status")


class Steps(Protocol):
    """A filter as two functions over B targets at once; a state is a dict of arrays whose first axis is the target.

    "x" (B, n) and "P" (B, n, n) are what it estimates. "mode_probability" (B, M), "nis" and "log_likelihood" (B,) are
    optional; other arrays are its own. Optional attributes: components and modes (names), non_manoeuvring.
    """

    def begin(self, z: Array, R: Array) -> State:
        """The state of tracks that start with measurements z (B, m) of covariance R (B, m, m)."""
        ...

    def step(self, state: State, dt: Array, z: Array, R: Array) -> State:
        """The state dt (B,) seconds later; a component that was not measured is NaN in z."""
        ...


class OwnFilter:
    """Your own filter, ``steps``, on a sensor; in races and wherever a filter's estimates are asked for.

    steps: an object with ``begin(z, R)`` and ``step(state, dt, z, R)``, see :class:`Steps`. Where it gives no NIS and
    likelihood, they follow from its prediction: the state of a step without measurement, linearised by the sensor.
    Errors: ValueError naming the function and what it gave.
    """

    arguments = ("steps",)
    engine = None  # which could be differentiated
    # a row without a measurement may change more than the time
    counts_rows = True
    not_smoothed = "a whole filter of your own has no smoother"

    def __init__(self, steps: Steps, sensor: Sensor) -> None:
        for name in ("begin", "step"):
            if not callable(getattr(steps, name, None)):
                raise TypeError(f"steps: expected an object with begin(z, R) and step(state, dt, z, R), got {steps!r}")
        self.steps, self.sensors = steps, (sensor,)
        self.axes, self.columns = int(sensor.axes or 2), len(sensor.components)
        self.motions, self.outliers, self.initial, self.coast, self.declaration = (), None, None, None, None
        self.fitted: dict[str, object] = {}
        found = probed(steps, sensor)
        self.components: tuple[str, ...] = names_of(steps, found["x"].shape[1], self.axes)
        count = found["mode_probability"].shape[1] if "mode_probability" in found else 1
        named = tuple(getattr(steps, "modes", ())) or tuple(f"mode_{k + 1}" for k in range(count))
        if len(named) != count:
            raise ValueError(f"modes: expected {count} names, as many as mode_probability has columns, got {named}")
        self.modes: tuple[str, ...] = named if count > 1 else (named[0] if named else type(steps).__name__,)
        self.non_manoeuvring: tuple[bool, ...] = tuple(getattr(steps, "non_manoeuvring", (False,) * count))
        self._density = Density(sensor, self.components)

    def __repr__(self) -> str:
        return f"OwnFilter({self.steps!r}, {self.sensors[0]!r})"

    def described(self) -> dict[str, object]:
        """As JSON holds it: module and name of the class of steps, and its numbers. Errors: TypeError."""
        body: dict[str, object] = {"filter": "OwnFilter", "steps": plain(self.steps), "motions": []}
        return body | {"sensors": [plain(sensor) for sensor in self.sensors]}

    def save(self, path: str | os.PathLike[str], **more: object) -> None:
        """As :meth:`jink.IMM.save`; :func:`jink.load` reads it with ``own=True``, which imports your module."""
        write({"jink": "filter", "version": VERSION, "units": "SI", **self.described(), **more}, path)

    def smooth(self, time: ArrayLike, z: ArrayLike, **options: object) -> Estimate:
        """Errors: ValueError, since there is no smoother."""
        raise ValueError(f"smooth: cannot smooth {type(self.steps).__name__}: {self.not_smoothed}")

    def filter(
        self,
        time: ArrayLike,
        z: ArrayLike,
        *,
        offsets: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        threads: int | None = None,
        outputs: Sequence[str] | None = None,
        **other: object,
    ) -> Estimate:
        """As :meth:`jink.IMM.filter`, scan by scan over all tracks in Python; threads is without effect."""
        if given := next((name for name, value in other.items() if value is not None), ""):
            raise TypeError(f"{given}: a whole filter of your own does not take this argument")
        rows = measurements(z, self.columns)
        times = np.asarray(time, dtype=float).reshape(-1)
        bounds, noise = track_offsets(offsets, len(rows)), self._noise(covariance, len(rows))
        lengths = np.diff(bounds)
        live = OwnLive(self, len(lengths))
        results: dict[str, Any] = {}
        for k in range(int(lengths.max(initial=0))):
            there = np.flatnonzero(lengths > k)
            at = bounds[there] + k
            for name, value in live.advance(there, times[at], rows[at], noise[at]).items():
                if name not in results:
                    results[name] = np.full((len(rows), *value.shape[1:]), np.nan)
                results[name][at] = value
        return self._estimate(results, bounds, outputs)

    def start(
        self, n: int | None = None, *, lag: int = 0, state: bytes | None = None, outputs: Sequence[str] | None = None
    ) -> OwnLive:
        """Follow n targets live (one where n is None). Errors: ValueError for a lag or a saved state."""
        if lag or state is not None:
            raise ValueError("start: a whole filter of your own takes neither a lag nor a saved state")
        return OwnLive(self, n or 1, single=n is None)

    def _noise(self, covariance: ArrayLike | None, n: int) -> Array:
        given = row_noise(covariance, n, self.columns)
        if given is None:
            return np.broadcast_to(self.sensors[0].noise, (n, self.columns, self.columns))
        return given if given.ndim == 3 else given[:, :, None] * np.eye(self.columns)

    def _estimate(self, results: dict[str, Any], bounds: Any, outputs: Sequence[str] | None) -> Estimate:
        wanted = OUTPUTS if outputs is None else tuple(outputs)
        n, m, rows = len(self.components), len(self.modes), int(bounds[-1])
        shapes = {"x": (n,), "P": (n, n), "mode_probability": (m,)}
        kept = {k: results.get(k, np.full((rows, *shapes.get(k, ())), np.nan)) for k in OUTPUTS}
        owner = np.repeat(np.arange(len(bounds) - 1), np.diff(bounds))
        each = np.nan_to_num(kept["log_likelihood_scan"])
        kept["log_likelihood"] = np.bincount(owner, each, minlength=len(bounds) - 1)
        kept["status"] = kept["status"].astype(np.uint8) if rows else np.zeros(0, dtype=np.uint8)
        chosen = {name: kept[name] for name in OUTPUTS if name in wanted}
        return Estimate(self.components, self.modes, chosen, self.non_manoeuvring)


class OwnLive:
    """n targets of a filter of your own, scan by scan."""

    def __init__(self, of: OwnFilter, n: int, *, single: bool = False) -> None:
        self.of, self.n, self._single = of, n, single
        self._state: State = {}
        self._time = np.full(n, np.nan)

    def update(self, t: ArrayLike, z: ArrayLike, *, covariance: ArrayLike | None = None) -> Estimate:
        """All targets at time t, one for all or (n,): z (n, m), NaN where missing."""
        rows = measurements(np.atleast_2d(np.asarray(z, dtype=float)), self.of.columns)
        noise = self.of._noise(None if covariance is None else np.asarray(covariance), self.n)
        times = np.broadcast_to(np.asarray(t, dtype=float), (self.n,))
        return self._out(self.advance(np.arange(self.n), times, rows, noise))

    def predict(self, t: ArrayLike) -> Estimate:
        """Where the targets will be at time t; the live state is not touched."""
        ahead = copy.deepcopy(self)
        return ahead.update(t, np.full((self.n, self.of.columns), np.nan))

    def advance(self, targets: Any, time: Array, z: Array, R: Array) -> dict[str, Array]:
        """Some targets with their rows; what is known of each afterwards."""
        of, measured = self.of, np.isfinite(z)
        begun = np.isfinite(self._time[targets])
        out = self._empty(len(targets))
        new = ~begun & measured.all(axis=1)
        if new.any():
            state = checked_state("begin", of.steps.begin(z[new].copy(), R[new].copy()), int(new.sum()), of.components)
            self._state = merged(self._state, state, targets[new], self.n)
            out["status"][new] = Status.initialised
        go = begun & (measured.any(axis=1) | (time > self._time[targets]))
        if go.any():
            self._steps(targets, time, z, R, np.flatnonzero(go), out)
        out["status"][begun & ~measured.any(axis=1)] = Status.predicted
        known = begun | new
        self._time[targets[known]] = time[known]
        for name in ("x", "P", "mode_probability"):
            if name in self._state:
                out[name][known] = self._state[name][targets[known]]
        return out

    def _steps(self, targets: Any, time: Array, z: Array, R: Array, go: Any, out: dict[str, Array]) -> None:
        """Step the targets that have begun; score the measurements against the predictions."""
        of, who = self.of, targets[go]
        before, dt = part_of(self._state, who), time[go] - self._time[who]
        if (dt < 0).any():
            raise ValueError("time: lies before the row before it; rows of a track must be in the order of time")
        after = checked_state(
            "step", of.steps.step(copy.deepcopy(before), dt.copy(), z[go].copy(), R[go].copy()), len(go), of.components
        )
        measured = np.isfinite(z[go])
        scored = np.flatnonzero(measured.any(axis=1))
        out["status"][go[scored]] = Status.updated
        given = {"nis": "nis", "log_likelihood": "log_likelihood_scan"}
        if len(scored) and "P" in after and not given.keys() <= after.keys():
            none = np.full((len(scored), of.columns), np.nan)
            past = part_of(before, scored)
            ahead = of.steps.step(past, dt[scored].copy(), none, R[go][scored].copy())
            state = checked_state("step", ahead, len(scored), of.components)
            found = of._density(state["x"], state["P"], z[go][scored], R[go][scored])
            for name, value in found.items():
                out[name][go[scored]] = value
        for name, to in given.items():
            if name in after:
                out[to][go[scored]] = after[name][scored]
        out["nis_dof"][go[scored]] = measured[scored].sum(axis=1)
        self._state = merged(self._state, after, who, self.n)

    def _empty(self, n: int) -> dict[str, Array]:
        size, modes = len(self.of.components), len(self.of.modes)
        out = {"nis": np.full(n, np.nan), "log_likelihood_scan": np.zeros(n)}
        out |= {"x": np.full((n, size), np.nan), "P": np.full((n, size, size), np.nan)}
        single = np.ones((n, 1)) if modes == 1 else np.full((n, modes), np.nan)
        return out | {"mode_probability": single, "nis_dof": np.zeros(n), "status": np.zeros(n)}

    def _out(self, results: dict[str, Any]) -> Estimate:
        estimate = self.of._estimate(results, np.arange(self.n + 1), None)
        if self._single:
            estimate.results = {name: value[0] for name, value in estimate.results.items()}
        return estimate
