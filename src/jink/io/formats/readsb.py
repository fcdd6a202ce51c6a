"""readsb and dump1090: snapshots of all aircraft (aircraft.json, history_*.json, one per line too) and traces of one.

Layouts: README-json.md of wiedehopf/readsb. A position is as old as `seen_pos` says when the snapshot is taken.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from ..errors import InputError
from .documents import documents
from .records import Format, Records, Refused

# what is kept of an aircraft in a snapshot
FIELDS = (
    *("hex", "flight", "lat", "lon", "alt_geom", "alt_baro", "gs", "track", "geom_rate", "baro_rate", "seen_pos"),
    *("nic", "nac_p", "gva", "nac_v"),
)
# dump1090 before 2018 (dump1090-mutability) has other names for what the transponder reports, in the same units
OLDER = {"altitude": "alt_baro", "speed": "gs", "vert_rate": "baro_rate"}
# places in a point of a trace
TRACE = {"lat": 1, "lon": 2, "alt_baro": 3, "gs": 4, "track": 5, "baro_rate": 7, "alt_geom": 10, "geom_rate": 11}


def snapshot(head: bytes) -> bool:
    """`{"now": ..., "aircraft": [...]}`."""
    return head.startswith((b"{", b"[")) and re.search(rb'"aircraft"\s*:\s*\[', head) is not None and b'"now"' in head


def trace(head: bytes) -> bool:
    """`{"icao": ..., "timestamp": ..., "trace": [[...]]}`."""
    return head.startswith(b"{") and re.search(rb'"trace"\s*:\s*\[', head) is not None and b'"icao"' in head


def read_snapshots(file: str, content: bytes) -> Records:
    """One row per aircraft and snapshot. Errors: InputError where there is none."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    for number, (now, aircraft) in enumerate(_aircraft(file, content, refused)):
        if not isinstance(aircraft, dict):
            refused.add(number, "not a JSON object", aircraft)
        else:
            row = {OLDER[name]: aircraft[name] for name in OLDER if name in aircraft}
            row |= {name: aircraft[name] for name in FIELDS if name in aircraft}
            rows.append({"row": number, "time": now} | row)
    if not rows:
        raise InputError(f"{file} is a snapshot of readsb or dump1090 without any aircraft")
    return Records.of(rows, refused, fixed={"time_s": "time", "target": "hex"})


def _aircraft(file: str, content: bytes, refused: Refused) -> Iterator[tuple[Any, Any]]:
    """The time of the snapshot and each of its aircraft."""
    for number, value, text in documents(file, content):
        for shot in value if isinstance(value, list) else [value]:
            if not isinstance(shot, dict) or not isinstance(shot.get("aircraft"), list):
                refused.add(number, "not a snapshot of aircraft" if value is not None else "not valid JSON", text)
                continue
            for aircraft in shot["aircraft"]:
                yield shot.get("now"), aircraft


def read_traces(file: str, content: bytes) -> Records:
    """One row per point of a trace; its time counts from the trace's timestamp."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    number = 0
    for _, value, _ in documents(file, content):
        start = value.get("timestamp") if isinstance(value, dict) else None
        points = value.get("trace") if isinstance(value, dict) else None
        for point in points if isinstance(points, list) else []:
            if isinstance(point, list) and len(point) > 3 and _number(point[0]) and _number(start):
                row = {"row": number, "hex": value.get("icao"), "time": start + point[0]}
                rows.append(row | {name: point[at] for name, at in TRACE.items() if at < len(point)})
            else:
                refused.add(number, "not a point of a trace", point)
            number += 1
    if not rows:
        raise InputError(f"{file} is a trace of readsb without any point")
    return Records.of(rows, refused, fixed={"time_s": "time", "target": "hex"})


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


SNAPSHOTS = Format(
    "readsb/dump1090 aircraft.json",
    snapshot,
    read_snapshots,
    "an aircraft in a snapshot; several snapshots as JSON Lines or in an array",
    "hex, lat, lon, alt_geom or alt_baro (feet, or ground), gs (knots), track, geom_rate or baro_rate (ft/min)",
    "now − seen_pos, seconds since 1970",
    "nac_p, nic, gva; nac_v of velocities",
)
TRACES = Format(
    "readsb trace_full.json",
    trace,
    read_traces,
    "a point of the trace",
    "icao, lat, lon, altitude (feet, or ground), ground speed (knots), track, vertical rate (ft/min)",
    "timestamp + offset, seconds since 1970",
)
