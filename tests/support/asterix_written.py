"""An encoder of ASTERIX of the tests' own, from the specification's layouts."""

from __future__ import annotations

import math
from pathlib import Path

from straight import GEOD, START, Journey

MIDNIGHT = START.replace(hour=0, minute=0)
# the items of each category by their place in a record; -: spare
ITEMS = {
    48: "010 140 020 040 070 090 130 220 240 250 161 042 200 170 210 030 080 100 110 120",
    62: "010 - 015 070 105 100 185 210 060 245 380 040 080 290 200 295 136 130 135 220 390 270 300 110 120 510 500",
    21: "010 040 161 015 071 130 131 072 150 151 080 073 074 075 076 140 090 210 070 230 145 152 200 155 157 160",
}
ORDER = {category: text.split() for category, text in ITEMS.items()}


def number(value: float, octets: int) -> bytes:
    return (round(value) % (1 << 8 * octets)).to_bytes(octets)


def packed(category: int, items: dict[str, bytes]) -> bytes:
    """A record: its FSPEC by the order of the items, and the items."""
    places = [ORDER[category].index(name) for name in items]
    octets = [sum(0x80 >> place % 7 for place in places if place // 7 == k) for k in range(max(places) // 7 + 1)]
    fspec = bytes(octet | (k < len(octets) - 1) for k, octet in enumerate(octets))
    return fspec + b"".join(items[name] for name in sorted(items, key=ORDER[category].index))


def block(category: int, *records: bytes) -> bytes:
    content = b"".join(records)
    return bytes([category]) + number(len(content) + 3, 2) + content


def seconds(time) -> float:
    return (time - MIDNIGHT).total_seconds() % 86400.0


def reports(journey: Journey) -> list[bytes]:
    """CAT021, with the velocity that the journey has."""
    out = []
    for time, (lat, lon) in zip(journey.times, journey.places, strict=True):
        items = {"010": b"\x19\xc9", "040": b"\x01\x00", "071": number(128 * seconds(time), 3)}
        items |= {"131": number(lat * 2**30 / 180, 4) + number(lon * 2**30 / 180, 4), "080": b"\x3c\x66\x0c"}
        items |= {"140": number(35000 / 6.25, 2), "090": b"\x11\x14", "157": number(0, 2)}
        items["160"] = number(journey.speed / 1852 * 2**14, 2) + number(journey.course * 65536 / 360, 2)
        out.append(packed(21, items))
    return out


def tracks_of_a_tracker(journey: Journey) -> list[bytes]:
    """CAT062, with an address among the derived data, and ages, which are skipped."""
    out = []
    for time, (lat, lon) in zip(journey.times, journey.places, strict=True):
        items = {"010": b"\x19\x64", "070": number(128 * seconds(time), 3), "040": number(4980, 2)}
        items |= {"105": number(lat * 2**25 / 180, 4) + number(lon * 2**25 / 180, 4), "136": number(350 * 4, 2)}
        items |= {"380": b"\x80\x3c\x0a\x55"}
        items |= {"080": b"\x01\x03\x40", "290": b"\x09\x40\x00\x01\x07", "220": number(-8, 2)}
        out.append(packed(62, items))
    return out


def plots(journey: Journey) -> list[bytes]:
    """CAT048 of a radar 80 km to the south, with characteristics and Mode S data, which are skipped."""
    out = []
    for time, (lat, lon) in zip(journey.times, journey.places, strict=True):
        azimuth, _, distance = GEOD.inv(7.0, 48.3, lon, lat)
        items = {"010": b"\x19\xc9", "140": number(128 * seconds(time), 3), "020": b"\xa0"}
        items["040"] = number(math.hypot(distance, 10668) / 1852 * 256, 2) + number(azimuth % 360 * 65536 / 360, 2)
        items |= {"070": b"\x08\x00", "090": number(350 * 4, 2), "130": b"\x60\x02\xb7", "161": b"\x00\x2a"}
        items |= {"220": b"\x3c\x66\x0c", "240": b"\x10\xc2\x36\xd4\x18\x20", "250": b"\x01" + bytes(8)}
        out.append(packed(48, items))
    return out


def written(path: Path, category: int, records: list[bytes], size: int = 3) -> Path:
    blocks = [block(category, *records[k : k + size]) for k in range(0, len(records), size)]
    # service messages of a radar stand between
    path.write_bytes(b"".join(one + bytes.fromhex("220010f6190e023a692b408840408000")[:16] for one in blocks))
    return path
