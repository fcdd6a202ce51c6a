"""The reference for turned axes: it believes what it should, and lies between knowing the angle and a wrong belief."""

from __future__ import annotations

import numpy as np
import pytest

from jink.compare import RandomAccelerations, near_optimal, near_optimal_turned
from jink.scenarios import SCENARIOS

SD, FIRST = 500.0, 5


@pytest.fixture(scope="module")
def made():
    """60 runs, each with axes of its own."""
    return SCENARIOS["random-accelerations-turned"].simulate(range(60), 7)


def rmse(reference, made):
    pairs = ((reference.position, made.truth.position), (reference.velocity, made.truth.velocity))
    return np.array([np.sqrt(((a - b)[:, FIRST:] ** 2).sum(axis=2).mean()) for a, b in pairs])


def test_it_is_consistent_and_better_than_a_wrong_belief(made):
    turned = near_optimal_turned(made.z, RandomAccelerations(), sd=SD, angles=8)
    wrong = near_optimal(made.z, RandomAccelerations(), sd=SD)
    assert (rmse(turned, made) < 0.97 * rmse(wrong, made)).all()
    nees = turned.nees(made.truth.position, made.truth.velocity)[:, FIRST:].mean(axis=1)
    assert abs(nees.mean() - 1) < 3 * nees.std(ddof=1) / np.sqrt(len(nees)) + 0.01
    np.testing.assert_allclose(turned.log_likelihood_scan[:, 0], wrong.log_likelihood_scan[:, 0], atol=1e-6)
    assert turned.log_likelihood_scan.sum() > wrong.log_likelihood_scan.sum()


def test_one_angle_is_the_tree_in_turned_axes(made):
    c = np.sqrt(0.5)
    back = np.array([[c, c], [-c, c]])
    z = made.z[:5]
    one = near_optimal_turned(z, RandomAccelerations(), sd=SD, angles=1)
    tree = near_optimal(z @ back.T, RandomAccelerations(), sd=SD)
    np.testing.assert_allclose(one.position @ back.T, tree.position, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(one.log_likelihood_scan, tree.log_likelihood_scan, rtol=1e-9, atol=1e-9)


def test_a_missed_plot_is_missed_at_every_angle(made):
    z = made.z[:3].copy()
    z[:, 50] = np.nan
    found = near_optimal_turned(z, RandomAccelerations(), sd=SD, angles=4)
    assert np.isfinite(found.x).all()
    np.testing.assert_allclose(found.log_likelihood_scan[:, 50], 0.0, atol=1e-9)


def test_what_it_needs():
    with pytest.raises(ValueError, match=r"expected \(runs, scans, 2\)"):
        near_optimal_turned(np.zeros((2, 5, 1)), RandomAccelerations(), sd=SD)
