"""The native engine against the textbook, to 1e-9 scaled by conditioning, over compositions and irregular
data.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from agreement import TOLERANCE, assert_agrees
from oracle import tracker
from oracle import twin as tw
from oracle.situations import BRISK, CV, P2, SITUATIONS, TWO, make_data


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", SITUATIONS)
def test_filter(name, seed):
    twin = SITUATIONS[name]
    assert_agrees(twin, make_data(twin, seed=seed))


@pytest.mark.parametrize("name", SITUATIONS)
def test_smoother(name):
    twin = SITUATIONS[name]
    assert_agrees(twin, make_data(twin, N=30, seed=2), smooth=True)


@pytest.mark.parametrize("name", ["kalman-cv-3", "kalman-ct-2", "kalman-singer-2", "imm-mixed-3", "imm-turns-and-ca"])
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
def test_known_input(name, smooth):
    twin = SITUATIONS[name]
    data = make_data(twin, N=40, seed=3)
    data.u = np.random.default_rng(4).normal(0, 3.0, (40, twin.axes))
    assert_agrees(twin, data, smooth)


@pytest.mark.parametrize("name", ["kalman-cv-3", "kalman-ct-2", "imm-mixed", "imm-robust", "imm-radar"])
def test_covariance_per_row(name):
    twin = SITUATIONS[name]
    data = make_data(twin, N=40, seed=5)
    rng, m = np.random.default_rng(6), data.z.shape[1]
    R = twin.sensors[0].sensor().R
    data.R = R * rng.uniform(0.2, 4.0, 40)[:, None, None]
    if "Position" in twin.sensors[0].name:  # correlated ones too
        root = np.linalg.cholesky(R) @ (np.eye(m) + 0.3 * rng.normal(size=(40, m, m)))
        data.R = root @ root.transpose(0, 2, 1)
    assert_agrees(twin, data)


@pytest.mark.parametrize("name", ["kalman-converted", "kalman-converted-3"])
def test_what_is_incomplete_cannot_be_converted(name):
    """A polar measurement without one of its components counts as missing."""
    twin = SITUATIONS[name]
    data = make_data(twin, N=40, seed=0)
    data.z[10, 0] = data.z[20, 1] = np.nan
    native = tw.run_native(twin, data)
    data.z[[10, 20]] = np.nan
    assert max(tw.distances(native, tw.run_oracle(twin, data)).values()) < TOLERANCE


SCORED = ["kalman-velocity", "imm-mixed", "imm-robust", "imm-sensors", "imm-ukf"]


@pytest.mark.parametrize("name", SCORED)
def test_probability_integral_transform(name):
    """Of each measured component given those before it."""
    twin = SITUATIONS[name]
    data = make_data(twin, N=50, seed=12)
    want = np.full(data.z.shape, np.nan)
    for k, scan in enumerate(tw.run_oracle(twin, data).scans):
        if scan.pit is not None and scan.status != tracker.RESTARTED:
            want[k, : len(scan.pit)] = scan.pit
    got = twin.native().filter(data.time, data.z, outputs=["pit"], **data.keywords()).pit
    there = ~np.isnan(want)
    np.testing.assert_allclose(got[there], want[there], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", SCORED)
def test_what_is_not_scored_is_nan(name):
    """Starts, restarts, updates before the second point of a start, misses."""
    twin = SITUATIONS[name]
    data = make_data(twin, N=50, seed=12)
    data.time[1] = data.time[0]  # not yet a second point
    oracle = tw.run_oracle(twin, data)
    outputs = ["nis", "nis_dof", "pit"]
    native = twin.native().filter(data.time, data.z, outputs=outputs, **data.keywords())
    np.testing.assert_array_equal(np.isnan(native.nis), np.isnan(oracle.nis))
    np.testing.assert_array_equal(native.nis_dof, oracle.nis_dof)
    np.testing.assert_array_equal((~np.isnan(native.pit)).sum(axis=1), oracle.nis_dof)


def test_variance_per_row_is_a_diagonal_covariance():
    twin = SITUATIONS["imm-mixed"]
    data = make_data(twin, N=40, seed=5)
    variance = np.random.default_rng(7).uniform(100.0, 2000.0, (40, 2))
    oracle = tw.run_oracle(twin, replace(data, R=np.array([np.diag(v) for v in variance])))
    native = twin.native().filter(data.time, data.z, covariance=variance)
    assert max(tw.distances(native, oracle).values()) < TOLERANCE


@pytest.mark.parametrize("variance", [625.0, 1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("dt", [5.0, 1000.0])
def test_a_full_covariance_costs_no_digits(variance, dt):
    """A diagonal covariance given as a matrix, after a prediction up to 1e18 times as uncertain."""
    sensor = tw.part("Position", sd=variance**0.5, axes=2)
    f = tw.Twin([CV], [sensor], 2, initial=tw.part("OnePoint", velocity_sd=1000.0)).native()
    t, z = np.array([0.0, dt, dt + 1]), np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])
    a, b = f.filter(t, z), f.filter(t, z, covariance=np.tile(variance * np.eye(2), (3, 1, 1)))
    sd = np.sqrt(np.einsum("kii->ki", a.P))
    np.testing.assert_array_less(np.abs(a.P - b.P) / (sd[:, :, None] * sd[:, None, :]), TOLERANCE)


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_given_prior(axes):
    rng = np.random.default_rng(axes)
    root = rng.normal(size=(2 * axes, 2 * axes)) * 30
    prior = tw.part("Prior", x=rng.normal(0, 50, 2 * axes), P=root @ root.T + 100 * np.eye(2 * axes))
    sensor = tw.part("Position", sd=25.0, axes=axes)
    brisk = tw.part("ConstantVelocity", acceleration_sd=8.0)
    data = make_data(tw.Twin([CV], [sensor], axes), N=30, seed=8)
    for motions in ([CV], [CV, brisk]):
        assert_agrees(tw.Twin(motions, [sensor], axes, 0.9, initial=prior), data)


@pytest.mark.parametrize("dt", [1e-6, 1e-3, 0.1, 10.0, 1e3])
@pytest.mark.parametrize("tau", [1e-2, 1.0, 60.0, 1e5])
def test_singer_over_every_ratio_of_step_and_time_constant(dt, tau):
    """The closed form loses all digits below alpha T = 1e-3: the series must take over."""
    twin = tw.Twin([tw.part("Singer", acceleration_sd=3.0, time_constant=tau)], [P2], 2, initial=TWO)
    t = dt * np.arange(8.0)
    z = np.random.default_rng(9).normal(0, 25, (8, 2))
    assert_agrees(twin, tw.Data(t, z))


@pytest.mark.parametrize("dt", [0.0, 1e-4, 1.0, 25.0])
@pytest.mark.parametrize("rate", [0.0, 1e-9, -1e-6, 1e-3, -0.1, 1.0])
def test_turn_prediction_through_zero_rate(rate, dt):
    """Prediction only: state, Jacobian (in P) and noise of a turn whose rate is small, zero or large."""
    x, P = np.array([100.0, 200.0, -50.0, 80.0, rate]), np.diag([9.0, 4.0, 25.0, 16.0, 1e-4])
    P[0, 4] = P[4, 0] = 0.01
    prior = tw.part("Prior", x=x, P=P)
    ct = tw.part("CoordinatedTurn", acceleration_sd=0.4, turn_rate_sd=0.004)
    twin = tw.Twin([ct], [P2], 2, initial=prior)
    assert_agrees(twin, tw.Data(np.array([0.0, dt]), np.full((2, 2), np.nan)))


def test_jump_of_fifty_kilometres_without_gating():
    twin = tw.Twin([CV, BRISK], [P2], 2, 0.95, initial=TWO)
    data = make_data(twin, N=40, seed=10)
    data.z[20] += 5e4
    assert_agrees(twin, data)


def test_long_gap_and_coasting():
    for name in ("imm-mixed", "imm-sojourn", "imm-step", "kalman-singer-2"):
        twin = SITUATIONS[name]
        data = make_data(twin, N=30, seed=11)
        data.time[15:] += 400.0
        data.z[20:26] = np.nan
        assert_agrees(twin, data)
