"""The tracks of a folder, group of rows by group of rows, and those of single targets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import polars as pl

from . import job as names
from .errors import Stopped
from .hashing import bucket_of
from .manifest import incomplete, manifest_of
from .store import Store


class Tracks:
    """The tracks of a complete folder. Errors: Stopped where it is not complete."""

    def __init__(self, path: str | Path) -> None:
        self.store = Store(str(path))
        manifest = manifest_of(self.store)
        if manifest is None:
            raise incomplete(path)
        self.summary: dict[str, Any] = manifest["summary"]
        self._count = len(manifest["buckets"])
        self.buckets = [each["bucket"] for each in manifest["buckets"] if each["bytes"]]

    def frames(self, bucket: int, columns: Sequence[str] | None = None) -> Iterator[pl.DataFrame]:
        """The rows of a bucket, as its file groups them; of the wanted columns those that are there."""
        with self._opened(bucket) as file:
            there = None if columns is None else [name for name in columns if name in file.schema_arrow.names]
            for group in range(file.num_row_groups):
                yield pl.DataFrame(pl.from_arrow(file.read_row_group(group, columns=there)))

    def spans(self, bucket: int) -> Iterator[tuple[Any, Any]]:
        """First and last time of each group of rows, from the file's statistics."""
        with self._opened(bucket) as file:
            found = file.metadata
            column = found.schema.names.index("time")
            for group in range(found.num_row_groups):
                said = found.row_group(group).column(column).statistics
                yield said.min, said.max

    def of_targets(self, targets: Sequence[str]) -> pl.DataFrame:
        """All rows of these targets. Errors: Stopped for a name that is not there."""
        wanted = pl.Series("target", list(dict.fromkeys(targets)), dtype=pl.String)
        frames = []
        for bucket in bucket_of(wanted, self._count).unique().sort():
            if bucket in self.buckets:
                frames += [
                    frame.filter(pl.col("target").cast(pl.String).is_in(wanted.implode()))
                    for frame in self.frames(bucket)
                ]
        found = pl.concat(frames) if frames else pl.DataFrame(schema={"target": pl.String})
        missing = set(wanted) - set(found["target"].cast(pl.String).unique())
        if missing:
            raise Stopped(f"{self.store.where} has no track of {', '.join(sorted(missing))}")
        return found

    @contextmanager
    def _opened(self, bucket: int) -> Iterator[Any]:
        """The Parquet file of a bucket. Errors: Stopped, with its name, where it is damaged."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        name = names.tracks(bucket)
        try:
            with self.store.open(name) as handle:
                yield pq.ParquetFile(handle)
        except pa.ArrowInvalid as error:
            raise Stopped(f"{self.store.named('/' + name)} is damaged: {str(error).splitlines()[0]}") from None
