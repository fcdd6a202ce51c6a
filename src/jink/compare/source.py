"""Where the runs of a race come from: drawn from a scenario, the training runs apart from those that are scored."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..frozen import frozen
from ..scenarios import Scenario, Simulation
from ..scenarios.observation import in_words

TRAINING = 1 << 40  # numbers of the training runs begin here: no race reaches them
TRAINING_ROWS, TRAINING_RUNS = 36_000, 200


@frozen(kw_only=True)
class Source:
    """Runs to score, and runs to be fitted on.

    scenario: name, kind, sensor and schedule; seen: these in words; runs to score; training: other runs, in words
    fitted ("" when training is for the level of the noise alone); chunks(size): the runs to score in pieces.
    """

    scenario: Scenario
    seen: str
    runs: int
    training: Simulation
    fitted: str
    chunks: Callable[[int], Iterator[Simulation]]


def drawn(scenario: Scenario, runs: int, seed: int) -> Source:
    """Runs 0 … runs − 1 of a seed; training runs have numbers that no race reaches."""
    count = int(np.clip(TRAINING_ROWS // scenario.schedule.count, 20, TRAINING_RUNS))
    return Source(
        scenario=scenario,
        seen=in_words(scenario),
        runs=runs,
        training=scenario.simulate(np.arange(TRAINING, TRAINING + count), seed),
        fitted=f"{count} training runs",
        chunks=lambda size: scenario.chunks(runs, seed, size=size),
    )
