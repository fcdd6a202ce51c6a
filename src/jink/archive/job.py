"""What every worker is told, and the names of what it leaves in the store."""

from __future__ import annotations

import json
from typing import Any

from ..frozen import frozen
from ..io.loading import Reading
from ..models.provenance import VERSION
from ..tracking.prepare import Settings
from .errors import Stopped
from .hashing import probe
from .store import WORK, Store


def versions() -> dict[str, Any]:
    """What must be the same wherever a part of the work is done."""
    import polars

    return {"jink": VERSION, "polars": polars.__version__, "hash": probe()}


@frozen
class Job:
    """Files, how they are read and tracked, into how many buckets, and where to.

    files: the path of each, and its name as it was given; piece: rows of a file that are measured at once; made_by: the
    versions of who planned it.
    """

    files: tuple[tuple[str, str], ...]
    reading: Reading
    settings: Settings
    buckets: int
    piece: int
    store: Store
    made_by: dict[str, Any]

    def check(self) -> None:
        """Errors: Stopped where this worker has another version than who planned the job."""
        mine = versions()
        for name, wanted in self.made_by.items():
            if mine[name] != wanted:
                raise Stopped(
                    f"a worker has {name} {mine[name]}, but the archive is made with {wanted}; "
                    "install the same versions everywhere"
                )

    def said(self, name: str) -> dict[str, Any] | None:
        """What a finished step says; None where it is not finished."""
        text = self.store.get(name)
        return None if text is None else json.loads(text)

    def say(self, name: str, body: dict[str, Any]) -> None:
        """A step is finished."""
        text = json.dumps(body, ensure_ascii=False, sort_keys=True).encode()
        self.store.put(name, lambda handle: handle.write(text))


def slices(number: int) -> str:
    """The rows of an input file, by bucket."""
    return f"{WORK}/map/{number:05d}.arrow"


def targets(number: int) -> str:
    """The targets of an input file, and how many rows each has."""
    return f"{WORK}/map/{number:05d}.targets.arrow"


def unread(number: int) -> str:
    """The rows of an input file that cannot be used."""
    return f"{WORK}/map/{number:05d}.rejected.arrow"


def mapped(number: int) -> str:
    """Says that an input file is divided."""
    return f"{WORK}/map/{number:05d}.json"


def tracks(bucket: int) -> str:
    """The tracks of a bucket."""
    return f"bucket={bucket:03d}/part.parquet"


def left_out(bucket: int) -> str:
    """The rows of a bucket that are in no track."""
    return f"{WORK}/reduce/{bucket:03d}.rejected.arrow"


def reduced(bucket: int) -> str:
    """Says that a bucket is tracked."""
    return f"{WORK}/reduce/{bucket:03d}.json"
