"""Plan-view coordinates in metres: equirectangular about the data's middle, or the tracks' own x and y."""

import numpy as np

from .rows import TrackRows

EARTH_RADIUS = 6_371_008.8


def plan_coordinates(rows: TrackRows) -> tuple[np.ndarray, np.ndarray, dict[str, float] | None]:
    """(east (N,), north (N,), frame); frame: {"latitude", "longitude", "radius"} of the origin or None.

    east = R cos(lat0) (lon - lon0), north = R (lat - lat0); longitudes are unwrapped along each target, so a
    track across the date line stays in one piece.
    """
    if not rows.has("latitude", "longitude"):
        return rows.column("x"), rows.column("y"), None
    latitude, longitude = rows.column("latitude"), rows.column("longitude")
    known = np.isfinite(latitude) & np.isfinite(longitude)
    if not known.any():
        return latitude, longitude, {"latitude": 0.0, "longitude": 0.0, "radius": EARTH_RADIUS}
    lat0 = float(np.clip(0.5 * (latitude[known].min() + latitude[known].max()), -85.0, 85.0))
    turn = np.exp(1j * np.radians(longitude[known])).mean()
    lon0 = float(np.degrees(np.angle(turn)))
    unwrapped = unwrap(np.where(known, longitude, np.nan), rows.target, 360.0, lon0)
    east = EARTH_RADIUS * np.cos(np.radians(lat0)) * np.radians(unwrapped - lon0)
    north = EARTH_RADIUS * np.radians(np.where(known, latitude, np.nan) - lat0)
    return east, north, {"latitude": lat0, "longitude": lon0, "radius": EARTH_RADIUS}


def plan_points(frame: dict[str, float], latitude: np.ndarray, longitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(east, north) in metres of places, on the side of the date line that is nearer to the frame's origin."""
    turn = (longitude - frame["longitude"] + 180.0) % 360.0 - 180.0
    east = frame["radius"] * np.cos(np.radians(frame["latitude"])) * np.radians(turn)
    return east, frame["radius"] * np.radians(latitude - frame["latitude"])


def plan_point(frame: dict[str, float], latitude: float, longitude: float) -> tuple[float, float]:
    """The same of one place."""
    east, north = plan_points(frame, np.asarray(latitude), np.asarray(longitude))
    return float(east), float(north)


def measured_coordinates(
    rows: TrackRows, east: np.ndarray, north: np.ndarray, frame: dict[str, float] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Plan-view coordinates (N,), (N,) of the measured positions; NaN where nothing was measured.

    With latitude and longitude, x and y run in a frame turned against true north by course - atan2(vx, vy);
    the difference measured - estimated is turned back by that angle and laid on the estimate.
    """
    if not rows.has("measured_x", "measured_y"):
        return np.full(len(rows), np.nan), np.full(len(rows), np.nan)
    if frame is None:
        return rows.column("measured_x"), rows.column("measured_y")
    dx = rows.column("measured_x") - rows.column("x")
    dy = rows.column("measured_y") - rows.column("y")
    vx, vy = rows.column("velocity_x"), rows.column("velocity_y")
    angle = rows.column("course") - np.arctan2(vx, vy)
    angle = np.where(np.isfinite(angle) & (np.hypot(vx, vy) > 1e-6), angle, np.nan)
    angle = _fill_forward(angle, rows.target)
    de = dx * np.cos(angle) + dy * np.sin(angle)
    dn = dy * np.cos(angle) - dx * np.sin(angle)
    latitude = frame["latitude"] + np.degrees(north / frame["radius"])
    stretch = np.cos(np.radians(frame["latitude"])) / np.maximum(np.cos(np.radians(latitude)), 1e-3)
    return east + de * stretch, north + dn


def unwrap(angle: np.ndarray, group: np.ndarray, period: float, start: float | None = None) -> np.ndarray:
    """`angle` (N,) without jumps of a period within each group; NaNs stay and do not interrupt.

    Each group starts as given, or within half a period of `start`.
    """
    out = angle.astype(np.float64, copy=True)
    at = np.flatnonzero(np.isfinite(angle))
    if at.size == 0:
        return out
    value = angle[at]
    fresh = np.ones(at.size, dtype=bool)
    fresh[1:] = group[at][1:] != group[at][:-1]
    turns = np.zeros(at.size)
    turns[1:] = -np.round(np.diff(value) / period)
    turns[fresh] = 0.0 if start is None else -np.round((value[fresh] - start) / period)
    total = np.cumsum(turns)
    origin = np.maximum.accumulate(np.where(fresh, np.arange(at.size), 0))
    out[at] = value + period * (total - total[origin] + turns[origin])
    return out


def _fill_forward(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Missing values from the row before in the same group, else zero."""
    index = np.where(np.isfinite(values), np.arange(values.size), -1)
    last = np.maximum.accumulate(index) if values.size else index
    usable = (last >= 0) & (group[np.maximum(last, 0)] == group)
    return np.where(usable, values[np.maximum(last, 0)], 0.0)
