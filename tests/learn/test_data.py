"""Training data: files with truth as jink simulate writes them, the split by run."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import jink
from jink.cli.simulate import SimulateRequest, run_simulate
from jink.filters.aided import Aided
from jink.learn import genetic as ga
from jink.learn.aid import fit_corrector, position_rms
from jink.learn.data import from_file, from_scenario

SENSOR = jink.Position(sd=50.0, axes=1)
SLUGGISH = jink.Kalman(jink.ConstantAcceleration(jerk_psd=1e-3), SENSOR)


def simulated(path, name="benchmark-1", runs=9, sensor="50", interval=1.0):
    """A file as the command writes it."""
    request = SimulateRequest(
        name=name, runs=runs, seed=4, output=str(path), sensor=sensor, interval=interval, quiet=True
    )
    assert run_simulate(request) == 0
    return path


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_file_holds_what_the_scenario_gives(ending, tmp_path):
    runs = from_file(simulated(tmp_path / f"runs.{ending}", runs=3), 50.0)
    expected = from_scenario("benchmark-1", 3, 4, sensor=50.0, interval=1.0)
    assert (len(runs), runs.axes, runs.sd) == (3, expected.axes, 50.0)
    for name in ("time", "z", "position", "velocity", "acceleration"):
        assert_allclose(getattr(runs, name), getattr(expected, name), rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_an_aid_is_trained_from_a_file_and_used_from_its_own(ending, tmp_path):
    """File in, filter file out; judged on the runs that were kept back."""
    runs = from_file(simulated(tmp_path / f"runs.{ending}", runs=20), 50.0).along([1])
    training, validation, test = runs.split(seed=1)
    corrector = fit_corrector(SLUGGISH, training, validation, epochs=20)
    Aided(SLUGGISH, corrector).save(tmp_path / "aided.json")
    aided = jink.load(tmp_path / "aided.json")
    x = aided.filter(**test.batch(), outputs=("x",)).x[:, 0].reshape(test.z.shape[:2])
    rms = np.sqrt(np.nanmean((x - test.position[..., 0]) ** 2))
    assert rms < 0.3 * position_rms(SLUGGISH, test)[0]


def test_fuzzy_rules_are_identified_from_a_file(tmp_path):
    """Shorter runs and misses are no hindrance; the fitness grows over that of the first generation."""
    path = simulated(tmp_path / "runs.csv", "lee-2003", 2, "500", None)
    table = pl.read_csv(path)
    rows = pl.int_range(pl.len()).over("target")
    table = table.filter((pl.col("target") != table["target"][0]) | (rows < 120))
    table.with_columns(x=pl.when(rows % 10 == 7).then(None).otherwise("x")).write_csv(path)
    runs = from_file(path, 500.0)
    assert np.isnan(runs.z[0, 120:]).all() and np.isnan(runs.z[1, 7, 0]) and np.isfinite(runs.z[1, 7, 1])
    said = []
    settings = ga.Settings(generations=8, population=30, most_rules=5)
    rules = ga.identify(10.0, runs, settings=settings, progress=lambda g, fitness, n: said.append(fitness))
    assert said[-1] > said[0] and 1 <= len(rules) <= 5
    assert rules.trained is not None and str(path) in rules.trained.data


def test_a_file_without_truth_or_with_another_column_is_refused(tmp_path):
    path = simulated(tmp_path / "runs.csv", runs=1)
    pl.read_csv(path).drop("true_velocity_y").write_csv(path)
    with pytest.raises(ValueError, match=r"runs\.csv: column 'true_velocity_y' is missing; expected measurements"):
        from_file(path, 50.0)
    with pytest.raises(ValueError, match="sd: expected"):
        from_file(simulated(tmp_path / "more.csv", runs=1), -1.0)


def test_the_split_is_by_run_and_by_seed():
    runs = from_scenario("choi-2001-1", 10, 1)
    parts = runs.split(seed=3)
    assert [len(part) for part in parts] == [6, 2, 2]
    assert sorted(np.concatenate([part.numbers for part in parts])) == list(range(10))
    for part in parts:
        assert_array_equal(part.z, runs.z[part.numbers])
    again, other = (runs.split(seed=seed)[2].numbers for seed in (3, 4))
    assert_array_equal(again, parts[2].numbers)
    assert not np.array_equal(other, parts[2].numbers)
    with pytest.raises(ValueError, match="runs: expected at least 3 to split, got 2"):
        runs.take([0, 1]).split()
