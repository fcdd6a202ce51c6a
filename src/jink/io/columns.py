"""Which column is what: by the usual names of the trade, by the units that names carry, and by the user's word.

A name is compared in lower case with everything but letters and digits as `_`. If it is not known as it
stands, its ending is tried as a unit: `altitude_ft`, `Range [km]`, `azimuth_deg`, `time_ms`. Without a unit a
column is in SI units (metres, radians, seconds), except where its name has a unit by custom (`alt_baro` of
readsb is in feet); what cannot be known from the name is decided from the values (`meaning.py`) and said in
the summary.
"""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field

from ..frozen import frozen
from .errors import InputError, NoTable
from .roles import ALTITUDES, CUSTOMARY_UNIT, MARKS, POSITIONS, ROLES
from .units import CLOCKS

USED = {  # roles that matter beside the position itself, by its kind
    "geographic": {"altitude", "nacp", "nic", "gva", "course", "velocity_x", "velocity_y", "vertical_rate"},
    "cartesian": {"z", "course", "velocity_x", "velocity_y", "vertical_rate", "range", "azimuth"},
    "polar": {"elevation", "altitude", "range_rate"},
}
SEVERAL = ("target", "time", "altitude")  # roles for which other columns are kept in mind
WORDS = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")


@frozen
class Column:
    """One recognised column: its name in the table, its unit in SI units (None: the name does not say), and the name
    that people know it by where that is another.
    """

    name: str
    unit: float | None
    shown: str = ""


@frozen
class Columns:
    """The recognised columns of one table by role, which kind of position they hold, and others that may be meant.

    given: roles that the user named; idle: those of them, with their columns, that such positions have no use for.
    """

    position: str
    roles: dict[str, Column]
    names: tuple[str, ...]
    others: dict[str, tuple[Column, ...]] = field(default_factory=dict)
    given: frozenset[str] = frozenset()
    idle: dict[str, str] = field(default_factory=dict)

    def named(self) -> dict[str, str]:
        """Role to column name, as it is said in the summary."""
        return {role: column.shown or column.name for role, column in self.roles.items()}


def normal(name: str) -> str:
    """Lower case without accents, everything but letters and digits as one `_`: `Range [km]` becomes `range_km`."""
    name = name.lower().replace("°", "deg")
    if not name.isascii():
        name = "".join(letter for letter in unicodedata.normalize("NFKD", name) if not unicodedata.combining(letter))
    return re.sub(r"[^0-9a-z]+", "_", name).strip("_")


def is_altitude(name: str) -> bool:
    """Whether a column's name says that it is a height, which points up whatever the axes do."""
    return re.search(rf"(^|_)({'|'.join(ALTITUDES)})(_|$)", normal(name)) is not None


def recognise(
    file: str, names: Sequence[str], given: Mapping[str, str] | None = None, fixed: Mapping[str, str] | None = None
) -> Columns:
    """Find every role's column, by `given` (role or role_unit: name), what the format has `fixed`, or usual names.

    Errors: InputError where there is no position or no time.
    """
    given = given or {}
    roles = _given_roles(file, names, given)
    told = frozenset(roles)
    fixed_roles = _given_roles(file, names, {key: name for key, name in (fixed or {}).items() if name in names})
    roles |= {role: column for role, column in fixed_roles.items() if role not in roles}
    taken = {column.name for column in roles.values()}
    usual = _usual([name for name in names if name not in taken])
    others: dict[str, tuple[Column, ...]] = {}
    for role in ROLES:
        found = _find(role, usual)
        if role not in roles and found:
            roles[role] = found[0]
            if role in SEVERAL:
                others[role] = tuple(dict.fromkeys(found[1:]))
    position = _position(roles, given)
    if position is None:
        raise NoTable(_missing(file, "position", names, ("latitude", "longitude", "x", "y", "range", "azimuth")))
    only_seconds = "time" not in roles or ("second" in roles and roles["time"].name == roles["second"].name)
    if {"year", "month", "day"} <= roles.keys() and only_seconds and "time" not in told:
        roles["time"] = roles["year"]  # the parts are put together when the values are read (moments.py)
    if "time" not in roles:
        raise InputError(_missing(file, "time", names, ("time",)))
    roles, told = _heights_as_told(roles, told, position)
    used = _used(roles, position, told)
    idle = {role: roles[role].name for role in sorted(told - used.keys()) if roles[role] not in used.values()}
    return Columns(position, used, tuple(names), others, told, idle)


def _heights_as_told(
    roles: dict[str, Column], told: frozenset[str], position: str
) -> tuple[dict[str, Column], frozenset[str]]:
    """A height that the user named, by the role that it has beside this kind of position: altitude, or z."""
    here, there = ("z", "altitude") if position == "cartesian" else ("altitude", "z")
    if there not in told or here in told:
        return roles, told
    return {**roles, here: roles[there]}, told | {here}


def _used(roles: dict[str, Column], position: str, told: frozenset[str]) -> dict[str, Column]:
    """The roles that matter for this kind of position."""
    used = {"target", "time", "speed", "source", *POSITIONS[position], *USED[position], *MARKS}
    if "elevation" in roles and position == "polar" and "altitude" not in told:
        used.discard("altitude")
    if position != "geographic":
        used -= {"place", "north_south", "east_west"}
    elif all(role in roles for role in POSITIONS[position]) and "place" not in told:
        used.discard("place")
    measured = {roles[role].name for role in POSITIONS[position] if role in roles}
    if roles["time"] is not roles.get("year"):
        measured.add(roles["time"].name)
        used -= {"year", "month", "day", "hour", "minute", "second"}
    return {
        role: column
        for role, column in roles.items()
        if role in used and (role not in MARKS or column.name not in measured)
    }


def _usual(names: Sequence[str]) -> dict[str, str]:
    """Names as they are compared, to names as written; of paths (`OSD.latitude`, `/fix/longitude`) also the last one or
    two words, where no other column has them.
    """
    known: dict[str, str] = {}
    ends: dict[str, list[str]] = {}
    for name in names:
        words = [word for word in re.split(r"[./]", name) if word]
        for count in (1, 2):
            if len(words) > count:
                ends.setdefault(normal(".".join(words[-count:])), []).append(name)
    known |= {end: found[0] for end, found in ends.items() if len(found) == 1}
    known |= {normal(WORDS.sub("_", name)): name for name in reversed(names)}
    return known | {normal(name): name for name in reversed(names)}


def _given_roles(file: str, names: Sequence[str], given: Mapping[str, str]) -> dict[str, Column]:
    roles: dict[str, Column] = {}
    if not isinstance(given, Mapping):
        raise InputError(f"columns: expected roles and the names of their columns, got {given!r}")
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
                f"  Found: {listed(names)}"
            )
        roles[role] = Column(name, unit if unit is not None else unit_of(role, normal(name)))
    return roles


def _role_and_unit(key: str) -> tuple[str | None, float | None]:
    if key in ROLES:
        return key, None
    for role, (units, _) in ROLES.items():
        if key.startswith(role + "_") and key[len(role) + 1 :] in units:
            return role, units[key[len(role) + 1 :]]
    return None, None


def _find(role: str, usual: Mapping[str, str]) -> list[Column]:
    """All columns that a role's names fit, the preferred first."""
    units, known = ROLES[role]
    found = []
    for name in known:
        if name in usual:
            found.append(Column(usual[name], CUSTOMARY_UNIT.get(name, CUSTOMARY_UNIT.get(role))))
        else:
            found += [Column(usual[f"{name}_{u}"], factor) for u, factor in units.items() if f"{name}_{u}" in usual]
            if role in ("time", "date"):
                found += [Column(usual[f"{name}_{zone}"], None) for zone in CLOCKS if f"{name}_{zone}" in usual]
    return found


def unit_of(role: str, name: str) -> float | None:
    """The unit that the name of a column given by the user carries, or the role's customary one."""
    for unit, factor in ROLES[role][0].items():
        if name.endswith("_" + unit):
            return factor
    return CUSTOMARY_UNIT.get(name, CUSTOMARY_UNIT.get(role))


def _position(roles: Mapping[str, Column], given: Iterable[str]) -> str | None:
    """Geographic before Cartesian before polar, unless the user mapped one of them; last one column for a place."""
    complete = [kind for kind, needed in POSITIONS.items() if all(role in roles for role in needed)]
    wanted = {_role_and_unit(key)[0] for key in given}
    if "place" in wanted or (not complete and "place" in roles):
        return "geographic"
    return max(complete, key=lambda kind: len(wanted.intersection(POSITIONS[kind])), default=None)


def _missing(file: str, what: str, names: Sequence[str], roles: Iterable[str]) -> str:
    looked = "; ".join(f"{role}: {', '.join(ROLES[role][1])}" for role in roles)
    example = "latitude=...,longitude=..." if what == "position" else f"{what}=..."
    need = "a pair latitude and longitude, x and y, or range and azimuth" if what == "position" else f"a {what} column"
    return (
        f"{file}: {need} is needed, but none was recognised.\n  Found: {listed(names)}\n"
        f"  Looked for: {looked} "
        f"(also with a unit, such as altitude_ft)\n  Name them yourself: --columns {example}"
    )


def listed(names: Sequence[str]) -> str:
    """Column names as a message lists them."""
    return ", ".join(names) if names else "no columns"
