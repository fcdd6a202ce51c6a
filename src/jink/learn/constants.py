"""What fuzzy rules are measured against: the same modes with one constant noise each, found on the same runs within the
same bounds.
"""

from __future__ import annotations

import numpy as np

from ..checks import Array
from .data import Runs
from .genetic import Settings, encoding_for, total_error
from .population import errors_of

GRID = 65  # noises tried, both bounds among them


def best_constant(acceleration: float, runs: Runs, settings: Settings, process_sd: float) -> float:
    """The noise's sd (m/s²) with the least error of eq. 17 in the interval of eq. 15: a rule that holds everywhere.

    The bounds are those of :func:`jink.learn.genetic.identify` with the same arguments.
    """
    encoding = encoding_for(acceleration, runs, settings, process_sd)
    sds = np.geomspace(encoding.least, encoding.most, GRID)
    errors = errors_of(_single_rules(sds, runs.sd), np.ones((GRID, 1), dtype=np.int64), runs)
    loss = total_error(errors.position / settings.unit, errors.velocity / settings.unit)
    return float(sds[np.argmin(loss)])


def _single_rules(sds: Array, spread: float) -> Array:
    tables = np.empty((len(sds), 1, 1, 5))
    tables[:, 0, 0] = [0.0, spread, 0.0, spread, 0.0]
    tables[:, 0, 0, 4] = sds**2
    return tables
