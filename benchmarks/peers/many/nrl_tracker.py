"""nrl-tracker: global nearest neighbour, confirmation by M of N, deletion by misses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pytcl.trackers.multi_target import MultiTargetTracker

from jink.metrics.skies import Picture

from . import Live, Task, picture

NAME = "nrl-tracker"
DISTRIBUTION = "nrl-tracker"


def entrants(task: Task) -> dict[str, Callable[[], Live]]:
    """Gate probability of d² < 16, three hits of five to confirm, three misses to delete, init_covariance in metres.

    Targets that are known before the first scan are given as its first measurements.
    """

    def make() -> Live:
        tracker = MultiTargetTracker(
            4,
            2,
            task.F,
            task.H,
            task.Q,
            task.R,
            gate_probability=1.0 - np.exp(-8.0),
            confirm_hits=3,
            confirm_window=5,
            max_misses=3,
            init_covariance=task.start,
        )
        if task.sky.known:
            tracker.process([x[[0, 2]] for x in task.sky.known[0]], task.sky.interval)

        def scan(time: float, plots: np.ndarray) -> Picture:
            tracker.process(list(plots), task.sky.interval)
            tracks = tracker.confirmed_tracks
            return picture([t.id for t in tracks], [t.state[[0, 2]] for t in tracks])

        return scan

    return {NAME: make}
