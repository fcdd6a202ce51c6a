"""Does a filter know how wrong it is? Squared errors over covariances, and log scores."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, by_hints
from ..frozen import frozen
from .chi_square import band
from .errors import as_error
from .figure import Figure, mean_over_runs, present, ratio


@frozen
class Consistency:
    """Normalised squared errors against χ².

    mean: per degree of freedom, 1 when consistent; inside: share of single values in their own central
    interval, ``level`` when consistent; per scan: average over runs (scans,) with the band low, high
    (scans,) it should lie in; scans_inside: share of scans where it does.
    """

    mean: Figure
    inside: Figure
    average: Array
    low: Array
    high: Array
    scans_inside: float


@by_hints
def nees(error: ArrayLike, P: ArrayLike) -> Array:
    """Normalised estimation error squared eᵀ P⁻¹ e, (runs, scans).

    error (runs, scans, n), P (runs, scans, n, n); NaN where anything is missing or P is not positive definite.
    Errors: ValueError for other shapes. Source: Bar-Shalom, Li & Kirubarajan 2001, §5.4.
    """
    return _decompose(error, P)[0]


def _decompose(error: ArrayLike, P: ArrayLike) -> tuple[Array, Array]:
    """eᵀ P⁻¹ e and ln det P, NaN where missing or P is not positive definite."""
    e, cov = as_error(error), np.asarray(P, dtype=float)
    n = e.shape[2]
    if cov.shape != (*e.shape, n):
        raise ValueError(f"P: expected {(*e.shape, n)} for errors {e.shape}, got {cov.shape}")
    there = present(e, 1) & present(cov, 2)
    scale = np.sqrt(np.where(there[..., None], np.maximum(np.diagonal(cov, axis1=2, axis2=3), 0.0), 1.0))
    there &= scale.min(axis=2) > 0
    scale = np.where(there[..., None], scale, 1.0)
    correlation = np.where(there[..., None, None], cov / (scale[..., :, None] * scale[..., None, :]), np.eye(n))
    sign, log_det = np.linalg.slogdet(correlation)
    there &= (sign > 0) & np.isfinite(log_det)
    correlation = np.where(there[..., None, None], correlation, np.eye(n))
    u = np.where(there[..., None], e / scale, 0.0)
    value = (u * np.linalg.solve(correlation, u[..., None])[..., 0]).sum(axis=2)
    log_det = np.where(there, log_det, 0.0) + 2 * np.log(scale).sum(axis=2)
    return np.where(there, value, np.nan), np.where(there, log_det, np.nan)


@by_hints
def consistency(squares: ArrayLike, dof: ArrayLike, *, first: int = 0, level: float = 0.95) -> Consistency:
    """NEES or NIS (runs, scans) against χ² with dof degrees of freedom, a number or (runs, scans).

    NaN and dof 0 are left out. The average over a scan's runs, times runs, is χ²(Σ dof): its band is the central
    interval of that, over runs. Source: Bar-Shalom, Li & Kirubarajan 2001, §5.4.
    """
    s = np.asarray(squares, dtype=float)
    if s.ndim != 2:
        raise ValueError(f"squares: expected (runs, scans), got {s.shape}")
    s = s[:, first:]
    d = np.broadcast_to(np.asarray(dof, dtype=float), np.shape(squares))[:, first:]
    there = np.isfinite(s) & np.isfinite(d) & (d > 0)
    s, whole = np.where(there, s, 0.0), np.where(there, np.rint(np.where(there, d, 0)), 0).astype(int)
    inside = np.zeros(s.shape, dtype=bool)
    for k in np.unique(whole[there]):
        low, high = band(int(k), level)
        inside |= there & (whole == k) & (s >= low) & (s <= high)
    runs, freedom = there.sum(axis=0), whole.sum(axis=0)
    bands = np.array([band(int(f), level) if f else (math.nan, math.nan) for f in freedom]).reshape(-1, 2)
    with np.errstate(invalid="ignore", divide="ignore"):
        average, low, high = s.sum(axis=0) / runs, bands[:, 0] / runs, bands[:, 1] / runs
    used = runs > 0
    within = (average >= low) & (average <= high)
    return Consistency(
        mean=ratio(s.sum(axis=1), whole.sum(axis=1).astype(float)),
        inside=ratio(inside.sum(axis=1).astype(float), there.sum(axis=1).astype(float)),
        average=np.where(used, average, np.nan),
        low=low,
        high=high,
        scans_inside=float(within[used].mean()) if used.any() else math.nan,
    )


@by_hints
def log_density(error: ArrayLike, P: ArrayLike) -> Array:
    """ln N(e; 0, P) = −½ (eᵀ P⁻¹ e + ln det P + n ln 2π), (runs, scans); NaN where missing."""
    square, log_det = _decompose(error, P)
    return -0.5 * (square + log_det + np.shape(error)[2] * math.log(2 * math.pi))


@by_hints
def log_score(error: ArrayLike, P: ArrayLike, *, first: int = 0) -> Figure:
    """Mean log density of the truth under the estimate, taken as Gaussian: the higher the better.

    Source: Gneiting & Raftery, J. Amer. Stat. Assoc. 102, 2007 (logarithmic score).
    """
    return mean_over_runs(log_density(error, P)[:, first:])


@by_hints
def prediction_score(log_likelihood_scan: ArrayLike, *, first: int = 0, counted: ArrayLike | None = None) -> Figure:
    """Mean log density of the next measurement, ln p(z_k | z_0 … z_{k−1}), (runs, scans): high is good.

    counted (runs, scans) bool: scans to score (those with an accepted measurement), by default all that are
    not NaN. Source: Gneiting & Raftery 2007; the mean of the filter's log-likelihood.
    """
    values = np.asarray(log_likelihood_scan, dtype=float)
    if counted is not None:
        values = np.where(np.asarray(counted, dtype=bool), values, np.nan)
    return mean_over_runs(values[:, first:])
