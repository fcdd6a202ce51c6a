"""JSON arrays of objects and JSON Lines to a polars frame, by its line reader (7 times its array reader).

An array becomes lines by rewriting `},{` as `}\\n{`, which is right as long as there are as many lines as
braces; whatever does not come out as valid lines is read again by the standard library, value by value, so
that a bad line costs only itself.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import polars as pl

from ..errors import InputError
from ..rejected import unreadable
from .records import whole_text

SAMPLE = 1000
COMMAS = re.compile(rb"\},[ \t]*\r?(?=\n\s*\{|$)")
FEW = 20_000  # bytes of lines that are read one by one where one of them is bad
PARTS = 16
# NaN and Infinity, which JSON lacks, are missing
VALUES = json.JSONDecoder(parse_constant=lambda _: None)


class JsonText:
    """A JSON file in memory: an array of objects, or one object per line."""

    def __init__(self, file: str, content: bytes):
        self.file = file
        if not content.startswith(b"{"):
            # of lines nothing is taken off: that would copy them all
            content = content.strip()
        if content.startswith(b"{") and COMMAS.search(content[: 1 << 16]):
            # lines that were taken out of an array
            content = COMMAS.sub(b"}", content)
        self.array = content if content.startswith(b"[") else None
        cut = self.array is not None and not content.endswith(b"]")
        self.notes = ("the array does not end with ]: the file may have been cut off",) if cut else ()
        self.lines = _array_to_lines(content) if self.array is not None else content
        self.types, sound = _sample_types(self.lines)
        if self.array is not None and not sound:
            self.lines = _written_again(self.array) or self.lines
            self.types, _ = _sample_types(self.lines)
        if not self.types:
            raise InputError(
                f"{file} has no JSON objects that can be read; expected an array of objects, or one object per line"
            )
        if all(kind == "container" for kind in self.types.values()) and b"\n" not in self.lines.strip():
            raise InputError(f"{file} is a single JSON object; expected an array of objects, or one object per line")
        self.names = list(self.types)

    def read(self, wanted: Sequence[str]) -> tuple[pl.DataFrame, pl.DataFrame]:
        """The wanted columns of every object, and the lines that are none."""
        typed = {name: _polars_type(self.types[name]) for name in wanted}
        as_text = dict.fromkeys(wanted, pl.String)
        for schema in (typed, as_text):
            try:
                frame = pl.read_ndjson(self.lines, schema=schema)
            except (pl.exceptions.PolarsError, OSError):
                if self.array is None and (parts := self._in_parts(wanted, schema, few=schema is typed)):
                    return parts
                continue
            if self.array is not None and frame.height != self.array.count(b"{"):
                break  # nested objects, or braces in texts: look more closely
            return frame.with_row_index("row"), unreadable()
        return self._value_by_value(wanted, self._records())

    def _in_parts(
        self, wanted: Sequence[str], typed: dict[str, Any], few: bool
    ) -> tuple[pl.DataFrame, pl.DataFrame] | None:
        """Lines of which some are bad: what can be read at once is, and the lines near a bad one are read alone.

        few: None where these are more than a few.
        """
        text = self.lines
        frames: list[pl.DataFrame] = []
        bad: list[pl.DataFrame] = []
        row, alone = 0, 0
        waiting = _parts(text, 0, len(text))
        while waiting:
            start, end = waiting.pop()
            frame = _read_lines(text[start:end], typed)
            if frame is not None:
                frames.append(frame.with_row_index("row", offset=row))
                row += frame.height
            elif end - start > FEW and len(parts := _parts(text, start, end)) > 1:
                waiting += parts
            else:
                alone += end - start
                if few and alone > max(10 * FEW, len(text) // 50):
                    return None
                lines = [line for line in text[start:end].split(b"\n") if line.strip()]
                values, refused = self._value_by_value(wanted, map(_value_of, lines))
                shift = pl.col("row") + row
                frames.append(_typed(values, typed).with_columns(shift))
                bad.append(refused.with_columns(shift))
                row += len(lines)
        kinds = {tuple(frame.dtypes) for frame in frames}
        if len(kinds) > 1:  # a line has text where others have numbers
            frames = [frame.cast(dict.fromkeys(wanted, pl.String)) for frame in frames]
        return pl.concat(frames), pl.concat(bad) if bad else unreadable()

    def _value_by_value(
        self, wanted: Sequence[str], records: Iterable[tuple[Any, str | None]]
    ) -> tuple[pl.DataFrame, pl.DataFrame]:
        columns: dict[str, list[str | None]] = {name: [] for name in wanted}
        rows: list[int] = []
        bad: tuple[list[int], list[str], list[str]] = ([], [], [])
        for row, (value, text) in enumerate(records):
            if not isinstance(value, dict):
                bad[0].append(row)
                bad[1].append("not a JSON object" if text is None else "not valid JSON")
                bad[2].append((text or json.dumps(value))[:80])
                continue
            rows.append(row)
            for name, column in columns.items():
                column.append(_text(value.get(name)))
        frame = pl.DataFrame({"row": rows, **columns}, schema={"row": pl.UInt32, **dict.fromkeys(wanted, pl.String)})
        return frame, unreadable(*bad)

    def _records(self) -> Iterator[tuple[Any, str | None]]:
        """Each record's value, or the text that could not be read as one."""
        if self.array is not None:
            try:
                values = VALUES.decode(self.array.decode("utf-8", errors="replace"))
            except (ValueError, RecursionError):
                pass
            else:
                yield from ((value, None) for value in values)
                return
        yield from (_value_of(line) for line in self.lines.split(b"\n") if line.strip())


def _value_of(line: bytes) -> tuple[Any, str | None]:
    """A line's value, or its text where it could not be read."""
    text = line.decode("utf-8", errors="replace").strip()
    try:
        return VALUES.decode(text), None
    except (ValueError, RecursionError):
        return None, text


def _parts(text: bytes, start: int, end: int) -> list[tuple[int, int]]:
    """Whole lines from `start` to `end` in some parts, the first one last."""
    cuts = [text.find(b"\n", start + (end - start) * k // PARTS, end) + 1 for k in range(1, PARTS)]
    bounds = sorted({start, end, *(cut for cut in cuts if cut)})
    return [*reversed(list(pairwise(bounds)))]


def _read_lines(text: bytes, typed: dict[str, Any]) -> pl.DataFrame | None:
    """Some lines at once, None where one of them is bad."""
    if not text.strip():
        return pl.DataFrame(schema=typed)
    try:
        return pl.read_ndjson(text, schema=typed)
    except (pl.exceptions.PolarsError, OSError):
        return None


def _typed(values: pl.DataFrame, typed: dict[str, Any]) -> pl.DataFrame:
    """Text as what it is elsewhere in the file, where that loses nothing."""

    def cast_to(name: str, kind: Any) -> pl.Expr:
        text = pl.col(name)
        flag = pl.when(text.is_in(["true", "false"])).then(text == "true")
        return (flag if kind == pl.Boolean else text.cast(kind, strict=False)).alias(name)

    cast = values.with_columns(cast_to(name, kind) for name, kind in typed.items())
    return cast if cast.null_count().equals(values.null_count()) else values


def _array_to_lines(content: bytes) -> bytes:
    """`[{...},{...}]` to one object per line, as long as objects do not nest."""
    body = content[1:-1] if content.endswith(b"]") else content[1:]
    if b"\n" in body or b"\r" in body:
        body = body.replace(b"\r", b" ").replace(b"\n", b" ")
    between = re.search(rb"\}\s*,\s*\{", body)
    if between is None or between.group() == b"},{":
        return body.replace(b"},{", b"}\n{").strip()
    return re.sub(rb"\}\s*,\s*\{", b"}\n{", body).strip()


def _written_again(array: bytes) -> bytes | None:
    """The array's objects one per line by the standard library, or None if it is not valid JSON."""
    try:
        values = VALUES.decode(array.decode("utf-8", errors="replace"))
    except (ValueError, RecursionError):
        return None
    return "\n".join(json.dumps(value) for value in values).encode()


def _sample_types(lines: bytes) -> tuple[dict[str, str], bool]:
    """Name and kind of every key seen in lines all over the file, and whether all were objects."""
    kinds: dict[str, str] = {}
    sound = True
    for line in _sample(lines):
        try:
            value = VALUES.decode(line.decode("utf-8", errors="replace"))
        except (ValueError, RecursionError):
            value = None
        sound = sound and isinstance(value, dict)
        if isinstance(value, dict):
            for name, item in value.items():
                known = name if name in kinds else whole_text(name)
                kinds[known] = _wider(kinds.get(known, "none"), _kind(item))
    return kinds, sound


def _sample(lines: bytes) -> Iterator[bytes]:
    position = 0
    for _ in range(SAMPLE):
        end = lines.find(b"\n", position)
        yield lines[position : end if end >= 0 else len(lines)]
        if end < 0:
            return
        position = end + 1
    step = max(1, (len(lines) - position) // SAMPLE)
    for place in range(position, len(lines), step):
        start = lines.find(b"\n", place) + 1
        if start == 0:
            start = lines.rfind(b"\n") + 1
        end = lines.find(b"\n", start)
        yield lines[start : end if end >= 0 else len(lines)]


def _kind(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "bool"
    if isinstance(value, int):
        return "int"
    if isinstance(value, float):
        return "float"
    return "str" if isinstance(value, str) else "container"


def _wider(one: str, other: str) -> str:
    if one == other or other == "none":
        return one
    if one == "none":
        return other
    return "float" if {one, other} == {"int", "float"} else "str"


def _polars_type(kind: str) -> Any:
    return {"int": pl.Int64, "float": pl.Float64, "bool": pl.Boolean}.get(kind, pl.String)


def _text(value: Any) -> str | None:
    if value is None or isinstance(value, str):
        return value and whole_text(value)
    return json.dumps(value)
