"""What counts as manoeuvring is one definition: tracks and races say the same of the same filter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose

import jink
from jink import metrics
from jink.compare import compare
from jink.scenarios import SCENARIOS

SCANS, RUNS, SEED = 90, 12, 3
GRAVITY = 9.80665
# modes whose names do not tell: two noises of one motion model, a turn of rate zero, two manoeuvring models
TOLD = {
    "two noises": ([{"psd": 0.01}, {"psd": 400.0}], (True, False)),
    "no turn and a turn": ([{"rate": 0.0}, {"rate": 0.1}], (True, False)),
    "only turns": ([{"rate": -0.1}, {"rate": 0.1}], (False, False)),
}


def motion(psd: float = 4.0, rate: float | None = None) -> object:
    if rate is None:
        return jink.ConstantVelocity(acceleration_psd=psd)
    return jink.KnownTurn(rate, acceleration_psd=psd)


@pytest.mark.parametrize("modes, straight", TOLD.values(), ids=TOLD)
def test_tracks_and_races_agree(modes, straight, tmp_path):
    scenario = SCENARIOS["random-turns"]
    scenario = replace(scenario, schedule=replace(scenario.schedule, count=SCANS))
    s = scenario.simulate(RUNS, SEED)
    sensor = scenario.observation.sensor
    filter = jink.IMM([motion(**m) for m in modes], sensor, jink.Sojourn(seconds=[60.0, 15.0]))
    assert filter.non_manoeuvring == straight

    columns = {"target": np.repeat([f"{k:02}" for k in range(RUNS)], SCANS), "time": s.time.reshape(-1)}
    table = pl.DataFrame(columns | {"x": s.z[..., 0].reshape(-1), "y": s.z[..., 1].reshape(-1)})
    tracks = jink.track(table, filter=filter, kind="fighter", gap=0, drop_stale=False, min_points=1)
    tracks = tracks.sort("target", "time")

    filter.save(tmp_path / "own.json")
    race = compare(scenario, [str(tmp_path / "own.json")], runs=RUNS, seed=SEED)
    (name,) = (n for n in race.entrants if n.endswith("own.json"))
    found = race.figures(name)
    if not any(straight):
        assert tracks["manoeuvring"].is_null().all() and tracks["segment"].is_null().all()
        assert "noticed" not in found
        return
    probability = tracks["manoeuvring"].to_numpy().reshape(RUNS, SCANS)
    busy = s.turn_rate != 0
    busy[:, 0] = busy[:, 1]
    seen = metrics.detection(probability, busy)
    assert seen.noticed.value > 0
    for metric, figure in (("noticed", seen.noticed), ("false_alarms", seen.false_alarms)):
        assert_allclose(race.figure(name, metric), figure, rtol=1e-9, err_msg=metric)
    pulls = np.linalg.norm(s.truth.acceleration, axis=2) > 0.5 * GRAVITY
    for metric, those in (("detection", pulls), ("false_alarm", ~pulls)):
        assert_allclose(race.figure(name, metric).value, (probability[those] > 0.5).mean(), rtol=1e-9, err_msg=metric)


@pytest.mark.parametrize("name", ["nnvsmm-modes", "fuzzy-imm", "imm", "gpb1", "vsmm-ag"])
def test_a_straight_flight_is_not_told_to_manoeuvre(name):
    rng, time = np.random.default_rng(4), np.arange(200.0)
    tables = [
        pl.DataFrame(
            {"target": str(k), "time": time, "x": 200.0 * time + rng.normal(0, 20, 200), "y": rng.normal(0, 20, 200)}
        )
        for k in range(10)
    ]
    told = jink.track(pl.concat(tables), filter=name, sensor_sd=20.0)["manoeuvring"]
    # scores of modes are no probabilities: what they would tell is left out
    assert told.null_count() == told.len() if name == "nnvsmm-modes" else (told > 0.5).mean() < 0.15
