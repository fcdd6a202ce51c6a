"""Where the time goes: wall and processor seconds of each stage of a run, for `jink track --timings`.

A stage within another one counts instead of it. Where stages run at once, the processor time is shared out evenly.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from threading import Lock, get_ident
from typing import Any, TypeVar

STAGES: tuple[str, ...] = ("read", "recognise", "clean", "place", "noise", "filter", "table", "check", "write")
REST = "rest"  # what no stage is about

F = TypeVar("F", bound=Callable[..., Any])


class Ledger:
    """Seconds by stage, of the process and by the clock, since it was begun."""

    def __init__(self) -> None:
        self.rows = 0  # that were read, once somebody knows
        self.wall: dict[str, float] = dict.fromkeys((*STAGES, REST), 0.0)
        self.cpu: dict[str, float] = dict.fromkeys((*STAGES, REST), 0.0)
        self._open: dict[int, list[str]] = {}  # of each thread, the innermost stage last
        self._busy = Lock()
        self._last = self._now()

    @staticmethod
    def _now() -> tuple[float, float]:
        return time.perf_counter(), time.process_time()

    def enter(self, name: str) -> None:
        """A stage begins in this thread."""
        with self._busy:
            self._account()
            self._open.setdefault(get_ident(), []).append(name)

    def leave(self) -> None:
        """The innermost stage of this thread ends."""
        with self._busy:
            self._account()
            stack = self._open[get_ident()]
            stack.pop()
            if not stack:
                del self._open[get_ident()]

    def figures(self) -> dict[str, dict[str, float]]:
        """Wall and processor seconds of each stage until now."""
        with self._busy:
            self._account()
            return {name: {"wall": self.wall[name], "cpu": self.cpu[name]} for name in self.wall}

    def _account(self) -> None:
        now = self._now()
        wall, cpu = now[0] - self._last[0], now[1] - self._last[1]
        self._last = now
        running = [stack[-1] for stack in self._open.values()] or [REST]
        for name in running:
            self.wall[name] += wall / len(running)
            self.cpu[name] += cpu / len(running)


_ledger: Ledger | None = None


@contextmanager
def recorded() -> Iterator[Ledger]:
    """Stages that end within are written into the ledger."""
    global _ledger
    before, _ledger = _ledger, Ledger()
    try:
        yield _ledger
    finally:
        _ledger = before


def stage(name: str) -> Callable[[F], F]:
    """Decorator: the function is a stage, or a part of one."""
    assert name in STAGES

    def decorate(function: F) -> F:
        @wraps(function)
        def timed(*arguments: Any, **options: Any) -> Any:
            ledger = _ledger
            if ledger is None:
                return function(*arguments, **options)
            ledger.enter(name)
            try:
                return function(*arguments, **options)
            finally:
                ledger.leave()

        return timed  # type: ignore[return-value]

    return decorate
