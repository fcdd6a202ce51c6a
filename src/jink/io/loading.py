"""Many files, or one DataFrame, to one table of measurements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl

from .columns import Columns, recognise
from .errors import InputError
from .files import expand, open_table
from .measurements import Measurements, measure


@dataclass(frozen=True)
class Reading:
    """How columns are to be read: role to name, units where names do not say, coordinates checked or not."""

    columns: Mapping[str, str] | None = None
    altitude_unit: str | None = None
    time_unit: str | None = None
    check_coordinates: bool = True

    def __post_init__(self) -> None:
        from .columns import TIME

        if self.altitude_unit not in (None, "ft", "m"):
            raise InputError(f"altitude_unit is {self.altitude_unit!r}; expected 'ft' or 'm'")
        if self.time_unit is not None and self.time_unit not in TIME:
            raise InputError(f"time_unit is {self.time_unit!r}; expected 's', 'ms', 'us' or 'ns'")


@dataclass(frozen=True)
class Loaded:
    """Measurements of all inputs together; `count` is the number of rows read, rejected ones included."""

    measurements: Measurements
    files: list[str]
    count: int


def load_files(
    inputs: Sequence[str | Path], how: Reading, progress: Callable[[int, int], None] | None = None
) -> Loaded:
    """Read every file or glob pattern; all have to hold the same kind of position and of time."""
    paths = expand(inputs)
    parts: list[Measurements] = []
    count = 0
    for number, path in enumerate(paths):
        table = open_table(path)
        columns = recognise(table.file, table.names, how.columns)
        frame, unreadable = table.read(_wanted(table.file, columns))
        total = frame.height + unreadable.height
        if total == 0:
            raise InputError(f"{table.file} has columns but no rows")
        if frame.height == 0:
            raise InputError(
                f"{table.file}: none of its {total} rows can be read; the first row: {unreadable['reason'][0]}"
            )
        part = measure(
            table.file,
            frame,
            columns,
            altitude_unit=how.altitude_unit,
            time_unit=how.time_unit,
            default_target=path.name.split(".")[0] or "0",
            check_coordinates=how.check_coordinates,
        )
        part.rejected.append(unreadable.with_columns(file=pl.lit(table.file)))
        parts.append(part)
        count += total
        if progress:
            progress(number + 1, len(paths))
    return Loaded(_together(parts, [str(p) for p in paths]), [str(p) for p in paths], count)


def load_frame(frame: pl.DataFrame, how: Reading) -> Loaded:
    """Measurements of a polars DataFrame; `row` is the position in it."""
    columns = recognise("the DataFrame", frame.columns, how.columns)
    if frame.height == 0:
        raise InputError("the DataFrame has columns but no rows")
    wanted = frame.select(_wanted("the DataFrame", columns))
    measurements = measure(
        None,
        wanted.with_row_index("row"),
        columns,
        altitude_unit=how.altitude_unit,
        time_unit=how.time_unit,
        check_coordinates=how.check_coordinates,
    )
    return Loaded(measurements, [], frame.height)


def _wanted(where: str, columns: Columns) -> list[str]:
    """Names of the columns to read; `row` is taken for the row's number."""
    names = sorted({column.name for column in columns.roles.values()})
    if "row" in names:
        raise InputError(f"{where}: a column named 'row' cannot hold measurements; rename it")
    return names


def _together(parts: list[Measurements], files: list[str]) -> Measurements:
    first = parts[0]
    for part, file in zip(parts, files, strict=True):
        if part.position != first.position:
            raise InputError(
                f"{files[0]} holds {first.position} positions and {file} {part.position} ones; "
                "track them separately, or choose the columns with --columns"
            )
        if part.absolute != first.absolute:
            absolute, plain = (file, files[0]) if part.absolute else (files[0], file)
            raise InputError(f"{absolute} has dates and {plain} has plain seconds; their times cannot be compared")
    return Measurements(
        pl.concat([part.rows for part in parts], how="diagonal", rechunk=True),
        [frame for part in parts for frame in part.rejected],
        first.position,
        first.absolute,
        first.named,
        list(dict.fromkeys(note for part in parts for note in part.notes)),
    )
