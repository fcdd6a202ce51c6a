"""Tables that come one after the other into one file: Parquet, Arrow, CSV and JSON Lines, the last two also as .gz."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import polars as pl

from .errors import InputError
from .packing import maybe_packed
from .text_tables import write_csv, write_json_lines

STREAMED = ("parquet", "arrow", "csv", "jsonl")


def check_streamed(path: Path, kind: str) -> None:
    """Errors: InputError for a format that is written whole."""
    if kind not in STREAMED:
        raise InputError(
            f"{path}: the table is larger than --memory, and {kind} is written whole; "
            "write to .parquet, .csv, .jsonl or .arrow, or give more memory"
        )


def write_stream(tables: Iterator[pl.DataFrame], path: Path, kind: str, *, packed: bool = False) -> None:
    """Write tables of the same columns to `path`; what `tables` raises is raised."""
    if kind in ("csv", "jsonl"):
        with path.open("wb") as handle, maybe_packed(handle, packed, kind) as out:
            for number, table in enumerate(tables):
                if kind == "csv":
                    write_csv(table, out, header=number == 0)
                else:
                    write_json_lines(table, out)
        return
    lazy, failure = _lazy(tables)
    try:
        with path.open("wb") as handle:
            if kind == "parquet":
                lazy.sink_parquet(handle, compression="zstd", compression_level=1)
            else:
                lazy.sink_ipc(handle)
    except pl.exceptions.PolarsError:
        if failure:
            raise failure[0] from None
        raise


def _lazy(tables: Iterator[pl.DataFrame]) -> tuple[pl.LazyFrame, list[BaseException]]:
    """The tables as one that polars takes piece by piece, and the error that ended it, if one did."""
    from polars.io.plugins import register_io_source

    first = next(tables, None)
    if first is None:
        return pl.LazyFrame(), []
    failure: list[BaseException] = []

    def source(columns: Any, predicate: Any, rows: Any, size: Any) -> Iterator[pl.DataFrame]:
        try:
            yield cast(pl.DataFrame, first)
            yield from tables
        except BaseException as error:
            failure.append(error)
            raise

    return register_io_source(source, schema=first.schema), failure
