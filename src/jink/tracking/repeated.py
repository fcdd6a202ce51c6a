"""Noise of many rows that have few different ones, as those of one target and file: each once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FEWEST = 200_000  # rows: of fewer, all covariances take little
TIMES = 16  # that each is repeated, on average


@dataclass(frozen=True)
class Repeated:
    """The covariances of rows, by the rows asked for; number (N,): which of `different` is a row's."""

    different: np.ndarray
    number: np.ndarray

    @classmethod
    def of(cls, covariance: np.ndarray | None) -> Repeated | None:
        """Of many rows, of which successive ones are alike; None where there are few, or they differ."""
        if covariance is None or len(covariance) < FEWEST:
            return None
        rows = covariance.reshape(len(covariance), -1)
        new = np.ones(len(rows), bool)
        new[1:] = (rows[1:] != rows[:-1]).any(axis=1)
        if TIMES * np.count_nonzero(new) > len(rows):
            return None
        return cls(covariance[new], np.cumsum(new, dtype=np.int32) - 1)

    def __getitem__(self, rows: slice | np.ndarray) -> np.ndarray:
        return self.different[self.number[rows]]
