"""Expectation-maximisation for a linear model, from the textbook: its fixed point is where the likelihood is
greatest.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import jink
from jink.fit.objectives import Likelihood
from jink.fit.optimise import Search
from jink.fit.parameters import Parameters
from jink.models.tracks import Tracks

T, SCANS, TRACKS = 2.0, 60, 8
F = np.array([[1.0, T], [0.0, 1.0]])
Q = np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])  # of unit density
H = np.array([1.0, 0.0])
P0 = np.diag([100.0**2, 30.0**2])


def simulated(q, r, rng):
    x = rng.multivariate_normal(np.zeros(2), P0, TRACKS)
    z = np.empty((TRACKS, SCANS))
    for k in range(SCANS):
        if k:
            x = x @ F.T + rng.multivariate_normal(np.zeros(2), q * Q, TRACKS)
        z[:, k] = x[:, 0] + rng.normal(0, np.sqrt(r), TRACKS)
    return z


def smoothed(z, q, r):
    """Rauch-Tung-Striebel with lag-one covariances: means (S, 2), covariances (S, 2, 2), Cov(x_k, x_k-1) (S, 2, 2)."""
    x, P, before = np.zeros(2), P0, []
    xs, Ps = [], []
    for k in range(len(z)):
        if k:
            x, P = F @ x, F @ P @ F.T + q * Q
        before.append((x, P))
        K = P @ H / (H @ P @ H + r)
        x, P = x + K * (z[k] - x[0]), P - np.outer(K, H @ P)
        xs.append(x), Ps.append(P)
    lag = [np.zeros((2, 2))] * len(z)
    for k in range(len(z) - 2, -1, -1):
        C = Ps[k] @ F.T @ np.linalg.inv(before[k + 1][1])
        lag[k + 1] = Ps[k + 1] @ C.T
        xs[k] = xs[k] + C @ (xs[k + 1] - before[k + 1][0])
        Ps[k] = Ps[k] + C @ (Ps[k + 1] - before[k + 1][1]) @ C.T
    return np.array(xs), np.array(Ps), np.array(lag)


def em_step(z, q, r):
    """One step of EM. Shumway & Stoffer, J. Time Series Analysis 3(4), 1982."""
    inverse, moved, missed = np.linalg.inv(Q), 0.0, 0.0
    for track in z:
        x, P, lag = smoothed(track, q, r)
        d = x[1:] - x[:-1] @ F.T
        spread = P[1:] + F @ P[:-1] @ F.T - lag[1:] @ F.T - F @ lag[1:].transpose(0, 2, 1)
        moved += np.einsum("ij,kji->", inverse, np.einsum("ki,kj->kij", d, d) + spread)
        missed += ((track - x[:, 0]) ** 2 + P[:, 0, 0]).sum()
    return moved / (2 * TRACKS * (SCANS - 1)), missed / (TRACKS * SCANS)


@pytest.fixture(scope="module")
def greatest():
    """Data, and q and r at the maximum of jink's likelihood, found by its own gradient."""
    z = simulated(3.0, 400.0, np.random.default_rng(5))
    tracks = Tracks(np.tile(np.arange(SCANS) * T, TRACKS), z.reshape(-1, 1), np.arange(TRACKS + 1) * SCANS)
    motion, sensor = jink.ConstantVelocity(acceleration_psd=20.0), jink.Position(sd=50.0, axes=1)
    start = jink.Kalman(motion, sensor, initial=jink.Prior(np.zeros(2), P0))
    parameters = Parameters(start, free=["*"])
    assert parameters.names == ("constant_velocity.acceleration_psd", "sensor.sd")
    found = minimize(
        lambda u: Likelihood().evaluate(parameters, u, tracks)[:2],
        parameters.start,
        jac=True,
        method="L-BFGS-B",
        options={"ftol": 1e-15, "gtol": 1e-9},
    )
    return z, tracks, parameters, found.x


def test_the_maximum_of_the_likelihood_is_a_fixed_point(greatest):
    z, _, _, u = greatest
    q, r = np.exp(u[0]), np.exp(2 * u[1])
    assert em_step(z, q, r) == pytest.approx((q, r), rel=1e-6)


def test_em_from_elsewhere_arrives_there(greatest):
    z, _, _, u = greatest
    q, r = 20.0, 2500.0
    for _ in range(200):
        q, r = em_step(z, q, r)
    assert (np.log(q), 0.5 * np.log(r)) == pytest.approx(tuple(u), abs=0.02)


def test_the_fit_ends_there(greatest):
    """Within what its weak prior and its stopping rule leave: a third of a standard error."""
    _, tracks, parameters, u = greatest
    found = Search(parameters, Likelihood(), tracks, starts=1).run()
    q_error, r_error = np.sqrt(2.0 / (2 * TRACKS * SCANS)), np.sqrt(1.0 / (2 * TRACKS * SCANS))
    assert np.abs(found.u - u) == pytest.approx((0.0, 0.0), abs=max(q_error, r_error))
