"""ASTERIX, as radars, trackers and ADS-B stations send: data blocks of CAT048, CAT062 and CAT021, one after the other.

A block is its category (one octet), its length (two) and records, whose items `asterix_layout.py` knows.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from ..errors import InputError
from .asterix_layout import CATEGORIES, Compound, Damaged, parts_of, record
from .records import Format, Records, Refused

DAY = 86_400.0
TICK = 1.0 / 128.0  # s
MILE, KNOTS = 1852.0, 3600.0 * 2.0**-14  # m, and knots in a unit of ground speed
TURN = 360.0 / 2**16  # degrees
LETTERS = "?ABCDEFGHIJKLMNOPQRSTUVWXYZ????? ???????????????0123456789??????"
NOT_READ = (1, 2, 8, 10, 11, 20, 34, 63, 65, 23, 25, 247)
SURE = 3  # blocks that follow each other are no accident
Row = dict[str, Any]


def recognises(head: bytes) -> bool:
    """Two blocks follow each other, or one is all there is; lengths below 0x900 make the second octet no text."""
    return bool(head) and (head[0] in CATEGORIES or head[0] in NOT_READ) and _follow(head, 0, 2)


def _follow(content: bytes, at: int, count: int) -> bool:
    """Whether so many blocks follow each other from here on, or fewer to the very end."""
    begin = at
    for _ in range(count):
        if at == len(content) and at > begin:
            return True
        if len(content) < at + 4 or content[at] == 0 or content[at + 1] > 8:
            return False
        length = int.from_bytes(content[at + 1 : at + 3])
        if length < 4 or at + length > len(content):
            return False
        at += length
    return True


def read(file: str, content: bytes) -> Records:
    """One row per record with a position, of the category that has most of them. Errors: InputError without any."""
    rows: dict[int, list[Row]] = {category: [] for category in CATEGORIES}
    refused = Refused()
    others: Counter[str] = Counter()
    for number, category, items in _records(content, refused, others):
        row = READERS[category](items)
        if row is None:
            others[f"CAT{category:03d} without a position or a time"] += 1
        else:
            rows[category].append({"row": number, "source": _source(items)} | row)
    category = max(rows, key=lambda each: len(rows[each]))
    table = rows[category]
    if not table:
        there = ", ".join(f"{count} of {words}" for words, count in others.items()) or "nothing that could be read"
        raise InputError(f"{file} is ASTERIX, of which jink reads CAT048, CAT062 and CAT021; it holds {there}")
    for other, left in rows.items():
        if other != category and left:
            others[f"CAT{other:03d}"] += len(left)
    _days(table)
    if category == 48:
        _identify(table)
    notes = [f"CAT{category:03d}; times of ASTERIX are of the day, in UTC, and go on after midnight"]
    notes += [f"{count} records of {words} are no rows" for words, count in others.items()]
    if category == 62:
        notes.append("CAT062 are tracks that another tracker has made: their errors are correlated in time")
    return Records.of(_alike(table), refused, notes, FIXED[category])


def _records(content: bytes, refused: Refused, others: Counter[str]) -> Iterator[tuple[int, int, dict[str, bytes]]]:
    """Number, category and items of every record; blocks of other categories are counted.

    Of a block that does not fit no record is believed. Reading goes on where blocks follow each other again.
    """
    at, number = 0, 0
    while at < len(content):
        length, category, sent = int.from_bytes(content[at + 1 : at + 3]), content[at], content[at : at + 20].hex()
        end = at + length
        if length < 4 or end > len(content):
            end = _resumed(content, at + 1)
            refused.add(number, f"no data block of ASTERIX: {end - at} octets are left out", sent)
            number += 1
        elif category not in CATEGORIES:
            others[f"CAT{category:03d}"] += 1
        else:
            found, why = _whole(content[at + 3 : end], category)
            reasons = [""] * len(found)
            if why:
                # where the block's length is wrong too, the records that it seems to hold come once more
                resumed = _resumed(content, at + 1)
                reasons = [f"in a block of CAT{category:03d} with a damaged record"] * len(found) * (resumed == end)
                reasons.append(f"a record of CAT{category:03d} {why}")
                end = resumed
            for row, reason in enumerate(reasons):
                if reason:
                    refused.add(number + row, reason, sent)
                else:
                    yield number + row, category, found[row]
            number += len(reasons)
        at = end


def _whole(block: bytes, category: int) -> tuple[list[dict[str, bytes]], str]:
    """The records of a block, and why they do not fill it."""
    found: list[dict[str, bytes]] = []
    place = 0
    while place < len(block):
        try:
            items, place = record(block, place, CATEGORIES[category])
        except Damaged as error:
            return found, f"{error} (damaged, or of another edition)"
        found.append(items)
    return found, ""


def _resumed(content: bytes, at: int) -> int:
    """Where blocks follow each other again; the end if nowhere."""
    while at < len(content) and not (content[at] in (*CATEGORIES, *NOT_READ) and _follow(content, at, SURE)):
        at += 1
    return at


def _unsigned(item: bytes) -> int:
    return int.from_bytes(item)


def _signed(item: bytes) -> int:
    return int.from_bytes(item, signed=True)


def _source(items: dict[str, bytes]) -> str | None:
    place = items.get("010")
    return f"{place[0]}/{place[1]}" if place else None


def _level(item: bytes | None, bits: int) -> float | None:
    """Feet of a level in quarters of a flight level, in the last `bits` bits."""
    if item is None:
        return None
    value = _unsigned(item) & ((1 << bits) - 1)
    return 25.0 * (value - (1 << bits) if value >> (bits - 1) else value)


def _text(item: bytes) -> str:
    """Eight letters of six bits."""
    number = _unsigned(item)
    return "".join(LETTERS[number >> (42 - 6 * k) & 63] for k in range(8)).strip()


def _plot(items: dict[str, bytes]) -> Row | None:
    """CAT048: a plot of a radar, with its range and azimuth."""
    if "140" not in items or "040" not in items:
        return None
    polar = items["040"]
    row: Row = {"time": TICK * _unsigned(items["140"])}
    row |= {"range": _unsigned(polar[:2]) * MILE / 256.0, "azimuth": TURN * _unsigned(polar[2:])}
    good = "090" in items and not items["090"][0] & 0x80
    height = _level(items["090"], 14) if good else _level(items.get("110"), 14)
    row |= {"altitude": height, "address": items["220"].hex() if "220" in items else None}
    row |= {"track": _unsigned(items["161"]) & 0xFFF if "161" in items else None}
    row |= {"squawk": f"{_unsigned(items['070']) & 0xFFF:04o}" if "070" in items else None}
    row |= {"callsign": _text(items["240"]) if "240" in items else None}
    if "120" in items:
        doppler = parts_of(items["120"], _layout(48, "120")).get(1)
        # the first bit says that it is doubtful
        if doppler is not None and not doppler[0] & 0x80:
            value = _unsigned(doppler) & 0x3FF
            row["range_rate"] = float(value - 1024 if value & 0x200 else value)
    return row


def _track(items: dict[str, bytes]) -> Row | None:
    """CAT062: an estimate of a tracker."""
    if "070" not in items or not ("105" in items or "100" in items):
        return None
    row: Row = {"time": TICK * _unsigned(items["070"])}
    row |= {"target": _unsigned(items["040"]) & 0x7FFF if "040" in items else None}
    if "105" in items:
        row |= {"latitude": _signed(items["105"][:4]) * 180.0 / 2**25}
        row |= {"longitude": _signed(items["105"][4:]) * 180.0 / 2**25}
    if "100" in items:
        row |= {"x": 0.5 * _signed(items["100"][:3]), "y": 0.5 * _signed(items["100"][3:])}
    if "185" in items:
        row |= {"vx": 0.25 * _signed(items["185"][:2]), "vy": 0.25 * _signed(items["185"][2:])}
    row["altitude"] = _level(items.get("136"), 16)
    if row["altitude"] is None:
        row["altitude"] = _level(items.get("135"), 15)
    if row["altitude"] is None and "130" in items:
        row["altitude"] = 6.25 * _signed(items["130"])
    if "220" in items:
        row["vertical_rate"] = 6.25 * _signed(items["220"])
    if "500" in items:
        row |= _claims(parts_of(items["500"], _layout(62, "500")), row, "136" in items or "135" in items)
    derived = parts_of(items["380"], _layout(62, "380")) if "380" in items else {}
    row |= {"address": derived[1].hex() if 1 in derived else None}
    row |= {"callsign": _text(derived[2]) if 2 in derived else None}
    return row


def _claims(parts: dict[int, bytes], row: Row, barometric: bool) -> Row:
    """The sds that a tracker states (I062/500): of position and velocity that of the worse axis."""
    found: Row = {}
    if 3 in parts and "latitude" in row:
        narrow = math.cos(math.radians(row["latitude"]))
        north, east = _unsigned(parts[3][:2]), narrow * _unsigned(parts[3][2:])
        found["position_sd"] = 60.0 * MILE * 180.0 / 2**25 * max(north, east)
    if 1 in parts:
        found["position_sd"] = 0.5 * max(_unsigned(parts[1][:2]), _unsigned(parts[1][2:]))
    part, step = (5, 25.0) if barometric else (4, 6.25)
    if part in parts:
        found["altitude_sd_ft"] = step * _unsigned(parts[part])
    if 6 in parts:
        found["velocity_sd"] = 0.25 * max(_unsigned(parts[6][:1]), _unsigned(parts[6][1:]))
    if 8 in parts:
        found["vertical_rate_sd_fpm"] = 6.25 * _unsigned(parts[8])
    return found


def _report(items: dict[str, bytes]) -> Row | None:
    """CAT021: an ADS-B report; the time is that for which its position holds, or of its reception."""
    time = next((items[name] for name in ("071", "073", "077") if name in items), None)
    if time is None or not ("130" in items or "131" in items):
        return None
    fine = "131" in items
    place, half, step = (items["131"], 4, 180.0 / 2**30) if fine else (items["130"], 3, 180.0 / 2**23)
    row: Row = {"time": TICK * _unsigned(time), "hex": items["080"].hex() if "080" in items else None}
    row |= {"latitude": step * _signed(place[:half]), "longitude": step * _signed(place[half:])}
    row["altitude"] = 6.25 * _signed(items["140"]) if "140" in items else _level(items.get("145"), 16)
    if "160" in items:
        row |= {"speed": KNOTS * (_unsigned(items["160"][:2]) & 0x7FFF), "course": TURN * _unsigned(items["160"][2:])}
    rate = items.get("157", items.get("155"))
    if rate is not None:
        value = _unsigned(rate) & 0x7FFF
        row["vertical_rate"] = 6.25 * (value - 0x8000 if value & 0x4000 else value)
    quality = items.get("090", b"")
    if len(quality) > 1:
        row |= {"nic": quality[0] >> 1 & 15, "nac_p": quality[1] >> 1 & 15, "nac_v": quality[0] >> 5}
    if len(quality) > 2:
        row["gva"] = quality[2] >> 1 & 3
    descriptor = items.get("040", b"")
    row["on_ground"] = len(descriptor) > 1 and bool(descriptor[1] & 0x40)
    row["callsign"] = _text(items["170"]) if "170" in items else None
    return row


def _layout(category: int, name: str) -> Compound:
    found = next(item[1] for item in CATEGORIES[category] if item is not None and item[0] == name)
    assert isinstance(found, Compound)
    return found


def _days(rows: list[Row]) -> None:
    """Times of day go on after midnight; records come late by seconds, never by half a day."""
    day, last = 0.0, None
    for row in rows:
        if last is not None and abs(row["time"] - last) > 0.5 * DAY:
            day += DAY if row["time"] < last else -DAY
        last = row["time"]
        row["time"] += day


def _identify(rows: list[Row]) -> None:
    """A plot's target: its aircraft's address, that of its track's other plots, its track's number, or its code."""
    addresses = {(row["source"], row["track"]): row["address"] for row in rows if row["track"] and row["address"]}
    for row in rows:
        track, address, code = row.pop("track"), row["address"], row["squawk"]
        target = address or (addresses.get((row["source"], track)) if track is not None else None)
        if target is None and track is not None:
            target = f"{row['source']} {track}"
        row["target"] = target or (f"A{code}" if code not in (None, "0000", "1000", "2000", "7000") else None)


def _alike(rows: list[Row]) -> list[Row]:
    """Of tracks with two kinds of position the one that all have."""
    everywhere = all("latitude" in row for row in rows)
    left_out = {"x", "y"} if everywhere else {"latitude", "longitude"}
    if not any(left_out & row.keys() for row in rows) or "range" in rows[0]:
        return rows
    return [{name: value for name, value in row.items() if name not in left_out} for row in rows]


READERS: dict[int, Callable[[dict[str, bytes]], Row | None]] = {48: _plot, 62: _track, 21: _report}
_ALL = {"time_s": "time", "altitude_ft": "altitude", "target": "target", "source": "source"}
FIXED = {
    48: _ALL | {"range_m": "range", "azimuth_deg": "azimuth", "range_rate_mps": "range_rate"},
    62: _ALL | {"vertical_rate_fpm": "vertical_rate"},
    21: _ALL | {"target": "hex", "speed_kt": "speed", "course_deg": "course", "vertical_rate_fpm": "vertical_rate"},
}
FORMAT = Format(
    "ASTERIX CAT048, CAT062, CAT021",
    recognises,
    read,
    "a record with a position, of the category that has most of them; other categories are counted",
    "CAT048: range and azimuth (I040), flight level (I090) or height (I110), Doppler speed (I120), and for the target "
    "the address (I220), track number (I161) or code (I070). CAT062: place (I105) or x and y (I100), velocity (I185), "
    "level (I136, I135) or height (I130), climb (I220), track number (I040). CAT021: place (I131, I130), height (I140) "
    "or level (I145), ground vector (I160), vertical rate (I157, I155), address (I080). Sources are SAC/SIC (I010)",
    "time of day in UTC: I048/140, I062/070, I021/071 or 073 or 077",
    "CAT021: NACp, NIC, GVA and NACv (I090). CAT062: sds of position, height, velocity and climb (I500)",
)
