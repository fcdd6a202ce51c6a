"""CSV text to a polars frame: typed when clean, as strings when not, line by line when ragged."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from typing import Any

import polars as pl

from ..columns import normal
from ..errors import InputError
from ..rejected import unreadable
from ..roles import POSITIONS, ROLES
from ..units import ANGLE, LENGTH, SPEED, TIME
from .head import body, first_line, is_number

MISSING = ["", "NA", "N/A", "NaN", "nan", "NAN", "null", "NULL", "None", "none", "-", "--", "\\N"]

NO_UNIT = {"", "-", "--", "[-]", "(-)", "1", "utc", "UTC", "text", "string", "id", "n/a"}
ALL_UNITS = {*LENGTH, *ANGLE, *SPEED, *TIME} - {"e7", "e6", "e5", "1e7", ""}
IDENTIFIERS = set(ROLES["target"][1])
# names of columns whose zeros in front say nothing
NUMBERS = {name for role, (_, names) in ROLES.items() if role != "target" for name in names}
# names of which a table may have but one
NEEDED = {name for role in ("time", "target", *sum(POSITIONS.values(), ())) for name in ROLES[role][1]}


def fields_of(file: str, line: str, separator: str) -> list[str]:
    """The fields of one line. Errors: InputError with the line."""
    try:
        return next(csv.reader([line.rstrip("\r\n")], delimiter=separator), [])
    except csv.Error as error:
        raise InputError(f"{file}: the line {line[:80]!r} cannot be read as CSV: {error}") from None


class CsvText:
    """A CSV file in memory; the separator (comma, semicolon, tab, bar, blanks) is taken from its header."""

    def __init__(self, file: str, content: bytes):
        found = body(content)
        self.file, self.content, self.separator, self.notes = file, found.content, found.separator, found.notes
        first = first_line(self.content).decode("utf-8", errors="replace").rstrip("\r")
        self.names = [name.strip() for name in fields_of(file, first, self.separator)]
        if self.names and all(is_number(name) for name in self.names):
            raise InputError(
                f"{file} has no header: its first line is {first[:80]!r}. The first line must name the columns, "
                "for example target,time,latitude,longitude"
            )
        self._take_units()
        self.names = self._told_apart(self.names)

    def _take_units(self) -> None:
        """A line of units below the header (`-, s, km, km`) goes into the names, and is no row."""
        head, _, rest = self.content.partition(b"\n")
        line = first_line(rest).decode("utf-8", errors="replace").rstrip("\r")
        units = [unit.strip() for unit in fields_of(self.file, line, self.separator)] if line.strip() else []
        if len(units) != len(self.names) or not all(unit in NO_UNIT or normal(unit) in ALL_UNITS for unit in units):
            return
        if sum(normal(unit) in ALL_UNITS for unit in units) < 2:
            return
        self.names = [
            name if normal(unit) not in ALL_UNITS or normal(name).endswith(normal(unit)) else f"{name} [{unit}]"
            for name, unit in zip(self.names, (unit.strip("[]()") for unit in units), strict=True)
        ]
        self.content = head + b"\n" + rest[len(first_line(rest)) + 1 :]
        self.notes += ("the line of units below the header is read",)

    def _told_apart(self, names: list[str]) -> list[str]:
        """Second columns of a name get a number, unless it names a time, a position or a target: which is meant?"""
        double = sorted(name for name, count in Counter(names).items() if name and count > 1)
        needed = [name for name in double if normal(name) in NEEDED]
        if needed:
            raise InputError(f"{self.file}: the header has the same column twice: {', '.join(needed)}")
        if double:
            self.notes += (f"the header has the same column twice: {', '.join(double)}; the first of each is read",)
        seen: dict[str, int] = {}
        out = []
        for name in names:
            seen[name] = seen.get(name, 0) + 1
            out.append(name if seen[name] == 1 or not name else f"{name} ({seen[name]})")
        return out

    def read(self, wanted: Sequence[str], *, typed: bool = True) -> tuple[pl.DataFrame, pl.DataFrame]:
        """The wanted columns of every row that has the right number of fields, and the rows that have not.

        typed: a column of numbers alone is one of numbers; else all are text.
        """
        if not self._even():
            return self._line_by_line(wanted)
        ordered = sorted(wanted, key=self.names.index)
        # whole numbers would lose the zeros in front of them
        texts = {name: pl.String for name in ordered if normal(name) in IDENTIFIERS}
        attempts: list[dict[str, Any]] = [
            {"infer_schema_length": 10_000, "schema_overrides": texts},
            {"infer_schema": False},
        ]
        for options in attempts[not typed :]:
            try:
                frame = pl.read_csv(
                    self.content,
                    separator=self.separator,
                    null_values=MISSING,
                    columns=[self.names.index(name) for name in ordered],
                    **options,
                )
            except (pl.exceptions.PolarsError, OSError):
                continue
            # by place, since names may repeat or have blanks around them
            frame.columns = ordered
            frame = self._with_names(frame)
            if frame.height == self.content.count(b"\n"):
                return frame.select(wanted).with_row_index("row"), unreadable()
        return self._line_by_line(wanted)

    def _with_names(self, frame: pl.DataFrame) -> pl.DataFrame:
        """Identifiers such as 3e1234 (as a number that one is infinite) and 007 stay text, and so do degrees of -0."""
        zero = f"{self.separator}-0{self.separator}".encode() in self.content
        wrong = [
            name
            for name, kind in frame.schema.items()
            if (kind == pl.Float64 and (normal(name) in IDENTIFIERS or frame[name].is_infinite().any()))
            or (kind == pl.Int64 and zero and normal(name).startswith(("lat", "lon", "lng")))
        ]
        padded = [
            name
            for name, kind in frame.schema.items()
            if kind == pl.Int64 and name not in wrong and not {normal(name), normal(name).rpartition("_")[0]} & NUMBERS
        ]
        if not wrong and not padded:
            return frame
        ordered = sorted([*wrong, *padded], key=self.names.index)
        places = [self.names.index(name) for name in ordered]
        text = pl.read_csv(
            self.content, separator=self.separator, null_values=MISSING, columns=places, infer_schema=False
        )
        text.columns = ordered
        kept = [name for name in ordered if name in wrong or _padded(text[name])]
        return frame.with_columns(text.select(kept)) if text.height == frame.height else frame

    def _even(self) -> bool:
        """Whether all lines can have as many fields as the header. Polars fills short lines silently."""
        lines = self.content.count(b"\n") + 1
        if b'"' not in self.content:
            return self.content.count(self.separator.encode()) == lines * (len(self.names) - 1)
        last = self.content.rsplit(b"\n", 1)[-1].decode("utf-8", errors="replace")
        return len(fields_of(self.file, last, self.separator)) == len(self.names)

    def _line_by_line(self, wanted: Sequence[str]) -> tuple[pl.DataFrame, pl.DataFrame]:
        text = io.StringIO(self.content.decode("utf-8", errors="replace").replace("\x00", ""), newline="")
        reader = csv.reader(text, delimiter=self.separator)
        places = [self.names.index(name) for name in wanted]
        columns: list[list[str | None]] = [[] for _ in wanted]
        rows: list[int] = []
        bad: tuple[list[int], list[str], list[str]] = ([], [], [])
        row = -1
        try:
            next(line for line in reader if line)
            for fields in reader:
                if not fields:
                    continue
                row += 1
                if len(fields) != len(self.names):
                    bad[0].append(row)
                    bad[1].append(f"line {reader.line_num} has {len(fields)} fields, the header has {len(self.names)}")
                    bad[2].append(self.separator.join(fields)[:80])
                    continue
                rows.append(row)
                for column, place in zip(columns, places, strict=True):
                    value = fields[place].strip()
                    column.append(None if value in MISSING else value)
        except csv.Error as error:
            raise InputError(f"{self.file}, line {reader.line_num}: cannot be read as CSV: {error}") from None
        frame = pl.DataFrame(
            {"row": rows, **dict(zip(wanted, columns, strict=True))},
            schema={"row": pl.UInt32, **dict.fromkeys(wanted, pl.String)},
        )
        return frame, unreadable(*bad)


def _padded(texts: pl.Series) -> bool:
    """Whether some whole numbers begin with a zero that a number would not keep."""
    return bool((texts.str.starts_with("0") & (texts.str.len_bytes() > 1)).any())
