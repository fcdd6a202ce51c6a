"""Filters in a race with a lag, and filter files with the noise of the data."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import jink
from jink.compare.race import compare
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS


def short(name: str, scans: int, **changes):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=scans), **changes)


@pytest.mark.parametrize(("lag", "words"), [(1, "1 scan"), ("2s", "2 s")])
def test_a_lag_races_beside_the_filter_itself(lag, words):
    race = compare(short("random-turns", 60), "facs", runs=30, lag=lag)
    late = f"imm, lag {words}"
    assert late in race.entrants and f"raw, lag {words}" not in race.entrants
    now, then = race.figures("imm"), race.figures(late)
    assert then["position_rmse"].value < 0.9 * now["position_rmse"].value
    assert then["velocity_rmse"].value < 0.9 * now["velocity_rmse"].value
    # what is measured later says nothing of how a measurement was predicted
    assert then["nis"].value == pytest.approx(now["nis"].value)


def test_a_filter_that_cannot_be_smoothed_says_why():
    race = compare(short("choi-2001-4", 20), "variable-dimension", runs=5, lag=1)
    assert "cannot be smoothed" in race.skipped["variable-dimension, lag 1 scan"]


def test_predictions_have_no_lag(tmp_path):
    path = tmp_path / "seen.csv"
    path.write_text("target,time,x,y\n" + "".join(f"A,{k},{10 * k},{k % 3}\n" for k in range(60)))
    with pytest.raises(InputError, match="without truth"):
        compare(str(path), lag=1)


def test_a_filter_file_gets_the_noise_of_the_data(tmp_path):
    path, scenario = str(tmp_path / "far.json"), short("random-turns", 60)
    jink.default_filter("fighter", jink.Position(sd=500.0)).save(path)
    race = compare(scenario, [path], runs=20)
    assert "which it is given" in race.entrants[path].note
    own = jink.default_filter("fighter", scenario.observation.sensor)
    same = compare(scenario, {"own": own}, runs=20)
    assert race.figures(path)["position_rmse"].value == pytest.approx(
        same.figures("own")["position_rmse"].value, rel=1e-6
    )
    # fitted on such data, its noise is what was found
    body = json.loads((tmp_path / "far.json").read_text())
    (tmp_path / "far.json").write_text(
        json.dumps(body | {"fitted": {"scenario": "random-turns", "seed": 9, "runs": 5}})
    )
    assert "assumes" in compare(scenario, [path], runs=20).entrants[path].note


def test_a_filter_of_one_axis_is_refused_noises_that_differ(tmp_path):
    path = tmp_path / "one.json"
    jink.Kalman(jink.ConstantVelocity(acceleration_sd=5.0), jink.Position(sd=50.0, axes=1)).save(path)
    seen = short("random-turns", 40).seen_by(jink.Position(sd=(20.0, 60.0)))
    with pytest.raises(InputError, match="one measurement noise"):
        compare(seen, [str(path)], runs=2)
    seen = short("random-turns", 40).seen_by(jink.Position(sd=20.0))
    assert "which it is given" in compare(seen, [str(path)], runs=2).entrants[str(path)].note
