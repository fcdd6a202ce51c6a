"""What a tracker knows after a scan."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..checks import Array
from ..estimate import Estimate
from ..frozen import frozen


@frozen(repr=False)
class Picture:
    """The tracks of one scan, by id.

    times (n,): of each track's estimate, ``time`` but for scans that take time. ids (n,): the same for as long as a
    track lives; ``report["handed"]`` has the new and the old id of each track that goes on under another's. existence
    (n,): probability that there is a target. confirmed (n,): whether it once was above 0.8 and has not fallen below 0.4
    since. age (n,): scans since the first plot of its id. plot (n,):
    the row of the scan's plots that most probably is the track's, −1 where it more probably has none. due (n,): whether
    the scan looks where the track is; of sectors, it is so once in a turn. estimate: x, P,
    mode_probability and status of each track. lone (m,): of each plot, the probability that it is no track's.
    report: counts of this scan, and what was bounded ("crowded", "full", "inexact"). lagged: of a tracker with a lag,
    where each track was so many scans ago, at ``lagged.time``; NaN where it was not there yet.
    """

    time: float
    times: Array
    ids: NDArray[np.int64]
    existence: Array
    confirmed: NDArray[np.bool_]
    age: NDArray[np.int64]
    plot: NDArray[np.int64]
    due: NDArray[np.bool_]
    estimate: Estimate
    lone: Array
    report: dict[str, Any]
    lagged: Estimate | None = None

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def positions(self) -> Array:
        """(n, axes)"""
        names = [name for name in ("px", "py", "pz") if name in self.estimate.components]
        return np.column_stack([self.estimate[name] for name in names])

    def __repr__(self) -> str:
        return f"Picture(time {self.time:g}, {int(self.confirmed.sum())} confirmed of {len(self)} tracks)"
