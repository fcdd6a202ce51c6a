"""Live tracking with models of the user's own: the interface of the engine's live targets."""

from collections import deque
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..estimate import Status, component_index
from ..times import seconds
from .batch import estimate
from .functions import Array, at_scan
from .scan import Scan
from .smoothing import backward
from .states import Outcome, Record

OUTPUTS = ("x", "P", "mode_probability", "log_likelihood", "nis", "nis_dof", "time", "status")


class LiveMany:
    """n live targets, scan by scan; with a lag the estimates are those of the scan so long ago, smoothed."""

    def __init__(self, engine: Scan, n: int, lag: int) -> None:
        self.engine, self.n, self.lag = engine, n, lag
        self.states = engine.new(n)
        self.scan = 0
        self._past: deque[tuple[Record, Array]] = deque(maxlen=lag + 1)

    def update(
        self,
        time: Array,
        z: Array,
        sensor: Array | None,
        noise: Array | None,
        input: Array | None,
        slots: list[Array | None],
        predict_only: bool,
    ) -> None:
        """All targets at a time, one or (n,), into the slots; predict_only leaves the live state alone."""
        to = {name: slot for name, slot in zip(OUTPUTS, slots, strict=True) if slot is not None}
        times = np.array(np.broadcast_to(time, (self.n,)))
        if predict_only:
            self._predict(to, times)
            return
        s, engine = self.states, self.engine
        if not s.started.any():
            engine.check_start()
        which = sensor if sensor is not None else np.zeros(self.n, dtype=np.int32)
        before, trial = s.time, s.take(np.arange(self.n))
        with at_scan(self.scan):
            out = engine.step(trial, times, z, which, noise, input)
        self.states, self.scan = trial, self.scan + 1
        x, P, probability, started, shown = trial.x, trial.P, trial.probability, trial.started, trial.time
        if self.lag:
            self._past.append((engine.record(trial, before, out, z, which, noise, input), trial.time))
            records = [record for record, _ in self._past]
            *_, (_, x, P, probability) = backward(engine, records)
            started, shown = records[0].started, self._past[0][1]
        estimate(engine, to, slice(None), x, P, probability, started)
        self._tell(to, out, started, shown)

    def _predict(self, to: dict[str, Any], times: Array) -> None:
        s = self.states
        with at_scan(self.scan):
            ahead = self.engine.propagate(s, np.where(s.started & ~np.isnan(s.time), times - s.time, 0.0), None)
        estimate(self.engine, to, slice(None), ahead.x, ahead.P, ahead.prior, s.started)
        self._tell(to, Outcome.new(self.n, self.engine.columns), s.started, times)

    def _tell(self, to: dict[str, Any], out: Outcome, started: Array, time: Array) -> None:
        values = {
            "log_likelihood": out.log_likelihood,
            "nis": np.where(out.scored, out.nis, np.nan),
            "nis_dof": np.where(out.scored, out.dof, 0.0),
            "time": time,
            "status": out.status(started),
        }
        for name, value in values.items():
            if name in to:
                to[name][:] = value

    def begin(self, target: int, x: Array, P: Array, time: float) -> None:
        """Start one target from a given state at a time; NaN: at its next update."""
        rows = np.array([target])
        self.engine.start.from_prior(self.states, rows, x[None], P[None], np.array([time]), self.engine.components)

    def reset(self, target: int) -> None:
        """Forget one target."""
        self.states.started[target] = self.states.running[target] = False

    def time(self, target: int) -> float:
        """Of one target's last update."""
        return float(self.states.time[target])

    def save(self) -> bytes:
        """The state as bytes; the fixed lag's past is not part of it."""
        return np.concatenate([np.asarray(a, dtype="<f8").ravel() for a in self.states.arrays()]).tobytes()

    def restore(self, state: bytes) -> None:
        """Take up a saved state."""
        numbers = np.frombuffer(state, dtype="<f8") if len(state) % 8 == 0 else np.empty(0)
        if len(numbers) != sum(a.size for a in self.states.arrays()):
            raise ValueError("state: was saved by another filter or for another number of targets")
        start = 0
        for a in self.states.arrays():
            a[...] = numbers[start : start + a.size].reshape(a.shape)
            start += a.size


@dataclass
class Now:
    """One target's estimate."""

    time: float
    x: Array
    P: Array
    mode_probability: Array
    log_likelihood: float
    nis: float
    nis_dof: float
    status: str
    components: tuple[str, ...]
    doubt: float = 0.0
    decided: str | None = None

    def __getitem__(self, component: str) -> float:
        """One component's estimate, by name."""
        return float(self.x[component_index(self.components, component)])

    def sd(self, component: str) -> float:
        """One component's standard deviation, by name."""
        k = component_index(self.components, component)
        return float(np.sqrt(self.P[k, k]))


class LiveOne:
    """One live target."""

    def __init__(self, engine: Scan, lag: int, filter: Any = None) -> None:
        self._many, self._filter = LiveMany(engine, 1, lag), filter

    def update(
        self,
        t: Any,
        z: ArrayLike | None,
        sensor: int = 0,
        covariance: ArrayLike | None = None,
        input: ArrayLike | None = None,
    ) -> Now:
        """One measurement at time t; returns the estimate. None or NaN is missing."""
        columns = self._many.engine.columns
        time = float(np.asarray(seconds(t)))
        row = np.full(columns, np.nan) if z is None else np.atleast_1d(np.asarray(z, dtype=float))
        if np.isnan(time):
            raise ValueError(f"t: expected a time in seconds or a date, got {t!r}")
        if self._many.states.started[0] and time < self._many.time(0):
            raise ValueError("t: lies before the last update; updates must come in the order of time")
        if not 0 <= sensor < len(self._many.engine.looks):
            raise ValueError(f"sensor: expected an index from 0 to {len(self._many.engine.looks) - 1}, got {sensor!r}")
        if row.shape != (columns,):
            raise ValueError(f"z: expected {columns} components, got shape {row.shape}")
        if np.isinf(row).any():
            raise ValueError("z: is infinite; a missing component is NaN or None")
        noise, known = (None if a is None else np.asarray(a, dtype=float)[None] for a in (covariance, input))
        return self._call(time, row[None], np.array([sensor], dtype=np.int32), noise, known, False)

    def predict(self, t: Any) -> Now:
        """The estimate expected at time t; the live state is not touched."""
        return self._call(float(np.asarray(seconds(t))), np.empty((0, 0)), None, None, None, True)

    def begin(self, x: ArrayLike, P: ArrayLike, time: float) -> None:
        """Start from a given state at a time."""
        self._many.begin(0, np.asarray(x, dtype=float), np.asarray(P, dtype=float), time)

    def reset(self) -> None:
        """Forget the target; the next position starts a new one."""
        self._many.reset(0)

    def save(self) -> bytes:
        """The state as bytes, the same on every machine."""
        return self._many.save()

    def restore(self, state: bytes) -> None:
        """Take up a saved state."""
        self._many.restore(state)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled as its filter and its state."""
        if self._filter is None:
            raise TypeError("a live target without its filter cannot be copied")
        return partial(self._filter.start, lag=self._many.lag, state=self.save()), ()

    def _call(self, time: float, z: Any, sensor: Any, noise: Any, known: Any, predict_only: bool) -> Now:
        n, m = len(self._many.engine.components), len(self._many.engine.modes)
        slots: list[Any] = [
            np.empty((1, n)),
            np.empty((1, n, n)),
            np.empty((1, m)),
            *(np.empty(1) for _ in range(4)),
        ]
        slots.append(np.empty(1, dtype=np.uint8))
        self._many.update(np.array([time]), z, sensor, noise, known, slots, predict_only)
        x, P, probability, likelihood, nis, dof, shown, status = (slot[0] for slot in slots)
        return Now(
            float(shown),
            x,
            P,
            probability,
            float(likelihood),
            float(nis),
            float(dof),
            Status(status).name,
            tuple(self._many.engine.components),
        )
