"""Smooth curves: the quadrature is exact to rounding, and ramps are what their formula says."""

from dataclasses import replace

import numpy as np
import pytest

from jink.metrics.draws import Draws
from jink.scenarios import SCENARIOS
from jink.scenarios.curves import Curves, Ramps, pulses


@pytest.mark.parametrize("name", ["weave", "vessel", "drone", "benchmark-5", "terminal-area"])
def test_shorter_panels_change_nothing(name):
    curve = SCENARIOS[name].truth(Draws(4, range(6)))
    curve = getattr(curve, "curve", curve)
    time = np.linspace(0.0, curve.duration, 200)[None, :].repeat(curve.runs, axis=0)
    fine = replace(curve, panel=curve.panel / 8)
    np.testing.assert_allclose(curve.at(time).position, fine.at(time).position, rtol=0, atol=1e-6)


def test_ramps_integrate_their_rate():
    """Course, its rate and its integral by brute force on a fine grid."""
    ramps = Ramps(np.array([3.0]), np.array([[1.0, 4.0]]), np.array([[2.5, 9.0]]), np.array([[0.7, -1.2]]))
    time = np.linspace(0.0, 12.0, 120_001)
    rate = sum(
        c * np.clip((time - b) / (e - b), 0, 1)
        for b, e, c in zip(ramps.begin[0], ramps.end[0], ramps.change[0], strict=True)
    )
    steps = np.diff(time)
    value = 3.0 + np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * steps)])
    total = np.concatenate([[0.0], np.cumsum(0.5 * (value[1:] + value[:-1]) * steps)])
    ours, ours_rate = ramps(time[None, :])
    np.testing.assert_allclose(ours_rate[0], rate, atol=1e-12)
    np.testing.assert_allclose(ours[0], value, atol=1e-8)
    np.testing.assert_allclose(ramps.integral(time[None, :])[0], total, atol=1e-7)


def test_a_level_turn_is_a_clothoid_a_circle_and_a_clothoid():
    start = np.zeros((1, 2))
    still = np.zeros((1, 0))
    turn = pulses(np.zeros(1), np.array([[10.0]]), np.array([[30.0]]), 2.0, 3.0, np.array([[np.pi / 2]]))
    curve = Curves(start, turn, Ramps(np.array([200.0]), still, still, still), None, 40.0)
    time = np.array([[0.0, 10.0, 11.0, 20.0, 30.0, 40.0]])
    _, v, a = (values[0] for values in curve.at(time))
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 200.0)
    rate = (np.pi / 2) / (20.0 - 2.5)
    np.testing.assert_allclose(np.linalg.norm(a, axis=1), 200.0 * rate * np.array([0, 0, 0.5, 1, 0, 0]), atol=1e-9)
    np.testing.assert_allclose(v[[0, 4]], [[0.0, 200.0], [200.0, 0.0]], atol=1e-9)
