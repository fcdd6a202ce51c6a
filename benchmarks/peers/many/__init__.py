"""Trackers of many targets in other libraries, one small file each, on the plots of a sky.

A module has NAME, DISTRIBUTION and `entrants(task)`: by name, functions that make a live tracker, which takes a time
and plots (m, 2) and returns the picture of its confirmed tracks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from jink.metrics.skies import Picture
from jink.scenarios.skies import Sky

Live = Callable[[float, np.ndarray], Picture]

PEERS = ("stonesoup", "norfair", "kalbee", "nrl_tracker")


@dataclass(frozen=True)
class Task:
    """A sky and the constant-velocity noise that targets are tracked with; state [x vx y vy], SI units."""

    sky: Sky
    acceleration_psd: float

    @property
    def F(self) -> np.ndarray:
        """Transition over one scan (4, 4)."""
        return np.kron(np.eye(2), [[1.0, self.sky.interval], [0.0, 1.0]])

    @property
    def Q(self) -> np.ndarray:
        """Process noise over one scan (4, 4)."""
        t = self.sky.interval
        return self.acceleration_psd * np.kron(np.eye(2), [[t**3 / 3, t**2 / 2], [t**2 / 2, t]])

    @property
    def H(self) -> np.ndarray:
        """Positions of the state (2, 4)."""
        return np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0]])

    @property
    def R(self) -> np.ndarray:
        """Noise of a plot (2, 2)."""
        return self.sky.sd**2 * np.eye(2)

    @property
    def start(self) -> np.ndarray:
        """Covariance of a track that begins at a plot (4, 4)."""
        return np.diag([self.sky.sd**2, self.sky.speed_sd**2] * 2)

    @property
    def clutter_density(self) -> float:
        """False plots per unit of area and scan."""
        x0, x1, y0, y1 = self.sky.area
        return self.sky.false_per_scan / ((x1 - x0) * (y1 - y0))


def picture(ids: list[int], points: list[np.ndarray]) -> Picture:
    """Of lists."""
    return Picture(np.array(ids, np.int64), np.array(points, float).reshape(-1, 2))
