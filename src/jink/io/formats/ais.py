"""AIS as NMEA 0183 sentences (!AIVDM, !AIVDO), decoded by pyais; the time is what the receiver added to each line.

A message itself has the second of the minute alone. Receivers add a tag block (`\\c:1559041817*hh\\`), or the time
before or behind the sentence; without either, the reports of base stations among the messages tell the minute.
"""

from __future__ import annotations

import re
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from typing import Any

from ..errors import InputError
from .records import Format, Records, Refused

LINE = re.compile(r"^(.*?)(![A-Z]{2}VD[MO],(\d),(\d),(\d?),([^,]*),[^,]*,\d\*[0-9A-Fa-f]{2})(.*)$")
TAG = re.compile(r"[\\,]c:(\d{9,13})")
EPOCH = re.compile(r"(?<!\d)(1\d{9}(?:\.\d+)?|1\d{12})(?!\d)")
ISO = re.compile(r"(\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}:\d{2}(?:[.,]\d+)?(?:Z|[+-]\d{2}:?\d{2})?)")
POSITIONS = (1, 2, 3, 9, 18, 19, 27)
BASE = 4
NO_SPEED = {9: 1023.0, 27: 63.0}  # knots that say that there is none; 102.3 in all other messages
ZONELESS = "times that the receiver wrote without a zone are taken as UTC unless --time-zone says"


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
        own = _time(before, after)
        now = own or now
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
        rows.append({"row": number, "time": own or _at_second(now, message)} | _report(message))
    if not rows:
        raise InputError(f"{file} holds AIS sentences without any position report ({others} other messages)")
    if all(row["time"] is None for row in rows):
        raise InputError(
            f"{file} holds AIS sentences without a time: messages have the second of the minute alone; let the "
            "receiver add a tag block (\\c:1559041817*hh\\) or the time before each line"
        )
    notes = [f"{others} messages that are no position reports are not rows"] if others else []
    zoned = all(row["time"] is None or row["time"].tzinfo for row in rows)
    notes += [] if zoned else [ZONELESS]
    for row in rows:
        row["time"] = row["time"] and (row["time"].timestamp() if zoned else row["time"].isoformat())
    return Records.of(
        rows, refused, notes, {"time_s" if zoned else "time": "time", "target": "mmsi", "speed_kt": "speed"}
    )


def _report(message: Any) -> dict[str, Any]:
    """What a position report holds beside its time; class B has the same fields."""
    return {
        "mmsi": str(message.mmsi),
        "latitude": float(message.lat),
        "longitude": float(message.lon),
        "speed": _available(message, "speed", NO_SPEED.get(message.msg_type, 102.3)),
        "cog": _available(message, "course", 360.0),
    }


def _available(message: Any, name: str, none: float) -> float | None:
    """A field of the message, if it is below the value that says that there is none."""
    value = getattr(message, name, None)
    return float(value) if value is not None and float(value) < none - 1e-6 else None


def _time(before: str, after: str) -> datetime | None:
    """The time that the receiver wrote beside a sentence, with its zone where it has one."""
    if found := TAG.search("\\" + before.lstrip("\\")):
        return _of_epoch(found[1])
    for text in (before, after):
        if found := ISO.search(text):
            with suppress(ValueError):  # the thirteenth month
                return datetime.fromisoformat(found[1].replace(",", "."))
        if found := EPOCH.search(text):
            return _of_epoch(found[1])
    return None


def _of_epoch(text: str) -> datetime:
    value = float(text)
    return datetime.fromtimestamp(value / 1000.0 if value > 1e11 else value, UTC)


def _of_base(message: Any) -> datetime | None:
    """The time in a base station's report."""
    try:
        parts = (message.year, message.month, message.day, message.hour, message.minute, message.second)
        return datetime(*parts, tzinfo=UTC)
    except (TypeError, ValueError):
        return None


def _at_second(now: datetime | None, message: Any) -> datetime | None:
    """The last known time, moved to the second that the message tells: up to 10 s before it, or else after it."""
    second = getattr(message, "second", None)
    if now is None or second is None or not 0 <= second < 60:
        return now
    return now + timedelta(seconds=(second - now.second + 10) % 60 - 10, microseconds=-now.microsecond)


FORMAT = Format(
    "AIS sentences (AIVDM)",
    recognises,
    read,
    "a position report (messages 1, 2, 3, 9, 18, 19, 27)",
    "mmsi, latitude, longitude, speed (knots), course; needs `jink[ais]`",
    "what the receiver wrote beside the sentence (tag block, epoch or ISO 8601, without a zone in `--time-zone`); else "
    "the minute of base stations' reports and the second of the message",
)
