"""`jink.track`: what it finds in made-up and in real flights, in every frame, and that no row is lost."""

import io
import json
import warnings
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod

import jink
from jink.io.errors import InputError

FLIGHTS = Path(__file__).parents[2] / "examples" / "flights.parquet"
GEOD = Geod(ellps="WGS84")


def made_up(
    count=300,
    *,
    start=(48.0, 11.0),
    course=70.0,
    speed=220.0,
    sd=20.0,
    step=2.0,
    seed=1,
    turn=(120, 160, 1.5),
):
    """One flight as a frame, and its courses: straight, so many deg/s between two rows, straight again."""
    rng = np.random.default_rng(1)
    step = 2.0
    time = np.arange(count) * step
    rate = np.zeros(count)
    rate[turn[0] : turn[1]] = turn[2]
    latitude, longitude = [start[0]], [start[1]]
    ahead, courses = course, [course]
    for k in range(1, count):
        lon, lat, back = GEOD.fwd(longitude[-1], latitude[-1], ahead, speed * step)
        ahead = back + 180.0 + rate[k] * step
        latitude.append(lat)
        longitude.append(lon)
        courses.append(ahead)
    lon, lat, _ = GEOD.fwd(longitude, latitude, rng.uniform(0, 360, count), np.abs(rng.normal(0, sd * 1.25, count)))
    frame = pl.DataFrame({"target": "m", "t": 1.7e9 + time, "latitude": lat, "longitude": lon})
    return frame.with_columns(altitude_m=3000.0 + rng.normal(0, 5.0, count)), np.radians(courses) % (2 * np.pi)


def _quiet(*arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return jink.track(*arguments, **options)


@pytest.mark.parametrize(
    ("start", "course"),
    [((48.0, 11.0), 70.0), ((10.0, 179.5), 90.0), ((88.5, 20.0), 10.0), ((-60.0, -30.0), 250.0)],
    ids=["home", "date line", "pole", "south"],
)
def test_speed_course_and_turn_are_right_anywhere_on_earth(start, course):
    frame, courses = made_up(start=start, course=course)
    tracks = jink.track(frame, smooth=True)
    steady = slice(30, 100)
    assert tracks.height == frame.height and tracks["status"][steady].unique().to_list() == ["updated"]
    np.testing.assert_allclose(tracks["speed"].to_numpy()[steady], 220.0, atol=6.0)
    off = np.angle(np.exp(1j * (tracks["course"].to_numpy() - courses)))
    assert np.abs(off[steady]).max() < 0.03 and np.abs(off[220:290]).max() < 0.03
    turning = tracks["turn_rate"].to_numpy()[130:150]  # to the right: clockwise, so negative
    np.testing.assert_allclose(turning, -np.radians(1.5), atol=0.006)
    assert tracks["manoeuvring"].to_numpy()[135:145].min() > 0.5 > tracks["manoeuvring"].to_numpy()[steady].mean()
    distance = GEOD.inv(frame["longitude"], frame["latitude"], tracks["longitude"], tracks["latitude"])[2]
    assert np.median(distance) < 40.0
    np.testing.assert_allclose(tracks["altitude"].to_numpy()[steady], 3000.0, atol=12.0)


def test_the_documented_columns_are_there_in_si_units():
    tracks = jink.track(made_up()[0])
    expected = ["target", "part", "time", "latitude", "longitude", "altitude", "x", "y", "z"]
    assert tracks.columns[: len(expected)] == expected
    for name in ("velocity_x", "acceleration_y", "speed", "course", "climb_rate", "turn_rate"):
        assert {name, f"{name}_sd"} <= set(tracks.columns), name
    late = [
        "manoeuvring",
        "manoeuvring_vertical",
        "segment",
        "status",
        "measured_x",
        "measured_y",
        "measured_z",
        "nis",
        "nis_dof",
        "row",
    ]
    assert tracks.columns[-len(late) :] == late
    assert tracks["time"].dtype == pl.Datetime("us", "UTC") and tracks["time"][1].timestamp() == 1.7e9 + 2.0
    probabilities = tracks.select(pl.sum_horizontal(pl.col("^probability_.*$"))).to_series()
    np.testing.assert_allclose(probabilities.to_numpy(), 1.0, atol=1e-9)
    assert not any(tracks[name].is_nan().any() for name, kind in tracks.schema.items() if kind == pl.Float64)


def test_the_filter_alone_uses_only_the_past():
    frame, _ = made_up()
    whole, half = (jink.track(f, sensor_sd="position=20,altitude=5") for f in (frame, frame.head(150)))
    np.testing.assert_allclose(half["speed"].to_numpy(), whole["speed"].to_numpy()[:150], rtol=1e-9)


def test_pandas_in_pandas_out_and_the_same_numbers():
    pandas = pytest.importorskip("pandas")
    frame, _ = made_up()
    native = pandas.DataFrame({name: frame[name].to_numpy() for name in frame.columns})
    native["t"] = pandas.to_datetime(native["t"], unit="s", utc=True)
    native.loc[5, "altitude_m"] = np.nan
    tracks = jink.track(native)
    assert isinstance(tracks, pandas.DataFrame) and str(tracks["time"].dtype).startswith("datetime64[")
    again = jink.track(frame.with_columns(altitude_m=pl.when(pl.arange(300) == 5).then(None).otherwise("altitude_m")))
    np.testing.assert_allclose(tracks["speed"], again["speed"].to_numpy(), rtol=1e-6)
    assert tracks["status"].iloc[50] == "updated" and str(tracks["time"].dt.tz) == "UTC"


def test_other_frames_come_back_as_they_went_in():
    pyarrow = pytest.importorskip("pyarrow")
    frame, _ = made_up()
    assert isinstance(jink.track(frame.lazy()), pl.LazyFrame)
    assert isinstance(jink.track(pyarrow.table(frame)), pyarrow.Table)
    with pytest.raises(InputError, match="data is a dict"):
        jink.track({"t": [1]})


def test_a_path_and_the_same_frame_give_the_same_tracks(tmp_path):
    frame, _ = made_up()
    path = tmp_path / "m.csv"
    frame.write_csv(path)
    from_path, from_frame = jink.track(path), jink.track(frame)
    assert from_path["file"].unique().to_list() == [str(path)]
    np.testing.assert_allclose(from_path["speed"].to_numpy(), from_frame["speed"].to_numpy(), rtol=1e-9)


def test_a_radar_measures_the_same_flight_in_range_azimuth_and_elevation():
    rng = np.random.default_rng(5)
    time = np.arange(200) * 4.0
    east, north, up = -40e3 + 180.0 * time, 30e3 + 60.0 * time, np.full(200, 8000.0)
    distance = np.sqrt(east**2 + north**2 + up**2) + rng.normal(0, 30.0, 200)
    azimuth = np.degrees(np.arctan2(east, north) + rng.normal(0, 1e-3, 200)) % 360
    elevation = np.degrees(np.arcsin(up / distance) + rng.normal(0, 1e-3, 200))
    plots = pl.DataFrame(
        {"id": "r", "t": time, "range_km": distance / 1e3, "azimuth_deg": azimuth, "elevation_deg": elevation}
    )
    tracks, _, summary = jink.track(plots, smooth=True, site=(48.0, 11.0, 500.0), details=True)
    speed = tracks["speed"].to_numpy()[20:180]
    np.testing.assert_allclose(speed, np.hypot(180.0, 60.0), rtol=0.1)
    np.testing.assert_allclose(tracks["x"].to_numpy()[20:180], east[20:180], atol=400.0)
    assert tracks["z"].to_numpy()[100] == pytest.approx(8000.0, abs=300.0)
    here = GEOD.inv(11.0, 48.0, tracks["longitude"][100], tracks["latitude"][100])
    assert here[2] == pytest.approx(np.hypot(east[100], north[100]), rel=0.01)
    noise = summary["noise"][0]
    assert noise["range_sd"] == pytest.approx(30.0, rel=0.4) and noise["azimuth_sd"] == pytest.approx(1e-3, rel=0.4)
    flat = jink.track(plots.drop("elevation_deg"), smooth=True)
    assert "z" not in flat.columns and "latitude" not in flat.columns


def test_x_and_y_in_plain_seconds_stay_plain():
    rng = np.random.default_rng(6)
    frame = pl.DataFrame(
        {
            "t": np.arange(100.0),
            "x": 10.0 * np.arange(100) + rng.normal(0, 1, 100),
            "y": rng.normal(0, 1, 100),
        }
    )
    tracks = jink.track(frame, kind="vehicle")
    assert tracks["time"].to_list() == list(range(100)) and "latitude" not in tracks.columns
    assert tracks["speed"].to_numpy()[50:].mean() == pytest.approx(10.0, rel=0.1)
    assert tracks["target"].unique().to_list() == ["0"]


def test_parts_without_altitude_are_two_dimensional_and_that_is_said():
    frame, _ = made_up()
    flat = frame.with_columns(target=pl.lit("flat"), altitude_m=None)
    tracks, _, summary = jink.track(pl.concat([frame, flat], how="vertical_relaxed"), details=True)
    assert tracks.filter(pl.col("target") == "flat")["z"].null_count() == 300
    assert tracks.filter(pl.col("target") == "m")["z"].null_count() == 0
    assert any("tracked in the plane" in note for note in summary["notes"])
    assert jink.track(flat)["speed"].to_numpy()[100] == pytest.approx(220.0, rel=0.1)


def test_a_part_whose_first_altitudes_are_missing_starts_all_the_same():
    frame, _ = made_up()
    late = frame.with_columns(altitude_m=pl.when(pl.arange(300) >= 40).then("altitude_m"))
    tracks = jink.track(late)
    assert (
        tracks["x"].null_count() == 0
        and tracks["altitude_sd" if "altitude_sd" in tracks.columns else "z_sd"][10] > 50.0
    )
    assert tracks["altitude"].to_numpy()[60] == pytest.approx(3000.0, abs=20.0)


def test_a_target_at_rest_has_no_turn_rate():
    rng = np.random.default_rng(8)
    frame = pl.DataFrame({"t": np.arange(200.0), "x": rng.normal(0, 3.0, 200), "y": rng.normal(0, 3.0, 200)})
    tracks = jink.track(frame, kind="person", smooth=True)
    assert tracks["turn_rate"].null_count() > 150 and tracks["turn_rate_sd"].null_count() > 150
    assert tracks["x"].null_count() == 0 and tracks["speed"].null_count() == 0


def test_stated_accuracy_sets_the_noise():
    frame, _ = made_up(sd=20.0)
    stated = jink.track(frame.with_columns(nacp=pl.lit(6)))
    assert stated["x_sd"].to_numpy()[200:].mean() > 2.5 * jink.track(frame)["x_sd"].to_numpy()[200:].mean()


def test_gross_outliers_are_gated_by_the_filter_not_cleaned_away():
    frame, _ = made_up()
    wild = frame.with_columns(
        latitude=pl.when(pl.arange(300).is_in([50, 200])).then(pl.col("latitude") + 0.5).otherwise("latitude")
    )
    tracks = jink.track(wild)
    assert tracks["status"].to_list()[50] == "gated" and tracks["status"].to_list()[200] == "gated"
    assert tracks["speed"].max() < 400.0


def test_rejected_rows_are_told_in_a_warning_or_returned():
    frame, _ = made_up(count=50)
    bad = pl.concat([frame, frame.head(1).with_columns(latitude=pl.lit(99.0))])
    with pytest.warns(UserWarning, match="1 of 51 rows are in no track .latitude beyond"):
        tracks = jink.track(bad)
    again, rejected, summary = jink.track(bad, details=True)
    assert tracks.equals(again) and rejected["row"].to_list() == [50]
    assert summary["rows"] == 51 == summary["accepted"] + sum(summary["rejected"].values())


def test_a_filter_of_ones_own_brings_its_own_noise():
    frame, _ = made_up()
    own = jink.Kalman(jink.ConstantVelocity(acceleration_sd=2.0), jink.Position(sd=20.0, axes=2))
    tracks = jink.track(frame, filter=own)
    assert "z" not in tracks.columns and "turn_rate" not in tracks.columns and tracks["manoeuvring"].is_null().all()
    loose = jink.track(frame, filter=own, sensor_sd=200.0)
    assert loose["x_sd"].to_numpy()[100] > 3 * tracks["x_sd"].to_numpy()[100]
    radar = jink.Kalman(jink.ConstantVelocity(acceleration_sd=2.0), jink.Polar(range_sd=20.0, azimuth_sd=1e-3))
    with pytest.raises(InputError, match="measures range, azimuth; the data has x, y"):
        jink.track(frame, filter=radar)
    for name in ("cv", "ca", "singer"):
        assert jink.track(frame, filter=name)["speed"].to_numpy()[100] == pytest.approx(220.0, rel=0.1)


def test_real_flights_look_like_flights():
    tracks, rejected, summary = jink.track(FLIGHTS, smooth=True, details=True)
    assert tracks.height + rejected.height == 41_855 and tracks["target"].n_unique() == 25
    flying = tracks.filter(pl.col("status") == "updated")
    speed = flying["speed"]
    assert 100 < speed.median() < 200 and speed.quantile(0.999) < 300.0
    assert flying["turn_rate"].abs().quantile(0.99) < np.radians(4.0)
    assert flying["climb_rate"].abs().quantile(0.99) < 30.0
    lost = summary["status"].get("gated", 0) + summary["status"].get("restarted", 0)
    assert lost < 0.005 * tracks.height
    assert 0.7 < summary["consistency"]["inside_95"] < 0.99
    noise = summary["noise"][0]
    assert 1.0 < noise["position_sd"] < 3.0 and 0.1 < noise["time_sd"] < 0.3
    turning = tracks.filter(pl.col("manoeuvring") > 0.6)
    assert 0.05 < turning.height / tracks.height < 0.6


STRANGE = {
    "nothing": pl.Series([None] * 12),
    "text": pl.Series(["a", "b", None] * 4),
    "numbers as text": pl.Series([str(k) for k in range(12)]),
    "wild numbers": pl.Series([float("nan"), float("inf"), -1e308, 1e308] * 3),
    "flags": pl.Series([True] * 12),
    "lists": pl.Series([[1, 2]] * 12),
    "records": pl.Series([{"a": 1}] * 12),
    "bytes": pl.Series([b"\xff"] * 12),
    "dates": pl.Series([date(2024, 1, day + 1) for day in range(12)]),
    "durations": pl.Series([timedelta(seconds=k) for k in range(12)]),
    "categories": pl.Series(["a", "b", "a"] * 4, dtype=pl.Categorical),
}


@pytest.mark.parametrize("values", STRANGE.values(), ids=STRANGE)
@pytest.mark.parametrize(
    "position", [("lat", "lon", "altitude_m"), ("x", "y", "z"), ("range", "azimuth_rad", "height")]
)
def test_a_column_of_any_type_is_used_or_refused_in_words(values, position):
    usual = {
        "id": ["a"] * 12,
        "t": np.arange(12.0),
        "speed": np.full(12, 5.0),
        "nacp": [8] * 12,
        "sensor": ["s"] * 12,
    }
    usual |= {name: 1.0 + 0.001 * np.arange(12.0) for name in position}
    for name in usual:
        try:
            tracks, rejected, _ = jink.track(pl.DataFrame(usual | {name: values}), details=True)
        except InputError as error:
            assert len(str(error)) > 20
        else:
            assert sorted(tracks["row"].to_list() + rejected["row"].to_list()) == list(range(12)), name


ROWS = st.lists(
    st.tuples(
        st.sampled_from(["a", "b", "", None]),
        st.one_of(st.integers(0, 60), st.sampled_from([None, "x"])),
        st.one_of(st.floats(40, 40.01), st.sampled_from([None, 0.0, 91.0, float("nan")])),
        st.one_of(st.floats(5, 5.01), st.sampled_from([None, 0.0, 400.0])),
        st.one_of(st.floats(0, 1000), st.sampled_from([None, "high"])),
    ),
    min_size=1,
    max_size=60,
)


@settings(max_examples=40)
@given(ROWS, st.sampled_from(["frame", "csv", "json", "jsonl"]), st.integers(1, 5), st.booleans())
def test_every_input_row_is_in_a_track_or_among_the_rejected(tmp_path_factory, rows, how, least, smooth):
    table = [dict(zip(("id", "t", "lat", "lon", "alt"), row, strict=True)) for row in rows]
    data = _stored(table, how, tmp_path_factory)
    try:
        tracks, rejected, summary = jink.track(data, min_points=least, smooth=smooth, kind="person", details=True)
    except InputError:
        return
    found = tracks["row"].to_list() + rejected["row"].to_list()
    assert sorted(found) == list(range(len(rows))) and summary["rows"] == len(rows)
    assert rejected["reason"].null_count() == 0
    known = tracks.filter(pl.col("status") != "none")
    assert known["x"].null_count() == 0 and (known["x_sd"] >= 0).all()


def _stored(table, how, tmp_path_factory):
    if how == "frame":
        return pl.DataFrame([{k: None if v is None else str(v) for k, v in row.items()} for row in table])
    path = tmp_path_factory.mktemp("rows") / f"rows.{how}"
    if how == "csv":
        path.write_text(pl.DataFrame(table, strict=False, infer_schema_length=None).write_csv())
    elif how == "json":
        path.write_text(json.dumps(table))
    else:
        buffer = io.StringIO()
        buffer.writelines(json.dumps(row) + "\n" for row in table)
        path.write_text(buffer.getvalue())
    return path
