"""Scans that come late: the tracker goes back to before them and takes the later ones again."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .picture import Picture


class _Taken(NamedTuple):
    """A scan as it was given, its time, the tracker's state and time before it."""

    scan: tuple[Any, ...]
    time: float
    state: bytes
    before: float


class History:
    """The last scans, so many that one of them may be late."""

    def __init__(self, length: int) -> None:
        self.taken: deque[_Taken] = deque(maxlen=length)
        self.late = 0  # plots of scans that were too late to be taken

    def take(
        self,
        time: float,
        scan: tuple[Any, ...],
        now: float,
        save: Callable[[], bytes],
        load: Callable[[bytes], None],
        work: Callable[..., Picture],
    ) -> Picture | None:
        """Take a scan in its place, exactly as if it had come in time; None if that is too long ago."""
        if not time < now:
            self.taken.append(_Taken(scan, time, save(), now))
            return work(*scan)
        kept = list(self.taken)
        first = next((k for k, each in enumerate(kept) if each.time > time), None)
        if first is None or time < kept[first].before:
            self.late += len(np.atleast_1d(scan[1]))
            return None
        load(kept[first].state)
        self.taken.extend(kept[:first])
        picture: Picture | None = None
        before = kept[first].before
        for each, t in ((scan, time), *((k.scan, k.time) for k in kept[first:])):
            self.taken.append(_Taken(each, t, save(), before))
            picture, before = work(*each), t
        return picture
