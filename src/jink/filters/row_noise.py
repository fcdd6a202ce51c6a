"""Measurement noise of many rows: what is not zero in their covariances, each entry once.

A covariance of six components has 36 entries, of which seven are not zero. A native filter takes them so; for others,
rows are put together where they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from .._engine import native
from ..frozen import frozen
from . import memory

FEWEST = 200_000  # rows: of fewer, all covariances take little
TIMES = 16  # that each is repeated, on average
BLOCK = 4_000  # rows that are put together at once: few enough for the cache


@frozen
class RowNoise:
    """Covariances (N, m, m) of m components, or their variances (N, m) where they are not `full`.

    entries: (i, j), i <= j, to values (N,); what is not there is zero. Rows that are asked for come as an array.
    """

    size: int
    entries: dict[tuple[int, int], np.ndarray]
    full: bool = True

    @classmethod
    def of_variances(cls, variances: Iterable[np.ndarray]) -> RowNoise:
        """Of components (N,) whose errors are independent, as variances."""
        each = {(k, k): variance for k, variance in enumerate(variances)}
        return cls(len(each), each, full=False)

    @classmethod
    def of_covariances(cls, R: np.ndarray) -> RowNoise:
        """Of covariances (N, m, m)."""
        size = R.shape[1]
        return cls(size, {(i, j): R[:, i, j].copy() for i in range(size) for j in range(i, size)})

    def __len__(self) -> int:
        return len(self.entries[0, 0])

    def variance(self, component: int) -> np.ndarray:
        """Of each row (N,)."""
        return self.entries[component, component]

    def covariance(self, first: int, second: int) -> np.ndarray | float:
        """Of each row (N,), 0 where it is zero in all."""
        return self.entries.get((first, second), 0.0)

    def some(self, rows: slice | np.ndarray) -> RowNoise:
        """That of some rows; their own values."""
        return replace(self, entries={at: each[rows].copy() for at, each in self.entries.items()})

    def piece(self, rows: slice | np.ndarray) -> RowNoise:
        """That of some rows; the same values in memory where the rows are a slice."""
        return replace(self, entries={at: each[rows] for at, each in self.entries.items()})

    def columns(self) -> list[tuple[int, int, np.ndarray]]:
        """The entries (i, j), each with its values (N,), as the engine takes them."""
        return [(i, j, np.ascontiguousarray(each, dtype=float)) for (i, j), each in self.entries.items()]

    def first_indefinite(self) -> int:
        """The first row whose covariance is not positive definite, or whose variances are not positive; -1: none."""
        return native.first_indefinite_row(self.size, self.columns())

    def first(self, count: int) -> RowNoise:
        """That of the first components."""
        return RowNoise(count, {at: each for at, each in self.entries.items() if at[1] < count}, self.full)

    def where(self, rows: np.ndarray, other: RowNoise) -> RowNoise:
        """The other in these rows (N,), and this in the rest."""
        ats = self.entries.keys() | other.entries.keys()
        return replace(self, entries={at: np.where(rows, other.covariance(*at), self.covariance(*at)) for at in ats})

    def beside(
        self, variances: Iterable[np.ndarray], correlated: Mapping[tuple[int, int], np.ndarray] | None = None
    ) -> RowNoise:
        """With further components (N,), whose errors are independent of these; correlated: covariances among them."""
        more = {(k, k): each for k, each in enumerate(variances, self.size)}
        return RowNoise(self.size + len(more), {**self.entries, **more, **(correlated or {})}, self.full)

    def __getitem__(self, rows: slice | np.ndarray) -> np.ndarray:
        chosen = self.piece(rows).entries
        count, size = len(chosen[0, 0]), self.size
        if not self.full:
            return np.stack([chosen[k, k] for k in range(size)], axis=1)
        R = memory.empty((count, size, size))
        for begin in range(0, count, BLOCK):
            some = slice(begin, begin + BLOCK)
            R[some] = 0.0
            for (i, j), each in chosen.items():
                R[some, i, j] = R[some, j, i] = each[some]
        return R

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        return self[:]

    @property
    def uniform(self) -> bool:
        """Whether every row has the same."""
        # most that differ do so among the first rows
        return all((some == each[:1]).all() for each in self.entries.values() for some in (each[:1000], each))


@frozen
class Repeated:
    """Rows that have few different ones, as those of one target and file: each once.

    number (N,): which of `different` is a row's.
    """

    different: RowNoise
    number: np.ndarray

    @classmethod
    def of(cls, noise: RowNoise | None) -> Repeated | None:
        """Of many rows, of which successive ones are alike; None where there are few, or they differ."""
        if noise is None or len(noise) < FEWEST:
            return None
        new = np.zeros(len(noise), bool)
        new[0] = True
        for each in noise.entries.values():
            new[1:] |= each[1:] != each[:-1]
        if TIMES * np.count_nonzero(new) > len(new):
            return None
        return cls(noise.some(new), np.cumsum(new, dtype=np.int32) - 1)

    def piece(self, rows: slice | np.ndarray) -> RowNoise:
        """That of some rows."""
        return self.different.piece(self.number[rows])

    def __getitem__(self, rows: slice | np.ndarray) -> np.ndarray:
        return self.different[self.number[rows]]
