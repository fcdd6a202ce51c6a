"""SBS-1 (BaseStation), as dump1090, readsb and many receivers write on port 30003: one message per line, no header.

Positions (MSG,2 and MSG,3) and velocities (MSG,4) are messages of their own. A position takes the last velocity of its
aircraft, if that is no older than `FRESH`.
"""

from __future__ import annotations

import re
from datetime import datetime
from typing import Any

from ..errors import InputError
from .records import Format, Records, Refused

LINE = re.compile(rb"^(MSG|SEL|ID|AIR|STA|CLK),[1-8]?,[^\n]*,", re.MULTILINE)
DATE, TIME, LATITUDE, LONGITUDE, FIELDS = 6, 7, 14, 15, 16
VELOCITY = {"speed_kt": 12, "track": 13, "vertical_rate_fpm": 16}
FRESH = 2.0  # s: transponders send a velocity twice a second
KEPT = {"hex": 4, "callsign": 10, "altitude_ft": 11, "latitude": LATITUDE, "longitude": LONGITUDE, "on_ground": 21}


def recognises(head: bytes) -> bool:
    """Its first line is a message."""
    return LINE.match(head) is not None


def read(file: str, content: bytes) -> Records:
    """One row per message with a position; the others are counted in a note. Errors: InputError where there is none."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    others = joined = 0
    velocities: dict[str, tuple[datetime, dict[str, Any]]] = {}
    for number, line in enumerate(content.decode("utf-8", errors="replace").splitlines()):
        fields = [field.strip() for field in line.split(",")]
        if not line.strip():
            continue
        if fields[0] != "MSG" and fields[0] in ("SEL", "ID", "AIR", "STA", "CLK"):
            others += 1
        elif fields[0] != "MSG" or len(fields) < FIELDS:
            refused.add(number, f"not a message of SBS-1: {len(fields)} fields, expected 22", line)
        elif not fields[LATITUDE] and not fields[LONGITUDE]:
            found = _velocity(fields)
            if found is None:
                others += 1
            else:
                velocities[fields[KEPT["hex"]]] = found
        else:
            row: dict[str, Any] = {name: fields[at] or None for name, at in KEPT.items() if at < len(fields)}
            row["on_ground"] = "true" if row.get("on_ground") in ("-1", "1") else None
            velocity = (_velocity(fields) or (None, {}))[1] or _last(velocities.get(fields[KEPT["hex"]]), fields)
            joined += bool(velocity)
            rows.append({"row": number, "time": f"{fields[DATE]} {fields[TIME]}"} | row | velocity)
    if not rows:
        raise InputError(f"{file} is SBS-1 (BaseStation) without any position ({others} other messages)")
    if not any(row["time"].strip() for row in rows):
        raise InputError(
            f"{file} is SBS-1 (BaseStation) whose messages have no date and time; the program that received them has "
            "to write these"
        )
    notes = ["times of SBS-1 are those of the receiver's clock and zone; they are taken as UTC unless --time-zone says"]
    if joined:
        notes.append(f"{joined} positions have the last velocity of their aircraft (MSG,4), up to {FRESH:g} s old")
    if others:
        notes.append(f"{others} messages without a position are not rows")
    return Records.of(rows, refused, notes, {"target": "hex", "time": "time"})


def _instant(fields: list[str]) -> datetime | None:
    try:
        return datetime.fromisoformat(f"{fields[DATE].replace('/', '-')} {fields[TIME]}")
    except ValueError:
        return None


def _velocity(fields: list[str]) -> tuple[datetime, dict[str, Any]] | None:
    """When a message tells a velocity, and what it tells; None if it does not."""
    when = _instant(fields)
    told = {name: fields[at] for name, at in VELOCITY.items() if at < len(fields) and fields[at]}
    return (when, told) if when is not None and "speed_kt" in told else None


def _last(velocity: tuple[datetime, dict[str, Any]] | None, fields: list[str]) -> dict[str, Any]:
    """The aircraft's last velocity, if it is fresh when a position comes."""
    when = _instant(fields)
    if velocity is None or when is None or not 0.0 <= (when - velocity[0]).total_seconds() <= FRESH:
        return {}
    return velocity[1]


FORMAT = Format(
    "SBS-1 (BaseStation)",
    recognises,
    read,
    "a message with a position (MSG,2 and MSG,3)",
    "hex, latitude, longitude, altitude (feet), on the ground; of MSG,4 ground speed (knots), track and vertical rate "
    "(ft/min)",
    "date and time of the message, in the receiver's zone (`--time-zone`)",
)
