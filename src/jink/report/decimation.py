"""Choose the rows worth drawing, so that every curve of a track keeps its shape.

All series of a track share their rows (a click on the plan view is a time in the charts), so rows are chosen
for all series at once. In the manner of Visvalingam and Whyatt (1993), the row whose removal changes the
curves least goes first:

    d_i = max_s |v_s,i - v_s,i-1 - w (v_s,i+1 - v_s,i-1)|,    w = (t_i - t_i-1) / (t_i+1 - t_i-1)

with the series in units of their own range. What a removed row cost is carried to its neighbours, so that
the sum d_i + carried bounds the error of everything removed around a row. Many rows go per pass (local
minima among the cheaper half), which makes it a handful of vectorised passes over all targets together.
"""

import numpy as np

_END_COST = 1e6  # rows at the ends of a track go last
_BREAK_COST = 1e3  # rows where a series begins, ends or changes part


def keep_rows(
    group: np.ndarray, time: np.ndarray, series: np.ndarray, budget: int, bonus: np.ndarray | None = None
) -> np.ndarray:
    """Sorted indices (<= max(budget, 2 per group)) of the rows to draw.

    group (N,): integer id of the track of each row, contiguous; time (N,): seconds, ascending within a
    group; series (S, N): normalised to a range of about one, NaN where absent; bonus (N,): added to the cost
    of single rows.
    """
    n = time.size
    if n <= budget:
        return np.arange(n)
    missing = np.isnan(series)
    values = np.where(missing, np.float32(0.0), series).astype(np.float32)
    extra = np.zeros(n, dtype=np.float64) if bonus is None else np.asarray(bonus, dtype=np.float64).copy()
    if n > 1:
        change = (missing[:, 1:] != missing[:, :-1]).any(axis=0)
        extra[1:][change] += _BREAK_COST
        extra[:-1][change] += _BREAK_COST
    edge = np.ones(n, dtype=bool)
    edge[1:-1] = (group[1:-1] != group[:-2]) | (group[1:-1] != group[2:])
    extra[edge] += _END_COST

    keep = np.arange(n)
    carried = np.zeros(n)
    while keep.size > budget:
        cost = _removal_cost(keep, time, values) + carried[keep] + extra[keep]
        gone = _cheapest_local_minima(cost, keep.size - budget, _END_COST)
        if gone.size == 0:
            break
        left, right = keep[gone - 1], keep[gone + 1]
        carried[left] = np.maximum(carried[left], cost[gone])
        carried[right] = np.maximum(carried[right], cost[gone])
        keep = np.delete(keep, gone)
    return keep


def _removal_cost(keep: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """d_i of the module's equation for the rows still kept; zero at the two outermost rows."""
    cost = np.zeros(keep.size)
    if keep.size < 3:
        return cost
    t = time[keep]
    span = t[2:] - t[:-2]
    weight = np.where(span > 0, (t[1:-1] - t[:-2]) / np.where(span > 0, span, 1.0), 0.5).astype(np.float32)
    worst = np.zeros(keep.size - 2, dtype=np.float32)
    for row in values:
        v = row[keep]
        np.maximum(worst, np.abs(v[1:-1] - v[:-2] - weight * (v[2:] - v[:-2])), out=worst)
    cost[1:-1] = worst
    return cost


def _cheapest_local_minima(cost: np.ndarray, wanted: int, limit: float) -> np.ndarray:
    """At most `wanted` positions, no two of them adjacent, cheapest first, none costing `limit` or more."""
    inner = cost[1:-1]
    lowest = (inner <= cost[:-2]) & (inner < cost[2:]) & (inner < limit)
    found = np.flatnonzero(lowest) + 1
    if found.size == 0:
        return found
    half = np.median(cost)
    cheap = found[cost[found] <= half]
    found = cheap if cheap.size else found
    if found.size > wanted:
        found = np.sort(found[np.argpartition(cost[found], wanted - 1)[:wanted]])
    return found
