"""GPX 1.0 and 1.1: track points, or route points and way points where there is no track."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from ..errors import InputError
from .markup import elements, local, numbered, rooted
from .records import Format, Records

POINTS = ("trkpt", "rtept", "wpt")


NAMES = {"speed": "speed_mps", "course": "course_deg"}  # of GPX 1.0, and of extensions


def recognises(head: bytes) -> bool:
    """Its root element is gpx."""
    return rooted(head, b"gpx")


def read(file: str, content: bytes) -> Records:
    """One row per point; a track is a target. Errors: InputError without a point that has a time."""
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in POINTS}
    seen: dict[str, int] = {}
    points: list[dict[str, Any]] = []
    for event, name, element in elements(file, content):
        if event == "start":
            if name in ("trk", "rte"):
                points = []
            continue
        if name in POINTS:
            row = _point(element)
            points.append(row)
            found[name].append(row)
            element.clear()
        elif name in ("trk", "rte"):
            title = next((c.text for c in element if local(c.tag) == "name" and c.text and c.text.strip()), None)
            target = numbered(title.strip() if title else "track", seen)
            for row in points:
                row["target"] = target
            element.clear()
    kind = next((kind for kind in POINTS if any(row["time"] for row in found[kind])), None)
    if kind is None:
        count = sum(len(rows) for rows in found.values())
        raise InputError(f"{file} is GPX with {count} points, but none has a time; a route that was not travelled?")
    rows = [row | {"row": number} for number, row in enumerate(found[kind])]
    others = sum(len(points) for name, points in found.items() if name != kind)
    return Records.of(rows, notes=[f"{others} points that are in no track are not rows"] if others else [])


def _point(element: ElementTree.Element) -> dict[str, Any]:
    row: dict[str, Any] = {"latitude": element.get("lat"), "longitude": element.get("lon"), "time": None}
    for child in element.iter():
        name = local(child.tag)
        if child.text and child.text.strip():
            if name == "time":
                row["time"] = child.text.strip()
            elif name == "hdop":
                row["hdop"] = child.text.strip()
            elif name == "ele":
                row["altitude_m"] = child.text.strip()
            elif name in ("speed", "course"):
                row[NAMES[name]] = child.text.strip()
    return row


FORMAT = Format(
    "GPX",
    recognises,
    read,
    "a track point (without tracks: a route point or way point)",
    "the track's name, lat, lon, ele (m); speed (m/s) and course where a device adds them",
    "time, ISO 8601",
    "estimated, scaled by hdop where there is one",
)
