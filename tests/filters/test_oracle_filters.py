"""The oracle's filters and smoothers against exact conditioning, enumeration of mode sequences and closed
forms.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle import exact, gaussian, pairwise
from oracle import motion as om
from oracle import sensor as osn
from oracle.chain import PerScan, Sojourn, stationary
from oracle.mixture import Mode, lift, match, mix, union
from oracle.smoother import smooth
from oracle.start import Fix, OnePoint, Prior, TwoPoint, one_point, two_point
from oracle.tracker import GATED, INITIALISED, NONE, PREDICTED, RESTARTED, UPDATED, Filter, Outliers, track
from scipy.stats import multivariate_normal

nan = np.nan


def one(motion, sensor, initial, **more):
    return Filter([motion], [sensor], PerScan(1.0, 1), initial, **more)


def wide(motion, seed=0):
    """A full-rank prior with correlations."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(motion.n, motion.n))
    return Mode(rng.normal(size=motion.n), root @ root.T + np.eye(motion.n))


MODELS = [
    om.ConstantVelocity(2, acceleration_sd=0.5),
    om.ConstantVelocity(1, acceleration_psd=0.5),
    om.ConstantAcceleration(2, jerk_psd=0.2),
    om.Singer(1, 2.0, 3.0),
    om.KnownTurn(2, 0.3, acceleration_psd=0.1),
]


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
@pytest.mark.parametrize("linearisation", ["ekf", "ukf"])
def test_kalman_and_rts_are_conditioning(model, linearisation):
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.1, 2.0, 9))
    z = rng.normal(0, 3, (9, model.axes))
    z[4], z[6, 0] = nan, nan
    u = rng.normal(0, 1, (9, model.axes))
    sensor = osn.Position(model.axes, sd=1.3)
    start = wide(model)
    f = one(model, sensor, Prior([start]), linearisation=linearisation)
    est = track(f, time, z, u=u)
    dts = np.r_[0, np.diff(time)]
    for k in range(9):  # filtered = conditioned on z[0..k]
        want, log_likelihood = exact.condition([model], [0] * (k + 1), start, dts, z[: k + 1], sensor.R, u)
        assert_allclose(est.scans[k].modes[0].x, want[k].x, rtol=1e-8, atol=1e-9)
        assert_allclose(est.scans[k].modes[0].P, want[k].P, rtol=1e-8, atol=1e-9)
        assert_allclose(est.log_likelihood_scan[: k + 1].sum(), log_likelihood, rtol=1e-9)
    for back in (smooth(f, est), pairwise.smooth(f, est)):
        for k in range(9):
            assert_allclose(back.scans[k].modes[0].x, want[k].x, rtol=1e-7, atol=1e-8)
            assert_allclose(back.scans[k].modes[0].P, want[k].P, rtol=1e-7, atol=1e-8)


def test_two_point_start_is_bayes_with_a_flat_velocity():
    """Equal to conditioning on z1, z2 with a vast velocity prior and no process noise."""
    T, R = 1.7, np.array([[4.0, 1.0], [1.0, 9.0]])
    z = np.array([[3.0, -2.0], [10.0, 5.0]])
    for model in (om.ConstantVelocity(2, acceleration_sd=1e-9), om.ConstantAcceleration(2, jerk_psd=1e-18)):
        first, second = Fix(0.0, z[0], R), Fix(T, z[1], 2 * R)
        got = two_point(model, first, second)
        start = one_point(model, Fix(0.0, np.zeros(2), 1e9 * np.eye(2)), 1e4)
        x = gaussian.update(model, osn.Position(2, sd=1), start.x, start.P, z[0], R)
        p = gaussian.predict(model, x.x, x.P, T)
        x = gaussian.update(model, osn.Position(2, sd=1), p.x, p.P, z[1], 2 * R)
        assert_allclose(got.x, x.x, rtol=1e-4, atol=1e-3)
        assert_allclose(got.P, x.P, rtol=1e-4, atol=1e-2)
    # the textbook block
    model = om.ConstantAcceleration(1, jerk_psd=1.0, acceleration_prior_sd=30.0)
    got = two_point(model, Fix(0.0, np.zeros(1), np.eye(1) * 25), Fix(2.0, np.array([6.0]), np.eye(1) * 25))
    a = 30.0**2
    assert_allclose(got.x, [6, 3, 0])
    assert_allclose(got.P, [[25, 12.5, 0], [12.5, 2 * 25 / 4 + a, a], [0, a, a]])


def test_steady_state_is_the_alpha_beta_filter():
    """Kalata's tracking index: lambda = sd_a T^2/sd_z, closed-form gains (Bar-Shalom 2001, 6.5.3)."""
    T, sd_a, sd_z = 2.0, 0.3, 4.0
    index = sd_a * T**2 / sd_z
    r = (4 + index - np.sqrt(8 * index + index**2)) / 4
    alpha = 1 - r**2
    beta = 2 * (2 - alpha) - 4 * np.sqrt(1 - alpha)
    model, sensor = om.ConstantVelocity(1, acceleration_sd=sd_a), osn.Position(1, sd=sd_z)
    x, P = np.zeros(2), 100 * np.eye(2)
    for _ in range(500):
        p = gaussian.predict(model, x, P, T)
        x = gaussian.update(model, sensor, p.x, p.P, np.zeros(1), sensor.R)
        x, P, gain = x.x, x.P, p.P @ [1, 0] / (p.P[0, 0] + sd_z**2)
    assert_allclose(gain, [alpha, beta / T], rtol=1e-10)


def test_unscented_moments_of_a_turn():
    """Predicted mean closer to Monte Carlo than the EKF's, covariance within a few per cent."""
    model = om.CoordinatedTurn(2, acceleration_sd=1e-6, turn_rate_sd=1e-9)
    x, P = np.array([0, 100.0, 0, 50.0, 0.1]), np.diag([1.0, 1, 1, 1, 0.15**2])
    samples = np.random.default_rng(0).multivariate_normal(x, P, 100_000)
    moved = np.array([model.f(s, 3.0) for s in samples[:20_000]])
    ukf = gaussian.predict(model, x, P, 3.0, linearisation="ukf")
    ekf = gaussian.predict(model, x, P, 3.0)
    assert np.linalg.norm(ukf.x - moved.mean(0)) < 0.2 * np.linalg.norm(ekf.x - moved.mean(0))
    assert_allclose(np.sqrt(np.diag(ukf.P)), moved.std(0), rtol=0.06)


def test_unscented_bearing_across_the_wrap():
    sensor, model = osn.Bearing(0.05), om.ConstantVelocity(2, acceleration_sd=1.0)
    for y in (-1000.0, 1000.0):  # due south, where azimuth jumps, and its mirror image
        x, P = np.array([1.0, 0, y, 0]), np.diag([100.0**2, 1, 100.0**2, 1])
        bearing = np.arctan2(1.0, y)
        got = gaussian.update(model, sensor, x, P, np.array([osn.wrap(bearing + 0.05)]), sensor.R, "ukf")
        assert_allclose(got.innovation, 0.05, atol=0.002)
        assert abs(got.x[0] - 1.0) < 50


def test_unscented_standard_form():
    """The statistical linearisation's update is the standard one: x + Pxz S^-1 nu, P - Pxz S^-1 Pxz'."""
    model, sensor = om.ConstantVelocity(2, acceleration_sd=1.0), osn.Polar(10.0, 0.05, range_rate_sd=2.0)
    x, P = np.array([300.0, 20, 400, -10]), np.diag([50.0**2, 25, 60.0**2, 36]) + 10.0
    z = np.array([520.0, 0.7, -3.0])
    got = gaussian.update(model, sensor, x, P, z, sensor.R, "ukf")
    points = gaussian.sigma_points(x, P)
    image = np.array([sensor.h(p[[0, 2]], p[[1, 3]]) for p in points])
    mean = image.mean(0)
    S = (image - mean).T @ (image - mean) / 8 + sensor.R
    K = (points - x).T @ (image - mean) / 8 @ np.linalg.inv(S)
    assert_allclose(got.x, x + K @ (z - mean), rtol=1e-9)
    assert_allclose(got.P, P - K @ S @ K.T, rtol=1e-8, atol=1e-8)
    assert_allclose(got.log_likelihood, multivariate_normal(mean, S).logpdf(z), rtol=1e-9)


def test_partial_misses_use_what_is_there():
    sensor, model = osn.Polar(10.0, 0.05), om.ConstantVelocity(2, acceleration_sd=1.0)
    x, P = np.array([300.0, 20, 400, -10]), np.diag([50.0**2, 25, 60.0**2, 36])
    bearing = gaussian.update(model, osn.Bearing(0.05), x, P, np.array([0.7]), np.array([[0.05**2]]))
    got = gaussian.update(model, sensor, x, P, np.array([nan, 0.7]), sensor.R)
    assert_allclose(got.x, bearing.x)
    assert_allclose(got.P, bearing.P)


def test_stationary_and_sojourn():
    Pi = np.array([[0.9, 0.1, 0], [0.3, 0.6, 0.1], [0, 0.2, 0.8]])
    p = stationary(Pi)
    assert_allclose(p @ Pi, p)
    assert_allclose(p.sum(), 1)
    chain = Sojourn([30.0, 10.0])
    assert_allclose(chain.over(2.0) @ chain.over(3.5), chain.over(5.5), rtol=1e-12)
    rate = 1 / 30 + 1 / 10  # two modes in closed form
    stay = (1 / 10 + np.exp(-rate * 2) / 30) / rate
    assert_allclose(chain.over(2.0)[0], [stay, 1 - stay], rtol=1e-12)
    assert_allclose(chain.stationary(), [0.75, 0.25], rtol=1e-12)
    per_scan = PerScan(0.97, 3, step=1.0)
    assert_allclose(per_scan.over(2.0), per_scan.matrix @ per_scan.matrix, rtol=1e-12)
    assert_allclose(per_scan.over(0.5) @ per_scan.over(0.5), per_scan.matrix, rtol=1e-12)
    assert_allclose(per_scan.over(0.0), np.eye(3))


def test_markov_only_through_misses():
    """[.34, .66]: FilterPy's IMM, which keeps the last likelihood, gives [.432, .568] (FACTS 3)."""
    Pi = np.array([[0.9, 0.1], [0.2, 0.8]])
    models = [om.ConstantVelocity(1, acceleration_sd=s) for s in (0.1, 1.0)]
    f = Filter(models, [osn.Position(1, sd=1.0)], PerScan(Pi, 2), Prior([wide(m) for m in models]))
    f.mode_probability = np.array([0.2, 0.8])
    est = track(f, [0.0, 1.0, 2.0], [[nan], [nan], [nan]])
    assert_allclose(est.mode_probability, [[0.2, 0.8], [0.34, 0.66], [0.438, 0.562]])
    assert list(est.status) == [PREDICTED] * 3


def mixed_set():
    return [
        om.ConstantVelocity(2, acceleration_sd=0.3),
        om.ConstantAcceleration(2, jerk_psd=0.05, acceleration_prior_sd=2.0),
        om.CoordinatedTurn(2, acceleration_sd=0.2, turn_rate_sd=0.01, turn_rate_prior_sd=0.3),
        om.KnownTurn(2, -0.1, acceleration_sd=0.2),
    ]


@pytest.mark.parametrize("mixing", ["prior", "unbiased"])
def test_mixing_keeps_the_moments_of_shared_components(mixing):
    """Mixing moves probability between modes, not the mixture's mean or covariance."""
    models = mixed_set()
    modes, mu = [wide(m, s) for s, m in enumerate(models)], np.array([0.4, 0.3, 0.2, 0.1])
    c, mixed = mix(models, modes, mu, PerScan(0.8, 4).matrix, mixing)
    shared = [[m.index(name) for name in ("px", "vx", "py", "vy")] for m in models]
    before = match(mu, [Mode(m.x[i], m.P[np.ix_(i, i)]) for m, i in zip(modes, shared, strict=True)])
    after = match(c, [Mode(m.x[i], m.P[np.ix_(i, i)]) for m, i in zip(mixed, shared, strict=True)])
    assert_allclose(after.x, before.x)
    assert_allclose(after.P, before.P)


def test_entering_components():
    models = [om.ConstantVelocity(1, acceleration_sd=1.0), om.ConstantAcceleration(1, jerk_psd=1.0)]
    modes = [wide(m, s) for s, m in enumerate(models)]
    Pi, mu = np.array([[0.7, 0.3], [0.4, 0.6]]), np.array([0.5, 0.5])
    _, mixed = mix(models, modes, mu, Pi, "prior")
    w = np.array([0.3, 0.6]) / 0.9
    a = modes[1].x[2]
    assert_allclose(mixed[1].x[2], w[1] * a)
    assert_allclose(mixed[1].P[2, 2], w[0] * 100 + w[1] * modes[1].P[2, 2] + w[0] * w[1] * a**2)
    _, mixed = mix(models, modes, mu, Pi, "unbiased")
    assert_allclose(mixed[1].x[2], a)
    assert_allclose(mixed[1].P[2, 2], modes[1].P[2, 2])
    assert_allclose(mixed[0].x, (0.35 * modes[0].x + 0.2 * modes[1].x[:2]) / 0.55)


def test_lift_is_kinematics_with_its_jacobian():
    models = mixed_set()
    components = union(models)
    assert components == ("px", "vx", "ax", "py", "vy", "ay", "turn_rate")
    for seed, m in enumerate(models):
        mode, step = wide(m, seed), 1e-6
        base = lift(m, mode, components)
        columns = []
        for i in range(m.n):
            e = np.eye(m.n)[i] * step
            up, down = (lift(m, Mode(mode.x + d, mode.P), components).x for d in (e, -e))
            columns.append((up - down) / (2 * step))
        J = np.array(columns).T
        assert_allclose(base.P, J @ mode.P @ J.T, rtol=1e-6, atol=1e-6)
        _, vx, ax, _, vy, ay, w = base.x
        if m.name == "constant_acceleration":
            assert_allclose(w, (vx * ay - vy * ax) / (vx**2 + vy**2))
        elif m.name == "constant_velocity":
            assert (ax, ay, w) == (0, 0, 0)
        else:
            assert_allclose([ax, ay], [-w * vy, w * vx])
            assert m.turning or w == -0.1


def test_statuses_gate_and_restart():
    model, sensor = om.ConstantVelocity(2, acceleration_sd=0.5), osn.Position(2, sd=1.0)
    f = one(model, sensor, TwoPoint(10.0), outliers=Outliers(0.01, 1e5, 2))
    t = np.arange(12.0)
    z = np.c_[3 * t, -2 * t]
    z[0, 1] = nan  # no complete position yet
    z[3] = nan
    z[6] += 5e4  # one outlier
    z[9:] += 5e4  # a jump that stays
    est = track(f, t, z)
    U, P = UPDATED, PREDICTED
    assert list(est.status) == [NONE, INITIALISED, INITIALISED, P, U, U, GATED, U, U, GATED, RESTARTED, U]
    assert np.isnan(est.x[0]).all() and not np.isnan(est.x[1:]).any()
    assert_allclose(est.log_likelihood_scan[:4], 0)
    assert_allclose(est.log_likelihood_scan[6], np.log(0.01) - 2 * np.log(1e5), rtol=1e-12)
    assert_allclose(est.x[10], [z[10, 0], 0, z[10, 1], 0])
    gapped = z.copy()
    gapped[6] = nan
    assert_allclose(track(f, t, gapped).x[:9], est.x[:9])  # a gated row is a missing one


def test_soft_outlier_likelihood():
    model, sensor = om.ConstantVelocity(1, acceleration_sd=0.5), osn.Position(1, sd=1.0)
    plain, soft = (
        one(model, sensor, OnePoint(2.0)),
        one(model, sensor, OnePoint(2.0), outliers=Outliers(0.1, 50.0, 2)),
    )
    t, z = np.arange(4.0), np.array([[0.0], [1.0], [0.5], [2.0]])
    a, b = track(plain, t, z), track(soft, t, z)
    assert_allclose(b.log_likelihood_scan[1:], np.log(0.9 * np.exp(a.log_likelihood_scan[1:]) + 0.1 / 50), rtol=1e-12)
    assert a.log_likelihood_scan[0] == 0  # one-point start: counted from the second
