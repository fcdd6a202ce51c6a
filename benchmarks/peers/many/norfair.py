"""norfair: for detections in pictures; greedy assignment by distance, hit counters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from norfair import Detection, OptimizedKalmanFilterFactory, Tracker

from jink.metrics.skies import Picture

from . import Live, Task, picture

NAME = "norfair"
DISTRIBUTION = "norfair"


def entrants(task: Task) -> dict[str, Callable[[], Live]]:
    """Euclidean distance within which a target moves in a scan; the filter's velocity is per scan.

    Targets that are known before the first scan are given as its first detections.
    """
    sky, t = task.sky, task.sky.interval
    reach = 4.0 * sky.sd + 1.5 * sky.speed_sd * t

    def make() -> Live:
        tracker = Tracker(
            distance_function="euclidean",
            distance_threshold=reach,
            hit_counter_max=6,
            initialization_delay=3,
            filter_factory=OptimizedKalmanFilterFactory(
                R=sky.sd**2,
                Q=task.acceleration_psd * t**3,
                pos_variance=sky.sd**2,
                vel_variance=(sky.speed_sd * t) ** 2,
            ),
        )

        def scan(time: float, plots: np.ndarray) -> Picture:
            tracks = tracker.update([Detection(points=z[None]) for z in plots])
            return picture([track.id for track in tracks], [track.estimate[0] for track in tracks])

        if sky.known:
            scan(0.0, sky.known[0][:, [0, 2]])
        return scan

    return {NAME: make}
