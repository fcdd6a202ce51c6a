"""What cannot be true is said, with its likely reason and what mends it; what is true is not suspected."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal
from typer.testing import CliRunner

import jink
from jink.catalogue.targets import KINDS
from jink.cli.main import app
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS
from jink.tracking import noise_findings, plausibility, seen
from jink.tracking.stretches import pieces

COUNT = 120


def straight(speed=200.0, sd=20.0, step=4.0, seed=0, start=(0.0, 0.0), course=0.3, target="A"):
    """A straight flight in x, y (m); time in seconds."""
    rng = np.random.default_rng(seed)
    t = step * np.arange(COUNT)
    x, y = start[0] + speed * t * np.sin(course), start[1] + speed * t * np.cos(course)
    return pl.DataFrame(
        {"target": target, "time": t, "x": x + rng.normal(0, sd, COUNT), "y": y + rng.normal(0, sd, COUNT)}
    )


def codes(data, **more):
    found = jink.track(data, details=True, **more).summary["warnings"]
    return {warning["code"]: warning for warning in found}


def test_a_flight_of_its_kind_raises_nothing():
    assert codes(straight()) == {}


@pytest.mark.parametrize(
    "name", ["lee-2003", "benchmark-2", "benchmark-6", "terminal-area", "vessel", "drone", "weave"]
)
def test_simulated_targets_of_the_right_kind_raise_nothing(name, tmp_path):
    path = tmp_path / "plots.parquet"
    assert CliRunner().invoke(app, ["simulate", name, "-o", str(path), "--runs", "5"]).exit_code == 0
    assert codes(str(path), kind=SCENARIOS[name].kind) == {}


@pytest.mark.parametrize("rows", [[0, 1, 2], [0, 1, 2, 0]], ids=["together", "apart"])
def test_a_long_target_has_the_figures_of_a_group(rows, monkeypatch):
    tracks = jink.track(pl.concat([straight(target=name, seed=k) for k, name in enumerate("abc")]))
    parts = [tracks[: COUNT - 7], tracks[COUNT - 7 : 2 * COUNT + 7], tracks[2 * COUNT + 7 :]]
    table = pl.concat([parts[k] for k in rows])
    expected = seen._by_target(table, KINDS["aircraft"])
    monkeypatch.setattr(seen, "pieces", partial(pieces, most=COUNT // 2))
    # a sum may round otherwise
    assert_frame_equal(seen._by_target(table, KINDS["aircraft"]), expected, rel_tol=1e-15, abs_tol=0.0)


def test_too_fast_for_its_kind():
    found = codes(straight(), kind="vessel")["too_fast"]
    assert found["targets"] == ["A"] and not found["fatal"]
    assert "--kind aircraft" in found["mend"]


def test_nothing_moves_at_a_hundred_times_the_speed():
    with pytest.raises(InputError, match=r"no track is plausible.*\n.*wrong unit"):
        jink.track(straight(speed=2e5))
    assert codes(straight(speed=2e5), check_coordinates=False)["too_fast"]["fatal"]


def test_times_in_milliseconds_are_suggested_where_they_would_make_a_flight():
    milliseconds = straight().with_columns(pl.col("time") * 1000.0)
    assert "--time-unit ms" in codes(milliseconds)["too_slow"]["mend"]
    assert codes(milliseconds, time_unit="ms") == {}
    assert "milliseconds" not in codes(straight(speed=1.4, sd=3.0))["too_slow"]["likely"]


def test_kilometres_are_suggested_where_they_would_make_a_flight():
    kilometres = straight().with_columns(pl.col("x", "y") / 1000.0)
    found = codes(kilometres)["too_slow"]
    assert "kilometres" in found["likely"] and "--columns x_km=NAME,y_km=NAME" in found["mend"]
    assert "too_slow" not in codes(kilometres, columns={"x_km": "x", "y_km": "y"})


def test_names_of_ships_are_noted_where_the_filter_is_for_aircraft():
    ships = straight(speed=8.0).rename({straight().columns[0]: "MMSI"})
    notes = {kind: jink.track(ships, kind=kind, details=True).summary["notes"] for kind in ("aircraft", "vessel")}
    assert [any("--kind vessel" in note for note in each) for each in notes.values()] == [True, False]


def test_a_walk_is_no_flight():
    assert "--kind person" in codes(straight(speed=1.4, sd=3.0))["too_slow"]["mend"]
    assert codes(straight(speed=1.4, sd=3.0), kind="person") == {}


def two_ships():
    """Two ships 40 km apart that send one identifier."""
    both = [
        straight(speed=v, sd=3.0, step=20.0, seed=i, start=(4e4 * i, 0.0), target="111000004")
        for i, v in enumerate((2.0, 6.0))
    ]
    return pl.concat([both[0], both[1].with_columns(pl.col("time") + 7.0)]).sort("time")


def test_two_ships_under_one_name():
    found = codes(two_ships(), kind="vessel", check_coordinates=False)["several_targets"]
    assert found["targets"] == ["111000004"] and "2 targets under one name" in found["likely"]


def test_one_such_target_among_others_is_a_warning_alone():
    others = [straight(speed=7.0, sd=3.0, step=20.0, seed=k, target=f"S{k}") for k in range(3)]
    found = codes(pl.concat([two_ships(), *others]).sort("target", "time"), kind="vessel")
    assert found["several_targets"]["targets"] == ["111000004"]


def test_positions_where_the_track_cannot_be():
    data = straight()
    far = np.where(np.arange(COUNT) % 4 == 1, 3e4 * (-1.0) ** np.arange(COUNT) * np.arange(COUNT), 0.0)
    data = data.with_columns(pl.col("x") + far)
    found = codes(data, sensor_sd=20.0)
    assert found["rejected"]["count"] == 1


def test_positions_that_never_change():
    data = straight().with_columns(x=pl.lit(16.4), y=pl.lit(39.9))
    assert "longitude_deg" in codes(data, drop_stale=False)["never_moves"]["mend"]


def test_noise_of_a_millimetre():
    assert codes(straight(speed=1.0, sd=1e-6, step=1.0), kind="person")["noise_tiny"]["likely"].startswith(
        "positions that"
    )


def test_dates_before_satellites():
    data = straight().with_columns(pl.from_epoch(pl.col("time").cast(pl.Int64), "s").alias("time"))
    assert "1970-01-01" in codes(data)["dates"]["what"]


def test_a_clock_that_lost_its_minutes():
    data = straight(speed=5.0, step=1800.0)
    assert "exactly 1800 s" in codes(data, kind="vessel")["coarse_step"]["what"]


def test_stamps_that_several_positions_share():
    coarse = straight(step=1.0).with_columns(time=(pl.col("time") / 5.0).floor() * 5.0)
    assert "80% of the rows have the time of another row" in codes(coarse)["shared_times"]["message"]
    cleaning = jink.track(coarse, details=True).summary["cleaning"]
    assert cleaning["duplicate_times"] == cleaning["shared_times"] == 96
    # the same position again, as of a second receiver, is no fault of the clock
    again = straight(step=1.0)
    assert codes(pl.concat([again, again])) == {}
    assert jink.track(pl.concat([again, again]), details=True).summary["cleaning"]["shared_times"] == 0


def test_noise_set_too_small_and_too_large():
    small = codes(straight(), sensor_sd=1.0)
    assert {"inconsistent", "rejected"} & small.keys()
    large = codes(straight(), sensor_sd=500.0)
    assert "too large" in large["inconsistent"]["likely"]


@pytest.mark.parametrize("turns", [False, True])
def test_a_variance_in_place_of_a_standard_deviation(turns):
    """Targets that turn keep the NIS above what noise alone would be, and positions were 500 m off without a word."""
    rng, time = np.random.default_rng(0), np.arange(150) * 4.0
    course = np.cumsum(np.where((np.arange(150) % 40 < 12) & turns, np.radians(6.0), 0.0))
    path = np.cumsum(720.0 * np.column_stack([np.sin(course), np.cos(course)]), axis=0)
    seen = path + rng.normal(0.0, 40.0, path.shape)
    table = pl.DataFrame({"target": "a", "time": time, "x": seen[:, 0], "y": seen[:, 1]})
    assert not codes(table, sensor_sd=40.0).keys() & {"noise_given", "inconsistent"}
    found = codes(table, sensor_sd=1600.0)["noise_given"]
    assert "variance" in found["likely"]
    sd = found["mend"].split()[1]
    assert 25.0 < float(sd.removeprefix("position=")) < 60.0
    assert "noise_given" not in codes(table, sensor_sd=sd)
    polar = table.select(
        "target", "time", range=(pl.col("x") ** 2 + pl.col("y") ** 2).sqrt(), azimuth=pl.arctan2("x", "y")
    )
    assert "variance" in codes(polar.slice(5), sensor_sd={"range": 1600.0})["noise_given"]["likely"]


def test_the_command_says_it_and_keeps_json_whole(tmp_path):
    path, out = tmp_path / "p.csv", tmp_path / "t.csv"
    straight().write_csv(path)
    done = CliRunner().invoke(app, ["track", str(path), "--kind", "vessel", "-o", str(out)])
    assert done.exit_code == 0 and "Warning" in done.output
    done = CliRunner().invoke(app, ["track", str(path), "--kind", "vessel", "--json", "--quiet"])
    assert json.loads(done.output)["warnings"][0]["code"] == "too_fast"


def test_the_command_refuses_what_cannot_be(tmp_path):
    path, out = tmp_path / "p.csv", tmp_path / "t.csv"
    two_ships().write_csv(path)
    done = CliRunner().invoke(app, ["track", str(path), "--kind", "vessel", "-o", str(out)])
    assert done.exit_code == 2 and not out.exists()
    assert "2 targets under one name" in done.output and "--columns target=NAME" in done.output
    done = CliRunner().invoke(app, ["track", str(path), "--kind", "vessel", "-o", str(out), "--no-check"])
    assert done.exit_code == 0 and out.exists()


def test_columns_that_are_not_used_are_listed():
    data = straight().with_columns(colour=pl.lit("red"))
    assert jink.track(data, details=True).summary["unused_columns"] == ["colour"]


def test_every_code_is_explained():
    source = "".join(Path(each.__file__).read_text(encoding="utf-8") for each in (plausibility, noise_findings))
    page = (Path(__file__).parents[2] / "docs/warnings.md").read_text(encoding="utf-8")
    named = set(re.findall(r'"([a-z]+(?:_[a-z]+)*)"(?= if small| if several|,\n +f?")', source)) | {
        "noise_huge",
        "rejected",
    }
    assert {"too_fast", "dates", "several_targets", "noise_tiny"} <= named
    assert [code for code in named if f"`{code}`" not in page] == []
