"""Where an archive lies: a folder, or a bucket of an object store. What has its final name is whole.

In a folder a file is written beside, flushed and renamed. An object store has no rename: an object is made ready in a
local file first and sent in one piece; the store shows it when it is complete.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from .errors import Stopped

WORK = ".jink"  # what is needed to go on and to add files
SPARE = f"{WORK}/spare"  # files that are being written
WITHOUT_FOLDERS = ("s3", "gcs")  # there a folder is an object of no bytes, which nothing needs
URL = re.compile(r"^[a-z][a-z0-9+.-]+://")


@dataclass
class Store:
    """Files by their names below `where`, a folder or a URL such as `s3://bucket/tracks`."""

    where: str
    _opened: Any = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        path, mark, options = (self.where, "", "") if self.local else self.where.partition("?")
        self.where = (path.rstrip("/") or path[:1]) + mark + options

    def __getstate__(self) -> dict[str, Any]:
        return {"where": self.where, "_opened": None}

    @property
    def local(self) -> bool:
        """Whether it is a folder of this machine."""
        return not URL.match(self.where)

    def beside(self) -> tuple[Store, str]:
        """What the folder lies in, and the folder's name."""
        if self.local:
            whole = Path(self.where).absolute()
            return Store(str(whole.parent)), whole.name
        path, mark, options = self.where.partition("?")
        above, _, name = path.rpartition("/")
        return Store(above + mark + options), name

    def named(self, ending: str) -> str:
        """The name of something beside the folder, as people write it."""
        path, mark, options = (self.where, "", "") if self.local else self.where.partition("?")
        return path + ending + mark + options

    def path(self, name: str) -> Path:
        """The file of a folder."""
        return Path(self.where, name)

    def put(self, name: str, write: Callable[[IO[bytes]], Any]) -> int:
        """Write a file whole or not at all; returns its size."""
        if self.local:
            spare = self.path(SPARE)
            spare.mkdir(parents=True, exist_ok=True)
            target = self.path(name)
            target.parent.mkdir(parents=True, exist_ok=True)
            with _temporary(spare) as (path, handle):
                write(handle)
                handle.flush()
                os.fsync(handle.fileno())
                size = handle.tell()
                os.replace(path, target)
            return size
        fs, root = self._remote()
        with tempfile.TemporaryFile() as handle:
            write(handle)
            size = handle.tell()
            handle.seek(0)
            if fs.type_name not in WITHOUT_FOLDERS:
                fs.create_dir(f"{root}/{name}".rpartition("/")[0], recursive=True)
            with fs.open_output_stream(f"{root}/{name}") as out:
                shutil.copyfileobj(handle, out, 1 << 22)
        return size

    def get(self, name: str) -> bytes | None:
        """The content of a file; None where there is none."""
        try:
            if self.local:
                return self.path(name).read_bytes()
            fs, root = self._remote()
            with fs.open_input_file(f"{root}/{name}") as handle:
                return handle.read()
        except FileNotFoundError:
            return None

    def open(self, name: str) -> Any:
        """A file that pyarrow reads pieces of."""
        import pyarrow as pa

        if self.local:
            return pa.memory_map(str(self.path(name)))
        fs, root = self._remote()
        return fs.open_input_file(f"{root}/{name}")

    def names(self) -> list[str]:
        """The names of all files."""
        if self.local:
            folder = Path(self.where)
            return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir())
        from pyarrow.fs import FileSelector, FileType

        fs, root = self._remote()
        found = fs.get_file_info(FileSelector(root, recursive=True, allow_not_found=True))
        return sorted(
            info.path.removeprefix("/").removeprefix(root.removeprefix("/")).removeprefix("/")
            for info in found
            if info.type == FileType.File
        )

    def remove(self, name: str) -> None:
        """Take a file away."""
        if self.local:
            self.path(name).unlink(missing_ok=True)
            return
        fs, root = self._remote()
        with suppress(FileNotFoundError):
            fs.delete_file(f"{root}/{name}")

    def sweep(self) -> None:
        """Take away what a run that was stopped left half written."""
        if self.local:
            shutil.rmtree(self.path(SPARE), ignore_errors=True)

    def _remote(self) -> tuple[Any, str]:
        if self._opened is None:
            self._opened = _connected(self.where)
        return self._opened


def _connected(url: str) -> tuple[Any, str]:
    """A file system of pyarrow, or one of fsspec, and the path in it. Errors: Stopped."""
    from pyarrow import ArrowException, fs

    try:
        if url.startswith("s3://"):
            found, path = _s3(url)
        elif url.startswith(("gs://", "gcs://", "abfs://", "abfss://", "hdfs://", "file://")):
            found, path = fs.FileSystem.from_uri(url)
        else:
            import fsspec

            made, path = fsspec.core.url_to_fs(url)
            found = fs.PyFileSystem(fs.FSSpecHandler(made))
    except (ArrowException, ValueError, OSError, ImportError) as error:
        raise Stopped(f"{url} cannot be opened: {error}") from None
    return found, path.rstrip("/")


def _s3(url: str) -> tuple[Any, str]:
    """Small objects in one request; an older pyarrow sends all of them in parts."""
    from pyarrow import ArrowInvalid, fs

    try:
        return fs.FileSystem.from_uri(f"{url}{'&' if '?' in url else '?'}allow_delayed_open=true")
    except ArrowInvalid:
        return fs.FileSystem.from_uri(url)


@contextmanager
def _temporary(folder: Path) -> Iterator[tuple[str, IO[bytes]]]:
    """A new file, which is taken away unless it was renamed."""
    handle, name = tempfile.mkstemp(dir=folder)
    try:
        with os.fdopen(handle, "wb") as out:
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(name, 0o666 & ~mask)
            yield name, out
    finally:
        Path(name).unlink(missing_ok=True)
