"""The rows that an estimate was made of, kept so that the same filter can say where targets are at other times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..checks import Array
from ..estimate import Estimate, Status
from ..frozen import frozen
from .rows import Batch


@frozen
class BatchSource:
    """A filter and its rows. smooth: whether every row's estimate uses its whole track."""

    filter: Any
    batch: Batch
    smooth: bool
    outputs: tuple[str, ...]
    lagged: bool = False

    @property
    def time(self) -> Array:
        """Of each row, s."""
        return self.batch.time

    @property
    def offsets(self) -> NDArray[np.int64]:
        """Where tracks begin, and the end."""
        return self.batch.offsets

    def part(self, first: int, end: int) -> BatchSource:
        """Some of the tracks."""
        return replace(self, batch=self.batch.part(first, end))

    def at(self, times: list[Array]) -> Estimate:
        """Every track at its own times. Errors: ValueError for an estimate with a lag."""
        if self.lagged:
            raise ValueError("at: an estimate with a lag is known at its own rows alone; use filter() or smooth()")
        if self.smooth or self.batch.input is not None:
            return self._inserted(times)
        return self._predicted(times)

    def _inserted(self, times: list[Array]) -> Estimate:
        """Rows without a measurement are put in at these times; what the filter or smoother says of them comes back."""
        wider, added = self.batch.with_times(times)
        everything = self.filter._run(wider, None, self._outputs, None, smooth=self.smooth)
        kept = {name: value[added.row] for name, value in everything.results.items()}
        for name, value in kept.items():
            value[added.early] = 0 if name == "status" else np.nan
        return self._estimate(kept, wider.only(added.row, added.offsets))

    def _predicted(self, times: list[Array]) -> Estimate:
        """Each track is run again live, and asked for its predictions on the way."""
        batch, count = self.batch, sum(map(len, times))
        n, modes = len(self.filter.components), len(self.filter.modes)
        shapes = {"x": (n,), "P": (n, n), "mode_probability": (modes,)}
        kept: dict[str, Any] = {
            name: np.full((count, *shapes[name]), np.nan) for name in self._outputs if name != "status"
        }
        status = np.zeros(count, dtype=np.uint8)
        begin = 0
        for track, wanted in enumerate(times):
            for place, now in self._along(track, wanted):
                for name, value in kept.items():
                    value[begin + place] = getattr(now, name)
                status[begin + place] = Status[now.status]
            begin += len(wanted)
        if "status" in self._outputs:
            kept["status"] = status
        rows = np.zeros(count, dtype=np.int64)
        answered = batch.only(rows, np.r_[0, np.cumsum([len(wanted) for wanted in times])].astype(np.int64))
        answered.time[:], answered.z[:] = np.concatenate([*times, np.empty(0)]), np.nan
        return self._estimate(kept, answered)

    def _along(self, track: int, wanted: Array) -> Iterator[tuple[int, Any]]:
        """Which of the times, and the live estimate there, from the first row on."""
        batch, live = self.batch, self.filter.start()
        first, end = int(batch.offsets[track]), int(batch.offsets[track + 1])
        x, P = batch.prior
        if x is not None and P is not None:
            live.begin(x[track], P[track], np.nan)
        order = np.argsort(wanted, kind="stable")
        due = np.searchsorted(batch.time[first:end], wanted[order], "right")  # after so many rows
        place = int(np.searchsorted(due, 0, "right"))
        for row in range(first, end):
            if place == len(order):
                return
            now = live.update(batch.time[row], batch.z[row], **batch.options(row))
            while place < len(order) and due[place] == row - first + 1:
                at = float(wanted[order[place]])
                yield int(order[place]), now if at == batch.time[row] else live.predict(at)
                place += 1

    @property
    def _outputs(self) -> tuple[str, ...]:
        return tuple(name for name in self.outputs if name in ("x", "P", "mode_probability", "status"))

    def _estimate(self, results: dict[str, Any], batch: Batch) -> Estimate:
        f = self.filter
        return Estimate(f.components, f.modes, results, f.non_manoeuvring, source=replace(self, batch=batch))
