"""Geolife trajectories (PLT): six lines of head, then latitude, longitude, 0, feet, days, date, time."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from .head import is_number
from .records import Format, Records, Refused

HEAD = 6
NO_HEIGHT = -777.0


def recognises(head: bytes) -> bool:
    """Its first line says so."""
    return head.startswith(b"Geolife trajectory") or head.startswith(b"OziExplorer Track Point File")


def read(file: str, content: bytes) -> Records:
    """One row per point. Errors: InputError where there is none."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    for number, line in enumerate(content.decode("utf-8", errors="replace").splitlines()[HEAD:]):
        fields = [field.strip() for field in line.split(",")]
        if not line.strip():
            continue
        if len(fields) < 7 or not is_number(fields[3]):
            refused.add(number, f"not a point of Geolife: {len(fields)} fields, expected 7", line)
            continue
        height = float(fields[3])
        rows.append(
            {
                "row": number,
                "time": f"{fields[5]} {fields[6]}",
                "latitude": fields[0],
                "longitude": fields[1],
                "altitude_ft": None if height == NO_HEIGHT else height,
            }
        )
    if not rows:
        raise InputError(f"{file} is a Geolife trajectory without any point")
    return Records.of(rows, refused)


FORMAT = Format(
    "Geolife PLT",
    recognises,
    read,
    "a point, counted after the head",
    "latitude, longitude, altitude (feet; −777 is missing)",
    "date and time of the last two fields, UTC",
)
