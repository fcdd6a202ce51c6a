"""KML: gx:Track with a time for each place, and placemarks of one point with a TimeStamp."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree

from ..errors import InputError
from .markup import elements, local, numbered, rooted, text_of
from .records import Format, Records, Refused

ZERO = re.compile(r"-?0+(?:\.0*)?")


def recognises(head: bytes) -> bool:
    """Its root element is kml."""
    return rooted(head, b"kml")


def read(file: str, content: bytes) -> Records:
    """One row per place of a track or point; a placemark with a track is a target, points of one name too.

    Errors: InputError where no place has a time.
    """
    rows: list[dict[str, Any]] = []
    refused = Refused()
    seen: dict[str, int] = {}
    untimed = number = 0
    for event, name, element in elements(file, content):
        if event != "end" or name != "Placemark":
            continue
        title = next((c.text for c in element if local(c.tag) == "name" and c.text and c.text.strip()), "")
        tracks = [child for child in element.iter() if local(child.tag) == "Track"]
        untimed += sum(local(child.tag) == "LineString" for child in element.iter())
        places = [_track(track) for track in tracks] or [_point(element)]
        target = numbered((title or "track").strip(), seen) if tracks else (title or "").strip() or None
        for when, place in (pair for pairs in places for pair in pairs):
            row = _row(when, place)
            if row is None:
                refused.add(number, "not a place of KML", place)
            else:
                rows.append({"row": number, "target": target} | row)
            number += 1
        element.clear()
    if not rows:
        raise InputError(
            f"{file} is KML, but no place in it has a time ({untimed} lines without times); jink reads gx:Track and "
            "points with a TimeStamp"
        )
    # KML asks for heights: a target whose heights are all 0 has none
    high = {row["target"] for row in rows if not ZERO.fullmatch(row.get("altitude_m", "0"))}
    for row in rows:
        if row["target"] not in high:
            row.pop("altitude_m", None)
    # placemarks of a journey are often named by their times or numbers: then the name is no target
    names = {row["target"] for row in rows}
    if len(names) > len(rows) / 2 and len(rows) > 3:
        rows = [{name: value for name, value in row.items() if name != "target"} for row in rows]
    notes = [f"{untimed} lines without times are not read"] if untimed else []
    return Records.of(rows, refused, notes)


def _track(track: ElementTree.Element) -> list[tuple[str | None, str]]:
    """Times and places of a gx:Track: as many of each, in the same order."""
    times = [child.text for child in track if local(child.tag) == "when"]
    places = [(child.text or "").strip() for child in track if local(child.tag) == "coord"]
    times += [None] * (len(places) - len(times))
    return list(zip(times, places, strict=False))


def _point(placemark: ElementTree.Element) -> list[tuple[str | None, str]]:
    """The time and place of a placemark of one point."""
    for child in placemark.iter():
        if local(child.tag) == "Point":
            place = text_of(child, "coordinates")
            when = text_of(placemark, "when") or text_of(placemark, "begin")
            return [(when, place.replace(",", " "))] if place and when else []
    return []


def _row(when: str | None, place: str) -> dict[str, Any] | None:
    numbers = place.split()
    if len(numbers) < 2:
        return None
    row: dict[str, Any] = {"time": when, "longitude": numbers[0], "latitude": numbers[1]}
    return row | ({"altitude_m": numbers[2]} if len(numbers) > 2 else {})


FORMAT = Format(
    "KML",
    recognises,
    read,
    "a place of a gx:Track, or a placemark of one point with a TimeStamp",
    "the placemark's name, longitude, latitude, altitude (m)",
    "when, ISO 8601",
)
