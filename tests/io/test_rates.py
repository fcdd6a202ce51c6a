"""Speeds, courses, vertical rates and range rates as tables and formats say them, in SI units."""

import json

import numpy as np
import polars as pl
import pytest

from jink.io.loading import Reading, load_files, load_frame

KNOT, FPM = 1852.0 / 3600.0, 0.3048 / 60.0
PLACE = {"id": ["a"] * 4, "time": [0.0, 1.0, 2.0, 3.0], "latitude": [48.0, 48.1, 48.2, 48.3], "longitude": [11.0] * 4}


def _loaded(columns, **reading):
    return load_frame(pl.DataFrame(PLACE | columns), Reading(**reading)).measurements


@pytest.mark.parametrize(
    ("columns", "role", "expected"),
    [
        ({"gs": [100.0] * 4, "track": [90.0, 91.0, 92.0, 360.0]}, "course", np.radians([90.0, 91.0, 92.0, 360.0])),
        ({"sog": [8.0] * 4, "cog": [90.0, 91.0, 92.0, 360.0]}, "course", np.radians([90.0, 91.0, 92.0, np.nan])),
        ({"speed": [8.0] * 4, "heading": [10.0, 511.0, 12.0, 13.0]}, "course", np.radians([10.0, np.nan, 12.0, 13.0])),
        ({"speed": [8.0] * 4, "course": [3.0, 3.1, 3.2, 3.3]}, "course", [3.0, 3.1, 3.2, 3.3]),
        ({"speed": [8.0] * 4, "course": [3.0, 3.1, 3.2, 33.0]}, "course", np.radians([3.0, 3.1, 3.2, 33.0])),
        ({"baro_rate": [600.0] * 4}, "vertical_rate", [600.0 * FPM] * 4),
        ({"vertrate": [5.0] * 4}, "vertical_rate", [5.0] * 4),
        ({"groundspeed": [400.0] * 4, "vertical_rate": [600.0] * 4}, "vertical_rate", [600.0 * FPM] * 4),
        ({"vertical_rate_ft_min": [600.0] * 4}, "vertical_rate", [600.0 * FPM] * 4),
        ({"vel_n": [1.0] * 4, "vel_e": [2.0] * 4, "vel_d": [3.0] * 4}, "vertical_rate", [-3.0] * 4),
        ({"vel_n": [1.0] * 4, "vel_e": [2.0] * 4, "vel_d": [3.0] * 4}, "velocity_x", [2.0] * 4),
        ({"velocity_x": [1.0] * 4, "velocity_y": [1e9, 2.0, 2.0, 2.0]}, "velocity_y", [np.nan, 2.0, 2.0, 2.0]),
    ],
)
def test_rates_of_a_table(columns, role, expected):
    assert _loaded(columns).rows[role].to_numpy() == pytest.approx(np.array(expected), nan_ok=True)


@pytest.mark.parametrize(
    "columns", [{"track": [1.0] * 4}, {"velocity_x": [1.0] * 4}, {"gs": [None] * 4, "cog": [1.0] * 4}]
)
def test_a_half_of_a_velocity_is_none(columns):
    rows = _loaded(columns).rows
    assert not {"course", "velocity_x", "velocity_y"} & set(rows.columns)


def test_a_radar_has_a_range_rate_and_nothing_else():
    table = {"time": [0.0, 1.0], "range": [1e4, 1e4], "azimuth_deg": [1.0, 2.0], "range_rate": [5.0, None]}
    rows = load_frame(pl.DataFrame(table | {"course": [1.0, 2.0]}), Reading()).measurements.rows
    assert rows["range_rate"].to_list() == pytest.approx([5.0, np.nan], nan_ok=True)
    assert "course" not in rows.columns


FILES = {
    "aircraft.json": (
        json.dumps(
            {
                "now": 1.7e9,
                "aircraft": [
                    {
                        "hex": "a1",
                        "lat": 48.0,
                        "lon": 11.0,
                        "gs": 400.0,
                        "track": 270.0,
                        "baro_rate": -640,
                        "seen_pos": 1,
                    }
                ],
            }
        ),
        np.radians(270.0),
        -640 * FPM,
    ),
    "trace.json": (
        json.dumps(
            {
                "icao": "a1",
                "timestamp": 1.7e9,
                "trace": [[0.0, 48.0, 11.0, 30000, 400.0, 270.0, 0, -640, None, "adsb", 30500, -700]],
            }
        ),
        np.radians(270.0),
        -700 * FPM,
    ),
    "states.json": (
        json.dumps(
            {
                "time": 1700000000,
                "states": [
                    [
                        "a1",
                        "X",
                        "D",
                        1700000000,
                        1700000000,
                        11.0,
                        48.0,
                        9e3,
                        False,
                        200.0,
                        270.0,
                        -3.0,
                        None,
                        9e3,
                        "",
                        0,
                        0,
                    ]
                ],
            }
        ),
        np.radians(270.0),
        -3.0,
    ),
    "log.nmea": ("$GPRMC,120000.00,A,4800.000,N,01100.000,E,10.0,270.0,010124,,,A*63\n", np.radians(270.0), None),
    "run.gpx": (
        '<?xml version="1.0"?><gpx version="1.0"><trk><trkseg><trkpt lat="48" lon="11">'
        "<time>2024-01-01T12:00:00Z</time><course>270</course><speed>10</speed></trkpt></trkseg></trk></gpx>",
        np.radians(270.0),
        None,
    ),
}


@pytest.mark.parametrize("name", FILES)
def test_rates_of_formats(name, tmp_path):
    content, course, vertical = FILES[name]
    (tmp_path / name).write_text(content)
    rows = load_files([tmp_path / name], Reading()).measurements.rows
    assert rows["course"].to_list() == pytest.approx([course])
    assert ("vertical_rate" in rows.columns) == (vertical is not None)
    if vertical is not None:
        assert rows["vertical_rate"].to_list() == pytest.approx([vertical])
    assert rows["speed"].is_finite().all()


def test_ais_says_what_is_not_available(tmp_path):
    pytest.importorskip("pyais")
    from pyais import encode_dict

    lines = []
    for k, (speed, course) in enumerate([(8.0, 90.0), (102.3, 360.0)]):
        report = {"type": 1, "mmsi": 211000001, "lat": 54.0, "lon": 10.0, "speed": speed, "course": course}
        lines.append(f"\\c:{1700000000 + k}*00\\" + encode_dict(report)[0])
    (tmp_path / "ais.txt").write_text("\n".join(lines))
    rows = load_files([tmp_path / "ais.txt"], Reading()).measurements.rows
    assert rows["speed"].to_list() == pytest.approx([8.0 * KNOT, np.nan], nan_ok=True)
    assert rows["course"].to_list() == pytest.approx([np.pi / 2, np.nan], nan_ok=True)
