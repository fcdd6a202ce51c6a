"""An adaptive network-based fuzzy inference system as data; :mod:`jink.learn.anfis` trains it."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array
from ..frozen import frozen
from .fuzzy import _tuples

PARAMETERS = {"triangular": 3, "gaussian": 2, "bell": 3}  # of a membership function
NOWHERE = 1e-9  # a total firing below this fades the answer to zero


@frozen
class Anfis:
    """First-order Sugeno rules on a grid of membership functions.

    Rule r takes one membership function of each input (the last input's run fastest) and fires with their product hᵣ;
    y = Σ hᵣ (Aᵣ u + bᵣ) / Σ hᵣ, and zero where nothing fires (the denominator is at least 1e-9).

    shape "triangular" (left, peak, right), "gaussian" (centre, sd) exp(−½((u−c)/s)²), or "bell" (centre, half width a,
    slope b) 1/(1 + |(u−c)/a|^2b); memberships, per input, per function, these parameters. The outermost triangles stay
    at one beyond their peaks. consequents (rules, outputs, inputs + 1): A and b of each rule. Errors: ValueError where
    these do not fit. Source: Jang, IEEE Trans. SMC-23(3), 1993.
    """

    shape: str
    memberships: Sequence[Sequence[Sequence[float]]]
    consequents: Sequence[Sequence[Sequence[float]]]

    def __post_init__(self) -> None:
        if self.shape not in PARAMETERS:
            raise ValueError(f"Anfis.shape: expected one of {', '.join(PARAMETERS)}, got {self.shape!r}")
        functions = [np.asarray(m, dtype=float) for m in self.memberships]
        for m in functions:
            if m.ndim != 2 or not len(m) or m.shape[1] != PARAMETERS[self.shape] or not np.isfinite(m).all():
                raise ValueError(
                    f"Anfis.memberships: expected (functions, {PARAMETERS[self.shape]}) finite numbers per input, "
                    f"got {m.shape}"
                )
            _check(self.shape, m)
        c = np.asarray(self.consequents, dtype=float)
        rules, inputs = prod(len(m) for m in functions), len(functions)
        if not functions or c.ndim != 3 or c.shape[0] != rules or c.shape[2] != inputs + 1:
            raise ValueError(f"Anfis.consequents: expected ({rules}, outputs, {inputs + 1}), got {c.shape}")
        if not np.isfinite(c).all():
            raise ValueError("Anfis.consequents: has numbers that are not finite")
        object.__setattr__(self, "memberships", tuple(_tuples(m.tolist()) for m in functions))
        object.__setattr__(self, "consequents", _tuples(c.tolist()))

    @property
    def inputs(self) -> int:
        """How many numbers go in."""
        return len(self.memberships)

    @property
    def outputs(self) -> int:
        """How many numbers come out."""
        return len(self.consequents[0])

    def firing(self, u: ArrayLike) -> Array:
        """hᵣ (N, rules) for u (N, inputs), not normalised."""
        u = np.asarray(u, dtype=float)
        h = np.ones((len(u), 1))
        for i, functions in enumerate(self.memberships):
            grade = membership(self.shape, np.asarray(functions), u[:, i])
            h = (h[:, :, None] * grade[:, None, :]).reshape(len(u), -1)
        return h

    def __call__(self, u: ArrayLike) -> Array:
        """y (N, outputs) for u (N, inputs)."""
        u = np.asarray(u, dtype=float)
        h = self.firing(u)
        h = h / np.maximum(h.sum(axis=1, keepdims=True), NOWHERE)
        c = np.asarray(self.consequents)
        return np.einsum("nr,rmi,ni->nm", h, c[..., :-1], u) + h @ c[..., -1]


def membership(kind: str, parameters: Array, u: Array) -> Array:
    """Grades (N, functions) of u (N,) under functions with the given parameters."""
    x = u[:, None]
    if kind == "gaussian":
        return np.exp(-0.5 * ((x - parameters[:, 0]) / parameters[:, 1]) ** 2)
    if kind == "bell":
        with np.errstate(divide="ignore"):
            return 1 / (1 + np.abs((x - parameters[:, 0]) / parameters[:, 1]) ** (2 * parameters[:, 2]))
    left, peak, right = parameters.T
    rising, falling = (x - left) / (peak - left), (right - x) / (right - peak)
    rising[:, 0] = np.where(u <= peak[0], 1.0, rising[:, 0])
    falling[:, -1] = np.where(u >= peak[-1], 1.0, falling[:, -1])
    return np.clip(np.minimum(rising, falling), 0.0, 1.0)


def _check(kind: str, m: Array) -> None:
    if kind == "triangular" and not ((m[:, 0] < m[:, 1]) & (m[:, 1] < m[:, 2])).all():
        raise ValueError("Anfis.memberships: expected left < peak < right of every triangle")
    if kind != "triangular" and not (m[:, 1:] > 0).all():
        raise ValueError("Anfis.memberships: expected positive widths (and slopes)")
