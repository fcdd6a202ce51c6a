"""How uncertain a height is while none is measured: the climb rate changes, and nothing shows it.

The modes of a filter share one probability, and positions without heights decide it: a target that flies straight on
the map seems to keep its climb rate as well. So the variance of a predicted height gains what changes of the climb rate
make of it. The rate is a random walk of intensity q = 2 σ² / τ, with an sd of σ after some τ seconds (`Kind.climbs`).
A filter knows the last measurement, a seconds ago:

    var z = q a³ / 3,  var v = q a

and a smoother also the next one, in b seconds: the covariances of both ends, [[a³/3, a²/2], [a²/2, a]] q and the same
with b and −b²/2, are fused by their inverses. No sd of the rate is above σ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import polars as pl

from .lag import Lag
from .placing import Placed

HEIGHT, CLIMB = "unseen_height_variance", "unseen_climb_variance"  # columns, m² and m²/s²


def with_doubt(placed: Placed, climbs: tuple[float, float], smooth: bool, lag: Lag | None = None) -> Placed:
    """Rows of three axes with the variances that their estimates gain.

    smooth: what came later is known as well; lag: what came so much later.
    """
    if placed.axes < 3:
        return placed
    vertical = [2, *(k for k, name in enumerate(placed.components) if name == "vz")]
    seen = np.asarray(np.isfinite(placed.z[:, vertical]).any(axis=1))
    if seen.all():
        return placed
    before, after, rows = _apart(placed, seen)
    if not smooth:
        known = np.zeros(seen.size, bool)
        if lag is not None:
            known = rows <= lag.scans if lag.scans is not None else after <= lag.seconds
        # a part without a height before begins with the first one that comes
        after = np.where(known | np.isinf(before), after, np.inf)
    return _with(placed, *variances(before, after, climbs))


def with_unseen(placed: Placed, unseen: Sequence[tuple[float, float]], climbs: tuple[float, float]) -> Placed:
    """The same of rows whose measurements before and after are so many seconds away, infinite: not known."""
    if placed.axes < 3 or not any(before for before, _ in unseen):
        return placed
    before, after = np.array(unseen).T
    return _with(placed, *variances(before, after, climbs))


def _with(placed: Placed, height: np.ndarray, climb: np.ndarray) -> Placed:
    return replace(placed, rows=placed.rows.with_columns(pl.Series(HEIGHT, height), pl.Series(CLIMB, climb)))


def variances(before: np.ndarray, after: np.ndarray, climbs: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Of height (m²) and climb rate (m²/s²), each (N,), 0 where something was measured.

    before, after (N,): seconds to the measurements that are known, infinite where there is none.
    """
    sd, seconds = climbs
    near = np.minimum(before, after)
    near = np.where(np.isfinite(near), near, 0.0)
    some = near > 0.0
    a, b = np.where(some, before, 1.0), np.where(some, after, 1.0)
    # the inverse covariances of both ends, over the intensity; of an end that is infinitely far off they are 0
    height, rate, both = (12.0 * (a**-3 + b**-3), 4.0 * (1.0 / a + 1.0 / b), 6.0 * (b**-2 - a**-2))
    over = 2.0 * sd**2 / seconds / (height * rate - both**2)
    of_rate = np.where(some, np.minimum(over * height, sd**2), 0.0)
    return np.where(some, np.minimum(over * rate, (sd * near) ** 2), 0.0), of_rate


def _apart(placed: Placed, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Seconds from the last row of the part that was seen, seconds and rows to the next one; infinite where none is."""
    rows = np.arange(seen.size)
    offsets = placed.offsets
    lengths = np.diff(offsets)
    first, last = np.repeat(offsets[:-1], lengths), np.repeat(offsets[1:] - 1, lengths)
    earlier = np.maximum.accumulate(np.where(seen, rows, -1))
    later = np.minimum.accumulate(np.where(seen, rows, seen.size)[::-1])[::-1]
    before = placed.time - placed.time[np.maximum(earlier, 0)]
    after = placed.time[np.minimum(later, seen.size - 1)] - placed.time
    none = later > last
    return (
        np.where(earlier >= first, before, np.inf),
        np.where(none, np.inf, after),
        np.where(none, np.inf, later - rows),
    )
