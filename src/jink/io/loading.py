"""Many files, or one DataFrame, to one table of measurements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import polars as pl

from .columns import Columns, recognise
from .conventions import Conventions
from .errors import InputError
from .files import Rows, Table, expand, name_of, open_table
from .layouts import Layout, layout_of
from .meaning import doubtful
from .measurements import Measurements, measure
from .stages import stage


@dataclass(frozen=True)
class Reading:
    """How columns are to be read: role to name, units where names do not say, coordinates checked or not, and the
    conventions of times and axes.
    """

    columns: Mapping[str, str] | None = None
    altitude_unit: str | None = None
    time_unit: str | None = None
    check_coordinates: bool = True
    conventions: Conventions = field(default_factory=Conventions)

    def __post_init__(self) -> None:
        from .units import TIME

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


@dataclass(frozen=True)
class Opened:
    """A file whose columns are recognised, and how its rows become measurements."""

    file: str
    columns: Columns
    conventions: Conventions
    notes: tuple[str, ...]
    default_target: str
    how: Reading

    @classmethod
    def of(cls, table: Table, path: Path, how: Reading) -> Opened:
        """By the names of its columns. Errors: InputError."""
        columns, conventions, notes = recognised(table.file, table.names, how, table.fixed)
        default = name_of(Path(path.name)).split(".")[0] or "0"
        return cls(table.file, columns, conventions, (*table.notes, *notes), default, how)

    def measured(self, frame: pl.DataFrame, *, some: bool = False) -> Measurements:
        """Measurements of its rows; some: there are more rows. Errors: InputError."""
        part = measure(
            self.file,
            frame,
            self.columns,
            altitude_unit=self.how.altitude_unit,
            time_unit=self.how.time_unit,
            default_target=self.default_target,
            check_coordinates=self.how.check_coordinates,
            conventions=self.conventions,
            some=some,
        )
        part.notes[:0] = self.notes
        return part


def load_files(
    inputs: Sequence[str | Path], how: Reading, progress: Callable[[int, int], None] | None = None
) -> Loaded:
    """Read every file or glob pattern; all have to hold the same kind of position and of time."""
    paths = expand(inputs)
    parts: list[Measurements] = []
    count = 0
    for number, path in enumerate(paths):
        table = open_table(path)
        opened = Opened.of(table, path, how)
        frame, unreadable = _read(table, opened.columns)
        total = frame.height + unreadable.height
        if total == 0:
            raise InputError(f"{table.file} has columns but no rows")
        if frame.height == 0:
            raise InputError(
                f"{table.file}: none of its {total} rows can be read; the first row: {unreadable['reason'][0]}"
            )
        part = opened.measured(frame)
        part.rejected.append(unreadable.with_columns(file=pl.lit(table.file)))
        parts.append(part)
        count += total
        if progress:
            progress(number + 1, len(paths))
    names = [name_of(path) for path in paths]
    return Loaded(together(parts, names), names, count)


def load_frame(frame: pl.DataFrame, how: Reading) -> Loaded:
    """Measurements of a polars DataFrame; `row` is the position in it."""
    columns, conventions, notes = recognised("the DataFrame", frame.columns, how)
    if frame.height == 0:
        raise InputError("the DataFrame has columns but no rows")
    wanted = wanted_names("the DataFrame", columns)
    wanted += doubtful(frame.select(wanted), columns)
    measurements = measure(
        None,
        frame.select(wanted).with_row_index("row"),
        columns,
        altitude_unit=how.altitude_unit,
        time_unit=how.time_unit,
        check_coordinates=how.check_coordinates,
        conventions=conventions,
    )
    measurements.notes[:0] = notes
    return Loaded(measurements, [], frame.height)


def recognised(
    file: str, names: Sequence[str], how: Reading, fixed: Mapping[str, str] | None = None
) -> tuple[Columns, Conventions, list[str]]:
    """The columns of a table by their names, the conventions that hold for it, and a note if its layout is known."""
    layout, of_layout = layout_of(names)
    columns = recognise(file, names, how.columns, fixed or of_layout)
    if layout is None:
        return columns, how.conventions, []
    note = f"the columns are those of {layout.title}: {layout.words}"
    return columns, _filled(how.conventions, layout), [note]


def _filled(conventions: Conventions, layout: Layout) -> Conventions:
    """What the user does not say is as the layout has it."""
    own = {name: value for name, value in vars(layout.conventions).items() if getattr(conventions, name) is None}
    return replace(conventions, **own)


@stage("read")
def _read(table: Table, columns: Columns) -> Rows:
    """The columns that are needed, and, where their values raise doubt, others that may be meant."""
    wanted = wanted_names(table.file, columns)
    frame, unreadable = table.read(wanted)
    more = doubtful(frame, columns)
    return table.read([*wanted, *more]) if more else (frame, unreadable)


def wanted_names(where: str, columns: Columns) -> list[str]:
    """Names of the columns to read; `row` is taken for the row's number."""
    names = sorted({column.name for column in columns.roles.values()})
    if "row" in names:
        raise InputError(f"{where}: a column named 'row' cannot hold measurements; rename it")
    return names


def together(parts: list[Measurements], files: list[str]) -> Measurements:
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
        list(dict.fromkeys(name for part in parts for name in part.unused)),
    )
