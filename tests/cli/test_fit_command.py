"""jink fit at the shell: truth from a file, Ctrl-C and --resume, and what is wrong with an input said in one line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import jink
from jink.cli.fit import FitRequest, run_fit
from jink.cli.simulate import SimulateRequest, run_simulate

FLIGHTS = str(Path(__file__).resolve().parents[2] / "examples" / "flights.parquet")


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Twenty runs of random turns with their truth, as jink simulate writes them."""
    path = str(tmp_path_factory.mktemp("fit") / "turns.parquet")
    request = SimulateRequest(name="random-turns", runs=20, seed=3, output=path, kind="fighter", quiet=True)
    assert run_simulate(request) == 0
    return path


def failure(capsys, **request):
    """What a refused request says."""
    assert run_fit(FitRequest(**request)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("jink: ") and said.err.count("\n") == 1
    return said.err


def test_truth_from_a_file(simulated, tmp_path, capsys):
    """The objective is then the error against it, and the fit gains in it."""
    out = tmp_path / "fitted.json"
    request = FitRequest(
        data=simulated, filter="imm-cv-ct", truth="true", kind="fighter", starts=1, output=str(out), json=True
    )
    assert run_fit(request) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["objective"] == "tracking"
    assert said["after"] < said["before"]
    assert jink.load(out).fitted["objective"] == "tracking"
    assert not out.with_name("fitted.json.checkpoint").exists()
    named = FitRequest(data=simulated, filter="cv", truth="px=true_x,py=true_y", starts=1, quiet=True)
    assert run_fit(named) == 0


def test_a_truth_that_is_not_the_targets(simulated, tmp_path, capsys):
    import polars as pl

    frame = pl.read_parquet(simulated)
    moved = tmp_path / "moved.parquet"
    frame.with_columns(pl.col("true_x") + 5e4).write_parquet(moved)
    said = failure(capsys, data=str(moved), truth="true")
    assert "the median distance of px from the measured position is 5e+04 m" in said
    assert "Check that the truth is of these targets" in said
    assert "has no column 'truth_x'" in failure(capsys, data=simulated, truth="px=truth_x")
    assert "expected COMPONENT=COLUMN" in failure(capsys, data=simulated, truth="px:true_x")
    assert "needs the truth" in failure(capsys, data=simulated, objective="tracking")
    assert "a scenario brings its own truth" in failure(capsys, data="random-turns", truth="true")


def table(path, x, y):
    lines = [
        f"{target},{k * 2.0},{a:.3f},{b:.3f}"
        for target in x
        for k, (a, b) in enumerate(zip(x[target], y[target], strict=True))
    ]
    path.write_text("target,time,x,y\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def test_too_little_data(tmp_path, capsys):
    """Too few rows for the parameters are an error, few targets a warning."""
    rng = np.random.default_rng(0)

    def moving(scans, targets):
        x = {f"t{b}": np.arange(scans) * 60.0 + rng.normal(0, 10, scans) for b in range(targets)}
        return x, {name: rng.normal(0, 10, scans) for name in x}

    few = table(tmp_path / "few.csv", *moving(30, 2))
    assert "rows are too few to fit" in failure(capsys, data=few)
    assert ", ten for each" in failure(capsys, data=few)
    some = table(tmp_path / "some.csv", *moving(300, 3))
    assert run_fit(FitRequest(data=some, filter="cv", starts=1, json=True)) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert any(line.startswith("little data: ") and "targets" in line for line in warnings)


def test_positions_that_never_change(tmp_path, capsys):
    still = {f"t{b}": np.full(200, 100.0 * b) for b in range(10)}
    said = failure(capsys, data=table(tmp_path / "still.csv", still, still))
    assert "never change" in said or "no row is left" in said


def test_checkpoints(simulated, tmp_path, capsys):
    kept = str(tmp_path / "kept")
    assert "does not exist" in failure(capsys, data=simulated, filter="cv", checkpoint=kept, resume=True)
    assert "resume: expected checkpoint" in failure(capsys, data=simulated, filter="cv", resume=True)
    assert run_fit(FitRequest(data=simulated, filter="cv", starts=1, checkpoint=kept, quiet=True)) == 0
    said = failure(capsys, data=FLIGHTS, filter="cv", starts=1, checkpoint=kept, resume=True)
    assert "different data" in said
    body = json.loads(Path(kept).read_text(encoding="utf-8"))
    body["state"] = {"stage": "seven"}
    Path(kept).write_text(json.dumps(body), encoding="utf-8")
    assert run_fit(FitRequest(data=simulated, filter="cv", starts=1, checkpoint=kept, resume=True)) == 2


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_ctrl_c_keeps_the_best_so_far_and_resume_ends_the_fit(tmp_path):
    """Exit status 130, the filter written and marked partial in the JSON; taken up again the fit ends with status 0."""
    out = tmp_path / "fitted.json"
    command = [
        sys.executable,
        "-m",
        "jink",
        "fit",
        "random-turns",
        "--filter",
        "imm-cv-ct",
        "--runs",
        "400",
        "--check-runs",
        "20",
        "--starts",
        "2",
        "--minutes",
        "30",
        "-o",
        str(out),
        "--json",
    ]
    kept = out.with_name("fitted.json.checkpoint")
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not kept.exists():
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    said, errors = process.communicate()
    assert process.returncode == 130, errors
    body = json.loads(said)
    assert body["partial"] and any("cut short" in line for line in body["warnings"])
    # stopped before the first better step it is the same filter, whose parameters went through logarithms and back:
    # each is off by a few 1e-16, and so is the figure
    assert body["after"] <= body["before"] * (1 + 1e-12)
    assert jink.load(out).modes == ("constant_velocity", "coordinated_turn")
    assert kept.exists()
    done = subprocess.run([*command, "--resume"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["after"] <= body["after"]
    assert not kept.exists()
