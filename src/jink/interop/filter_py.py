"""FilterPy: a ``KalmanFilter`` or an ``IMMEstimator`` read as a jink filter; no package is needed to read one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..checks import Array
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..models.start import Prior


@dataclass
class FixedStep:
    """x' = step x with noise, for one step of ``step_seconds``; several steps are taken one after the other."""

    step: Array
    noise: Array
    step_seconds: float
    components: tuple[str, ...]
    name: str

    def _powers(self, dt: float) -> tuple[Array, Array]:
        steps = round(float(dt) / self.step_seconds)
        if abs(steps * self.step_seconds - dt) > 1e-6 * self.step_seconds:
            raise ValueError(f"dt is {dt:g} s; FilterPy's F and Q are for steps of {self.step_seconds:g} s")
        F, Q = np.eye(len(self.step)), np.zeros_like(self.noise)
        for _ in range(steps):
            F, Q = self.step @ F, self.step @ Q @ self.step.T + self.noise
        return F, Q

    def f(self, x: Array, dt: float) -> Array:
        """One elapsed time for all targets."""
        return x @ self._powers(dt)[0].T

    def jacobian(self, x: Array, dt: float) -> Array:
        """F of that time."""
        return self._powers(dt)[0]

    def Q(self, dt: float) -> Array:
        """Q of that time."""
        return self._powers(dt)[1]


@dataclass
class Linear:
    """z = H x + v, v ~ N(0, R)."""

    H: Array
    R: Array
    axes: int

    def h(self, x: Array) -> Array:
        """What is measured."""
        return x @ self.H.T

    def jacobian(self, x: Array) -> Array:
        """H for every target."""
        return np.broadcast_to(self.H, (len(x), *self.H.shape))


def filter_of(theirs: Any, dt: float, components: Sequence[str] | None = None) -> Kalman | IMM:
    """A jink filter that does what FilterPy's does, from the state that it stands at.

    theirs: a ``KalmanFilter`` or an ``IMMEstimator`` of some; dt: seconds of one predict(); components: names of x, by
    default px vx (ax) py … by their number. The first row given to the filter is for the time of FilterPy's state, so
    a row without a measurement comes first. Errors: ValueError for filters that differ in H or R.
    """
    filters = list(getattr(theirs, "filters", [theirs]))
    first = filters[0]
    for one in filters[1:]:
        if not (np.array_equal(one.H, first.H) and np.array_equal(one.R, first.R)):
            raise ValueError("filters: differ in H or R; expected one sensor for all")
    H, R = np.atleast_2d(np.asarray(first.H, float)), np.atleast_2d(np.asarray(first.R, float))
    names = tuple(components) if components else _names(H.shape[1], H.shape[0])
    axes = sum(name[0] == "p" and name[1:] in ("x", "y", "z") for name in names)
    motions = [
        FixedStep(np.asarray(each.F, float), np.asarray(each.Q, float), float(dt), names, f"filterpy_{k + 1}")
        for k, each in enumerate(filters)
    ]
    prior = Prior(np.asarray(theirs.x, float).ravel(), np.asarray(theirs.P, float))
    if len(filters) == 1:
        return Kalman(motions[0], Linear(H, R, axes), initial=prior)
    return IMM(
        motions, Linear(H, R, axes), np.asarray(theirs.M, float), mode_probability=np.asarray(theirs.mu), initial=prior
    )


def _names(n: int, axes: int) -> tuple[str, ...]:
    kinds = {2: "pv", 3: "pva"}.get(n // axes if n % axes == 0 else 0)
    if kinds is None or axes > 3:
        raise ValueError(f"components: expected names for the {n} components of x")
    return tuple(f"{kind}{axis}" for axis in "xyz"[:axes] for kind in kinds)
