"""What no archive can do without: its input read, its rows filtered and its tracks written, each alone, one thread."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from jink._engine import native
from jink.archive.reducing import parquet_options
from jink.io.loading import Reading, load_files
from jink.tracking.prepare import Settings, prepare
from jink.tracking.stretches import OUTPUTS


class Clock:
    """Processor seconds by what they were spent on."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def on(self, name: str) -> Iterator[None]:
        """While it is done."""
        began = time.process_time()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - began


def floor(files: Sequence[Path], output: Path) -> str:
    """Processor time of a row; output: a folder of tracks of these files, whose tables are written again."""
    native.keep_freed_memory()
    clock, rows = Clock(), 0
    for file in files:
        with clock.on("read"):
            pq.read_table(file, use_threads=False)
    # that of one file has the same models and costs as much as that of all
    prepared = prepare(load_files([str(files[0])], Reading()).measurements, replace(Settings(), threads=1))
    group = prepared.groups[0]
    noise = group.level.covariance[:1]
    spare = output.with_name("floor.parquet")
    for path in sorted(output.glob("bucket=*/*")):
        source = pq.ParquetFile(path)
        with spare.open("wb") as handle:
            with pq.ParquetWriter(handle, source.schema_arrow, **parquet_options(source.schema_arrow)) as writer:
                for number in range(source.num_row_groups):
                    table = source.read_row_group(number)
                    rows += table.num_rows
                    with clock.on("write"):
                        writer.write_table(table)
                    filtered(clock, group.filter, noise, table)
            with clock.on("write"):
                handle.flush()
                os.fsync(handle.fileno())
    spare.unlink()
    each = {name: seconds / rows * 1e6 for name, seconds in clock.seconds.items()}
    words = ", ".join(f"{name} {cost:.2f}" for name, cost in each.items())
    return f"floor: {sum(each.values()):.2f} us of CPU a row ({words}), nothing divided, cleaned, looked at or checked"


def filtered(clock: Clock, filter: Any, noise: np.ndarray, table: pa.Table) -> None:
    """The rows of a table through the filter, as archives ask for it."""
    time_of = np.asarray(table["time"].cast(pa.int64())) / 1e6
    z = np.column_stack([np.asarray(table[f"measured_{axis}"]) for axis in "xyz"])
    target = np.asarray(table["target"].combine_chunks().dictionary_encode().indices)
    part = np.asarray(table["part"])
    new = (np.diff(target, prepend=-1) != 0) | (np.diff(part, prepend=-1) != 0)
    offsets = np.append(np.flatnonzero(new), len(new))
    covariance = np.repeat(noise, len(z), axis=0)
    with clock.on("filter"):
        filter.filter(time_of, z, offsets=offsets, covariance=covariance, threads=1, outputs=OUTPUTS)
