"""Times however they are written: the same journey is found, or the file is refused with what decides."""

from __future__ import annotations

from datetime import UTC, datetime
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


@pytest.mark.parametrize(
    ("form", "said"),
    [
        ("%Y%m%dT%H%M%SZ", None),
        ("%Y%m%d%H%M%S", "14 digits"),
        ("%Y-%m-%d %H:%M:%S,000", None),
        ("%Y-%m-%d %H:%M:%S.123456789", None),
        ("%Y-%m-%d %H:%M:%S +0000 UTC", None),
        ("%d-%b-%Y %H:%M:%S", "day and name"),
        ("%d %B %Y %H:%M:%S", "day and name"),
        ("%a %b %d %H:%M:%S %Y", "year last"),
        ("%m/%d/%Y %I:%M:%S %p", "month first"),
        ("%d.%m.%Y %H:%M:%S", "day first"),
        ("%Y:%m:%d %H:%M:%S", None),
        ("%Y/%m/%d %H:%M:%S", None),
    ],
)
def test_dates_in_any_usual_form(tmp_path, form, said):
    lines = ["id;time;latitude;longitude", *CAR.lines("a;{t};{lat:.6f};{lon:.6f}", form)]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    CAR.agrees(tracks, start="123456789" not in form)
    assert any(said in note for note in summary["notes"]) if said else not any("times" in n for n in summary["notes"])


@pytest.mark.parametrize(
    ("origin", "words"),
    [(25_569.0, "1899-12-30"), (719_529.0, "MATLAB"), (40_587.0, "modified Julian"), (2_440_587.5, "Julian days")],
)
def test_days_are_known_by_the_speed_that_seconds_would_need(tmp_path, origin, words):
    lines = [
        f"a,{origin + time.timestamp() / 86400:.8f},{place[0]:.6f},{place[1]:.6f}"
        for time, place in zip(CAR.times, CAR.places, strict=True)
    ]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,time,latitude,longitude", *lines])
    CAR.agrees(tracks, start=False)
    # 1e-8 of a day is .9 ms
    assert abs((tracks["time"].min() - CAR.start).total_seconds()) < 2e-3
    assert any(words in note for note in summary["notes"])


def test_seconds_of_a_day_in_the_same_range_stay_seconds(tmp_path):
    lines = [f"a,{45306.6 + s},{p[0]:.6f},{p[1]:.6f}" for s, p in zip(CAR.seconds, CAR.places, strict=True)]
    tracks, _, _ = track(tmp_path / "x.csv", ["id,time,latitude,longitude", *lines])
    CAR.agrees(tracks, start=False)
    assert tracks["time"].min() == pytest.approx(45306.6)


@pytest.mark.parametrize("form", ["%d/%m/%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S"])
def test_a_file_of_one_ambiguous_day_is_refused_with_both_readings_until_told(tmp_path, form):
    car = Journey(start=datetime(2024, 3, 1, tzinfo=UTC))
    lines = ["id,time,latitude,longitude", *car.lines("a,{t},{lat:.6f},{lon:.6f}", form)]
    with pytest.raises(InputError, match=r"2024-0\d-0\d 00:00:00 \(day first\) or 2024-0\d-0\d 00:00:00 .*--day-first"):
        track(tmp_path / "x.csv", lines)
    car.agrees(track(tmp_path / "x.csv", lines, day_first=form.startswith("%d"))[0])
    car.agrees(track(tmp_path / "x.csv", lines, time_format=form)[0])


def test_days_that_join_at_midnight_tell_day_from_month(tmp_path):
    car = Journey(count=60, step=900.0, speed=1.1, start=datetime(2019, 9, 7, 20, tzinfo=UTC))
    lines = ["time\tlatitude\tlongitude", *car.lines("{t}\t{lat:.6f}\t{lon:.6f}", "%d/%m/%Y %H:%M")]
    tracks, _, summary = track(tmp_path / "x.tsv", lines, gap=0)
    car.agrees(tracks)
    assert any("day first" in note and "longest step" in note for note in summary["notes"])


def test_the_danish_layout_is_day_first(tmp_path):
    car = Journey(speed=6.0, start=datetime(2024, 3, 1, tzinfo=UTC))
    head = "# Timestamp,Type of mobile,MMSI,Latitude,Longitude,SOG"
    lines = car.lines("{t},Class A,219000000,{lat:.6f},{lon:.6f},11.7", "%d/%m/%Y %H:%M:%S")
    tracks, _, summary = track(tmp_path / "x.csv", [head, *lines])
    car.agrees(tracks)
    assert any("Danish" in note for note in summary["notes"])


@pytest.mark.parametrize(
    ("date", "clock"),
    [("%Y-%m-%d", "%H:%M:%S"), ("%d.%m.%Y", "%H:%M:%S.250"), ("%Y%m%d", "%H%M%S"), ("%Y/%m/%d", "%I:%M:%S %p")],
)
def test_date_and_time_in_two_columns(tmp_path, date, clock):
    car = Journey(count=60, start=datetime(2018, 4, 18, 23, 58, tzinfo=UTC))
    lines = ["Date;Time;Latitude;Longitude", *car.lines("{t};{lat:.6f};{lon:.6f}", f"{date};{clock}")]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    car.agrees(tracks, start=False)
    assert abs((tracks["time"].min() - car.start).total_seconds()) < 0.26
    assert summary["columns"]["time"] == "Date + Time"


def test_times_of_day_go_on_after_midnight(tmp_path):
    car = Journey(count=60, start=datetime(2018, 4, 18, 23, 58, tzinfo=UTC))
    lines = ["time,latitude,longitude", *car.lines("{t},{lat:.6f},{lon:.6f}", "%H:%M:%S")]
    tracks, _, summary = track(tmp_path / "x.csv", lines)
    car.agrees(tracks, start=False)
    assert tracks["time"].max() == pytest.approx(23 * 3600 + 58 * 60 + 295)
    assert any("midnight" in note for note in summary["notes"])


def test_seconds_and_milliseconds_in_one_column(tmp_path):
    lines = [f"a,{t.timestamp() * (1000 if i % 3 else 1):.0f},{p[0]:.6f},{p[1]:.6f}" for i, (t, p) in _pairs(CAR)]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,time,latitude,longitude", *lines])
    CAR.agrees(tracks)
    assert any("26 in ms, 14 in s" in note for note in summary["notes"])


def _pairs(journey: Journey):
    return enumerate(zip(journey.times, journey.places, strict=True))


def test_microseconds_since_boot_are_known_by_the_speed(tmp_path):
    lines = [f"a,{112_574_307 + int(5e6 * i)},{p[0]:.6f},{p[1]:.6f}" for i, (_, p) in _pairs(CAR)]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,timestamp,latitude,longitude", *lines])
    CAR.agrees(tracks, start=False)
    assert any("us since a start" in note and "--time-unit" in note for note in summary["notes"])


def test_what_no_speed_explains_is_refused_with_both_readings(tmp_path):
    slow = [f"a,{112_574_307 + int(5e6 * i)},{51 + 1e-9 * i:.9f},7" for i in range(30)]
    with pytest.raises(InputError, match=r"1973-07-26 as seconds since 1970.*microseconds since a start.*--time-unit"):
        track(tmp_path / "y.csv", ["id,timestamp,latitude,longitude", *slow])


def test_milliseconds_of_a_log_are_known_by_its_speed_column(tmp_path):
    lines = [f"a,{1000 * s:.0f},{p[0]:.6f},{p[1]:.6f},72" for s, p in zip(CAR.seconds, CAR.places, strict=True)]
    tracks, _, summary = track(tmp_path / "x.csv", ["id,time,latitude,longitude,speed", *lines])
    CAR.agrees(tracks, start=False)
    assert any("taken as ms" in note for note in summary["notes"])


def test_gps_weeks_and_seconds_become_utc(tmp_path):
    # 2024-01-14 began GPS week 2297; GPS is 18 s ahead of UTC
    lines = [
        f"2297,{86400 + 52200 + 18 + s},{p[0]:.6f},{p[1]:.6f}" for s, p in zip(CAR.seconds, CAR.places, strict=True)
    ]
    tracks, _, summary = track(tmp_path / "x.csv", ["gps_week,tow,latitude,longitude", *lines])
    CAR.agrees(tracks)
    assert any("GPS weeks" in note for note in summary["notes"])


def test_a_logger_with_weeks_and_its_own_clock_is_read_by_the_weeks(tmp_path):
    lines = [
        f"{112_000_000 + s * 1e6:.0f},{(86400 + 52200 + 18 + s) * 1000:.0f},2297,{p[0]:.6f},{p[1]:.6f}"
        for s, p in zip(CAR.seconds, CAR.places, strict=True)
    ]
    CAR.agrees(track(tmp_path / "x.csv", ["TimeUS,GMS,GWk,Lat,Lng", *lines])[0])


@pytest.mark.parametrize("text", ["{h}", "{h}.50"])
def test_times_of_day_in_digits(tmp_path, text):
    lines = [f"{text.format(h=t.strftime('%H%M%S'))},{p[0]:.6f},{p[1]:.6f}" for _, (t, p) in _pairs(CAR)]
    tracks, _, summary = track(tmp_path / "x.csv", ["time,latitude,longitude", *lines])
    CAR.agrees(tracks, start=False)
    assert any("HHMMSS" in note for note in summary["notes"])


def test_seconds_of_two_short_recordings_are_no_times_of_day():
    rng = np.random.default_rng(3)
    time = 0.3 + np.r_[np.arange(60.0), np.arange(500.0, 560.0)]
    data = pl.DataFrame({"target": "a", "time": time, "x": 200 * time + rng.normal(0, 5, 120), "y": 0.0})
    done = jink.track(data, details=True)
    assert done.tracks["time"].to_list() == time.tolist() and done.summary["parts"] == 2
    assert abs(done.tracks["speed"].median() - 200.0) < 5.0


def test_dates_in_floats_of_32_bits_are_refused():
    time = 1.7e9 + 300.0 * np.arange(60)
    data = pl.DataFrame({"target": "a", "time": time, "x": 10 * (time - time[0]), "y": 0.0})
    with pytest.raises(InputError, match="floats of 32 bits, which are 128 apart"):
        jink.track(data.with_columns(pl.col("time").cast(pl.Float32)), kind="vessel")
    short = data.with_columns(pl.col("time") - time[0])
    narrow = jink.track(short.with_columns(pl.col("time").cast(pl.Float32)), kind="vessel")
    assert narrow["time"].to_list() == short["time"].to_list()


def test_a_date_and_seconds_of_the_day(tmp_path):
    lines = [f"2024-01-15,{52_200 + s},{p[0]:.6f},{p[1]:.6f}" for s, p in zip(CAR.seconds, CAR.places, strict=True)]
    CAR.agrees(track(tmp_path / "x.csv", ["date,time,latitude,longitude", *lines])[0])


@pytest.mark.parametrize("head", ["year,month,day,hour,minute,second", "YYYY,MM,DD,hh,min,sec"])
def test_year_month_day_and_the_rest_in_columns_of_their_own(tmp_path, head):
    head += ",latitude,longitude"
    lines = CAR.lines("{t},{lat:.6f},{lon:.6f}", "%Y,%m,%d,%H,%M,%S.0")
    tracks, _, summary = track(tmp_path / "x.csv", [head, *lines])
    CAR.agrees(tracks)
    assert any("put together from the columns" in note for note in summary["notes"])


def test_seconds_and_nanoseconds_in_two_columns(tmp_path):
    fast = Journey(step=0.25, count=80)
    lines = [f"{int(t.timestamp())},{t.microsecond * 1000},{p[0]:.8f},{p[1]:.8f}" for _, (t, p) in _pairs(fast)]
    head = "header.stamp.secs,header.stamp.nsecs,latitude,longitude"
    fast.agrees(track(tmp_path / "x.csv", [head, *lines])[0])


def test_epochs_with_a_decimal_comma(tmp_path):
    lines = [f"{t.timestamp():.1f};{p[0]:.6f};{p[1]:.6f}".replace(".", ",") for _, (t, p) in _pairs(CAR)]
    CAR.agrees(track(tmp_path / "x.csv", ["time;latitude;longitude", *lines])[0])


def test_the_second_of_the_minute_gives_way_to_another_column_or_is_refused(tmp_path):
    rows = [
        {"mmsi": 7, "timestamp": t.second, "lat": p[0], "lon": p[1], "rxtime": t.timestamp()}
        for t, p in zip(CAR.times, CAR.places, strict=True)
    ]
    frame = pl.DataFrame(rows)
    tracks, _, summary = jink.track(frame, kind="vessel", details=True)
    CAR.agrees(tracks)
    assert any("second of the minute" in note and "rxtime" in note for note in summary["notes"])
    with pytest.raises(InputError, match=r"second of the minute(.|\n)*--columns time="):
        jink.track(frame.drop("rxtime"), kind="vessel")


def test_times_without_a_zone_are_in_the_zone_that_is_given(tmp_path):
    lines = ["id,time,latitude,longitude", *CAR.lines("a,{t},{lat:.6f},{lon:.6f}", "%Y-%m-%d 15:%M:%S")]
    tracks, _, _ = track(tmp_path / "x.csv", lines, time_zone="Europe/Berlin")
    CAR.agrees(tracks)
    with pytest.raises(InputError, match="expected a name such as Europe/Berlin"):
        track(tmp_path / "x.csv", lines, time_zone="Berlin")


@pytest.mark.parametrize(
    ("shift", "rows", "words"),
    [
        (-3600, slice(20, 40), "one hour"),
        (-86400, slice(20, 23), "one day"),
        (-619_315_200, slice(0, 20), "1024 weeks"),
    ],
)
def test_one_step_of_a_clock_is_mended(tmp_path, shift, rows, words):
    moved = [t.timestamp() for t in CAR.times]
    moved[rows] = [t + shift for t in moved[rows]]
    lines = [f"a,{t:.0f},{p[0]:.6f},{p[1]:.6f}" for t, p in zip(moved, CAR.places, strict=True)]
    tracks, rejected, summary = track(tmp_path / "x.csv", ["id,time,latitude,longitude", *lines])
    CAR.agrees(tracks)
    assert not rejected.height and any(words in note for note in summary["notes"])


def test_two_receivers_one_after_the_other_are_no_clock_that_was_set(tmp_path):
    car = Journey(count=721)  # an hour, so that the second receiver begins one hour and a step back
    lines = ["id,time,latitude,longitude", *2 * car.lines("a,{t},{lat:.6f},{lon:.6f}")]
    tracks, rejected, summary = track(tmp_path / "x.csv", lines)
    car.agrees(tracks)
    assert rejected.height == 721 and not any("clock" in note for note in summary["notes"])


def test_the_time_of_a_position_is_its_own_not_the_rows(tmp_path):
    lines = [f"{t.timestamp() + 9:.0f},abc123,{p[0]:.6f},{p[1]:.6f},{t.timestamp():.3f}" for _, (t, p) in _pairs(CAR)]
    tracks, _, summary = track(tmp_path / "x.csv", ["time,icao24,lat,lon,lastposupdate", *lines])
    CAR.agrees(tracks)
    assert any("'lastposupdate'" in note for note in summary["notes"])


def test_the_age_of_a_position_is_taken_from_the_time_of_its_row(tmp_path):
    lines = [f"{t.timestamp() + i % 4:.1f},abc123,{p[0]:.6f},{p[1]:.6f},{i % 4}.0" for i, (t, p) in _pairs(CAR)]
    tracks, _, summary = track(tmp_path / "x.csv", ["now,hex,lat,lon,seen_pos", *lines])
    CAR.agrees(tracks)
    assert any("less its age" in note for note in summary["notes"])
