"""The same journey as files of every format that people have."""

from __future__ import annotations

import gzip
import io
import json
import zipfile
from functools import reduce

import asterix_written
import polars as pl
from straight import Journey

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


def table() -> pl.DataFrame:
    """Target, time and place."""
    rows = zip(CAR.times, CAR.places, strict=True)
    return pl.DataFrame([{"target": "a", "time": t, "latitude": p[0], "longitude": p[1]} for t, p in rows])


def _bytes_of(write) -> bytes:
    handle = io.BytesIO()
    write(handle)
    return handle.getvalue()


def _zipped(**inside: bytes) -> bytes:
    def write(handle):
        with zipfile.ZipFile(handle, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in inside.items():
                archive.writestr(name, content)

    return _bytes_of(write)


def ais() -> str:
    """Position reports of class A, each with its receiver's time before it."""
    lines = []
    for t, (lat, lon) in zip(CAR.times, CAR.places, strict=True):
        fields = [(1, 6), (0, 2), (219000001, 30), (0, 4), (128, 8), (389, 10), (1, 1)]
        fields += [(round(lon * 600_000), 28), (round(lat * 600_000), 27), (600, 12), (511, 9), (t.second, 6), (0, 25)]
        bits = "".join(f"{value & (1 << size) - 1:0{size}b}" for value, size in fields)
        sixes = [int(bits[k : k + 6].ljust(6, "0"), 2) for k in range(0, len(bits), 6)]
        body = f"AIVDM,1,1,,A,{''.join(chr(v + 48 if v < 40 else v + 56) for v in sixes)},0"
        total = reduce(lambda so_far, letter: so_far ^ ord(letter), body, 0)
        lines.append(f"\\c:{t.timestamp():.0f}*00\\!{body}*{total:02X}")
    return "\n".join(lines)


def mot() -> str:
    """MOTChallenge: boxes of one object in frames."""
    return "\n".join(f"{k + 1},1,{100 + 4.0 * k:.1f},{50 + k:.1f},40,80,1,-1,-1,-1" for k in range(40))


def everything() -> dict[str, bytes]:
    """Content of every format, packed in every way, and tables as people write them."""
    text = table().write_csv().encode()
    blocks = {"CAT021": (21, asterix_written.reports), "CAT048": (48, asterix_written.plots)}
    blocks["CAT062"] = (62, asterix_written.tracks_of_a_tracker)
    return {
        **{name: write().encode() for name, (write, _, _) in FILES.items()},
        **{
            f"ASTERIX {name}": b"".join(asterix_written.block(category, one) for one in make(PLANE))
            for name, (category, make) in blocks.items()
        },
        "AIS": ais().encode(),
        "MOT": mot().encode(),
        "CSV": text,
        "CSV with semicolons": text.replace(b",", b";"),
        "CSV in UTF-16": text.decode().encode("utf-16"),
        "JSON Lines": _bytes_of(table().with_columns(pl.col("time").dt.to_string()).write_ndjson),
        "Parquet": _bytes_of(table().write_parquet),
        "Arrow": _bytes_of(table().write_ipc),
        "Arrow stream": _bytes_of(table().write_ipc_stream),
        "gzip": gzip.compress(text, mtime=0),
        "zstd": _bytes_of(lambda handle: pl.DataFrame({"a": [1]}).write_csv(handle)) and _zstd(text),
        "zip": _zipped(inner=text),
        "zip of two": _zipped(one=text, two=text.replace(b"\na,", b"\nb,")),
        "zip of gzip": _zipped(inner=gzip.compress(text, mtime=0)),
    }


def _zstd(content: bytes) -> bytes:
    """One frame of a raw block."""
    size = len(content)
    head = b"\x28\xb5\x2f\xfd" + bytes([0b1010_0000]) + size.to_bytes(4, "little")
    return head + ((size << 3) | 1).to_bytes(3, "little") + content
