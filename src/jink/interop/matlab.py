"""MATLAB: tables of tracks or truth as a struct of columns in a .mat file, and back."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import polars as pl

from ..io.frames import from_any
from .needed import needed

LONGEST = 63  # characters of a field's name
KINDS = "kinds_of_columns"


def write_mat(path: str | os.PathLike[str], **tables: Any) -> None:
    """Each table (a DataFrame) as a struct of column vectors under its name; text becomes a cell array.

    Times with a date become seconds since 1970-01-01 UTC: ``datetime(tracks.time, ConvertFrom="posixtime")``. Missing
    numbers are NaN. Errors: ValueError for names that MATLAB does not take.
    """
    out: dict[str, Any] = {}
    for name, table in tables.items():
        frame = from_any(table)
        for column in frame.columns:
            if not column.isidentifier() or len(column) > LONGEST or column == KINDS or column[0] == "_":
                raise ValueError(f"{name}: MATLAB takes no field called {column!r}; rename the column")
        kinds = {column: kind for column in frame.columns if (kind := _kind(frame[column]))}
        fields = {column: _written(frame[column]) for column in frame.columns}
        out[name] = fields | {KINDS: kinds or {"none": ""}}
    needed("scipy.io").savemat(os.fspath(path), out, long_field_names=True, oned_as="column", do_compression=True)


def read_mat(path: str | os.PathLike[str]) -> dict[str, pl.DataFrame]:
    """Every struct of equally long columns in a file as a table, by its name; other variables are left out."""
    found = needed("scipy.io").loadmat(os.fspath(path), simplify_cells=False, chars_as_strings=True)
    tables = {}
    for name, value in found.items():
        if isinstance(value, np.ndarray) and value.dtype.names and value.size == 1:
            fields = {field: value[field].item() for field in value.dtype.names}
            kinds = fields.pop(KINDS, None)
            known = (
                {field: str(np.ravel(kinds[field].item())[0]) for field in kinds.dtype.names} if _named(kinds) else {}
            )
            columns = {field: np.ravel(each) for field, each in fields.items()}
            if columns and len({len(each) for each in columns.values()}) == 1:
                tables[name] = pl.DataFrame(
                    [_read(field, each, known.get(field, "")) for field, each in columns.items()]
                )
    return tables


def _named(kinds: Any) -> bool:
    return isinstance(kinds, np.ndarray) and bool(kinds.dtype.names) and "none" not in (kinds.dtype.names or ())


def _kind(column: pl.Series) -> str:
    """What the numbers of a column were, where they do not tell."""
    if column.dtype.is_temporal():
        return "utc" if getattr(column.dtype, "time_zone", None) else "date"
    if column.dtype == pl.Boolean:
        return "flag"
    return "whole" if column.dtype.is_integer() else ""


def _written(column: pl.Series) -> np.ndarray:
    if column.dtype.is_temporal():
        micros = column.cast(pl.Datetime("us", getattr(column.dtype, "time_zone", None))).dt.timestamp("us")
        return micros.cast(pl.Float64).fill_null(np.nan).to_numpy() / 1e6
    if column.dtype.is_numeric() or column.dtype == pl.Boolean:
        return column.cast(pl.Float64).fill_null(np.nan).to_numpy()
    return np.array(column.cast(pl.String).fill_null("").to_list(), dtype=object)


def _read(name: str, values: np.ndarray, kind: str) -> pl.Series:
    if values.dtype == object:
        return pl.Series(name, [str(np.ravel(each)[0]) if np.size(each) else None for each in values])
    if values.dtype.kind == "U":
        return pl.Series(name, [str(each) for each in values])
    numbers = pl.Series(name, values.astype(float), nan_to_null=True)
    if kind in ("utc", "date"):
        when = (numbers * 1e6).round().cast(pl.Int64).cast(pl.Datetime("us"))
        return when.dt.replace_time_zone("UTC") if kind == "utc" else when
    return numbers.cast(pl.Boolean) if kind == "flag" else numbers.cast(pl.Int64) if kind == "whole" else numbers
