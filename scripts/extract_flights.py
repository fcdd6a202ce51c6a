"""Make examples/flights.parquet: the flights of traffic's quickstart collection with the most clear turns.

    pip download --no-deps traffic==2.13
    python scripts/extract_flights.py traffic-2.13-py3-none-any.whl
    python scripts/extract_flights.py traffic-2.13-py3-none-any.whl --all -o quickstart.parquet     # the whole
    collection, 213 flights

Columns and values are the source's own (only renamed so that they carry their unit); rows are not cleaned:
stale positions and gaps are part of the example. A clear turn: the course, taken from positions 10 s apart,
changes at a rate that means at least 0.3 g sideways for 10 s on end.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import polars as pl

MEMBER = "traffic/data/samples/collections/quickstart.json.gz"
NAMES = {
    "icao24": "icao24",
    "callsign": "callsign",
    "timestamp": "time",
    "latitude": "latitude",
    "longitude": "longitude",
    "altitude": "altitude_ft",
    "groundspeed": "groundspeed_kt",
    "vertical_rate": "vertical_rate_ft_min",
}
GRAVITY, WINDOW, SUSTAINED = 9.80665, 10, 10


def read(source: Path) -> pl.DataFrame:
    """The collection from the wheel, or from the .json.gz inside it."""
    content = zipfile.ZipFile(source).read(MEMBER) if source.suffix == ".whl" else source.read_bytes()
    rows = json.loads(gzip.decompress(content))
    table = pl.DataFrame([[row[name] for row in rows] for name in NAMES], schema=list(NAMES.values()), strict=False)
    return table.with_columns(pl.from_epoch("time", time_unit="ms").dt.replace_time_zone("UTC"))


def clear_turns(flight: pl.DataFrame) -> int:
    """How many times a flight turns with 0.3 g or more for 10 s; positions that are repeated do not count."""
    seconds = flight["time"].dt.timestamp("ms").to_numpy() / 1000.0
    latitude, longitude = flight["latitude"].to_numpy(), flight["longitude"].to_numpy()
    fresh = np.r_[True, (np.diff(latitude) != 0) | (np.diff(longitude) != 0)]
    if fresh.sum() < 60:
        return 0
    grid = np.arange(seconds[0], seconds[-1])
    latitude = np.interp(grid, seconds[fresh], latitude[fresh])
    longitude = np.interp(grid, seconds[fresh], longitude[fresh])
    north = (latitude[WINDOW:] - latitude[:-WINDOW]) * 111_200.0 / WINDOW
    east = (longitude[WINDOW:] - longitude[:-WINDOW]) * 111_200.0 * np.cos(np.radians(latitude[WINDOW:])) / WINDOW
    course = np.unwrap(np.arctan2(east, north))
    rate = (course[WINDOW:] - course[:-WINDOW]) / WINDOW
    speed = np.hypot(east, north)[WINDOW // 2 : -(WINDOW // 2)]
    hole = np.interp(grid[WINDOW:-WINDOW], seconds[fresh][1:], np.diff(seconds[fresh])) > 5.0
    hard = (np.abs(rate) * speed > 0.3 * GRAVITY) & (speed > 50.0) & ~hole
    edges = np.flatnonzero(np.diff(np.r_[0, hard.astype(int), 0]))
    return int(((edges[1::2] - edges[::2]) >= SUSTAINED).sum())


def main() -> None:
    """Rank the flights by clear turns, keep the first, write one Parquet file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path, help="the wheel of traffic 2.13, or its quickstart.json.gz")
    parser.add_argument("-o", "--output", type=Path, default=Path("examples/flights.parquet"))
    parser.add_argument("-n", "--flights", type=int, default=25)
    parser.add_argument("--all", action="store_true", help="every flight, not those with the most turns")
    given = parser.parse_args()
    table = read(given.source).sort("icao24", "time", maintain_order=True)
    turns = {name: clear_turns(flight) for (name,), flight in table.group_by(["icao24"], maintain_order=True)}
    kept = sorted(turns, key=lambda name: (-turns[name], name))[: None if given.all else given.flights]
    flights = table.filter(pl.col("icao24").is_in(kept))
    buffer = io.BytesIO()
    flights.write_parquet(buffer, compression="zstd", compression_level=19)
    given.output.write_bytes(buffer.getvalue())
    count = sum(turns[name] for name in kept)
    size = len(buffer.getvalue()) / 1e6
    print(f"{given.output}: {flights.height} rows, {len(kept)} flights, {count} clear turns, {size:.2f} MB")


if __name__ == "__main__":
    main()
