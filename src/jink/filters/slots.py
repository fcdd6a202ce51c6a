"""Live targets that come and go, all in one batch: a target has a slot, and a slot is used again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..checks import numbers
from ..estimate import Estimate
from .live import OUTPUTS
from .rows import indices, measurements


class Slots:
    """Live filters of any number of targets; a row costs the same whichever targets come together."""

    def __init__(
        self,
        live: Any,
        estimate: Callable[[dict[str, Any]], Estimate],
        *,
        components: int,
        modes: int,
        columns: int,
    ) -> None:
        self._live, self._estimate, self._columns = live, estimate, columns
        self._shapes: dict[str, tuple[int, ...]] = {name: () for name in OUTPUTS[:-1]}
        self._shapes |= {"x": (components,), "P": (components, components), "mode_probability": (modes,)}

    @property
    def in_use(self) -> int:
        """How many slots have a target."""
        return int(self._live.in_use)

    def take(self) -> int:
        """A slot for a new target."""
        return int(self._live.take())

    def release(self, slot: int) -> None:
        """Say that the slot's target has gone. Errors: ValueError for a slot that is not in use."""
        self._live.release(slot)

    def update(self, slots: ArrayLike, t: ArrayLike, z: ArrayLike) -> Estimate:
        """One estimate per row: slots (N,), times t (N,) and measurements z (N, m), NaN where missing.

        The rows of one slot stand in the order of time. Errors: ValueError naming the argument.
        """
        which = np.atleast_1d(indices("slots", slots))
        if which.ndim != 1 or which.dtype.kind not in "iu" or (which.size and np.abs(which).max() >= 2**31):
            raise ValueError(f"slots: expected whole numbers (N,) that take() gave, got {which!r:.80}")
        which = np.ascontiguousarray(which, dtype=np.int32)
        times, rows = np.atleast_1d(np.ascontiguousarray(numbers("t", t))), measurements(z, self._columns)
        order = _in_turn(which)
        if order is not None:
            which, times, rows = which[order], times[order], rows[order]
        results: dict[str, Any] = {name: np.empty((which.size, *shape)) for name, shape in self._shapes.items()}
        results["status"] = np.empty(which.size, dtype=np.uint8)
        self._live.update(which, times, rows, [results[name] for name in OUTPUTS])
        if order is not None:
            back = np.empty_like(order)
            back[order] = np.arange(order.size)
            results = {name: value[back] for name, value in results.items()}
        return self._estimate(results)


def _in_turn(slots: np.ndarray) -> np.ndarray | None:
    """The order in which slots take turns, so that rows fill packs; None where no slot comes twice."""
    order = np.argsort(slots, kind="stable")
    new = np.r_[True, np.diff(slots[order]) != 0]
    if new.all():
        return None
    place = np.arange(slots.size)
    turn = np.empty(slots.size, int)
    turn[order] = place - np.maximum.accumulate(np.where(new, place, 0))
    return np.argsort(turn, kind="stable")
