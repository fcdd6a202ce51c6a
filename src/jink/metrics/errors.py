"""How large the errors are.

Errors are (runs, scans, n): estimate minus truth in n components (axes), NaN where there is none.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, by_hints
from .figure import Figure, jackknife, mean_over_runs, ratio_influence, spread


def as_error(error: ArrayLike, name: str = "error") -> Array:
    """Errors as an array (runs, scans, n). Errors: ValueError for another shape."""
    e = np.asarray(error, dtype=float)
    if e.ndim != 3 or not len(e):
        raise ValueError(f"{name}: expected (runs, scans, n) with at least one run, got {e.shape}")
    return e


def squared(error: ArrayLike, first: int = 0) -> Array:
    """|e|² (runs, scans − first), NaN where any component is missing."""
    return sum_of_squares(as_error(error)[:, first:])


def sum_of_squares(values: Array) -> Array:
    """Over the last axis, which is short: component by component, several times as fast as ``sum(axis=-1)``."""
    total = np.zeros(values.shape[:-1])
    for k in range(values.shape[-1]):
        total += values[..., k] ** 2
    return total


def _sums(square: Array) -> tuple[Array, Array]:
    there = np.isfinite(square)
    return np.where(there, square, 0.0).sum(axis=1), there.sum(axis=1).astype(float)


def rmse_influence(error: ArrayLike, first: int = 0) -> tuple[float, Array]:
    """RMSE and each run's influence on it, (runs,): of the mean square, divided by 2 RMSE."""
    mean_square, influence = ratio_influence(*_sums(squared(error, first)))
    value = math.sqrt(mean_square)
    return value, influence / (2 * value) if value > 0 else np.zeros_like(influence)


@by_hints
def rmse(error: ArrayLike, *, first: int = 0) -> Figure:
    """Root mean square error over runs and scans ≥ first, all components together.

    RMSE = √(Σᵣₖ |eᵣₖ|² / Σᵣₖ 1);  se = sd over runs of the run's mean square / (2 RMSE √runs). Unit of the error.
    Source: Li & Zhao, "Evaluation of estimation algorithms, part I", IEEE Trans. AES 42(4), 2006.
    """
    value, influence = rmse_influence(error, first)
    return Figure(value, spread(influence))


@by_hints
def rmse_over_time(error: ArrayLike) -> tuple[Array, Array]:
    """RMSE of every scan, √(mean over runs of |e|²), and its standard error; both (scans,), NaN without errors."""
    square = squared(error)
    there = np.isfinite(square)
    count = there.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(there, square, 0.0).sum(axis=0) / count
        variance = np.where(there, (square - mean) ** 2, 0.0).sum(axis=0) / (count - 1)
        value = np.sqrt(mean)
        se = np.where(value > 0, np.sqrt(variance / count) / (2 * value), np.where(count > 1, 0.0, np.nan))
    return value, se


@by_hints
def mean_euclidean(error: ArrayLike, *, first: int = 0) -> Figure:
    """Mean of |e| over runs and scans ≥ first: less ruled by the largest errors than RMSE.

    Source: Li & Zhao, IEEE Trans. AES 42(4), 2006 (average Euclidean error).
    """
    return mean_over_runs(np.sqrt(squared(error, first)))


@by_hints
def quantile(error: ArrayLike, q: float, *, first: int = 0) -> Figure:
    """Quantile of |e| over runs and scans ≥ first (0.5: the median); jackknife over runs."""
    return jackknife(
        lambda s: math.sqrt(np.nanquantile(s, q)) if np.isfinite(s).any() else math.nan, squared(error, first)
    )


@by_hints
def trimmed_rmse(error: ArrayLike, *, share: float = 0.01, first: int = 0) -> Figure:
    """RMSE without the worst ``share`` of all errors (over runs and scans ≥ first); jackknife over runs."""
    if not 0 <= share < 1:
        raise ValueError(f"share: expected at least 0 and below 1, got {share!r}")

    def trimmed(square: Array) -> float:
        values = np.sort(square[np.isfinite(square)])
        kept = values[: len(values) - math.floor(share * len(values))]
        return math.sqrt(kept.mean()) if len(kept) else math.nan

    return jackknife(trimmed, squared(error, first))


@by_hints
def measured_velocity(z: ArrayLike, time: ArrayLike) -> Array:
    """Backward differences of positions, (zₖ − zₖ₋₁)/(tₖ − tₖ₋₁), (runs, scans, axes).

    z (runs, scans, axes) at time (scans,) or (runs, scans); NaN in the first scan and beside missing measurements.
    Source: Lee, Joo & Park 2003 (their measured velocity).
    """
    z = as_error(z, "z")
    dt = np.broadcast_to(np.diff(np.asarray(time, dtype=float)), (z.shape[0], z.shape[1] - 1))
    velocity = np.full_like(z, np.nan)
    velocity[:, 1:] = np.diff(z, axis=1) / dt[..., None]
    return velocity


@by_hints
def normalised_error(error: ArrayLike, measurement_error: ArrayLike, *, first: int = 2) -> Figure:
    """lee-2003's ζ: RMS error of the estimate over that of the measurement, scan by scan, averaged.

    ζ = meanₖ √(Σᵣ |eᵣₖ|² / Σᵣ |nᵣₖ|²), scans ≥ first, over the runs that have both; axes pooled. 1: as bad as
    measuring. se: from each run's influence, meanₖ ζₖ/2 (aᵣₖ/aₖ − bᵣₖ/bₖ). Source: Lee, Joo & Park 2003.
    """
    a, b = squared(error, first), squared(measurement_error, first)
    if a.shape != b.shape:
        raise ValueError(f"measurement_error: expected the runs and scans of error, {a.shape}, got {b.shape}")
    both = np.isfinite(a) & np.isfinite(b)
    used = both.any(axis=0)
    if not used.any():
        return Figure(math.nan, math.nan)
    a, b = np.where(both, a, 0.0)[:, used], np.where(both, b, 0.0)[:, used]
    mean_a, mean_b = a.mean(axis=0), b.mean(axis=0)
    scan = np.sqrt(mean_a / mean_b)
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = np.where(mean_a > 0, (a - mean_a) / mean_a, 0.0) - (b - mean_b) / mean_b
    return Figure(float(scan.mean()), spread((scan / 2 * relative).mean(axis=1)))


@by_hints
def lost(position_error: ArrayLike, limit: float, *, scans: int = 5) -> Figure:
    """Share of runs whose track is lost: |e| > limit (m) in at least ``scans`` scans one after the other.

    se = √(p (1 − p)/runs). A missing estimate after the first one counts as beyond the limit.
    Source: a distance from the truth, as in Blair, Watson, Kirubarajan & Bar-Shalom 1998.
    """
    if not limit > 0 or int(scans) != scans or scans < 1:
        raise ValueError(
            f"limit and scans: expected a number above 0 and a whole number from 1, got {limit!r} and {scans!r}"
        )
    square = squared(position_error)
    begun = np.maximum.accumulate(np.isfinite(square), axis=1)
    far = begun & ~(square <= limit * limit)
    run = np.zeros(len(far), dtype=int)
    gone = np.zeros(len(far), dtype=bool)
    for k in range(far.shape[1]):
        run = np.where(far[:, k], run + 1, 0)
        gone |= run >= scans
    p = float(gone.mean())
    return Figure(p, math.sqrt(p * (1 - p) / len(gone)))
