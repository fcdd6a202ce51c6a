"""Columns that go through to the output, and rows at even times."""

import json

import numpy as np
import polars as pl
import pytest

import jink
from jink.cli.main import app
from jink.io.errors import InputError


def _walk(step=2.0, count=80, gap=(40, 50)):
    """A car at 12 m/s with positions every two seconds, none for a while, and a name beside its number."""
    rng = np.random.default_rng(2)
    time = step * np.arange(count) + 0.4
    kept = ~((np.arange(count) >= gap[0]) & (np.arange(count) < gap[1]))
    table = pl.DataFrame(
        {
            "icao24": "abc123",
            "callsign": "CAR1",
            "time": time,
            "x": 12.0 * time + 3.0 * rng.normal(size=count),
            "y": 3.0 * rng.normal(size=count),
            "speed": "quick",
            "note": np.arange(count),
        }
    )
    return table.filter(pl.Series(kept))


def test_columns_that_say_who_a_target_is_go_through():
    found = jink.track(_walk(), kind="vehicle")
    assert found["callsign"].to_list() == ["CAR1"] * found.height
    assert "note" not in found.columns


def test_the_columns_that_are_asked_for_go_through_under_names_that_are_free():
    table = _walk()
    found = jink.track(table, kind="vehicle", keep=["note", "speed"])
    assert found["note"].to_list() == table["note"].gather(found["row"]).to_list()
    assert found["input_speed"].to_list() == ["quick"] * found.height
    assert "callsign" not in found.columns
    assert jink.track(table, kind="vehicle", keep=[]).columns == [c for c in found.columns if c[:2] not in ("no", "in")]
    with pytest.raises(InputError, match="no column 'notes' in the input; did you mean 'note'"):
        jink.track(table, kind="vehicle", keep=["notes"])


def test_kept_columns_of_files_that_differ(tmp_path):
    _walk().write_csv(tmp_path / "a.csv")
    _walk().with_columns(note=pl.lit("text"), icao24=pl.lit("other")).write_csv(tmp_path / "b.csv")
    _walk().drop("note").with_columns(icao24=pl.lit("third")).write_csv(tmp_path / "c.csv")
    found = jink.track([tmp_path / f"{name}.csv" for name in "abc"], kind="vehicle", keep=["note"])
    by = {name: rows["note"].to_list() for (name,), rows in found.group_by("target")}
    assert by["abc123"][0] == "0"
    assert set(by["other"]) == {"text"}
    assert set(by["third"]) == {None}


@pytest.mark.parametrize("smooth", [False, True])
def test_rows_at_even_times_bridge_a_gap_with_an_sd_that_grows(smooth):
    table = _walk()
    found = jink.track(table, kind="vehicle", every="1s", smooth=smooth)
    # from 0.4 s to 158.4 s
    assert found["time"].to_list() == [float(k) for k in range(1, 159)]
    assert found["row"].null_count() == found.height
    error = np.abs(found["x"].to_numpy() - 12.0 * found["time"].to_numpy())
    late = found["time"].to_numpy() > 10.0
    assert (error[late] < 4.0 * found["x_sd"].to_numpy()[late]).all()
    gap = found.filter(pl.col("time").is_between(79.0, 100.0))
    assert (gap["status"] == "predicted").all()
    sd = gap["x_sd"].to_numpy()
    assert sd.max() > 2.0 * sd[0]
    # filtered it grows to the end of the gap; smoothed it is widest in the middle
    assert (sd.argmax() in range(5, 17)) if smooth else (np.diff(sd) > 0).all()


def test_even_times_that_are_measured_are_the_measured_rows():
    table = _walk().with_columns(pl.col("time") - 0.4)
    plain, even = jink.track(table, kind="vehicle"), jink.track(table, kind="vehicle", every=2)
    rows = even.filter(pl.col("row").is_not_null())
    assert rows.height == plain.height
    assert even.height == 80
    # In the gap the modes mix at every row, and each mixing replaces a mixture by its first two moments. So the first
    # rows after it differ by some tenths of an sd (.55 here); before it nothing differs, and 20 s after it little does.
    difference = np.abs(rows["x"] - plain["x"]).to_numpy() / plain["x_sd"].to_numpy()
    time = plain["time"].to_numpy()
    assert difference[time < 80.0].max() < 1e-9
    assert difference.max() < 1.0
    assert difference[time > 125.0].max() < 0.01


def test_a_filter_that_counts_rows_takes_no_rows_between():
    with pytest.raises(InputError, match="counts rows, so rows between"):
        jink.track(_walk(), kind="vehicle", filter="fuzzy-imm", every="1s")


@pytest.mark.parametrize("name", ["kalman-cv", "two-stage", "aimm3", "singer", "csaf", "kalman-ca"])
def test_noise_that_belongs_to_a_step_is_named(name):
    """Rows between the measurements make other estimates of such a filter, silently before."""
    found = jink.track(_walk(), kind="vehicle", filter=name, every="200ms", details=True)
    noted = any("noise of this filter is that of a step" in note for note in found.summary["notes"])
    assert noted == (name in ("kalman-cv", "two-stage", "aimm3"))
    plain = jink.track(_walk(), kind="vehicle", filter=name).join(found.tracks, on="time", suffix="_even")
    differs = ((plain["x"] - plain["x_even"]).abs() / plain["x_sd"]).head(20).max()
    assert (differs > 0.01) == noted


def test_even_times_of_places_on_the_map():
    time = pl.datetime_range(pl.datetime(2024, 5, 1), pl.datetime(2024, 5, 1, 0, 10), "5s", eager=True, time_zone="UTC")
    seconds = 5.0 * np.arange(time.len())
    flight = pl.DataFrame(
        {"icao24": "a", "time": time, "latitude": 48.0 + 0.002 * seconds, "longitude": 11.0, "altitude_m": 3000.0}
    )
    found = jink.track(flight, every="1s", smooth=True)
    assert found.height == 601
    at = (found["time"] - found["time"][0]).dt.total_seconds().to_numpy()
    assert np.abs(found["latitude"].to_numpy() - 48.0 - 0.002 * at).max() < 1e-4


@pytest.mark.parametrize("every", ["0s", "-1", "soon", "1e-9", "3 fortnights", "nan", "inf"])
def test_times_that_cannot_be(every):
    with pytest.raises(InputError, match="every is"):
        jink.track(_walk(), kind="vehicle", every=every)


def test_both_at_the_command_line(tmp_path, capsys):
    _walk().write_csv(tmp_path / "car.csv")
    out = tmp_path / "tracks.csv"
    with pytest.raises(SystemExit) as ended:
        given = ["--kind", "vehicle", "--keep", "note", "--every", "500ms", "-o", str(out), "--json"]
        app(["track", str(tmp_path / "car.csv"), *given])
    assert ended.value.code in (0, None)
    assert json.loads(capsys.readouterr().out)["every_seconds"] == 0.5
    found = pl.read_csv(out)
    assert set(np.round(np.diff(found["time"]), 6)) == {0.5}
    assert found["note"].is_not_null().all()


def test_a_column_of_row_numbers_is_not_kept_and_it_is_said_why(tmp_path):
    table = pl.DataFrame({"row": range(9, 19), "time": range(10), "x": np.arange(10.0), "y": 0.0})
    table.write_csv(tmp_path / "x.csv")
    for data in (table, tmp_path / "x.csv"):
        with pytest.raises(InputError, match="a column named 'row' cannot go along"):
            jink.track(data, keep=["row"])
