"""What the motion of the targets says about units: the speed that positions and times imply, and the reported one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..frozen import frozen

EARTH_RADIUS = 6_371_000.0
ROWS = 20_000  # rows that are looked at
FASTEST = 1500.0  # m/s: nothing that is tracked goes faster, rockets and satellites apart
SLOWEST = 0.05  # m/s: what goes slower does not move


@frozen
class Motion:
    """Positions as they follow each other: target (N,) numbers, first and second (N,), their kind, reported (N,) speed
    in its own unit, or none.
    """

    target: np.ndarray
    first: np.ndarray
    second: np.ndarray
    position: str
    reported: np.ndarray | None = None

    def steps(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Metres and elapsed time between consecutive different positions of each target, by time."""
        known = np.isfinite(time) & np.isfinite(self.first) & np.isfinite(self.second)
        index = np.flatnonzero(known)[:ROWS]
        index = index[np.lexsort((time[index], self.target[index]))]
        same = np.diff(self.target[index]) == 0
        distance = distances(self.first[index], self.second[index], self.position)
        with np.errstate(over="ignore"):
            elapsed = np.diff(time[index])
        moved = same & np.isfinite(distance) & (distance > 0) & (elapsed > 0)
        return distance[moved], elapsed[moved]

    def speed(self, time: np.ndarray) -> float:
        """The median speed that the times imply; NaN where nothing moves."""
        distance, elapsed = self.steps(time)
        return float(np.median(distance / elapsed)) if distance.size > 2 else float("nan")

    def gets_somewhere(self, time: np.ndarray) -> bool:
        """Whether a path of latitudes and longitudes leads anywhere: noise about one place is long for its extent."""
        path = self.steps(time)[0]
        north, east = self.first[np.isfinite(self.first)], self.second[np.isfinite(self.second)]
        extent = 111e3 * np.hypot(np.ptp(north), np.ptp(east) * np.cos(np.radians(np.median(north))))
        # n noisy rows about one place have a path of 1.8 n sds and an extent of some 6: a ratio of 3.4 / n
        return path.size > 2 and extent / path.sum() > max(0.02, 12.0 / max(path.size, 13))

    def reported_speed(self) -> float:
        """The median of the reported speeds that are not 0; NaN if there are none."""
        if self.reported is None:
            return float("nan")
        moving = self.reported[np.isfinite(self.reported) & (self.reported > 0)]
        return float(np.median(moving)) if moving.size > 2 else float("nan")


def distances(first: np.ndarray, second: np.ndarray, position: str) -> np.ndarray:
    """Metres between consecutive positions, as `between` has them."""
    return between([first[:-1], second[:-1]], [first[1:], second[1:]], position)


def between(one: Sequence[np.ndarray], other: Sequence[np.ndarray], position: str) -> np.ndarray:
    """Metres from some positions to others, roughly; values beyond all measure give infinity."""
    with np.errstate(over="ignore", invalid="ignore"):
        if position == "polar":
            return np.abs(other[0] * np.exp(1j * other[1]) - one[0] * np.exp(1j * one[1]))
        first, second = other[0] - one[0], other[1] - one[1]
        if position == "geographic":
            wrapped = (second + 180.0) % 360.0 - 180.0
            first = np.radians(first) * EARTH_RADIUS
            second = np.radians(wrapped) * EARTH_RADIUS * np.cos(np.radians(other[0]))
        return np.hypot(first, second)
