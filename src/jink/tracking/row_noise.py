"""Measurement noise of many rows in less memory than a covariance of each: those of some rows are put together.

An array (N, m, m), `JoinedNoise` and `Repeated` give the covariances of the rows that are asked for in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..filters import memory

FEWEST = 200_000  # rows: of fewer, all covariances take little
TIMES = 16  # that each is repeated, on average
BLOCK = 4_000  # rows that are put together at once: few enough for the cache


@dataclass(frozen=True)
class JoinedNoise:
    """Of positions and velocities whose errors are independent.

    position (N, a, a) of a axes; variances (N,) of vx, vy and vz (m²/s²), of which the first a count; xy (N,): the
    covariance of vx and vy, None where there is none.
    """

    position: np.ndarray
    variances: tuple[np.ndarray, np.ndarray, np.ndarray]
    xy: np.ndarray | None

    def __len__(self) -> int:
        return len(self.position)

    def __getitem__(self, rows: slice | np.ndarray) -> np.ndarray:
        axes = self.position.shape[1]
        position, variances = self.position[rows], [each[rows] for each in self.variances[:axes]]
        both = None if self.xy is None else self.xy[rows]
        R = memory.empty((len(position), 2 * axes, 2 * axes))
        for first in range(0, len(R), BLOCK):
            some = slice(first, first + BLOCK)
            R[some] = 0.0
            R[some, :axes, :axes] = position[some]
            for k, variance in enumerate(variances, axes):
                R[some, k, k] = variance[some]
            if both is not None:
                R[some, axes, axes + 1] = R[some, axes + 1, axes] = both[some]
        return R

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        return self[:]

    def parts(self) -> Iterator[np.ndarray]:
        """What tells the covariances of rows apart, (N, …) each."""
        axes = self.position.shape[1]
        yield self.position.reshape(len(self), -1)
        yield from (each[:, None] for each in (*self.variances[:axes], self.xy) if each is not None)


@dataclass(frozen=True)
class Repeated:
    """Rows that have few different ones, as those of one target and file: each once.

    number (N,): which of `different` is a row's.
    """

    different: np.ndarray
    number: np.ndarray

    @classmethod
    def of(cls, covariance: np.ndarray | JoinedNoise | None) -> Repeated | None:
        """Of many rows, of which successive ones are alike; None where there are few, or they differ."""
        if covariance is None or len(covariance) < FEWEST:
            return None
        new = np.zeros(len(covariance), bool)
        new[0] = True
        for part in parts_of(covariance):
            new[1:] |= (part[1:] != part[:-1]).any(axis=1)
        if TIMES * np.count_nonzero(new) > len(new):
            return None
        return cls(covariance[new], np.cumsum(new, dtype=np.int32) - 1)

    def __getitem__(self, rows: slice | np.ndarray) -> np.ndarray:
        return self.different[self.number[rows]]


def parts_of(covariance: np.ndarray | JoinedNoise) -> Iterator[np.ndarray]:
    """What tells the covariances of rows apart, (N, …) each."""
    if isinstance(covariance, JoinedNoise):
        yield from covariance.parts()
    else:
        yield covariance.reshape(len(covariance), -1)


def uniform(covariance: np.ndarray | JoinedNoise) -> bool:
    """Whether every row has the same."""
    # most that differ do so among the first rows
    return all((some == part[:1]).all() for part in parts_of(covariance) for some in (part[:1000], part))
