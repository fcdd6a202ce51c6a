"""The same journey in every format that people have: read, tracked, and every row accounted for."""

from __future__ import annotations

import io
import json
import os
import threading
import zipfile
from pathlib import Path

import numpy as np
import pytest
from formats_written import CAR, FILES, PLANE, kml_points, kml_track, nmea

import jink
from jink.io.errors import InputError
from jink.io.formats.registry import FORMATS
from jink.io.loading import Reading, load_files
from jink.io.writing import write_tracks

TABLES = ("Flightradar24", "nested JSON", "one list in an object", "JSON by columns", "JSON of lists")


@pytest.mark.parametrize(("write", "journey", "height"), FILES.values(), ids=FILES)
def test_the_same_journey_is_found_in_every_format(tmp_path, write, journey, height):
    path = tmp_path / "given.dat"
    path.write_text(write(), encoding="utf-8")
    tracks, rejected, summary = jink.track(path, kind="vehicle" if journey is CAR else "aircraft", details=True)
    journey.agrees(tracks)
    assert not rejected.height and tracks["target"].n_unique() == 1
    if height is None:
        assert "altitude" not in tracks.columns
    else:
        # heights of vehicles on level ground are tracked to rounding
        assert tracks["altitude"].median() == pytest.approx(height, abs=0.1)
    assert any(
        note.startswith(("read as", "the columns are those of", "nested JSON", "JSON by columns"))
        for note in summary["notes"]
    )


def test_a_format_is_told_by_its_content_alone(tmp_path):
    for name, (write, _, _) in FILES.items():
        head = write().encode()
        fitting = [known.title for known in FORMATS if known.recognises(head)]
        assert len(fitting) == (0 if name in TABLES else 1), (name, fitting)


KML = "<kml><Placemark><LineString><coordinates>1,2 3,4</coordinates></LineString></Placemark></kml>"
LINE = {"type": "LineString", "coordinates": [[1, 2], [3, 4]]}
FEATURES = {"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": LINE}]}
DETECTION = "{},-1,794.2,47.5,71.2,174.8,67.5,-1,-1,-1"
MESSAGE = "MSG,8,1,1,ABC123,1,2024/01/15,14:30:00.000,2024/01/15,14:30:00.000,,,,,,,,,,,,0"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<gpx><wpt lat='1' lon='2'/></gpx>", "GPX with 1 points, but none has a time"),
        ("<gpx><trk><trkseg><trkpt lat='1' lon='2'>", "XML that cannot be read"),
        ("<!DOCTYPE gpx [<!ENTITY a 'b'>]><gpx>&a;</gpx>", "declares XML entities"),
        (KML, "no place in it has a time"),
        (json.dumps(FEATURES), "lines have no times"),
        ("\n".join(DETECTION.format(i) for i in range(9)), "MOTChallenge .* without identity"),
        ("AXXXTST\nHFDTE150124\n", "IGC file without any fix"),
        (MESSAGE, "without any position"),
        ("MSG,3,,,4B1908,,,,,,,2525,,,33.96693,-118.25598,,,0,0,0,0", "have no date and time"),
        ('{"now": 1.0, "aircraft": []}', "without any aircraft"),
    ],
)
def test_files_without_tracks_are_refused_by_name(tmp_path, content, message):
    (tmp_path / "given.dat").write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        jink.track(tmp_path / "given.dat")
    assert "given.dat" in str(caught.value)


TABLE = CAR.lines("{t},{lat:.6f},{lon:.6f}")


@pytest.mark.parametrize(
    ("lines", "note"),
    [
        (["sep=,", "time,latitude,longitude", *TABLE], None),
        (["sep=;", "time;latitude;longitude", *[line.replace(",", ";") for line in TABLE]], None),
        (["# by a logger", "# UTC, WGS84", "time,latitude,longitude", *TABLE], "2 lines before the header"),
        (["Device: X", "Serial: 7", "", "time,latitude,longitude", *TABLE], "3 lines before the header"),
        (["# time,latitude,longitude", *TABLE], None),
        (["time,latitude,longitude", *[line + "," for line in TABLE]], None),
        (["time,latitude,longitude,", *TABLE], None),
        (["time,latitude,longitude,Speed,Speed", *[line + ",10,19" for line in TABLE]], "same column twice: Speed"),
        (["time,latitude,longitude", *TABLE[:9], "time,latitude,longitude", *TABLE[9:]], "1 repeated headers"),
        (["time,latitude,longitude", *TABLE[:9], "# a remark", *TABLE[9:]], "1 comments"),
        (["time latitude longitude", *[line.replace(",", "  ") for line in TABLE]], None),
        (["\ufefftime,latitude,longitude", *TABLE], None),
    ],
)
def test_what_stands_around_a_csv_table_is_no_row(tmp_path, lines, note):
    (tmp_path / "x.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    tracks, rejected, summary = jink.track(tmp_path / "x.csv", kind="vehicle", details=True)
    CAR.agrees(tracks)
    assert not rejected.height and tracks["row"].to_list() == list(range(40))
    assert note is None or any(note in said for said in summary["notes"])


def test_lines_that_end_as_on_old_computers(tmp_path):
    (tmp_path / "x.csv").write_bytes("\r".join(["time,latitude,longitude", *TABLE]).encode())
    CAR.agrees(jink.track(Path(tmp_path / "x.csv"), kind="vehicle", details=True)[0])


def test_all_files_of_an_archive_are_read(tmp_path):
    for name, content in (("doc.kml", kml_track()), ("x.csv", "\n".join(["time,latitude,longitude", *TABLE]))):
        with zipfile.ZipFile(tmp_path / "given.zip", "w") as archive:
            archive.writestr(name, content)
        CAR.agrees(jink.track(tmp_path / "given.zip", kind="vehicle", details=True)[0])
    with zipfile.ZipFile(tmp_path / "given.zip", "a") as archive:
        archive.writestr("y.csv", "\n".join(["time,latitude,longitude", *TABLE]))
    tracks = jink.track(tmp_path / "given.zip", kind="vehicle", details=True)[0]
    assert tracks["target"].unique().sort().to_list() == ["x", "y"]
    for _, rows in tracks.group_by("target"):
        CAR.agrees(rows)
    with zipfile.ZipFile(tmp_path / "given.zip", "a") as archive:
        archive.writestr("z.csv", "time,latitude,longitude")
    with pytest.raises(InputError, match=r"given.zip/z.csv has columns but no rows"):
        jink.track(tmp_path / "given.zip")
    (tmp_path / "sheet.xlsx").write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(InputError, match="Excel sheet"):
        jink.track(tmp_path / "sheet.xlsx")


def stored(content: bytes) -> bytes:
    """A zstd file of one raw block (RFC 8878)."""
    size = len(content).to_bytes(4, "little")
    return b"\x28\xb5\x2f\xfd\xa0" + size + (len(content) << 3 | 1).to_bytes(3, "little") + content


def packed(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def test_data_that_cannot_be_read_in_an_archive_are_not_left_out(tmp_path):
    lines = "\n".join(["time,latitude,longitude", *TABLE]).encode()
    path = tmp_path / "given.zip"
    path.write_bytes(packed({"a.csv": lines, "b.csv.zst": stored(lines), "map.png": b"\x89PNG"}))
    tracks, _, summary = jink.track(path, kind="vehicle", details=True)
    assert tracks["target"].unique().sort().to_list() == ["a", "b"]
    assert any("map.png is an image" in note for note in summary["notes"])
    for name, content, said in (
        ("b.zip", packed({"b.csv": lines}), "b.zip is an archive inside an archive"),
        ("b.h5", b"\x89HDF\r\n\x1a\n", "b.h5 is an HDF5 file"),
        ("b.csv.bz2", b"BZh91AY", "b.csv.bz2 is compressed with bzip2"),
    ):
        path.write_bytes(packed({"a.csv": lines, name: content}))
        with pytest.raises(InputError, match=said):
            jink.track(path, kind="vehicle")
    path.write_bytes(packed({"b.zip": packed({"b.csv": lines})}))
    with pytest.raises(InputError, match="an archive inside an archive"):
        jink.track(path, kind="vehicle")


def test_zstd_without_text_is_no_damage(tmp_path):
    (tmp_path / "x.ast.zst").write_bytes(stored(b"\x15\x00\xcb\x11\n\xff\xfe"))
    with pytest.raises(InputError, match="holds no text in UTF-8; unpack it"):
        jink.track(tmp_path / "x.ast.zst")


def test_a_folder_stands_for_the_files_in_it(tmp_path):
    lines = "\n".join(["time,latitude,longitude", *TABLE])
    (tmp_path / "day 1").mkdir()
    (tmp_path / "day 1" / "a.csv").write_text(lines)
    (tmp_path / "b.csv").write_text(lines)
    (tmp_path / "map.png").write_bytes(b"\x89PNG")
    tracks, _, summary = jink.track(tmp_path, kind="vehicle", details=True)
    assert tracks["target"].unique().sort().to_list() == ["a", "b"]
    assert any("map.png is an image" in note for note in summary["notes"])
    (tmp_path / "only").mkdir()
    (tmp_path / "only" / "map.png").write_bytes(b"\x89PNG")
    with pytest.raises(InputError, match="no file of the folder or archive can be read"):
        jink.track(tmp_path / "only")


def test_a_pipe_is_read_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    content = "\n".join(["time,latitude,longitude", *TABLE])
    writer = threading.Thread(target=lambda: (tmp_path / "pipe").write_text(content))
    writer.start()
    CAR.agrees(jink.track(tmp_path / "pipe", kind="vehicle", details=True)[0])
    writer.join()


def test_every_damaged_line_of_a_receiver_is_counted(tmp_path):
    lines = nmea().splitlines()
    damaged = lines[10].removeprefix("$")  # its first letter is lost
    (tmp_path / "x.nmea").write_text(
        "\n".join(["# a logger", *lines[:10], damaged, "", "!AIVDM,1,1,,A,x,0*00", *lines[11:]])
    )
    _, rejected, summary = jink.track(tmp_path / "x.nmea", kind="vehicle", details=True)
    assert rejected.select("row", "reason").rows() == [(11, "not a sentence of NMEA 0183")]
    assert any("1 sentences of AIS are not read" in note for note in summary["notes"])


def test_ais_sentences_are_read_by_their_receivers_time(tmp_path):
    pytest.importorskip("pyais")
    from pyais import encode_dict

    lines = []
    for t, (lat, lon) in zip(CAR.times, CAR.places, strict=True):
        message = {"type": 1, "mmsi": 219000000, "lat": lat, "lon": lon, "speed": 38.9, "second": t.second}
        lines += [f"\\s:x,c:{t.timestamp():.0f}*00\\{sentence}" for sentence in encode_dict(message, radio_channel="A")]
    (tmp_path / "x.nmea").write_text("\n".join(lines))
    tracks, rejected, _ = jink.track(tmp_path / "x.nmea", kind="vehicle", details=True)
    CAR.agrees(tracks)
    assert not rejected.height and tracks["target"][0] == "219000000"
    (tmp_path / "y.nmea").write_text("\n".join(line.rpartition("\\")[2] for line in lines))
    with pytest.raises(InputError, match="without a time"):
        jink.track(tmp_path / "y.nmea")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"%PDF-1.4 ...", "PDF"),
        (b"\x89PNG....", "image"),
        (b"\x1a3abcdef", "Beast"),
        (b"\x0e\x10....\x00\x00.FIT", "FIT"),
        (b"<html><body>no</body></html>", "XML or HTML of an unknown kind"),
    ],
)
def test_content_that_is_no_track_is_named(tmp_path, content, message):
    (tmp_path / "given.dat").write_bytes(content)
    with pytest.raises(InputError, match=message):
        jink.track(tmp_path / "given.dat")


def test_velocities_of_sbs_join_the_positions_of_their_aircraft(tmp_path):
    head = "1,1,{hex},1,{date:%Y/%m/%d},{date:%H:%M:%S}.{ms},{date:%Y/%m/%d},{date:%H:%M:%S}.900"
    place = PLANE.lines(
        "MSG,3," + head.replace("{hex}", "ABC123").replace("{ms}", "800") + ",,36000,,,{lat},{lon},,,0,0,0,0"
    )
    speed = PLANE.lines(
        "MSG,4," + head.replace("{hex}", "ABC123").replace("{ms}", "300") + ",,,447.1,100,,,64,,0,0,0,0"
    )
    other = PLANE.lines("MSG,4," + head.replace("{hex}", "FFFFFF").replace("{ms}", "500") + ",,,99,9,,,0,,0,0,0,0")
    (tmp_path / "x.sbs").write_text(
        "\n".join(line for lines in zip(speed, other, place, strict=True) for line in lines)
    )
    loaded = load_files([tmp_path / "x.sbs"], Reading()).measurements
    assert loaded.rows["speed"].to_numpy() == pytest.approx(230.0, rel=1e-3)
    assert loaded.rows["vertical_rate"].to_numpy() == pytest.approx(64 * 0.3048 / 60)
    # a velocity of long ago is not that of now
    (tmp_path / "x.sbs").write_text("\n".join([speed[0], *place]))
    late = load_files([tmp_path / "x.sbs"], Reading()).measurements.rows["speed"].to_numpy()
    assert np.isfinite(late).sum() == 1


@pytest.mark.parametrize("kind", ["gpx", "kml", "geojson", "csv", "jsonl", "arrow", "parquet"])
def test_what_is_written_is_read_back(tmp_path, kind):
    """Tracks in the plane stay so, and their places, times and names are those of the table."""
    (tmp_path / "ride.csv").write_text("\n".join(["time,latitude,longitude", *TABLE]))
    tracks = jink.track(tmp_path / "ride.csv", kind="vehicle")
    write_tracks(tracks, tmp_path / f"tracks.{kind}", kind)
    loaded = load_files([tmp_path / f"tracks.{kind}"], Reading()).measurements
    assert loaded.position == "geographic" and "altitude" not in loaded.rows.columns
    np.testing.assert_allclose(loaded.rows["latitude"], tracks["latitude"], rtol=0, atol=6e-8)
    np.testing.assert_allclose(loaded.rows["longitude"], tracks["longitude"], rtol=0, atol=6e-8)
    np.testing.assert_allclose(loaded.rows["time"], tracks["time"].dt.epoch("us") / 1e6, rtol=0, atol=1e-6)
    assert loaded.rows["target"].unique().to_list() == ["ride"]
    if kind not in ("gpx", "kml"):
        assert any("those of tracks that jink wrote: positions are estimates" in note for note in loaded.notes)


@pytest.mark.parametrize(("write", "journey", "_"), [FILES[name] for name in FILES if name != "SBS-1"])
def test_a_time_zone_is_not_for_formats_that_tell_utc(tmp_path, write, journey, _):
    path = tmp_path / "given.dat"
    path.write_text(write(), encoding="utf-8")
    journey.agrees(jink.track(path, kind="vehicle" if journey is CAR else "aircraft", time_zone="Asia/Tokyo"))


@pytest.mark.parametrize("write", [kml_track, kml_points])
def test_heights_of_0_in_kml_are_none(tmp_path, write):
    text = write()
    (tmp_path / "high.kml").write_text(text)
    (tmp_path / "flat.kml").write_text(text.replace(" 100</gx", " 0</gx").replace(",100</c", ",0</c"))
    assert "altitude" in jink.track(tmp_path / "high.kml", kind="vehicle").columns
    tracks = jink.track(tmp_path / "flat.kml", kind="vehicle")
    CAR.agrees(tracks)
    assert "altitude" not in tracks.columns
