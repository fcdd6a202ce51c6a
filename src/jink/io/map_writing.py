"""Tracks as GPX and KML, which maps and sports programs show: one track per part, one point per row with a place."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import IO

import polars as pl

GPX_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n<gpx version="1.1" creator="jink" xmlns="http://www.topografix.com/GPX/1/1">\n'
KML_HEAD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2" '
    'xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>\n'
)


def write_gpx(tracks: pl.DataFrame, handle: IO[bytes]) -> None:
    """GPX 1.1: a trk per part of a target."""
    handle.write(GPX_HEAD.encode())
    for name, rows in _parts(tracks):
        handle.write(f"<trk><name>{escape(name, quote=False)}</name><trkseg>\n".encode())
        lines = []
        for latitude, longitude, altitude, time in rows.iter_rows():
            height = "" if altitude is None else f"<ele>{altitude:.2f}</ele>"
            when = "" if time is None else f"<time>{time}</time>"
            lines.append(f'<trkpt lat="{latitude:.7f}" lon="{longitude:.7f}">{height}{when}</trkpt>')
        handle.write("\n".join(lines).encode() + b"\n</trkseg></trk>\n")
    handle.write(b"</gpx>\n")


def write_kml(tracks: pl.DataFrame, handle: IO[bytes]) -> None:
    """KML 2.2 with Google's extension: a gx:Track per part of a target."""
    handle.write(KML_HEAD.encode())
    for name, rows in _parts(tracks):
        mode = "clampToGround" if rows["altitude"].null_count() else "absolute"
        head = f"<Placemark><name>{escape(name, quote=False)}</name><gx:Track><altitudeMode>{mode}</altitudeMode>\n"
        whens = [f"<when>{time}</when>" for time in rows["time"] if time is not None]
        places = [f"<gx:coord>{lon:.7f} {lat:.7f} {alt or 0.0:.2f}</gx:coord>" for lat, lon, alt, _ in rows.iter_rows()]
        handle.write((head + "\n".join(whens + places) + "\n</gx:Track></Placemark>\n").encode())
    handle.write(b"</Document></kml>\n")


def _parts(tracks: pl.DataFrame) -> Iterator[tuple[str, pl.DataFrame]]:
    """Name and rows (latitude, longitude, altitude, time as ISO 8601 or null) of each part, in the table's order."""
    if "altitude" not in tracks.columns:
        tracks = tracks.with_columns(altitude=pl.lit(None, pl.Float64))
    dated = isinstance(tracks.schema["time"], pl.Datetime)
    time = pl.col("time").dt.strftime("%Y-%m-%dT%H:%M:%S%.6fZ") if dated else pl.lit(None, pl.String)
    known = tracks.filter(pl.col("latitude").is_not_null() & pl.col("longitude").is_not_null())
    several = known.group_by("target").agg(pl.col("part").n_unique())
    split = set(several.filter(pl.col("part") > 1)["target"])
    for (target, part), rows in known.group_by(["target", "part"], maintain_order=True):
        name = f"{target}, part {part}" if target in split else str(target)
        yield name, rows.select("latitude", "longitude", "altitude", time.alias("time"))
