"""AIS as NMEA 0183 sentences (!AIVDM, !AIVDO), decoded by pyais; the time is what the receiver added to each line.

A message itself has the second of the minute alone. Receivers add a tag block (`\\c:1559041817*hh\\`), or the time
before or behind the sentence; without either, the reports of base stations among the messages tell the time.
"""

from __future__ import annotations

import re
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any

from ..errors import InputError
from .records import Format, Records, Refused

LINE = re.compile(r"^(.*?)(![A-Z]{2}VD[MO],(\d),(\d),(\d?),([^,]*),[^,]*,\d\*[0-9A-Fa-f]{2})(.*)$")
TAG = re.compile(r"[\\,]c:(\d{9,13})")
EPOCH = re.compile(r"(?<!\d)(1\d{9}(?:\.\d+)?|1\d{12})(?!\d)")
ISO = re.compile(r"(\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}:\d{2}(?:\.\d+)?)")
POSITIONS = (1, 2, 3, 9, 18, 19, 27)
BASE = 4


def recognises(head: bytes) -> bool:
    """A sentence among its first lines."""
    return any(LINE.match(line) for line in head[:8000].decode("latin-1").splitlines()[:20])


def read(file: str, content: bytes) -> Records:
    """One row per position report. Errors: InputError without pyais, without a position or without any time."""
    try:
        from pyais import decode  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InputError(f"{file} holds AIS sentences, which need the package pyais: pip install 'jink[ais]'") from None
    rows: list[dict[str, Any]] = []
    refused = Refused()
    parts: dict[tuple[str, ...], list[str]] = {}
    others, now = 0, None
    for number, line in enumerate(content.decode("latin-1").splitlines()):
        found = LINE.match(line)
        if not found:
            if line.strip() and not line.startswith(("#", "$")):
                refused.add(number, "not a sentence of AIS", line)
            continue
        before, sentence, total, place, sequence, channel, after = found.groups()
        now = _time(before, after) or now
        key = (total, sequence, channel)
        waiting = parts.setdefault(key, []) if total != "1" else []
        waiting.append(sentence)
        if int(place) < int(total):
            continue
        parts.pop(key, None)
        try:
            message = decode(*waiting, error_if_checksum_invalid=True)
        except Exception as error:  # pyais raises many kinds for a damaged sentence
            refused.add(number, f"not a message of AIS: {type(error).__name__}", line)
            continue
        now = (_of_base(message) if message.msg_type == BASE else None) or now
        if message.msg_type not in POSITIONS:
            others += 1
            continue
        if getattr(message, "lat", None) is None or getattr(message, "lon", None) is None:
            refused.add(number, "not a whole message of AIS: it ends before the position", line)
            continue
        rows.append({"row": number} | _report(message, now))
    if not rows:
        raise InputError(f"{file} holds AIS sentences without any position report ({others} other messages)")
    if all(row["time"] is None for row in rows):
        raise InputError(
            f"{file} holds AIS sentences without a time: messages have the second of the minute alone; let the "
            "receiver add a tag block (\\c:1559041817*hh\\) or the time before each line"
        )
    notes = [f"{others} messages without a position are not rows"] if others else []
    return Records.of(rows, refused, notes, {"time_s": "time", "target": "mmsi", "speed_kt": "speed"})


def _report(message: Any, now: float | None) -> dict[str, Any]:
    """What a position report holds; class B has the same fields."""
    return {
        "mmsi": str(message.mmsi),
        "time": now,
        "latitude": float(message.lat),
        "longitude": float(message.lon),
        "speed": _available(message, "speed", 102.3),
        "cog": _available(message, "course", 360.0),
    }


def _available(message: Any, name: str, none: float) -> float | None:
    """A field of the message, if it is below the value that says that there is none."""
    value = getattr(message, name, None)
    return float(value) if value is not None and float(value) < none - 1e-6 else None


def _time(before: str, after: str) -> float | None:
    """Seconds since 1970 that the receiver wrote beside a sentence."""
    if found := TAG.search("\\" + before.lstrip("\\")):
        value = float(found[1])
        return value / 1000.0 if value > 1e11 else value
    for text in (before, after):
        if found := ISO.search(text):
            with suppress(ValueError):  # the thirteenth month
                return datetime.fromisoformat(found[1].replace(" ", "T")).replace(tzinfo=UTC).timestamp()
        if found := EPOCH.search(text):
            value = float(found[1])
            return value / 1000.0 if value > 1e11 else value
    return None


def _of_base(message: Any) -> float | None:
    """The time in a base station's report."""
    try:
        parts = (message.year, message.month, message.day, message.hour, message.minute, message.second)
        return datetime(*parts, tzinfo=UTC).timestamp()
    except (TypeError, ValueError):
        return None


FORMAT = Format(
    "AIS sentences (AIVDM)",
    recognises,
    read,
    "a position report (messages 1, 2, 3, 9, 18, 19, 27)",
    "mmsi, latitude, longitude, speed (knots), course; needs `jink[ais]`",
    "what the receiver wrote beside the sentence (tag block, epoch or ISO 8601), or base stations' reports",
)
