"""The race: figures equal the metrics computed from whole arrays, verdicts are earned, requests are checked."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle.tracker import track as oracle_track
from oracle.twin import Twin, part

import jink
from jink import metrics
from jink.catalogue.tuning import best_noise, golden_section
from jink.compare import simulated
from jink.compare.estimates import raw
from jink.compare.mahalanobis import mahalanobis
from jink.compare.race import compare
from jink.compare.scores import Tally, difference
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS


def short(name: str, scans: int, **changes):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=scans), **changes)


@pytest.fixture(scope="module")
def lee():
    return compare("lee-2003", ["imm-cv-ca", "imm-cv-ct"], runs=500, seed=1)


def test_clairvoyant_on_lee_2003_and_its_consistency(lee):
    for metric, published in (("normalised_position", 0.3001), ("normalised_velocity", 0.0197)):
        figure = lee.figure("clairvoyant", metric)
        assert abs(figure.value - published) < 3 * figure.se
    assert abs(lee.figure("clairvoyant", "nees").value - 1) < 3 * lee.figure("clairvoyant", "nees").se
    assert abs(lee.figure("clairvoyant", "nees_inside").value - 0.95) < 0.01


def test_tuned_kalman_filter_on_lee_2003(lee):
    """The published constant velocity filter, tuned for normalised errors: .570/.091."""
    assert abs(lee.figure("kalman-cv", "normalised_position").value - 0.570) < 0.006
    assert lee.entrants["kalman-cv"].fitted and not lee.entrants["kalman-cv"].in_sample
    assert lee.entrants["imm"].fitted == "the default's search, on other draws"
    assert lee.entrants["imm-cv-ca"].fitted and not lee.entrants["raw"].fitted
    assert not compare(short("wang-2010-circle", 40), runs=2).entrants["imm"].fitted


def test_better_and_worse_are_said_where_the_interval_excludes_zero(lee):
    assert lee.compare("imm-cv-ca", "kalman-cv").verdict == "better"
    assert lee.compare("kalman-cv", "imm-cv-ca").verdict == "worse"
    assert lee.compare("imm", "imm").verdict == "undecided"
    assert lee.worse_than_raw("imm-cv-ct") and not lee.worse_than_raw("kalman-cv")
    assert not lee.worse_than_raw("raw")


def whole(scenario, filter, runs, seed):
    """Position and velocity errors, NEES and estimates of all runs at once, by the engine and plain arrays."""
    s = scenario.simulate(runs, seed)
    est = filter.filter(**s.batch())
    shape = s.time.shape
    columns = [est.components.index(c) for c in ("px", "py", "vx", "vy")]
    x = est.x[:, columns].reshape(*shape, 4)
    P = est.P[:, columns][:, :, columns].reshape(*shape, 4, 4)
    error = x - np.concatenate([s.truth.position, s.truth.velocity], axis=2)
    return s, est, error, metrics.nees(error, P)


def test_every_figure_equals_the_metrics_of_whole_arrays(monkeypatch):
    scenario = short("random-turns", 40).seen_by(50.0, detection=0.9)
    monkeypatch.setattr(simulated, "CHUNK_ROWS", 40 * 7)  # chunks of seven runs
    race = compare(scenario, ["imm-cv-ct"], runs=30, seed=5)
    s, est, error, nees = whole(scenario, race.entrants["imm-cv-ct"].filter, 30, 5)
    measured = raw(s)
    noise = [measured.position - s.truth.position, measured.velocity - s.truth.velocity]
    shape, status = s.time.shape, est.status.reshape(s.time.shape)
    scored = np.where(np.isin(status, (1, 3)), est.log_likelihood_scan.reshape(shape), np.nan)
    nis = metrics.consistency(est.nis.reshape(shape), np.nan_to_num(est.nis_dof.reshape(shape)), first=2)
    expected = {
        "position_rmse": metrics.rmse(error[..., :2], first=2),
        "velocity_rmse": metrics.rmse(error[..., 2:], first=2),
        "mean_euclidean": metrics.mean_euclidean(error[..., :2], first=2),
        "normalised_position": metrics.normalised_error(error[..., :2], noise[0]),
        "normalised_velocity": metrics.normalised_error(error[..., 2:], noise[1]),
        "nees": metrics.consistency(nees, 4, first=2).mean,
        "nees_inside": metrics.consistency(nees, 4, first=2).inside,
        "nis_inside": nis.inside,
        "prediction_score": metrics.prediction_score(scored, first=2),
    }
    for name, q in (("position_median", 0.5), ("position_95", 0.95)):
        exact = metrics.quantile(error[..., :2], q, first=2)
        assert_allclose(race.figure("imm-cv-ct", name).value, exact.value, rtol=0.005)
        assert_allclose(race.figure("imm-cv-ct", name).se, exact.se, rtol=0.15)
    over_time = metrics.rmse_over_time(error[:, 2:, :2])
    assert_allclose(race.tallies["imm-cv-ct"].over_time("position"), over_time, rtol=1e-9)
    for name, figure in expected.items():
        assert_allclose(race.figure("imm-cv-ct", name), figure, rtol=1e-9, err_msg=name)
    cv = whole(scenario, race.entrants["kalman-cv"].filter, 30, 5)[2]
    c, d = race.compare("imm-cv-ct", "kalman-cv"), metrics.compare_rmse(error[..., :2], cv[..., :2], first=2)
    assert_allclose([c.difference, c.se, c.low, c.high], [d.difference, d.se, d.low, d.high], rtol=1e-9)


def test_lost_tracks_are_counted_as_the_metric_does():
    rng = np.random.default_rng(3)
    error = rng.normal(size=(40, 60, 2)) * rng.uniform(0.1, 3, (40, 1, 1))
    error[:3, :20] = np.nan
    error[3, 30:40] = np.nan
    assert simulated._gone(error, 2.0).mean() == metrics.lost(error, 2.0).value


def test_more_runs_than_groups_keep_figures_and_nearly_their_errors():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 4000)) ** 2 + 1
    ones, runs = np.ones(4000), np.arange(4000)
    fine, coarse = [], []
    for groups, tallies in ((4000, fine), (500, coarse)):
        for values in (a, b):
            tally = Tally(groups=groups)
            tally.runs += 1
            tally.add(runs, "position_rmse", values, ones)
            tallies.append(tally)
    assert_allclose(coarse[0].figure("position_rmse").value, math.sqrt(a.mean()))
    assert_allclose(coarse[0].figure("position_rmse").se, fine[0].figure("position_rmse").se, rtol=0.12)
    c, f = difference(*coarse, "position_rmse"), difference(*fine, "position_rmse")
    assert_allclose(c.difference, f.difference)
    assert_allclose(c.se, f.se, rtol=0.12)


def test_mahalanobis_is_that_of_the_inverse():
    rng = np.random.default_rng(1)
    A = rng.normal(size=(5, 7, 6, 6))
    P, e = A @ A.swapaxes(-1, -2) + 0.1 * np.eye(6), rng.normal(size=(5, 7, 4))
    index = [4, 0, 3, 1]
    square, log_det = mahalanobis(e, P, index)
    part = P[..., index, :][..., index]
    assert_allclose(square, np.einsum("rsi,rsij,rsj->rs", e, np.linalg.inv(part), e), rtol=1e-9)
    assert_allclose(log_det, np.linalg.slogdet(part)[1], rtol=1e-9)
    assert np.isnan(mahalanobis(e[:1, :1], -np.eye(4)[None, None], range(4))[0]).all()


def test_noise_is_found_by_golden_section():
    assert golden_section(lambda x: (x - 1.2345) ** 2, 0, 5, tolerance=1e-6) == pytest.approx(1.2345, abs=1e-5)
    assert best_noise(lambda q: math.log(q / 3.0) ** 2, 1e-6, 1e6) == pytest.approx(3.0, rel=0.02)
    assert best_noise(lambda q: math.nan if q < 1 else math.log(q / 3.0) ** 2, 1e-6, 1e6) == pytest.approx(3, rel=0.02)


def test_the_race_against_a_textbook_imm(tmp_path):
    """The same file races and is run scan by scan in NumPy: the same RMSE."""
    twin = Twin(
        [part("ConstantVelocity", acceleration_sd=1.0), part("ConstantAcceleration", jerk_psd=20.0)],
        [part("Position", sd=50.0)],
        transition=0.95,
    )
    path = str(tmp_path / "imm.json")
    twin.native().save(path)
    scenario = short("random-turns", 40)
    race = compare(scenario, [path], runs=4, seed=2)
    s = scenario.simulate(4, 2)
    tracks = [oracle_track(twin.oracle(), t, z) for t, z in zip(s.time, s.z, strict=True)]
    x = np.stack([each.x for each in tracks])
    names = jink.load(path).components
    for quantity, letter in (("position", "p"), ("velocity", "v")):
        index = [names.index(letter + a) for a in "xy"]
        error = x[..., index] - getattr(s.truth, quantity)
        expected = metrics.rmse(error, first=2).value
        assert_allclose(race.figure(path, f"{quantity}_rmse").value, expected, rtol=1e-6)


def test_the_race_against_filterpy(tmp_path):
    kalman = pytest.importorskip("filterpy.kalman")
    scenario, T, sds = short("random-turns", 40), 1.0, (1.0, 15.0)
    P0 = np.diag([1e6, 1e5, 1e6, 1e5])
    start = jink.Prior(np.zeros(4), P0)
    path = str(tmp_path / "imm.json")
    modes = [jink.ConstantVelocity(acceleration_sd=sd) for sd in sds]
    filter = jink.IMM(modes, jink.Position(sd=50.0), 0.95, mode_probability=[0.5, 0.5], initial=start)
    filter.save(path)
    race = compare(scenario, [path], runs=4, seed=2)
    s = scenario.simulate(4, 2)
    one, G = np.array([[1, T], [0, 1]]), np.array([[T * T / 2], [T]])
    error = np.empty((*s.time.shape, 2))
    for run, z in enumerate(s.z):
        bank = []
        for sd in sds:
            f = kalman.KalmanFilter(dim_x=4, dim_z=2)
            f.x, f.P = np.zeros((4, 1)), P0.copy()
            f.F, f.Q = np.kron(np.eye(2), one), np.kron(np.eye(2), sd**2 * G @ G.T)
            f.H, f.R = np.kron(np.eye(2), [[1.0, 0.0]]), 2500.0 * np.eye(2)
            bank.append(f)
        imm = kalman.IMMEstimator(bank, [0.5, 0.5], np.array([[0.95, 0.05], [0.05, 0.95]]))
        for k, measured in enumerate(z):
            if k:
                imm.predict()
            imm.update(measured[:, None])
            error[run, k] = imm.x[[0, 2], 0] - s.truth.position[run, k]
    expected = metrics.rmse(error, first=2).value
    assert_allclose(race.figure(path, "position_rmse").value, expected, rtol=1e-6)


def test_polar_scenarios_race_with_polar_filters():
    scenario = short("terminal-area", 60)
    race = compare(scenario, "singer", runs=20, seed=1)
    assert set(race.tallies) == {"raw", "kalman-cv", "kalman-ca", "imm", "singer"}
    assert "measures positions" in race.skipped["clairvoyant"] and race.bound
    assert race.compare("kalman-ca", "raw").verdict == "better"
    s = scenario.simulate(20, 1)
    error = raw(s).position - s.truth.position
    assert_allclose(race.figure("raw", "position_rmse").value, metrics.rmse(error, first=2).value, rtol=1e-9)


@pytest.mark.parametrize("radar", ["radar-1hz", "radar-12s"])
def test_raw_positions_of_a_radar_without_noise_are_the_truth(radar):
    scenario = SCENARIOS["drone"].seen_by(radar)
    truth = scenario.simulate(2, 1).truth
    sensor = replace(scenario.observation.sensor, site=(1000.0, -500.0, 20.0))
    assert_allclose(sensor.positions(sensor.observe(truth)), truth.position, atol=1e-6)


def test_one_axis_and_the_near_optimal_reference():
    race = compare(short("wang-2010-step", 60), runs=10)
    assert "without noise" in race.entrants["clairvoyant"].words and "one axis" in race.entrants["imm"].words
    race = compare(short("random-accelerations", 50), "near-optimal", runs=20)
    assert race.figures("near-optimal")["position_efficiency"].value == 1.0
    assert race.figures("kalman-cv")["velocity_efficiency"].value > 1
    assert "turns need two axes" in compare(short("wang-2010-step", 60), "all", runs=5).skipped["imm-cv-ct"]


def test_files_say_what_they_were_fitted_on(tmp_path):
    path = tmp_path / "mine.json"
    jink.Kalman(jink.ConstantVelocity(acceleration_sd=9.0), jink.Position(sd=50.0)).save(path)
    scenario = short("random-turns", 30)
    for fitted, here, in_sample in (
        ({"scenario": "random-turns", "seed": 3, "runs": 100}, True, False),
        ({"scenario": "random-turns", "seed": 4, "runs": 100}, True, True),
        ({"scenario": "lee-2003", "seed": 4, "runs": 100}, False, False),
        ({"scenario": "lee-2003,random-turns", "seed": 3, "runs": 100}, True, False),
    ):
        path.write_text(json.dumps({**json.loads(path.read_text()), "fitted": fitted}))
        body = compare(scenario, [str(path)], runs=5, seed=4).as_dict()
        assert bool(body["about"][str(path)]["fitted_on_this_scenario"]) == here
        assert body["about"][str(path)]["in_sample"] == in_sample
        assert bool(body["comparisons"][str(path)]) != in_sample


def refused(path, message, scenario="random-turns"):
    with pytest.raises(InputError, match=message):
        compare(short(scenario, 30), [str(path)], runs=2)


def test_filter_files_that_do_not_fit_are_refused(tmp_path):
    path = tmp_path / "f.json"
    refused(path, "no filter file")
    jink.Kalman(jink.ConstantVelocity(acceleration_sd=9.0), jink.Polar(range_sd=9.0, azimuth_sd=0.1)).save(path)
    refused(path, "the filter's sensor measures range, azimuth; expected x, y as in random-turns")
    refused(path, "the filter's sensor measures range, azimuth;", "terminal-area")
    body = json.loads(path.read_text())
    path.write_text(json.dumps({**body, "version": 99}))
    refused(path, "version 99")
    path.write_text(json.dumps({**body, "units": "km"}))
    refused(path, "units 'km'")
    path.write_text("{")
    refused(path, "not valid JSON")
    jink.Kalman(jink.ConstantVelocity(acceleration_sd=9.0), jink.Position(sd=9.0)).save(path)
    assert (
        "its own measurement noise is not that of the data, which it is given"
        in compare(short("random-turns", 30), [str(path)], 2).entrants[str(path)].note
    )


def test_interrupted_the_finished_runs_are_summarised(monkeypatch):
    scenario = short("random-turns", 40)
    monkeypatch.setattr(simulated, "CHUNK_ROWS", 400)

    def stop(done: int, runs: int) -> None:
        if done == 20:
            raise KeyboardInterrupt

    race = compare(scenario, runs=50, seed=3, progress=stop)
    assert race.partial and race.runs == 20 and race.as_dict()["partial"]
    there = compare(scenario, runs=20, seed=3)
    assert not there.partial
    for name in there.tallies:
        assert race.figure(name, "position_rmse") == there.figure(name, "position_rmse")


def test_interrupted_in_the_last_figures_all_runs_are_kept(monkeypatch):
    def stop(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(simulated.bounds, "posterior_bound", stop)
    scenario = short("random-turns", 20)
    race = compare(scenario, runs=10, seed=3)
    assert race.partial and race.runs == 10 and race.bound == {} and race.skipped["PCRB"] == "interrupted"
    assert race.figure("imm", "position_rmse").value > 0


def test_memory_is_the_same_for_many_runs(monkeypatch):
    scenario = short("random-turns", 5)
    race = compare(scenario, runs=2500)
    tally = race.tallies["kalman-cv"]
    assert all(len(values) == 1000 for values in tally.totals.values())
    assert all(len(values) == 100 for values in tally.curves.values())
    assert tally.runs.sum() == 2500
