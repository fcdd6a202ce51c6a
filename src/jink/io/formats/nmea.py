"""NMEA 0183 of GPS receivers: RMC, GGA, GLL and ZDA sentences, put together by their time of day."""

from __future__ import annotations

import re
from typing import Any

from ..errors import InputError
from .head import is_number
from .records import Format, Records, Refused

SENTENCE = re.compile(r"\$([A-Z]{2})([A-Z]{3}),([^*]*)(?:\*([0-9A-Fa-f]{2}))?")
AIS = re.compile(r"![A-Z]{2}VD[MO],")
POSITIONS = ("RMC", "GGA", "GLL")
OTHERS = ("#", "%", ";", "//", "!")  # how comments of loggers begin, and sentences that hold other things


def recognises(head: bytes) -> bool:
    """A sentence among its first lines, perhaps behind a time or a name of its logger."""
    lines = head[:4000].splitlines()[:20]
    return (
        sum(re.search(rb"\$(G[PNLABQI]|BD|II)[A-Z]{3},[^*]*\*[0-9A-Fa-f]{2}", line) is not None for line in lines) > 0
    )


def read(file: str, content: bytes) -> Records:
    """One row per instant of a receiver, numbered by the line of its first sentence. Errors: InputError without any."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    latest: dict[str, Any] | None = None
    day, others = "", 0
    for number, line in enumerate(content.decode("latin-1").splitlines()):
        found = SENTENCE.search(line)
        others += AIS.search(line) is not None
        if not found:
            if line.strip() and not line.lstrip().startswith(OTHERS):
                refused.add(number, "not a sentence of NMEA 0183", line)
            continue
        fields = found[3].split(",")
        if found[4] and _checksum(found[0]) != int(found[4], 16):
            refused.add(number, "wrong checksum", line)
            continue
        kind = found[2]
        day = _day(kind, fields) or day
        if kind not in POSITIONS:
            continue
        row = _fix(kind, fields)
        if row is None:
            refused.add(number, f"not a {kind} sentence of NMEA 0183", line)
            continue
        if latest is not None and latest["clock"] == row["clock"]:
            latest.update({name: value for name, value in row.items() if value is not None})
        else:
            latest = {"row": number} | row
            rows.append(latest)
        latest["day"] = day
    if not rows:
        raise InputError(f"{file} is NMEA 0183 without any RMC, GGA or GLL sentence")
    _date(rows)
    said = f"{others} sentences of AIS are not read beside those of a receiver; a file of them alone is"
    return Records.of(rows, refused, [said] if others else [])


def _checksum(sentence: str) -> int:
    value = 0
    for letter in sentence[1 : sentence.rindex("*")]:
        value ^= ord(letter)
    return value


def _day(kind: str, fields: list[str]) -> str:
    """The date in a RMC or ZDA sentence, as ISO 8601; nothing in others."""
    if kind == "RMC" and len(fields) > 8 and re.fullmatch(r"\d{6}", fields[8]):
        text = fields[8]
        return f"{'19' if int(text[4:]) >= 80 else '20'}{text[4:]}-{text[2:4]}-{text[:2]}"
    if kind == "ZDA" and len(fields) > 3 and re.fullmatch(r"\d{4}", fields[3]):
        return f"{fields[3]}-{fields[2]:0>2}-{fields[1]:0>2}"
    return ""


def _fix(kind: str, fields: list[str]) -> dict[str, Any] | None:
    """Time of day, position, height and whether the receiver believes it."""
    clock, place, status = {"RMC": (0, 2, 1), "GGA": (0, 1, 5), "GLL": (4, 0, 5)}[kind]
    if len(fields) <= max(clock, place + 3, status) or not re.match(r"\d{6}", fields[clock]):
        return None
    row: dict[str, Any] = {
        "clock": fields[clock],
        "latitude": _degrees(fields[place], fields[place + 1]),
        "longitude": _degrees(fields[place + 2], fields[place + 3]),
    }
    if kind == "GGA":
        row["altitude_m"] = float(fields[8]) if len(fields) > 8 and is_number(fields[8]) else None
    # RMC and GLL: A or V; GGA: the quality of the fix, 0 for none
    row["valid"] = "false" if fields[status] in ("V", "0") else None
    if kind == "RMC" and len(fields) > 6 and is_number(fields[6]):
        row["speed_kt"] = float(fields[6])
    if kind == "RMC" and len(fields) > 7 and is_number(fields[7]):
        row["cog"] = float(fields[7])
    return row


def _degrees(text: str, letter: str) -> float | None:
    """ddmm.mmmm and a letter to signed degrees."""
    if not is_number(text):
        return None
    whole, minutes = divmod(float(text), 100.0)
    value = whole + minutes / 60.0
    return -value if letter in ("S", "W") else value


def _date(rows: list[dict[str, Any]]) -> None:
    """Date and time of day of each row as one text; rows before the first date get that; without any, none."""
    first = next((row["day"] for row in rows if row["day"]), "")
    for row in rows:
        clock, day = row.pop("clock"), row.pop("day") or first
        text = f"{clock[:2]}:{clock[2:4]}:{clock[4:]}"
        row["time"] = f"{day} {text}Z" if day else text


FORMAT = Format(
    "NMEA 0183",
    recognises,
    read,
    "an instant: RMC, GGA and GLL of one time of day together",
    "latitude, longitude, altitude (m), speed (knots), course; sentences marked V or 0 are rejected",
    "UTC with the date of RMC or ZDA; without one, seconds of the day",
)
