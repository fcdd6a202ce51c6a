"""The papers' scenarios: their motions at given times, and figures that depend on every detail of them."""

import numpy as np
import pytest

import jink
from jink.scenarios import SCENARIOS


def truth_at(name: str, times: list[float], run: int = 0):
    """Kinematics of one run without its process noise, (n, axes) each."""
    from jink.metrics.draws import Draws

    truth = SCENARIOS[name].truth(Draws(0, [run]))
    return [values[0] for values in truth.at(np.array([times]))]


def rms(error: np.ndarray) -> float:
    return float(np.sqrt((error**2).sum(axis=-1).mean()))


def filtered(name: str, acceleration_sd: float, runs: int = 500, known_input: bool = False):
    """Estimates (B, S, axes) of position and velocity by one Kalman filter, and the simulation."""
    made = SCENARIOS[name].simulate(runs, seed=1)
    kalman = jink.Kalman(jink.ConstantVelocity(acceleration_sd=acceleration_sd), SCENARIOS[name].observation.sensor)
    known = made.input.reshape(-1, made.input.shape[-1]) if known_input else None
    x = kalman.filter(**made.batch(), input=known).x.reshape(*made.time.shape, -1)
    return x[..., 0::2], x[..., 1::2], made


def test_lee_2003_clairvoyant_errors():
    """Normalised errors .3001 and .0197 of the Kalman filter that knows the input."""
    position, velocity, made = filtered("lee-2003", 1.0, runs=1000, known_input=True)
    measured_velocity = np.diff(made.z, axis=1, prepend=np.nan)

    def over_runs(error):
        return np.sqrt((error**2).sum(axis=-1).mean(axis=0))

    p = over_runs(position - made.truth.position) / over_runs(made.z - made.truth.position)
    v = over_runs(velocity - made.truth.velocity) / over_runs(measured_velocity - made.truth.velocity)
    assert p[2:].mean() == pytest.approx(0.3001, abs=0.003)
    assert v[2:].mean() == pytest.approx(0.0197, abs=0.0003)


def test_lee_2003_inputs():
    made = SCENARIOS["lee-2003"].simulate(1)
    np.testing.assert_allclose(made.input[0, 38:43, 0], [0, 0, 10, 10, 10])
    np.testing.assert_allclose(made.input[0, [60, 61], 0], [10, 0])
    np.testing.assert_allclose(made.input.sum(axis=1)[0], [21 * 10 - 21 * 30, 11 * 60])
    p, v, _ = truth_at("lee-2003", [0.0])
    np.testing.assert_allclose(np.hypot(*p[0]), 22400.0)
    np.testing.assert_allclose(np.hypot(*v[0]), 15.0)


@pytest.mark.parametrize(
    ("name", "sd", "expected"),
    [
        ("choi-2001-1", 1.0, 1.16),
        ("choi-2001-2", 1.0, 10.8),
        ("choi-2001-3", 1.0, 26.8),
        ("choi-2001-4", 1.0, 21.7),
        ("choi-2001-1", 14.0, 1.40),
        ("choi-2001-2", 14.0, 1.41),
        ("choi-2001-3", 14.0, 1.73),
        ("choi-2001-4", 14.0, 1.46),
    ],
)
def test_choi_2001_fixed_noise(name, sd, expected):
    """Position errors over scans 3–20 of the filters with a fixed process noise of 1 and 196."""
    position, _, made = filtered(name, sd)
    assert rms((position - made.truth.position)[:, 2:]) == pytest.approx(expected, rel=0.015)


def test_choi_2001_training_sets_take_their_paths_in_turn():
    lines = SCENARIOS["choi-2001-line"].simulate(8)
    np.testing.assert_allclose(np.abs(lines.truth.velocity[:, 0]), [[200.0, 100.0]] * 8)
    assert len(np.unique(lines.truth.velocity[:4, 0], axis=0)) == 4
    circles = SCENARIOS["choi-2001-circle"].simulate(5)
    radius = np.linalg.norm(circles.truth.position, axis=-1)
    np.testing.assert_allclose(radius, np.array([50.0, 100, 150, 200, 50])[:, None] * np.ones(20))
    mixed = SCENARIOS["choi-2001-mixed"].simulate(4)
    np.testing.assert_allclose(mixed.turn_rate[:, 1], [0, 0, np.pi / 10, np.pi / 10])


def test_wang_2010_motions():
    p, v, a = truth_at("wang-2010-velocity", [0.0, 50.0, 200.0])
    np.testing.assert_allclose(v[:, 0], [100.0, 1600.0, 3350.0])
    np.testing.assert_allclose(p[:2, 0], [10e3, 10e3 + 100 * 50 + 15 * 50**2])
    np.testing.assert_allclose(a[:, 0], [30.0, 20.0, 5.0])
    p, v, a = truth_at("wang-2010-circle", [30.0, 90.0, 150.0])
    np.testing.assert_allclose(np.hypot(p[:, 0] - 14500.0, p[:, 1] - 10e3), 10e3)
    np.testing.assert_allclose(np.hypot(*v.T), 150.0)
    np.testing.assert_allclose(np.hypot(*a.T), 2.25)
    _, v, a = truth_at("wang-2010-step", [49.9, 50.0, 99.9, 100.0, 150.0])
    np.testing.assert_allclose(a[:, 0], [0.0, 60.0, 60.0, 0.0, 0.0])
    np.testing.assert_allclose(v[-1], 3100.0)
