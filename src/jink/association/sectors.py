"""Plots of a turning antenna as they come, sector by sector instead of turn by turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import positive, whole
from ..times import seconds
from .picture import Picture
from .tracker import Tracker

CLAIMED = 0.5  # a plot that is no track's with less than this is not offered again


class Sectors:
    """Gives a :class:`jink.Tracker` the plots of an antenna that turns, with ``count`` sectors to a turn.

    A sector is a scan: the tracks that are predicted in it are seen or missed, once in a turn. It waits until the next
    sector has closed, so that a track at the border may have its plot on either side. Each track is predicted to the
    time of the plot nearest to it. period: seconds of a turn; sensor: its name, where the tracker has several;
    clockwise: from north over east, as most antennas turn.
    Errors: ValueError naming the argument.
    """

    def __init__(
        self, tracker: Tracker, period: float, sensor: str | None = None, count: int = 16, *, clockwise: bool = True
    ) -> None:
        if not isinstance(tracker, Tracker):
            raise TypeError(f"tracker: expected a Tracker, got {type(tracker).__name__}")
        if tracker.history:
            raise ValueError("tracker: sectors cannot come late; expected one without history=")
        self.tracker, self.sensor = tracker, sensor
        self.period = positive("period", period)
        self.count = whole("count", count, 3, 3600)
        self.sense = 1.0 if clockwise else -1.0
        which = tracker._index(sensor)
        self.model = tracker._models[which]
        _, (x, y, _) = list(tracker.radars.values())[which].limits()
        self.site = np.array([x, y])
        self.at: tuple[float, float] | None = None  # time and place of the newest plot, in sectors since the first turn
        self.next = 0  # sector that is done next
        self.waiting: list[_Plots] = []
        self.number = 0  # of plots so far

    def take(self, times: ArrayLike, plots: ArrayLike) -> list[Picture]:
        """Plots (m, components) and their times (m,), in order of time; the pictures of the sectors that they close.

        Of a picture ``plot`` counts the plots as they were taken, from 0; its report has the turn, the sector, and as
        "offered" the numbers of the plots that ``lone`` is of.
        """
        return list(self.each(times, plots))

    def each(self, times: ArrayLike, plots: ArrayLike) -> Iterator[Picture]:
        """As :meth:`take`, one picture at a time, so that the tracker stands where that picture was taken."""
        z = self.tracker._plots(plots, self.tracker._index(self.sensor))
        when = np.asarray(seconds(times), float).reshape(-1)
        if len(when) != len(z) or not np.isfinite(when).all():
            raise ValueError(f"times: expected a time for each of {len(z)} plots")
        if (np.diff(when) < 0).any() or (self.at is not None and len(when) and when[0] < self.at[0]):
            raise ValueError("times: plots of sectors must be in order of time")
        points = self.model.positions(z)[:, :2] - self.site
        turned = self.sense * np.arctan2(points[:, 0], points[:, 1]) / (2 * np.pi) % 1.0 * self.count
        for t, row, own in zip(when.tolist(), z, turned.tolist(), strict=True):
            if np.isfinite(own):
                place = self._place(t, own)
                self.waiting.append(_Plots(int(place), t, row, self.number))
                yield from self._close(int(place) - 1)
            self.number += 1

    def finish(self) -> list[Picture]:
        """The pictures of the sectors that still wait, at the end."""
        return list(self.rest())

    def rest(self) -> Iterator[Picture]:
        """As :meth:`finish`, one picture at a time."""
        if self.at is not None:
            yield from self._close(int(self.at[1]) + 1)

    def _place(self, t: float, own: float) -> float:
        """Where the antenna was, in sectors since the first turn; own: in sectors from north."""
        if self.at is None:
            self.at, self.next = (t, own), int(own)
            return own
        expected = self.at[1] + (t - self.at[0]) / self.period * self.count
        place = own + self.count * round((expected - own) / self.count)
        # a plot of a sector that is done belongs to the one that is not
        place = max(place, float(self.next))
        self.at = t, max(place, self.at[1])
        return place

    def _close(self, before: int) -> Iterator[Picture]:
        """Every sector before this one is done."""
        while self.next < before:
            self.next += 1
            yield self._scan(self.next - 1)

    def _scan(self, n: int) -> Picture:
        assert self.at is not None
        here = [p for p in self.waiting if p.sector <= n + 1]
        waits = np.array([p.sector > n for p in here], np.int64)
        z = np.array([p.row for p in here]).reshape(len(here), self.tracker._columns[self.tracker._index(self.sensor)])
        turn, k = divmod(n, self.count)
        width = 2 * np.pi / self.count
        first = k if self.sense > 0 else self.count - 1 - k
        sector = (self.period, first * width, (first + 1) * width, 1.0 / self.count, k == self.count - 1, waits)
        middle = self.at[0] - (self.at[1] - (n + 0.5)) * self.period / self.count
        now = self.tracker._many.time
        t = middle if np.isnan(now) else max(middle, now)
        own = np.array([p.time for p in here]) if here else None
        picture = self.tracker._scan(t, z, self.sensor, None, None, own, sector)
        free = [p for p, lone in zip(here, picture.lone, strict=True) if p.sector > n and not lone < CLAIMED]
        self.waiting = free + [p for p in self.waiting if p.sector > n + 1]
        numbers = np.array([p.number for p in here], np.int64)
        plot = np.where(picture.plot >= 0, numbers[picture.plot] if len(numbers) else -1, -1)
        return replace(picture, plot=plot, report={**picture.report, "turn": turn, "sector": k, "offered": numbers})


class _Plots:
    """One plot that waits: its sector, time, row and number."""

    __slots__ = ("number", "row", "sector", "time")

    def __init__(self, sector: int, time: float, row: NDArray[np.float64], number: int) -> None:
        self.sector, self.time, self.row, self.number = sector, time, row, number
