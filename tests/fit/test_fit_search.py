"""jink fit --search: candidates fitted side by side, ranked on data held out, the best explained, within a budget."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import jink
from jink.catalogue.purpose import Purpose
from jink.cli.fit import FitRequest, run_fit
from jink.fit.fitting import chosen_objective, training_data
from jink.fit.search import CANDIDATES, search
from jink.io.errors import InputError

FLIGHTS = str(Path(__file__).resolve().parents[2] / "examples" / "flights.parquet")


def prepared(name, runs=20, check_runs=60):
    training = training_data(name, runs=runs, check_runs=check_runs, seed=0, kind="aircraft", columns=None, truth=None)
    return training, chosen_objective(None, training, 1)


@pytest.fixture(scope="module")
def turns():
    training, objective = prepared("random-turns")
    return search(training, objective, names=["cv", "ca", "ct", "cv+ca", "cv+ct"], workers=2)


def test_the_best_on_held_out_data_comes_first(turns):
    scores = [ranked.score for ranked in turns.ranked]
    assert scores == sorted(scores)
    assert turns.ranked[0].name == "cv+ct"
    assert not turns.partial
    best = turns.ranked[0].figures["position_rmse"]
    assert best == pytest.approx(turns.fit.race.figure("fitted", "position_rmse").value)
    for ranked in turns.ranked[1:]:
        behind = ranked.behind["position_rmse"].difference
        assert behind == pytest.approx(ranked.figures["position_rmse"] - best)


def test_the_best_is_explained_by_what_its_parts_gain(turns):
    said = " ".join(turns.explanation)
    assert "cv+ct is the best of 5" in said
    assert "Without turns at a rate of their own the best is cv+ca, worse" in said
    assert "Without more than one mode the best is ct, worse" in said
    json.dumps(turns.as_dict(), allow_nan=False)


def test_processes_change_nothing(turns):
    training, objective = prepared("random-turns")
    alone = search(training, objective, names=["cv+ct", "cv"], workers=1)
    for ranked in alone.ranked:
        other = next(r for r in turns.ranked if r.name == ranked.name)
        assert ranked.training == other.training
        assert ranked.figures == other.figures


def test_what_does_as_well_with_less_is_the_simpler_choice():
    """On straight lines a second mode buys nothing."""
    training, objective = prepared("choi-2001-1", runs=30, check_runs=80)
    found = search(training, objective, names=["cv", "cv+ca"])
    if found.ranked[0].name == "cv+ca":
        assert any("cv is not told apart from it" in line for line in found.explanation)
    cv, ca = (next(r for r in found.ranked if r.name == name) for name in ("cv", "cv+ca"))
    assert cv.figures["position_rmse"] == pytest.approx(ca.figures["position_rmse"], rel=0.02)


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_every_candidate_can_be_made(axes):
    """For one axis all but those that turn; each filters a straight line."""
    time_, z = np.arange(30.0), np.outer(np.arange(30.0), np.full(axes, 100.0))
    for name, candidate in CANDIDATES.items():
        try:
            filter = candidate.made(Purpose(sensor=jink.Position(sd=10.0, axes=axes), sd=10.0))
        except ValueError as why:
            assert axes == 1 and ("turn" in str(why) or "one axis" in str(why)), name
            continue
        assert np.abs(filter.filter(time_, z)["px"][-1] - 2900.0) < 50.0, name


def test_a_file_within_its_budget(tmp_path, capsys):
    out, page = tmp_path / "best.json", tmp_path / "best.html"
    request = FitRequest(
        data=FLIGHTS, search=True, filter="cv,ca,cv+ca", minutes=5.0, output=str(out), report=str(page), json=True
    )
    assert run_fit(request) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["best"] == "cv+ca" == said["search"][0]["filter"]
    assert said["search"][0]["prediction_score"] > said["search"][1]["prediction_score"]
    assert jink.load(out).modes == ("constant_velocity", "constant_acceleration")
    assert "Candidates" in page.read_text(encoding="utf-8")


def test_a_budget_too_small_and_names_that_are_none(capsys):
    training, objective = prepared("random-turns")
    with pytest.raises(InputError, match="no time was left"):
        search(training, objective, names=["cv"], minutes=1e-9)
    with pytest.raises(InputError, match=r"candidate 'cv\+cx'.*did you mean"):
        search(training, objective, names=["cv+cx"])
    with pytest.raises(InputError, match="no candidate has a parameter"):
        search(training, objective, names=["cv"], fixed=["jerk*"])
    assert run_fit(FitRequest(data="random-turns", search=True, resume=True)) == 2
    assert "--resume" in capsys.readouterr().err


@pytest.mark.parametrize("workers", [1, 2])
def test_interrupted_it_ranks_what_is_done(workers):
    training, objective = prepared("random-turns")

    def after_two(words, done, of):
        if done == 2:
            raise KeyboardInterrupt

    found = search(training, objective, names=["cv", "ca", "cv+ca", "cv+ct"], workers=workers, progress=after_two)
    assert found.partial and found.interrupted
    assert 2 <= len(found.ranked) < 4
    assert len(found.ranked) + len(found.left) == 4
    assert set(found.left.values()) == {"interrupted"}


def test_filters_of_your_own_are_candidates_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my_candidates.py").write_text(OWN, encoding="utf-8")
    training, objective = prepared("random-turns", runs=2, check_runs=4)
    found = search(training, objective, names=["my_candidates.py:filters", "cv"], workers=2)
    assert {ranked.name for ranked in found.ranked} == {"mine", "drag", "cv"}
    assert found.left == {}
    with pytest.raises(InputError, match=r"has no nothing; it has .*filters"):
        search(training, objective, names=["my_candidates.py:nothing"])


OWN = """
import numpy as np
import jink

def mine(purpose):
    return jink.Kalman(jink.ConstantVelocity(acceleration_psd=50.0), purpose.sensor)

class Drag:
    components = ("px", "vx", "py", "vy")

    def __init__(self, acceleration_psd=4.0):
        self.acceleration_psd = acceleration_psd

    def f(self, x, dt):
        out = x.copy()
        out[:, [0, 2]] += x[:, [1, 3]] * np.asarray(dt)[:, None]
        return out

    def Q(self, dt):
        dt = np.asarray(dt)
        Q = np.zeros((len(dt), 4, 4))
        for p in (0, 2):
            Q[:, p, p], Q[:, p + 1, p + 1] = dt**3 / 3, dt
            Q[:, p, p + 1] = Q[:, p + 1, p] = dt**2 / 2
        return Q * self.acceleration_psd

filters = {"mine": mine, "drag": Drag}
"""
