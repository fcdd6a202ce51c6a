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


def impossible_heights(time: np.ndarray, height: np.ndarray, new: np.ndarray, fastest: float) -> np.ndarray:
    """Rows (N,) whose height cannot be; time (N,) s, height (N,) m, NaN: none, new (N,) first rows of parts."""
    bad = np.zeros(time.size, bool)
    known = np.flatnonzero(np.isfinite(height))
    if known.size < 3:
        return bad
    t, h, part = time[known], height[known], np.cumsum(new)[known]
    same = part[1:] == part[:-1]
    cut = np.r_[True, ~same | _apart(h[:-1], h[1:], t[1:] - t[:-1], fastest)]
    first = np.flatnonzero(cut)
    last = np.r_[first[1:] - 1, known.size - 1]
    rows = last - first + 1
    if first.size < 3:
        return bad
    before, here, after = slice(None, -2), slice(1, -1), slice(2, None)
    one_part = (part[first[before]] == part[first[here]]) & (part[first[after]] == part[first[here]])
    few = (rows[here] < rows[before]) & (rows[here] < rows[after]) & (t[last[here]] - t[first[here]] < LONGEST)
    out, back = last[before], first[after]
    agree = ~_apart(h[out], h[back], t[back] - t[out], fastest)
    wrong = np.r_[False, one_part & few & agree, False]
    bad[known] = np.repeat(wrong, rows)
    return bad


def _apart(one: np.ndarray, other: np.ndarray, elapsed: np.ndarray, fastest: float) -> np.ndarray:
    return np.abs(other - one) > np.maximum(LEAST, CLIMB * fastest * (elapsed + SLACK))
