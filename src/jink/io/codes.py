"""Numbers that stand for "no value": -9999, 32767, 1e20 and their like, told from values because they stand alone;
and heights of 0 that no climb or descent leads to.
"""

from __future__ import annotations

import numpy as np

from .values import order_of

# what sensors and file formats write where there is nothing to report
CODES = (
    *(-999.0, -999.9, -999.99, -9999.0, -9999.9, -9999.99, -99999.0, -999999.0, -32767.0, -32768.0, -2147483648.0),
    *(9999.0, 99999.0, 999999.0, 9999999.0, 32767.0, 65535.0, 2147483647.0, 4294967295.0),
)
ALONE = 0.2  # of its size: a code is at least this far from every value
FASTEST_CLIMB = 150.0  # m/s: what is tracked climbs and dives more slowly
NO_HEIGHT = -999.0, 1e19  # no height is so low or so high, so that a code shows even without others beside it


def are_codes(value: np.ndarray, height: bool = False) -> np.ndarray:
    """Which numbers (N,) are such codes: those of the list that lie far from all others. height: of a height."""
    low, high = np.fmin.reduce(value, initial=np.inf), np.fmax.reduce(value, initial=-np.inf)
    found = np.zeros(value.size, bool)
    for code in CODES:
        if low <= code <= high:
            found |= value == code
    none = ~found
    for code in np.unique(value[found]):
        near = none & (np.abs(value - code) < ALONE * abs(code))
        if (near.any() or not (none & np.isfinite(value)).any()) and not (height and code <= NO_HEIGHT[0]):
            found &= value != code
    if height and max(-low, high) >= NO_HEIGHT[1]:
        found |= np.abs(value) >= NO_HEIGHT[1]
    return found


def zero_heights(altitude: np.ndarray, codes: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Which heights of exactly 0 (N,) stand for none: the target would have to leave or reach them too fast.

    A run of zeros counts as one: what leads to it or away from it tells.
    """
    zero = altitude == 0.0
    out = np.zeros(altitude.size, bool)
    if not zero.any() or not (np.abs(altitude[np.isfinite(altitude)]) > 0.0).any():
        return out
    asked = np.zeros(codes.max() + 1, bool)
    asked[codes[zero]] = True
    rows = np.flatnonzero(asked[codes] & np.isfinite(altitude) & np.isfinite(seconds))
    rows = rows[order_of(codes[rows], seconds[rows])]
    height, none = altitude[rows], zero[rows]
    same = np.diff(codes[rows]) == 0
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = same & (np.abs(np.diff(height)) > FASTEST_CLIMB * np.maximum(np.diff(seconds[rows]), 1.0))
    edge = np.r_[False, none[1:] != none[:-1]] | np.r_[True, ~same]
    run = np.cumsum(edge) - 1
    leaps = steep & (none[1:] != none[:-1])
    bad = np.zeros(run[-1] + 1, bool)
    bad[run[1:][leaps]] = bad[run[:-1][leaps]] = True
    out[rows] = bad[run] & none
    return out
