"""The Doppler benchmark: its targets are what their settings say, its linear filter is the textbook's, its table says
who took part.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import child, doppler, doppler_kalman
from benchmarks.doppler_targets import (
    AZIMUTH_SD,
    ELEVATION_SD,
    FASTEST,
    RANGE_SD,
    RATE_SD,
    SETTINGS,
    STEEPEST,
    observed,
    simulate,
    to_positions,
    turn,
)


def rows_within(flights):
    """Rows that have a next one of the same target."""
    inner = np.ones(len(flights.time), bool)
    inner[flights.offsets[1:] - 1] = False
    return np.flatnonzero(inner)


@pytest.mark.parametrize("name", SETTINGS)
def test_a_seed_makes_the_same_targets_again(name):
    one, again, other = (simulate(SETTINGS[name], 20, seed) for seed in (3, 3, 4))
    assert (one.z == again.z).all() and (one.truth == again.truth).all() and (one.offsets == again.offsets).all()
    assert one.z[0, 0] != other.z[0, 0]


@pytest.mark.parametrize("name", SETTINGS)
def test_plots_scatter_as_the_radar_says(name):
    flights = simulate(SETTINGS[name], 200, 0)
    residual = flights.z - observed(flights.truth)
    # sd of an estimated sd: sd / sqrt(2 n), so 5 of them; as many for the mean
    n, sds = len(residual), np.array([RANGE_SD, AZIMUTH_SD, ELEVATION_SD, RATE_SD])
    assert (abs(residual.std(axis=0) / sds - 1.0) < 5.0 / np.sqrt(2.0 * n)).all()
    assert (abs(residual.mean(axis=0)) < 5.0 * sds / np.sqrt(n)).all()
    assert np.allclose(to_positions(observed(flights.truth)), flights.truth[:, :3])


@pytest.mark.parametrize("name", SETTINGS)
def test_positions_follow_velocities(name):
    flights = simulate(SETTINGS[name], 50, 1)
    at = rows_within(flights)
    x, v = flights.truth[:, :3], flights.truth[:, 3:]
    assert np.allclose(x[at + 1] - x[at], 0.5 * (v[at] + v[at + 1]))


def test_targets_pull_what_their_setting_says():
    for name, setting in SETTINGS.items():
        flights = simulate(setting, 300, 2)
        at, v = rows_within(flights), flights.truth[:, 3:]
        pull = np.linalg.norm(v[at + 1] - v[at], axis=1)  # over a second; a turn's chord is shorter than its arc
        assert pull.max() <= setting.acceleration + 1e-9, name
        assert (pull.max() > 0.9 * setting.acceleration) or not setting.acceleration
        speed = np.linalg.norm(v, axis=1)
        assert speed.max() <= FASTEST + 1e-9
        assert abs(speed[flights.offsets[:-1]].mean() - 70.0) < 5.0 * 15.0 / np.sqrt(300)


def test_durations_and_places_are_the_settings():
    near, far, free = (simulate(SETTINGS[name], 600, 5) for name in ("close", "const-v", "free"))
    lengths = np.diff(far.offsets)
    # a leg of d seconds has ⌈d⌉ rows, on average half a one more
    assert abs(lengths.mean() - 30.5) < 5.0 * 8.0 / np.sqrt(600) and lengths.min() >= 5
    assert abs(far.truth[far.offsets[:-1], :3]).max(axis=0) == pytest.approx([4000.0, 4000.0, 400.0], rel=0.05)
    middle = np.add.reduceat(near.truth[:, :3], near.offsets[:-1]) / np.diff(near.offsets)[:, None]
    assert (abs(middle.std(axis=0) / 200.0 - 1.0) < 5.0 / np.sqrt(1200.0)).all()
    assert np.diff(free.offsets).mean() > 40


def test_turns_keep_their_speed_and_end_when_too_steep():
    rng, v = np.random.default_rng(0), np.array([60.0, -30.0, 8.0])
    vertical = []
    for _ in range(300):
        path = turn(v, SETTINGS["free"], rng)
        assert np.allclose(path[0], v) and np.allclose(np.linalg.norm(path, axis=1), np.linalg.norm(v))
        climb = np.arcsin(path[:, 2] / np.linalg.norm(v))
        assert abs(climb).max() <= STEEPEST + 1e-9
        vertical.append(len(path) > 1 and not np.isclose(climb[1], climb[0]))
    # 300 draws of a share .3: sd .026
    assert abs(np.mean(vertical) - 0.3) < 5 * 0.026


def test_the_linear_filter_is_the_textbooks():
    flights = simulate(replace(SETTINGS["free"], leg=6.0, leg_sd=1.0), 3, 7)
    Q, R = doppler_kalman.estimated_noise(simulate(SETTINGS["free"], 60, 8))
    found, z = doppler_kalman.kalman(flights, Q, R), doppler_kalman.plots(flights)
    F = doppler_kalman.F
    for begin, end in zip(flights.offsets[:-1], flights.offsets[1:], strict=True):
        P, x = np.eye(6) * doppler_kalman.START, np.r_[z[begin, :3], np.zeros(3)]
        for k in range(begin, end):
            if k > begin:
                x, P = F @ x, F @ P @ F.T + Q
            H = np.zeros((4, 6))
            H[:3, :3], H[3, 3:] = np.eye(3), z[k, :3] / np.linalg.norm(z[k, :3])
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
            x = x + K @ (z[k] - H @ x) if k > begin else x
            P = P - K @ H @ P
            np.testing.assert_allclose(found[k], x, rtol=1e-7, atol=1e-6)


def test_noise_estimated_from_the_truth_of_straight_flights_is_that_of_the_radar():
    Q, R = doppler_kalman.estimated_noise(simulate(SETTINGS["const-v"], 200, 0))
    assert abs(Q).max() < 1e-9
    assert np.sqrt(R[3, 3]) == pytest.approx(RATE_SD, rel=0.05)


def test_errors_compared_by_target_with_themselves_are_equal():
    flights = simulate(SETTINGS["close"], 30, 0)
    square = np.abs(np.random.default_rng(0).standard_normal((len(flights.time), 2)))
    same, double = (doppler.compared(k * square, square, flights) for k in (1.0, 2.0))
    assert same == {"position gain": 0.0, "position se": 0.0, "velocity gain": 0.0, "velocity se": 0.0}
    assert double["position gain"] == pytest.approx(1.0) and double["position se"] < 1e-12


def test_the_race_is_a_table_and_says_who_took_no_part():
    found = child.run_doppler(child.TINY)
    entrants = found["settings"]["close"]
    assert len(entrants) >= 8 and all(np.isfinite(f["position"]) for f in entrants.values())
    text = "\n".join(doppler.table_of(found))
    assert "| close" in text and "jink imm, fitted by truth" in text
    assert ("OKF takes no part: not installed" in text) == (doppler.OKF not in entrants)
    assert doppler.table_of({"error": "interrupted"}) == ["not measured: interrupted"]
