"""Many files, or one DataFrame, to one table of measurements."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path

import polars as pl

from ..frozen import frozen
from .columns import Columns, recognise
from .conventions import Conventions
from .errors import InputError, NoTable
from .files import Rows, Table, expand, name_of, open_tables
from .formats import mot
from .kept import alike, check_kept, kept
from .layouts import Layout, layout_of
from .meaning import doubtful
from .measurements import Measurements, measure
from .same_names import keep_apart, one_spelling
from .stages import stage

FORMS = 3  # of columns, beside the first file's, that notes show
LOCAL = (mot.FORMAT.title,)  # formats that number the targets of each file from 1
OF_DAY = (
    "times of several files count from midnight and tell no date: they are taken for one day; track files of several "
    "days, or that go on after midnight, each by itself"
)


@frozen
class Reading:
    """How columns are to be read: role to name, units where names do not say, coordinates checked or not, and the
    conventions of times and axes; keep: columns that go through to the output (None: those that say who a target is).
    """

    columns: Mapping[str, str] | None = None
    altitude_unit: str | None = None
    time_unit: str | None = None
    check_coordinates: bool = True
    conventions: Conventions = field(default_factory=Conventions)
    keep: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        from .units import TIME

        if self.altitude_unit not in (None, "ft", "m"):
            raise InputError(f"altitude_unit is {self.altitude_unit!r}; expected 'ft' or 'm'")
        if self.time_unit is not None and not (isinstance(self.time_unit, str) and self.time_unit in TIME):
            raise InputError(f"time_unit is {self.time_unit!r}; expected 's', 'ms', 'us' or 'ns'")


@frozen
class Loaded:
    """Measurements of all inputs together; `count` is the number of rows read, rejected ones included."""

    measurements: Measurements
    files: list[str]
    count: int


@frozen
class Opened:
    """A file whose columns are recognised, and how its rows become measurements."""

    file: str
    columns: Columns
    conventions: Conventions
    notes: tuple[str, ...]
    default_target: str
    how: Reading
    carried: tuple[str, ...] = ()

    @classmethod
    def of(cls, table: Table, path: Path, how: Reading) -> Opened:
        """By the names of its columns. Errors: InputError."""
        columns, conventions, notes = recognised(table.file, table.names, how, table.fixed)
        default = name_of(Path(path.name)).split(".")[0] or "0"
        carried = tuple(kept(table.names, columns, how.keep))
        return cls(table.file, columns, conventions, (*table.notes, *notes), default, how, carried)

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
            carried=[name for name in self.carried if name in frame.columns],
        )
        part.notes[:0] = self.notes
        return part


def load_files(
    inputs: Sequence[str | Path], how: Reading, progress: Callable[[int, int], None] | None = None
) -> Loaded:
    """Read every file or glob pattern; all have to hold the same kind of position and of time."""
    paths = expand(inputs)
    folders = {path for given in map(Path, inputs) if given.is_dir() for path in expand([given])}
    parts: list[Measurements] = []
    left_out: list[str] = []
    names: list[str] = []
    files: list[str] = []
    local: list[bool] = []
    count = of_day = 0
    for number, path in enumerate(paths):
        try:
            for table, part, total in load_tables(path, how, left_out):
                names += table.names
                parts.append(part)
                files.append(table.file)
                local.append(table.format in LOCAL)
                of_day += part.of_day or table.format.startswith("ASTERIX")
                count += total
        except InputError as error:
            # a folder also holds notes and pictures
            if path not in folders or path in map(Path, inputs):
                raise
            left_out.append(str(error).splitlines()[0])
        if progress:
            progress(number + 1, len(paths))
    if not parts:
        reasons = "\n".join(f"  {reason}" for reason in left_out)
        raise InputError(f"no file of the folder or archive can be read:\n{reasons}")
    check_kept(how.keep, names)
    keep_apart(parts, files, local)
    one_spelling(parts)
    whole = together(parts, files)
    whole.notes += other_columns([(file, part.named) for file, part in zip(files, parts, strict=True)])
    whole.notes += [OF_DAY] if of_day > 1 else []
    whole.notes += [f"left out: {reason}" for reason in left_out[:5]]
    if len(left_out) > 5:
        whole.notes.append(f"left out: {len(left_out) - 5} more files")
    return Loaded(whole, files, count)


def load_tables(path: Path, how: Reading, left_out: list[str]) -> Iterator[tuple[Table, Measurements, int]]:
    """The tables of a file or archive, measurements and numbers of rows; notes beside them go into `left_out`.

    Errors: InputError.
    """
    for table in open_tables(path, left_out):
        try:
            part, total = load_table(table, how)
        except NoTable as error:
            # an archive holds notes beside its tables, too
            if table.file == name_of(path):
                raise
            left_out.append(str(error).splitlines()[0])
            continue
        yield table, part, total


def load_table(table: Table, how: Reading) -> tuple[Measurements, int]:
    """Measurements of one table, and the number of its rows. Errors: InputError."""
    opened = Opened.of(table, Path(table.file), how)
    frame, unreadable = _read(table, opened.columns, opened.carried)
    total = frame.height + unreadable.height
    if total == 0:
        raise InputError(f"{table.file} has columns but no rows")
    if frame.height == 0:
        raise InputError(
            f"{table.file}: none of its {total} rows can be read; the first row: {unreadable['reason'][0]}"
        )
    part = opened.measured(frame)
    part.rejected.append(unreadable.with_columns(file=pl.lit(table.file)))
    return part, total


def load_frame(frame: pl.DataFrame, how: Reading) -> Loaded:
    """Measurements of a polars DataFrame; `row` is the position in it."""
    columns, conventions, notes = recognised("the DataFrame", frame.columns, how)
    if frame.height == 0:
        raise InputError("the DataFrame has columns but no rows")
    check_kept(how.keep, frame.columns)
    carried = kept(frame.columns, columns, how.keep)
    wanted = list(dict.fromkeys([*wanted_names("the DataFrame", columns), *carried]))
    wanted += doubtful(frame.select(wanted), columns)
    measurements = measure(
        None,
        frame.select(wanted).with_row_index("row"),
        columns,
        altitude_unit=how.altitude_unit,
        time_unit=how.time_unit,
        check_coordinates=how.check_coordinates,
        conventions=conventions,
        carried=carried,
    )
    measurements.notes[:0] = notes
    one_spelling([measurements])
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
def _read(table: Table, columns: Columns, carried: Sequence[str]) -> Rows:
    """The columns that are needed or kept, and, where their values raise doubt, others that may be meant."""
    wanted = list(dict.fromkeys([*wanted_names(table.file, columns), *carried]))
    frame, unreadable = table.read(wanted)
    more = doubtful(frame, columns)
    return table.read([*wanted, *more]) if more else (frame, unreadable)


def wanted_names(where: str, columns: Columns) -> list[str]:
    """Names of the columns to read; `row` is taken for the row's number."""
    names = sorted({column.name for column in columns.roles.values()})
    if "row" in names:
        raise InputError(f"{where}: a column named 'row' cannot hold measurements; rename it")
    return names


def other_columns(named: Sequence[tuple[str, Mapping[str, str]]]) -> list[str]:
    """Notes on files whose columns are others than those of the first, which the summary names; role to name each."""
    forms: dict[str, list[str]] = {}
    for file, columns in named:
        said = ", ".join(f"{role} = {name}" if role != name else role for role, name in sorted(columns.items()))
        forms.setdefault(said, []).append(file)
    others = list(forms.items())[1:]
    notes = [
        f"the columns named here are those of {named[0][0]}; those of {files[0]}"
        + (f" and {len(files) - 1} more" if len(files) > 1 else "")
        + f": {said}"
        for said, files in others[:FORMS]
    ]
    return notes + ([f"files have {len(others) - FORMS} more forms of columns"] if len(others) > FORMS else [])


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
        pl.concat(alike([part.rows for part in parts]), how="diagonal", rechunk=True),
        [frame for part in parts for frame in part.rejected],
        first.position,
        first.absolute,
        first.named,
        list(dict.fromkeys(note for part in parts for note in part.notes)),
        list(dict.fromkeys(name for part in parts for name in part.unused)),
        list(dict.fromkeys(note for part in parts for note in part.rate_notes)),
    )
