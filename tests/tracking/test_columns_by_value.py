"""Columns whose names do not say what they hold: the values tell the same journey, and what was inferred is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from straight import Journey

import jink
from jink.io.errors import InputError

CAR = Journey()


def track(path: Path, lines: list[str], **options):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return jink.track(path, kind="vehicle", details=True, **options)


def said(summary: dict, *words: str) -> bool:
    return any(all(word in note for word in words) for note in summary["notes"])


def test_x_and_y_that_hardly_move_are_degrees(tmp_path):
    lines = ["X;Y;track_id;t", *CAR.lines("{lon:.6f};{lat:.6f};7;{t}")]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks)
    assert said(summary, "longitude and latitude in degrees", "hardly move", "--columns x=X,y=Y")


def test_x_and_y_that_agree_with_the_reported_speed_stay_metres(tmp_path):
    lines = [f"a,{s},{50 + 0.01 * s:.4f},{20 + 0.01 * s:.4f},0.014" for s in CAR.seconds]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,time,x,y,speed", *lines])
    assert tracks["speed"].median() == pytest.approx(0.01414, rel=0.01) and not said(summary, "degrees")


def test_a_robot_at_rest_stays_in_metres(tmp_path):
    noise = np.random.default_rng(5).normal(scale=1e-3, size=(200, 2))
    lines = [f"a,{0.1 * i:.1f},{16.4 + e:.5f},{39.9 + n:.5f}" for i, (e, n) in enumerate(noise)]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,time,x,y", *lines])
    assert "latitude" not in tracks.columns and not said(summary, "degrees")


def test_an_identifier_that_is_unique_per_row_is_no_target(tmp_path):
    lines = ["id;person;trip_id;time;latitude;longitude", *CAR.lines("{n};p;T;{t};{lat:.6f};{lon:.6f}")]
    tracks, _, summary = track(tmp_path / "x.csv", [lines[0].replace("trip_id", "name"), *lines[1:]])
    CAR.agrees(tracks)
    assert tracks["target"].unique().to_list() == ["T"] and said(summary, "'id' is different in every row", "'name'")
    tracks, _, summary = track(
        tmp_path / "y.csv", ["id,time,latitude,longitude", *CAR.lines("{n},{t},{lat:.6f},{lon:.6f}")]
    )
    CAR.agrees(tracks)
    assert said(summary, "'id' is different in every row", "numbers the rows") and said(summary, "as target 'y'")


@pytest.mark.parametrize("name", ["trajectory_id", "individual-local-identifier", "tag-local-identifier"])
def test_identifiers_of_movement_data_are_known(tmp_path, name):
    lines = [f"event-id,{name},timestamp,location-lat,location-long"]
    tracks, _, summary = track(tmp_path / "x.csv", lines + CAR.lines("{n},stork,{t},{lat:.6f},{lon:.6f}"))
    CAR.agrees(tracks)
    assert summary["columns"]["target"] == name


@pytest.mark.parametrize(
    "head",
    [
        "OSD.time,OSD.latitude,OSD.longitude",
        "%time,field.latitude,field.longitude",
        "/fix/header/stamp,/fix/latitude,/fix/longitude",
        "Time (UTC),GPS Latitude (deg),GPS Longitude (deg)",
    ],
)
def test_names_may_be_paths(tmp_path, head):
    CAR.agrees(track(tmp_path / "x.csv", [head, *CAR.lines("{e:.0f},{lat:.6f},{lon:.6f}")])[0])


SOUTHWEST = Journey(latitude=-28.6, longitude=-17.9)


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("TIME,LATITUDE,N/S,LONGITUDE,E/W", "{t},{a:.6f},S,{b:.6f},W"),
        ("time,lat,lat_dir,lon,lon_dir", "{t},{a:.6f},S,{b:.6f},W"),
        ("time,lat,lon", "{t},{a:.6f}S,{b:.6f}W"),
        ("time,lat,lon", "{t},S {a:.6f},W {b:.6f}"),
        ("time;lat;lon", "{t};{d}°{m:.4f}' S;{e}°{k:.4f}' W"),
        ("time,lat,ns,lon,ew", "{t},{d}{m:07.4f},S,{e:03d}{k:07.4f},W"),
        ("time,lat,lon", "{t},-{d}{m:07.4f},-{e:03d}{k:07.4f}"),
        ("time;position", "{t};-{a:.6f},-{b:.6f}"),
        ("time,GPS", "{t},-{a:.6f} -{b:.6f}"),
        ("time;geometry", "{t};POINT(-{b:.6f} -{a:.6f})"),
        ("time;lonlat", "{t};-{b:.6f},-{a:.6f}"),
        ("time;latitude;longitude", "{t};-{comma_a};-{comma_b}"),
        ("time,lat,lon", '{t},"-{comma_a}","-{comma_b}"'),
        ("time,lat,lon", "{t},-{a7:.0f},-{b7:.0f}"),
        ("time,latitudeE7,longitudeE7", "{t},-{a7:.0f},-{b7:.0f}"),
    ],
)
def test_every_way_to_write_a_place_is_the_same_place(tmp_path, head, row):
    lines = [head]
    for time, (lat, lon) in zip(SOUTHWEST.times, SOUTHWEST.places, strict=True):
        a, b = -lat, -lon
        parts = {
            "a": a,
            "b": b,
            "d": int(a),
            "m": a % 1 * 60,
            "e": int(b),
            "k": b % 1 * 60,
            "a7": a * 1e7,
            "b7": b * 1e7,
        }
        parts |= {"comma_a": f"{a:.6f}".replace(".", ","), "comma_b": f"{b:.6f}".replace(".", ",")}
        lines.append(row.format(t=f"{time:%Y-%m-%dT%H:%M:%SZ}", **parts))
    tracks, _, _ = track(tmp_path / "x.csv", lines)
    SOUTHWEST.agrees(tracks)
    assert tracks["latitude"][0] == pytest.approx(-28.6, abs=1e-5) and tracks["longitude"][0] == pytest.approx(
        -17.9, abs=1e-5
    )


def test_scaled_degrees_that_fit_twice_are_refused_with_both_readings(tmp_path):
    car = Journey(latitude=5.5, longitude=7.1)
    lines = [f"{s},{p[0] * 1e7:.0f},{p[1] * 1e7:.0f}" for s, p in zip(car.seconds, car.places, strict=True)]
    with pytest.raises(InputError, match=r"5.5\d*° in 1e-7 degrees or 55.\d+° in 1e-6 degrees.*latitude_e7=lat"):
        track(tmp_path / "x.csv", ["time,lat,lon", *lines])
    tracks, _, _ = track(
        tmp_path / "x.csv", ["time,lat,lon", *lines], columns={"latitude_e7": "lat", "longitude_e7": "lon"}
    )
    car.agrees(tracks, start=False)


def test_exchanged_columns_are_refused(tmp_path):
    east = Journey(latitude=35.6, longitude=139.7)
    lines = ["time,latitude,longitude", *east.lines("{t},{lon:.6f},{lat:.6f}")]
    with pytest.raises(InputError, match="exchanged; --columns latitude=longitude,longitude=latitude"):
        track(tmp_path / "x.csv", lines)


def plots(azimuths: float, elevation: float | None, unit: float, count: int = 60) -> list[str]:
    """A target that crosses a radar's beam at 150 m/s, 60 km away; angles in `unit` degrees."""
    rows = []
    for i in range(count):
        east, north = -18_000.0 + 600.0 * i, 60_000.0
        azimuth = (np.degrees(np.arctan2(east, north)) + azimuths) / unit
        rows.append(
            f"7,{4.0 * i},{np.hypot(east, north):.2f},{azimuth:.6f}" + (f",{elevation / unit:.5f}" if elevation else "")
        )
    return rows


@pytest.mark.parametrize(
    ("azimuths", "elevation", "unit", "words"),
    [
        (90.0, 2.8, 1.0, "degrees (values beyond 2 pi in column 'azimuth')"),
        (90.0, 2.8, 180 / np.pi, "radians (no value beyond 2 pi)"),
        (90.0, None, 180 / np.pi, "radians (no value beyond 2 pi)"),
    ],
)
def test_angles_of_one_table_share_one_unit(tmp_path, azimuths, elevation, unit, words):
    head = "track_id,time,range,azimuth" + (",elevation" if elevation else "")
    tracks, _, summary = jink.track(
        pl.read_csv("\n".join([head, *plots(azimuths, elevation, unit)]).encode()), details=True
    )
    assert tracks["speed"].median() == pytest.approx(150.0, rel=0.02)
    assert said(summary, f"azimuth in column 'azimuth' is taken as {words}")


def test_a_northern_sector_in_degrees_is_known_by_the_speed(tmp_path):
    # the azimuths run from 0 to 6.2 degrees: as radians the target would go round the radar
    rows = [f"7,{4.0 * i},{60_000:.1f},{0.1 + 0.076 * i:.4f}" for i in range(80)]
    tracks, _, summary = track(tmp_path / "x.csv", ["track_id,time,range,azimuth", *rows])
    assert tracks["speed"].median() == pytest.approx(60_000 * np.radians(0.076) / 4.0, rel=0.02)
    assert said(summary, "degrees (median speed 19.9 m/s, as radians")


def test_azimuth_from_the_x_axis_and_axes_that_point_down(tmp_path):
    rows = [f"{0.1 * i:.1f},{50 + 1.2 * i:.3f},{0.3:.4f}" for i in range(60)]
    tracks, _, _ = track(tmp_path / "x.csv", ["time,range,azimuth_rad", *rows], azimuth_from="east")
    assert tracks["y"][-1] / tracks["x"][-1] == pytest.approx(np.tan(0.3), rel=1e-3)
    rows = [f"{0.2 * i:.1f},{1.7 * i:.3f},{1.0 * i:.3f},{-20 - 0.4 * i:.3f}" for i in range(60)]
    tracks, _, summary = track(tmp_path / "y.csv", ["time,x,y,z", *rows], axes="ned")
    assert np.degrees(tracks["course"].median()) == pytest.approx(np.degrees(np.arctan2(1.0, 1.7)), abs=0.1)
    assert tracks["climb_rate"].median() == pytest.approx(2.0, rel=0.01) and said(summary, "x points north, y east")


def test_a_drones_local_position_is_north_east_down_in_microseconds(tmp_path):
    rows = [
        f"{112_574_307 + 200_000 * i},{1.7 * i:.3f},{1.0 * i:.3f},{-20 - 0.4 * i:.3f},8.5,5,-2,0.53" for i in range(60)
    ]
    tracks, _, summary = track(tmp_path / "x.csv", ["timestamp,x,y,z,vx,vy,vz,heading", *rows])
    assert tracks["speed"].median() == pytest.approx(np.hypot(8.5, 5.0), rel=0.01)
    assert tracks["climb_rate"].median() == pytest.approx(2.0, rel=0.01) and said(summary, "PX4", "z down")


@pytest.mark.parametrize(
    ("name", "value", "metres"),
    [
        ("elevation", 100.0, 100.0),
        ("height-above-msl", 100.0, 100.0),
        ("Altitude [ft]", 1000.0, 304.8),
        ("altitude (cm)", 1000.0, 10.0),
        ("alt_mm", 10_000.0, 10.0),
    ],
)
def test_heights_by_name_and_unit(tmp_path, name, value, metres):
    lines = [f"id,time (millisecond),latitude,longitude,{name}"]
    lines += [f"a,{1000 * s:.0f},{p[0]:.6f},{p[1]:.6f},{value}" for s, p in zip(CAR.seconds, CAR.places, strict=True)]
    tracks, _, _ = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks, start=False)
    assert tracks["altitude"].median() == pytest.approx(metres, abs=1e-6)


def test_units_may_stand_in_the_fields(tmp_path):
    lines = ["id,time,latitude,longitude,height,speed", *CAR.lines("a,{t},{lat:.6f},{lon:.6f},513.8 M,72.0 km/h")]
    tracks, _, _ = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks)
    assert tracks["altitude"].median() == pytest.approx(513.8, abs=0.1)


def test_heights_in_steps_of_25_beyond_15_km_are_feet(tmp_path):
    plane = Journey(speed=230.0)
    lines = ["id,time,latitude,longitude,altitude", *plane.lines("a,{t},{lat:.6f},{lon:.6f},35000")]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    assert tracks["altitude"].median() == pytest.approx(10_668.0, abs=1.0) and said(
        summary, "taken as feet", "steps of 25"
    )


def test_another_column_of_heights_serves_where_the_first_is_zero(tmp_path):
    lines = ["id,time,latitude,longitude,altitude,baro_altitude", *CAR.lines("a,{t},{lat:.6f},{lon:.6f},0,812.0")]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    assert tracks["altitude"].median() == pytest.approx(812.0, abs=0.1) and said(summary, "'baro_altitude'")


def test_the_accuracy_of_each_fix_is_its_noise(tmp_path):
    rng = np.random.default_rng(3)
    rough = np.arange(60) % 6 == 5
    sd = np.where(rough, 250.0, 3.0)
    walker = Journey(count=60, speed=1.4)
    lines = ["device_id,time,latitude,longitude,accuracy"]
    for t, p, s in zip(walker.times, walker.places, sd, strict=True):
        north, east = rng.normal(scale=s, size=2) / 111_000.0
        radius = 1.51 * s
        lines.append(f"a,{t:%Y-%m-%dT%H:%M:%SZ},{p[0] + north:.7f},{p[1] + east / 0.63:.7f},{radius:.1f}")
    (tmp_path / "x.csv").write_text("\n".join(lines))
    tracks, _, summary = jink.track(tmp_path / "x.csv", kind="person", smooth=True, details=True)
    north, east = np.array(walker.places).T
    error = 111_000.0 * np.hypot(tracks["latitude"] - north, 0.63 * (tracks["longitude"] - east))
    # smoothing 50 good fixes of 3 m leaves less than 3 m at nearly all times; with rough ones believed it would be tens
    assert np.quantile(error, 0.95) < 6.0 and said(summary, "noise of each row", "68 %")


@pytest.mark.parametrize(("name", "of"), [("hdop", lambda s: 0.3 * s), ("position_covariance0", lambda s: s * s)])
def test_dilution_and_variance_are_the_noise_of_their_row(tmp_path, name, of):
    rng = np.random.default_rng(8)
    sd = np.where(np.arange(200) % 5 == 4, 60.0, 3.0)
    walker = Journey(count=200, speed=1.4)
    lines = [f"device_id,time,latitude,longitude,{name}"]
    for t, p, s in zip(walker.times, walker.places, sd, strict=True):
        north, east = rng.normal(scale=s, size=2) / 111_000.0
        lines.append(f"a,{t:%Y-%m-%dT%H:%M:%SZ},{p[0] + north:.7f},{p[1] + east / 0.63:.7f},{of(s):.2f}")
    (tmp_path / "x.csv").write_text("\n".join(lines))
    tracks, _, summary = jink.track(tmp_path / "x.csv", kind="person", smooth=True, details=True)
    north, east = np.array(walker.places).T
    error = 111_000.0 * np.hypot(tracks["latitude"] - north, 0.63 * (tracks["longitude"] - east))
    # good fixes of 3 m smoothed leave less; one rough fix in five that is believed alike would leave more than 10
    assert np.quantile(error, 0.95) < 6.0 and said(summary, "noise of each row", name)


def test_fixes_that_the_source_marks_as_wrong_are_rejected(tmp_path):
    lines = ["id,time,latitude,longitude,visible,manually-marked-outlier"]
    for i, line in enumerate(CAR.lines("a,{t},{lat:.6f},{lon:.6f}")):
        lines.append(f"{line},{'false' if i == 7 else 'true'},{'true' if i == 9 else ''}")
    tracks, rejected, _ = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks, rows=38)
    assert rejected["row"].to_list() == [7, 9] and "visible" in rejected["reason"][0]
    assert track(tmp_path / "x.csv", lines, check_coordinates=False)[0].height == 40


def test_on_the_ground_the_height_stays(tmp_path):
    plane = Journey(count=120, step=2.0, speed=60.0)
    heights = [max(1500 - 25 * i, 0) or "ground" for i in range(120)]
    rows = [
        {"hex": "ab", "timestamp": t.timestamp(), "lat": p[0], "lon": p[1], "alt_baro": h}
        for t, p, h in zip(plane.times, plane.places, heights, strict=True)
    ]
    tracks, _, summary = jink.track(pl.DataFrame(rows, strict=False), details=True)
    last = tracks.tail(40)
    # the last height in the air is one step of 25 feet, 7.6 m; the filter overshoots by less than its sd there, 5 m
    assert last["altitude"].abs().max() < 12.6 and last["climb_rate"].abs().max() < 0.5
    assert said(summary, "60 rows on the ground")


def test_ais_says_where_no_position_is_available(tmp_path):
    lines = ["MMSI,BaseDateTime,LAT,LON,SOG", *CAR.lines("219,{t},{lat:.6f},{lon:.6f},38.9")]
    lines[6] = f"219,{CAR.times[5]:%Y-%m-%dT%H:%M:%SZ},91.0,181.0,102.3"
    lines[9] = f"219,{CAR.times[8]:%Y-%m-%dT%H:%M:%SZ},51.001,181.0,102.3"
    tracks, rejected, _ = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks, rows=38)
    assert rejected["row"].to_list() == [5, 8] and "no longitude is available" in rejected["reason"][1]


def test_a_comma_that_could_be_either_is_not_guessed(tmp_path):
    lines = ["id;time;x;y", *[f"a;{i};{1 + i},{100 + i};5" for i in range(12)]]
    with pytest.raises(InputError, match="x has a comma that is a decimal one or one between thousands"):
        track(tmp_path / "x.csv", lines)
    lines = ["id,time,latitude,longitude,altitude_ft", *CAR.lines('a,{t},{lat:.6f},{lon:.6f},"35,000"')]
    assert track(tmp_path / "y.csv", lines)[0]["altitude"].median() == pytest.approx(10_668.0, abs=1.0)


def test_a_row_may_begin_with_the_sign_of_a_comment(tmp_path):
    lines = ["id,time,latitude,longitude", *CAR.lines("#7,{t},{lat:.6f},{lon:.6f}")]
    tracks, _, _ = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks)
    assert tracks["target"][0] == "#7"
