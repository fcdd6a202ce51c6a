"""TCX of sports watches: track points with time and position."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from .markup import elements, rooted, text_of
from .records import Format, Records


def recognises(head: bytes) -> bool:
    """Its root element is TrainingCenterDatabase."""
    return rooted(head, b"TrainingCenterDatabase")


def read(file: str, content: bytes) -> Records:
    """One row per track point; those without a position (indoors, before the first fix) are rows too."""
    rows: list[dict[str, Any]] = []
    names = {
        "time": "Time",
        "latitude": "LatitudeDegrees",
        "longitude": "LongitudeDegrees",
        "altitude_m": "AltitudeMeters",
    }
    for event, name, element in elements(file, content):
        if event == "end" and name == "Trackpoint":
            rows.append({"row": len(rows)} | {ours: text_of(element, theirs) for ours, theirs in names.items()})
            element.clear()
    if not any(row["latitude"] for row in rows):
        raise InputError(f"{file} is TCX with {len(rows)} track points, but none has a position")
    return Records.of(rows)


FORMAT = Format(
    "TCX",
    recognises,
    read,
    "a track point",
    "latitude, longitude, altitude (m)",
    "Time, ISO 8601",
)
