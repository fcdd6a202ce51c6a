"""A filter of one axis on several: what it gives along each, in batches, live, from files, and in a fit."""

from __future__ import annotations

import io
import json
import subprocess
import sys

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from typer.testing import CliRunner

import jink
from jink.cli.main import app
from jink.filters.axis_by_axis import on_axes
from jink.filters.fuzzy_imm import fuzzy_imm
from jink.fit.fitting import fit

ONE = fuzzy_imm(jink.Position(sd=500.0, axes=1))
OFFSETS = np.array([0, 40, 100, 101])


def situation(axes: int, seed: int = 0):
    """Three tracks, one of a single row, with missing components."""
    rng = np.random.default_rng(seed)
    time = np.concatenate([np.arange(float(n)) for n in np.diff(OFFSETS)])
    z = rng.normal(0, 500.0, (101, axes)) + 30.0 * time[:, None] ** 1.5
    z[[7, 55]], z[20, 0] = np.nan, np.nan
    return time, z


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("verb", ["filter", "smooth"])
def test_every_axis_is_a_track_of_its_own(axes, verb):
    time, z = situation(axes)
    variances = np.random.default_rng(1).uniform(1e5, 4e5, z.shape)
    both = getattr(jink.AxisByAxis(ONE, axes), verb)(time, z, offsets=OFFSETS, covariance=variances)
    nis, score = np.zeros((2, 101))
    for k in range(axes):
        alone = getattr(ONE, verb)(time, z[:, k : k + 1], offsets=OFFSETS, covariance=variances[:, k : k + 1])
        own = slice(2 * k, 2 * k + 2)
        assert_array_equal(both.x[:, own], alone.x)
        assert_array_equal(both.P[:, own, own], alone.P)
        assert_array_equal(both.mode_probability[:, 3 * k : 3 * k + 3], alone.mode_probability)
        nis += np.nan_to_num(alone.nis)
        score += np.nan_to_num(alone.log_likelihood_scan)
    assert both.components == tuple(f"{c}{a}" for a in "xyz"[:axes] for c in "pv")
    assert not both.P[:, 0:2, 2:4].any()
    assert_allclose(np.nan_to_num(both.nis), nis, rtol=1e-12)
    assert_allclose(np.nan_to_num(both.log_likelihood_scan), score, rtol=1e-12)
    assert both.nis_dof[20] == axes - 1 and both.nis_dof[30] == axes and both.nis_dof[7] == 0
    assert both.log_likelihood.shape == (3,)


def test_a_target_manoeuvres_where_it_does_along_any_axis():
    time, z = situation(2)
    both = jink.AxisByAxis(ONE, 2).filter(time, z, offsets=OFFSETS)
    alone = [ONE.filter(time, z[:, k : k + 1], offsets=OFFSETS).manoeuvring for k in range(2)]
    assert np.isfinite(alone[0]).all()
    assert_allclose(both.manoeuvring, 1 - (1 - alone[0]) * (1 - alone[1]), rtol=1e-12)


def test_live_gives_what_a_batch_gives():
    time, z = situation(3)
    filter = jink.AxisByAxis(ONE, 3)
    rows = slice(40, 100)
    batch = filter.filter(time[rows], z[rows])
    many, one = filter.start(2), filter.start()
    for k, (t, row) in enumerate(zip(time[rows], z[rows], strict=True)):
        ahead = many.predict(t + 1.0)
        assert ahead.x.shape == (2, 6)
        for estimate in (many.update(t, np.stack([row, row])), one.update(t, row)):
            assert_allclose(np.atleast_2d(estimate.x)[0], batch.x[k], rtol=1e-9)
            assert_allclose(np.atleast_2d(estimate.mode_probability)[-1], batch.mode_probability[k], rtol=1e-9)
    again = filter.start(2, state=many.save())
    assert_array_equal(again.predict(70.0).x, many.predict(70.0).x)


def test_statuses_that_differ():
    filter = jink.AxisByAxis(jink.Kalman(jink.ConstantVelocity(acceleration_sd=1.0), jink.Position(sd=1.0, axes=1)), 2)
    z = np.array([[0.0, 0.0], [1.0, np.nan], [2.0, 2.0], [3.0, np.nan], [np.nan, np.nan]])
    named = [jink.STATUS[k] for k in filter.filter(np.arange(5.0), z).status]
    alone = [jink.STATUS[k] for k in filter.filter_.filter(np.arange(5.0), z[:, 1:]).status]
    assert alone[3] == "predicted" and named[3] == "updated" and named[4] == "predicted"


def test_what_it_cannot_take_is_refused():
    with pytest.raises(ValueError, match="measures x alone"):
        jink.AxisByAxis(fuzzy_imm(jink.Position(sd=500.0, axes=2)), 2)
    with pytest.raises(ValueError, match="axes: expected a whole number from 2 to 3, got 1"):
        jink.AxisByAxis(ONE, 1)
    with pytest.raises(ValueError, match=r"z: expected shape \(N, 2\)"):
        jink.AxisByAxis(ONE, 2).filter(np.arange(3.0), np.zeros((3, 3)))
    with pytest.raises(TypeError, match="initial"):
        jink.AxisByAxis(ONE, 2).filter(np.arange(3.0), np.zeros((3, 2)), initial=jink.Prior(np.zeros(2), np.eye(2)))
    polar = jink.Polar(range_sd=10.0, azimuth_sd=0.01)
    assert on_axes(ONE, polar) is ONE


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Runs of lee-2003 as jink simulate writes them, and a filter of one axis as jink learn does."""
    folder = tmp_path_factory.mktemp("axes")
    path, rules = folder / "l.parquet", folder / "rules.json"
    done = CliRunner().invoke(app, ["simulate", "lee-2003", "--runs", "12", "-o", str(path), "-q"])
    assert done.exit_code == 0, done.output
    ONE.save(rules)
    return path, rules


def test_a_file_is_tracked_and_a_stream_gives_the_same(simulated, tmp_path):
    path, rules = simulated
    out = tmp_path / "t.parquet"
    done = CliRunner().invoke(app, ["track", str(path), "--filter", str(rules), "-o", str(out), "-q"])
    assert done.exit_code == 0, done.output
    table, data = pl.read_parquet(out), pl.read_parquet(path)
    first = table.filter(pl.col("target") == table["target"][0])
    z = data.filter(pl.col("target") == data["target"][0]).select("x", "y").to_numpy()
    for k, axis in enumerate("xy"):
        alone = ONE.filter(first["time"].to_numpy(), z[:, k : k + 1])
        assert_allclose(first[axis], alone["px"], rtol=1e-9)
        assert_allclose(first[f"velocity_{axis}_sd"], alone.sd("vx"), rtol=1e-9)
    lines = data.filter(pl.col("target") == data["target"][0]).select("target", "time", "x", "y").write_ndjson()
    command = [sys.executable, "-m", "jink", "track", "-", "--filter", str(rules), "-q"]
    live = subprocess.run(command, input=lines, capture_output=True, text=True, check=True)
    streamed = pl.read_ndjson(io.StringIO(live.stdout))
    for name in ("x", "velocity_y", "manoeuvring", "probability_y_fuzzy_constant_velocity_3", "nis"):
        assert_allclose(streamed[name].to_numpy(), first[name].to_numpy(), rtol=1e-9)


def test_its_numbers_are_fitted_on_data_of_two_axes(simulated, tmp_path):
    path, start = str(simulated[0]), str(tmp_path / "start.json")
    jink.Kalman(jink.ConstantVelocity(acceleration_sd=2.0), jink.Position(sd=500.0, axes=1)).save(start)
    fitted = fit(path, start, starts=1)
    assert fitted.filter.axes == 1 and fitted.after < fitted.before
    assert set(fitted.race.tallies) >= {"fitted", "before", "kalman-cv"}
    with_truth = fit(path, start, starts=1, truth="true")
    assert with_truth.objective == "tracking" and with_truth.after < with_truth.before
    assert with_truth.race.compare("fitted", "before", "position_rmse").difference < 0
    with_truth.save(tmp_path / "f.json")
    assert json.loads((tmp_path / "f.json").read_text())["sensors"][0]["axes"] == 1
