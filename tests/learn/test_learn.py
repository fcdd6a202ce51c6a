"""`jink learn`: every recipe on simulated targets and on a file, what is written, what is refused, stopped and taken up
again.
"""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

import jink
from jink.cli.main import app
from jink.fit.data import SIMULATED_TRUTH, true_values
from jink.learn.learning import BASE, LEARNED, NAMED, learn
from jink.learn.recipes import RECIPES

SMALL = {
    "fuzzy-imm": {"generations": 4, "population": 30, "rules": 6},
    "fuzzy-kalman": {"generations": 4, "population": 30, "rules": 6},
    "anfis-kf": {"epochs": 3},
    "nn-kf": {"epochs": 5},
    "corrector": {"families": 20, "epochs": 1},
    "nnvsmm": {"epochs": 20},
    "nnvsmm-modes": {"labels": True, "epochs": 5},
}


def command(*arguments):
    return CliRunner().invoke(app, ["learn", *map(str, arguments)])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """24 runs with their truth, as jink simulate writes them."""
    path = tmp_path_factory.mktemp("learn") / "turns.parquet"
    done = CliRunner().invoke(app, ["simulate", "random-turns", "--runs", "24", "-o", str(path), "-q"])
    assert done.exit_code == 0, done.output
    return path


def test_every_recipe_is_tested():
    assert set(SMALL) == set(RECIPES)


@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe_learns_and_its_file_gives_the_same_filter(name, tmp_path):
    learned = learn(name, "random-turns", runs=24, check_runs=20, seed=3, **SMALL[name])
    assert np.isfinite(learned.race.figure(LEARNED, "position_rmse").value)
    assert "learned filter" in learned.verdict() and learned.verdicts()
    path = tmp_path / "learned.json"
    learned.save(path)
    rng = np.random.default_rng(0)
    t, z = np.arange(40.0), np.cumsum(rng.normal(100, 40, (40, 2)), axis=0)
    for output in ("x", "P", "log_likelihood_scan"):
        a, b = (getattr(f.filter(t, z), output) for f in (learned.filter, jink.load(path)))
        np.testing.assert_array_equal(a, b)
    said = json.loads(path.read_text())["fitted"]
    assert said["scenario"] == "random-turns" and said["seed"] == 3
    assert said["held_out"]["position_rmse"]["value"] == learned.race.figure(LEARNED, "position_rmse").value


@pytest.mark.parametrize("name", ["fuzzy-kalman", "nnvsmm", "nn-kf"])
def test_the_same_seed_learns_the_same_filter(name, tmp_path):
    for k in (1, 2):
        learn(name, "random-turns", runs=16, check_runs=5, seed=1, **SMALL[name]).save(tmp_path / f"{k}.json")
    assert (tmp_path / "1.json").read_bytes() == (tmp_path / "2.json").read_bytes()


def test_of_several_scenarios_the_first_is_raced_and_said():
    done = command("nn-kf", "benchmark-1,benchmark-3", "--runs", 6, "--check-runs", 4, "--epochs", 1)
    said = " ".join(done.output.split())
    assert done.exit_code == 0, done.output
    assert "the first of 2 scenarios; jink compare checks the filter on benchmark-3" in said


@pytest.mark.parametrize("base, below", [(None, "40 training runs"), ("kalman-cv", "training runs"), ("singer", "")])
def test_what_an_aid_stands_on_is_marked_where_it_was_fitted_here(base, below):
    learned = learn("nn-kf", "benchmark-1", runs=40, check_runs=10, base=base, epochs=1)
    entrants = learned.race.entrants
    assert below in entrants[BASE].fitted and bool(below) == bool(entrants[BASE].fitted)
    # its own base is a Kalman filter that is tuned on runs of this scenario
    assert entrants[NAMED].fitted == entrants["kalman-ca"].fitted != ""


def test_an_aid_is_compared_with_the_filter_it_aids_and_helps_a_sluggish_one():
    sluggish = jink.Kalman(
        jink.ConstantAcceleration(jerk_psd=1e-4, acceleration_prior_sd=10.0), jink.Position(sd=50.0, axes=2)
    )
    learned = learn("nn-kf", "random-turns", runs=40, check_runs=60, base=sluggish, epochs=30)
    gain = learned.race.compare(LEARNED, BASE)
    assert gain.verdict == "better"
    assert gain.difference < -0.3 * learned.race.figure(BASE, "position_rmse").value


def test_rules_learned_from_a_file_are_written_shown_and_track_it(recorded, tmp_path):
    out, page = tmp_path / "rules.json", tmp_path / "rules.html"
    done = command(
        "fuzzy-imm",
        recorded,
        "-o",
        out,
        "--report",
        page,
        "--generations",
        4,
        "--population",
        30,
        "--inputs",
        "1,30",
    )
    assert done.exit_code == 0, done.output
    said = " ".join(done.output.split())
    assert "with truth" in said and "On held-out data the learned filter" in said
    filter = jink.load(out)
    assert len(filter.modes) == 2
    words = [line for motion in filter.motions for line in motion.rules.describe()]
    text = page.read_text()
    assert text.count("<svg") == 2
    # the marks of the terminal's table, and what they mean
    assert "learned *</th>" in text and "kalman-cv *</th>" in text and "* fitted on other rows of this file" in text
    assert text.count("then the acceleration noise has sd") == len(words)
    tracked = CliRunner().invoke(
        app, ["track", str(recorded), "--filter", str(out), "-o", str(tmp_path / "t.parquet"), "-q"]
    )
    assert tracked.exit_code == 0, tracked.output
    assert not list(tmp_path.glob("*.npz"))


def test_json_says_everything_in_numbers(recorded):
    done = command("nn-kf", recorded, "--epochs", 3, "--json")
    assert done.exit_code == 0, done.output
    body = json.loads(done.stdout)
    assert {"raw", "kalman-cv", "imm", LEARNED, BASE} <= set(body["held_out"]["filters"])
    assert body["filter"] == "nn-kf" and body["warnings"]


def test_the_file_s_race_is_the_error_against_its_truth(recorded):
    """Recomputed by hand for the raw measurements, over the rows held out."""
    import polars as pl

    from jink.fit.fitting import training_data

    learned = learn("nn-kf", str(recorded), epochs=2)
    training = training_data(str(recorded), runs=1, check_runs=1, seed=0, kind="aircraft", columns=None, truth="true")
    owners = set(training.held_out.owner.tolist())
    table = pl.read_parquet(recorded).filter(pl.col("target").cast(str).is_in(owners) & (pl.col("scan") >= 3))
    error = (pl.col("x") - pl.col("true_x")) ** 2 + (pl.col("y") - pl.col("true_y")) ** 2
    counted = training.held_out.counts.sum()
    by_hand = np.sqrt(table.select(error).to_series().mean())
    assert abs(counted - table.height) <= len(owners)
    assert learned.race.figure("raw", "position_rmse").value == pytest.approx(by_hand, rel=1e-3)


PUBLISHED = ["--inputs", "titi-guney", "--functions", 4, "--membership", "triangular"]
PUBLISHED += ["--method", "backpropagation", "--epochs", 10]


def test_an_anfis_is_trained_as_published_from_the_command_line(tmp_path):
    """Titi & Güney: two inputs, four triangular functions each, ten epochs of backpropagation, the position alone."""
    base, out = tmp_path / "slow.json", tmp_path / "aid.json"
    sensor = jink.Position(sd=50.0, axes=3)
    jink.Kalman(jink.ConstantAcceleration(jerk_psd=0.05, acceleration_prior_sd=10.0), sensor).save(base)
    done = command("anfis-kf", "benchmark-1", *PUBLISHED, "--base", base, "--runs", 8, "--check-runs", 20, "-o", out)
    assert done.exit_code == 0, done.output
    corrector = jink.load(out).corrector
    assert corrector.inputs == "titi-guney" and corrector.corrects == ("position",)
    assert corrector.model.shape == "triangular" and [len(m) for m in corrector.model.memberships] == [4, 4]
    assert "10 epochs of backpropagation, gain " in corrector.trained.method
    assert "against unaided: position better" in " ".join(done.output.split())


def test_an_anfis_on_sums_of_innovations_from_the_command_line(tmp_path):
    out = tmp_path / "aid.json"
    asked = ["--inputs", "sums", "--functions", 2, "--epochs", 2, "--runs", 8, "--check-runs", 10]
    done = command("anfis-kf", "benchmark-1", *asked, "-o", out)
    assert done.exit_code == 0, done.output
    corrector = jink.load(out).corrector
    assert corrector.inputs == "sums" and [len(m) for m in corrector.model.memberships] == [2] * 4
    assert "sums of the last 1, 2, 4 and 8 innovations" in corrector.trained.method
    # of position and velocity: acceleration is not part of the truth that is learned on
    assert len(corrector.sd_factors) == 2


def test_a_base_of_one_axis_is_aided_on_data_of_two(recorded):
    motion = jink.ConstantAcceleration(jerk_psd=1e-3, acceleration_prior_sd=10.0)
    alone = jink.Kalman(motion, jink.Position(sd=50.0, axes=1))
    learned = learn("nn-kf", "random-turns", runs=16, check_runs=20, base=alone, epochs=10)
    assert learned.filter.axes == 1 and learned.race.compare(LEARNED, BASE).verdict == "better"


@pytest.mark.parametrize("labels", [True, "argmin"])
def test_labels_suit_the_sensor_and_the_targets(labels):
    """With levels of 1 to 196 m²/s⁴ the network was worse than the measurements, whose sd is 500 m here."""
    learned = learn("nnvsmm", "random-turns", kind="fighter", runs=60, check_runs=60, labels=labels, epochs=60)
    assert learned.race.compare(LEARNED, "raw").verdict == "better"


def test_a_network_scores_a_bank_of_motions(tmp_path):
    """As asked for, scaled by what the targets pull; the file is read back and tracks as the filter did."""
    out = tmp_path / "bank.json"
    asked = ["--bank", "cv,ca, ct", "--runs", 16, "--check-runs", 20, "--epochs", 20, "--acceleration", 30]
    done = command("nnvsmm-modes", "random-turns", *asked, "-o", out)
    assert done.exit_code == 0, done.output
    filter = jink.load(out)
    kinds = [type(motion).__name__ for motion in filter.motions]
    assert kinds == ["ConstantVelocity"] * 3 + ["ConstantAcceleration", "CoordinatedTurn"]
    assert [m.acceleration_sd for m in filter.motions[:3]] == pytest.approx([0.03, 3.0, 30.0])
    assert filter.motions[3].acceleration_prior_sd == 30.0 and filter.motions[4].acceleration_psd == 1.5**2
    assert filter.network.best == 3 and "best of 5 modes" in filter.network.trained.method


def test_the_range_of_labels_follows_the_acceleration():
    common = {"runs": 8, "check_runs": 4, "labels": True, "epochs": 2}
    for acceleration in (10.0, 80.0):
        network = learn("nnvsmm", "random-turns", acceleration=acceleration, **common).filter.motions[0].network
        assert network.least == pytest.approx((1e-3 * acceleration) ** 2)
        assert network.most == pytest.approx((3 * acceleration) ** 2)


def test_published_labels_have_the_paper_s_levels_in_units_of_the_sensor():
    """1 to 196 where sd²/T⁴ is one: times 50² for a sensor of 50 m once a second."""
    learned = learn("nnvsmm", "random-turns", runs=8, check_runs=4, labels="argmin", epochs=2)
    network = learned.filter.motions[0].network
    assert (network.least, network.most) == (1.0 * 50**2, 196.0 * 50**2)
    assert network.inputs == "likelihood" and network.output == "variance"


class Stop(KeyboardInterrupt):
    pass


@pytest.mark.parametrize("optimiser", ["ga", "cma", "together"])
def test_a_search_stopped_and_taken_up_finds_the_same_rules(optimiser, tmp_path):
    common = {
        "runs": 12,
        "check_runs": 5,
        "optimiser": optimiser,
        "generations": 8,
        "population": 20,
        "rules": 4,
    }
    name = "fuzzy-imm"
    learn(name, "random-turns", **common).save(tmp_path / "whole.json")
    calls = 0

    def stop(words, done, of):
        nonlocal calls
        calls += 1
        if calls == 11 or (optimiser == "together" and calls == 5):
            raise Stop

    kept = tmp_path / "kept"
    with pytest.raises(KeyboardInterrupt):
        learn(name, "random-turns", checkpoint=kept, progress=stop, **common)
    assert list(tmp_path.glob("kept.*.npz"))
    learn(name, "random-turns", checkpoint=kept, **common).save(tmp_path / "resumed.json")
    assert (tmp_path / "resumed.json").read_bytes() == (tmp_path / "whole.json").read_bytes()


def test_a_checkpoint_of_other_data_is_refused(tmp_path):
    common = {
        "check_runs": 5,
        "generations": 3,
        "population": 20,
        "rules": 4,
        "checkpoint": tmp_path / "kept",
    }
    learn("fuzzy-kalman", "random-turns", runs=12, **common)
    with pytest.raises(ValueError, match="written by another search"):
        learn("fuzzy-kalman", "random-turns", runs=13, **common)


def test_an_interrupt_at_the_terminal_keeps_the_checkpoint_and_says_so(recorded, tmp_path, monkeypatch):
    import jink.learn.population as population

    real, calls = population.errors_of, []

    def sometimes(*arguments, **more):
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return real(*arguments, **more)

    monkeypatch.setattr("jink.learn.genetic.errors_of", sometimes)
    out = tmp_path / "rules.json"
    asked = ["fuzzy-kalman", recorded, "-o", out, "--generations", 6, "--population", 20]
    done = command(*asked)
    assert done.exit_code == 130 and "--resume" in done.stderr and not out.exists()
    assert list(tmp_path.glob("*.npz"))
    again = command(*asked, "--resume")
    assert again.exit_code == 0, again.output
    assert out.exists() and not list(tmp_path.glob("*.npz"))
    assert len(calls) == 3 + 1 + 3  # three generations, the stop, and the three that were missing


BAD = {
    "unknown name": (["fuzzy-im", "lee-2003"], "fuzzy-imm"),
    "no file": (["nn-kf", "nowhere.parquet"], "nowhere.parquet"),
    "no truth": (["nn-kf", "examples/flights.parquet"], "jink fit"),
    "not a recipe's option": (["nn-kf", "lee-2003", "--optimizer", "cma"], "--optimizer"),
    "no such optimizer": (["fuzzy-imm", "lee-2003", "--optimizer", "annealing"], "ga, cma, together"),
    "one axis": (["nnvsmm", "lee-2003"], "two axes"),
    "one mode": (["fuzzy-imm", "lee-2003", "--inputs", "3"], "at least two modes"),
    "no number": (["fuzzy-imm", "lee-2003", "--inputs", "a,b"], "--inputs"),
    "no filter file": (["nn-kf", "lee-2003", "-o", "out.txt"], ".json"),
    "no base": (["nn-kf", "lee-2003", "--base", "kalman-xx"], "kalman-cv"),
    "base of rules": (["fuzzy-imm", "lee-2003", "--base", "imm"], "--base"),
    "labels of an aid": (["nn-kf", "lee-2003", "--labels"], "--labels"),
    "resume of a network": (["nn-kf", "lee-2003", "--resume"], "nn-kf does not have it"),
    "resume from nothing": (["fuzzy-imm", "lee-2003", "--resume"], "--checkpoint"),
    "too few": (["nn-kf", "lee-2003", "--runs", "1"], "at least 4"),
    "weight": (["fuzzy-imm", "lee-2003", "--weight", "2"], "--weight"),
    "acceleration": (["fuzzy-imm", "lee-2003", "--acceleration", "-1"], "--acceleration"),
    "no noise": (["fuzzy-imm", "lee-2003", "--process-sd", "0"], "--process-sd"),
    "noise of one mode": (["fuzzy-kalman", "lee-2003", "--process-sd", "1"], "--process-sd"),
    "noise of all modes": (["fuzzy-imm", "lee-2003", "--process-sd", "1", "--optimizer", "together"], "--process-sd"),
    "inputs of a network": (["nn-kf", "lee-2003", "--own-inputs"], "--own-inputs"),
    "inputs of all modes": (["fuzzy-imm", "lee-2003", "--own-inputs", "--optimizer", "together"], "--own-inputs"),
    "no such inputs": (["anfis-kf", "lee-2003", "--inputs", "1,10"], "titi-guney, innovations"),
    "sums of too many functions": (
        ["anfis-kf", "lee-2003", "--inputs", "sums", "--functions", "5"],
        "at most 256 rules",
    ),
    "sums of a filter of rules": (["fuzzy-imm", "lee-2003", "--inputs", "sums"], "--inputs"),
    "no such form": (["anfis-kf", "lee-2003", "--membership", "square"], "triangular, gaussian, bell"),
    "no such method": (["anfis-kf", "lee-2003", "--method", "annealing"], "hybrid, backpropagation"),
    "too many rules": (["anfis-kf", "lee-2003", "--functions", "4"], "at most 256 rules"),
    "no function": (["anfis-kf", "lee-2003", "--functions", "0"], "functions is 0"),
    "functions of a network": (["nn-kf", "lee-2003", "--functions", "3"], "--functions"),
    "both labels": (["nnvsmm", "random-turns", "--labels", "--argmin-labels"], "give one"),
    "labels of modes": (["nnvsmm-modes", "random-turns", "--argmin-labels"], "--argmin-labels"),
    "bank of a noise": (["nnvsmm", "random-turns", "--bank", "cv,ca"], "--bank is an option for nnvsmm-modes"),
    "no such bank": (["nnvsmm-modes", "random-turns", "--bank", "cv,singer"], "expected some of cv, ca, ct, each once"),
    "twice in a bank": (["nnvsmm-modes", "random-turns", "--bank", "cv,cv"], "each once, got cv,cv"),
    "a bank of one": (["nnvsmm-modes", "random-turns", "--bank", "ct"], "expected at least two, for example cv,ct"),
    "bank and inputs": (["nnvsmm-modes", "random-turns", "--bank", "cv,ca", "--inputs", "1,9"], "give one"),
    "along the track one by one": (["fuzzy-imm", "random-turns", "--along-track"], "give --optimizer together"),
    "along a track of a network": (["nnvsmm", "random-turns", "--along-track"], "--along-track is an option for"),
    "along a track of one axis": (
        ["fuzzy-imm", "lee-2003", "--along-track", "--optimizer", "together"],
        "two or three axes, got one",
    ),
    "no runs": (["fuzzy-imm", "lee-2003", "--runs", "0"], "--runs"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_done_is_said_before_anything_runs(case):
    arguments, expected = BAD[case]
    done = command(*arguments)
    assert done.exit_code == 2, done.output
    assert expected in done.stderr


@pytest.mark.parametrize(
    "wrong",
    [
        {"true_velocity_x": pl.col("true_velocity_x") * 1.94384},  # kt
        {"true_velocity_x": pl.col("true_velocity_y"), "true_velocity_y": pl.col("true_velocity_x")},
        {"time": (pl.col("time") * 1000).cast(pl.Int64)},  # ms, taken for s
    ],
)
def test_true_velocities_that_lead_elsewhere_are_refused(recorded, tmp_path, wrong):
    path = tmp_path / "wrong.parquet"
    pl.read_parquet(recorded).with_columns(**wrong).write_parquet(path)
    done = command("nn-kf", path, "--kind", "fighter", "--epochs", 1, "-q")
    assert done.exit_code == 2 and "vx leads elsewhere than px" in " ".join(done.output.split())


def test_units_in_names_of_true_columns_count(recorded, tmp_path):
    """Knots under a name that says so were taken for m/s, and refused."""
    table, path = pl.read_parquet(recorded), tmp_path / "units.parquet"
    names = {"true_velocity_x": "vx_kt", "true_velocity_y": "vy_kt", "true_x": "x_km", "true_y": "north_nmi"}
    factors = dict(zip(names, (3600 / 1852, 3600 / 1852, 1e-3, 1 / 1852), strict=True))
    table.with_columns(pl.col(n) * f for n, f in factors.items()).rename(names).write_parquet(path)
    row = np.arange(table.height)
    truth = {"px": "x_km", "py": "north_nmi", "vx": "vx_kt", "vy": "vy_kt"}
    wanted = true_values(str(recorded), row, {c: SIMULATED_TRUTH[c] for c in truth})
    np.testing.assert_allclose(true_values(str(path), row, truth), wanted, rtol=1e-12)


@pytest.mark.parametrize("late", [0, 1])
def test_a_truth_that_is_a_row_late_is_said(recorded, tmp_path, late):
    path = tmp_path / "late.parquet"
    table = pl.read_parquet(recorded)
    true = [name for name in table.columns if name.startswith("true_")]
    table.with_columns(pl.col(true).shift(late).over("target")).write_parquet(path)
    learned = learn("nn-kf", str(path), kind="fighter", epochs=1)
    assert any("from the truth" in line for line in learned.warnings) == bool(late)


def test_truth_of_other_targets_is_refused(recorded):
    done = command("nn-kf", recorded, "--truth", "px=true_y,py=true_x")
    assert done.exit_code == 2 and "Check that the truth is of these targets" in done.stderr


def test_rules_need_true_velocities(recorded):
    done = command("fuzzy-imm", recorded, "--truth", "px=true_x,py=true_y")
    assert done.exit_code == 2 and "vx=" in done.stderr
