"""Adding runs to sums whose rows several runs share (run modulo rows), and taking a chunk of them back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..checks import Array

Stores = list[dict[str, Array]]


def add_at(store: Array, runs: np.ndarray, values: Array) -> None:
    """store[run modulo rows] += values (n, …), in the order of the runs, to the bit as `np.add.at`.

    That is slow in more than one dimension. There the first run of every row is added, then the second, and so on.
    """
    rows = runs % len(store)
    if store.ndim == 1 or not len(rows):
        np.add.at(store, rows, values)
        return
    order = np.argsort(rows, kind="stable")
    begins = np.flatnonzero(np.diff(rows[order], prepend=-1))
    turn = np.arange(len(rows)) - np.repeat(begins, np.diff(begins, append=len(rows)))
    for k in range(int(turn.max()) + 1):
        now = order[turn == k]
        store[rows[now]] += values[now]


def undo(stores: Stores, runs: np.ndarray, growing: list[Any]) -> Callable[[], None]:
    """What sets the rows of these runs back to what they are now, forgets new names, and cuts a list that grew."""
    length = len(growing)
    kept = [{name: _rows(values, runs) for name, values in store.items()} for store in stores]

    def take_back() -> None:
        for store, known in zip(stores, kept, strict=True):
            for name in [each for each in store if each not in known]:
                del store[name]
            for name, (rows, values) in known.items():
                store[name][rows] = values
        del growing[length:]

    return take_back


def _rows(values: Array, runs: np.ndarray) -> tuple[Any, Array]:
    rows = np.unique(runs % len(values))
    return rows, values[rows]
