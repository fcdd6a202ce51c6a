"""SBS-1 (BaseStation), as dump1090, readsb and many receivers write on port 30003: one message per line, no header."""

from __future__ import annotations

import re
from typing import Any

from ..errors import InputError
from .records import Format, Records, Refused

LINE = re.compile(rb"^(MSG|SEL|ID|AIR|STA|CLK),[1-8]?,[^\n]*,", re.MULTILINE)
DATE, TIME, LATITUDE, LONGITUDE, FIELDS = 6, 7, 14, 15, 16
KEPT = {"hex": 4, "callsign": 10, "altitude_ft": 11, "latitude": LATITUDE, "longitude": LONGITUDE, "on_ground": 21}


def recognises(head: bytes) -> bool:
    """Its first line is a message."""
    return LINE.match(head) is not None


def read(file: str, content: bytes) -> Records:
    """One row per message with a position; the others are counted in a note. Errors: InputError where there is none."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    others = 0
    for number, line in enumerate(content.decode("utf-8", errors="replace").splitlines()):
        fields = [field.strip() for field in line.split(",")]
        if not line.strip():
            continue
        if fields[0] != "MSG" and fields[0] in ("SEL", "ID", "AIR", "STA", "CLK"):
            others += 1
        elif fields[0] != "MSG" or len(fields) < FIELDS:
            refused.add(number, f"not a message of SBS-1: {len(fields)} fields, expected 22", line)
        elif not fields[LATITUDE] and not fields[LONGITUDE]:
            others += 1
        else:
            row: dict[str, Any] = {name: fields[at] or None for name, at in KEPT.items() if at < len(fields)}
            row["on_ground"] = "true" if row.get("on_ground") in ("-1", "1") else None
            rows.append({"row": number, "time": f"{fields[DATE]} {fields[TIME]}"} | row)
    if not rows:
        raise InputError(f"{file} is SBS-1 (BaseStation) without any position ({others} other messages)")
    notes = ["times of SBS-1 are those of the receiver's clock and zone; they are taken as UTC unless --time-zone says"]
    if others:
        notes.append(f"{others} messages without a position are not rows")
    return Records.of(rows, refused, notes, {"target": "hex", "time": "time"})


FORMAT = Format(
    "SBS-1 (BaseStation)",
    recognises,
    read,
    "a message with a position (MSG,2 and MSG,3)",
    "hex, latitude, longitude, altitude (feet), on the ground",
    "date and time of the message, in the receiver's zone (`--time-zone`)",
)
