"""The textbook's adaptive filters against what they must equal: one another, the IMM, regression, by hand."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle import exact, many
from oracle import motion as om
from oracle import sensor as osn
from oracle.adaptive_imm import adaptive_imm, levels
from oracle.aided import Anfis, Perceptron, aided_position, within
from oracle.chain import PerScan
from oracle.current_statistical import (
    RAYLEIGH,
    CurrentStatistical,
    FuzzyCurrentStatistical,
    largest_k,
)
from oracle.fuzzy import Rules, fuzzy_imm
from oracle.input_estimation import input_estimation
from oracle.mixture import Mode
from oracle.neural_vsmm import by_mode, by_parameter
from oracle.pseudo_bayesian import gpb1, gpb2, static
from oracle.start import TwoPoint
from oracle.tracker import Filter, track
from oracle.two_stage import augmented, two_stage
from oracle.variable_dimension import VariableDimension, restarted
from oracle.variable_structure import (
    acceleration_grid,
    adapted_grid,
    graph_transition,
    most_probable,
    neighbours,
    switched,
    variable_structure,
)

R2 = 25.0 * np.eye(2)


def reports(tracks=4, scans=30, axes=2, seed=1, misses=True):
    """Irregular times, a random walk of velocities, some scans missing whole and some in part."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.3, 2.0, scans))
    velocity = np.cumsum(rng.normal(0, 4, (tracks, scans, axes)), axis=1)
    z = np.cumsum(velocity, axis=1) + rng.normal(0, 5, (tracks, scans, axes))
    if misses:
        z[:, 9] = np.nan
        z[0, 15:18] = np.nan
        z[-1, 20, 0] = np.nan
    return time, z


def bank(*noises, axes=2):
    return [om.ConstantVelocity(axes, acceleration_sd=sd) for sd in noises]


def stay(p, M):
    return np.full((M, M), (1 - p) / (M - 1)) + np.eye(M) * (p - (1 - p) / (M - 1))


def same(a, b, rtol=1e-9):
    for name in ("x", "P", "mu"):
        assert_allclose(getattr(a, name)[:, 1:], getattr(b, name)[:, 1:], rtol=rtol, atol=1e-9)


@pytest.mark.parametrize(
    "motions",
    [
        bank(0.5, 4.0),
        [
            om.ConstantVelocity(2, acceleration_psd=0.5),
            CurrentStatistical(2, 40.0, 8.0, acceleration_prior_sd=5.0),
        ],
        [FuzzyCurrentStatistical(2, 8.0, threshold=50.0, acceleration_prior_sd=5.0)],
    ],
    ids=["velocity", "with current statistical", "fuzzy limits alone"],
)
def test_many_tracks_are_each_track(motions):
    time, z = reports()
    M = len(motions)
    Pi = stay(0.9, M) if M > 1 else np.ones((1, 1))
    mu = np.arange(1.0, M + 1) / np.arange(1.0, M + 1).sum()
    together = many.imm(motions, time, z, R2, Pi, mu)
    f = Filter(motions, [osn.Position(2, sd=5.0)], PerScan(Pi, M), TwoPoint(30.0), mode_probability=mu)
    for b in range(len(z)):
        alone = track(f, time, z[b])
        assert_allclose(together.x[b, 1:], alone.x[1:], rtol=1e-9, atol=1e-9)
        assert_allclose(together.P[b, 1:], alone.P[1:], rtol=1e-9, atol=1e-9)
        assert_allclose(together.mu[b, 1:], alone.mode_probability[1:], rtol=1e-9, atol=1e-12)


def test_current_statistical_variance_and_guard():
    csaf = CurrentStatistical(1, 90.0, 20.0, acceleration_min=-60.0)
    got = csaf.variance(np.array([0.0, 30.0, -30.0, 90.0, 500.0, -61.0]))
    want = np.array([90.0, 60.0, 30.0, 0.9, 0.9, 0.6]) ** 2
    assert_allclose(got, RAYLEIGH * want)
    x = np.array([1.0, 2.0, 3.0])  # the mean keeps its acceleration, whatever the time constant
    assert_allclose(csaf.f(x, 2.0), [1 + 4 + 6, 2 + 6, 3])
    singer = om.Singer(1, np.sqrt(RAYLEIGH) * 87.0, 20.0)
    assert_allclose(csaf.noise(x, 1.5), singer.Q(1.5), rtol=1e-12)


def test_fuzzy_limits_stay_above_the_acceleration_up_to_the_bound():
    assert_allclose(largest_k(100.0, 90.0), 1.0536, rtol=1e-4)
    a = np.linspace(0, 90, 1001)
    for k, holds in ((0.97, True), (largest_k(100.0, 90.0) - 1e-9, True), (1.08, False)):
        upper, lower = FuzzyCurrentStatistical(1, 20.0, k1=k, k2=k).limits(a)
        assert np.all(upper >= a - 1e-9) == holds
        assert_allclose(lower, -upper)


def test_two_stage_is_augmented_without_bias_noise():
    time, z = reports(axes=1)
    for bias_sd, published in ((0.0, False), (3.0, True)):
        a = two_stage(time, z[..., 0], 25.0, 1.0, bias_sd, 100.0)
        b = augmented(time, z[..., 0], 25.0, 1.0, bias_sd, 100.0, published)
        assert_allclose(a.x[:, 1:], b.x[:, 1:], rtol=1e-10, atol=1e-10)
        assert_allclose(a.P[:, 1:], b.P[:, 1:], rtol=1e-10, atol=1e-10)


def test_two_stage_with_bias_noise_is_not_optimal():
    """The noise is taken to have acted since the start: its variances are too large."""
    time, z = reports(axes=1)
    a = two_stage(time, z[..., 0], 25.0, 1.0, 3.0, 100.0)
    b = augmented(time, z[..., 0], 25.0, 1.0, 3.0, 100.0)
    a, b = a.P[:, 10:, 0, 0], b.P[:, 10:, 0, 0]
    assert np.all(a > b) and np.mean(a / b) > 1.1


def test_adaptive_imm_without_levels_follows_its_side_estimate():
    time, z = reports(axes=1)
    got = adaptive_imm(time, z, 25.0 * np.eye(1), [], 1.0, 3.0, 100.0, np.ones((1, 1)), np.ones(1))
    ahat = two_stage(time, z[..., 0], 25.0, 1.0, 3.0, 100.0).x[..., 2]
    u = np.zeros((*z.shape[:2], 1, 1))
    u[:, 2:, 0, 0] = ahat[:, 1:-1]
    same(got, many.imm(bank(1.0, axes=1), time, z, 25.0 * np.eye(1), np.ones((1, 1)), np.ones(1), u))
    assert_allclose(levels([0.02, 0.04]), [0, 0.02, -0.02, 0.04, -0.04])


def test_per_axis_is_more_tracks():
    time, z = reports()
    one = many.imm(bank(0.5, 4.0, axes=1), time, many.each_axis(z), R2[:1, :1], stay(0.9, 2), np.full(2, 0.5))
    alone = many.imm(bank(0.5, 4.0, axes=1), time, z[2:3, :, 1:], R2[:1, :1], stay(0.9, 2), np.full(2, 0.5))
    assert_allclose(many.joined(one.x, 2)[2, 1:, 1], alone.x[0, 1:], rtol=1e-12)


def test_identical_modes_are_one_mode_in_every_method():
    time, z = reports()
    single = many.imm(bank(2.0), time, z, R2, np.ones((1, 1)), np.ones(1))
    Pi, mu = stay(0.8, 3), np.array([0.2, 0.3, 0.5])
    graph = neighbours(3, 1)
    for method in (
        partial(many.imm, Pi=Pi, mu=mu),
        partial(gpb1, Pi=Pi, mu=mu),
        partial(gpb2, Pi=Pi, mu=mu),
        partial(static, mu=mu),
        partial(variable_structure, Pi=Pi, mu=mu, propose=partial(switched, graph)),
    ):
        got = method(bank(2.0, 2.0, 2.0), time, z, R2)
        assert_allclose(got.x[:, 1:], single.x[:, 1:], rtol=1e-9, atol=1e-9)
        assert_allclose(got.P[:, 1:], single.P[:, 1:], rtol=1e-9, atol=1e-9)


def test_second_order_is_exact_for_two_scans():
    """Two scans after the start there are M^3 histories and GPB2 has merged none that differ in the last two modes
    but by their first, whose estimates are the same: exact. IMM and GPB1 are not.
    """
    time, z = reports(tracks=1, scans=4, misses=False)
    motions, Pi, mu = bank(0.5, 6.0), stay(0.8, 2), np.array([0.7, 0.3])
    start = many.started(motions, time, z, R2)
    starts = [Mode(m.x[0], m.P[0]) for m in start]
    dts = np.r_[0, np.diff(time)[1:]]
    hidden = np.vstack([np.full((1, 2), np.nan), z[0, 2:]])
    probability, modes, _ = exact.enumerate_sequences(motions, starts, mu, PerScan(Pi, 2), dts, hidden, R2)
    want = many.match(probability[-1], modes[-1])
    got = gpb2(motions, time, z, R2, Pi, mu)
    assert_allclose(got.mu[0, -1], probability[-1], rtol=1e-9)
    assert_allclose(got.x[0, -1], want.x, rtol=1e-9)
    assert_allclose(got.P[0, -1], want.P, rtol=1e-9)
    for other in (gpb1, many.imm):
        assert abs(other(motions, time, z, R2, Pi, mu).mu[0, -1, 0] - probability[-1, 0]) > 1e-6


def test_static_is_the_likelihood_of_whole_tracks():
    time, z = reports(tracks=1)
    motions, mu = bank(0.5, 2.0, 6.0), np.array([0.5, 0.3, 0.2])
    got = static(motions, time, z, R2, mu)
    evidence = []
    for motion in motions:
        f = Filter([motion], [osn.Position(2, sd=5.0)], PerScan(1.0, 1), TwoPoint(30.0))
        evidence.append(track(f, time, z[0]).log_likelihood)
    want = mu * np.exp(np.array(evidence) - max(evidence))
    assert_allclose(got.mu[0, -1], want / want.sum(), rtol=1e-8)


def test_variable_structure_with_everything_active_is_the_imm():
    time, z = reports()
    motions, mu = bank(0.5, 2.0, 6.0, 12.0), np.eye(4)[1]
    everything = np.ones((4, 4), dtype=bool)
    Pi = graph_transition(everything, 0.9)
    want = many.imm(motions, time, z, R2, Pi, mu)
    for propose in (partial(switched, everything), partial(most_probable, 4)):
        same(variable_structure(motions, time, z, R2, Pi, mu, propose), want)


def test_active_modes_are_those_proposed():
    time, z = reports()
    graph = neighbours(6, 1)
    motions, Pi = bank(*np.geomspace(0.3, 20, 6)), graph_transition(graph, 0.9)
    est = variable_structure(motions, time, z, R2, Pi, np.eye(6)[0], partial(switched, graph))
    for k in range(2, len(time)):
        active = graph[est.mu[:, k - 1].argmax(axis=1)]
        assert np.all(est.mu[:, k][~active] == 0)
    assert_allclose(est.mu[:, 1:].sum(axis=-1), 1)
    est = variable_structure(motions, time, z, R2, Pi, np.eye(6)[0], partial(most_probable, 2))
    assert np.all((est.mu[:, 1:] > 0).sum(axis=-1) <= 2)
    assert (est.mu[:, 1:].argmax(axis=-1) > 0).any()


def test_grid_moves_by_its_rules():
    grid = np.tile([-30.0, 0.0, 30.0], (4, 1))
    mu = np.array([[0.05, 0.9, 0.05], [0.2, 0.6, 0.2], [0.0, 0.05, 0.95], [0.8, 0.1, 0.1]])
    got = adapted_grid(grid, mu, 2.0, (-60.0, 60.0), 0.1, 0.9)
    want = [[-15, 0, 15], [-30, 0, 30], [28.5 - 15, 28.5, 60], [-21 - 30, -21, 9]]
    assert_allclose(got, want, atol=1e-12)
    time, z = reports(axes=1)
    est, grids = acceleration_grid(time, z, np.eye(1) * 25, 0.5, stay(0.9, 3), np.full(3, 1 / 3), 20.0, 1.0)
    assert np.isfinite(est.x[:, 1:]).all()
    assert np.all(np.diff(grids, axis=-1) >= 0) and np.abs(grids).max() <= 20


def test_rules_answer_everywhere_and_their_order_of_use():
    one = Rules(np.zeros((1, 2)), np.ones((1, 2)), np.array([4.0]))
    time, z = reports()
    Pi, mu = stay(0.9, 2), np.array([0.6, 0.4])
    constant = [one, Rules(one.centre, one.spread, np.array([36.0]))]
    same(fuzzy_imm(time, z, R2, constant, Pi, mu), many.imm(bank(2.0, 6.0), time, z, R2, Pi, mu))
    rules = Rules.table([(0.0, 5.0, 0.0, 8.0, 0.25), (20.0, 8.0, 10.0, 9.0, 64.0)])
    far = rules.q(np.array([0.0, 1e6, -1e6]), np.zeros(3))
    assert np.all(far >= 0.25) and np.all(far <= 64)
    assert_allclose(Rules.table([(0.3, 0.5, 0, 1, 2e-6)], 1e3, 1e6).w, 2.0)
    # by hand: the third scan's residual, with no change yet
    got = fuzzy_imm(time[:3], z[:1, :3, :1], R2[:1, :1], [rules], np.ones((1, 1)), np.ones(1))
    T, dt = time[1] - time[0], time[2] - time[1]
    v = (z[0, 1, 0] - z[0, 0, 0]) / T
    r = z[0, 2, 0] - z[0, 1, 0] - dt * v
    q = rules.q(np.array(r), np.array(0.0))
    P = 25 * (1 + 2 * dt / T + 2 * dt**2 / T**2) + q * dt**4 / 4
    assert_allclose(got.x[0, 2, 0], z[0, 1, 0] + dt * v + P / (P + 25) * r, rtol=1e-12)


def test_input_estimate_is_the_regression_on_its_onset():
    """Corrected state and covariance = the filter that carries the input as an unknown constant from the onset."""
    time, z = reports(tracks=1, scans=14, misses=False)
    z = z[0]
    z[8:] += np.array([300.0, -200.0]) * np.arange(1, 7)[:, None] ** 2
    motion = om.ConstantVelocity(2, acceleration_sd=1.0)
    est = input_estimation(motion, time, z, R2, window=6, threshold=40.0)
    k = int(np.flatnonzero(est.detected)[0])
    assert 8 <= k <= 10
    best, x = np.inf, None
    for onset in range(max(2, k - 5), k + 1):  # every onset in the window, by a filter with a flat input
        got, misfit = with_input(motion, time, z, onset, k)
        if misfit < best:
            best, x = misfit, got
    assert_allclose(est.x[k], x.x[:4], rtol=1e-6)
    assert_allclose(est.P[k], x.P[:4, :4], rtol=1e-4)
    assert_allclose(est.u[k], x.x[4:], rtol=1e-6)


def with_input(motion, time, z, onset, k):
    """[state, u] from the start to scan k, u acting from scan onset on, u flat before; and the squared residuals."""
    start = many.started([motion], time, z[None, :2], R2)[0]
    x, P = np.r_[start.x[0], 0, 0], np.zeros((6, 6))
    P[:4, :4], P[4:, 4:] = start.P[0], 1e11 * np.eye(2)
    H, misfit = np.eye(6)[[0, 2]], 0.0
    for i in range(2, k + 1):
        dt = time[i] - time[i - 1]
        A, Q = np.eye(6), np.zeros((6, 6))
        A[:4, :4], Q[:4, :4] = motion.F(x, dt), motion.Q(dt)
        if i >= onset:
            A[:4, 4:] = motion.input_matrix(dt)
        x, P = A @ x, A @ P @ A.T + Q
        S = H @ P @ H.T + R2
        nu, K = z[i] - H @ x, np.linalg.solve(S, H @ P).T
        misfit += nu @ np.linalg.solve(S, nu)
        x, P = x + K @ nu, (np.eye(6) - K @ H) @ P @ (np.eye(6) - K @ H).T + K @ R2 @ K.T
    return Mode(x, P), misfit


def test_no_manoeuvre_is_the_plain_filter():
    time, z = reports(tracks=1)
    motion = om.ConstantVelocity(2, acceleration_sd=4.0)
    plain = many.imm([motion], time, z, R2, np.ones((1, 1)), np.ones(1))
    est = input_estimation(motion, time, z[0], R2, window=6, threshold=1e9)
    assert not est.detected.any()
    assert_allclose(est.x[1:], plain.x[0, 1:], rtol=1e-9, atol=1e-9)
    active = om.ConstantAcceleration(2, jerk_psd=1.0)
    both = VariableDimension(motion, active, R2, 5, 1e9, 10.0).track(time, z[0])
    assert not both.manoeuvring.any()
    assert_allclose(both.x[1:, [0, 1, 3, 4]], plain.x[0, 1:], rtol=1e-9, atol=1e-9)


def test_variable_dimension_begins_in_the_past_and_ends():
    time = np.arange(60.0)
    truth = np.where(time < 20, 0.0, 15.0 * np.minimum(time - 20, 10) ** 2)
    truth = truth + np.where(time > 30, 300.0 * (time - 30), 0.0)
    z = (truth + 100 * time + np.random.default_rng(2).normal(0, 5, 60))[:, None]
    quiet = om.ConstantVelocity(1, acceleration_sd=0.5)
    active = om.ConstantAcceleration(1, acceleration_increment_sd=1.0)
    R = 25.0 * np.eye(1)
    est = VariableDimension(quiet, active, R, 5, 15.0, 12.0).track(time, z)
    k = int(np.flatnonzero(est.begun >= 0)[0])
    assert 20 <= k <= 24 and est.begun[k] == k - 5
    assert est.manoeuvring[25:30].all() and not est.manoeuvring[-1] and not est.manoeuvring[:20].any()
    assert_allclose(est.x[28, 2], 30.0, atol=6)
    # the restart: z and the estimate before carried through, errors and all
    before = Mode(np.array([3.0, 2.0]), np.array([[4.0, 1.0], [1.0, 2.0]]))
    got = restarted(before, np.array([20.0]), np.array([[9.0]]), 2.0, 1)
    assert_allclose(got.x, [20, 2 + (20 - 3 - 4), (20 - 3 - 4) / 2])
    p11, p12, p22, r, T = 4.0, 1.0, 2.0, 9.0, 2.0
    want = [
        [r, 2 * r / T, 2 * r / T**2],
        [2 * r / T, 4 / T**2 * (r + p11) + p22 + 4 / T * p12, 4 / T**3 * (r + p11) + 2 / T * p22 + 6 / T**2 * p12],
        [
            2 * r / T**2,
            4 / T**3 * (r + p11) + 2 / T * p22 + 6 / T**2 * p12,
            4 / T**4 * (r + p11 + 2 * T * p12 + T**2 * p22),
        ],
    ]
    assert_allclose(got.P, want)


def test_correctors():
    net = Perceptron([(np.array([[1.0, -2.0]]), np.array([0.5])), (np.array([[3.0]]), np.array([-1.0]))])
    assert_allclose(net(np.array([0.2, 0.1])), [3 * np.tanh(0.2 - 0.2 + 0.5) - 1])
    functions = [(-2.0, -1.0, 1.0), (-1.0, 1.0, 2.0)]
    plane = np.tile([0.5, -0.25, 2.0], (2, 2, 1))  # all rules say the same: a plane, inside and outside
    anfis = Anfis("triangular", (functions, functions), plane)
    x1, x2 = np.array([0.3, 50.0]), np.array([-0.4, -1.5])
    assert_allclose(anfis(x1, x2), 0.5 * x1 - 0.25 * x2 + 2)
    corner = np.zeros((2, 2, 3))
    corner[1, 0, 2] = 1.0  # only "x1 high, x2 low" says anything
    assert_allclose(Anfis("triangular", (functions, functions), corner)(np.array([0.5]), np.array([0.5])), 0.75 * 0.25)
    got = aided_position(lambda a, b: 2 * a + b, np.array([5.0, np.nan]), np.array([1.0, 1.0]), np.array([0.0, 7.0]))
    assert_allclose(got, [1 + 2 * 4 - 1, 1])
    low, high = np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    assert_allclose(within(np.array([[0.0, 1.0], [1.5, 0.0], [3.0, 0.0]]), low, high, 0.5), [1, 0.5, 0])


def test_networks_that_always_say_the_same_are_fixed_filters():
    time, z = reports()
    z[-1, 20] = np.nan  # scans are complete or missed
    fixed = by_parameter(lambda u: np.full(len(u), 9.0), time, z, R2, q_start=9.0)
    same(fixed, many.imm(bank(3.0), time, z, R2, np.ones((1, 1)), np.ones(1)))
    scores = by_mode(lambda u: np.tile([0.0, 5.0, 1.0], (len(u), 1)), time, z, R2, [1.0, 9.0, 25.0], best=1)
    assert_allclose(scores.x[:, 1:], fixed.x[:, 1:], rtol=1e-9)
    two = by_mode(lambda u: np.tile([0.0, 5.0, 1.0], (len(u), 1)), time, z, R2, [1.0, 9.0, 25.0], best=2)
    assert_allclose(two.mu[:, 3], np.tile([0, 1 / (1 + np.exp(-4)), 1 / (1 + np.exp(4))], (len(z), 1)))
