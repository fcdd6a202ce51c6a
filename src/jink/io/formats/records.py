"""What a reader of a format hands over: rows under column names that jink knows, and rows that could not be read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import polars as pl

from ...frozen import frozen
from ..rejected import unreadable


@dataclass
class Refused:
    """Rows of a file that could not be read: number, reason, beginning of their text."""

    rows: list[int] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    values: list[str] = field(default_factory=list)

    def add(self, row: int, reason: str, value: object) -> None:
        """One row more."""
        self.rows.append(row)
        self.reasons.append(reason)
        self.values.append(whole_text(str(value)[:80]))


@frozen
class Records:
    """A file read whole: `frame` has `row` and the columns, `fixed` says what some of them are (role: name)."""

    frame: pl.DataFrame
    refused: pl.DataFrame
    notes: tuple[str, ...] = ()
    fixed: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        rows: Sequence[Mapping[str, Any]],
        refused: Refused | None = None,
        notes: Sequence[str] = (),
        fixed: Mapping[str, str] | None = None,
    ) -> Records:
        """From one dictionary per row, `row` among its entries; a column of mixed types becomes text."""
        names = dict.fromkeys(name for row in rows for name in row if name != "row")
        columns = {name: _series(whole_text(name), [row.get(name) for row in rows]) for name in names}
        numbers = pl.Series("row", [row["row"] for row in rows], dtype=pl.UInt32)
        bad = refused or Refused()
        return cls(
            pl.DataFrame([numbers, *columns.values()]),
            unreadable(bad.rows, bad.reasons, bad.values),
            tuple(notes),
            fixed or {},
        )

    @property
    def names(self) -> list[str]:
        """The columns without the row's number."""
        return [name for name in self.frame.columns if name != "row"]

    def read(self, wanted: Sequence[str]) -> tuple[pl.DataFrame, pl.DataFrame]:
        """The wanted columns of every row, and the rows that could not be read."""
        return self.frame.select("row", *wanted), self.refused


def _series(name: str, values: list[Any]) -> pl.Series:
    """Numbers, flags or text; anything else as text, value by value."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float}:
        try:
            return pl.Series(name, values, dtype=pl.Float64 if float in kinds else pl.Int64, strict=False)
        except (TypeError, OverflowError, pl.exceptions.PolarsError):
            pass
    if kinds == {bool}:
        return pl.Series(name, values, dtype=pl.Boolean)
    return pl.Series(name, [None if value is None else whole_text(str(value)) for value in values], dtype=pl.String)


def whole_text(text: str) -> str:
    """Text without halves of characters, which damaged JSON can hold and no file can."""
    return text.encode("utf-8", errors="replace").decode("utf-8")


@frozen
class Format:
    """One format: how it is told by its beginning, how it is read, and what its rows hold (for the docs).

    recognises takes the first 64 kB of the content; read takes the file's name, for messages, and its content.
    """

    title: str
    recognises: Callable[[bytes], bool]
    read: Callable[[str, bytes], Records]
    row: str
    columns: str
    time: str
    noise: str = "estimated"
