"""Columns that go through to the output as they are: those that the user names, or those that say who a target is."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

import polars as pl

from .columns import Columns, normal
from .errors import InputError
from .values import texts

MARK = "\x01"  # begins the names of kept columns while rows are on their way
IDENTITY = (
    *("callsign", "flight", "ident", "registration", "reg", "tail", "tail_number", "icao24", "icao", "hex"),
    *("mmsi", "imo", "shipname", "ship_name", "vesselname", "vessel_name", "aircraft_type", "typecode"),
)


def kept(names: Sequence[str], columns: Columns, asked: Sequence[str] | None) -> list[str]:
    """Names of the columns to keep: as asked (those that this table has), or identities beside the target's."""
    if asked is not None:
        if "row" in asked and "row" in names:
            raise InputError("keep: a column named 'row' cannot go along, since tracks number their rows so; rename it")
        return [name for name in dict.fromkeys(asked) if name in names]
    used = {column.name for column in columns.roles.values()} - {"row"}
    return [name for name in names if normal(name) in IDENTITY and name not in used]


def check_kept(asked: Sequence[str] | None, names: Iterable[str]) -> None:
    """Errors: InputError for a column that no input has."""
    known = list(dict.fromkeys(names))
    for name in asked or ():
        if name not in known:
            close = difflib.get_close_matches(name, known, 1)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            raise InputError(f"keep: there is no column {name!r} in the input{hint}\n  Found: {', '.join(known)}")


def marked(frame: pl.DataFrame, names: Sequence[str]) -> list[pl.Series]:
    """The kept columns of a frame under their marked names."""
    return [frame[name].alias(MARK + name) for name in names]


def alike(frames: Sequence[pl.DataFrame]) -> list[pl.DataFrame]:
    """Frames whose kept columns have one type each: text where files differ."""
    kinds: dict[str, set[pl.DataType]] = {}
    for frame in frames:
        for name, kind in frame.schema.items():
            if name.startswith(MARK):
                kinds.setdefault(name, set()).add(kind)
    mixed = [name for name, found in kinds.items() if len(found) > 1]
    if not mixed:
        return list(frames)
    return [frame.with_columns(texts(frame[name]).alias(name) for name in mixed if name in frame) for frame in frames]


def unmarked(rows: pl.DataFrame, taken: Iterable[str]) -> dict[str, pl.Series]:
    """Kept columns by the names that they have in the output: `input_NAME` where the output has that name itself."""
    others = set(taken)
    found = {}
    for name in rows.columns:
        if name.startswith(MARK):
            plain = name.removeprefix(MARK)
            found[f"input_{plain}" if plain in others else plain] = rows[name]
    return found
