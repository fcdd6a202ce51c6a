"""traffic: ``Traffic`` and ``Flight`` in and out, in its columns and units (feet, knots, degrees, feet a minute)."""

from __future__ import annotations

from math import degrees
from typing import Any

import polars as pl

from ..io.frames import from_any
from .needed import needed

FOOT, KNOT = 0.3048, 1852.0 / 3600.0
# traffic's column: jink's column, and what one of jink's units is in traffic's
COLUMNS = {
    "latitude": ("latitude", 1.0),
    "longitude": ("longitude", 1.0),
    "altitude": ("altitude", 1.0 / FOOT),
    "groundspeed": ("speed", 1.0 / KNOT),
    "track": ("course", degrees(1.0)),
    "vertical_rate": ("climb_rate", 60.0 / FOOT),
}
# what jink.track needs to read them, by role and unit
ROLES = {
    "target": "icao24",
    "time": "timestamp",
    "altitude_ft": "altitude",
    "speed_kt": "groundspeed",
    "course_deg": "track",
    "vertical_rate_fpm": "vertical_rate",
}


def from_traffic(flights: Any) -> tuple[pl.DataFrame, dict[str, str]]:
    """The table of a ``Traffic`` or a ``Flight``, and the columns for ``jink.track(table, columns=columns)``."""
    table = from_any(flights.data.reset_index(drop=True))
    return table, {role: name for role, name in ROLES.items() if name in table.columns}


def table_of(tracks: Any) -> pl.DataFrame:
    """Tracks of jink in traffic's columns and units; targets are icao24, callsigns are kept where there are any."""
    frame = from_any(tracks)
    there = {name: pl.col(own) * factor for name, (own, factor) in COLUMNS.items() if own in frame.columns}
    callsign = next((name for name in ("callsign", "flight") if name in frame.columns), "target")
    return frame.select(
        icao24=pl.col("target").cast(pl.String), callsign=pl.col(callsign).cast(pl.String), timestamp="time", **there
    )


def to_traffic(tracks: Any) -> Any:
    """A ``Traffic`` of tracks that :func:`jink.track` returned. Errors: ImportError naming what is missing."""
    core = needed("traffic.core", "traffic")
    frame = table_of(tracks)
    columns = {name: frame[name].to_list() for name in frame.columns if name != "timestamp"}
    table = needed("pandas").DataFrame(columns)
    when = frame["timestamp"].dt.replace_time_zone(None).to_numpy()
    table["timestamp"] = needed("pandas").Series(when).dt.tz_localize("UTC")
    return core.Traffic(table)
