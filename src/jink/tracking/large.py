"""Tracks of tables that are larger than memory: share by share, each with the pace, noise and filter of a sample.

The same targets tell the same of a table that is tracked in memory (`prepare.EVIDENCE`), so the tracks are the same.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import polars as pl

from ..io.errors import InputError
from ..io.files import expand, name_of
from ..io.loading import Reading, other_columns
from ..io.measurements import Measurements
from ..io.pieces import pieced, row_count, same_kind
from ..io.spill import SAMPLE, Source, Spill, check_alike
from .batch import implausible, nothing_left
from .prepare import EVIDENCE, Known, Settings, drawn, prepare
from .shares import Ready, Shares, learned_schema

PER_ROW = 800  # bytes of memory that a row takes from its reading to its track
FIXED = 450_000_000  # bytes that the packages, a piece of the input and the tables on their way take
PIECE = 500_000  # rows that are read at once
FEWEST = 100_000  # rows of a share: smaller ones save nothing
MORE = 2.0  # times as much a row of a share takes: the next one is made ready beside it

Progress = Callable[[str, int, int], None]


def fits(inputs: Sequence[str | Path], memory: int) -> bool:
    """Whether all files together can be tracked in so many bytes of memory."""
    return taken(inputs) <= memory


def taken(inputs: Sequence[str | Path]) -> int:
    """About how many bytes of memory it takes to track all files together; known before they are read."""
    return FIXED + PER_ROW * sum(map(row_count, expand(inputs)))


def check_whole(inputs: Sequence[str | Path], memory: int) -> None:
    """Errors: InputError where a table has to be read whole and that takes more memory than was allowed."""
    wanted = taken(inputs)
    if wanted > memory:
        raise InputError(
            f"the table takes about {wanted / 1e9:.1f} GB of memory and --memory allows {memory / 1e9:.1f} GB; it is "
            "needed whole for -o -, --every, several sites, plots without identity, and formats other than "
            "Parquet, Arrow, CSV and JSON Lines"
        )


@dataclass
class Large:
    """Files of which only a share is in memory at a time.

    `tables()` gives the tracks, in the order of their targets; then `summary()` says what was done, and `rejected()`
    has the rows that are in no track.
    """

    spill: Spill
    settings: Settings
    memory: int
    progress: Progress
    sample: Measurements | None = None
    began: float = field(default_factory=clock.perf_counter)
    lost: int = 0

    def __post_init__(self) -> None:
        self.shares = Shares(self.settings, self._keep, "a larger --memory tracks them together")

    @classmethod
    def of(
        cls,
        inputs: Sequence[str | Path],
        how: Reading,
        settings: Settings,
        memory: int,
        folder: Path,
        progress: Progress,
    ) -> Large | None:
        """Made ready; None where the files cannot be divided: a format that is read whole, or rows without identity."""
        sources = []
        for path in expand(inputs):
            read = pieced(path, PIECE)
            if read is None:
                return None
            sources.append(Source.of(path, read, how))
        if any("target" not in source.opened.columns.roles for source in sources):
            return None
        return cls(Spill(folder, sources), settings, memory, progress)

    @property
    def files(self) -> list[str]:
        """The names of the inputs."""
        return [source.opened.file for source in self.spill.sources]

    def tables(self) -> Iterator[pl.DataFrame]:
        """All tracks, with the same columns in every table. Errors: InputError where none is left or plausible."""
        self.spill.count()
        self.progress("reading", 1, 2)
        sample = drawn(self.spill.counts)
        some = sample is not None
        if sample is None and self.spill.counts["rows"].sum() <= EVIDENCE:
            sample = self.spill.counts.select("target")
        most = max(FEWEST, int((self.memory - FIXED) / (MORE * PER_ROW)))
        shares = self.spill.divide(most, sample)
        self.shares.reject(self.spill.unreadable)
        self.progress("reading", 2, 2)
        if sample is not None:
            self.sample = self.spill.share(SAMPLE)
            prepared = prepare(replace(self.sample), self.settings)
            self.shares.known = Known.of(prepared, some=some)
            self.shares.schema = learned_schema(prepared, self.settings, self.sample.absolute)
        for number, share in enumerate(self._ahead(map(self._ready, self.spill.shares(shares)))):
            yield from self.shares.tracks(share)
            self.progress("smoothing" if self.settings.smoothing is not None else "filtering", number + 1, shares)
        tally = self.shares.tally
        if not tally.counts["accepted"]:
            raise InputError(nothing_left(self.spill.rows, tally.refused.most_common()))

    def _ready(self, measurements: Measurements) -> Ready:
        if self.sample is not None:
            kinds = same_kind(self.sample.notes), same_kind(measurements.notes)
            check_alike(self.sample, measurements, kinds)
        return self.shares.ready(measurements)

    def _ahead(self, shares: Iterator[Ready]) -> Iterator[Ready]:
        """The same; each is made ready while the one before it is tracked, unless one thread is all that is allowed."""
        if self.settings.threads == 1:
            yield from shares
            return
        with ThreadPoolExecutor(1) as worker:
            waiting = worker.submit(next, shares, None)
            while (share := waiting.result()) is not None:
                waiting = worker.submit(next, shares, None)
                yield share

    def _keep(self, rejected: pl.DataFrame) -> None:
        rejected.write_ipc(self.spill.folder / f"rejected-{self.lost}.arrow")
        self.lost += 1

    def rejected(self) -> Iterator[pl.DataFrame]:
        """The rows that are in no track."""
        for number in range(self.lost):
            yield pl.read_ipc(self.spill.folder / f"rejected-{number}.arrow")

    def summary(self) -> dict[str, Any]:
        """What was done and found. Errors: InputError where no track is plausible."""
        known, tally = self.shares.known, self.shares.tally
        assert known is not None
        tally.rows = self.spill.rows
        files = [name_of(source.path) for source in self.spill.sources]
        summary, hopeless = tally.summary(files, self.sample, known, self.settings)
        if hopeless:
            raise InputError(implausible(hopeless, tally.counts["targets"]))
        if not self.sample:
            summary["columns"] = self.spill.sources[0].opened.columns.named()
        summary["notes"] += other_columns([(s.opened.file, s.opened.columns.named()) for s in self.spill.sources])
        summary["notes"].append(
            "the table is larger than --memory: it was divided by target, and the noise is that of a sample"
        )
        return summary | {"seconds": clock.perf_counter() - self.began}
