"""Lines of a stream to measurements: the kind of position and of time is that of the first lines, for all of them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import polars as pl

from ..io.columns import Columns
from ..io.conventions import Conventions
from ..io.errors import InputError
from ..io.formats.records import whole_text
from ..io.loading import Reading, recognised
from ..io.measurements import Measurements, measure

NAME = "standard input"
LONGEST = 1 << 20  # bytes of a line
MOST_NAMES = 4096  # names that are looked at; more are no columns
SHOWN = 80


class TooLong(bytes):
    """The beginning of a line that is longer than `LONGEST`."""


Refused = list[dict[str, Any]]


@dataclass
class Lines:
    """What is known of the columns of one stream, and how its lines are read."""

    reading: Reading
    names: list[str] = field(default_factory=list)
    foreign: set[str] = field(default_factory=set)  # names that say something else than the first lines
    seen: set[tuple[str, ...]] = field(default_factory=set)
    columns: Columns | None = None
    conventions: Conventions | None = None
    absolute: bool | None = None
    notes: list[str] = field(default_factory=list)

    def read(self, lines: Sequence[bytes]) -> tuple[Measurements | None, Refused]:
        """Measurements of some lines, `row` counting them, and those that are none. Errors: InputError where the first
        lines have no position or time.
        """
        values, refused = _decoded(lines)
        if not values:
            return None, refused
        self._learn(values)
        columns = self.columns
        assert columns is not None and self.conventions is not None
        if self.foreign:
            values = self._of_this_kind(values, columns, refused)
        frame = _frame(values, sorted({column.name for column in columns.roles.values()}))
        try:
            found = measure(
                NAME,
                frame,
                columns,
                altitude_unit=self.reading.altitude_unit,
                time_unit=self.reading.time_unit,
                check_coordinates=self.reading.check_coordinates,
                conventions=self.conventions,
                stream=True,
                some=True,
            )
        except InputError as error:
            if self.absolute is None:
                raise
            return None, refused + [{"row": row, "reason": str(error).splitlines()[0]} for row in values]
        if self.absolute is None and found.rows.height:
            self.absolute = found.absolute
        if found.rows.height and found.absolute != self.absolute:
            words = "a date" if found.absolute else "no date, as the others are"
            return None, refused + [{"row": row, "reason": f"time is {words}"} for row in values]
        self._note(found.notes)
        return found, refused

    def _learn(self, values: dict[int, dict[str, Any]]) -> None:
        """The columns with the names that these lines add. The most frequent lines come first: they tell which kind of
        position it is, and names that turn it are foreign.
        """
        kinds = Counter(map(tuple, values.values()))
        failure: InputError | None = None
        for names, _ in kinds.most_common():
            if names not in self.seen:
                try:
                    self._add(names)
                except InputError as error:
                    failure = failure or error
        if self.columns is None:
            self._add(tuple(name for names in kinds for name in names))  # what is in no line alone
        if self.columns is None and failure is not None:
            raise failure

    def _add(self, names: tuple[str, ...]) -> None:
        """The names of one line. Errors: InputError for the first ones, where they are not enough."""
        known = {*self.names, *self.foreign}
        new = [name for name in dict.fromkeys(names) if name not in known]
        if len(self.seen) < MOST_NAMES:
            self.seen.add(names)
        if self.columns is not None and (not new or len(known) > MOST_NAMES):
            return
        try:
            columns, conventions, notes = recognised(NAME, [*self.names, *map(whole_text, new)], self.reading)
            known_units(columns)
        except InputError:
            self.seen.discard(names)
            if self.columns is None:
                raise
            self.foreign.update(new)
            return
        if self.columns is not None and columns.position != self.columns.position:
            self.foreign.update(new)
            return
        self.names += new
        self.columns, self.conventions = columns, conventions
        self._note(notes)

    def _of_this_kind(
        self, values: dict[int, dict[str, Any]], columns: Columns, refused: Refused
    ) -> dict[int, dict[str, Any]]:
        """The lines but those whose position is of another kind."""
        own = {columns.roles[role].name for role in PLACES[columns.position] if role in columns.roles}
        other = {row for row, value in values.items() if not own & value.keys() and self.foreign & value.keys()}
        reason = f"its position is of another kind; those of the stream are {columns.position}"
        refused += [{"row": row, "reason": reason} for row in sorted(other)]
        return {row: value for row, value in values.items() if row not in other}

    def _note(self, notes: Sequence[str]) -> None:
        self.notes += [note for note in notes if note not in self.notes]


PLACES = {
    "geographic": ("latitude", "longitude", "place"),
    "cartesian": ("x", "y"),
    "polar": ("range", "azimuth"),
}


def known_units(columns: Columns) -> None:
    """Errors: InputError for angles whose unit nothing says; one line's values cannot tell it."""
    for role in ("azimuth", "elevation"):
        column = columns.roles.get(role)
        if column is not None and column.unit is None:
            raise InputError(
                f"{NAME}: a stream needs the unit of {role}; --columns {role}_deg={column.name} (or {role}_rad)"
            )


def _decoded(lines: Sequence[bytes]) -> tuple[dict[int, dict[str, Any]], Refused]:
    """The object of each line by its number, and the lines that hold none."""
    values: dict[int, dict[str, Any]] = {}
    refused: Refused = []
    for row, line in enumerate(lines):
        if isinstance(line, TooLong):
            refused.append({"row": row, "reason": f"the line is longer than {LONGEST:,} bytes", "value": _shown(line)})
            continue
        try:
            value = _DECODER.decode(line.decode("utf-8", errors="replace"))
        except (ValueError, RecursionError):
            refused.append({"row": row, "reason": "not valid JSON", "value": _shown(line)})
            continue
        if isinstance(value, dict):
            values[row] = value
        else:
            refused.append({"row": row, "reason": "not a JSON object", "value": _shown(line)})
    return values, refused


_DECODER = json.JSONDecoder(parse_constant=lambda _: None)


def _shown(line: bytes) -> str:
    return line[:SHOWN].decode("utf-8", errors="replace")


def _frame(values: dict[int, dict[str, Any]], wanted: Sequence[str]) -> pl.DataFrame:
    """The wanted columns, null where a line has none."""
    columns = [_series(name, [value.get(name) for value in values.values()]) for name in wanted]
    return pl.DataFrame([pl.Series("row", list(values), dtype=pl.UInt32), *columns])


def _series(name: str, values: list[Any]) -> pl.Series:
    """Numbers, flags or text; a mixture is text."""
    kinds = set(map(type, values)) - {type(None)}
    try:
        if kinds and kinds <= {int, float}:
            return pl.Series(name, values, dtype=pl.Float64 if float in kinds else pl.Int64, strict=False)
        if kinds == {bool}:
            return pl.Series(name, values, dtype=pl.Boolean)
        if kinds <= {str}:
            return pl.Series(name, values, dtype=pl.String)
    except (TypeError, ValueError, OverflowError, pl.exceptions.PolarsError):
        pass
    return pl.Series(name, [_text(value) for value in values], dtype=pl.String)


def _text(value: Any) -> str | None:
    return value if value is None else whole_text(value if isinstance(value, str) else json.dumps(value))
