"""Which estimates to take at their word when looking for an extreme: not first guesses, not long coasting."""

import numpy as np
import polars as pl

from ..estimate import Status
from .rows import TrackRows

_TIMES = 2.0
_QUANTILE = 0.9  # not the median: a manoeuvre's sds are several times those of straight motion, and count


def settled(value: np.ndarray, sd: np.ndarray, rows: TrackRows) -> np.ndarray:
    """(N,) bool: a number, its sd at most twice the 90 % quantile of the target's sds at updates."""
    updated = rows.status == Status.updated
    limit = _TIMES * group_quantile(sd[updated], rows.target[updated], len(rows.names), _QUANTILE)
    return np.isfinite(value) & ~(sd > limit[rows.target])


def group_quantile(values: np.ndarray, group: np.ndarray, groups: int, quantile: float = 0.5) -> np.ndarray:
    """Quantile per group (groups,) of the finite values, NaN where a group has none."""
    finite = np.isfinite(values)
    table = pl.DataFrame({"group": group[finite], "value": values[finite]})
    found = table.group_by("group").agg(pl.col("value").quantile(quantile, "linear"))
    out = np.full(groups, np.nan)
    out[found["group"].to_numpy()] = found["value"].to_numpy()
    return out
