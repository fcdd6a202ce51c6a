"""Do the plots come from an antenna that turns? Their azimuths then go with their times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..frozen import frozen

Array = NDArray[np.float64]

TOGETHER = 0.95  # length of the mean of unit vectors whose angles are how far azimuths are off; 16 sectors have 0.98
FEWEST = 30  # pairs of plots that tell anything
TURNS = 3  # so many at least
AS_GIVEN = 0.02  # how far the period may be from the one that was given


@frozen
class Antenna:
    """period: seconds of a turn; clockwise: from north over east; together: 1 where azimuths are as foreseen."""

    period: float
    clockwise: bool
    together: float


def antenna_of(time: Array, azimuth: Array, period: float | None = None) -> Antenna | None:
    """The antenna that turns once in about ``period`` s, or in a time to be found; None if there is none.

    time (n,) s in order, azimuth (n,) rad. Plots a third of a turn apart or more must lie where the antenna has turned
    in between: |mean exp i(Δazimuth − 2π Δt / period)| > 0.95.
    """
    good = np.isfinite(azimuth) & np.isfinite(time)
    t, a = time[good], azimuth[good] / (2 * np.pi)
    best: Antenna | None = None
    for clockwise in (True, False):
        turned = a if clockwise else -a
        for guess in [period] if period else _guesses(t, turned):
            found = _refined(t, turned, guess)
            if found is None or (period and abs(found / period - 1) > AS_GIVEN):
                continue
            together = _together(t, turned, found)
            if best is None or together > best.together + 1e-6:
                best = Antenna(found, clockwise, together)
    return best if best is not None and best.together > TOGETHER else None


def _guesses(t: Array, a: Array) -> list[float]:
    """Periods that plots so many rows apart tell, each the median."""
    out = []
    for lag in (1, 2, 4, 8, 16, 32, 64, 128):
        dt, turned = t[lag:] - t[:-lag], (a[lag:] - a[:-lag]) % 1.0
        some = (dt > 0) & (turned > 0)
        if some.sum() >= FEWEST:
            out.append(float(np.median(dt[some] / turned[some])))
    return out


def _refined(t: Array, a: Array, period: float) -> float | None:
    """The whole time over all turns; a turn without a plot counts too. None where there are not enough turns."""
    if len(t) < FEWEST:
        return None
    for _ in range(3):
        turned = np.diff(a)
        turns = float((turned + np.round(np.diff(t) / period - turned)).sum())
        if turns < TURNS:
            return None
        period = float(t[-1] - t[0]) / turns
    return period


def _together(t: Array, a: Array, period: float) -> float:
    """How well azimuths go with times, over pairs of plots a third of a turn apart or more; 0 where there are few."""
    later = np.searchsorted(t, t + period / 3, side="left")
    first = np.flatnonzero(later < len(t))
    dt = t[later[first]] - t[first]
    near = dt < 0.9 * period
    first, dt = first[near], dt[near]
    if len(first) < FEWEST:
        return 0.0
    off = a[later[first]] - a[first] - dt / period
    return float(abs(np.exp(2j * np.pi * off).mean()))
