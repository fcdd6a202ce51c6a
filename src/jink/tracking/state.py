"""An estimate's components and covariances by their names, as a table of tracks reads and changes them."""

from __future__ import annotations

from typing import Any

import numpy as np

BLOCK = 2048  # rows


class State:
    """Named access to an estimate's components and covariances, (N,) each; both may be changed one by one."""

    def __init__(self, estimate: Any):
        # a copy of each component: each is read several times, and far apart rows cost more than their numbers. By
        # itself, so that a table that keeps one does not hold all.
        self.columns, self.P = [column.copy() for column in estimate.x.T], estimate.P
        self.known: dict[tuple[int, int], np.ndarray] = {}
        self.index = {name: i for i, name in enumerate(estimate.components)}

    def let_go(self) -> State:
        """Copy the covariances that a table of tracks reads; the array of all is not needed any more."""
        pairs = [(name, name) for name in self.index] + [("px", "py"), ("vx", "vy")]
        if "turn_rate" in self and "ax" not in self:
            pairs += [("vx", "turn_rate"), ("vy", "turn_rate")]
        elif "ax" in self and "turn_rate" not in self:
            pairs += [("vx", "ax"), ("vx", "ay"), ("vy", "ax"), ("vy", "ay"), ("ax", "ay")]
        places = [(self.index[first], self.index[second]) for first, second in pairs]
        rows, n = self.P.reshape(len(self.P), -1), len(self.index)
        found = np.empty((len(places), len(rows)))
        flat = np.array([i * n + j for i, j in places])
        # block by block: each matrix is read once, and what is taken of it is turned within the cache
        for first in range(0, len(rows), BLOCK):
            some = slice(first, first + BLOCK)
            found[:, some] = rows[some].take(flat, axis=1).T
        for (i, j), covariance in zip(places, found, strict=True):
            self.known[i, j] = self.known[j, i] = covariance
        self.P = np.empty((self.columns[0].size, 0, 0))
        return self

    def __contains__(self, name: str) -> bool:
        return name in self.index

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[self.index[name]]

    def covariance(self, first: str, second: str) -> np.ndarray:
        """Of two components (N,)."""
        i, j = self.index[first], self.index[second]
        if (i, j) not in self.known:
            self.known[i, j] = self.known[j, i] = self.P[:, i, j].copy()
        return self.known[i, j]

    def widen(self, first: str, second: str, more: np.ndarray) -> None:
        """Add to the covariance of two components, more (N,)."""
        i, j = self.index[first], self.index[second]
        self.known[i, j] = self.known[j, i] = self.covariance(first, second) + more

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
