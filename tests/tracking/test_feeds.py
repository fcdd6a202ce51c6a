"""Feeds as stations deliver them: clocks of receivers, values that say none, and damage on the way."""

from __future__ import annotations

from datetime import timedelta

import numpy as np
import polars as pl
import pytest
from formats_written import CAR

import jink

BASE = {"type": 4, "mmsi": 2190001, "lat": 54.0, "lon": 10.0}


def sentences(**fields) -> list[str]:
    from pyais import encode_dict

    return encode_dict({"type": 1, "mmsi": 219000000} | fields, radio_channel="A")


def journey(written, **fields) -> list[str]:
    """One report per place of the journey, behind what the receiver wrote of its time."""
    pairs = zip(CAR.times, CAR.places, strict=True)
    return [
        written(t) + line for t, (lat, lon) in pairs for line in sentences(lat=lat, lon=lon, second=t.second, **fields)
    ]


@pytest.mark.parametrize(
    ("written", "zone"),
    [
        (lambda t: (t + timedelta(hours=2)).strftime("%Y-%m-%dT%H:%M:%S+02:00 "), None),
        (lambda t: (t + timedelta(hours=2)).strftime("%Y-%m-%d %H:%M:%S,000+0200 "), None),
        (lambda t: (t + timedelta(hours=3)).strftime("%Y-%m-%dT%H:%M:%S "), "Etc/GMT-3"),
        (lambda t: t.strftime("%Y-%m-%dT%H:%M:%SZ "), "Etc/GMT-3"),
    ],
)
def test_times_beside_ais_sentences_keep_their_zone(tmp_path, written, zone):
    pytest.importorskip("pyais")
    (tmp_path / "x.nmea").write_text("\n".join(journey(written)))
    CAR.agrees(jink.track(tmp_path / "x.nmea", kind="vehicle", time_zone=zone, details=True)[0])


def test_base_stations_tell_the_minute_and_messages_the_second(tmp_path):
    pytest.importorskip("pyais")
    lines = journey(lambda t: "")
    told = [t - timedelta(seconds=4) for t in CAR.times[::8]]
    for number, t in reversed(list(enumerate(told))):
        parts = dict(year=t.year, month=t.month, day=t.day, hour=t.hour, minute=t.minute, second=t.second)
        lines[8 * number : 8 * number] = sentences(**BASE | parts)
    (tmp_path / "x.nmea").write_text("\n".join(lines))
    tracks, rejected, summary = jink.track(tmp_path / "x.nmea", kind="vehicle", details=True)
    CAR.agrees(tracks)
    assert not rejected.height
    assert f"{len(told)} messages that are no position reports are not rows" in summary["notes"]


@pytest.mark.parametrize(("kind", "none", "most"), [(27, 63.0, 62.0), (9, 1023.0, 150.0)])
def test_each_message_of_ais_says_in_its_own_way_that_there_is_no_speed(tmp_path, kind, none, most):
    pytest.importorskip("pyais")
    from jink.io.formats.ais import read

    lines = [line for speed in (none, most) for line in sentences(type=kind, lat=54.0, lon=10.0, speed=speed)]
    content = "\n".join(f"\\c:1559041817*00\\{line}" for line in lines).encode()
    assert read("x", content).frame["speed"].to_list() == [None, most]


@pytest.mark.parametrize("lag", [1.0, 2.0])
def test_two_stations_with_one_report_do_not_hide_its_noise(lag):
    """Each report comes twice, so that the usual step of the rows is not that of the positions."""
    rng, time = np.random.default_rng(0), 10.0 * np.arange(120)
    lat = 54.0 + (6.0 * time + rng.normal(0, 5.0, 120)) / 111_200
    lon = 10.0 + rng.normal(0, 5.0, 120) / 65_400
    once = pl.DataFrame({"mmsi": "219000000", "time": 1.7e9 + time, "lat": lat, "lon": lon})
    twice = pl.concat([once, once.with_columns(pl.col("time") + lag)]).sort("time")
    noise = jink.track(twice, kind="vessel", details=True).summary["noise"][0]
    assert noise["position_sd_from"] == "estimated" and noise["position_sd"] == pytest.approx(5.0, rel=0.25)
