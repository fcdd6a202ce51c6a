"""How long a filter's modes take to follow a target whose motion changes at the same scans in all runs.

The right mode of a phase (the scans between two changes of the commanded input or turn rate) is the one with the
largest mean probability over runs in its last third: where the filter settles. A jump is called for where that is
another mode than in the phase before. Its delay is the number of scans from the change until the right mode leads, on
the mean over runs. Source: Choi, Samal & Ahn 2001 (mode-set jump delay), which gives no formula.
"""

from __future__ import annotations

import math

import numpy as np

from ..checks import Array
from ..metrics import Figure
from ..metrics.figure import jackknife
from ..scenarios import Simulation
from .scores import JACKKNIFE, NAN, Tally

Phases = list[tuple[int, int]]
METRIC = "mode_jump_delay"
SHORTEST = 2  # scans of a phase
LEAST = 1e-9  # scans: a standard error below that is none


def count(tally: Tally, runs: np.ndarray, probability: Array | None) -> None:
    """Add the mode probabilities (B, S, M) of the runs with these numbers."""
    if probability is None:
        return
    tally.add_response(runs, "modes", np.nan_to_num(probability))


def phases(simulation: Simulation, first: int) -> Phases:
    """Scans (begin, end) from the first that counts on, between changes that all runs share; none where they do not."""
    command, rate = simulation.input, simulation.turn_rate
    if command is None or rate is None:
        return []
    told = np.concatenate([command, rate[..., None]], axis=2)
    if (told != told[:1]).any():
        return []
    changed = (told[0, 1:] != told[0, :-1]).any(axis=1)
    begins = [first, *(k for k in np.flatnonzero(changed) + 1 if k > first)]
    ends = [*begins[1:], told.shape[1]]
    return [(int(a), int(b)) for a, b in zip(begins, ends, strict=True) if b - a >= SHORTEST]


def mode_jump_delay(tally: Tally, of: Phases) -> Figure:
    """Mean over jumps, in scans; NaN for a filter of one mode, and where no jump is called for."""
    if "modes" not in tally.responses:
        return NAN
    counted = tally.responses["modes"]
    used = counted.any(axis=(1, 2))

    def delay(modes: Array) -> float:
        total = modes.sum(axis=0)
        found, before = [], int(total[of[0][0]].argmax()) if of else -1
        for begin, end in of:
            right = int(total[end - max((end - begin) // 3, 1) : end].sum(axis=0).argmax())
            if right != before:
                found.append(int((total[begin:end].argmax(axis=1) == right).argmax()))
            before = right
        return float(np.mean(found)) if found else math.nan

    value, se = jackknife(delay, counted[used], groups=JACKKNIFE)
    # rounding of sums that are all alike
    return Figure(value, 0.0 if se < LEAST else se)
