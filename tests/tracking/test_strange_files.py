"""The same journey in strange encodings, packings, clocks and tables: read rightly, or refused with the fault named."""

from __future__ import annotations

import gzip
import io
import json
import math
import tarfile
import zipfile
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import polars as pl
import pytest
from straight import Journey

import jink
from jink.io.errors import InputError

CAR = Journey()
PLANE = Journey(speed=230.0, course=100.0, latitude=49.0)
SHIP = Journey(speed=6.0, course=45.0, latitude=55.5, longitude=11.0, step=10.0)
SOUTH = Journey(latitude=-33.9, longitude=-70.4)
HEADER = "id,time,lat,lon"
ROW = "1,{t},{lat:.7f},{lon:.7f}"


def table(rows: list[str], header: str = HEADER, end: str = "\n") -> bytes:
    return end.join([header, *rows, ""]).encode()


def timed(form: Callable[[datetime], object], journey: Journey = CAR) -> bytes:
    """The journey with times as `form` writes them."""
    pairs = zip(journey.times, journey.places, strict=True)
    return table([f"1;{form(time)};{lat:.7f};{lon:.7f}" for time, (lat, lon) in pairs], HEADER.replace(",", ";"))


def plain(header: str, scale: float = 1.0, begin: float = 0.0, units: str = "") -> bytes:
    """x and y of the journey's way."""
    course = math.radians(60.0)
    rows = []
    for second in CAR.seconds.tolist():
        x, y = 20.0 * second * math.sin(course) / scale, 20.0 * second * math.cos(course) / scale
        rows.append(f"1,{second + begin},{x:.6f},{y:.6f}")
    return table([units, *rows] if units else rows, header)


def objects(make: Callable[[datetime, float, float], dict]) -> list[str]:
    return [json.dumps(make(time, *place)) for time, place in zip(CAR.times, CAR.places, strict=True)]


def packed(files: dict[str, bytes]) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        with zipfile.ZipFile(folder / "given.zip", "w") as archive:
            for name, content in files.items():
                archive.writestr(name, content)
        return folder / "given.zip"

    return write


def lettered(texts: list[str]) -> bytes:
    rows = [f"{texts[i % len(texts)]},{row.split(',', 1)[1]}" for i, row in enumerate(PLANE.lines(ROW))]
    return table(rows, "icao24,time,lat,lon")


def tar() -> bytes:
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        info = tarfile.TarInfo("x.csv")
        info.size = 5
        archive.addfile(info, io.BytesIO(b"a,b\n\n"))
    return content.getvalue()


ZONE = ZoneInfo("Europe/Berlin")
PLAIN = table(CAR.lines(ROW))
CP1252 = table(CAR.lines("ä;{t};{lat:.7f};{lon:.7f}"), "Gerät;Zeit;Breite (°);Länge (°)").decode().encode("cp1252")
MARKDOWN = table(["|---|---|---|---|", *CAR.lines("| 1 | {t} | {lat:.7f} | {lon:.7f} |")], "| id | time | lat | lon |")
UNITS = table(["-,UTC,deg,deg", *CAR.lines(ROW)])
NOTHING = ["NULL", "N/A", "-", "none", "nan", "?", "--", "nil"]
AGREES: dict[str, bytes | Callable[[Path], Path]] = {
    "Windows-1252": CP1252,
    "UTF-16 with a mark": PLAIN.decode().encode("utf-16"),
    "UTF-16 without a mark": PLAIN.decode().encode("utf-16-le"),
    "UTF-16, most significant byte first": PLAIN.decode().encode("utf-16-be"),
    "UTF-32": PLAIN.decode().encode("utf-32"),
    "zeros of a recorder that lost its power": PLAIN + bytes(512),
    "ends of lines of old Macs": table(CAR.lines(ROW), end="\r"),
    "mixed ends of lines": PLAIN.replace(b"\n", b"\r\n", 9),
    "an empty line after each row": PLAIN.replace(b"\n", b"\n\n").replace(b"lon\n\n", b"lon\n"),
    "a remark at the end": PLAIN + b"# end of file\n",
    "packed twice": gzip.compress(gzip.compress(PLAIN)),
    "two packed pieces": gzip.compress(PLAIN[:900]) + gzip.compress(PLAIN[900:]),
    "an archive with a packed table and a note": packed(
        {"a/b/x.csv.gz": gzip.compress(PLAIN), "__MACOSX/a/._x": b"\x00\x05", "readme.txt": b"Of a ride\nin May.\n"}
    ),
    "columns of fixed width": table(CAR.lines("1    {t}  {lat:10.7f}  {lon:10.7f}"), "id   time   lat   lon"),
    "decimal commas in quotes": PLAIN.replace(b",", b'";"')
    .replace(b".", b",")
    .replace(b"\n1", b'"\n"1')
    .join([b'"', b'"']),
    "signs and blanks": table(CAR.lines("1,{t}, +{lat:.7f} , +{lon:.7f} ")),
    "spellings of nothing": table(
        [f"{row},{NOTHING[i % 8]}" for i, row in enumerate(CAR.lines(ROW))],
        HEADER + ",alt",
    ),
    "another position beside": table(
        CAR.lines("1,{t},51.0,7.0,{lat:.7f},{lon:.7f}"), "id,time,home_lat,home_lon,lat,lon"
    ),
    "newest first": table(CAR.lines(ROW)[::-1]),
    "a line of units": UNITS,
    "a line of units: kilometres": plain("id,time,x,y", 1000.0, units="-,s,km,km"),
    "feet": plain("id,time,x_ft,y_ft", 0.3048),
    "yards": plain("id,time,x [yd],y [yd]", 0.9144),
    "times before a launch": plain("id,t,x,y", begin=-100.0),
    "a negative zero": plain("id,time,x,y").replace(b"1,0.0,", b"1,-0.0,"),
    "exponents": timed(lambda t: f"{t.timestamp():.9E}"),
    "mail's dates": timed(lambda t: t.strftime("%a, %d %b %Y %H:%M:%S +0000")),
    "C's dates": timed(lambda t: t.strftime("%a %b %d %H:%M:%S %Y")),
    "German months": timed(lambda t: t.strftime("%d. Januar %Y %H:%M:%S")),
    "French months": timed(lambda t: (t + timedelta(0)).strftime("%d janvier %Y %H:%M:%S")),
    "Central European Time": timed(lambda t: (t + timedelta(hours=1)).strftime("%Y-%m-%d %H:%M:%S CET")),
    "Eastern Standard Time": timed(lambda t: (t - timedelta(hours=5)).strftime("%m/%d/%Y %H:%M:%S EST")),
    "half hours of offset": timed(lambda t: (t + timedelta(hours=5.5)).strftime("%Y-%m-%dT%H:%M:%S+05:30")),
    "minutes since 1970": timed(lambda t: f"{t.timestamp() / 60:.6f}").replace(b"time", b"time (min)"),
    "ticks of .NET": timed(lambda t: int(t.timestamp() * 1e7) + 621_355_968_000_000_000),
    "ticks of Windows": timed(lambda t: int(t.timestamp() * 1e7) + 116_444_736_000_000_000),
    "microseconds of WebKit": timed(lambda t: int(t.timestamp() * 1e6) + 11_644_473_600_000_000),
    "lines out of an array": "\n".join(
        line + "," for line in objects(lambda t, lat, lon: {"time": t.isoformat(), "lat": lat, "lon": lon})
    ).encode(),
    "numbers in quotes": "\n".join(
        objects(lambda t, lat, lon: {"time": t.isoformat(), "lat": f"{lat:.7f}", "lon": f"{lon:.7f}"})
    ).encode(),
    "nothing by JavaScript's name": "\n".join(
        objects(lambda t, lat, lon: {"time": t.isoformat(), "lat": lat, "lon": lon, "alt": float("nan")})
    ).encode(),
    "columns of JSON": json.dumps(
        {
            "time": [t.isoformat() for t in CAR.times],
            "lat": [p[0] for p in CAR.places],
            "lon": [p[1] for p in CAR.places],
        }
    ).encode(),
    "rows of JSON by their index": json.dumps(
        {
            str(i): {"time": t.isoformat(), "lat": p[0], "lon": p[1]}
            for i, (t, p) in enumerate(zip(CAR.times, CAR.places, strict=True))
        }
    ).encode(),
    "MongoDB": "\n".join(
        objects(
            lambda t, lat, lon: {
                "vehicle_id": "a",
                "ts": {"$date": {"$numberLong": str(int(t.timestamp() * 1000))}},
                "loc": {"type": "Point", "coordinates": [lon, lat]},
            }
        )
    ).encode(),
}


@pytest.mark.parametrize("name", AGREES)
def test_the_journey_is_read_rightly(tmp_path, name):
    given = AGREES[name]
    path = given(tmp_path) if callable(given) else tmp_path / "given.dat"
    if isinstance(given, bytes):
        path.write_bytes(given)
    tracks, rejected, summary = jink.track(path, kind="vehicle", details=True)
    CAR.agrees(tracks, start=isinstance(tracks.schema["time"], pl.Datetime))
    assert not rejected.height, summary["rejected"]


def written(path: Path, content: bytes, kind: str = "vehicle", **options):
    path.write_bytes(content)
    return jink.track(path, kind=kind, details=True, **options)


@pytest.mark.parametrize(
    ("journey", "kind"),
    [
        (Journey(longitude=179.99, course=80.0, speed=230.0), "aircraft"),
        (Journey(latitude=-0.01, longitude=-0.01, course=45.0), "vehicle"),
        (SOUTH, "vehicle"),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 360.0])
def test_places_where_longitudes_jump(tmp_path, journey, kind, turn):
    pairs = zip(journey.times, journey.places, strict=True)
    rows = [f"1,{t:%Y-%m-%dT%H:%M:%SZ},{lat:.7f},{lon % turn if turn else lon:.7f}" for t, (lat, lon) in pairs]
    tracks, rejected, _ = written(tmp_path / "x.csv", table(rows), kind)
    journey.agrees(tracks)
    assert not rejected.height


@pytest.mark.parametrize(("latitude", "course"), [(89.9, 0.0), (-89.99, 180.0)])
def test_over_a_pole_the_speed_stays(tmp_path, latitude, course):
    flight = Journey(latitude=latitude, longitude=20.0, course=course, speed=230.0)
    tracks, rejected, _ = written(tmp_path / "x.csv", table(flight.lines(ROW)), "aircraft")
    assert tracks.height == 40 and not rejected.height
    assert tracks["speed"].drop_nulls().to_numpy() == pytest.approx(230.0, abs=0.1)


@pytest.mark.parametrize("start", [datetime(2024, 10, 27, 0, 30, tzinfo=UTC), datetime(2024, 3, 31, 0, 30, tzinfo=UTC)])
def test_summer_time_begins_and_ends(tmp_path, start):
    ride = Journey(start=start, step=120.0)
    content = timed(lambda t: t.astimezone(ZONE).strftime("%Y-%m-%d %H:%M:%S"), ride)
    tracks, rejected, _ = written(tmp_path / "x.csv", content, time_zone="Europe/Berlin")
    ride.agrees(tracks)
    assert not rejected.height
    if start.month == 10:
        # without the zone the start is not known, but times go on
        tracks, _, summary = written(tmp_path / "y.csv", content)
        ride.agrees(tracks, start=False)
        assert any("summer time?" in note for note in summary["notes"])


def test_a_leap_second_is_a_second(tmp_path):
    ride = Journey(start=datetime(2016, 12, 31, 23, 59, tzinfo=UTC))

    def form(time: datetime) -> str:
        since = (time - ride.start).total_seconds()
        if since == 60.0:
            return "2016-12-31T23:59:60Z"
        return f"{time - timedelta(seconds=1) if since > 60.0 else time:%Y-%m-%dT%H:%M:%SZ}"

    tracks, rejected, _ = written(tmp_path / "x.csv", timed(form, ride))
    ride.agrees(tracks)
    assert not rejected.height


def test_a_clock_of_twelve_hours_goes_on_after_one(tmp_path):
    ride = Journey(start=datetime(2024, 1, 15, 12, 58, tzinfo=UTC))
    tracks, _, summary = written(tmp_path / "x.csv", timed(lambda t: t.strftime("%Y-%m-%d %I:%M:%S"), ride))
    ride.agrees(tracks)
    assert any("a clock of 12 hours" in note for note in summary["notes"])


@pytest.mark.parametrize(
    ("name", "origin", "words"),
    [("gps_time", 315_964_800.0 - 18.0, "of GPS"), ("timestamp", 978_307_200.0, "of Apple")],
)
def test_seconds_since_another_year_are_spoken_of(tmp_path, name, origin, words):
    content = timed(lambda t: f"{t.timestamp() - origin:.1f}").replace(b"time", name.encode(), 1)
    tracks, _, summary = written(tmp_path / "x.csv", content)
    CAR.agrees(tracks, start=False)
    assert any(words in note and "dates are 2024-01-15" in note for note in summary["notes"])
    assert not any("count from 1970" in note for note in written(tmp_path / "y.csv", PLAIN)[2]["notes"])


def test_base_stations_and_buoys_are_no_ships(tmp_path):
    rows = []
    for time, (lat, lon) in zip(SHIP.times, SHIP.places, strict=True):
        rows += [f"{mmsi},{time:%Y-%m-%dT%H:%M:%SZ},55.4,11.1" for mmsi in ("002111111", "992111112")]
        rows.append(f"211000001,{time:%Y-%m-%dT%H:%M:%SZ},{lat:.7f},{lon:.7f}")
    tracks, rejected, summary = written(tmp_path / "x.csv", table(rows, "mmsi,time,lat,lon"), "vessel")
    SHIP.agrees(tracks)
    assert rejected.height == 80
    assert summary["rejected"] == {"its MMSI is of a base station or an aid to navigation": 80}


@pytest.mark.parametrize("texts", [["3c660c", "3C660C"], ["3C660C"], ["3e1234"]])
def test_an_address_in_two_spellings_is_one_target(tmp_path, texts):
    tracks, _, summary = written(tmp_path / "x.csv", lettered(texts), "aircraft")
    PLANE.agrees(tracks)
    assert tracks["target"].unique().to_list() == texts[:1]
    assert any("capital and in small letters" in note for note in summary["notes"]) == (len(texts) > 1)


def test_addresses_that_look_like_numbers_stay_apart(tmp_path):
    """Read as numbers, both would be infinite."""
    rows = [f"{name}{row[1:]}" for name in ("3e1234", "3e5678") for row in PLANE.lines(ROW)]
    tracks, _, _ = written(tmp_path / "x.csv", table(rows, "hex,time,lat,lon"), "aircraft")
    assert sorted(tracks["target"].unique()) == ["3e1234", "3e5678"]
    whole, _, _ = written(tmp_path / "y.csv", table(SHIP.lines("211000001.0" + ROW[1:]), "mmsi,time,lat,lon"), "vessel")
    assert whole["target"].unique().to_list() == ["211000001"]


def test_two_formats_in_one_folder_share_their_aircraft(tmp_path):
    (tmp_path / "a.csv").write_bytes(table(PLANE.lines("3c660c,{t},{lat:.7f},{lon:.7f}")[:20], "hex,time,lat,lon"))
    head = "MSG,3,1,1,3C660C,1,{date:%Y/%m/%d},{date:%H:%M:%S}.000,{date:%Y/%m/%d},{date:%H:%M:%S}.000,,36000"
    (tmp_path / "b.txt").write_text("\n".join(PLANE.lines(head + ",,,{lat:.7f},{lon:.7f},,,0,0,0,0")[20:]) + "\n")
    tracks, rejected, _ = jink.track(tmp_path, kind="aircraft", details=True)
    PLANE.agrees(tracks)
    assert tracks["target"].unique().to_list() == ["3c660c"] and not rejected.height


def test_names_that_differ_by_letters_alone_stay_apart(tmp_path):
    rows = [f"{name}{row[1:]}" for name in "aA" for row in PLANE.lines(ROW)]
    tracks, _, _ = written(tmp_path / "x.csv", table(rows, "callsign,time,lat,lon"), "aircraft")
    assert sorted(tracks["target"].unique()) == ["A", "a"]


def test_a_last_line_that_was_cut_costs_itself_alone(tmp_path):
    tracks, rejected, _ = written(tmp_path / "x.csv", PLAIN[: -len("51.0000000,7.0000000\n") - 3])
    assert (tracks.height, rejected.height) == (39, 1)
    tracks, rejected, _ = written(tmp_path / "y.csv", PLAIN[:-9])
    # a cut number is a position far away: the gate knows
    assert (tracks.height, rejected.height) == (40, 0) and tracks["status"][-1] == "gated"
    assert np.median(tracks["speed"].drop_nulls()) == pytest.approx(20.0, rel=0.01)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (gzip.compress(PLAIN)[:-30], "ends too early"),
        (table(CAR.lines(ROW), HEADER.replace("lon", "lat")), "the same column twice: lat"),
        (timed(lambda t: f"{t.timestamp():.5E}"), "39  time occurs twice"),
        (timed(lambda t: t.strftime("%Y-%jT%H:%M:%SZ")), "--time-format says how"),
        (table(CAR.lines("1,{t},u1hzz"), "id,time,geohash"), "Found: id, time, geohash"),
        (table(CAR.lines(ROW), "id,time,start_lat,start_lon"), "--columns latitude="),
        (tar(), "is a tar archive"),
        (gzip.compress(tar()), "is a tar archive"),
        (b"<html><table><tr><td>time</td></tr></table></html>", "XML or HTML of an unknown kind"),
        (plain("id,time,x,y").replace(b".", b",").replace(b"0,0,", b"0;0;"), "."),
    ],
)
def test_what_cannot_be_read_is_refused_in_words(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        written(tmp_path / "x.csv", content)


def test_an_ordinal_date_by_its_format(tmp_path):
    content = timed(lambda t: t.strftime("%Y-%jT%H:%M:%SZ"))
    CAR.agrees(written(tmp_path / "x.csv", content, time_format="%Y-%jT%H:%M:%SZ")[0])


def parts_of(value: float, count: int) -> str:
    size = abs(value)
    minutes = size % 1 * 60
    degrees = f"-{int(size)}" if value < 0 else f"{int(size)}"
    return f"{degrees},{minutes:.5f}" if count == 2 else f"{degrees},{int(minutes)},{minutes % 1 * 60:.4f}"


@pytest.mark.parametrize(
    ("count", "header"),
    [(2, "id,time,Lat Deg,Lat Min,Lon Deg,Lon Min"), (3, "id,time,lat_deg,lat_min,lat_sec,lon_deg,lon_min,lon_sec")],
)
@pytest.mark.parametrize("journey", [CAR, SOUTH, Journey(latitude=-0.4, longitude=-0.5)])
def test_degrees_minutes_and_seconds_in_columns_of_their_own(tmp_path, count, header, journey):
    pairs = zip(journey.times, journey.places, strict=True)
    rows = [f"1,{t:%Y-%m-%dT%H:%M:%SZ},{parts_of(lat, count)},{parts_of(lon, count)}" for t, (lat, lon) in pairs]
    tracks, rejected, summary = written(tmp_path / "x.csv", table(rows, header))
    journey.agrees(tracks)
    assert not rejected.height and any("is put together from columns" in note for note in summary["notes"])
    assert tracks["latitude"][0] == pytest.approx(journey.latitude, abs=1e-5)


def test_tables_of_r_begin_their_rows_with_a_number(tmp_path):
    content = table(CAR.lines('"{n}",1,{t},{lat:.7f},{lon:.7f}'), '"id","time","lat","lon"')
    tracks, rejected, _ = written(tmp_path / "x.csv", content)
    CAR.agrees(tracks)
    assert not rejected.height


def test_days_of_a_spreadsheet_with_decimal_commas(tmp_path):
    content = timed(lambda t: f"{t.timestamp() / 86_400 + 25_569:.9f}").replace(b".", b",")
    tracks, rejected, summary = written(tmp_path / "x.csv", content)
    CAR.agrees(tracks)
    assert not rejected.height and any("as spreadsheets" in note for note in summary["notes"])
