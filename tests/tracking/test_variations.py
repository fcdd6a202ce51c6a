"""The same journey as other people write it, in names, units, placeholders and places: none is silently wrong."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from straight import Journey

import jink
from jink.io.codes import are_codes, zero_heights
from jink.io.errors import InputError

CAR = Journey()
WEST = Journey(latitude=-33.9, longitude=-70.4)
PLANE = Journey(speed=230.0, course=100.0, latitude=49.0)
SHIP = Journey(speed=6.0, course=45.0, latitude=55.5, longitude=11.0, step=10.0)


def track(path: Path, lines: list[str], kind: str = "vehicle", **options):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return jink.track(path, kind=kind, details=True, **options)


def said(summary: dict, *words: str) -> bool:
    return any(all(word in note for word in words) for note in summary["notes"])


def dms(value: float, letter: str) -> str:
    size = abs(value)
    minutes = size % 1 * 60
    return f"{int(size)}°{int(minutes)}'{minutes % 1 * 60:.3f}\"{letter}"


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("id,time,n,e,d", "1,{t},{north:.3f},{east:.3f},-100"),
        ("id,time,e,n,u", "1,{t},{east:.3f},{north:.3f},100"),
        ("id,Elapsed (min),x [mm],y [mm]", "1,{min:.9f},{eastmm:.0f},{northmm:.0f}"),
        ("GPS Week,GPS Second [s],Lat,Lon", "2297,{sow:.1f},{lat:.7f},{lon:.7f}"),
        ("timestamp,position_lat,position_long", "{t},{lat32:.0f},{lon32:.0f}"),
        ("device_id;time;the_geom", "1;{t};POINT Z ({lon:.7f} {lat:.7f} 100)"),
        ("zeit;Breitengrad;Längengrad", "{t};{lat:.7f};{lon:.7f}"),
        ('id,"time","Latitude, Longitude"', '1,"{ms:,.0f}","{lat:.7f}, {lon:.7f}"'),
        ("id,time,lat,lon", "1,[{t}],{lat:.7f},{lon:.7f}"),
        ("OSD.latitude,OSD.longitude,CUSTOM.date [local],CUSTOM.updateTime [local]", "{lat:.7f},{lon:.7f},{day},{pm}"),
    ],
)
def test_the_same_journey_in_other_words(tmp_path, header, row):
    first = CAR.places[0]
    lines = []
    for i, (time, (lat, lon)) in enumerate(zip(CAR.times, CAR.places, strict=True)):
        north = math.radians(lat - first[0]) * 6.3913e6
        east = math.radians(lon - first[1]) * 6.3913e6 * math.cos(math.radians(first[0]))
        values = {"north": north, "east": east, "northmm": 1e3 * north, "eastmm": 1e3 * east, "min": 5 * i / 60}
        values |= {"t": f"{time:%Y-%m-%dT%H:%M:%SZ}", "lat": lat, "lon": lon, "sow": 138618.0 + 5 * i}
        values |= {"lat32": lat * 2**31 / 180, "lon32": lon * 2**31 / 180, "ms": time.timestamp() * 1e3}
        lines.append(row.format(**values, day=f"{time:%m/%d/%Y}", pm=f"{time:%I:%M:%S} PM"))
    tracks, rejected, _ = track(tmp_path / "x.csv", [header, *lines])
    CAR.agrees(tracks, start=isinstance(tracks.schema["time"], pl.Datetime))
    assert rejected.height == 0


@pytest.mark.parametrize("text", ["{south} {west}", "{south}, {west}", "{latitude:.7f}S {longitude:.7f}W"])
def test_one_column_of_letters_is_split(tmp_path, text):
    lines = ["id;time;position"]
    for time, (lat, lon) in zip(WEST.times, WEST.places, strict=True):
        place = text.format(south=dms(lat, "S"), west=dms(lon, "W"), latitude=-lat, longitude=-lon)
        lines.append(f"1;{time:%Y-%m-%dT%H:%M:%SZ};{place}")
    tracks, _, _ = track(tmp_path / "x.csv", lines)
    WEST.agrees(tracks)
    assert tracks["longitude"][0] == pytest.approx(-70.4, abs=1e-4)


@pytest.mark.parametrize(
    ("name", "value"), [("FL", "350"), ("flight_level", "FL350"), ("altitude", '"35,000 ft"'), ("alt", "10668 m")]
)
def test_flight_levels_and_units_in_fields(tmp_path, name, value):
    lines = [f"flight,time,lat,lon,{name}", *PLANE.lines(f"X1,{{t}},{{lat:.6f}},{{lon:.6f}},{value}")]
    tracks, _, _ = track(tmp_path / "x.csv", lines, "aircraft")
    assert tracks["altitude"].to_numpy() == pytest.approx(10668.0, abs=0.1)


@pytest.mark.parametrize("code", ["-9999", "-32768", "1e20"])
def test_codes_for_no_height_are_missing(tmp_path, code):
    lines = ["id,time,lat,lon,alt", *CAR.lines("1,{t},{lat:.6f},{lon:.6f},{i}")]
    lines[1:] = [line[: line.rindex(",") + 1] + (code if i % 9 == 4 else "100") for i, line in enumerate(lines[1:])]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks)
    assert tracks["altitude"].to_numpy() == pytest.approx(100.0, abs=0.1)
    assert said(summary, "codes for none", "'alt'")


def test_codes_for_no_position_are_rejected_with_the_reason(tmp_path):
    lines = [f"1,{5 * i},{-9999 if i % 9 == 4 else 100 * i},{-9999 if i % 9 == 4 else 20}" for i in range(40)]
    tracks, rejected, _ = track(tmp_path / "x.csv", ["id,time,x,y", *lines])
    assert (tracks.height, rejected.height) == (36, 4) and set(rejected["reason"]) == {"x is a code for none"}
    assert tracks["speed"].median() == pytest.approx(20.0, rel=0.01)


def test_a_path_through_a_code_is_a_path():
    assert not are_codes(np.arange(-11_000.0, -9_000.0, 50.0) - 49.0).any()
    assert are_codes(np.array([-9999.0, 1.0, 2.0])).tolist() == [True, False, False]
    assert not are_codes(np.array([-9999.0])).any() and are_codes(np.array([-9999.0]), height=True).all()


def test_a_height_of_zero_that_no_climb_leads_to_is_missing(tmp_path):
    heights = [0 if i in (20, 21, 30) else 35000 for i in range(40)]
    lines = [f"{line},{height}" for line, height in zip(PLANE.lines("a,{t},{lat},{lon}"), heights, strict=True)]
    tracks, _, summary = track(tmp_path / "x.csv", ["icao,time,lat,lon,altitude_ft", *lines], "aircraft")
    assert tracks["altitude"].to_numpy() == pytest.approx(10668.0, abs=0.1) and said(summary, "3 heights of 0")
    climb = np.r_[np.zeros(5), 10.0 * np.arange(1, 6)]
    assert not zero_heights(climb, np.zeros(10, int), np.arange(10.0)).any()


def test_codes_of_ais_tell_the_unit_of_its_integers(tmp_path):
    rows = [
        f"211,{time.timestamp():.0f}," + ("54600000,108600000" if i % 10 == 3 else f"{lat * 6e5:.0f},{lon * 6e5:.0f}")
        for i, (time, (lat, lon)) in enumerate(zip(SHIP.times, SHIP.places, strict=True))
    ]
    tracks, rejected, summary = track(tmp_path / "x.csv", ["mmsi,timestamp,lat,lon", *rows], "vessel")
    SHIP.agrees(tracks, 36)
    assert rejected.height == 4 and said(summary, "1/10000 minutes")


def test_milliseconds_without_a_unit_beside_places_that_hardly_move(tmp_path):
    lines = [f"1,{5000 * i},{lat:.7f},{lon:.7f}" for i, (lat, lon) in enumerate(CAR.places)]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,time,lat,lon", *lines])
    assert tracks["speed"].median() == pytest.approx(20.0, rel=0.01) and said(summary, "ms since a start")
    walk = Journey(speed=1.2)
    lines = [f"1,{5000 * i},{lat:.7f},{lon:.7f}" for i, (lat, lon) in enumerate(walk.places)]
    with pytest.raises(InputError, match=r"195000 can be 195000 s since a start, where nothing moves.*--time-unit"):
        track(tmp_path / "y.csv", ["id,time,lat,lon", *lines], "person")


def test_kilometres_without_a_unit_crawl(tmp_path):
    lines = [f"1,{5 * i},{0.09 * i:.3f},{0.05 * i:.3f}" for i in range(40)]
    _, _, summary = track(tmp_path / "x.csv", ["id,time,x,y", *lines])
    assert "too_slow" in [w["code"] for w in summary["warnings"] if "kilometres" in w["message"]]


def test_exchanged_columns_are_refused_by_what_targets_report(tmp_path):
    lines = CAR.lines("1,{t},{lon:.6f},{lat:.6f},20,60")
    with pytest.raises(InputError, match=r"'lat' and 'lon' are exchanged.*--columns latitude=lon,longitude=lat"):
        track(tmp_path / "x.csv", ["id,time,lat,lon,speed,course", *lines])
    tracks, _, _ = track(
        tmp_path / "x.csv",
        ["id,time,lat,lon,speed,course", *lines],
        columns={"latitude": "lon", "longitude": "lat"},
    )
    CAR.agrees(tracks)


def test_degrees_near_zero_may_be_radians(tmp_path):
    radians = [f"{np.radians(lat):.9f},{np.radians(lon):.9f}" for lat, lon in CAR.places]
    lines = [f"{line},{place}" for line, place in zip(CAR.lines("1,{t}"), radians, strict=True)]
    _, _, summary = track(tmp_path / "x.csv", ["id,time,lat,lon", *lines])
    assert said(summary, "if they are radians", "latitude_rad=lat")
    tracks, _, _ = track(
        tmp_path / "x.csv",
        ["id,time,lat,lon", *lines],
        columns={"latitude_rad": "lat", "longitude_rad": "lon"},
    )
    CAR.agrees(tracks)


def test_base_stations_do_not_move(tmp_path):
    lines = SHIP.lines("{t},Class A,219,{lat:.6f},{lon:.6f}") + SHIP.lines("{t},Base Station,2190,56,10")
    header = "# Timestamp,Type of mobile,MMSI,Latitude,Longitude"
    tracks, rejected, summary = track(tmp_path / "x.csv", [header, *lines], "vessel")
    SHIP.agrees(tracks)
    assert set(rejected["reason"]) == {"a base station or an aid to navigation does not move"}
    assert summary["warnings"] == []


def test_speeds_below_zero_are_none(tmp_path):
    lines = [f"{line},{-1 if i % 3 else 20}" for i, line in enumerate(CAR.lines("1,{t},{lat:.6f},{lon:.6f}"))]
    tracks, _, _ = track(tmp_path / "x.csv", ["id,time,lat,lon,speed", *lines])
    CAR.agrees(tracks)


def test_radars_at_different_places_are_named_as_the_reason(tmp_path):
    lines = ["t,id,source,range,azimuth_deg"]
    noise = np.random.default_rng(4).normal(scale=20.0, size=80)
    for i in range(80):
        east, north = (600.0 * i - 20e3, 60e3) if i % 2 else (600.0 * i - 50e3, 50e3)
        azimuth = np.degrees(np.arctan2(east, north)) % 360
        lines.append(f"{4 * i},1,{'north' if i % 2 else 'south'},{np.hypot(east, north) + noise[i]:.1f},{azimuth:.4f}")
    _, _, summary = track(tmp_path / "x.csv", lines, "aircraft")
    assert "radars that stand at different places (2 sources)" in summary["warnings"][0]["likely"]
    assert "--site NAME=LAT,LON" in summary["warnings"][0]["mend"]


def test_a_file_of_marks_alone_says_how_to_believe_it(tmp_path):
    lines = ["id,time,lat,lon,valid", *CAR.lines("1,{t},{lat:.6f},{lon:.6f},0")]
    with pytest.raises(InputError, match="--no-check believes rows that are marked as not valid"):
        track(tmp_path / "x.csv", lines)


def test_geojson_whose_type_stands_behind_long_lines_is_geojson(tmp_path):
    place = "[7.0, 51.0],\n" * 9000
    line = f'{{"geometry": {{"coordinates": [{place}[7.0, 51.0]], "type": "LineString"}}, "type": "Feature"}}'
    (tmp_path / "x.json").write_text(f'{{\n "features": [\n {line}], "type": "FeatureCollection"}}')
    with pytest.raises(InputError, match="is GeoJSON without points; its 1 lines have no times"):
        jink.track(tmp_path / "x.json")
