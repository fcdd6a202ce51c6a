"""OpenSky's REST interface: state vectors of all aircraft at one time, and the track of one.

Fields: https://openskynetwork.github.io/opensky-api/rest.html
"""

from __future__ import annotations

import re
from typing import Any

from ..errors import InputError
from .documents import documents
from .records import Format, Records, Refused

STATE = {
    "icao24": 0,
    "callsign": 1,
    "time_position": 3,
    "longitude": 5,
    "latitude": 6,
    "baro_altitude": 7,
    "on_ground": 8,
    "velocity_mps": 9,
    "true_track": 10,
    "vertical_rate_mps": 11,
    "geo_altitude": 13,
}
PATH = {"time": 0, "latitude": 1, "longitude": 2, "baro_altitude": 3, "on_ground": 5}


def recognises(head: bytes) -> bool:
    """`{"time": ..., "states": [[...]]}` or `{"icao24": ..., "path": [[...]]}`."""
    if not head.startswith((b"{", b"[")):
        return False
    lists = re.search(rb'"(states|path)"\s*:\s*\[', head)
    return lists is not None and (b'"time"' if lists[1] == b"states" else b'"icao24"') in head


def read(file: str, content: bytes) -> Records:
    """One row per state vector or way point. Errors: InputError where there is none."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    number = 0
    for line, value, text in documents(file, content):
        for shot in value if isinstance(value, list) else [value]:
            if not isinstance(shot, dict):
                refused.add(line, "not a response of OpenSky" if value is not None else "not valid JSON", text)
                continue
            states = isinstance(shot.get("states"), list)
            places = STATE if states else PATH
            for state in shot["states"] if states else shot.get("path") or []:
                if isinstance(state, list) and len(state) >= 6:
                    row = {name: state[at] for name, at in places.items() if at < len(state)}
                    rows.append({"row": number} | ({} if states else {"icao24": shot.get("icao24")}) | row)
                else:
                    refused.add(number, "not a state vector", state)
                number += 1
    if not rows:
        raise InputError(f"{file} is a response of OpenSky without any state")
    return Records.of(rows, refused, fixed={"target": "icao24", "time_s": "time_position", "speed_mps": "velocity_mps"})


FORMAT = Format(
    "OpenSky states and tracks (JSON)",
    recognises,
    read,
    "a state vector or a way point; several responses as JSON Lines",
    "icao24, latitude, longitude, geo_altitude or baro_altitude (m), on_ground, velocity, vertical rate (m/s), track",
    "time_position, seconds since 1970",
)
