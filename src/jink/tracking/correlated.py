"""Whether the errors of positions are correlated in time, from the positions themselves.

Third differences of every row, of every second row, of every fourth ... cancel motion and leave noise (`scatter`).
White noise gives the same sd at every spacing, and motion gives one that more than doubles with each. Errors of GPS,
which wander over some seconds, give one that grows and then stays: from there on they are independent.
"""

from __future__ import annotations

import numpy as np

from .scatter import MEDIAN, grouped_quantile, third_differences

SPACINGS = (1, 2, 4, 8, 16, 32)
LEAST = 40  # differences of one spacing
FLAT = 1.35  # two spacings have the same sd
STEEP = 2.5  # times the sd at half the spacing: motion grows faster, by 2.8 for white accelerations and 8 in circles
GROWN = 2.0  # times the sd of successive rows


def correlated_errors(
    time: np.ndarray, plane: np.ndarray, target: np.ndarray, targets: int
) -> tuple[np.ndarray, np.ndarray]:
    """The sd (m) of the errors of each target, and the seconds over which they are correlated; NaN where they are not.

    time (N,) s, plane (N, 2) m, target (N,) numbers the targets, whose rows stand together.
    """
    starts = np.flatnonzero(np.diff(target, prepend=-1))
    within = np.arange(time.size) - np.repeat(starts, np.diff(np.r_[starts, time.size]))
    levels = []
    for spacing in SPACINGS:
        some = within % spacing == 0
        new = np.diff(target[some], prepend=-1) != 0
        difference, index = third_differences(time[some], plane[some], new)
        of = np.repeat(target[some][index], 2)
        levels.append(MEDIAN * grouped_quantile(np.abs(difference).ravel(), of, targets, 0.5, least=2 * LEAST))
    level = np.array(levels)
    sd, seconds = np.full(targets, np.nan), np.full(targets, np.nan)
    step = grouped_quantile(np.diff(time, prepend=np.nan), target, targets, 0.5)
    with np.errstate(invalid="ignore"):
        for k in range(2, len(SPACINGS) - 1):
            ratio = level[k + 1] / level[k]
            slow = (level[1 : k + 1] / level[:k]).max(axis=0) < STEEP
            flat = slow & (ratio < FLAT) & (ratio > 1.0 / FLAT) & (level[k] > GROWN * level[0]) & np.isnan(sd)
            sd[flat], seconds[flat] = level[k + 1][flat], SPACINGS[k] * step[flat]
    return sd, seconds
