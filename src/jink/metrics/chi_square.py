"""Quantiles of the chi-square distribution, without SciPy."""

from __future__ import annotations

import math
from functools import lru_cache
from statistics import NormalDist

LARGE = 2000  # degrees of freedom from which the normal approximation of the cube root is used


def cdf(x: float, dof: int) -> float:
    """P(χ²(dof) ≤ x), from erf (odd dof) or exp (even dof).

    P(a + 1, y) = P(a, y) − yᵃ e⁻ʸ/Γ(a + 1), y = x/2, up to a = dof/2.
    """
    if x <= 0:
        return 0.0
    y = x / 2
    a, value = (1.0, -math.expm1(-y)) if dof % 2 == 0 else (0.5, math.erf(math.sqrt(y)))
    while a < dof / 2 - 0.25:
        value -= math.exp(a * math.log(y) - y - math.lgamma(a + 1))
        a += 1
    return min(max(value, 0.0), 1.0)


def wilson_hilferty(p: float, dof: float) -> float:
    """x with P(χ²(dof) ≤ x) ≈ p for any dof: ν (1 − 2/9ν + z √(2/9ν))³, z the normal quantile (Wilson & Hilferty
    1931).
    """
    return dof * (1 - 2 / (9 * dof) + NormalDist().inv_cdf(p) * math.sqrt(2 / (9 * dof))) ** 3


@lru_cache(maxsize=4096)
def quantile(p: float, dof: int) -> float:
    """x with P(χ²(dof) ≤ x) = p: bisection, for large dof an approximation (error < 1e-5 x).

    From 2000 degrees of freedom that of :func:`wilson_hilferty`.
    Errors: ValueError unless 0 < p < 1 and dof is a whole number from 1.
    """
    if not 0 < p < 1 or dof < 1 or int(dof) != dof:
        raise ValueError(f"p and dof: expected a probability and a whole number from 1, got {p!r} and {dof!r}")
    start = wilson_hilferty(p, dof)
    if dof >= LARGE:
        return start
    low, high = 0.0, max(2 * start, 1.0)
    while cdf(high, dof) < p:
        low, high = high, 2 * high
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (middle, high) if cdf(middle, dof) < p else (low, middle)
    return middle


def band(dof: int, level: float = 0.95) -> tuple[float, float]:
    """The central interval that holds ``level`` of χ²(dof)."""
    return quantile((1 - level) / 2, dof), quantile((1 + level) / 2, dof)
