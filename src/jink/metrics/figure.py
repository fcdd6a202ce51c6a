"""A figure from Monte Carlo runs and how sure it is.

Scans of one run are correlated and runs are not, so every standard error comes from the spread over runs:
the delta method where the figure is smooth in per-run sums, a jackknife over groups of runs where it is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..checks import Array

GROUPS = 20  # of runs, for the jackknife


def present(values: Array, trailing: int) -> NDArray[np.bool_]:
    """Where all along the last ``trailing`` axes is finite."""
    finite = np.isfinite(values)
    return np.logical_and.reduce(finite, axis=tuple(range(finite.ndim - trailing, finite.ndim)))


class Figure(NamedTuple):
    """A value and its standard error; NaN where there is nothing to take it from (one run has no error)."""

    value: float
    se: float


def ratio_influence(total: Array, count: Array) -> tuple[float, Array]:
    """q = Σ total / Σ count over runs, and each run's influence (total − q count) / mean count; all (runs,)."""
    weight = count.sum()
    if not weight > 0:
        return math.nan, np.full(len(total), math.nan)
    q = float(total.sum() / weight)
    return q, (total - q * count) / count.mean()


def spread(influence: Array) -> float:
    """Standard error of a figure whose runs have these influences: sd / √runs."""
    return float(influence.std(ddof=1) / math.sqrt(len(influence))) if len(influence) > 1 else math.nan


def ratio(total: Array, count: Array) -> Figure:
    """Σ total / Σ count over runs with its standard error (delta method for a ratio)."""
    q, influence = ratio_influence(total, count)
    return Figure(q, spread(influence))


def mean_over_runs(values: Array) -> Figure:
    """Mean of values (runs, scans, ...) that are not NaN; standard error over runs."""
    there = np.isfinite(values)
    axes = tuple(range(1, values.ndim))
    return ratio(np.where(there, values, 0.0).sum(axis=axes), there.sum(axis=axes).astype(float))


def jackknife(figure: Callable[..., float], *arrays: Array, groups: int = GROUPS) -> Figure:
    """figure(*arrays) with the delete-a-group jackknife's standard error, groups along the first axis (runs).

    se² = (g − 1)/g Σ (θ₍ᵢ₎ − mean θ₍·₎)². Source: Efron & Tibshirani 1993, ch. 11.
    """
    runs = len(arrays[0])
    g = min(groups, runs)
    value = float(figure(*arrays))
    if g < 2:
        return Figure(value, math.nan)
    member = np.arange(runs) % g
    without = np.array([figure(*(a[member != i] for a in arrays)) for i in range(g)], dtype=float)
    with np.errstate(invalid="ignore"):
        se = math.sqrt((g - 1) / g * float(((without - without.mean()) ** 2).sum()))
    return Figure(value, se)


def student_quantile(p: float, dof: float) -> float:
    """Quantile of Student's t by its expansion around the normal one; error below 1% from dof 4.

    t = z + (z³ + z)/4ν + (5z⁵ + 16z³ + 3z)/96ν² + (3z⁷ + 19z⁵ + 17z³ − 15z)/384ν³.
    Source: Abramowitz & Stegun 26.7.5.
    """
    z = NormalDist().inv_cdf(p)
    first = (z**3 + z) / (4 * dof)
    second = (5 * z**5 + 16 * z**3 + 3 * z) / (96 * dof**2)
    return z + first + second + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * dof**3)
