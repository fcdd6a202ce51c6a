"""Geolife and OziExplorer trajectories (PLT): six lines of head, then latitude, longitude, break, feet, days, date,
time. OziExplorer's files may leave out date and time, but not the days.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

from ..errors import InputError
from .head import is_number
from .records import Format, Records, Refused

HEAD = 6
NO_HEIGHT = -777.0
FIRST_DAY = datetime(1899, 12, 30)


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
                "time": f"{fields[5]} {fields[6]}Z" if fields[5] and fields[6] else _of_days(fields[4]),
                "latitude": fields[0],
                "longitude": fields[1],
                "altitude_ft": None if height == NO_HEIGHT else height,
            }
        )
    if not rows:
        raise InputError(f"{file} is a Geolife trajectory without any point")
    return Records.of(rows, refused)


def _of_days(text: str) -> str | None:
    """A moment in days since 1899-12-30, whose eleven digits tell it to the millisecond; None for what is no number."""
    if not is_number(text) or not 0.0 < float(text) < 100_000.0:
        return None
    moment = FIRST_DAY + timedelta(milliseconds=round(float(text) * 86_400_000.0))
    return moment.isoformat(sep=" ", timespec="milliseconds") + "Z"


FORMAT = Format(
    "Geolife and OziExplorer PLT",
    recognises,
    read,
    "a point, counted after the head",
    "latitude, longitude, altitude (feet; −777 is missing)",
    "date and time of the last two fields, or the days since 1899-12-30 before them; UTC",
)
