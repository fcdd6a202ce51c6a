"""The output of an archive: made where it is not there, of one run at a time, and what is said where it is full."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager

import polars as pl

from .errors import Stopped
from .store import Store

FULL = {
    errno.ENOSPC: "the disk is full; make room",
    errno.EFBIG: "a file is larger than the system allows; raise its limit (ulimit -f)",
}
if hasattr(errno, "EDQUOT"):
    FULL[errno.EDQUOT] = "the quota of the disk is used up; make room"


def made(store: Store) -> None:
    """Make the folder. Errors: Stopped where it cannot be made."""
    if not store.local:
        if "/" not in store.where.partition("?")[0].partition("://")[2]:
            raise Stopped(
                f"the output {store.where} is a whole store; give a folder in it, such as {store.named('/tracks')}"
            )
        return
    folder = store.path("")
    if not folder.parent.is_dir():
        raise Stopped(f"the output {folder} cannot be written: there is no directory {folder.parent}")
    if folder.exists() and not folder.is_dir():
        raise Stopped(f"the output {folder} is a file; give the name of a folder")
    folder.mkdir(exist_ok=True)


@contextmanager
def locked(store: Store) -> Iterator[None]:
    """One run at a time in a folder. Errors: Stopped."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    if not store.local:
        yield
        return
    handle = os.open(store.path(""), os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise Stopped(f"another run writes to {store.where}") from None
    finally:
        os.close(handle)


@contextmanager
def room(store: Store) -> Iterator[None]:
    """A disk that is full is said as such. Errors: OSError."""
    try:
        yield
    except (OSError, pl.exceptions.PolarsError) as error:
        for number, what in FULL.items():
            if getattr(error, "errno", None) == number or f"os error {number})" in str(error):
                words = f"{what} and run the same command again, it goes on from here"
                raise OSError(number, words, store.where) from None
        raise
