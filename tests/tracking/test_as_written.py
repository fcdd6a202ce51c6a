"""Files as receivers and other programs write them: what real files showed."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest
from straight import Journey

import jink

CAR = Journey()
PLANE = Journey(speed=230.0, course=100.0, latitude=49.0)
DAYS = 25_569.0  # from 1899-12-30 to 1970-01-01


def test_tracks_of_oziexplorer_count_days(tmp_path):
    head = "OziExplorer Track Point File Version 2.1\nWGS 84\nAltitude is in Feet\nReserved 3\n0,2,255,RIDE,0,0\n0\n"
    points = [
        f"{lat:.7f},{lon:.7f},{int(i == 0)},328.1,{DAYS + time.timestamp() / 86_400.0:.7f},,"
        for i, (time, (lat, lon)) in enumerate(zip(CAR.times, CAR.places, strict=True))
    ]
    (tmp_path / "ride.plt").write_text(head + "\n".join(points) + "\n")
    tracks, rejected, _ = jink.track(tmp_path / "ride.plt", kind="vehicle", details=True)
    # seven digits of a day are 9 ms
    CAR.agrees(tracks, start=False)
    assert not rejected.height
    assert abs((tracks["time"].min() - CAR.start).total_seconds()) < 0.01
    assert tracks["altitude"].median() == pytest.approx(100.0, abs=0.1)


def test_snapshots_of_older_receivers_have_heights_in_feet(tmp_path):
    lines = []
    for time, (lat, lon) in zip(PLANE.times, PLANE.places, strict=True):
        one = {"hex": "400f99", "lat": lat, "lon": lon, "nucp": 7, "seen_pos": 0.0, "altitude": 36000}
        one |= {"vert_rate": 0, "track": 100, "speed": 447, "mlat": [], "tisb": [], "rssi": -49.5}
        lines.append(json.dumps({"now": time.timestamp(), "messages": 9, "aircraft": [one]}))
    (tmp_path / "history.jsonl").write_text("\n".join(lines) + "\n")
    tracks, rejected, summary = jink.track(tmp_path / "history.jsonl", details=True)
    PLANE.agrees(tracks)
    assert not rejected.height
    assert tracks["altitude"].median() == pytest.approx(36000 * 0.3048, abs=1.0)
    assert summary["columns"]["speed"] == "gs"


def boxes(start: float, speed: float) -> str:
    return "".join(f"{k},1,{start + speed * k:.1f},100,40,90,1,-1,-1,-1\n" for k in range(1, 41))


@pytest.mark.parametrize("packed", [False, True])
def test_files_that_number_their_own_targets_are_kept_apart(tmp_path, packed):
    sets = {"seq-02/gt/gt.txt": boxes(100.0, 2.0), "seq-04/gt/gt.txt": boxes(900.0, -3.0)}
    for name, text in sets.items():
        (tmp_path / "in" / name).parent.mkdir(parents=True)
        (tmp_path / "in" / name).write_text(text)
    given = tmp_path / "in"
    if packed:
        given = tmp_path / "sets.zip"
        with zipfile.ZipFile(given, "w") as archive:
            for name, text in sets.items():
                archive.writestr(name, text)
    tracks, rejected, summary = jink.track(given, kind="person", details=True)
    assert tracks.height == 80 and not rejected.height
    assert sorted(tracks["target"].unique()) == ["seq-02/gt/gt/1", "seq-04/gt/gt/1"]
    assert "several_targets" not in [each["code"] for each in summary["warnings"]]


def test_logs_of_one_name_in_two_folders_are_two_targets_if_they_overlap(tmp_path):
    other = Journey(latitude=52.0)
    for folder, journey in (("phone", CAR), ("watch", other)):
        (tmp_path / folder).mkdir()
        lines = journey.lines("{t},{lat:.7f},{lon:.7f}")
        (tmp_path / folder / "log.csv").write_text("\n".join(["time,lat,lon", *lines]) + "\n")
    tracks, _, _ = jink.track(tmp_path, kind="vehicle", details=True)
    assert sorted(tracks["target"].unique()) == ["phone/log", "watch/log"]
    CAR.agrees(tracks.filter(tracks["target"] == "phone/log"))


def test_logs_of_one_name_that_follow_each_other_stay_one_target(tmp_path):
    lines = CAR.lines("{t},{lat:.7f},{lon:.7f}")
    for folder, part in (("day1", lines[:20]), ("day2", lines[20:])):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "log.csv").write_text("\n".join(["time,lat,lon", *part]) + "\n")
    tracks, _, _ = jink.track(tmp_path, kind="vehicle", details=True)
    CAR.agrees(tracks)
    assert tracks["target"].unique().to_list() == ["log"]


def messages(heights: bool) -> list[str]:
    """Positions and heights in messages of their own, and who measured in a few alone (as rs1090 writes them)."""
    rows = []
    for i, (time, (lat, lon)) in enumerate(zip(PLANE.times, PLANE.places, strict=True)):
        one = {"timestamp": time.timestamp(), "icao24": "400f99", "latitude": lat, "longitude": lon}
        rows.append(json.dumps(one))
        rows.append(json.dumps({"timestamp": time.timestamp() + 1.0, "icao24": "400f99", "df": "4"}))
        if heights:
            rows[-1] = json.dumps(json.loads(rows[-1]) | {"altitude": 36000 - 25 * (i % 2)})
        if i % 4 == 0:
            more = {"timestamp": time.timestamp() + 2.0, "icao24": "400f99", "source": "barometric", "bds": "09"}
            rows.append(json.dumps(more))
    return rows


@pytest.mark.parametrize("heights", [False, True])
def test_heights_in_messages_without_positions_are_no_third_axis(tmp_path, heights):
    (tmp_path / "decoded.jsonl").write_text("\n".join(messages(heights)) + "\n")
    tracks, rejected, summary = jink.track(tmp_path / "decoded.jsonl", details=True)
    measured = tracks.filter(tracks["status"] != "predicted")
    assert measured.height == 40 and tracks.height + rejected.height == 90
    assert np.median(measured["speed"].drop_nulls()) == pytest.approx(230.0, rel=0.01)
    assert any("'source' is empty in most rows" in note for note in summary["notes"])
