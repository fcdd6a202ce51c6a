"""Which column is what: the usual names of the ADS-B, AIS and radar world, and the units that names carry.

A name is compared in lower case with everything but letters and digits as `_`. If it is not known as it
stands, its ending is tried as a unit: `altitude_ft`, `Range [km]`, `azimuth_deg`, `time_ms`. Without a unit a
column is in SI units (metres, radians, seconds), except where its name has a unit by custom (`alt_baro` of
readsb is in feet); what cannot be known from the name is decided by a stated rule in `measurements.py` and
said in the summary.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from .errors import InputError

FOOT, MILE, KNOT, DEGREE = 0.3048, 1852.0, 1852.0 / 3600.0, 0.017453292519943295
LENGTH = {
    "m": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "km": 1000.0,
    "ft": FOOT,
    "feet": FOOT,
    "foot": FOOT,
    "nmi": MILE,
    "nm": MILE,
    "mi": 1609.344,
    "yd": 0.9144,
    "fl": 100 * FOOT,
}
ANGLE = {
    "deg": DEGREE,
    "degree": DEGREE,
    "degrees": DEGREE,
    "rad": 1.0,
    "radian": 1.0,
    "radians": 1.0,
    "mrad": 1e-3,
}
SPEED = {
    "mps": 1.0,
    "ms": 1.0,
    "m_s": 1.0,
    "kt": KNOT,
    "kts": KNOT,
    "kn": KNOT,
    "knot": KNOT,
    "knots": KNOT,
    "kmh": 1 / 3.6,
    "kph": 1 / 3.6,
    "km_h": 1 / 3.6,
    "mph": 0.44704,
}
TIME = {
    "s": 1.0,
    "sec": 1.0,
    "secs": 1.0,
    "second": 1.0,
    "seconds": 1.0,
    "ms": 1e-3,
    "msec": 1e-3,
    "millis": 1e-3,
    "us": 1e-6,
    "usec": 1e-6,
    "micros": 1e-6,
    "ns": 1e-9,
    "nanos": 1e-9,
}

# quantity and names of every role, the preferred name first
ROLES: dict[str, tuple[Mapping[str, float], tuple[str, ...]]] = {
    "target": (
        {},
        (
            "target",
            "target_id",
            "track_id",
            "tracknumber",
            "track_number",
            "flight_id",
            "icao24",
            "icao",
            "hex",
            "hexident",
            "mmsi",
            "callsign",
            "ident",
            "flight",
            "vessel_id",
            "vehicle_id",
            "object_id",
            "device_id",
            "trip_id",
            "tail",
            "registration",
            "imo",
            "id",
            "name",
        ),
    ),
    "time": (
        TIME,
        (
            "time",
            "timestamp",
            "t",
            "datetime",
            "date_time",
            "basedatetime",
            "base_date_time",
            "time_position",
            "timeposition",
            "epoch",
            "unixtime",
            "unix_time",
            "utc",
            "ts",
            "time_utc",
            "timestamp_utc",
            "gps_time",
            "received_at",
        ),
    ),
    "latitude": (ANGLE, ("latitude", "lat", "position_latitude", "location_lat")),
    "longitude": (ANGLE, ("longitude", "lon", "lng", "long", "position_longitude", "location_long")),
    "altitude": (
        LENGTH,
        (
            "altitude",
            "geoaltitude",
            "geo_altitude",
            "geom_altitude",
            "alt_geom",
            "baroaltitude",
            "baro_altitude",
            "alt_baro",
            "alt",
            "flight_level",
            "height",
            "elevation_above_sea",
            "ele",
        ),
    ),
    "x": (LENGTH, ("x", "px", "pos_x", "position_x", "easting", "east", "measured_x")),
    "y": (LENGTH, ("y", "py", "pos_y", "position_y", "northing", "north", "measured_y")),
    "z": (LENGTH, ("z", "pz", "pos_z", "position_z", "up", "measured_z", "altitude", "alt", "height")),
    "range": (LENGTH, ("range", "slant_range", "rho", "distance", "r")),
    "azimuth": (ANGLE, ("azimuth", "az", "theta", "bearing")),
    "elevation": (ANGLE, ("elevation", "el", "elev", "elevation_angle")),
    "speed": (SPEED, ("speed", "groundspeed", "ground_speed", "gs", "sog", "speed_over_ground", "velocity")),
    "nacp": ({}, ("nacp", "nac_p", "nac")),
    "nic": ({}, ("nic",)),
    "gva": ({}, ("gva",)),
    "source": ({}, ("source", "sensor", "sensor_id", "radar", "radar_id", "station", "sac_sic")),
}

CUSTOMARY_UNIT = {
    "alt_baro": FOOT,
    "alt_geom": FOOT,
    "flight_level": 100 * FOOT,
    "latitude": DEGREE,
    "longitude": DEGREE,
    "gs": KNOT,
    "sog": KNOT,
    "groundspeed": KNOT,
    "speed_over_ground": KNOT,
    "geoaltitude": 1.0,
    "geo_altitude": 1.0,
    "geom_altitude": 1.0,
    "baroaltitude": 1.0,
    "baro_altitude": 1.0,
}
POSITIONS = {"geographic": ("latitude", "longitude"), "cartesian": ("x", "y"), "polar": ("range", "azimuth")}


@dataclass(frozen=True)
class Column:
    """One recognised column: its name in the file and its unit in SI units (None: the name does not say)."""

    name: str
    unit: float | None


@dataclass(frozen=True)
class Columns:
    """The recognised columns of one table by role, and which kind of position they hold."""

    position: str
    roles: dict[str, Column]
    names: tuple[str, ...]

    def named(self) -> dict[str, str]:
        """Role to column name, as it is said in the summary."""
        return {role: column.name for role, column in self.roles.items()}


def normal(name: str) -> str:
    """Lower case, everything but letters and digits as one `_`: `Range [km]` becomes `range_km`."""
    return re.sub(r"[^0-9a-z]+", "_", name.lower().replace("°", "deg")).strip("_")


def recognise(
    file: str, names: Sequence[str], given: Mapping[str, str] | None = None, altitude: bool = True
) -> Columns:
    """Find every role's column, by `given` (role or role_unit: name) or usual names, or raise InputError."""
    roles = _given_roles(file, names, given or {})
    taken = {column.name for column in roles.values()}
    usual = {normal(name): name for name in reversed(names) if name not in taken}
    for role in ROLES:
        if role not in roles and (found := _find(role, usual)):
            roles[role] = found
    position = _position(roles, given or {})
    if position is None:
        raise InputError(_missing(file, "position", names, ("latitude", "longitude", "x", "y", "range", "azimuth")))
    if "time" not in roles:
        raise InputError(_missing(file, "time", names, ("time",)))
    used = {"target", "time", "speed", "source", *POSITIONS[position]}
    used |= {
        "geographic": {"altitude", "nacp", "nic", "gva"},
        "cartesian": {"z"},
        "polar": {"elevation", "altitude"},
    }[position]
    if "elevation" in roles and position == "polar" and "altitude" not in (given or {}):
        used.discard("altitude")
    roles = {role: column for role, column in roles.items() if role in used}
    return Columns(position, roles, tuple(names))


def _given_roles(file: str, names: Sequence[str], given: Mapping[str, str]) -> dict[str, Column]:
    roles: dict[str, Column] = {}
    for key, name in given.items():
        role, unit = _role_and_unit(key)
        if role is None:
            raise InputError(
                f"columns: {key!r} is not known; known are {', '.join(ROLES)}, "
                "each also with a unit (altitude_ft, time_ms)"
            )
        if name not in names:
            close = difflib.get_close_matches(name, names, 1)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            raise InputError(
                f"{file}: columns: {role} is given as column {name!r}, which does not exist{hint}\n"
                f"  Found: {_listed(names)}"
            )
        roles[role] = Column(name, unit if unit is not None else _unit_of(role, normal(name)))
    return roles


def _role_and_unit(key: str) -> tuple[str | None, float | None]:
    if key in ROLES:
        return key, None
    for role, (units, _) in ROLES.items():
        if key.startswith(role + "_") and key[len(role) + 1 :] in units:
            return role, units[key[len(role) + 1 :]]
    return None, None


def _find(role: str, usual: Mapping[str, str]) -> Column | None:
    units, known = ROLES[role]
    for name in known:
        if name in usual:
            return Column(usual[name], CUSTOMARY_UNIT.get(name, CUSTOMARY_UNIT.get(role)))
        for unit, factor in units.items():
            if f"{name}_{unit}" in usual:
                return Column(usual[f"{name}_{unit}"], factor)
    return None


def _unit_of(role: str, name: str) -> float | None:
    """The unit that the name of a column given by the user carries, or the role's customary one."""
    for unit, factor in ROLES[role][0].items():
        if name.endswith("_" + unit):
            return factor
    return CUSTOMARY_UNIT.get(name, CUSTOMARY_UNIT.get(role))


def _position(roles: Mapping[str, Column], given: Iterable[str]) -> str | None:
    """Geographic before Cartesian before polar, unless the user mapped one of them."""
    complete = [kind for kind, needed in POSITIONS.items() if all(role in roles for role in needed)]
    wanted = {_role_and_unit(key)[0] for key in given}
    return max(complete, key=lambda kind: len(wanted.intersection(POSITIONS[kind])), default=None)


def _missing(file: str, what: str, names: Sequence[str], roles: Iterable[str]) -> str:
    looked = "; ".join(f"{role}: {', '.join(ROLES[role][1])}" for role in roles)
    example = "latitude=...,longitude=..." if what == "position" else f"{what}=..."
    need = "a pair latitude and longitude, x and y, or range and azimuth" if what == "position" else f"a {what} column"
    return (
        f"{file}: {need} is needed, but none was recognised.\n  Found: {_listed(names)}\n"
        f"  Looked for: {looked} "
        f"(also with a unit, such as altitude_ft)\n  Name them yourself: --columns {example}"
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if names else "no columns"
