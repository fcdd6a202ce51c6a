"""Races against the truth: manoeuvre figures, bounds, how it is seen, and files that hold truth."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose

import jink
from jink import metrics
from jink.catalogue.purpose import Unfit
from jink.cli.compare import CompareRequest, run_compare
from jink.compare import bounds, manoeuvring, simulated
from jink.compare.race import compare
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS
from jink.scenarios.observation import in_words
from jink.scenarios.table import simulation_table
from jink.tracking.manoeuvring import Manoeuvres, Moving, probabilities


def short(name: str, scans: int, **changes):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=scans), **changes)


def test_manoeuvre_figures_are_those_of_the_metrics(monkeypatch):
    scenario = short("random-turns", 90)
    monkeypatch.setattr(simulated, "CHUNK_ROWS", 90 * 7)  # chunks of seven runs
    race = compare(scenario, ["imm-cv-ct", "singer"], runs=40, seed=5)
    s = scenario.simulate(40, 5)
    filter = race.entrants["imm-cv-ct"].filter
    est = filter.filter(**s.batch())
    px, py = (est.components.index(c) for c in ("px", "py"))
    error = est.x[:, [px, py]].reshape(40, 90, 2) - s.truth.position
    error[:, :2] = np.nan
    busy = s.turn_rate != 0
    busy[:, 0] = busy[:, 1]
    new = np.arange(40 * 90) % 90 == 0
    told = probabilities(Moving.of(est, s.time.reshape(-1), new), Manoeuvres.of(filter, "fighter"))
    probability = told[0].reshape(40, 90)
    onset = metrics.response(error, busy, "onset")
    end = metrics.response(error, busy, "end", level=onset.level)
    seen = metrics.detection(probability, busy)
    expected = {
        "onset_peak": onset.peak,
        "onset_settling": onset.settling,
        "end_peak": end.peak,
        "detection_delay": seen.delay,
        "noticed": seen.noticed,
        "false_alarms": seen.false_alarms,
    }
    for name, figure in expected.items():
        assert_allclose(race.figure("imm-cv-ct", name), figure, rtol=1e-9, err_msg=name)
    assert race.figure("imm-cv-ct", "end_settling").value == end.settling.value
    assert onset.peak.value > 0 and 0 < seen.noticed.value <= 1
    assert "noticed" not in race.figures("singer") and "onset_peak" in race.figures("raw")
    body = race.as_dict()["filters"]["imm-cv-ct"]
    assert body["onset_peak"]["se"] > 0 and {"log_score", "mean_euclidean", "prediction_score"} <= set(body)


def test_a_climb_is_nothing_that_a_probability_in_the_plane_should_notice():
    race = compare("terminal-area", ["imm"], runs=10, seed=3)
    s = SCENARIOS["terminal-area"].simulate(10, 3)
    filter = race.entrants["imm"].filter
    new = np.arange(s.time.size) % s.time.shape[1] == 0
    moving = Moving.of(filter.filter(**s.batch()), s.time.reshape(-1), new)
    probability = probabilities(moving, Manoeuvres.of(filter, "aircraft"))[0].reshape(s.time.shape)
    level = np.linalg.norm(s.truth.acceleration[..., :2], axis=2) > 0.05 * 3.0
    climbs = np.abs(s.truth.acceleration[..., 2]) > 0.05 * 3.0
    assert (climbs & ~level).any()
    seen = metrics.detection(probability, level)
    for name, figure in {
        "noticed": seen.noticed,
        "detection_delay": seen.delay,
        "false_alarms": seen.false_alarms,
    }.items():
        assert_allclose(race.figure("imm", name), figure, rtol=1e-9, err_msg=name)


def test_a_curve_manoeuvres_where_it_accelerates():
    s = short("benchmark-1", 100).simulate(1)
    busy = manoeuvring.busy(s)[0]
    assert not busy[:60].any() and busy[63:78].all() and not busy[82:].any()


def test_errors_over_time_of_accelerations():
    race = compare(short("random-turns", 30), ["singer"], runs=20, seed=1)
    s = short("random-turns", 30).simulate(20, 1)
    est = race.entrants["singer"].filter.filter(**s.batch())
    index = [est.components.index(c) for c in ("ax", "ay")]
    error = est.x[:, index].reshape(20, 30, 2) - s.truth.acceleration
    assert_allclose(race.tallies["singer"].over_time("acceleration"), metrics.rmse_over_time(error[:, 2:]), rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("lee-2003", "noise of"),
        ("wang-2010-velocity", "without noise"),
        ("wang-2010-circle", "without noise"),
        ("choi-2001-3", "without noise"),
        ("benchmark-5", "smooth path"),
        ("random-turns", "noise of"),
    ],
)
def test_the_clairvoyant_reaches_the_bound_and_nobody_beats_it(name, words):
    race = compare(name, runs=150, seed=2)
    assert words in race.entrants["clairvoyant"].words
    for metric in ("position_rmse", "velocity_rmse"):
        figure = race.figure("clairvoyant", metric)
        assert abs(figure.value - race.bound[metric]) < 4 * figure.se
        for other in ("raw", "kalman-cv", "kalman-ca", "imm"):
            assert race.figure(other, metric).value > race.bound[metric]
    assert abs(race.figure("clairvoyant", "nees_inside").value - 0.95) < 0.03


def test_without_noise_the_clairvoyant_is_a_line_through_what_is_left():
    """Least squares: position variance R (4n − 2)/(n (n + 1)) at the last of n scans."""
    scenario = short("wang-2010-step", 40)
    s = scenario.simulate(300, 1)
    estimate = bounds.clairvoyant(s, bounds.told(s), None)
    error = estimate["px"].reshape(300, 40) - s.truth.position[..., 0]
    n = 40
    sd = 50.0 * math.sqrt((4 * n - 2) / (n * (n + 1)))
    assert_allclose(estimate.sd("px").reshape(300, 40)[0, -1], sd, rtol=1e-3)
    assert error[:, -1].std() == pytest.approx(sd, rel=0.15)
    slope = np.polyfit(s.time[0], s.z[..., 0].T - s.truth.position[..., 0].T, 1)
    assert_allclose(error[:, -1], slope[0] * s.time[0, -1] + slope[1], atol=0.01)


@pytest.mark.parametrize(
    ("name", "sensor", "why"),
    [
        ("random-turns", "radar-4s", "change between scans"),
        ("lee-2003", "radar-20hz", "lasts for several scans"),
        ("terminal-area", None, "measures positions"),
        ("choi-2001-3", "radar-1hz", "measures positions"),
    ],
)
def test_where_manoeuvres_are_not_known_exactly_there_is_no_clairvoyant(name, sensor, why):
    scenario = SCENARIOS[name] if sensor is None else SCENARIOS[name].seen_by(sensor)
    assert why in compare(scenario, runs=3).skipped["clairvoyant"]


def test_a_radar_has_a_bound_as_well():
    """Information of range and azimuth at the truth: for a target that stands still, the sensor's own ellipse."""
    scenario = short("benchmark-1", 3).seen_by(jink.Polar(range_sd=30.0, azimuth_sd=1e-3, elevation_sd=2e-3))
    training = scenario.simulate(2)
    found = bounds.posterior_bound(training, bounds.told(training), 0)
    p = training.truth.position[0]
    r, ground = np.linalg.norm(p, axis=1), np.hypot(p[:, 0], p[:, 1])
    first = 30.0**2 + (1e-3 * ground[0]) ** 2 + (2e-3 * r[0]) ** 2
    second = bounds.posterior_bound(
        replace(
            training,
            time=training.time[:, :1],
            truth=training.truth._replace(**{name: values[:, :1] for name, values in training.truth._asdict().items()}),
        ),
        bounds.told(training),
        0,
    )
    assert second["position_rmse"] == pytest.approx(math.sqrt(first), rel=1e-3)
    assert found["position_rmse"] < 1.05 * second["position_rmse"]


def test_unknown_scan_times_make_no_bound():
    with pytest.raises(Unfit, match="revisit time"):
        bounds.told(SCENARIOS["lee-2003"].seen_by(500.0, interval=2.5).simulate(5))


def ask(**changes) -> int:
    return run_compare(CompareRequest(**{"scenario": "choi-2001-1", "filters": "", "runs": 10, "seed": 1, **changes}))


def test_sensor_options(tmp_path, capsys):
    out = tmp_path / "o.json"
    seen = {"sensor": "20", "interval": 2.0, "detection": 0.9, "outliers": 0.01}
    assert ask(scenario="random-turns", **seen, json=str(out)) == 0
    scenario = SCENARIOS["random-turns"].seen_by(20.0, interval=2.0, detection=0.9, outlier_share=0.01)
    body = json.loads(out.read_text())
    assert body["seen"] == in_words(scenario) and "one every 2 s" in body["seen"]
    there = compare(scenario, runs=10, seed=1).as_dict()
    assert body["filters"]["imm"]["position_rmse"] == there["filters"]["imm"]["position_rmse"]
    assert "seen by position, sd 20" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"sensor": "radar-4"}, "did you mean radar-4s"),
        ({"sensor": "-3"}, "--sensor is -3"),
        ({"detection": 1.5}, "detection: expected"),
        ({"bias": "1,x"}, "--bias is '1,x'"),
        ({"bias": "nan,1"}, "--bias is 'nan,1'"),
        ({"interval": 15.0}, "choi-2001-1: 2 scans in 15 s steps; expected at least 3 scans"),
        ({"bias": "1"}, "bias: expected one number for each of x, y"),
        ({"jitter": 9.0}, "jitter: expected"),
    ],
)
def test_wrong_sensor_options(options, said, capsys, tmp_path):
    assert ask(**options, json=str(tmp_path / "o.json")) == 2
    assert said in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_a_simulated_file_is_scored_against_its_truth(tmp_path):
    """The runs that are scored have the figures of the same runs of the scenario."""
    scenario = short("lee-2003", 60)
    path = tmp_path / "lee.csv"
    simulation_table(scenario.simulate(60, 3)).write_csv(path)
    race = compare(str(path), ["singer"], runs=1000, seed=4, kind="fighter")
    assert race.runs == 30 and not race.partial and "noise as found" in race.seen
    assert race.entrants["kalman-cv"].fitted == "30 other runs of this file"
    order = np.random.default_rng(4).permutation(60)
    s = scenario.simulate(np.sort(order[30:]), 3)
    raw = metrics.rmse(s.z - s.truth.position, first=2)
    assert_allclose(race.figure("raw", "position_rmse"), raw, rtol=1e-9)
    sensor = race.entrants["singer"].filter.sensors[0]
    assert sensor.sd == pytest.approx(500.0, rel=0.03)
    filter = jink.Kalman(jink.Singer(acceleration_sd=20.0, time_constant=20.0), sensor)
    x = filter.filter(**s.batch()).x.reshape(30, 60, 6)
    expected = metrics.rmse(x[..., [0, 3]] - s.truth.position, first=2)
    assert_allclose(race.figure("singer", "position_rmse"), expected, rtol=1e-9)
    bound, clairvoyant = race.bound["position_rmse"], race.figure("clairvoyant", "position_rmse")
    assert abs(clairvoyant.value - bound) < 4 * clairvoyant.se


def test_a_file_of_a_radar_keeps_its_site_and_noise(tmp_path):
    path = tmp_path / "radar.parquet"
    scenario = short("terminal-area", 60).seen_by(
        SCENARIOS["terminal-area"].observation, interval=4.0, jitter=0.05, detection=0.9, outlier_share=0.02
    )
    simulation_table(scenario.simulate(40, 1)).write_parquet(path)
    race = compare(str(path), runs=12, seed=1)
    sensor = race.entrants["imm"].filter.sensors[0]
    own = scenario.observation.sensor
    assert sensor.components == own.components and tuple(sensor.site) == tuple(own.site) != (0.0, 0.0, 0.0)
    for name in ("range_sd", "azimuth_sd", "height_sd"):
        assert getattr(sensor, name) == pytest.approx(getattr(own, name), rel=0.08)
    assert race.runs == 12 and race.compare("imm", "raw").verdict == "better"
    assert "outliers" in race.seen and "detection 0.9" in race.seen


def test_one_run_of_a_file_is_not_fitted_on(tmp_path):
    path = tmp_path / "one.csv"
    simulation_table(short("random-turns", 60).simulate(1, 1)).write_csv(path)
    race = compare(str(path), runs=5)
    assert race.runs == 1 and not race.entrants["kalman-cv"].fitted
    assert math.isnan(race.figure("imm", "position_rmse").se)


def broken(table: pl.DataFrame) -> dict[str, tuple[pl.DataFrame, str]]:
    return {
        "scans": (table[:-1], "runs have 39 to 40 scans"),
        "truth": (table.with_columns(true_y=None), "column true_y has a missing value"),
        "times": (table.with_columns(time=pl.lit(1.0)), "expected times that rise"),
        "measurements": (table.drop("x", "y"), "no column holds a measurement"),
        "nothing measured": (table.with_columns(pl.lit(None).alias("x")), "missing or equal the truth"),
        "velocity": (table.drop("true_velocity_y"), "true_velocity_y missing"),
        "rows": (table.clear(), "the file has no rows"),
    }


@pytest.mark.parametrize("case", broken(pl.DataFrame({"x": [0], "y": [0], "true_velocity_y": [0]})))
def test_files_whose_truth_is_broken(case, tmp_path):
    table, said = broken(simulation_table(short("random-turns", 40).simulate(3, 1)))[case]
    path = tmp_path / "f.parquet"
    table.write_parquet(path)
    with pytest.raises(InputError, match=said):
        compare(str(path), runs=5)


def test_simulated_files_take_no_sensor_options(tmp_path, capsys):
    path = tmp_path / "f.parquet"
    simulation_table(short("random-turns", 40).simulate(3, 1)).write_parquet(path)
    assert ask(scenario=str(path), sensor="20") == 2
    assert "holds simulated measurements" in capsys.readouterr().err


def test_recorded_tracks_seen_by_a_simulated_radar(capsys, tmp_path):
    out = tmp_path / "o.json"
    assert ask(scenario="examples/flights.parquet", sensor="radar-4s", json=str(out)) == 0
    body = json.loads(out.read_text())
    assert "position_rmse" in body["filters"]["imm"] and "package traffic" in body["about"]["imm"]["note"]


@pytest.mark.parametrize("unit", [1, 1000])
def test_a_default_that_cannot_be_right_on_a_recording_has_a_note(tmp_path, unit):
    table = simulation_table(short("random-turns", 60).simulate(10, 1)).select("target", "time", "x", "y")
    path = tmp_path / "f.parquet"
    table.with_columns(time=(pl.col("time") * unit).cast(pl.Int64)).write_parquet(path)  # 1000: ms taken for s
    race = compare(str(path), [], kind="fighter")
    assert ("Likely: a wrong unit of time or position" in race.entrants["imm"].note) == (unit == 1000)
