"""Memory of results that nobody holds any more, kept for the next ones.

The system clears every page that it hands out, which costs as much as filtering. So blocks of at least SMALLEST bytes
come back here when the last array in them is gone, and the next call of about that size takes them again. What is kept
stays below a sixteenth of the machine's memory; the oldest go first.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Lock

import numpy as np

from ..checks import Array

SMALLEST = 1 << 20  # bytes
SPARE = 1.25  # a block may be so much larger than what is wanted
LINE = 64  # bytes of a cache line

_kept: list[np.ndarray] = []  # the oldest first
_busy = Lock()


def _most() -> int:
    """Bytes that may be kept."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 16
    except (AttributeError, OSError, ValueError):
        return 1 << 28


MOST = _most()


class _Lent:
    """A block in use: an array made of it holds this, and the block is kept again once the last one is gone."""

    def __init__(self, block: np.ndarray, size: int):
        self.block = block
        start = -block.ctypes.data % LINE
        self.__array_interface__ = block[start : start + size].__array_interface__

    def __del__(self) -> None:
        # at the end of the process functions may be gone before the last array
        if keep is not None:
            keep(self.block)


def empty(shape: tuple[int, ...]) -> Array:
    """An array of floats, not set, on a cache line's boundary: there results can be written past the caches."""
    size = 8 * int(np.prod(shape))
    if size < SMALLEST:
        block = np.empty(size + LINE, np.uint8)
        start = -block.ctypes.data % LINE
        return block[start : start + size].view(np.float64).reshape(shape)
    block = _taken(size + LINE)
    if block is None:
        block = np.empty(size + LINE, np.uint8)
    return np.asarray(_Lent(block, size)).view(np.float64).reshape(shape)


@contextmanager
def at_most(size: int) -> Iterator[None]:
    """Within it, no more than so many bytes are kept."""
    global MOST
    before, MOST = MOST, min(MOST, size)
    try:
        yield
    finally:
        MOST = before


def give_back() -> None:
    """Let go of what is kept, and of what was freed before, where the system can take single pages back."""
    with _busy:
        _kept.clear()
    # another C library, or a system without one of its own
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


def keep(block: np.ndarray) -> None:
    """Keep a block for later, if that can be done at once: arrays may end even while another block is taken."""
    if block.nbytes > MOST or not _busy.acquire(blocking=False):
        return
    try:
        _kept.append(block)
        while sum(each.nbytes for each in _kept) > MOST:
            del _kept[0]
    finally:
        _busy.release()


def _taken(size: int) -> np.ndarray | None:
    """The latest kept block that holds `size` bytes and not many more."""
    with _busy:
        for place in range(len(_kept) - 1, -1, -1):
            if size <= _kept[place].nbytes <= SPARE * size + SMALLEST:
                return _kept.pop(place)
    return None
