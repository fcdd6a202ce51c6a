"""ASTERIX: records that an encoder of the tests' own writes from the specification's layouts, read and tracked."""

from __future__ import annotations

import contextlib
import math
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from straight import GEOD, START, Journey

import jink
from jink.io.errors import InputError
from jink.io.formats import asterix
from jink.io.formats.asterix_layout import CATEGORIES

PLANE = Journey(speed=230.0, course=100.0, latitude=49.0, step=4.0)
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


@pytest.mark.parametrize(("category", "make"), [(21, reports), (62, tracks_of_a_tracker)])
def test_places_of_the_journey(tmp_path, category, make):
    path = written(tmp_path / "x.ast", category, make(PLANE))
    tracks, rejected, summary = jink.track(path, details=True)
    PLANE.agrees(tracks, start=False)
    assert rejected.height == 0 and tracks["altitude"].to_numpy() == pytest.approx(10668.0, abs=1.0)
    assert tracks["time"][0] == pytest.approx(14.5 * 3600)
    assert any("records of CAT034 are no rows" in note for note in summary["notes"])
    assert tracks["target"].unique().to_list() == [{21: "3c660c", 62: "4980"}[category]]
    assert tracks["latitude"][-1] == pytest.approx(PLANE.places[-1][0], abs=1e-3)


def test_plots_of_a_radar(tmp_path):
    path = written(tmp_path / "x.ast", 48, plots(PLANE))
    tracks, rejected, summary = jink.track(path, site=(48.3, 7.0, 0.0), details=True)
    assert rejected.height == 0 and summary["columns"]["range"] == "range"
    assert tracks["speed"].median() == pytest.approx(230.0, rel=0.02)
    assert tracks["latitude"][-1] == pytest.approx(PLANE.places[-1][0], abs=3e-3)
    assert tracks["altitude"].to_numpy() == pytest.approx(10668.0, abs=20.0)


def test_a_record_as_it_was_sent():
    """A record of CAT048 that EUROCONTROL's users know from many descriptions of decoders."""
    content = bytes.fromhex(
        "300030fdf70219c9356d4da0c5aff1e0020005283c660c10c236d4182001c0780031bc0000400deb07b9582e410020f5"
    )
    row = asterix.read("x", content).frame.row(0, named=True)
    assert (row["target"], row["callsign"], row["squawk"], row["source"]) == ("3c660c", "DLH65A", "1000", "25/201")
    assert row["time"] == 27354.6015625 and row["altitude"] == 33000.0
    assert row["range"] == 197.68359375 * 1852 and row["azimuth"] == 340.13671875


def test_times_of_day_go_on_after_midnight(tmp_path):
    late = Journey(speed=230.0, course=100.0, latitude=49.0, start=MIDNIGHT - timedelta(seconds=60))
    tracks = jink.track(written(tmp_path / "x.ast", 21, reports(late)))
    late.agrees(tracks, start=False)
    assert tracks["time"].max() > 86400.0


def test_a_velocity_and_marks_are_read():
    row = asterix.read("x", block(21, reports(PLANE)[0]) * 2).frame.row(0, named=True)
    assert row["speed"] == pytest.approx(230.0 * 3600 / 1852, abs=0.2) and row["course"] == pytest.approx(100, abs=0.01)
    assert row["nac_v"] == 0
    assert (row["nic"], row["nac_p"], row["on_ground"], row["vertical_rate"]) == (8, 10, False, 0.0)


def test_a_tracker_states_its_accuracy():
    """I062/500 with the place (degrees), the height by pressure, the velocity and the climb."""
    items = {"010": b"\x19\x64", "070": number(128 * 50000, 3), "040": number(4980, 2)}
    items |= {"105": number(60.0 * 2**25 / 180, 4) + number(11.0 * 2**25 / 180, 4), "136": number(350 * 4, 2)}
    parts = [number(50, 2) + number(120, 2), b"\x02", b"\x04\x06", b"\x28"]
    # part 3, 5, 6 and 8: bits 0x20, 0x08, 0x04, and 0x80 of the next octet
    items |= {"220": number(-8, 2), "500": b"\x2d\x80" + b"".join(parts)}
    row = asterix.read("x", block(62, packed(62, items)) * 2).frame.row(0, named=True)
    assert row["position_sd"] == pytest.approx(120 * 180 / 2**25 * 111_120 * 0.5)
    assert (row["altitude_sd_ft"], row["velocity_sd"], row["vertical_rate_sd_fpm"]) == (50.0, 1.5, 250.0)


def test_what_is_not_read_is_named(tmp_path):
    service = bytes.fromhex("220010f6190e023a692b408840408000")
    (tmp_path / "x.ast").write_bytes(service * 3)
    with pytest.raises(
        InputError, match="ASTERIX, of which jink reads CAT048, CAT062 and CAT021; it holds 3 of CAT034"
    ):
        jink.track(tmp_path / "x.ast")


def test_damaged_records_are_rejected_and_nothing_is_lost(tmp_path):
    records = reports(PLANE)
    broken = records[7][:-9]
    path = tmp_path / "x.ast"
    path.write_bytes(b"".join(block(21, broken if k == 7 else one) for k, one in enumerate(records)))
    tracks, rejected, _ = jink.track(path, details=True)
    assert (tracks.height, rejected.height) == (39, 1) and "ends too early" in rejected["reason"][0]


def test_mutated_bytes_raise_nothing_but_input_errors():
    content = b"".join(block(21, one) for one in reports(PLANE)) + b"".join(block(48, one) for one in plots(PLANE))
    random = np.random.default_rng(12)
    for _ in range(300):
        changed = bytearray(content)
        for place in random.integers(0, len(content), 8):
            changed[place] = random.integers(0, 256)
        with contextlib.suppress(InputError):
            asterix.read("x", bytes(changed[: random.integers(1, len(content))]))


def test_text_is_not_taken_for_asterix():
    assert not asterix.recognises(b"0,1,2\n0,1,2\n") and not asterix.recognises(b">id,time\n" * 100)
    assert all(len(items) > 25 for items in CATEGORIES.values())
