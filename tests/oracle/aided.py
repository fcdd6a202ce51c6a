"""Correctors on a filter's output: ANFIS (Jang 1993) and a multilayer perceptron, as Titi & Guney use them.

Inputs of one axis: z - x(t|t) and x(t|t-1) - x(t|t); output: the filter's error, added to the estimate. (The
paper's text calls x(t|t) predicted and x(t|t-1) estimated in one sentence; its equations say the reverse.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def triangular(x: Array, a: float, b: float, c: float) -> Array:
    """0 outside (a, c), 1 at b, straight between."""
    return np.maximum(np.minimum((x - a) / (b - a), (c - x) / (c - b)), 0.0)


def gaussian(x: Array, centre: float, spread: float) -> Array:
    return np.exp(-(((x - centre) / spread) ** 2) / 2)


def bell(x: Array, half_width: float, slope: float, centre: float) -> Array:
    """1/(1 + |(x - c)/a|^(2b))"""
    return 1 / (1 + np.abs((x - centre) / half_width) ** (2 * slope))


MEMBERSHIPS = {"triangular": triangular, "gaussian": gaussian, "bell": bell}


@dataclass
class Anfis:
    """First-order Sugeno system on a grid: rule (i, j) fires A_i(x1) B_j(x2) and says p x1 + q x2 + r.

    memberships: for either input a list of parameter tuples; consequents (len1, len2, 3). The outermost
    triangles stay at one beyond their peaks. The denominator is at least 1e-9: where nothing fires, 0.
    """

    shape: str
    memberships: tuple[list[tuple[float, ...]], list[tuple[float, ...]]]
    consequents: Array

    def __call__(self, x1: Array, x2: Array) -> Array:
        A, B = self.grades(x1, 0), self.grades(x2, 1)
        firing = A[..., :, None] * B[..., None, :]
        says = np.einsum("ijc,...c->...ij", self.consequents, np.stack([x1, x2, np.ones_like(x1)], axis=-1))
        return (firing * says).sum(axis=(-1, -2)) / np.maximum(firing.sum(axis=(-1, -2)), 1e-9)

    def grades(self, x: Array, which: int) -> Array:
        functions = self.memberships[which]
        grade = np.stack([MEMBERSHIPS[self.shape](x, *p) for p in functions], axis=-1)
        if self.shape == "triangular":
            grade[..., 0] = np.where(x <= functions[0][1], 1.0, grade[..., 0])
            grade[..., -1] = np.where(x >= functions[-1][1], 1.0, grade[..., -1])
        return grade


@dataclass
class Perceptron:
    """y = W_L tanh(... tanh(W_1 x + b_1) ...) + b_L; layers [(W (out, in), b (out,)), ...]."""

    layers: list[tuple[Array, Array]]

    def __call__(self, x: Array) -> Array:
        for W, b in self.layers[:-1]:
            x = np.tanh(x @ W.T + b)
        W, b = self.layers[-1]
        return x @ W.T + b


def within(u: Array, low: Array, high: Array, fade: float) -> Array:
    """How far a corrector is believed: 1 inside its training range, falling to 0 at `fade` ranges outside."""
    outside = np.maximum(np.maximum(low - u, u - high), 0.0) / (high - low)
    return np.maximum(0.0, 1.0 - outside.max(axis=-1) / fade)


def aided_position(corrector, z: Array, estimated: Array, predicted: Array) -> Array:
    """x(t|t) + corrector(z - x(t|t), x(t|t-1) - x(t|t)) of one axis; where z is missing, x(t|t)."""
    missing = np.isnan(z)
    correction = corrector(np.where(missing, 0.0, z - estimated), predicted - estimated)
    return np.where(missing, estimated, estimated + correction)
