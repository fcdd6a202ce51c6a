"""Text to gzip files, in members that several threads pack at the same time."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import IO, cast

from .stages import stage

MEMBER = 1 << 22  # bytes of text in one member
LEVEL = 1  # of zlib: six times as fast as 6, 7 % larger
# Digits of measured numbers hardly repeat: without a search for what does, packing takes two thirds of the time.
# Such files are up to a tenth larger. Names of keys do repeat, so JSON and maps are searched.
STRATEGIES = {"csv": zlib.Z_HUFFMAN_ONLY}


@contextmanager
def maybe_packed(handle: IO[bytes], packed: bool, kind: str = "") -> Iterator[IO[bytes]]:
    """The handle, or one whose bytes are packed on their way to it. kind: the format, as in `writing.FORMATS`."""
    if not packed:
        yield handle
        return
    out = Packed(handle, STRATEGIES.get(kind, zlib.Z_DEFAULT_STRATEGY))
    yield cast(IO[bytes], out)
    out.finish()


class Packed:
    """Bytes to the members of a gzip file, several of them packed at the same time."""

    def __init__(self, handle: IO[bytes], strategy: int = zlib.Z_DEFAULT_STRATEGY) -> None:
        self.handle, self.strategy = handle, strategy
        self.pool = ThreadPoolExecutor(os.cpu_count() or 1)
        self.waiting: list[Future[bytes]] = []
        self.held = bytearray()

    def write(self, text: bytes) -> int:
        """Take some bytes more."""
        view = memoryview(text)
        while len(self.held) + len(view) >= MEMBER:
            size = MEMBER - len(self.held)
            self._pack(b"".join((self.held, view[:size])))
            self.held.clear()
            view = view[size:]
        self.held += view
        return len(text)

    def flush(self) -> None:
        """Nothing: members have a size of their own."""

    def finish(self) -> None:
        """Write what is left."""
        if self.held or not self.waiting:
            self._pack(bytes(self.held))
        for member in self.waiting:
            self.handle.write(member.result())
        self.pool.shutdown()

    def _pack(self, text: bytes) -> None:
        self.waiting.append(self.pool.submit(_member, text, self.strategy))
        if len(self.waiting) > 2 * (os.cpu_count() or 1):
            self.handle.write(self.waiting.pop(0).result())


def _member(text: bytes, strategy: int) -> bytes:
    pack = zlib.compressobj(LEVEL, wbits=31, strategy=strategy)
    return pack.compress(text) + pack.flush()


@stage("write")
def compress(path: Path, kind: str = "") -> None:
    """Replace a file's content by its gzip form. kind: its format."""
    plain = path.with_name(f"{path.name}.plain")
    os.replace(path, plain)
    try:
        with plain.open("rb") as source, path.open("wb") as handle, maybe_packed(handle, True, kind) as out:
            while text := source.read(MEMBER):
                out.write(text)
    finally:
        plain.unlink(missing_ok=True)
