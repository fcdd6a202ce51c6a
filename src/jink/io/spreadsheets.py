"""CSV that a spreadsheet opens as text: no cell of it is run as a formula."""

from __future__ import annotations

from pathlib import Path

import polars as pl

from .errors import InputError

# a cell that begins so is a formula, or is after the blanks before it are taken away
STARTS = ("=", "+", "-", "@", "\t", "\r", "\n")
MARK = "'"  # what spreadsheets take for "this is text"


def harmless(table: pl.DataFrame) -> pl.DataFrame:
    """The table with `'` before each text cell and name of a column that begins like a formula; numbers stay."""
    texts = [name for name, kind in table.schema.items() if isinstance(kind, pl.String | pl.Categorical | pl.Enum)]
    begins = "^[" + "".join(f"\\x{ord(start):02x}" for start in STARTS) + "]"
    cells = [pl.col(name).cast(pl.String) for name in texts]
    marked = table.with_columns(
        pl.when(cell.str.contains(begins)).then(pl.lit(MARK) + cell).otherwise(cell).alias(name)
        for cell, name in zip(cells, texts, strict=True)
    )
    return marked.rename({name: MARK + name for name in table.columns if name.startswith(STARTS)})


def check_is_csv(output: Path | str | None, kind: str) -> None:
    """Errors: InputError where cells are to be harmless and the output is no CSV."""
    if kind != "csv":
        raise InputError(f"--safe-csv is for -o tracks.csv or .csv.gz, but the output is {output or 'none'}")
