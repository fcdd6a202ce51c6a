"""Heights that cannot be: a few in a row that are left for, and come back from, faster than the target can climb.

The heights of a part are cut where one differs from the one before by more than `LEAST`, and by more than climbing at
`CLIMB` of the kind's fastest speed allows, with `SLACK` seconds in doubt. Between two cuts a stretch is wrong if it is
shorter than `LONGEST`, has fewer rows than the stretches before and after, and these two agree with each other.
"""

from __future__ import annotations

import numpy as np

LEAST = 300.0  # m: smaller jumps are for the filter's gate
CLIMB = 0.4  # of the fastest speed: 120 m/s of an aircraft
SLACK = 2.0  # s by which two time stamps may be wrong together
LONGEST = 60.0  # s


def impossible_heights(time: np.ndarray, height: np.ndarray, new: np.ndarray, fastest: float) -> tuple[np.ndarray, int]:
    """Rows (N,) whose height cannot be, and how many jumps are left, of which one side is wrong and nothing says which.

    time (N,) s, height (N,) m, NaN: none, new (N,) first rows of parts.
    """
    bad = np.zeros(time.size, bool)
    known = np.flatnonzero(np.isfinite(height))
    if known.size < 2:
        return bad, 0
    parts = np.cumsum(new)
    part = parts[known]
    cut = _cuts(time[known], height[known], part, fastest)
    # most parts have none, and are not looked at again
    asked = np.zeros(part[-1] + 1, bool)
    asked[part[1:][cut]] = True
    inside = asked[part]
    if not inside.any():
        return bad, 0
    known, part = known[inside], part[inside]
    cut = _cuts(time[known], height[known], part, fastest)
    bad[known] = _wrong(time[known], height[known], part, cut, fastest)
    good = known[~bad[known]]
    return bad, int(_cuts(time[good], height[good], parts[good], fastest).sum())


def _cuts(t: np.ndarray, h: np.ndarray, part: np.ndarray, fastest: float) -> np.ndarray:
    """Where a height is too far from the one before it in its part (N - 1,)."""
    return (part[1:] == part[:-1]) & _apart(h[:-1], h[1:], t[1:] - t[:-1], fastest)


def _wrong(t: np.ndarray, h: np.ndarray, part: np.ndarray, cut: np.ndarray, fastest: float) -> np.ndarray:
    """The rows of stretches between two cuts that are wrong (N,)."""
    first = np.flatnonzero(np.r_[True, cut | (part[1:] != part[:-1])])
    last = np.r_[first[1:] - 1, t.size - 1]
    rows = last - first + 1
    before, here, after = slice(None, -2), slice(1, -1), slice(2, None)
    one_part = (part[first[before]] == part[first[here]]) & (part[first[after]] == part[first[here]])
    few = (rows[here] < rows[before]) & (rows[here] < rows[after]) & (t[last[here]] - t[first[here]] < LONGEST)
    out, back = last[before], first[after]
    agree = ~_apart(h[out], h[back], t[back] - t[out], fastest)
    # the first stretch and the last one have no way there and back
    between = np.zeros(first.size, bool)
    between[1:-1] = one_part & few & agree
    return np.repeat(between, rows)


def _apart(one: np.ndarray, other: np.ndarray, elapsed: np.ndarray, fastest: float) -> np.ndarray:
    return np.abs(other - one) > np.maximum(LEAST, CLIMB * fastest * (elapsed + SLACK))
