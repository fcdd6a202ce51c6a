"""How far a run is: rows, rows per second, and the seconds that its stage will still take."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

Say = Callable[[dict[str, Any]], None]


class Progress:
    """One stage, `map` or `reduce`; every step is said as an event."""

    def __init__(self, say: Say, stage: str, of: int, of_rows: int):
        self.say, self.stage, self.of, self.of_rows = say, stage, of, of_rows
        self.done = self.rows = self.fresh = 0
        self.began = time.perf_counter()

    def step(self, rows: int, *, kept: bool = False) -> None:
        """One more file or bucket; kept: an earlier run had done it."""
        self.done += 1
        self.rows += rows
        self.fresh += 0 if kept else rows
        passed = time.perf_counter() - self.began
        speed = self.fresh / passed if passed > 0 else 0.0
        left = max(0, self.of_rows - self.rows) / speed if speed > 0 else None
        if self.done == self.of:
            left = 0.0
        self.say(
            {
                "event": self.stage,
                "done": self.done,
                "of": self.of,
                "rows": self.rows,
                "rows_per_second": round(speed),
                "seconds_left": None if left is None else round(left, 1),
            }
        )
