"""Squared errors over covariances for whole chunks of runs at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..checks import Array


def mahalanobis(error: Array, P: Array, index: Sequence[int]) -> tuple[Array, Array]:
    """eᵀ P⁻¹ e and ln det P, both (...), for errors (..., k) and the rows and columns `index` of P (..., n, n).

    P = L D Lᵀ column by column, vectorised over the leading axes; NaN where P is not positive definite.
    """
    k = len(index)
    lower: dict[tuple[int, int], Array] = {}
    pivots: list[Array] = []
    rest: list[Array] = []
    square, log_det = np.zeros(error.shape[:-1]), np.zeros(error.shape[:-1])
    with np.errstate(invalid="ignore", divide="ignore"):
        for j in range(k):
            pivot, left = P[..., index[j], index[j]], error[..., j]
            for m in range(j):
                pivot = pivot - lower[j, m] ** 2 * pivots[m]
                left = left - lower[j, m] * rest[m]
            pivot = np.where(pivot > 0, pivot, np.nan)
            for i in range(j + 1, k):
                value = P[..., index[i], index[j]]
                for m in range(j):
                    value = value - lower[i, m] * lower[j, m] * pivots[m]
                lower[i, j] = value / pivot
            pivots.append(pivot)
            rest.append(left)
            square += left * left / pivot
            log_det += np.log(pivot)
    return square, log_det
