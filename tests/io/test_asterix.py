"""ASTERIX: records that an encoder of the tests' own writes from the specification's layouts, read and tracked."""

from __future__ import annotations

from datetime import timedelta

import pytest
from asterix_written import MIDNIGHT, block, number, packed, plots, reports, tracks_of_a_tracker, written
from straight import Journey

import jink
from jink.io.errors import InputError
from jink.io.formats import asterix
from jink.io.formats.asterix_layout import CATEGORIES

PLANE = Journey(speed=230.0, course=100.0, latitude=49.0, step=4.0)


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


def test_files_that_tell_no_date_are_said_to_be_of_one_day(tmp_path):
    late = Journey(speed=230.0, course=100.0, latitude=49.0, start=MIDNIGHT - timedelta(seconds=100))
    records = reports(late)
    files = [written(tmp_path / f"{k}.ast", 21, records[20 * k : 20 * k + 20]) for k in range(2)]
    said = "times of several files count from midnight and tell no date"
    assert any(note.startswith(said) for note in jink.track(files, details=True).summary["notes"])
    assert not any(note.startswith(said) for note in jink.track(files[:1], details=True).summary["notes"])


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


def blocks_of(records: list[bytes], each: int = 4) -> list[bytes]:
    return [block(21, *records[k : k + each]) for k in range(0, len(records), each)]


@pytest.mark.parametrize("octet", [1, 2])
def test_reading_goes_on_behind_a_block_whose_length_is_wrong(tmp_path, octet):
    blocks = [bytearray(one) for one in blocks_of(reports(PLANE))]
    blocks[3][octet] ^= 5
    (tmp_path / "x.ast").write_bytes(b"".join(blocks))
    tracks, rejected, summary = jink.track(tmp_path / "x.ast", details=True)
    PLANE.agrees(tracks, rows=36, start=False)
    # one row stands for the damage: the records of the blocks behind it are read in their own place
    assert (rejected.height, summary["rows"]) == (1, 37)


def test_octets_between_blocks_are_counted():
    blocks = blocks_of(reports(PLANE))
    found = asterix.read("x", b"".join([*blocks[:4], b"\x00" * 50, *blocks[4:], blocks[0][:-5]]))
    assert found.frame["row"].to_list() == [*range(16), *range(17, 41)]
    lost = len(blocks[0]) - 5
    said = [f"no data block of ASTERIX: {count} octets are left out" for count in (50, lost)]
    assert found.refused["reason"].to_list() == said


def test_no_record_of_a_damaged_block_is_believed():
    records = reports(PLANE)
    found = asterix.read(
        "x", b"".join([*blocks_of(records[:8]), block(21, *records[8:10], records[10][:-9]), *blocks_of(records[12:])])
    )
    assert found.frame["row"].to_list() == [*range(8), *range(11, 39)]
    assert found.refused["row"].to_list() == [8, 9, 10] and "ends too early" in found.refused["reason"][2]


def test_text_is_not_taken_for_asterix():
    assert not asterix.recognises(b"0,1,2\n0,1,2\n") and not asterix.recognises(b">id,time\n" * 100)
    assert all(len(items) > 25 for items in CATEGORIES.values())
