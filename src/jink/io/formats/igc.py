"""IGC flight logs of gliders and paragliders (FAI technical specification, appendix A): fixed places in B records."""

from __future__ import annotations

import re
from datetime import date, timedelta
from typing import Any

from ..errors import InputError
from .records import Format, Records, Refused

FIX = re.compile(r"^B(\d{2})(\d{2})(\d{2})(\d{2})(\d{5})([NS])(\d{3})(\d{5})([EW])([AV])(-\d{4}|\d{5})(-\d{4}|\d{5})")
DAY = re.compile(r"^HF?DTE(?:DATE)?:? ?(\d{2})(\d{2})(\d{2})")
IDENTITY = re.compile(r"^H[FOP]GID(?:GLIDERID)? ?: ?(\S.*)$", re.IGNORECASE)
CIRCLE_2_SD = 2.486  # radius of the 95.45 % circle, which FXA states, over the sd of one axis


def recognises(head: bytes) -> bool:
    """An A record, and an H record of the date or a fix soon after."""
    text = head[:20000].decode("latin-1")
    return text.startswith(("A", "H")) and re.search(r"^(HF?DTE|B\d{6}\d{7}[NS])", text, re.MULTILINE) is not None


def read(file: str, content: bytes) -> Records:
    """One row per B record. Errors: InputError without a date or without a fix."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    day: date | None = None
    identity: str | None = None
    accuracy: slice | None = None
    before = -1
    for number, line in enumerate(content.decode("latin-1").splitlines()):
        if found := DAY.match(line):
            day = _date(found)
        elif found := IDENTITY.match(line):
            identity = found[1].strip()
        elif line.startswith("I"):
            accuracy = _accuracy_place(line)
        elif line.startswith("B"):
            found = FIX.match(line)
            if not found:
                refused.add(number, "not a B record of IGC", line)
                continue
            row = _fix(found, line, accuracy)
            second = row.pop("second")
            if day is not None and second < before - 43_200:
                day += timedelta(days=1)
            before = second
            clock = f"{found[1]}:{found[2]}:{found[3]}"
            rows.append({"row": number, "time": f"{day.isoformat()}T{clock}Z" if day else clock} | row)
    if not rows:
        raise InputError(f"{file} is an IGC file without any fix (B record)")
    if identity:
        rows = [row | {"target": identity} for row in rows]
    return Records.of(rows, refused)


def _date(found: re.Match[str]) -> date | None:
    year = int(found[3])
    try:
        return date(year + (1900 if year >= 80 else 2000), int(found[2]), int(found[1]))
    except ValueError:
        return None


def _fix(found: re.Match[str], line: str, accuracy: slice | None) -> dict[str, Any]:
    latitude = int(found[4]) + int(found[5]) / 60_000.0
    longitude = int(found[7]) + int(found[8]) / 60_000.0
    pressure, satellites = int(found[11]), int(found[12])
    row: dict[str, Any] = {
        "second": int(found[1]) * 3600 + int(found[2]) * 60 + int(found[3]),
        "latitude": -latitude if found[6] == "S" else latitude,
        "longitude": -longitude if found[9] == "W" else longitude,
        # V marks a fix without height from satellites
        "altitude_m": float(satellites) if found[10] == "A" else None,
        "baro_altitude": float(pressure),
    }
    stated = line[accuracy] if accuracy else ""
    if stated.isdigit() and int(stated) > 0:
        row["position_sd"] = int(stated) / CIRCLE_2_SD
    return row


def _accuracy_place(line: str) -> slice | None:
    """Where the I record says that FXA stands in B records."""
    for start, end, code in re.findall(r"(\d{2})(\d{2})([A-Z]{3})", line[3:]):
        if code == "FXA":
            return slice(int(start) - 1, int(end))
    return None


FORMAT = Format(
    "IGC",
    recognises,
    read,
    "a B record",
    "latitude, longitude, height from satellites (m), or by pressure if most have none; the glider's name",
    "UTC, with the date of the H record; it goes on after midnight",
    "FXA where the log has it",
)
