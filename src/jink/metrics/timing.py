"""What an update costs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from ..checks import by_hints
from .figure import Figure


@by_hints
def microseconds_per_update(work: Callable[[], object], updates: int, *, repetitions: int = 5) -> Figure:
    """Median wall-clock time of ``work()`` per update (tracks × scans), µs, after a run that is not counted.

    se = 1.253 sd/√repetitions, that of a median. Errors: ValueError for no updates or repetitions.
    """
    if updates < 1 or repetitions < 1:
        raise ValueError(f"updates and repetitions: expected at least 1, got {updates!r} and {repetitions!r}")
    work()
    costs = np.empty(repetitions)
    for k in range(repetitions):
        begin = time.perf_counter()
        work()
        costs[k] = (time.perf_counter() - begin) * 1e6 / updates
    se = 1.253 * costs.std(ddof=1) / math.sqrt(repetitions) if repetitions > 1 else math.nan
    return Figure(float(np.median(costs)), float(se))
