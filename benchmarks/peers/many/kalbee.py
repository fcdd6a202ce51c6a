"""kalbee: SORT-like; Mahalanobis gate and optimal assignment over a Kalman filter of one's own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from kalbee import KalmanFilter, MultiObjectTracker
from kalbee.tracking.track import CONFIRMED, Track

from jink.metrics.skies import Picture

from . import Live, Task, picture

NAME = "kalbee"
DISTRIBUTION = "kalbee"


def entrants(task: Task) -> dict[str, Callable[[], Live]]:
    """MultiObjectTracker with a gate of four sigmas, three hits to confirm and three misses to delete."""

    def filter_at(z: np.ndarray) -> KalmanFilter:
        x = np.array([[z[0]], [0.0], [z[1]], [0.0]])
        return KalmanFilter(x, task.start.copy(), task.F, task.Q, task.H, task.R)

    def make() -> Live:
        tracker = MultiObjectTracker(filter_at, n_init=3, max_age=3, gate=4.0)
        for k, (x, variance) in enumerate(zip(*(task.sky.known or ((), ())), strict=True)):
            known = Track(KalmanFilter(x[:, None], np.diag(variance), task.F, task.Q, task.H, task.R), -1 - k)
            known.status = CONFIRMED
            tracker.tracks.append(known)

        def scan(time: float, plots: np.ndarray) -> Picture:
            tracks = tracker.update(plots, dt=task.sky.interval)
            return picture([t.id for t in tracks], [t.state.ravel()[[0, 2]] for t in tracks])

        return scan

    return {NAME: make}
