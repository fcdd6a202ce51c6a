"""Rows of a stream whose times do not go on: late rows, stamps that are wrong, clocks that were set.

A row before its target's last one waits. If the next rows go on from the old time, it was late and is rejected; if
they go on from the row that waits, the clock was set (or a recording began again), and a new part begins with them. A
stamp far ahead begins a new part too; when the next row goes on from before it, that one stamp was wrong.
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field
from typing import Any

import polars as pl

HELD = 4  # rows that go on from an earlier time: a clock that was set, not rows that come late
DAY = 86_400.0


@dataclass(frozen=True, slots=True)
class Waiting:
    """A row that waits for those after it, as a dictionary and as a table of one row with its number in the stream."""

    row: dict[str, Any]
    table: pl.DataFrame


@dataclass(slots=True)
class Order:
    """What is known of the times of one target."""

    waiting: list[Waiting] = field(default_factory=list)
    before: Any = None  # the target as it was before its latest part began
    ended: bool = False  # whether the next row begins a new part

    def late(self, waiting: Waiting) -> tuple[list[Waiting], list[Waiting]]:
        """One more row before the last time: rows that can be used now (then the clock was set), rows that cannot."""
        lost: list[Waiting] = []
        if self.waiting and waiting.row["time"] <= self.waiting[-1].row["time"]:
            lost, self.waiting = self.waiting, []
        self.waiting.append(waiting)
        if len(self.waiting) < HELD:
            return [], lost
        ready, self.waiting, self.ended = self.waiting, [], True
        return ready, lost

    def given_up(self) -> list[Waiting]:
        """The rows that waited in vain."""
        lost, self.waiting = self.waiting, []
        return lost


def tomorrow() -> float:
    """The end of the next 24 hours, in seconds since 1970."""
    return clock.time() + DAY
