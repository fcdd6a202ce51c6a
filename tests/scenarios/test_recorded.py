"""Recorded flights as truth."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from jink.io.errors import InputError
from jink.metrics.draws import Draws
from jink.scenarios.recorded import Spline, recorded

FLIGHTS = Path(__file__).parents[2] / "examples" / "flights.parquet"


@pytest.fixture(scope="module")
def flights():
    table = pl.read_parquet(FLIGHTS)
    some = table["icao24"].unique(maintain_order=True)[:3].implode()
    return recorded(table.filter(pl.col("icao24").is_in(some)), duration=200.0, name="three")


def test_runs_are_windows_of_the_flights_around_the_radar(flights):
    made = flights.simulate(12, seed=1)
    assert made.z.shape[1:] == (50, 3)
    middle = np.linalg.norm(made.truth.position[:, 25, :2], axis=1)
    assert (middle > 10e3).all() and (middle < 130e3).all()
    speed = np.linalg.norm(made.truth.velocity, axis=2)
    assert 20 < np.median(speed) < 300
    error = made.z[..., 0] - np.linalg.norm(made.truth.position, axis=2)
    assert error.std() == pytest.approx(50.0, rel=0.15)


def test_truth_is_exact(flights):
    truth = flights.truth(Draws(1, range(4)))
    step = 2.0**-8
    time = np.random.default_rng(2).uniform(1.0, 199.0, (4, 300))
    near = np.abs(time[:, :, None] - truth.breaks()[:, None, :]).min(axis=2) < 2 * step
    here, before, after = truth.at(time), truth.at(time - step), truth.at(time + step)
    velocity = (after.position - before.position) / (2 * step)
    bend = (after.acceleration - before.acceleration) / (2 * step)
    velocity -= step**2 / 6 * bend  # a cubic's central difference is off by exactly this
    acceleration = (after.velocity - before.velocity) / (2 * step)
    np.testing.assert_allclose(velocity[~near], here.velocity[~near], atol=1e-6)
    np.testing.assert_allclose(acceleration[~near], here.acceleration[~near], atol=1e-6)


def test_the_same_in_any_company(flights):
    np.testing.assert_array_equal(flights.simulate([5], 3).z[0], flights.simulate(6, 3).z[5])


def test_spline_equals_scipy():
    from scipy.interpolate import CubicSpline

    numbers = np.random.default_rng(1)
    time = np.cumsum(numbers.uniform(0.5, 3.0, 40))
    points = numbers.normal(size=(40, 2))
    asked = np.linspace(time[0], time[-1], 200)
    theirs, ours = CubicSpline(time, points, bc_type="natural"), Spline.through(time, points).at(asked)
    for order in range(3):
        np.testing.assert_allclose(ours[order], theirs(asked, order), atol=1e-12)


def test_short_tracks_are_refused():
    table = pl.read_parquet(FLIGHTS).head(100)
    with pytest.raises(InputError, match="expected a track that lasts 5000 s"):
        recorded(table, duration=5000.0)
