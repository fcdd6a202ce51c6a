"""Filters of one's own in races and fits: equal to jink's where they are the same filter, refused with a reason."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from support import own_filters as own

import jink
from jink.catalogue.purpose import Named, Unfit
from jink.cli.compare import CompareRequest, run_compare
from jink.cli.fit import FitRequest, run_fit
from jink.compare.race import compare
from jink.fit import fit
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS

HERE = Path(own.__file__)
SHORT = replace(SCENARIOS["wang-2010-circle"], schedule=replace(SCENARIOS["wang-2010-circle"].schedule, count=40))
SENSOR = jink.Position(sd=20.0)
COMPARED = ("position_rmse", "velocity_rmse", "nees", "nis", "log_score", "prediction_score")


def fleet():
    """Ragged tracks with misses, whole and partial, and rows of one time."""
    rng = np.random.default_rng(0)
    lengths = np.array([30, 1, 0, 17])
    offsets = np.r_[0, np.cumsum(lengths)]
    time = np.concatenate([np.cumsum(rng.uniform(0.5, 3.0, n)) for n in lengths])
    z = np.column_stack([100.0 * time, -40.0 * time]) + rng.normal(0.0, 20.0, (len(time), 2))
    z[[5, 6, 40]] = np.nan
    return time, z, offsets


def test_a_whole_filter_is_the_kalman_filter_that_it_copies():
    time, z, offsets = fleet()
    noise = np.random.default_rng(1).uniform(100.0, 900.0, z.shape)
    motion = jink.ConstantVelocity(acceleration_psd=4.0)
    same = jink.Kalman(motion, SENSOR, initial=jink.OnePoint(velocity_sd=300.0))
    for covariance in (None, noise):
        got = jink.OwnFilter(own.Straight(), SENSOR).filter(time, z, offsets=offsets, covariance=covariance)
        want = same.filter(time, z, offsets=offsets, covariance=covariance)
        assert got.components == want.components
        for name in ("x", "P", "nis", "nis_dof", "log_likelihood", "log_likelihood_scan", "status"):
            assert_allclose(getattr(got, name), getattr(want, name), rtol=1e-7, atol=1e-7, err_msg=name)


def test_live_is_the_batch():
    time, z, _ = fleet()
    filter = jink.OwnFilter(own.Straight(), SENSOR)
    live = filter.start()
    batch = filter.filter(time[:30], z[:30])
    for k in range(30):
        now = live.update(time[k], z[k])
        assert_array_equal(now.x, batch.x[k])
    ahead = live.predict(time[29] + 10.0)
    assert ahead.sd("px") > now.sd("px") and live.predict(time[29] + 10.0) == ahead


def test_own_filters_race_by_their_names():
    def unfit(purpose):
        raise Unfit("it has no opinion on circles")

    def named(purpose):
        return Named(filter=own.make(purpose), words="in my words", note="a note")

    race = compare(
        SHORT,
        {"mine": own.Straight(), "made": own.make, "model": own.Drifting(), "many": own.several_models}
        | {"unfit": unfit, "named": named, "imm-cv-ca": None, "class": own.Straight},
        runs=3,
    )
    assert list(race.tallies)[-6:] == ["mine", "made", "model", "many", "named", "class"]
    assert "imm-cv-ca" in race.tallies and race.skipped == {"unfit": "it has no opinion on circles"}
    for metric in COMPARED:
        assert_allclose(race.figure("mine", metric).value, race.figure("made", metric).value, rtol=1e-6)
    assert race.entrants["mine"].words == "own filter: Straight"
    assert (race.entrants["named"].words, race.entrants["named"].note) == ("in my words", "a note")


def test_a_radar_and_a_range_rate_give_the_same_scores_as_the_engine():
    """NIS and density of a whole filter come from its prediction, linearised by differences."""
    sensor = jink.Polar(range_sd=30.0, azimuth_sd=0.004, range_rate_sd=2.0)
    inner = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), sensor)

    class Wrapped:
        """jink's live filter behind the two functions: its state is its memory."""

        components = inner.components

        def begin(self, z, R):
            live = inner.start(len(z))
            self._time = 0.0
            now = live.update(0.0, z)
            return {
                "x": now.x,
                "P": now.P,
                "live": np.array([live.save()] * len(z), dtype=object),
                "t": np.zeros(len(z)),
            }

        def step(self, state, dt, z, R):
            live = inner.start(len(z), state=state["live"][0])
            t = state["t"] + dt
            now = live.update(t, z)
            return {"x": now.x, "P": now.P, "live": np.array([live.save()] * len(z), dtype=object), "t": t}

    rng = np.random.default_rng(3)
    time = np.arange(20.0) * 4.0
    place = np.column_stack([4000.0 + 90.0 * time, 9000.0 - 60.0 * time])
    r = np.hypot(*place.T)
    clean = np.column_stack([r, np.arctan2(place[:, 0], place[:, 1]), (place @ [90.0, -60.0]) / r])
    z = clean + rng.normal(0.0, [30.0, 0.004, 2.0], clean.shape)
    want = inner.filter(time, z)
    got = jink.OwnFilter(Wrapped(), sensor).filter(time, z)
    assert_allclose(got.x, want.x, rtol=1e-12)
    scored = want.scored
    # the engine linearises at the prediction as well; what differs is the error of central differences
    assert_allclose(got.nis[scored], want.nis[scored], rtol=1e-5)
    assert_allclose(got.log_likelihood_scan[scored], want.log_likelihood_scan[scored], rtol=1e-6)


class WrongShape(own.Straight):
    def step(self, state, dt, z, R):
        return {**state, "P": state["P"][:, :2]}


class NotADict(own.Straight):
    def begin(self, z, R):
        return z


class OddNumber(own.Straight):
    def begin(self, z, R):
        return {"x": np.zeros((len(z), 5))}


@pytest.mark.parametrize(
    ("filters", "said"),
    [
        ({"imm": own.make}, "imm is the name of a filter of jink; expected another name"),
        ({"mine": 3}, "mine is 3; expected a filter, a function of the purpose"),
        ({"mine": "imm"}, "mine is given as 'imm'; expected a filter"),
        ({"mine": own.failing}, "mine failed for wang-2010-circle: RuntimeError: own trouble"),
        ({"mine": lambda purpose: None}, "mine is None; expected a filter"),
        ({"mine": NotADict()}, "begin: expected a dict of arrays"),
        ({"mine": OddNumber()}, "x has 5 columns where the sensor has 2 axes; expected 2, 4 or 6"),
        (
            {"mine": jink.Kalman(own.Drifting(), jink.Bearing(sd=0.1), initial=jink.Prior(np.zeros(4), np.eye(4)))},
            "azi",
        ),
        ([own.make], "expected names, or a mapping such as"),
        ("nowhere.py:make", "there is no file nowhere.py"),
        (f"{HERE}:nothing", "has no nothing; it has"),
        ("no.such.module:make", "expected a module that can be imported"),
    ],
)
def test_what_cannot_race_says_why(filters, said):
    with pytest.raises(InputError) as error:
        compare(SHORT, filters, runs=1)
    assert said in str(error.value)


def test_a_state_of_a_wrong_shape_names_the_function():
    with pytest.raises(ValueError, match=r"step: P has shape \(1, 2, 4\) for 1 targets; expected \(1, 4, 4\)"):
        jink.OwnFilter(WrongShape(), SENSOR).filter(*fleet()[:2])


@pytest.fixture
def recorded(tmp_path):
    """Positions without truth, as a file."""
    rows = []
    rng = np.random.default_rng(0)
    for target in range(12):
        t = np.arange(40) * 2.0
        place = np.column_stack([60.0 * t + 500.0 * target, 30.0 * t]) + rng.normal(0.0, 15.0, (40, 2))
        rows.append(pl.DataFrame({"target": f"t{target}", "time": t, "x": place[:, 0], "y": place[:, 1]}))
    path = tmp_path / "recorded.csv"
    pl.concat(rows).write_csv(path)
    return str(path)


def test_recorded_positions_and_the_command_line(recorded, tmp_path, capsys):
    out = tmp_path / "race.json"
    request = CompareRequest(scenario=recorded, filters=f"{HERE}:everything,{HERE}:make", json=str(out), quiet=True)
    assert run_compare(request) == 0, capsys.readouterr().err
    found = json.loads(out.read_text())["filters"]
    assert {"mine", "made", "imm", f"{HERE}:make"} <= set(found)
    for metric in ("prediction_rmse", "prediction_score", "nis"):
        assert_allclose(found["mine"][metric]["value"], found["made"][metric]["value"], rtol=1e-5)
    assert run_compare(CompareRequest(scenario=recorded, filters=f"{HERE}:nothing")) == 2
    assert "has no nothing" in capsys.readouterr().err


@pytest.mark.parametrize("given", [own.Drifting(40.0), own.Straight(40.0), own.make])
def test_a_fit_of_ones_own(given):
    """Own numbers that end in _psd are fitted like jink's, whose best is 0.7; a search without gradient stops near."""
    found = fit(SHORT, given, runs=10, check_runs=2, starts=1, objective="likelihood")
    (value,) = [v for name, v in found.parameters.values(found.u).items() if name.endswith("acceleration_psd")]
    assert found.after < found.before and 0.3 < value < 3.0


def test_a_fit_at_the_command_line(tmp_path, capsys):
    out = tmp_path / "fitted.json"
    small = {"data": "choi-2001-1", "runs": 20, "check_runs": 5, "starts": 1, "quiet": True}
    assert run_fit(FitRequest(filter=f"{HERE}:Straight", output=str(out), **small)) == 0, capsys.readouterr().err
    assert jink.load(out, own=True).steps.acceleration_psd != 4.0
    for name, said in (("everything", "is a mapping of filters; expected one"), ("failing", "own trouble")):
        assert run_fit(FitRequest(filter=f"{HERE}:{name}", **small)) == 2
        assert said in capsys.readouterr().err
