"""The rows of a bucket, from the slices of all files, as if they had been read together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import polars as pl

from ..frozen import frozen
from ..io.kept import MARK, alike
from ..io.loading import other_columns
from ..io.measurements import Measurements
from . import job as names
from .errors import Stopped
from .mapping import unpacked
from .store import Store


class Place(NamedTuple):
    """A slice of an input file: the file's number, what is the same in its rows, the batch that it is, and its rows."""

    number: int
    same: dict[str, Any]
    batch: int
    rows: int


@frozen
class Kind:
    """What all files have in common, as `io.loading.together` would find it.

    columns: the types of the rows' columns; named, unused, rate_notes and notes: what the summary says of reading.
    """

    position: str
    absolute: bool
    columns: dict[str, Any]
    named: dict[str, str]
    unused: list[str]
    rate_notes: list[str]
    notes: list[str]

    def measurements(self, rows: pl.DataFrame) -> Measurements:
        """Of some rows; what is said of all is not said again."""
        named, unused, rate_notes = dict(self.named), list(self.unused), list(self.rate_notes)
        return Measurements(rows, [], self.position, self.absolute, named, [], unused, rate_notes)


def kind_of(said: Sequence[dict[str, Any]]) -> Kind:
    """What files have in common; said: of each what its map says. Errors: Stopped, with both, where two differ."""
    parts = [part for each in said for part in each["parts"]]
    first = parts[0]
    for part in parts[1:]:
        check_same(first, part)
    heads = alike([unpacked(part["head"]) for part in parts])
    columns = pl.concat(heads, how="diagonal_relaxed").schema
    lists = {
        name: list(dict.fromkeys(text for part in parts for text in part[name]))
        for name in ("unused", "rate_notes", "notes")
    }
    lists["notes"] += other_columns([(part["file"], part["named"]) for part in parts])
    return Kind(first["position"], first["absolute"], dict(columns), first["named"], **lists)


def check_same(one: dict[str, Any], other: dict[str, Any]) -> None:
    """Errors: Stopped where two files cannot be tracked together, with the columns of both."""
    if one["position"] != other["position"]:
        what = f"{one['position']} positions", f"{other['position']} ones"
    elif one["absolute"] != other["absolute"]:
        what = tuple("dates" if part["absolute"] else "plain seconds" for part in (one, other))
    elif ("target" in one["named"]) != ("target" in other["named"]):
        what = tuple("a column of targets" if "target" in part["named"] else "none" for part in (one, other))
    else:
        return
    raise Stopped(
        f"{one['file']} has {what[0]} and {other['file']} has {what[1]}; they cannot be tracked together\n"
        + "\n".join(f"  {part['file']}: {_columns(part)}" for part in (one, other))
        + "\n  Name the columns that hold for all files (--columns target=...), or leave one of them out"
    )


def _columns(part: dict[str, Any]) -> str:
    found = [f"{role} = {name}" for role, name in part["named"].items()]
    return ", ".join(found) + (f"; unused: {', '.join(part['unused'])}" if part["unused"] else "")


def places(said: Sequence[dict[str, Any]], bucket: int) -> list[Place]:
    """Where the rows of a bucket are, in the order of the files."""
    name = str(bucket)
    return [
        Place(number, part["same"], part["slices"][name], part["rows"][name])
        for number, each in enumerate(said)
        for part in each["parts"]
        if name in part["slices"]
    ]


def gather(store: Store, kind: Kind, where: Sequence[Place], between: tuple[str, str] | None = None) -> pl.DataFrame:
    """The rows of a bucket in the order of the files; between: those of some targets, from the first to the last."""
    frames = list(_slices(store, kind, where, between))
    if not frames:
        return pl.DataFrame(schema=kind.columns)
    # column by column, so that no column is there twice but one
    return pl.DataFrame(
        [pl.concat([frame.drop_in_place(name) for frame in frames], rechunk=True) for name in kind.columns]
    )


def shares(store: Store, where: Sequence[Place], most: int) -> list[tuple[str, str] | None]:
    """A bucket in shares of whole targets, in the order of their names: the first and the last of each. A share has
    at most `most` rows, or one target. None: the whole bucket.
    """
    import pyarrow as pa

    if sum(place.rows for place in where) <= most:
        return [None]
    counts: list[pl.DataFrame] = []
    for number, some in groupby(where, lambda place: place.number):
        with store.open(names.slices(number)) as source, pa.ipc.open_file(source) as reader:
            column = reader.schema.get_field_index("target")
        with store.open(names.slices(number)) as source:
            options = pa.ipc.IpcReadOptions(included_fields=[column])
            with pa.ipc.open_file(source, options=options) as reader:
                for place in some:
                    found = pl.DataFrame(pa.Table.from_batches([reader.get_batch(place.batch)]))
                    counts.append(found.group_by("target").len("rows"))
    total = pl.concat(counts).group_by("target").agg(pl.col("rows").sum()).sort("target")
    names_of = total["target"]
    return [(names_of[first], names_of[end - 1]) for first, end in packed(total["rows"].to_numpy(), most)]


def packed(sizes: np.ndarray, most: int) -> Iterator[tuple[int, int]]:
    """First and end of successive groups whose sizes together are at most so many; of one alone where it has more."""
    ends = np.cumsum(sizes)
    first, done = 0, 0
    while first < ends.size:
        end = max(int(np.searchsorted(ends, done + most, side="right")), first + 1)
        yield first, end
        first, done = end, int(ends[end - 1])


def _slices(
    store: Store, kind: Kind, where: Sequence[Place], between: tuple[str, str] | None
) -> Iterator[pl.DataFrame]:
    import pyarrow as pa

    for number, some in groupby(where, lambda place: place.number):
        with store.open(names.slices(number)) as source, pa.ipc.open_file(source) as reader:
            for place in some:
                batch = reader.get_batch(place.batch)
                frame = pl.DataFrame(pa.Table.from_batches([batch]))
                if between is not None:
                    frame = frame.filter(pl.col("target").is_between(pl.lit(between[0]), pl.lit(between[1])))
                yield _shaped(frame, place.same, kind.columns)


def _shaped(frame: pl.DataFrame, same: dict[str, Any], columns: dict[str, Any]) -> pl.DataFrame:
    """With what was the same in all rows, and all columns of the archive in their order and type."""
    known = {name: pl.lit(value, pl.String) for name, value in same.items()}
    own = frame.schema
    if all(kind == (pl.String if name in same else own.get(name)) for name, kind in columns.items()):
        return frame.select(known[name].alias(name) if name in same else pl.col(name) for name in columns)
    absent = {name: pl.lit(None, kind) for name, kind in columns.items() if name not in frame.columns}
    frame = frame.with_columns(**(absent | known))
    mixed = [name for name in columns if name.startswith(MARK) and frame.schema[name] != columns[name]]
    texts = alike([frame.select(mixed), pl.DataFrame(schema={name: columns[name] for name in mixed})])[0]
    return frame.with_columns(texts).select(pl.col(name).cast(kind) for name, kind in columns.items())
