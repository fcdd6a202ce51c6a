"""Tables out: Parquet, CSV, JSON Lines and GeoJSON by extension, each file complete or not there at all."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

import polars as pl

from .errors import InputError
from .map_writing import write_gpx, write_kml
from .packing import compress as compress
from .packing import maybe_packed
from .stages import stage
from .temporary import atomically as atomically
from .text_tables import plain_times, write_csv, write_json_lines

FORMATS = {
    ".parquet": "parquet",
    ".pq": "parquet",
    ".csv": "csv",
    ".jsonl": "jsonl",
    ".ndjson": "jsonl",
    ".geojson": "geojson",
    ".gpx": "gpx",
    ".kml": "kml",
    ".arrow": "arrow",
    ".feather": "arrow",
}


MAPS = {"geojson": "GeoJSON", "gpx": "GPX", "kml": "KML"}  # they hold places on the map


def format_of(path: Path) -> str:
    """The format that a file name asks for; text formats may end in .gz as well."""
    name = path.name.removesuffix(".gz")
    suffix = Path(name).suffix.lower()
    kind = FORMATS.get(suffix)
    if kind is None or (name != path.name and kind in ("parquet", "arrow")):
        known = "tracks.parquet, .csv, .jsonl, .geojson, .gpx, .kml or .arrow (text also with .gz)"
        raise InputError(f"the output {path} has an unknown extension; write to {known}")
    return kind


def check_writable(path: Path) -> None:
    """Raise InputError before any work is done if the output cannot be written."""
    if path.is_dir():
        raise InputError(f"the output {path} is a directory")
    folder = path.parent
    if not folder.is_dir():
        raise InputError(f"the output {path} cannot be written: there is no directory {folder}")
    if not os.access(folder, os.W_OK):
        raise InputError(f"the output {path} cannot be written: no permission to write in {folder}")


def check_apart(written: Sequence[Path], read: Iterable[Path]) -> None:
    """Errors: InputError where a file would be written over an input, or two would be written under one name."""
    inputs = {_true(path) for path in read}
    seen: dict[Path, Path] = {}
    for path in written:
        true = _true(path)
        if true in inputs:
            raise InputError(f"{path} is an input; the output needs another name")
        if true in seen:
            raise InputError(f"{path} would be written twice; outputs need different names")
        seen[true] = path


def _true(path: Path) -> Path:
    """What a name stands for, links followed."""
    try:
        return path.resolve()
    except (OSError, RuntimeError):
        raise InputError(f"{path} cannot be used: its links lead round in a circle") from None


@stage("write")
def write_tracks(tracks: pl.DataFrame, path: Path | IO[bytes], kind: str) -> None:
    """Write to `path` (any name, or an open stream) in the format `kind`; nulls are empty in CSV and null in JSON."""
    writers: dict[str, Callable[[pl.DataFrame, IO[bytes]], Any]] = {
        "parquet": write_parquet,
        "arrow": pl.DataFrame.write_ipc,
        "csv": write_csv,
        "jsonl": write_json_lines,
        "geojson": _write_geojson,
        "gpx": write_gpx,
        "kml": write_kml,
    }
    if not isinstance(path, Path):
        writers[kind](tracks, path)
        return
    with path.open("wb") as handle:
        writers[kind](tracks, handle)


@stage("write")
def write_packed(tracks: pl.DataFrame, path: Path, kind: str) -> None:
    """The same as a gzip file."""
    with path.open("wb") as handle, maybe_packed(handle, True, kind) as out:
        write_tracks(tracks, out, kind)


def write_parquet(frame: pl.DataFrame | pl.LazyFrame, handle: IO[bytes]) -> None:
    """Parquet, quickly compressed; into an open file, since polars takes no name that is not UTF-8."""
    # few rows of a group: less memory on the way
    frame.lazy().sink_parquet(handle, compression="snappy", row_group_size=1 << 16)


def _write_geojson(tracks: pl.DataFrame, handle: IO[bytes]) -> None:
    """RFC 7946: a line for every track part, then a point for every row with all its columns."""
    handle.write(b'{"type":"FeatureCollection","features":[\n')
    lines = list(_lines(tracks))
    handle.write(b",\n".join(json.dumps(line, ensure_ascii=False).encode() for line in lines))
    table = plain_times(tracks)
    names = [name for name in table.columns if name not in ("latitude", "longitude")]
    point = pl.concat_list("longitude", "latitude")
    separator = ",\n" if lines else ""
    for start in range(0, table.height, 50_000):
        chunk = table.slice(start, 50_000).select(
            point.alias("coordinates"),
            pl.struct(names).struct.json_encode().alias("properties"),
            known=pl.col("latitude").is_not_null(),
        )
        texts = []
        for coordinates, properties, known in chunk.iter_rows():
            place = f'{{"type":"Point","coordinates":[{coordinates[0]!r},{coordinates[1]!r}]}}'
            geometry = place if known else "null"
            texts.append(f'{{"type":"Feature","geometry":{geometry},"properties":{properties}}}')
        handle.write((separator + ",\n".join(texts)).encode())
        separator = ",\n"
    handle.write(b"\n]}\n")


def _lines(tracks: pl.DataFrame) -> Iterator[dict[str, object]]:
    known = tracks.filter(pl.col("latitude").is_not_null())
    for (target, part), rows in known.group_by(["target", "part"], maintain_order=True):
        places = list(zip(rows["longitude"].to_list(), rows["latitude"].to_list(), strict=True))
        ends = plain_times(rows.select("time")[[0, -1]])["time"].to_list()
        properties = {"target": target, "part": part, "rows": len(places), "start": ends[0], "end": ends[1]}
        yield {"type": "Feature", "geometry": _line(places), "properties": properties}


def _line(places: list[tuple[float, float]]) -> dict[str, object]:
    """A line, or several where it crosses the antimeridian (RFC 7946, section 3.1.9)."""
    pieces: list[list[tuple[float, float]]] = [[places[0]]]
    for (lon, lat), (next_lon, next_lat) in pairwise(places):
        if abs(next_lon - lon) > 180.0:
            edge = 180.0 if lon > 0 else -180.0
            share = (edge - lon) / (next_lon + 2 * edge - lon) if next_lon + 2 * edge != lon else 0.0
            crossing = lat + share * (next_lat - lat)
            pieces[-1].append((edge, crossing))
            pieces.append([(-edge, crossing)])
        pieces[-1].append((next_lon, next_lat))
    pieces = [piece if len(piece) > 1 else piece * 2 for piece in pieces]
    if len(pieces) == 1:
        return {"type": "LineString", "coordinates": pieces[0]}
    return {"type": "MultiLineString", "coordinates": pieces}
