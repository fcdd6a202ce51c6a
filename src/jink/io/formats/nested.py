"""JSON whose objects nest: what lies deeper becomes a column under its own name, or its path where that is not unique.

Read so are objects with no position on their first level, such as aisstream's messages, and one list of objects inside
another object, such as Google's `{"locations": [...]}`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

from ..columns import WORDS, normal
from ..roles import POSITIONS, ROLES
from .documents import documents
from .records import Records, Refused

DEEPEST = 6
MOST = 1000  # columns: more are rows that are named by their numbers


def has_position(names: list[str]) -> bool:
    """Whether the first level already names a position, perhaps with units behind it."""
    known = {normal(WORDS.sub("_", name)) for name in names} | {normal(name) for name in names}
    starts = {name.rsplit("_", 1)[0] for name in known}
    return any(all((known | starts) & set(ROLES[role][1]) for role in roles) for roles in POSITIONS.values())


def read(file: str, content: bytes) -> Records | None:
    """One row per object; None if nothing in it is nested or names a position. Errors: InputError for broken JSON."""
    by_columns = _columns(file, content)
    if by_columns is not None:
        return by_columns
    flat: list[dict[tuple[str, ...], Any]] = []
    rows: list[int] = []
    refused = Refused()
    for number, value in enumerate(_objects(file, content)):
        if isinstance(value, dict):
            flat.append(dict(_leaves(value, ())))
            rows.append(number)
        else:
            refused.add(number, "not a JSON object", value)
    paths = dict.fromkeys(path for row in flat for path in row)
    if len(paths) > MOST:
        return None
    last = Counter(path[-1] for path in paths)
    names = {path: path[-1] if last[path[-1]] == 1 else ".".join(path) for path in paths}
    if not has_position(list(names.values())):
        return None
    table = [
        {"row": n} | {names[path]: value for path, value in row.items()} for n, row in zip(rows, flat, strict=True)
    ]
    return Records.of(table, refused, ["nested JSON is read by the names of its innermost fields"])


def _columns(file: str, content: bytes) -> Records | None:
    """One object of columns, each a list or an object of rows, as pandas writes (`orient="columns"` or `"list"`)."""
    values = [value for _, value, _ in documents(file, content)]
    table = values[0] if len(values) == 1 else None
    if not isinstance(table, dict) or not all(isinstance(column, dict | list) for column in table.values()):
        return None
    columns = {name: dict(enumerate(c)) if isinstance(c, list) else c for name, c in table.items()}
    if not has_position(list(columns)):
        return _rows_by_name(list(columns.values()))
    keys = list(dict.fromkeys(key for column in columns.values() for key in column))
    rows = [{"row": row} | {name: column.get(key) for name, column in columns.items()} for row, key in enumerate(keys)]
    return Records.of(rows, notes=["JSON by columns is read (as pandas writes it)"])


def _rows_by_name(values: list[dict[Any, Any]]) -> Records | None:
    """An object of rows by their index, as pandas writes (`orient="index"`); None where they name no position."""
    if not values or not has_position([str(name) for name in values[0]]):
        return None
    rows = [{"row": row} | {str(name): item for name, item in value.items()} for row, value in enumerate(values)]
    return Records.of(rows, notes=["JSON of rows by their index is read (as pandas writes it)"])


def _objects(file: str, content: bytes) -> Iterator[Any]:
    """The objects of a file: its own, or those of the one list in a single object."""
    for _, value, _ in documents(file, content):
        if isinstance(value, list):
            yield from value
            continue
        lists = (
            [v for v in value.values() if isinstance(v, list) and v and isinstance(v[0], dict)]
            if isinstance(value, dict)
            else []
        )
        if len(lists) == 1:
            outer = {name: v for name, v in value.items() if not isinstance(v, list | dict)}
            yield from (outer | item if isinstance(item, dict) else item for item in lists[0])
        else:
            yield value


def _leaves(value: dict[str, Any], path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Path and value of every number, text or flag; a list of two or three numbers called coordinates is a place."""
    for name, item in value.items():
        # MongoDB says a value's type by a name of its own: {"$date": {"$numberLong": "1705329000000"}}
        here = path if path and str(name).startswith("$") else (*path, str(name))
        if isinstance(item, dict) and len(here) < DEEPEST:
            yield from _leaves(item, here)
        elif name == "coordinates" and isinstance(item, list) and len(item) in (2, 3):
            yield from zip(((*path, "longitude"), (*path, "latitude"), (*path, "altitude_m")), item, strict=False)
        elif not isinstance(item, list | dict):
            yield here, item
