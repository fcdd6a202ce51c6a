"""Does the filter believe what it should? The normalised innovation squared (NIS) against chi-square.

For a linear-Gaussian filter with the right models NIS ~ chi2(nis_dof), so 95 % of it lies between the 2.5 %
and 97.5 % quantiles and its probability integral transform F(NIS) is uniform on (0, 1). For an IMM the NIS
is of the moment-matched innovation, so this is a guide rather than an exact test (Bar-Shalom, Li and
Kirubarajan 2001, section 5.4).
"""

import math

import numpy as np

from ..frozen import frozen
from ..metrics.chi_square import quantile

BINS = 20


@frozen
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
        bands[k] = (quantile(0.025, k), quantile(0.975, k))
        below |= rows & (nis < bands[k][0])
        above |= rows & (nis > bands[k][1])
        edges = [quantile(i / BINS, k) for i in range(1, BINS)]
        histogram += np.bincount(np.searchsorted(edges, nis[rows]), minlength=BINS)

    def count(rows: np.ndarray) -> np.ndarray:
        return np.bincount(target[rows], minlength=targets)

    ratio = float(np.mean(nis[used] / whole[used])) if used.any() else math.nan
    inside = used & ~below & ~above
    return Consistency(count(used), count(inside), count(below), count(above), histogram, ratio, bands)
