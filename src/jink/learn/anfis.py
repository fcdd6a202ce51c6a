"""Training of ANFIS: backpropagation alone, or hybrid with least squares for the consequents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from ..checks import Array
from ..models.anfis import NOWHERE, Anfis, membership
from .descent import Adam, Kept

METHODS = ("hybrid", "backpropagation")
GAP = 0.02  # least distance between a triangle's corners, least width of the others, in units of the scaled inputs


def fit_anfis(
    u: Array,
    y: Array,
    *,
    validation: tuple[Array, Array] | None = None,
    kind: str = "triangular",
    functions: int | Sequence[int] = 4,
    method: str = "hybrid",
    epochs: int = 300,
    rate: float = 0.01,
    ridge: float = 1e-6,
    progress: Callable[[int, float], None] | None = None,
) -> Anfis:
    """An ANFIS that maps u (N, inputs) to y (N, outputs), both scaled to about one.

    functions: how many each input has, one number for all or one each; an input with a single one divides nothing, and
    takes part in the consequents only. They are spread evenly over each input's range first. Each epoch of "hybrid"
    solves the consequents by ridge least squares, min ‖y − Φ c‖² + ridge · N ‖c‖², and takes a gradient step in the
    memberships; "backpropagation" takes gradient steps (Adam) in both. The epoch that does best on the validation pair
    is kept (without one, on the training pair). Deterministic. Errors: ValueError for an unknown method, TypeError
    where y is not (N, outputs). Source: Jang, IEEE Trans. SMC-23(3), 1993, §III; ridge because neighbouring inputs may
    be multiples of each other.
    """
    if method not in METHODS:
        raise ValueError(f"method: expected one of {', '.join(METHODS)}, got {method!r}")
    if not isinstance(functions, int) and len(functions) != u.shape[-1]:
        raise ValueError(f"functions: expected {u.shape[-1]} numbers, one for each input, got {len(functions)}")
    if u.ndim != 2 or y.ndim != 2 or len(u) != len(y):
        raise TypeError(f"y: expected (N, outputs) with u (N, inputs), got {y.shape} and {u.shape}")
    counts = [functions] * u.shape[1] if isinstance(functions, int) else list(functions)
    m = [_spread(kind, count, u[:, i]) for i, count in enumerate(counts)]
    c = np.zeros((prod(counts), y.shape[1], u.shape[1] + 1))
    checked = validation if validation is not None else (u, y)
    kept: Kept[tuple[list[Array], Array]] = Kept()
    adam = Adam(rate)
    for epoch in range(epochs):
        system = _System(kind, m, u)
        if method == "hybrid":
            c = system.solve(y, ridge)
        gradient_m, gradient_c = system.gradient(y, c)
        kept.offer(_loss(kind, m, c, *checked), (m, c))
        if progress:
            progress(epoch, kept.loss)
        moved = adam.step([*m, c], [*gradient_m, gradient_c if method == "backpropagation" else 0 * c])
        m, c = [_admissible(kind, each) for each in moved[:-1]], moved[-1]
    if method == "hybrid":
        c = _System(kind, m, u).solve(y, ridge)
    kept.offer(_loss(kind, m, c, *checked), (m, c))
    m, c = kept.value
    return Anfis(kind, [each.tolist() for each in m], c.tolist())


@dataclass
class _System:
    """The firing strengths of all samples under the memberships m, and what depends on them."""

    kind: str
    m: list[Array]
    u: Array

    def __post_init__(self) -> None:
        self.grades = [membership(self.kind, each, self.u[:, i]) for i, each in enumerate(self.m)]
        self.shape = tuple(len(each) for each in self.m)
        h = self.grades[0]
        for grade in self.grades[1:]:
            h = (h[:, :, None] * grade[:, None, :]).reshape(len(self.u), -1)
        self.total = np.maximum(h.sum(axis=1, keepdims=True), NOWHERE)
        self.share = h / self.total
        self.extended = np.column_stack([self.u, np.ones(len(self.u))])
        self.design = (self.share[:, :, None] * self.extended[:, None, :]).reshape(len(self.u), -1)

    def answer(self, c: Array) -> Array:
        """y (N, outputs) under consequents c (rules, outputs, inputs + 1)."""
        return self.design @ c.transpose(0, 2, 1).reshape(self.design.shape[1], -1)

    def solve(self, y: Array, ridge: float) -> Array:
        """Consequents by ridge least squares."""
        normal = self.design.T @ self.design
        normal[np.diag_indices_from(normal)] += ridge * len(self.u)
        return self._as_consequents(np.linalg.solve(normal, self.design.T @ y))

    def _as_consequents(self, flat: Array) -> Array:
        return flat.reshape(self.share.shape[1], self.extended.shape[1], -1).transpose(0, 2, 1)

    def gradient(self, y: Array, c: Array) -> tuple[list[Array], Array]:
        """Of the mean squared error, in the memberships and the consequents."""
        n, answer = len(self.u), self.answer(c)
        slope = 2 / n * (answer - y)
        # dy/dh_r = (rule_r − y)/Σh; each grade takes part in the rules of its row, times the grades of the other inputs
        in_h = np.zeros_like(self.share)
        for m in range(y.shape[1]):
            in_h += slope[:, m : m + 1] * (self.extended @ c[:, m].T - answer[:, m : m + 1])
        in_h /= self.total
        in_h = in_h.reshape(n, *self.shape)
        gradients = []
        for i, parameters in enumerate(self.m):
            in_grade = in_h
            for k in reversed(range(len(self.m))):
                if k != i:
                    shape = [n] + [1] * len(self.m)
                    shape[k + 1] = self.shape[k]
                    in_grade = (in_grade * self.grades[k].reshape(shape)).sum(axis=k + 1, keepdims=True)
            in_grade = in_grade.reshape(n, self.shape[i])
            gradients.append(_chain(self.kind, parameters, self.u[:, i], self.grades[i], in_grade))
        return gradients, self._as_consequents(self.design.T @ slope)


def _chain(kind: str, parameters: Array, u: Array, grade: Array, in_grade: Array) -> Array:
    """Gradient in the parameters (functions, …) from that in the grades (N, functions)."""
    x = u[:, None]
    if kind == "gaussian":
        centre, sd = parameters.T
        d = (x - centre) / sd
        parts = [grade * d / sd, grade * d * d / sd]
    elif kind == "bell":
        centre, width, slope = parameters.T
        distance = np.maximum(np.abs(x - centre) / width, 1e-12)
        common = grade * (1 - grade)
        parts = [
            common * 2 * slope * np.sign(x - centre) / (distance * width),
            common * 2 * slope / width,
            -common * 2 * np.log(distance),
        ]
    else:
        left, peak, right = parameters.T
        rising, falling = (x - left) / (peak - left), (right - x) / (right - peak)
        up = (rising > 0) & (rising < 1) & (x < peak)
        down = (falling > 0) & (falling < 1) & (x >= peak)
        up[:, 0] = down[:, -1] = False
        parts = [
            np.where(up, (rising - 1) / (peak - left), 0.0),
            np.where(up, -rising / (peak - left), np.where(down, falling / (right - peak), 0.0)),
            np.where(down, (1 - falling) / (right - peak), 0.0),
        ]
    return np.stack([(in_grade * part).sum(axis=0) for part in parts], axis=1)


def _spread(kind: str, functions: int, u: Array) -> Array:
    """Memberships that cover the range of u evenly and meet at one half."""
    low, high = float(u.min()), float(u.max())
    peaks = np.linspace(low, high, functions) if functions > 1 else np.array([0.5 * (low + high)])
    step = max((high - low) / max(functions - 1, 1), 2 * GAP)
    if kind == "triangular":
        return np.column_stack([peaks - step, peaks, peaks + step])
    if kind == "gaussian":
        return np.column_stack([peaks, np.full(functions, step / 2 / np.sqrt(2 * np.log(2)))])
    return np.column_stack([peaks, np.full(functions, step / 2), np.full(functions, 2.0)])


def _admissible(kind: str, parameters: Array) -> Array:
    """The nearest parameters that are allowed."""
    p = parameters.copy()
    if kind == "triangular":
        p[:, 0] = np.minimum(p[:, 0], p[:, 1] - GAP)
        p[:, 2] = np.maximum(p[:, 2], p[:, 1] + GAP)
    else:
        p[:, 1] = np.maximum(np.abs(p[:, 1]), GAP)
    if kind == "bell":
        p[:, 2] = np.clip(p[:, 2], 0.5, 10.0)
    return p


def _loss(kind: str, m: list[Array], c: Array, u: Array, y: Array) -> float:
    return float(((_System(kind, m, u).answer(c) - y) ** 2).mean())
