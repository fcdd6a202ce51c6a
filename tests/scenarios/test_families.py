"""The families with random parameters: their statistics, and the limits of what moves."""

import numpy as np
import pytest

import jink
from jink.scenarios import SCENARIOS, by_name

G = 9.80665


def test_random_accelerations_have_the_stated_lengths_and_levels():
    """Quiet a geometric mean of 40 s, then uniform in ±100 m/s² for a mean of 15 s, per axis."""
    made = SCENARIOS["random-accelerations"].simulate(1000, 1)
    command = made.input[:, 1:].swapaxes(1, 2).reshape(-1, 179)
    levels = command[command != 0]
    assert np.abs(levels).max() <= 100.0
    assert np.mean(levels > 0) == pytest.approx(0.5, abs=0.05)
    began = (command[:, :-1] == 0) & (command[:, 1:] != 0)
    ended = (command[:, :-1] != 0) & (command[:, 1:] != command[:, :-1])
    assert began.sum() / (command[:, :-1] == 0).sum() == pytest.approx(1 / 40, rel=0.05)
    assert ended.sum() / (command[:, :-1] != 0).sum() == pytest.approx(1 / 15, rel=0.05)
    noise = np.diff(made.truth.velocity, axis=1) - made.input[:, 1:]
    assert noise.std() == pytest.approx(1.0, rel=0.01)


def test_turned_accelerations_are_the_same_along_other_axes():
    straight = SCENARIOS["random-accelerations"].simulate(20, 1).input
    turned = SCENARIOS["random-accelerations-turned"].simulate(20, 1).input
    np.testing.assert_allclose(np.linalg.norm(straight, axis=2), np.linalg.norm(turned, axis=2), atol=1e-9)
    assert np.abs(straight - turned).max() > 1.0


@pytest.mark.parametrize(
    ("name", "position", "velocity"), [("lee-2003", 216, 24.9), ("random-accelerations", 217, 24.5)]
)
def test_clairvoyant_filter(name, position, velocity):
    """The Kalman filter that knows the input, scored from the sixth scan on."""
    made = SCENARIOS[name].simulate(500, 3)
    kalman = jink.Kalman(jink.ConstantVelocity(acceleration_sd=1.0), made.scenario.observation.sensor)
    x = kalman.filter(**made.batch(), input=made.input.reshape(-1, 2)).x.reshape(*made.time.shape, 4)
    for values, truth, wanted in (
        (x[..., 0::2], made.truth.position, position),
        (x[..., 1::2], made.truth.velocity, velocity),
    ):
        error = np.sqrt(((values - truth)[:, 5:] ** 2).sum(axis=-1).mean())
        assert error == pytest.approx(wanted, rel=0.03)


def test_random_turns_are_coordinated_turns_with_process_noise():
    made = SCENARIOS["random-turns"].simulate(400, 1)
    rate = made.turn_rate[:, 1:]
    turning = np.abs(rate[rate != 0])
    assert np.degrees(turning.min()) >= 0.999 and np.degrees(turning.max()) <= 6.001
    assert np.linalg.norm(made.truth.velocity, axis=2).mean() == pytest.approx(250.0, rel=0.01)
    v = made.truth.velocity[..., 0] + 1j * made.truth.velocity[..., 1]
    off = v[:, 1:] - v[:, :-1] * np.exp(1j * rate)
    assert np.sqrt((np.abs(off) ** 2).mean()) == pytest.approx(np.sqrt(2), rel=0.02)


def test_climbing_turns_climb_and_fly_level():
    vertical = SCENARIOS["random-turns-climbing"].simulate(200, 1).truth.velocity[..., 2]
    assert vertical.max() > 10 and vertical.min() < -10
    assert 0.2 < np.mean(np.abs(vertical) < 15.0) < 0.95


@pytest.mark.parametrize(
    ("name", "slowest", "fastest", "load"),
    [
        ("weave", 150, 350, 5.01),
        ("terminal-area", 70, 230, 0.6),
        ("vessel", 2, 11, 0.03),
        ("drone", 0, 18, 2.1),
    ],
)
def test_smooth_families_stay_within_what_they_can_do(name, slowest, fastest, load):
    _, v, a = SCENARIOS[name].simulate(100, 1).truth
    speed = np.hypot(v[..., 0], v[..., 1])
    assert slowest - 1e-6 <= speed.min() and speed.max() <= fastest + 1e-6
    lateral = np.abs(a[..., 0] * v[..., 1] - a[..., 1] * v[..., 0]) / np.maximum(speed, 1e-9) / G
    assert lateral.max() <= load
    assert lateral.max() > 0.3 * load


def test_terminal_area_has_departures_and_arrivals():
    p, v, _ = SCENARIOS["terminal-area"].simulate(60, 1).truth
    arrives = p[:, -1, 2] < p[:, 0, 2]
    assert 15 < arrives.sum() < 45
    lands = p[arrives, -1]
    assert (np.hypot(lands[:, 0], lands[:, 1]) < 2000.0).all() and (lands[:, 2] < 100.0).all()
    slope = -v[arrives, -10, 2] / np.hypot(v[arrives, -10, 0], v[arrives, -10, 1])
    np.testing.assert_allclose(np.degrees(np.arctan(slope)), 3.0, atol=0.1)
    assert p[:, :, 2].min() > 0


def test_drones_hover_and_stay_off_the_ground():
    p, v, _ = SCENARIOS["drone"].simulate(200, 1).truth
    speed = np.linalg.norm(v[..., :2], axis=2)
    assert 0.05 < np.mean(speed < 0.1) < 0.5
    assert p[..., 2].min() > 0


def test_an_unknown_name_is_answered_with_the_nearest_and_all():
    with pytest.raises(ValueError, match="did you mean benchmark-") as error:
        by_name("benchmark-7")
    assert all(name in str(error.value) for name in SCENARIOS)
