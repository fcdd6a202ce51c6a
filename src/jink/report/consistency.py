"""Does the filter believe what it should? The normalised innovation squared (NIS) against chi-square.

For a linear-Gaussian filter with the right models NIS ~ chi2(nis_dof), so 95 % of it lies between the 2.5 %
and 97.5 % quantiles and its probability integral transform F(NIS) is uniform on (0, 1). For an IMM the NIS
is of the moment-matched innovation, so this is a guide rather than an exact test (Bar-Shalom, Li and
Kirubarajan 2001, section 5.4).
"""

import math
from dataclasses import dataclass

import numpy as np

BINS = 20


def chi2_cdf(x: float, dof: int) -> float:
    """F(x) of the chi-square distribution with integer dof >= 1.

    P(a + 1, y) = P(a, y) - y^a e^-y / Gamma(a + 1) from P(1/2, y) = erf(sqrt y) or P(1, y) = 1 - e^-y, at y
    = x / 2.
    """
    if x <= 0:
        return 0.0
    y = 0.5 * x
    a, value = (1.0, -math.expm1(-y)) if dof % 2 == 0 else (0.5, math.erf(math.sqrt(y)))
    while a < 0.5 * dof - 0.25:
        value -= math.exp(a * math.log(y) - y - math.lgamma(a + 1.0))
        a += 1.0
    return min(max(value, 0.0), 1.0)


def chi2_quantile(p: float, dof: int) -> float:
    """x with F(x) = p, 0 < p < 1, by bisection to the last bit or so."""
    if not 0.0 < p < 1.0:
        raise ValueError(f"p = {p}: expected a probability strictly between 0 and 1")
    low, high = 0.0, float(max(dof, 1))
    while chi2_cdf(high, dof) < p:
        low, high = high, 2.0 * high
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if chi2_cdf(middle, dof) < p else (low, middle)
    return 0.5 * (low + high)


@dataclass(frozen=True)
class Consistency:
    """Counts over compared rows, overall and per target.

    compared, inside, below, above (T,): rows per target; histogram (BINS,): rows by F(NIS), uniform when
    consistent; mean_ratio: mean of NIS / nis_dof, one when consistent; bands {dof: (low, high)}.
    """

    compared: np.ndarray
    inside: np.ndarray
    below: np.ndarray
    above: np.ndarray
    histogram: np.ndarray
    mean_ratio: float
    bands: dict[int, tuple[float, float]]


def consistency(
    target: np.ndarray, targets: int, nis: np.ndarray, dof: np.ndarray, accepted: np.ndarray
) -> Consistency:
    """NIS against its 95 % band. target (N,) < targets; accepted (N,) bool: rows that updated the filter."""
    whole = np.where(np.isfinite(dof), np.round(dof), 0).astype(np.int64)
    used = np.asarray(accepted, dtype=bool) & np.isfinite(nis) & (whole > 0)
    below = np.zeros(nis.size, dtype=bool)
    above = np.zeros(nis.size, dtype=bool)
    histogram = np.zeros(BINS, dtype=np.int64)
    bands: dict[int, tuple[float, float]] = {}
    for k in (int(d) for d in np.unique(whole[used])):
        rows = used & (whole == k)
        bands[k] = (chi2_quantile(0.025, k), chi2_quantile(0.975, k))
        below |= rows & (nis < bands[k][0])
        above |= rows & (nis > bands[k][1])
        edges = [chi2_quantile(i / BINS, k) for i in range(1, BINS)]
        histogram += np.bincount(np.searchsorted(edges, nis[rows]), minlength=BINS)

    def count(rows: np.ndarray) -> np.ndarray:
        return np.bincount(target[rows], minlength=targets)

    ratio = float(np.mean(nis[used] / whole[used])) if used.any() else math.nan
    inside = used & ~below & ~above
    return Consistency(count(used), count(inside), count(below), count(above), histogram, ratio, bands)
