"""The engine against answers known in closed form, without any other filter to compare with."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_discrete_are
from scipy.stats import kstest

import jink

nan = np.nan


def steady(motion, sd, T, n=2000):
    """P after n scans of one axis, T apart, and the gain that P implies."""
    f = jink.Kalman(motion, jink.Position(sd=sd, axes=1), initial=jink.OnePoint(velocity_sd=100.0))
    est = f.filter(np.arange(n) * T, np.zeros((n, 1)))
    return est.P[-1], est.P[-1][:, 0] / sd**2


@pytest.mark.parametrize("index", [1e-3, 0.1, 1.0, 30.0])
def test_alpha_beta_gains(index):
    """Kalata's tracking index lambda = sd_a T^2 / sd_z gives the steady gains (Bar-Shalom 2001, 6.5.3)."""
    T, sd = 2.0, 5.0
    _, gain = steady(jink.ConstantVelocity(acceleration_sd=index * sd / T**2), sd, T, 20_000)
    r = (4 + index - np.sqrt(8 * index + index**2)) / 4
    alpha = 1 - r**2
    beta = 2 * (2 - alpha) - 4 * np.sqrt(1 - alpha)
    assert_allclose(gain, [alpha, beta / T], rtol=1e-9)


@pytest.mark.parametrize("psd", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("T", [0.1, 1.0, 12.0])
def test_riccati_steady_state(psd, T):
    """The filter's P converges to the algebraic Riccati equation's solution, for velocity and for
    acceleration noise.
    """
    sd = 20.0
    Q2 = psd * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
    F2 = np.array([[1.0, T], [0, 1]])
    F3 = np.array([[1.0, T, T**2 / 2], [0, 1, T], [0, 0, 1]])
    Q3 = psd * np.array([[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]])
    cases = [(jink.ConstantVelocity(acceleration_psd=psd), F2, Q2)]
    cases.append((jink.ConstantAcceleration(jerk_psd=psd), F3, Q3))
    for motion, F, Q in cases:
        n = len(F)
        H, R = np.eye(1, n), np.array([[sd**2]])
        before = solve_discrete_are(F.T, H.T, Q, R)
        K = before @ H.T / (H @ before @ H.T + R)
        after = before - K @ H @ before
        got, _ = steady(motion, sd, T, 20_000)
        scale = np.sqrt(np.diag(after))
        assert np.abs((got - after) / np.outer(scale, scale)).max() < 1e-8


def test_markov_only_through_misses():
    """[.34, .66]: what a filter that keeps the last likelihood gets wrong (it gives [.432, .568])."""
    motions = [jink.ConstantVelocity(acceleration_sd=s) for s in (0.1, 1.0)]
    prior = jink.Prior(np.zeros(2), np.eye(2))
    f = jink.IMM(
        motions,
        jink.Position(sd=1.0, axes=1),
        [[0.9, 0.1], [0.2, 0.8]],
        mode_probability=[0.2, 0.8],
        initial=prior,
    )
    est = f.filter([0.0, 1.0, 2.0], [[nan], [nan], [nan]])
    assert_allclose(est.mode_probability, [[0.2, 0.8], [0.34, 0.66], [0.438, 0.562]], rtol=1e-13)
    assert list(est.status) == [2, 2, 2] and (est.log_likelihood_scan == 0).all()


def test_two_modes_relax_to_their_sojourn_times():
    """p(t) = pi + (p(0) - pi) exp(-(1/a + 1/b) t), whatever the steps; the same instant does not switch."""
    motions = [jink.ConstantVelocity(acceleration_sd=s) for s in (0.1, 1.0)]
    f = jink.IMM(
        motions,
        jink.Position(sd=1.0, axes=1),
        jink.Sojourn(seconds=[30.0, 10.0]),
        mode_probability=[0.1, 0.9],
        initial=jink.Prior(np.zeros(2), np.eye(2)),
    )
    t = np.array([0.0, 0.0, 1e-3, 0.7, 0.7, 5.0, 80.0, 1e4])
    est = f.filter(t, np.full((8, 1), nan))
    rate = 1 / 30 + 1 / 10
    assert_allclose(est.mode_probability[:, 0], 0.75 + (0.1 - 0.75) * np.exp(-rate * t), rtol=1e-12)


@pytest.mark.parametrize("seconds", [1e-5, 1e-12, 1e-40, 1e-149])
def test_many_sojourns_within_a_step_end_at_the_stationary_probabilities(seconds):
    """They end where pi G = 0, pi = (3/4, 1/4), whatever the number of squarings."""
    motions = [jink.ConstantVelocity(acceleration_sd=s) for s in (0.1, 1.0)]
    chain = jink.Sojourn(seconds=[3.0 * seconds, seconds])
    prior = jink.Prior(np.zeros(2), np.eye(2))
    f = jink.IMM(motions, jink.Position(sd=1.0, axes=1), chain, mode_probability=[0.1, 0.9], initial=prior)
    est = f.filter([0.0, 0.01, 1e4], np.full((3, 1), nan))
    assert_allclose(est.mode_probability[1:], [[0.75, 0.25]] * 2, rtol=1e-9)


@pytest.mark.parametrize("step", [0.5, 1.0, 4.0])
def test_a_matrix_with_its_step_is_a_matrix_power(step):
    motions = [jink.ConstantVelocity(acceleration_sd=s) for s in (0.1, 1.0)]
    Pi = np.array([[0.95, 0.05], [0.2, 0.8]])
    f = jink.IMM(
        motions,
        jink.Position(sd=1.0, axes=1),
        Pi,
        transition_step=step,
        mode_probability=[0.1, 0.9],
        initial=jink.Prior(np.zeros(2), np.eye(2)),
    )
    est = f.filter(np.arange(6.0) * 3 * step, np.full((6, 1), nan))
    for k in range(6):
        assert_allclose(est.mode_probability[k], [0.1, 0.9] @ np.linalg.matrix_power(Pi, 3 * k), rtol=1e-11)


def test_coasting_ends_the_track():
    """Beyond `coast` seconds without an accepted measurement there is no track; the next measurement starts
    one.
    """
    f = jink.Kalman(
        jink.ConstantVelocity(acceleration_sd=1.0),
        jink.Position(sd=10.0, axes=1),
        initial=jink.OnePoint(velocity_sd=50.0),
        coast=10.0,
    )
    t = np.array([0.0, 1, 2, 6, 11, 13, 30, 31, 50])
    z = np.array([0.0, 5, 10, nan, nan, nan, 500, 520, 800])[:, None]
    est = f.filter(t, z)
    assert list(est.status) == [5, 1, 1, 2, 2, 0, 5, 1, 5]
    assert np.isnan(est.x[5]).all()
    assert_allclose(est.x[6], [500, 0])
    assert_allclose(est.x[8], [800, 0])


def test_consistency_of_a_matched_filter():
    """NIS has mean nis_dof and the probability integral transform is uniform where the model is the truth."""
    rng = np.random.default_rng(0)
    B, N, sd, q = 300, 40, 20.0, 2.0
    dt = rng.uniform(0.5, 2.0, (B, N))
    dt[:, 0] = 0
    x = np.zeros((B, 2, 2))
    x[:, :, 1] = rng.normal(0, 100.0, (B, 2))
    z = np.empty((B, N, 2))
    for k in range(N):
        T = dt[:, k]
        Q = q * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]]).transpose(2, 0, 1) + 1e-12 * np.eye(2)
        w = np.einsum("bij,bkj->bki", np.linalg.cholesky(Q), rng.normal(size=(B, 2, 2)))
        x[:, :, 0] += T[:, None] * x[:, :, 1]
        x += w
        z[:, k] = x[:, :, 0] + rng.normal(0, sd, (B, 2))
    z[rng.random(z.shape) < 0.1] = nan
    f = jink.Kalman(
        jink.ConstantVelocity(acceleration_psd=q),
        jink.Position(sd=sd),
        initial=jink.OnePoint(velocity_sd=100.0),
    )
    names = ("pit", "nis", "nis_dof", "status")
    est = f.filter(np.cumsum(dt, axis=1).ravel(), z.reshape(-1, 2), offsets=np.arange(B + 1) * N, outputs=names)
    used = est.status == 1
    assert abs(est.nis[used].sum() / est.nis_dof[used].sum() - 1) < 0.02
    pit = est.pit[used]
    assert kstest(pit[~np.isnan(pit)], "uniform").pvalue > 0.01


def test_log_likelihood_of_one_scan():
    """log N(z; 0, P + R) with all of 2 pi; with outliers log[(1 - e) N + e / (product of the extents)]."""
    prior = jink.Prior(np.zeros(4), np.diag([9.0, 1.0, 16.0, 1.0]))
    z = np.array([[3.0, -2.0]])
    N = np.exp(-0.5 * (9 / 13 + 4 / 20)) / (2 * np.pi * np.sqrt(13 * 20))
    motion, sensor = jink.ConstantVelocity(acceleration_sd=1.0), jink.Position(sd=2.0)
    assert_allclose(jink.Kalman(motion, sensor, initial=prior).filter([0.0], z).log_likelihood, np.log(N))
    soft = jink.Kalman(motion, sensor, initial=prior, outliers=jink.Outliers(share=0.2, extent=500.0))
    assert_allclose(soft.filter([0.0], z).log_likelihood, np.log(0.8 * N + 0.2 / 500**2))
