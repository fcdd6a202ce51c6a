"""Tables whose header tells who wrote them, and what their columns therefore hold.

A layout is recognised by the names that it always has. It fixes columns (role with a unit: name) and conventions that
the names alone do not tell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field

from ..frozen import frozen
from .columns import normal
from .conventions import Conventions


@frozen
class Layout:
    """Who writes such tables, the names that it has (all of `names`, one of `some`), what it fixes, and why."""

    title: str
    names: frozenset[str]
    fixed: Mapping[str, str]
    words: str
    some: frozenset[str] = frozenset()
    conventions: Conventions = field(default_factory=Conventions)

    def fits(self, known: Mapping[str, str]) -> bool:
        """Whether a table with these names (normal: as written) is one."""
        return self.names <= known.keys() and (not self.some or bool(self.some & known.keys()))


LAYOUTS = (
    Layout(
        "tracks that jink wrote",
        frozenset({"part", "segment", "status", "x_sd", "y_sd"}),
        {"altitude_m": "altitude", "course_rad": "course"},
        "positions are estimates, whose errors last from row to row; the measurements that they come from are a better "
        "input",
    ),
    Layout(
        "Flightradar24 CSV",
        frozenset({"timestamp", "utc", "callsign", "altitude", "speed", "direction"}),
        {"time_s": "timestamp", "altitude_ft": "altitude", "speed_kt": "speed", "place": "position"},
        "altitude in feet, speed in knots",
    ),
    Layout(
        "Danish Maritime Authority AIS",
        frozenset({"timestamp", "type_of_mobile", "mmsi", "latitude", "longitude"}),
        {"target": "mmsi", "time": "timestamp"},
        "times are day first, UTC",
        conventions=Conventions(day_first=True),
    ),
    Layout(
        "libais JSON",
        frozenset({"mmsi", "x", "y", "repeat_indicator"}),
        {"target": "mmsi", "longitude_deg": "x", "latitude_deg": "y", "time_s": "tagblock_timestamp"},
        "x and y are longitude and latitude in degrees, timestamp is the second of the minute",
    ),
    Layout(
        "PX4 vehicle_local_position",
        frozenset({"timestamp", "x", "y", "z", "vx", "vy", "vz"}),
        {"time_us": "timestamp"},
        "time in microseconds since boot; x north, y east, z down",
        some=frozenset({"heading", "xy_valid", "z_valid", "ref_lat", "dist_bottom", "xy_global"}),
        conventions=Conventions(axes="ned"),
    ),
    Layout(
        "PX4 vehicle_gps_position",
        frozenset({"timestamp", "lat", "lon", "alt", "eph", "epv", "fix_type"}),
        {"time_us": "timestamp", "latitude_e7": "lat", "longitude_e7": "lon", "altitude_mm": "alt"},
        "time in microseconds since boot, latitude and longitude in 1e-7 degrees, altitude in millimetres",
    ),
    Layout(
        "Virtual Radar Server JSON",
        frozenset({"icao", "lat", "long", "postime"}),
        {"target": "icao", "altitude_ft": "alt", "time_ms": "postime", "speed_kt": "spd"},
        "altitude in feet, time in milliseconds",
    ),
    Layout(
        "OwnTracks",
        frozenset({"tst", "lat", "lon", "acc"}),
        {"time_s": "tst", "accuracy_m": "acc"},
        "tst in seconds since 1970, acc in metres",
    ),
    Layout(
        "RadarScenes detections",
        frozenset({"range_sc", "azimuth_sc"}),
        {"range_m": "range_sc", "azimuth_rad": "azimuth_sc"},
        "azimuth in radians, counter-clockwise from the x axis (forward)",
        conventions=Conventions(azimuth="east"),
    ),
    Layout(
        "positions north, east, down",
        frozenset({"n", "e", "d"}),
        {"x": "n", "y": "e", "z": "d"},
        "n north, e east, d down",
        conventions=Conventions(axes="ned"),
    ),
    Layout(
        "positions east, north, up",
        frozenset({"e", "n", "u"}),
        {"x": "e", "y": "n", "z": "u"},
        "e east, n north, u up",
    ),
    Layout(
        "Movebank CSV",
        frozenset({"timestamp", "location_long", "location_lat", "individual_local_identifier"}),
        {"target": "individual_local_identifier"},
        "each animal is a target",
    ),
)


def layout_of(names: Sequence[str]) -> tuple[Layout | None, dict[str, str]]:
    """The layout of a table with these columns, and its fixed columns by the names as written."""
    known = {normal(name): name for name in reversed(names)}
    for layout in LAYOUTS:
        if layout.fits(known):
            return layout, {role: known[name] for role, name in layout.fixed.items() if name in known}
    return None, {}
