"""An estimate's components and covariances by their names, as a table of tracks reads and changes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..estimate import covariance_name


def covariances_read(components: Sequence[str]) -> list[str]:
    """The outputs that hold the covariances which tables of tracks read."""
    pairs = [(name, name) for name in components] + [("px", "py"), ("vx", "vy")]
    if "turn_rate" in components and "ax" not in components:
        pairs += [("vx", "turn_rate"), ("vy", "turn_rate")]
    elif "ax" in components and "turn_rate" not in components:
        pairs += [("vx", "ax"), ("vx", "ay"), ("vy", "ax"), ("vy", "ay"), ("ax", "ay")]
    return [covariance_name(*pair) for pair in pairs]


class State:
    """Named access to an estimate's components and covariances, (N,) each; both may be changed one by one."""

    def __init__(self, estimate: Any):
        # a copy of each component: each is read several times, and far apart rows cost more than their numbers. By
        # itself, so that a table that keeps one does not hold all.
        self.columns, self.estimate = [column.copy() for column in estimate.x.T], estimate
        self.changed: dict[tuple[str, str], np.ndarray] = {}
        self.index = {name: i for i, name in enumerate(estimate.components)}

    def __contains__(self, name: str) -> bool:
        return name in self.index

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[self.index[name]]

    def covariance(self, first: str, second: str) -> np.ndarray:
        """Of two components (N,)."""
        changed = self.changed.get((first, second))
        return self.estimate.covariance(first, second) if changed is None else changed

    def widen(self, first: str, second: str, more: np.ndarray) -> None:
        """Add to the covariance of two components, more (N,)."""
        self.changed[first, second] = self.changed[second, first] = self.covariance(first, second) + more

    def sd(self, name: str) -> np.ndarray:
        """Standard deviation of one component (N,)."""
        return np.sqrt(self.covariance(name, name))

    def sd_of(self, gradient: dict[str, np.ndarray]) -> np.ndarray:
        """Standard deviation of a function of the state, from its gradient by component (N,)."""
        names = list(gradient)
        variance = np.zeros(self.columns[0].size)
        for a, first in enumerate(names):
            for second in names[a:]:
                term = gradient[first] * gradient[second] * self.covariance(first, second)
                variance += term if first == second else 2.0 * term
        return np.sqrt(np.maximum(variance, 0.0))
