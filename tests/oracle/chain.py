"""Mode switching: the Markov chain over a step of any length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, logm

Array = NDArray[np.float64]


class PerScan:
    """Transition matrix (or stay probability) once per scan, or, with its reference step T, to the power
    dt/T.
    """

    def __init__(self, transition, modes: int, step: float | None = None):
        matrix = np.asarray(transition, float)
        if matrix.ndim == 0:
            stay = float(matrix)
            matrix = np.full((modes, modes), (1 - stay) / max(modes - 1, 1))
            np.fill_diagonal(matrix, stay if modes > 1 else 1.0)
        self.matrix, self.step = matrix, step
        self.generator = logm(matrix).real / step if step is not None else None

    def over(self, dt: float) -> Array:
        if dt == 0:
            return np.eye(len(self.matrix))
        return self.matrix if self.generator is None else expm(self.generator * dt)

    def stationary(self) -> Array:
        return stationary(self.matrix)


class Sojourn:
    """Mean stay of each mode in seconds; `to[i, j]`: where a stay in i ends (uniform over the others by
    default).
    """

    def __init__(self, seconds, to=None):
        seconds = np.asarray(seconds, float)
        M = len(seconds)
        to = (np.ones((M, M)) - np.eye(M)) / max(M - 1, 1) if to is None else np.asarray(to, float)
        self.generator = (to - np.eye(M)) / seconds[:, None]
        if M == 1:
            self.generator = np.zeros((1, 1))

    def over(self, dt: float) -> Array:
        return expm(self.generator * dt)

    def stationary(self) -> Array:
        return stationary(expm(self.generator * 1.0))


def stationary(matrix: Array) -> Array:
    """p with p Pi = p and sum 1."""
    M = len(matrix)
    A = np.vstack([matrix.T - np.eye(M), np.ones((1, M))])
    return np.linalg.lstsq(A, np.r_[np.zeros(M), 1.0], rcond=None)[0]
