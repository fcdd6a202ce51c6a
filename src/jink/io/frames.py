"""DataFrames of any library to polars and back, by narwhals; without pyarrow, column by column."""

from __future__ import annotations

from typing import Any

import polars as pl

from .errors import InputError


def from_any(data: Any) -> pl.DataFrame:
    """A DataFrame of polars, pandas, PyArrow or anything else that narwhals reads, in polars."""
    if isinstance(data, pl.DataFrame):
        return data
    if isinstance(data, pl.LazyFrame):
        return data.collect()
    import narwhals as nw

    try:
        frame: Any = nw.from_native(data)
    except TypeError:
        raise InputError(
            f"data is a {type(data).__name__}; expected a DataFrame (polars, pandas, PyArrow, ...), "
            "a path or a list of paths"
        ) from None
    if isinstance(frame, nw.LazyFrame):
        frame = frame.collect()
    if frame.implementation.is_pandas_like():
        return pl.DataFrame({name: _series(frame[name]) for name in frame.columns})
    return frame.to_polars()


def _series(column: Any) -> pl.Series:
    """One pandas column: numbers and date-times directly, everything else value by value."""
    import narwhals as nw

    if column.dtype.is_numeric() or column.dtype == nw.Boolean:
        return (
            pl.Series(column.name, column.to_numpy(), nan_to_null=True)
            if not column.is_null().any()
            else _listed(column)
        )
    if column.dtype == nw.Datetime:
        zone = getattr(column.dtype, "time_zone", None)
        plain = column.dt.convert_time_zone("UTC").dt.replace_time_zone(None) if zone else column
        series = pl.Series(column.name, plain.to_numpy().astype("datetime64[us]"))
        return series.dt.replace_time_zone("UTC") if zone else series
    return _listed(column)


def _listed(column: Any) -> pl.Series:
    missing = column.is_null().to_list()
    values = [None if gone else value for value, gone in zip(column.to_list(), missing, strict=True)]
    try:
        return pl.Series(column.name, values)
    except (TypeError, pl.exceptions.PolarsError):
        return pl.Series(column.name, [None if value is None else str(value) for value in values])


def to_same(frame: pl.DataFrame, like: Any) -> Any:
    """`frame` in the library that `like` came from."""
    if isinstance(like, pl.DataFrame):
        return frame
    if isinstance(like, pl.LazyFrame):
        return frame.lazy()
    import narwhals as nw

    backend = nw.get_native_namespace(like)
    if not nw.from_native(like).implementation.is_pandas_like():
        return nw.to_native(nw.DataFrame.from_arrow(frame, backend=backend))
    columns: dict[str, Any] = {}
    zoned = []
    for name, kind in frame.schema.items():
        series = frame[name]
        if isinstance(kind, pl.Datetime):
            zoned.append(name)
            series = series.dt.replace_time_zone(None)
        elif kind == pl.Enum or kind == pl.Categorical:
            series = series.cast(pl.String)
        columns[name] = series.to_numpy() if kind != pl.String and series.dtype != pl.String else series.to_list()
    native = nw.from_dict(columns, backend=backend)
    for name in zoned:
        native = native.with_columns(nw.col(name).dt.replace_time_zone("UTC"))
    return nw.to_native(native)
