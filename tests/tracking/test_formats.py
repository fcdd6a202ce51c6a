"""The same journey in every format that people have: read, tracked, and every row accounted for."""

from __future__ import annotations

import json
import os
import threading
import zipfile
from functools import reduce
from pathlib import Path

import numpy as np
import pytest
from straight import Journey

import jink
from jink.io.errors import InputError
from jink.io.files import open_table
from jink.io.formats.registry import FORMATS
from jink.io.loading import Reading, load_files

CAR = Journey()
PLANE = Journey(speed=230.0, course=100.0, latitude=49.0)


def with_checksum(sentence: str) -> str:
    return f"${sentence}*{reduce(lambda total, letter: total ^ ord(letter), sentence, 0):02X}"


def minutes(value: float, width: int, digits: int) -> str:
    return f"{int(value):0{width}d}{value % 1 * 60:0{3 + digits}.{digits}f}"


def gpx() -> str:
    points = CAR.lines('<trkpt lat="{lat:.6f}" lon="{lon:.6f}"><ele>100.0</ele><time>{t}</time></trkpt>')
    head = '<?xml version="1.0"?>\n<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><name>ride</name><trkseg>'
    return "\n".join([head, *points, "</trkseg></trk></gpx>"])


def kml_track() -> str:
    whens, places = CAR.lines("<when>{t}</when>"), CAR.lines("<gx:coord>{lon:.6f} {lat:.6f} 100</gx:coord>")
    head = (
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document><Placemark>'
    )
    return "\n".join([head, "<name>ride</name><gx:Track>", *whens, *places, "</gx:Track></Placemark></Document></kml>"])


def kml_points() -> str:
    text = "<Placemark><name>{n}</name><TimeStamp><when>{t}</when></TimeStamp>"
    text += "<Point><coordinates>{lon:.6f},{lat:.6f},100</coordinates></Point></Placemark>"
    return '<?xml version="1.0"?><kml><Document>' + "".join(CAR.lines(text)) + "</Document></kml>"


def geojson_points() -> str:
    features = [
        {
            "type": "Feature",
            "properties": {"track_id": 1, "t": f"{t:%Y-%m-%dT%H:%M:%SZ}"},
            "geometry": {"type": "Point", "coordinates": [round(p[1], 6), round(p[0], 6)]},
        }
        for t, p in zip(CAR.times, CAR.places, strict=True)
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


def geojson_line() -> str:
    times = CAR.lines("{t}")
    places = [[round(p[1], 6), round(p[0], 6), 100.0] for p in CAR.places]
    geometry = {"type": "LineString", "coordinates": places}
    return json.dumps({"type": "Feature", "properties": {"name": "ride", "coordTimes": times}, "geometry": geometry})


def nmea() -> str:
    lines = []
    for t, (lat, lon) in zip(CAR.times, CAR.places, strict=True):
        place = f"{minutes(lat, 2, 5)},N,{minutes(lon, 3, 5)},E"
        lines.append(with_checksum(f"GPGGA,{t:%H%M%S}.00,{place},1,08,0.9,100.0,M,47.0,M,,"))
        lines.append(with_checksum("GPGSV,1,1,00"))
        lines.append(with_checksum(f"GPRMC,{t:%H%M%S}.00,A,{place},38.9,060.0,{t:%d%m%y},,,A"))
    return "\r\n".join(lines)


def igc() -> str:
    lines = ["AXXXTST", "HFDTE150124", "HFGIDGLIDERID:D-1234"]
    for t, (lat, lon) in zip(CAR.times, CAR.places, strict=True):
        north, east = (f"{int(v):0{w}d}{round(v % 1 * 60_000):05d}" for v, w in ((lat, 2), (lon, 3)))
        lines.append(f"B{t:%H%M%S}{north}N{east}EA0010000100")
    return "\r\n".join([*lines, "GABCDEF"])


def plt() -> str:
    head = ["Geolife trajectory", "WGS 84", "Altitude is in Feet", "Reserved 3", "0,2,255,My Track,0,0,2,8421376", "0"]
    return "\n".join(head + CAR.lines("{lat:.6f},{lon:.6f},0,328,45306.6,{date:%Y-%m-%d},{date:%H:%M:%S}"))


def sbs() -> str:
    head = "1,1,ABC123,1,{date:%Y/%m/%d},{date:%H:%M:%S}.000,{date:%Y/%m/%d},{date:%H:%M:%S}.500"
    text = "MSG,3," + head + ",,36000,,,{lat:.5f},{lon:.5f},,,0,0,0,0"
    speed = "MSG,4," + head + ",,,447,100,,,0,,0,0,0,0"
    return "\r\n".join(line for pair in zip(PLANE.lines(text), PLANE.lines(speed), strict=True) for line in pair)


def readsb(lines: bool) -> str:
    shots = [
        {
            "now": t.timestamp() + i % 3,
            "messages": i,
            "aircraft": [
                {"hex": "abc123", "lat": p[0], "lon": p[1], "alt_baro": 36000, "seen_pos": i % 3, "gs": 447.0}
            ],
        }
        for i, (t, p) in enumerate(zip(PLANE.times, PLANE.places, strict=True))
    ]
    return "\n".join(map(json.dumps, shots)) if lines else json.dumps(shots, indent=1)


def trace() -> str:
    points = [
        [s, p[0], p[1], 36000, 447.0, 100.0, 0, 0, None] for s, p in zip(PLANE.seconds, PLANE.places, strict=True)
    ]
    return json.dumps({"icao": "abc123", "timestamp": PLANE.start.timestamp(), "trace": points})


def opensky() -> str:
    shots = []
    for t, p in zip(PLANE.times, PLANE.places, strict=True):
        second = int(t.timestamp())
        state = [
            "abc123",
            "TST",
            "X",
            second,
            second + 1,
            p[1],
            p[0],
            10972.8,
            False,
            230.0,
            100.0,
            None,
            None,
            11000.0,
        ]
        shots.append({"time": second + 2, "states": [[*state, "1000", False, 0]]})
    return "\n".join(map(json.dumps, shots))


def fr24() -> str:
    text = '{e:.0f},{t},TST1,"{lat:.6f},{lon:.6f}",36000,447,100'
    return "\n".join(["Timestamp,UTC,Callsign,Position,Altitude,Speed,Direction", *PLANE.lines(text)])


def tcx() -> str:
    point = "<Trackpoint><Time>{t}</Time><Position><LatitudeDegrees>{lat:.6f}</LatitudeDegrees>"
    point += (
        "<LongitudeDegrees>{lon:.6f}</LongitudeDegrees></Position><AltitudeMeters>100.0</AltitudeMeters></Trackpoint>"
    )
    return "\n".join(["<TrainingCenterDatabase><Track>", *CAR.lines(point), "</Track></TrainingCenterDatabase>"])


def nested() -> str:
    shots = [
        {
            "MessageType": "PositionReport",
            "MetaData": {
                "MMSI": 219,
                "latitude": p[0],
                "longitude": p[1],
                "time_utc": f"{t:%Y-%m-%d %H:%M:%S}.0 +0000 UTC",
            },
            "Message": {"PositionReport": {"Sog": 38.9, "Timestamp": t.second, "Latitude": p[0], "Longitude": p[1]}},
        }
        for t, p in zip(CAR.times, CAR.places, strict=True)
    ]
    return "\n".join(map(json.dumps, shots))


def locations() -> str:
    rows = [
        {
            "latitudeE7": round(p[0] * 1e7),
            "longitudeE7": round(p[1] * 1e7),
            "timestampMs": str(int(t.timestamp() * 1000)),
        }
        for t, p in zip(CAR.times, CAR.places, strict=True)
    ]
    return json.dumps({"locations": rows})


def by_columns(listed: bool) -> str:
    rows = {"timestamp": [int(t.timestamp() * 1000) for t in CAR.times], "latitude": [p[0] for p in CAR.places]}
    rows["longitude"] = [p[1] for p in CAR.places]
    return json.dumps(rows if listed else {name: {str(i): v for i, v in enumerate(c)} for name, c in rows.items()})


FILES = {
    "JSON by columns": (lambda: by_columns(False), CAR, None),
    "JSON of lists": (lambda: by_columns(True), CAR, None),
    "TCX": (tcx, CAR, 100.0),
    "nested JSON": (nested, CAR, None),
    "one list in an object": (locations, CAR, None),
    "GPX": (gpx, CAR, 100.0),
    "KML, a track": (kml_track, CAR, 100.0),
    "KML, points": (kml_points, CAR, 100.0),
    "GeoJSON, points": (geojson_points, CAR, None),
    "GeoJSON, a line": (geojson_line, CAR, 100.0),
    "NMEA": (nmea, CAR, 100.0),
    "IGC": (igc, CAR, 100.0),
    "PLT": (plt, CAR, 328 * 0.3048),
    "SBS-1": (sbs, PLANE, 36000 * 0.3048),
    "aircraft.json, one per line": (lambda: readsb(True), PLANE, 36000 * 0.3048),
    "aircraft.json, an array": (lambda: readsb(False), PLANE, 36000 * 0.3048),
    "trace": (trace, PLANE, 36000 * 0.3048),
    "OpenSky": (opensky, PLANE, 11000.0),
    "Flightradar24": (fr24, PLANE, 36000 * 0.3048),
}


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


@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_in_part_or_refused_in_words(tmp_path, name):
    """Cut or with bytes changed: every row is in tracks or rejected, or the file is refused."""
    content = FILES[name][0]().encode()
    rng = np.random.default_rng(list(FILES).index(name))
    for number in range(110):
        damaged = bytearray(content)
        for _ in range(rng.integers(1, 12)):
            place = int(rng.integers(len(damaged)))
            damaged[place : place + int(rng.integers(0, 4))] = (
                rng.integers(32, 127, rng.integers(0, 4)).astype("u1").tobytes()
            )
        if number % 4 == 0:
            del damaged[int(rng.integers(len(damaged))) :]
        path = tmp_path / f"{number}.dat"
        path.write_bytes(bytes(damaged))
        try:
            table = open_table(path)
            count = sum(frame.height for frame in table.read(table.names))
            loaded = load_files([path], Reading())
            measured = loaded.measurements
            assert loaded.count == count == measured.rows.height + sum(frame.height for frame in measured.rejected)
            if number % 5 == 0:
                tracks, rejected, _ = jink.track(path, details=True)
                assert tracks.height + rejected.height == count
        except InputError as error:
            assert len(str(error)) > 20


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
    with pytest.raises(InputError, match="no file of the folder can be read"):
        jink.track(tmp_path / "only")


def test_a_pipe_is_read_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    content = "\n".join(["time,latitude,longitude", *TABLE])
    writer = threading.Thread(target=lambda: (tmp_path / "pipe").write_text(content))
    writer.start()
    CAR.agrees(jink.track(tmp_path / "pipe", kind="vehicle", details=True)[0])
    writer.join()


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
