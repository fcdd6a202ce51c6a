"""Tables that are larger than memory, divided by target: each share is small, and holds whole targets in their order.

The rows are written to temporary files, one for each share and piece of the input, and read back share by share.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import polars as pl

from .columns import Columns
from .errors import InputError
from .identity import choose_target
from .loading import Opened, Reading, together, wanted_names
from .meaning import doubtful
from .measurements import Measurements, target_names
from .pieces import Pieced
from .rejected import SCHEMA
from .sheet import Sheet
from .stages import stage

KEY = "\x00target"
SAMPLE = -1  # the number of the share that tells what holds for all


@dataclass
class Source:
    """One input file: how it is read in pieces, its columns, and which of them are needed."""

    path: Path
    pieced: Pieced
    opened: Opened
    wanted: list[str]
    whole_numbers: bool = False  # whether all identifiers are such, and are read as such

    @classmethod
    def of(cls, path: Path, pieced: Pieced, how: Reading) -> Source:
        """What its first piece shows holds for all of it. Errors: InputError."""
        opened = Opened.of(pieced.table, path, how)
        wanted = list(dict.fromkeys([*wanted_names(opened.file, opened.columns), *opened.carried]))
        first = next(pieced.read(wanted))[0]
        wanted += doubtful(first, opened.columns)
        first = next(pieced.read(wanted))[0]
        sheet = Sheet.of(opened.file, first, opened.columns, opened.conventions)
        choose_target(sheet)
        columns = _settled(opened.columns, sheet)
        return cls(path, pieced, replace(opened, columns=columns, notes=(*opened.notes, *sheet.notes)), wanted)

    def keys(self, frame: pl.DataFrame) -> pl.Series:
        """The target of every row as its measurements name it; empty where there is none."""
        column = self.opened.columns.roles.get("target")
        if column is None:
            return pl.repeat(self.opened.default_target, frame.height, dtype=pl.String, eager=True)
        return target_names(self.typed(frame)[column.name]).fill_null("")

    def count(self) -> pl.DataFrame:
        """Each target of the file and its `rows`; then it is known whether all identifiers are whole numbers."""
        found: list[pl.DataFrame] = []
        column = self.opened.columns.roles.get("target")
        # the targets alone; of Parquet nothing else is read
        wanted = [column.name] if column is not None else self.wanted[:1]
        for frame, _ in self.pieced.read(wanted):
            found.append(pl.DataFrame({"target": self.keys(frame)}).group_by("target").len("rows"))
            if len(found) > 16:
                found = [_summed(found)]
        names = _summed(found)
        numbers = names["target"].replace("", None).cast(pl.Int64, strict=False)
        padded = names["target"].str.contains(r"^0\d").any()
        self.whole_numbers = (
            self.pieced.table.format == "csv"
            and not padded
            and bool((numbers.is_not_null() | (names["target"] == "")).all())
        )
        if self.whole_numbers:
            names = _summed([names.with_columns(numbers.cast(pl.String).fill_null("").alias("target"))])
        return names

    def typed(self, frame: pl.DataFrame) -> pl.DataFrame:
        """The frame with its identifiers as the whole file has them."""
        column = self.opened.columns.roles.get("target")
        if column is None or not self.whole_numbers or frame.schema[column.name] != pl.String:
            return frame
        return frame.with_columns(pl.col(column.name).cast(pl.Int64, strict=False))


def _settled(columns: Columns, sheet: Sheet) -> Columns:
    """The columns with the target that was chosen, as if the user had named it."""
    roles = {role: column for role, column in columns.roles.items() if role != "target"}
    if "target" in sheet:
        roles["target"] = sheet.roles["target"]
    return replace(columns, roles=roles, given=columns.given | ({"target"} & roles.keys()))


@dataclass
class Spill:
    """Shares of all files: `counts` has each target, its `rows` and its `share`."""

    folder: Path
    sources: list[Source]
    counts: pl.DataFrame = field(default_factory=pl.DataFrame)
    rows: int = 0
    unreadable: list[pl.DataFrame] = field(default_factory=list)

    @stage("read")
    def count(self) -> None:
        """Read all files once: which targets there are, and how many rows each has."""
        found = [source.count() for source in self.sources]
        if found:
            self.counts = _summed(found)

    @stage("read")
    def divide(self, most: int, sample: pl.DataFrame | None) -> int:
        """Give every target a share of about `most` rows, in the order of their names; returns how many there are.

        sample: targets of which a share of their own is kept beside, `SAMPLE`.
        """
        counts = self.counts.sort("target")
        share = np.zeros(counts.height, int)
        held, number = 0, 0
        for place, rows in enumerate(counts["rows"].to_list()):
            if held and held + rows > most:
                number, held = number + 1, 0
            share[place], held = number, held + rows
        drawn = pl.lit(False) if sample is None else pl.col("target").is_in(sample["target"].implode())
        self.counts = counts.with_columns(pl.Series("share", share), sample=drawn)
        self._distribute()
        return number + 1

    def _distribute(self) -> None:
        where = self.counts.select(pl.col("target").alias(KEY), "share", "sample")
        for number, source in enumerate(self.sources):
            for piece, (frame, bad) in enumerate(source.pieced.read(source.wanted)):
                self.rows += frame.height + bad.height
                if bad.height:
                    self.unreadable.append(_complete(bad.with_columns(file=pl.lit(source.opened.file))))
                keyed = frame.with_columns(source.keys(frame).alias(KEY)).join(
                    where, on=KEY, how="left", maintain_order="left"
                )
                for (share,), rows in keyed.partition_by("share", as_dict=True, maintain_order=True).items():
                    self._write(rows, int(share), number, piece)
                self._write(keyed.filter("sample"), SAMPLE, number, piece)

    def _write(self, rows: pl.DataFrame, share: int, source: int, piece: int) -> None:
        if rows.height:
            rows.drop(KEY, "share", "sample").write_ipc(self.folder / f"{share}-{source}-{piece}.arrow")

    @stage("read")
    def share(self, number: int) -> Measurements:
        """The measurements of one share; its files are taken away. Errors: InputError."""
        parts, names = [], []
        for place, source in enumerate(self.sources):
            files = sorted(
                self.folder.glob(f"{number}-{place}-*.arrow"), key=lambda path: int(path.stem.split("-")[-1])
            )
            if not files:
                continue
            whole = pl.concat([pl.read_ipc(path) for path in files], how="vertical_relaxed", rechunk=True)
            for path in files:
                path.unlink()
            parts.append(source.opened.measured(source.typed(whole), some=True))
            names.append(source.opened.file)
        return together(parts, names)

    def shares(self, count: int) -> Iterator[Measurements]:
        """All shares, one after the other."""
        for number in range(count):
            yield self.share(number)


def _summed(found: Sequence[pl.DataFrame]) -> pl.DataFrame:
    return pl.concat(found).group_by("target").agg(pl.col("rows").sum())


def _complete(frame: pl.DataFrame) -> pl.DataFrame:
    """Rejected rows with all columns of such."""
    return frame.select(
        (pl.col(name) if name in frame.columns else pl.lit(None)).cast(kind).alias(name)
        for name, kind in SCHEMA.items()
    )


def check_alike(sample: Measurements, share: Measurements, kinds: tuple[frozenset[str], frozenset[str]]) -> None:
    """Errors: InputError where values of a share say something else of the columns than the sample's."""
    if (sample.position, sample.absolute) == (share.position, share.absolute) and kinds[1] <= kinds[0]:
        return
    other = next(iter(sorted(kinds[1] - kinds[0])), "its positions or times are of another kind")
    raise InputError(
        f"the table is too large for --memory, and some of its targets are read in another way than others: {other}. "
        "Name the columns and units (--columns, --altitude-unit, --time-unit), or give more memory"
    )
