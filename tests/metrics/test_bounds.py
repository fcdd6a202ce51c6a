"""The bounds against what they must equal, and filters against the bounds."""

from __future__ import annotations

import families
import numpy as np
import pytest

import jink
from jink import metrics
from jink.compare import clairvoyant

SCANS = 30
F1 = np.array([[1.0, 2.0], [0, 1]])
F = np.kron(np.eye(2), F1)
H = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0]])


def riccati(Q, R, P0):
    """The covariances of the Kalman filter, textbook form."""
    covariances, P = [], P0
    for k in range(SCANS):
        if k:
            P = F @ P @ F.T + Q
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        P = P - K @ H @ P
        covariances.append(P)
    return np.array(covariances)


def piecewise(sd):
    G = np.array([2.0, 2.0])
    return np.kron(np.eye(2), sd**2 * np.outer(G, G))


def white(psd):
    return np.kron(np.eye(2), psd * np.array([[8 / 3, 2.0], [2.0, 2.0]]))


P0 = np.diag([1e4, 900.0, 1e4, 900.0])
R = np.diag([25.0, 36.0])
J_Z = np.broadcast_to(H.T @ np.linalg.inv(R) @ H, (SCANS, 4, 4))


@pytest.mark.parametrize("Q", [piecewise(2.0), white(3.0), np.zeros((4, 4))])
def test_posterior_bound_is_the_riccati_recursion(Q):
    bound = metrics.posterior_bound(F, Q, J_Z, P0)
    assert np.allclose(bound, riccati(Q, R, P0), rtol=1e-9, atol=1e-9)


def test_posterior_bound_is_the_engines_covariance():
    kalman = jink.Kalman(
        jink.ConstantVelocity(acceleration_sd=2.0),
        jink.Position(covariance=R),
        initial=jink.Prior(np.zeros(4), P0),
    )
    estimate = kalman.filter(np.arange(SCANS) * 2.0, np.zeros((SCANS, 2)))
    assert np.allclose(metrics.posterior_bound(F, piecewise(2.0), J_Z, P0), estimate.P, rtol=1e-9, atol=1e-9)


def test_tichavsky_is_the_same_for_linear_motion():
    Q = white(3.0)
    jacobians = np.broadcast_to(F, (5, SCANS, 4, 4))
    bound = metrics.tichavsky_bound(jacobians, Q, J_Z, P0)
    assert np.allclose(bound, riccati(Q, R, P0), rtol=1e-8)
    with pytest.raises(ValueError, match="singular one in scan 1"):
        metrics.tichavsky_bound(jacobians, piecewise(2.0), J_Z, P0)


def test_tichavsky_of_random_jacobians_by_loops():
    rng = np.random.default_rng(0)
    jacobians = F + 0.1 * rng.standard_normal((6, SCANS, 4, 4))
    Q, J = white(3.0), np.linalg.inv(P0) + J_Z[0]
    bound = metrics.tichavsky_bound(jacobians, Q, J_Z, P0)
    for k in range(1, SCANS):
        D11 = sum(f.T @ np.linalg.inv(Q) @ f for f in jacobians[:, k]) / 6
        D12 = sum(-f.T @ np.linalg.inv(Q) for f in jacobians[:, k]) / 6
        J = np.linalg.inv(Q) + J_Z[k] - D12.T @ np.linalg.inv(J + D11) @ D12
        assert np.allclose(bound[k], np.linalg.inv(J), rtol=1e-8)


def polar_jacobian(truth):
    """d(range, azimuth)/d(px, vx, py, vy) with the azimuth from north (the second axis), clockwise."""
    x, y = truth[..., 0], truth[..., 1]
    r = np.hypot(x, y)
    out = np.zeros((*x.shape, 2, 4))
    out[..., 0, 0], out[..., 0, 2] = x / r, y / r
    out[..., 1, 0], out[..., 1, 2] = y / r**2, -x / r**2
    return out


def test_a_radar_filter_obeys_the_bound_and_comes_close():
    rng = np.random.default_rng(5)
    runs, noise = 400, np.diag([30.0**2, 0.01**2])
    prior = np.diag([200.0**2, 20.0**2, 200.0**2, 20.0**2])
    mean = np.array([4000.0, 10, 8000, -20])
    x = mean + rng.standard_normal((runs, 4)) @ np.sqrt(prior)
    root = np.linalg.cholesky(white(1.0))
    truth = np.empty((runs, SCANS, 4))
    for k in range(SCANS):
        x = x @ F.T + rng.standard_normal((runs, 4)) @ root.T if k else x
        truth[:, k] = x
    position = truth[..., [0, 2]]
    z = np.stack([np.hypot(*np.moveaxis(position, -1, 0)), np.arctan2(position[..., 0], position[..., 1])], -1)
    z += rng.standard_normal(z.shape) * np.sqrt(np.diag(noise))
    filter = jink.Kalman(
        jink.ConstantVelocity(acceleration_psd=1.0),
        jink.Polar(range_sd=30.0, azimuth_sd=0.01),
        initial=jink.Prior(mean, prior),
    )
    estimate = filter.filter(
        np.tile(np.arange(SCANS) * 2.0, runs), z.reshape(-1, 2), offsets=np.arange(runs + 1) * SCANS
    )
    information = metrics.information(polar_jacobian(position), noise)
    bound = metrics.posterior_bound(F, white(1.0), information, prior)
    error = estimate.x.reshape(runs, SCANS, 4) - truth
    for index in ([0, 2], [1, 3]):
        achieved = metrics.rmse(error[..., index], first=1)
        limit = metrics.bound_rmse(bound, index, first=1)
        assert limit - 3 * achieved.se < achieved.value < 1.05 * limit + 3 * achieved.se


def test_missed_measurements_inform_less():
    jacobians = np.broadcast_to(H, (4, SCANS, 2, 4)).copy()
    jacobians[::2, 3] = np.nan
    information = metrics.information(jacobians, R)
    assert np.allclose(information[2], J_Z[2])
    assert np.allclose(information[3], J_Z[3] / 2)
    with pytest.raises(ValueError, match="jacobians, R"):
        metrics.information(jacobians, np.eye(3))


def figures(runs, estimate):
    n, scans, axes = runs.position.shape
    x = estimate.x.reshape(n, scans, 2 * axes)
    return x[..., ::2] - runs.position, x[..., 1::2] - runs.velocity, x


def told(runs, **known):
    time = np.arange(runs.position.shape[1], dtype=float)
    return clairvoyant(time, runs.measured, sensor=jink.Position(sd=runs.sd), acceleration_sd=1.0, **known)


@pytest.mark.parametrize(
    ("generate", "position", "velocity"),
    [(families.lee, 216.0, 24.9), (families.random_accelerations, 217.0, 24.5)],
)
def test_clairvoyant_figures(generate, position, velocity):
    runs = generate(500, 1)
    p, v, _ = figures(runs, told(runs, input=runs.input))
    for error, value in ((p, position), (v, velocity)):
        figure = metrics.rmse(error, first=5)
        assert abs(figure.value - value) < 3 * np.hypot(figure.se, figure.se)


def test_clairvoyant_normalised_errors_of_lee_2003():
    runs = families.lee(2000, 3)
    p, v, _ = figures(runs, told(runs, input=runs.input))
    measured = metrics.measured_velocity(runs.measured, np.arange(180.0))
    zeta_p = metrics.normalised_error(p, runs.measured - runs.position)
    zeta_v = metrics.normalised_error(v, measured - runs.velocity)
    assert abs(zeta_p.value - 0.3001) < 3 * np.hypot(zeta_p.se, zeta_p.se)
    assert abs(zeta_v.value - 0.0197) < 3 * np.hypot(zeta_v.se, zeta_v.se)


def test_clairvoyant_of_turns():
    runs, rates = families.random_turns(500, 1)
    time = np.arange(180.0)
    displacement = metrics.turn_displacement(runs.velocity, rates, time)
    estimate = told(runs, displacement=displacement)
    p, v, _ = figures(runs, estimate)
    for error, value in ((p, 31.2), (v, 4.86)):
        figure = metrics.rmse(error, first=5)
        assert abs(figure.value - value) < 3 * np.hypot(figure.se, figure.se)
    with pytest.raises(ValueError, match="Position sensor"):
        told(runs, displacement=displacement, input=runs.input)


def test_clairvoyant_is_consistent_and_at_the_bound():
    runs = families.lee(500, 2)
    estimate = told(runs, input=runs.input)
    p, v, x = figures(runs, estimate)
    truth = np.stack([runs.position, runs.velocity], axis=-1).reshape(x.shape)
    P = estimate.P.reshape(*x.shape, 4)
    c = metrics.consistency(metrics.nees(x - truth, P), 4, first=2)
    assert abs(c.mean.value - 1) < 3 * c.mean.se
    assert c.scans_inside > 0.85
    step = np.kron(np.eye(2), np.array([[1.0, 1.0], [0, 1]]))
    Q = np.kron(np.eye(2), np.outer([0.5, 1.0], [0.5, 1.0]))
    J = np.broadcast_to(H.T @ H / 500.0**2, (180, 4, 4))
    bound = metrics.posterior_bound(step, Q, J, np.diag([1e14, 1e10, 1e14, 1e10]))
    for error, index in ((p, [0, 2]), (v, [1, 3])):
        figure = metrics.rmse(error, first=5)
        assert abs(figure.value - metrics.bound_rmse(bound, index, first=5)) < 3 * figure.se
    nis = metrics.consistency(estimate.nis.reshape(500, 180), estimate.nis_dof.reshape(500, 180), first=2)
    assert abs(nis.mean.value - 1) < 3 * nis.mean.se
