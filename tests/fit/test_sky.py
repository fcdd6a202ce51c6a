"""Detection, false plots, new targets and noise are fitted to plots without identity."""

import json

import numpy as np
import polars as pl
import pytest
from oracle.association import enumerated
from typer.testing import CliRunner

import jink
from jink.cli.main import app
from jink.fit.sky import fit_sky
from jink.scenarios.skies import sky_called

BOX = (0.0, 10e3, 0.0, 8e3)


def plots_of(name, run, seed):
    scans = sky_called(name).run(run, seed).scans
    return pl.concat([pl.DataFrame({"time": s.time, "x": s.z[:, 0], "y": s.z[:, 1]}) for s in scans])


def tracker_of(detection=0.8, clutter=4.0):
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=50.0))
    radar = jink.Radar(detection=detection, clutter_per_scan=clutter, area=BOX, learn_clutter=False)
    tracker = jink.Tracker(filter, radar, targets=0.0, new_per_hour=0.0)
    tracker.rules.likelihood = True
    tracker.reset()
    return tracker


def test_the_likelihood_of_a_scan_is_the_sum_over_all_assignments():
    """Two known targets, three plots: every assignment by itself, false plots Poisson."""
    detection, clutter, area = 0.8, 4.0, 80e6
    tracker = tracker_of(detection, clutter)
    places = np.array([[4000.0, 4000.0], [4100.0, 4050.0]])
    for place in places:
        tracker.add(0.0, [place[0], 0.0, place[1], 0.0], np.diag([400.0, 1e-6, 400.0, 1e-6]), 0.7)
    z = np.array([[4010.0, 4020.0], [4120.0, 4030.0], [9000.0, 1000.0]])
    got = tracker.scan(0.0, z).report["log_likelihood"]
    S = 400.0 + 50.0**2
    distance = ((z[None] - places[:, None]) ** 2).sum(axis=2) / S
    density = np.exp(-distance / 2) / (2 * np.pi * S)
    r = 0.7
    psi = np.where(distance < 16, r * detection * density / ((1 - r * detection) * clutter / area), 0.0)
    _, _, lone = enumerated(psi)
    # Σ over assignments of Π psi, from the probability that no plot is a track's, whose weight is one
    total = 1 / _nothing(psi)
    want = -clutter + 3 * np.log(clutter / area) + 2 * np.log(1 - r * detection) + np.log(total)
    # two tracks and two plots make a circle: Bethe's sum is at most the true one, and at least half of it
    assert want - np.log(2) <= got <= want + 1e-3
    assert lone[2] == pytest.approx(1.0)


def _nothing(psi):
    """Probability of the assignment in which no track has a plot."""
    weight = 1.0 + psi.sum()
    weight += sum(psi[0, j] * psi[1, k] for j in range(3) for k in range(3) if j != k)
    return 1.0 / weight


def test_one_track_alone_is_exact_and_only_where_it_is_asked_for():
    tracker = tracker_of()
    tracker.add(0.0, [4000.0, 0.0, 4000.0, 0.0], np.diag([400.0, 1e-6, 400.0, 1e-6]), 0.9)
    got = tracker.scan(0.0, [[4030.0, 3990.0]]).report["log_likelihood"]
    S = 2900.0
    seen = 0.9 * 0.8 * np.exp(-(30**2 + 10**2) / S / 2) / (2 * np.pi * S)
    want = -4.0 + np.log((1 - 0.72) * 4.0 / 80e6 + seen)
    assert got == pytest.approx(want, abs=1e-9)
    nothing = tracker.scan(4.0, np.zeros((0, 2))).report["log_likelihood"]
    assert nothing < -4.0
    tracker.rules.likelihood = False
    tracker.reset()
    assert "log_likelihood" not in tracker.scan(0.0, [[1.0, 2.0]]).report


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("fit") / "plots.parquet"
    plots_of("sky-parallel-200", 1, 77).write_parquet(path)
    return path


def test_what_the_sensor_does_is_found_again(file):
    """106 looks at a target: sd of detection √(.9 × .1 / 106) = .03; 1113 false plots: 3 %; 190 coordinates: 5 %."""
    fit = fit_sky(str(file), fixed=["new_per_hour"])
    assert fit.values["detection"] == pytest.approx(0.9, abs=3 * 0.03)
    assert fit.values["clutter"] == pytest.approx(21, rel=3 * 0.03)
    assert fit.values["position_sd"] == pytest.approx(50, rel=3 * 0.05)
    assert fit.after[0] >= fit.before[0] - 1e-3 and not fit.partial
    rows = {row["parameter"]: row for row in fit.parameters}
    assert rows["position_sd"]["low"] < fit.values["position_sd"] < rows["position_sd"]["high"]
    assert rows["new_per_hour"]["low"] is None and rows["new_per_hour"]["after"] == rows["new_per_hour"]["before"]


def run(*arguments):
    result = CliRunner(env={"COLUMNS": "200"}).invoke(app, [str(a) for a in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr


def test_a_file_without_identity_is_fitted_so_by_itself(file, tmp_path):
    fixed = ["--fix", "new_per_hour,position_sd,clutter"]
    status, said, _ = run("fit", file, *fixed, "-o", tmp_path / "f.json", "--json")
    found = json.loads(said)
    assert status == 0 and found["objective"] == "likelihood"
    assert {row["parameter"] for row in found["parameters"]} == {"detection", "clutter", "new_per_hour", "position_sd"}
    assert "--detection" in found["options"]
    status, said, _ = run("track", file, "--filter", tmp_path / "f.json", *found["options"].split(), "--json")
    assert status == 0 and json.loads(said)["targets"] >= 2


@pytest.mark.parametrize(
    "options, says",
    [
        (["--search"], "--search: plots without identity are fitted by likelihood alone"),
        (["--truth", "true"], "--truth: plots without identity"),
        (["--fix", "colour"], "no parameter 'colour'; expected some of detection, clutter"),
        (["--fix", "*"], "no parameter is left to fit"),
        (["--filter", "gpb2"], "cannot track plots without identity"),
    ],
)
def test_what_makes_no_sense_is_refused_with_status_2(file, options, says):
    status, _, said = run("fit", file, *options)
    assert status == 2 and says in said


def test_too_few_scans_are_refused(tmp_path):
    plots_of("sky-parallel-200", 1, 77).filter(pl.col("time") < 60).write_parquet(tmp_path / "few.parquet")
    status, _, said = run("fit", tmp_path / "few.parquet")
    assert status == 2 and "15 scans are too few to fit; expected at least 20" in said


def test_compare_says_what_such_a_file_is_for(file):
    status, _, said = run("compare", file)
    assert status == 2 and "plots have no identity" in said and "jink track" in said


def test_a_number_of_the_filter_is_fitted_too_where_asked_for(file):
    fit = fit_sky(str(file), "kalman-cv", free=["*acceleration*"], fixed=["*"], minutes=0.2)
    own = [row for row in fit.parameters if not row["sensor"]]
    assert len(own) == 1 and own[0]["after"] > 0
    assert fit.after[0] > fit.before[0] - 1e-3
