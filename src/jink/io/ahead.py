"""A compressed file is unpacked while Python still imports what reads it; zlib leaves Python to others meanwhile."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from pathlib import Path
from threading import Thread

from .errors import InputError
from .stages import stage
from .unpacking import gunzip

MOST = 50_000_000  # bytes of a packed file
_begun: dict[Path, _Ahead] = {}


class _Ahead(Thread):
    """Its content is None where it cannot be had: then whoever reads the file says why."""

    def __init__(self, path: Path) -> None:
        super().__init__(daemon=True)
        self.path = path
        self.content: bytes | None = None

    @stage("read")
    def run(self) -> None:
        """Unpack the file."""
        try:
            self.content = gunzip(str(self.path), self.path.read_bytes())
        except (InputError, OSError, EOFError, MemoryError, zlib.error):
            return


def begin(inputs: Sequence[str]) -> None:
    """Unpack the first input, if it is a gzip file of usual size."""
    path = Path(inputs[0])
    if path.suffix == ".gz" and path.is_file() and path.stat().st_size <= MOST:
        _begun[path] = _Ahead(path)
        _begun[path].start()


def unpacked(path: Path) -> bytes | None:
    """The content of a file that was begun, once; None of any other."""
    ahead = _begun.pop(path, None)
    if ahead is None:
        return None
    ahead.join()
    return ahead.content
