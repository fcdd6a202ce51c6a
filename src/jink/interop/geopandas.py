"""geopandas and movingpandas: tracks as points of a GeoDataFrame or as a TrajectoryCollection, and back."""

from __future__ import annotations

from typing import Any

import polars as pl

from ..io.frames import from_any
from .needed import needed

WGS84 = "EPSG:4326"


def to_geodataframe(tracks: Any) -> Any:
    """Every row of tracks (a DataFrame with latitude and longitude) as a point, with all other columns.

    Errors: ValueError without latitude and longitude; ImportError naming what is missing.
    """
    geopandas, frame = needed("geopandas"), from_any(tracks)
    if missing := {"latitude", "longitude"} - set(frame.columns):
        raise ValueError(f"tracks: have no {' and '.join(sorted(missing))}; expected geographic positions")
    columns = {name: _values(frame[name]) for name in frame.columns}
    table = needed("pandas").DataFrame(columns)
    points = geopandas.points_from_xy(table["longitude"], table["latitude"], crs=WGS84)
    return geopandas.GeoDataFrame(table.drop(columns=["latitude", "longitude"]), geometry=points)


def from_geodataframe(points: Any) -> pl.DataFrame:
    """Points with their columns as a table with latitude and longitude, for :func:`jink.track`; another system of
    coordinates is turned into WGS 84. Errors: ValueError for points without a system.
    """
    if points.crs is None:
        raise ValueError("points: have no coordinate reference system; expected one, for example EPSG:4326")
    there = points if points.crs.to_epsg() == 4326 else points.to_crs(WGS84)
    table = needed("pandas").DataFrame(there.drop(columns=there.geometry.name)).reset_index(drop=True)
    place = {"latitude": pl.Series(there.geometry.y.to_numpy()), "longitude": pl.Series(there.geometry.x.to_numpy())}
    return from_any(table).with_columns(**place)


def to_trajectories(tracks: Any) -> Any:
    """A movingpandas ``TrajectoryCollection``, one trajectory for each target with at least two rows."""
    points = to_geodataframe(tracks)
    if not str(points["time"].dtype).startswith("datetime"):
        points["time"] = needed("pandas").to_datetime(points["time"], unit="s", utc=True)
    points["time"] = points["time"].dt.tz_convert("UTC").dt.tz_localize(None)
    return needed("movingpandas").TrajectoryCollection(points, traj_id_col="target", t="time")


def from_trajectories(collection: Any) -> pl.DataFrame:
    """The points of a ``TrajectoryCollection``, with target, time (UTC), latitude and longitude."""
    points = collection.to_point_gdf()
    named = points.rename(columns={collection.get_traj_id_col(): "target"}) if "target" not in points else points
    time = pl.Series("time", points.index.to_numpy().astype("datetime64[us]")).dt.replace_time_zone("UTC")
    return from_geodataframe(named).with_columns(time)


def _values(column: pl.Series) -> Any:
    if column.dtype.is_temporal():
        return needed("pandas").Series(column.dt.replace_time_zone(None).to_numpy()).dt.tz_localize("UTC")
    return column.cast(pl.String).to_list() if column.dtype in (pl.Enum, pl.Categorical) else column.to_list()
