"""Clocks that were set: one step in the order of the file by an hour, a day or 1024 weeks is no disorder.

A clock's step leaves the next position where the target goes on, so the elapsed time without the step is a usual one
and the distance too. Rows that were written by two receivers one after the other do not look so.
"""

from __future__ import annotations

import numpy as np

from .evidence import distances
from .values import short

HOUR, HALF_DAY, DAY, ROLLOVER = 3600.0, 43_200.0, 86_400.0, 1024 * 7 * 86_400.0
WORDS = {
    HOUR: "one hour (summer time?)",
    HALF_DAY: "12 hours (a clock of 12 hours without AM and PM?)",
    DAY: "one day (a date that lags behind midnight?)",
    ROLLOVER: "1024 weeks (GPS)",
}
MOST = 4  # steps in one target: more are interleaved sources


def mend(
    seconds: np.ndarray, codes: np.ndarray, first: np.ndarray, second: np.ndarray, position: str
) -> tuple[np.ndarray, list[str]]:
    """Times without such steps, and notes; (N,) in the order of the file. Later rows of a rollover are right."""
    known = np.flatnonzero(np.isfinite(seconds) & np.isfinite(first) & np.isfinite(second))
    order = known[np.argsort(short(codes[known]), kind="stable")]
    if order.size < 4:
        return seconds, []
    same = np.diff(codes[order]) == 0
    elapsed = np.where(same, np.diff(seconds[order]), np.nan)
    if not (elapsed <= -0.5 * HOUR).any() and not (elapsed >= 0.9 * ROLLOVER).any():
        return seconds, []
    far = distances(first[order], second[order], position)
    out, counts = seconds.copy(), dict.fromkeys(WORDS, 0)
    for code in np.unique(codes[order][1:][same & ((elapsed <= -0.5 * HOUR) | (elapsed >= 0.9 * ROLLOVER))]):
        mine = np.flatnonzero(codes[order] == code)
        shift, moved = _shift(elapsed[mine[:-1]], far[mine[:-1]])
        if shift is not None:
            out[order[mine]] += shift
            counts[moved] += int((shift != 0).sum())
    # rows without a position follow the row before them
    return out, [
        f"the clock steps by {WORDS[size]}: {count} rows are moved by that, so that times go on"
        for size, count in counts.items()
        if count
    ]


def _shift(elapsed: np.ndarray, far: np.ndarray) -> tuple[np.ndarray | None, float]:
    """What is added to each of a target's rows, and the size of the step; None if there is no such step."""
    forward = elapsed[elapsed > 0]
    usual = float(np.median(forward)) if forward.size else 0.0
    near = far <= 5.0 * float(np.quantile(far, 0.9)) + 1e-9
    for size in WORDS:
        low, high = -0.5 * usual, 10.0 * max(usual, 1.0)
        back = near & (elapsed + size >= low) & (elapsed + size <= high)
        forth = near & (elapsed - size >= low) & (elapsed - size <= high)
        if size == ROLLOVER:
            steps = back.astype(float) - forth
        elif back.any():
            # a step forward undoes one back; alone it is a gap
            steps = np.where(back, 1.0, np.where(forth & (np.cumsum(back) > 0), -1.0, 0.0))
        else:
            continue
        if 0 < np.count_nonzero(steps) <= MOST:
            level = np.r_[0.0, np.cumsum(steps)]
            if size == ROLLOVER:
                level -= level.min()
            return level * size, size
    return None, 0.0
