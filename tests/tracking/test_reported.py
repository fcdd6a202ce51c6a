"""Speeds, courses, vertical rates and range rates of files: used where they help, left out where they do not."""

import numpy as np
import polars as pl
import pytest

import jink
from jink.cli.main import app
from jink.models.sensor import Polar
from jink.scenarios import by_name
from jink.scenarios.observation import Seeing
from jink.scenarios.table import simulation_table

RUNS, SCANS, KNOT = 6, 150, 1852.0 / 3600.0


def _ships(seed=3, sd=15.0, speed_sd=0.1, course_sd=0.02):
    """Vessels that turn, with positions every 10 s, and their true velocities."""
    rng = np.random.default_rng(seed)
    tables = []
    for run in range(RUNS):
        time = 10.0 * np.arange(SCANS)
        rate = np.where((time // 300).astype(int) % 3 == 1, rng.choice([-1.0, 1.0]) * 0.004, 0.0)
        course = rng.uniform(0, 2 * np.pi) + np.cumsum(rate * 10.0)
        vx, vy = 7.0 * np.sin(course), 7.0 * np.cos(course)
        x, y = np.cumsum(vx * 10.0), np.cumsum(vy * 10.0)
        said = np.mod(course + course_sd * rng.normal(size=SCANS), 2 * np.pi)
        tables.append(
            pl.DataFrame(
                {
                    "target": f"ship {run}",
                    "time": time,
                    "x": x + sd * rng.normal(size=SCANS),
                    "y": y + sd * rng.normal(size=SCANS),
                    "sog": (7.0 + speed_sd * rng.normal(size=SCANS)) / KNOT,
                    "cog": np.degrees(said),
                    "true_x": x,
                    "true_y": y,
                    "true_vx": vx,
                    "true_vy": vy,
                }
            )
        )
    return pl.concat(tables)


def _errors(tracks, truth, settled=60.0):
    """RMS errors of position and velocity."""
    tracks = pl.DataFrame(tracks).sort("row")
    late = (tracks["time"] > settled).to_numpy()
    rows = truth[tracks["row"].to_numpy()]
    names = (("x", "true_x"), ("y", "true_y")), (("velocity_x", "true_vx"), ("velocity_y", "true_vy"))
    squares = [sum((tracks[a].to_numpy() - rows[b].to_numpy()) ** 2 for a, b in pairs)[late] for pairs in names]
    return [float(np.sqrt(square.mean())) for square in squares]


def test_speed_and_course_sharpen_position_and_velocity():
    ships = _ships()
    with_, without = (jink.track(ships, kind="vessel", velocity=on, details=True) for on in (True, False))
    (position, velocity), (plain_position, plain_velocity) = (
        _errors(with_.tracks, ships),
        _errors(without.tracks, ships),
    )
    assert position < 0.85 * plain_position
    assert velocity < 0.6 * plain_velocity
    assert any("the reported velocity is used" in note for note in with_.summary["notes"])
    # speed_sd along, 7 m/s times course_sd across: 0.1 and 0.14
    assert 0.07 < with_.summary["noise"][0]["velocity_sd"] < 0.6
    assert not any("velocity" in note for note in without.summary["notes"])


def test_velocities_that_say_nothing_are_left_out():
    ships = _ships()
    rng = np.random.default_rng(0)
    false = ships.with_columns(
        sog=pl.Series(rng.uniform(0, 30, ships.height)), cog=pl.Series(rng.uniform(0, 360, ships.height))
    )
    found = jink.track(false, kind="vessel", details=True)
    assert any("the reported velocity is not used" in note for note in found.summary["notes"])
    assert pl.DataFrame(found.tracks).equals(jink.track(false, kind="vessel", velocity=False))


def test_velocities_in_another_unit_are_left_out_and_named():
    """Half the speed that is true, as a wrong unit makes it."""
    ships = _ships().with_columns(pl.col("sog") * 0.5)
    found = jink.track(ships, kind="vessel", details=True)
    assert any("is not used: it is 0.5 times what the positions show" in note for note in found.summary["notes"])
    assert pl.DataFrame(found.tracks).equals(jink.track(ships, kind="vessel", velocity=False))


def test_a_speed_without_a_course_helps_too():
    """The course stays as it is found from positions; the speed is as good as it is reported."""
    ships = _ships().drop("cog")
    with_, without = (jink.track(ships, kind="vessel", velocity=on) for on in (True, False))
    assert _errors(with_, ships)[0] < _errors(without, ships)[0]
    late = (with_["time"] > 60.0).to_numpy()
    errors = [float(np.sqrt(((each["speed"].to_numpy() - 7.0)[late] ** 2).mean())) for each in (with_, without)]
    assert errors[0] < 0.6 * errors[1]


def test_a_climb_rate_that_hardly_ever_changes_is_used_and_few_rows_are_said_to_be_too_few():
    rng, t = np.random.default_rng(0), np.arange(600.0)
    rate = 8.0 * ((t >= 120) & (t < 300))
    z = 3000.0 + np.cumsum(rate) + rng.normal(0, 7.0, t.size)
    x, y = 200.0 * t + rng.normal(0, 10.0, t.size), rng.normal(0, 10.0, t.size)
    flight = pl.DataFrame({"target": "a", "time": t, "x": x, "y": y, "z": z, "vertical_rate": rate})
    notes = jink.track(flight, details=True).summary["notes"]
    assert any(note.startswith("the reported vertical rate is used") for note in notes)
    few = flight.with_columns(pl.when(pl.col("time") < 30).then("vertical_rate").alias("vertical_rate"))
    notes = jink.track(few, details=True).summary["notes"]
    assert "the reported vertical rate is not used: 30 rows tell too little" in notes


def test_velocities_along_the_axes_and_the_noise_that_is_given():
    ships = _ships().with_columns(
        velocity_x=pl.col("sog") * KNOT * pl.col("cog").radians().sin(),
        velocity_y=pl.col("sog") * KNOT * pl.col("cog").radians().cos(),
    )
    found = jink.track(
        ships.drop("sog", "cog"), kind="vessel", sensor_sd={"position": 15.0, "velocity": 0.15}, details=True
    )
    line = found.summary["noise"][0]
    assert (line["velocity_sd"], line["velocity_sd_from"]) == (0.15, "given")
    assert _errors(found.tracks, ships)[1] < 0.6 * _errors(jink.track(ships, kind="vessel", velocity=False), ships)[1]


def test_axes_that_point_north_east_down_turn_velocities_too():
    ships = _ships()
    enu = ships.with_columns(
        vx=pl.col("true_vx") + 0.05 * pl.col("x").hash().cast(pl.Float64).rank() / ships.height, vy=pl.col("true_vy")
    ).select("target", "time", "x", "y", "vx", "vy")
    ned = enu.rename({"x": "y", "y": "x", "vx": "vy", "vy": "vx"})
    one = jink.track(enu, kind="vessel")
    two = jink.track(ned, kind="vessel", axes="ned")
    assert np.allclose(one["velocity_x"], two["velocity_x"], atol=1e-9)
    assert any(
        "velocity is used" in n for n in jink.track(ned, kind="vessel", axes="ned", details=True).summary["notes"]
    )


def test_courses_are_from_true_north_everywhere():
    """Near the pole the frame's north turns away from the meridians by degrees."""
    from pyproj import Geod

    rng = np.random.default_rng(5)
    geod, time, speed = Geod(ellps="WGS84"), 5.0 * np.arange(400), 230.0
    line = np.array(geod.npts(0.0, 84.0, 110.0, 84.0, 2000))
    lon, lat, back = geod.fwd(
        np.full(400, 0.0), np.full(400, 84.0), np.full(400, geod.inv(0.0, 84.0, 110.0, 84.0)[0]), speed * time
    )
    assert len(line) == 2000
    course = np.mod(np.array(back) + 180.0, 360.0)
    east, north = 30.0 * rng.normal(size=(2, 400))
    flight = pl.DataFrame(
        {
            "icao24": "abc123",
            "time": time,
            "latitude": lat + north / 111_000.0,
            "longitude": lon + east / (111_000.0 * np.cos(np.radians(lat))),
            "gs": speed / KNOT + 0.5 * rng.normal(size=400),
            "track": course + 0.1 * rng.normal(size=400),
        }
    )
    found = jink.track(flight, details=True)
    assert any("the reported velocity is used" in note for note in found.summary["notes"])
    off = np.degrees(pl.DataFrame(found.tracks)["course"].to_numpy()[20:]) - course[20:]
    assert np.abs((off + 180.0) % 360.0 - 180.0).max() < 0.5


@pytest.mark.parametrize("scenario", ["random-turns", "weave"])
def test_a_radar_with_range_rate_is_tracked_from_its_file_as_by_the_api(scenario):
    """As accurately as the filter that knows the sensor, and better than without the range rate."""
    seen = Seeing(sensor="radar-20hz").of(by_name(scenario))
    table = simulation_table(seen.simulate(3, seed=0))
    found = jink.track(table, details=True)
    assert any("the range rate is used" in note for note in found.summary["notes"])
    assert found.summary["noise"][0]["range_rate_sd"] == pytest.approx(1.0, rel=0.05)
    sensor = Polar(range_sd=25.0, azimuth_sd=2e-3, elevation_sd=2e-3, range_rate_sd=1.0)
    z = table.select("range", pl.col("azimuth_deg", "elevation_deg").radians(), "range_rate").to_numpy()
    offsets = np.r_[np.flatnonzero(np.diff(table["run"], prepend=-1)), table.height]
    known = jink.default_filter("aircraft", sensor).filter(table["time"].to_numpy(), z, offsets=offsets)
    api = pl.DataFrame(
        {"row": np.arange(table.height), "time": table["time"]}
        | {name: known[f"p{name}"] for name in "xy"}
        | {f"velocity_{name}": known[f"v{name}"] for name in "xy"}
    )
    truth = table.rename({"true_velocity_x": "true_vx", "true_velocity_y": "true_vy"})
    here, there = _errors(found.tracks, truth, 10.0), _errors(api, truth, 10.0)
    plain = _errors(jink.track(table, velocity=False), truth, 10.0)
    assert here[0] < 1.03 * there[0]
    assert here[1] < 1.03 * there[1]
    assert here[0] < 0.95 * plain[0]
    assert here[1] < 0.8 * plain[1]


def test_a_saved_filter_that_measures_velocities_gets_them(tmp_path):
    ships = _ships()
    sensor = jink.PositionVelocity(sd=15.0, velocity_sd=0.15)
    jink.default_filter("vessel", sensor).save(tmp_path / "own.json")
    ships.write_parquet(tmp_path / "ships.parquet")
    out = tmp_path / "tracks.parquet"
    with pytest.raises(SystemExit) as ended:
        app(["track", str(tmp_path / "ships.parquet"), "--filter", str(tmp_path / "own.json"), "-o", str(out), "-q"])
    assert ended.value.code in (0, None)
    assert _errors(pl.read_parquet(out), ships)[1] < 0.4


def test_no_velocity_at_the_command_line(tmp_path):
    ships = _ships()
    ships.write_parquet(tmp_path / "ships.parquet")
    out = tmp_path / "tracks.parquet"
    with pytest.raises(SystemExit) as ended:
        app(["track", str(tmp_path / "ships.parquet"), "--kind", "vessel", "--no-velocity", "-o", str(out), "-q"])
    assert ended.value.code in (0, None)
    plain = jink.track(ships, kind="vessel", velocity=False)
    written = pl.read_parquet(out)
    assert np.allclose(written["velocity_x"].to_numpy(), plain["velocity_x"].to_numpy(), equal_nan=True)
