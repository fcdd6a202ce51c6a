"""Files that are written under another name first: complete under their own name, or not there at all.

They lie in folders `.jink-run-*` beside what they become. A run holds a lock on its folders while it lives. A run that
was killed leaves its folder behind, without a lock: the next run that writes there takes it away.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows has no such locks: nothing is taken away there
    fcntl = None

PREFIX = ".jink-run-"


@contextmanager
def atomically(*paths: Path) -> Iterator[list[Path]]:
    """Empty temporary files, one for each path; on success all are renamed into place, on failure none is left.

    Errors: OSError, before anything is done, of a path that no file can have.
    """
    for path in paths:
        with suppress(FileNotFoundError):
            os.lstat(path)
    with ExitStack() as stack:
        folders = {parent: stack.enter_context(folder_in(parent)) for parent in dict.fromkeys(p.parent for p in paths)}
        temporary = [folders[path.parent] / f"{number}.part" for number, path in enumerate(paths)]
        for source in temporary:
            source.touch(0o600, exist_ok=False)
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        for source in temporary:
            os.chmod(source, 0o666 & ~mask)
            _to_disk(source)
        for source, path in zip(temporary, paths, strict=True):
            os.replace(source, path)


@contextmanager
def folder_in(parent: Path | None) -> Iterator[Path]:
    """A folder of this run's own in `parent` (None: where the system has its temporary files); it is removed after."""
    where = Path(tempfile.gettempdir()) if parent is None else parent
    take_away_left(where)
    folder, lock = _locked_folder(where)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def take_away_left(parent: Path) -> None:
    """Remove the folders in `parent` of runs that were killed. What cannot be removed stays."""
    if fcntl is None:
        return
    with suppress(OSError):
        for entry in os.scandir(parent):
            if entry.name.startswith(PREFIX) and entry.is_dir(follow_symlinks=False):
                with suppress(OSError):
                    _remove_if_left(entry.path)


def _remove_if_left(folder: str) -> None:
    assert fcntl is not None
    handle = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        if os.fstat(handle).st_uid == os.geteuid():
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
    finally:
        os.close(handle)


def _locked_folder(parent: Path) -> tuple[Path, int | None]:
    """A new folder and its lock; no lock where the file system has none, since then nobody can remove it either."""
    while True:
        try:
            folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent))
        except OSError as error:  # of the folder that the caller knows
            raise type(error)(error.errno, error.strerror, os.fspath(parent)) from None
        if fcntl is None:
            return folder, None
        try:
            handle = os.open(folder, os.O_RDONLY)
        except FileNotFoundError:
            continue  # another run took it away before it had a lock
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            if folder.exists():
                return folder, handle
        except OSError:
            os.close(handle)
            return folder, None
        os.close(handle)


def _to_disk(path: Path) -> None:
    """So that a file with its final name is whole even after a power cut."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
