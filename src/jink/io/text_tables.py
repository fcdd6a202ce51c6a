"""Text tables into an open file: CSV and JSON Lines.

The engine makes the text. Columns of kinds that it does not write (lists, durations) make polars write the table.

polars hands over 32 MB of JSON Lines at a time. Linux then looks for free pages that are as large, and where memory is
in pieces this can cost more than making the text. So both write little at a time.
"""

from __future__ import annotations

import io
from typing import IO

import numpy as np
import polars as pl

from .._engine import native

BYTES = 1 << 18  # of one write
ROWS = 1 << 14  # made at a time: columns in other pieces than the rest of their table are copied on the way


def write_csv(table: pl.DataFrame, handle: IO[bytes], *, header: bool = True) -> None:
    """Write rows as CSV; nulls are empty, date-times as `plain_times` has them."""
    _write(table, handle, native.TextFormat.csv, header)


def write_json_lines(table: pl.DataFrame, handle: IO[bytes]) -> None:
    """Write rows as JSON Lines; numbers that JSON lacks are null, date-times as `plain_times` has them."""
    _write(table, handle, native.TextFormat.json)


def json_lines(table: pl.DataFrame) -> str:
    """The text that `write_json_lines` writes."""
    text = io.BytesIO()
    write_json_lines(table, text)
    return text.getvalue().decode()


def plain_times(table: pl.DataFrame) -> pl.DataFrame:
    """Date-times as ISO 8601 in UTC with a Z, which every reader understands."""
    times = [name for name, kind in table.schema.items() if isinstance(kind, pl.Datetime)]
    return table.with_columns(pl.col(name).dt.strftime("%Y-%m-%dT%H:%M:%S%.6fZ") for name in times)


def _write(table: pl.DataFrame, handle: IO[bytes], form: native.TextFormat, header: bool = False) -> None:
    """Write rows with the engine, and with polars where it lacks a kind."""
    held = np.empty(BYTES, np.uint8)
    for start in range(0, max(table.height, int(header)), ROWS):
        part, first = table.slice(start, ROWS), header and start == 0
        if rows := _rows(part, form, first):
            while size := rows.fill(held):
                handle.write(held.data[:size])
            continue
        text = io.BytesIO()
        if form == native.TextFormat.csv:
            plain_times(part).write_csv(text, include_header=first)
        else:
            plain_times(part).write_ndjson(text)
        whole = text.getbuffer()
        for begin in range(0, len(whole), BYTES):
            handle.write(whole[begin : begin + BYTES])


def _rows(table: pl.DataFrame, form: native.TextFormat, header: bool) -> native.TextRows | None:
    """The rows as text; None where the engine lacks a kind."""
    # polars ends the process where a name has a NUL that Arrow's names cannot have
    if "\0" in "".join(table.columns) or any(kind.is_nested() for kind in table.schema.values()):
        return None
    rows = native.TextRows(table, form, header)
    return rows if rows.supported else None
