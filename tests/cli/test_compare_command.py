"""`jink compare` from the command line, and races on files without truth."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import jink
from jink.cli.compare import CompareRequest, run_compare
from jink.compare.race import ALWAYS, ENTRANTS, compare
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS


def short(name: str, scans: int, **changes):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=scans), **changes)


def ask(**changes) -> int:
    return run_compare(CompareRequest(**{"scenario": "choi-2001-1", "filters": "", "runs": 20, "seed": 1, **changes}))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"scenario": "lee2003"}, "did you mean lee-2003?"),
        ({"scenario": "none.csv"}, "there is no file none.csv"),
        ({"scenario": str(Path(__file__).parent)}, "is a folder, but none that jink track wrote"),
        ({"filters": "singer,immm"}, "did you mean imm"),
        ({"filters": "none.json"}, "there is no filter file none.json"),
        ({"runs": 0}, "--runs is 0"),
        ({"seed": -1}, "--seed is -1"),
        ({"json": "/nowhere/o.json"}, "a folder that exists"),
    ],
)
def test_wrong_requests_leave_with_2_and_write_nothing(changes, said, capsys, tmp_path):
    changes = {"json": str(tmp_path / "o.json"), **changes}
    assert ask(**changes) == 2
    out, err = capsys.readouterr()
    assert said in err and not out and not list(tmp_path.iterdir())
    if "did you mean" in said:
        assert "kalman-cv" in err or "choi-2001-1" in err


def test_a_seed_that_is_no_integer():
    with pytest.raises(InputError, match=r"seed is 1\.5"):
        compare("lee-2003", seed=1.5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="runs is True"):
        compare("lee-2003", runs=True)


def test_json_has_the_promised_form(tmp_path, capsys):
    path = tmp_path / "o.json"
    assert ask(filters="all", json=str(path)) == 0
    body = json.loads(path.read_text())
    assert (body["scenario"], body["runs"], body["seed"]) == ("choi-2001-1", 20, 1)
    assert set(ALWAYS) <= set(body["filters"]) <= set(ENTRANTS)
    assert set(body["filters"]["imm"]) >= {
        "position_rmse",
        "velocity_rmse",
        "acceleration_rmse",
        "normalised_position",
        "normalised_velocity",
        "nees_inside",
        "nis_inside",
        "lost",
        "us_per_update",
    }
    assert all(set(f) == {"value", "se"} for filter in body["filters"].values() for f in filter.values())
    assert body["comparisons"]["singer"]["raw"]["position_rmse"]["verdict"] in (
        "better",
        "worse",
        "undecided",
    )
    table = capsys.readouterr().out
    assert "kalman-cv *" in table and "fitted on this scenario" in table and "without near-optimal" in table


@pytest.mark.parametrize("runs", [24, 2])
def test_a_file_without_truth_is_scored_on_held_out_predictions(runs, tmp_path, capsys):
    from jink.scenarios.table import simulation_table

    path = tmp_path / "seen.csv"
    s = short("random-turns", 80).simulate(runs, 1)
    simulation_table(s).select("target", "time", "x", "y").write_csv(path)
    assert ask(scenario=str(path), filters="imm-cv-ct", json=str(tmp_path / "o.json"), kind="fighter") == 0
    body = json.loads((tmp_path / "o.json").read_text())
    assert set(body["filters"]) == {"raw", "kalman-cv", "kalman-ca", "imm", "imm-corrected", "imm-cv-ct"}
    assert set(body["filters"]["imm"]) == {
        "prediction_rmse",
        "prediction_score",
        "nis",
        "nis_inside",
        "gated",
        "us_per_update",
    }
    verdict = body["comparisons"]["kalman-cv"]["raw"]["prediction_rmse"]["verdict"]
    assert verdict == "better" and body["skipped"]["clairvoyant"] == "needs the truth"
    assert ("other targets" in body["about"]["kalman-cv"]["fitted_on_this_scenario"]) == (runs == 24)
    assert "prediction m" in capsys.readouterr().out


def test_predictions_are_those_of_the_state_before(tmp_path):
    """With constant velocity the prediction is p + T v of the row before."""
    from jink.compare.recorded import predictions, read
    from jink.scenarios.table import simulation_table

    path = tmp_path / "seen.csv"
    simulation_table(short("random-turns", 30).simulate(3, 1)).select("target", "time", "x", "y").write_csv(path)
    recording = read(str(path), "fighter", 0)
    tracks = recording.tracks
    assert (tracks.rows, recording.left_out) == (90, 0)
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=9.0), jink.Position(sd=50.0))
    x = filter.filter(tracks.time, tracks.z, offsets=tracks.offsets).x
    ahead = x[3:29, [0, 2]] + x[3:29, [1, 3]] * np.diff(tracks.time)[3:29, None]
    assert_allclose(predictions(filter, tracks)[4:30], ahead, rtol=1e-9)


@pytest.mark.parametrize("name", ["vsmm-ds", "fuzzy-imm", "input-estimation", "nnvsmm"])
def test_filters_that_count_rows_predict_live(name, tmp_path):
    """A row without a measurement would move on what is alive, or leave the last residual: predicted target by target
    instead.
    """
    from jink.catalogue.purpose import Purpose
    from jink.catalogue.registry import FILTERS
    from jink.compare.recorded import predictions, read
    from jink.scenarios.table import simulation_table

    path = tmp_path / "seen.csv"
    table = simulation_table(short("random-turns", 30).simulate(3, 1)).select("target", "time", "x", "y")
    table.filter((table["target"] != table["target"][0]) | (table["time"] < 20)).write_csv(path)  # one ends early
    recording = read(str(path), "fighter", 0)
    tracks = recording.tracks
    filter = FILTERS[name](Purpose(sensor=recording.sensor, kind="fighter")).filter
    assert filter.counts_rows
    want = []
    for begin, end in itertools.pairwise(tracks.offsets):
        live = filter.start()
        for k in range(begin, end):
            want.append(live.predict(tracks.time[k]).x[[0, filter.components.index("py")]])
            R = None if tracks.covariance is None else tracks.covariance[k]
            live.update(tracks.time[k], tracks.z[k], covariance=R)
    got = predictions(filter, tracks)
    assert len(np.unique(np.diff(tracks.offsets))) == 2 and np.isfinite(got).all(axis=1).sum() > 60
    assert_allclose(got, want, rtol=1e-9, atol=1e-6)


def test_positions_that_never_change_are_named(tmp_path, capsys):
    path = tmp_path / "still.csv"
    path.write_text("target,time_s,x_m,y_m\n" + "".join(f"A,{4 * k},5,6\n" for k in range(40)))
    assert ask(scenario=str(path)) == 2
    assert "the positions never change" in capsys.readouterr().err


def test_a_file_without_the_needed_columns(tmp_path, capsys):
    path = tmp_path / "f.csv"
    path.write_text("a,b\n1,2\n")
    assert ask(scenario=str(path)) == 2
    assert "latitude and longitude" in capsys.readouterr().err
