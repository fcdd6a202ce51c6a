"""Is one filter better than another? Said only where the paired interval excludes no difference."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, by_hints
from ..frozen import frozen
from .errors import as_error, rmse_influence
from .figure import Figure, mean_over_runs, present, spread, student_quantile


@frozen
class Comparison:
    """Two filters on the same runs.

    difference: first minus second, with its standard error and the interval low … high.
    """

    difference: float
    se: float
    low: float
    high: float
    lower_is_better: bool = True

    @property
    def verdict(self) -> Literal["better", "worse", "undecided"]:
        """What the first is, if the interval excludes zero."""
        if self.low > 0:
            return "worse" if self.lower_is_better else "better"
        if self.high < 0:
            return "better" if self.lower_is_better else "worse"
        return "undecided"


@by_hints
def paired(difference: float, influence: Array, *, level: float = 0.95, lower_is_better: bool = True) -> Comparison:
    """The comparison whose difference the runs influence so, (runs,): difference ± t sd(influence)/√runs."""
    se = spread(influence)
    half = student_quantile(0.5 + level / 2, len(influence) - 1) * se if len(influence) > 1 else math.nan
    return Comparison(difference, se, difference - half, difference + half, lower_is_better)


@by_hints
def compare_rmse(a: ArrayLike, b: ArrayLike, *, first: int = 0, level: float = 0.95) -> Comparison:
    """RMSE of errors a minus RMSE of errors b, (runs, scans, n) of the same runs (common random numbers).

    Var(RMSE_a − RMSE_b) by the delta method on each run's pair of mean squares: its influence is
    dᵣ = (sₐᵣ − RMSE_a²)/(2 RMSE_a) − (s_bᵣ − RMSE_b²)/(2 RMSE_b), se = sd(d)/√runs, interval ± t₀.₉₇₅(runs −
    1) se. Scans where either has no error are left out of both. Errors: ValueError for different runs or
    scans.
    """
    (va, ia), (vb, ib) = _paired_rmse(a, b, first)
    return paired(va - vb, ia - ib, level=level)


@by_hints
def efficiency(error: ArrayLike, reference_error: ArrayLike, *, first: int = 0) -> Figure:
    """RMSE of a filter over that of the reference on the same runs: 1.00 leaves nothing to gain.

    q = RMSE / RMSE_ref; se from each run's influence iᵣ/RMSE_ref − q i_refᵣ/RMSE_ref (delta method, paired).
    """
    (va, ia), (vb, ib) = _paired_rmse(error, reference_error, first)
    return Figure(va / vb, spread((ia - va / vb * ib) / vb)) if vb > 0 else Figure(math.nan, math.nan)


def _paired_rmse(a: ArrayLike, b: ArrayLike, first: int) -> list[tuple[float, Array]]:
    """RMSE and influences of both, over the scans where both have an error."""
    ea, eb = as_error(a, "a"), as_error(b, "b")
    if ea.shape[:2] != eb.shape[:2]:
        raise ValueError(f"b: expected the runs and scans of a, {ea.shape[:2]}, got {eb.shape[:2]}")
    both = present(ea, 1) & present(eb, 1)
    return [rmse_influence(np.where(both[..., None], e, np.nan), first) for e in (ea, eb)]


@by_hints
def compare_means(a: ArrayLike, b: ArrayLike, *, level: float = 0.95, lower_is_better: bool = True) -> Comparison:
    """Mean of a minus mean of b, (runs, scans), paired over runs; NaN in either is left out.

    For log scores, NEES, Euclidean errors. Errors: ValueError for different shapes.
    """
    x, y = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if x.shape != y.shape or x.ndim < 1:
        raise ValueError(f"b: expected the shape of a, {x.shape}, got {y.shape}")
    d = (x - y).reshape(len(x), -1)
    there = np.isfinite(d)
    figure = mean_over_runs(np.where(there, d, np.nan))
    total, count = np.where(there, d, 0.0).sum(axis=1), there.sum(axis=1)
    influence = (total - figure.value * count) / count.mean() if count.any() else np.full(len(x), math.nan)
    return paired(figure.value, influence, level=level, lower_is_better=lower_is_better)
