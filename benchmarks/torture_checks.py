"""What must be 0 in ``python -m benchmarks.torture``, counted on estimates."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from jink.estimate import Status

MUST_BE_NONE = ("non-finite", "indefinite", "off one", "lost", "restored otherwise")
ROUNDING = 1e-12  # of a correlation matrix's smallest eigenvalue, as tests/support/subjects.py has it
OFF_ONE = 1e-9


def checked(estimate: Any, rows: int) -> Counter[str]:
    """Counts of the rows of one estimate."""
    status = np.asarray(estimate.status).reshape(-1)
    found = Counter(updates=int(rows), lost=abs(rows - status.size) + abs(rows - len(estimate.x)))
    at = status > 0
    x, P, mu = estimate.x[at], estimate.P[at], estimate.mode_probability[at]
    finite = np.isfinite(x).all(axis=1) & np.isfinite(P).all(axis=(1, 2))
    if "log_likelihood_scan" in estimate.results:
        finite &= np.isfinite(estimate.log_likelihood_scan[at])
    found["non-finite"] = int((~finite).sum())
    found["indefinite"] = indefinite(P[finite])
    wrong = ~(np.abs(mu.sum(axis=1) - 1.0) < OFF_ONE) | ~((mu >= 0.0) & (mu <= 1.0 + OFF_ONE)).all(axis=1)
    found["off one"] = int(wrong.sum())
    return found


def lost(status: np.ndarray, time: np.ndarray, coast: float | None) -> int:
    """Rows without an estimate after their track's start, (tracks, scans) each.

    A filter with ``coast`` drops a track so many seconds after the last row that it believed, as documented: such rows
    are not lost.
    """
    there = status > 0
    missing = np.maximum.accumulate(there, axis=1) & ~there
    believed = there & ~np.isin(status, (Status.predicted, Status.gated))
    last = np.maximum.accumulate(np.where(believed, time, -np.inf), axis=1)
    return int((missing & (time - last <= (coast or np.inf))).sum())


def indefinite(P: np.ndarray) -> int:
    """How many covariances have a correlation matrix with an eigenvalue below minus rounding, or are not symmetric.

    A Cholesky factor of all of them at once says that there is none; eigenvalues are taken where it fails.
    """
    if not len(P):
        return 0
    variance = np.einsum("kii->ki", P)
    sd = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    scaled = P / sd[:, :, None] / sd[:, None, :]
    skew = np.abs(scaled - scaled.transpose(0, 2, 1)).max(axis=(1, 2)) > ROUNDING
    bad = skew | (variance < 0.0).any(axis=1)
    try:
        np.linalg.cholesky(scaled + ROUNDING * np.eye(P.shape[1]))
    except np.linalg.LinAlgError:
        bad |= np.linalg.eigvalsh(scaled).min(axis=1) < -ROUNDING
    return int(bad.sum())
