"""CZML: tracks for globes such as Cesium, one packet for each target; needs no package."""

from __future__ import annotations

import json
import os
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import polars as pl

from ..io.frames import from_any

COLOURS = ((31, 119, 180), (255, 127, 14), (44, 160, 44), (214, 39, 40), (148, 103, 189), (140, 86, 75))


def to_czml(tracks: Any, *, name: str = "jink", start: datetime | None = None) -> list[dict[str, Any]]:
    """Packets of tracks with latitude and longitude; altitude (m) is 0 where there is none.

    start: the date of time 0, for times that are no dates. Errors: ValueError for tracks without a place, or without
    dates and start.
    """
    frame = from_any(tracks)
    if missing := {"target", "time", "latitude", "longitude"} - set(frame.columns):
        raise ValueError(f"tracks: have no {', '.join(sorted(missing))}; expected geographic positions")
    height = pl.col("altitude").fill_null(0.0) if "altitude" in frame.columns else pl.lit(0.0)
    rows = frame.select(pl.col("target").cast(pl.String), "time", "latitude", "longitude", height=height).drop_nulls()
    if not rows["time"].dtype.is_temporal():
        if start is None:
            raise ValueError("tracks: times are no dates; expected start, the date of time 0")
        since = pl.lit(start.astimezone(UTC)) + pl.duration(microseconds=(pl.col("time") * 1e6).round().cast(pl.Int64))
        rows = rows.with_columns(time=since)
    packets: list[dict[str, Any]] = [{"id": "document", "name": name, "version": "1.0"}]
    for k, (key, part) in enumerate(rows.group_by("target", maintain_order=True)):
        packets.append(_packet(str(key[0]), part, COLOURS[k % len(COLOURS)]))
    return packets


def write_czml(path: str | os.PathLike[str], tracks: Any, **options: Any) -> None:
    """Write :func:`to_czml` as a file."""
    Path(path).write_text(json.dumps(to_czml(tracks, **options)), encoding="utf-8")


def from_czml(packets: list[dict[str, Any]] | str | os.PathLike[str]) -> pl.DataFrame:
    """target, time (UTC), latitude, longitude and altitude of packets, or of a file, with cartographicDegrees."""
    found = packets if isinstance(packets, list) else json.loads(Path(packets).read_text(encoding="utf-8"))
    rows: list[tuple[str, datetime, float, float, float]] = []
    for packet in found:
        position = packet.get("position", {})
        values = position.get("cartographicDegrees", [])
        if "epoch" not in position:
            continue
        epoch = datetime.fromisoformat(position["epoch"])
        for t, longitude, latitude, height in zip(*(values[k::4] for k in range(4)), strict=True):
            rows.append((packet["id"], epoch + timedelta(microseconds=round(t * 1e6)), latitude, longitude, height))
    names = ("target", "time", "latitude", "longitude", "altitude")
    kinds = (pl.String, pl.Datetime("us", "UTC"), pl.Float64, pl.Float64, pl.Float64)
    return pl.DataFrame(rows, schema=dict(zip(names, kinds, strict=True)), orient="row")


def _packet(target: str, part: pl.DataFrame, colour: tuple[int, int, int]) -> dict[str, Any]:
    times: list[datetime] = part["time"].to_list()
    first, last = times[0], times[-1]
    values: list[float] = []
    for time, row in zip(times, part.iter_rows(named=True), strict=True):
        values += [(time - first).total_seconds(), row["longitude"], row["latitude"], row["height"]]
    solid = {"solidColor": {"color": {"rgba": [*colour, 255]}}}
    return {
        "id": target,
        "name": target,
        "availability": f"{_text(first)}/{_text(last)}",
        "position": {"epoch": _text(first), "cartographicDegrees": values},
        "path": {"material": solid, "width": 2, "leadTime": 0},
        "point": {"pixelSize": 6, "color": {"rgba": [*colour, 255]}},
        "label": {"text": target, "font": "12px sans-serif", "pixelOffset": {"cartesian2": [0, -14]}},
    }


def _text(time: datetime) -> str:
    return time.astimezone(UTC).isoformat()
