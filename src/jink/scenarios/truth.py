"""What a truth is: position, velocity and acceleration as functions of time, for many runs at once."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ..checks import Array


class Kinematics(NamedTuple):
    """Position (m), velocity (m/s) and acceleration (m/s²), each (B, n, axes): east, north, up."""

    position: Array
    velocity: Array
    acceleration: Array

    def repeated(self, runs: int) -> Kinematics:
        """One run's kinematics for all."""
        return Kinematics(*(np.broadcast_to(a, (runs, *a.shape[1:])) for a in self))


class Truth(Protocol):
    """The true motion of B runs (or one that all runs share: B = 1)."""

    @property
    def runs(self) -> int:
        """B"""
        ...

    def at(self, time: Array) -> Kinematics:
        """Kinematics at the times (B, n), in seconds; where a derivative jumps, its value afterwards."""
        ...

    def breaks(self) -> Array:
        """(B, K) times where acceleration or its rate may jump."""
        ...


def find(knots: Array, time: Array) -> np.ndarray:
    """(B, n) number of the last of the knots (B, K) at or before each time (B, n); 0 before the first."""
    if len(knots) == 1:
        return np.maximum(np.searchsorted(knots[0], time, side="right") - 1, 0)
    found = np.empty(time.shape, dtype=np.intp)
    for row, own, asked in zip(found, knots, time, strict=True):
        row[:] = np.searchsorted(own, asked, side="right")
    return np.maximum(found - 1, 0)


def rows_of(array: Array, index: np.ndarray) -> Array:
    """array[b, index[b, n]] for (B, K, ...) or shared (1, K, ...) arrays."""
    if len(array) == 1:
        return array[0][index]
    return array[np.arange(len(array))[:, None], index]
