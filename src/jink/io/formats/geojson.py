"""GeoJSON (RFC 7946): points with a time among their properties, and lines with a list of times (coordTimes)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from ..errors import InputError
from .documents import documents
from .records import Format, Records, Refused

TIMES = ("coordTimes", "coordinateProperties", "times", "timestamps", "time", "linestringTimestamps")
PLACES = ("longitude", "latitude", "lon", "lat", "lng", "long", "altitude", "alt", "ele", "x", "y", "z")


def recognises(head: bytes) -> bool:
    """A feature, or a collection of them; the first one may fill the head, before any type is told."""
    if not head.startswith((b"{", b"[")):
        return False
    if re.match(rb'\{\s*"features"\s*:\s*\[\s*\{\s*"geometry"\s*:\s*\{', head):
        return True
    if b'"type"' not in head:
        return False
    return b'"FeatureCollection"' in head or (b'"Feature"' in head and b'"geometry"' in head)


def read(file: str, content: bytes) -> Records:
    """One row per point or place of a line with times; properties are columns. Errors: InputError without any."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    untimed = number = 0
    for feature in _features(file, content, refused):
        properties: dict[str, Any] = _object(feature.get("properties")) or {}
        geometry = _object(feature.get("geometry"))
        lines = _lines(geometry)
        if lines:
            times = _times(properties, lines)
            if times is None:
                untimed += 1
                continue
            own = {name: value for name, value in properties.items() if not isinstance(value, list | dict)}
            pairs = zip((place for line in lines for place in line), times, strict=False)
        else:
            own, pairs = properties, [(geometry.get("coordinates") if geometry else None, None)]
        for place, when in pairs:
            row = _row(own, place, when, feature.get("id"))
            if row is None:
                refused.add(number, "not a place of GeoJSON", json.dumps(place))
            else:
                rows.append({"row": number} | row)
            number += 1
    if not rows:
        raise InputError(
            f"{file} is GeoJSON without points; its {untimed} lines have no times (coordTimes among their properties)"
        )
    notes = [f"{untimed} lines without times are not read; points are"] if untimed else []
    fixed = {"longitude_deg": "longitude", "latitude_deg": "latitude"}
    fixed |= {"altitude_m": "altitude_m"} if any("altitude_m" in row for row in rows) else {}
    return Records.of(rows, refused, notes, fixed)


def _object(value: Any) -> dict[str, Any] | None:
    return value if isinstance(value, dict) else None


def _features(file: str, content: bytes, refused: Refused) -> Iterator[dict[str, Any]]:
    for line, value, text in documents(file, content):
        values = value.get("features") if isinstance(value, dict) and "features" in value else value
        for feature in values if isinstance(values, list) else [values]:
            if isinstance(feature, dict):
                yield feature
            else:
                refused.add(line, "not a feature of GeoJSON", text)


def _lines(geometry: dict[str, Any] | None) -> list[list[Any]]:
    """The places of a line or several; nothing for other geometries."""
    coordinates = geometry.get("coordinates") if geometry else None
    if not isinstance(coordinates, list):
        return []
    if geometry and geometry.get("type") == "LineString":
        return [coordinates]
    if geometry and geometry.get("type") == "MultiLineString":
        return [line for line in coordinates if isinstance(line, list)]
    return []


def _times(properties: dict[str, Any], lines: list[list[Any]]) -> list[Any] | None:
    """One time per place of the lines, if there is such a list among the properties."""
    for name in TIMES:
        value = properties.get(name)
        if name == "coordinateProperties" and isinstance(value, dict):
            value = value.get("times")
        if isinstance(value, list) and value and isinstance(value[0], list):
            value = [item for part in value for item in part]
        if isinstance(value, list) and len(value) == sum(len(line) for line in lines):
            return value
    return None


def _row(own: dict[str, Any], place: Any, when: Any, identity: Any) -> dict[str, Any] | None:
    """Properties under their own names; the place goes before columns of the same name."""
    row = {name: value for name, value in own.items() if name.lower() not in PLACES and not isinstance(value, list)}
    if when is not None:
        row["time"] = when
    if identity is not None and "id" not in row:
        row["id"] = identity
    if not isinstance(place, list) or len(place) < 2 or not all(isinstance(v, int | float) for v in place[:2]):
        return None
    row |= {"longitude": float(place[0]), "latitude": float(place[1])}
    if len(place) > 2 and isinstance(place[2], int | float):
        row["altitude_m"] = float(place[2])
    else:
        row |= {name: value for name, value in own.items() if name.lower() in ("altitude", "alt", "ele")}
    return row


FORMAT = Format(
    "GeoJSON",
    recognises,
    read,
    "a point, or a place of a line with times",
    "longitude, latitude, altitude (m); properties by their names",
    "a property (time, timestamp, t, …), or coordTimes of a line",
)
