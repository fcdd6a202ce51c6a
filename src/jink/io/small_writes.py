"""Text tables into an open file in small writes.

polars writes 32 MB of JSON Lines at a time. Linux then looks for free pages that are as large, and where memory is in
pieces this can cost more than making the text.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any, cast

import polars as pl

BYTES = 1 << 18  # of one write
ROWS = 1 << 14  # of JSON Lines that polars makes at a time: some 23 MB of tracks


class SmallWrites:
    """Hands bytes on to a file in small writes, and keeps the error that ended them."""

    def __init__(self, handle: IO[bytes]) -> None:
        self.handle = handle
        self.failure: BaseException | None = None

    def write(self, text: bytes) -> int:
        """Write all of it. Errors: those of the file."""
        view = memoryview(text)
        try:
            for start in range(0, len(view), BYTES):
                self.handle.write(view[start : start + BYTES])
        except BaseException as error:
            self.failure = error
            raise
        return len(view)

    def flush(self) -> None:
        """Nothing: the file is flushed by whoever opened it."""


@contextmanager
def _small(handle: IO[bytes]) -> Iterator[Any]:
    """A file for polars, which raises the file's own error in place of what polars makes of it."""
    small = SmallWrites(handle)
    try:
        yield cast(Any, small)
    except Exception:
        if small.failure is not None:
            raise small.failure from None
        raise


def write_csv(table: pl.DataFrame, handle: IO[bytes], *, header: bool = True) -> None:
    """Write rows as CSV."""
    with _small(handle) as small:
        table.write_csv(small, include_header=header)


def write_json_lines(table: pl.DataFrame, handle: IO[bytes]) -> None:
    """Write rows as JSON Lines, a stretch after the other, so that the text of few rows is in memory."""
    with _small(handle) as small:
        for start in range(0, table.height, ROWS):
            table.slice(start, ROWS).write_ndjson(small)
