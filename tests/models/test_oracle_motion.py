"""The oracle's motion models against van Loan's exponential, ODE integration and finite differences."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle import motion as om
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag

STEPS = [1e-3, 0.1, 1.0, 4.7, 60.0]


def van_loan(A, L, psd, dt):
    """F = expm(A T) and Q = int expm(A s) L psd L' expm(A s)' ds from one exponential (van Loan 1978).

    In 60 digits: the block holds expm(-A T) beside expm(A' T), and F @ block cancels; in doubles the result
    depends on the BLAS (Singer at T = 3 tau: 3e-10 off under one).
    """
    n = len(A)
    block = np.block([[-A, psd * np.outer(L, L)], [np.zeros((n, n)), A.T]])
    with mpmath.workdps(60):
        exponential = mpmath.expm(mpmath.matrix(block.tolist()) * mpmath.mpf(float(dt)))
        F = exponential[n:, n:].T
        Q = F * exponential[:n, n:]
        return np.array(F.tolist(), float), np.array(Q.tolist(), float)


@pytest.mark.parametrize("dt", STEPS)
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_continuous_noise_is_van_loan(axes, dt):
    psd = [0.3, 2.0, 7.0][:axes]
    cases = [
        (om.ConstantVelocity(axes, acceleration_psd=psd), np.diag([1.0], 1), [0, 1], psd),
        (om.ConstantAcceleration(axes, jerk_psd=psd), np.diag([1.0, 1.0], 1), [0, 0, 1], psd),
    ]
    tau, sd = 20.0, np.array([1.5, 2.0, 0.5])[:axes]
    A = np.array([[0, 1, 0], [0, 0, 1], [0, 0, -1 / tau]])
    cases.append((om.Singer(axes, sd, tau), A, [0, 0, 1], 2 / tau * sd**2))
    for model, A, L, psds in cases:
        by_axis = [van_loan(A, np.array(L, float), p, dt) for p in psds]
        assert_allclose(model.F(np.zeros(model.n), dt), block_diag(*[F for F, _ in by_axis]), rtol=1e-13)
        assert_allclose(model.Q(dt), block_diag(*[Q for _, Q in by_axis]), rtol=1e-13)


def test_singer_limits():
    """alpha T -> 0: white jerk of psd 2 alpha sigma^2; alpha T -> infinity: the acceleration forgets,
    variance sigma^2.
    """
    tau, sd = 1e7, 3.0
    white = om.ConstantAcceleration(1, jerk_psd=2 / tau * sd**2)
    assert_allclose(om.Singer(1, sd, tau).Q(1.0), white.Q(1.0), rtol=1e-6)
    assert_allclose(om.Singer(1, sd, tau).F(None, 1.0), white.F(None, 1.0), rtol=1e-6)
    fast = om.Singer(1, sd, 1e-3)
    assert_allclose(fast.Q(10.0)[2, 2], sd**2, rtol=1e-12)
    assert_allclose(fast.F(None, 10.0)[2, 2], 0, atol=1e-300)


@pytest.mark.parametrize(
    "model",
    [
        om.ConstantVelocity(2, acceleration_psd=2.0),
        om.ConstantAcceleration(2, jerk_psd=0.1),
        om.Singer(2, 3.0, 5.0),
        om.KnownTurn(2, 0.1, acceleration_psd=0.0),
    ],
    ids=lambda m: m.name,
)
def test_two_steps_are_one(model):
    a, b = 0.7, 2.6
    Fa, Fb = model.F(None, a), model.F(None, b)
    assert_allclose(Fb @ Fa, model.F(None, a + b), rtol=1e-12, atol=1e-12)
    assert_allclose(Fb @ model.Q(a) @ Fb.T + model.Q(b), model.Q(a + b), rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("w", [0.0, 1e-12, -1e-6, 3e-4, -0.02, 0.3, 2.0])
def test_turn_is_its_differential_equation(axes, w):
    """v' = w x v: state and Jacobian after T."""
    model = om.CoordinatedTurn(axes, acceleration_sd=1.0, turn_rate_sd=0.01)
    x = np.array([100.0, 200.0, -50.0, 30.0] + [7.0, -2.0] * (axes - 2) + [w])

    def derivative(t, s):
        d = np.zeros_like(s)
        d[0], d[2] = s[1], s[3]
        d[1], d[3] = -s[-1] * s[3], s[-1] * s[1]
        if axes == 3:
            d[4] = s[5]
        return d

    solved = solve_ivp(derivative, (0, 2.5), x, rtol=1e-12, atol=1e-12).y[:, -1]
    assert_allclose(model.f(x, 2.5), solved, rtol=1e-9, atol=1e-8)
    J, step = model.F(x, 2.5), 1e-5
    for i in range(model.n):
        e = np.zeros(model.n)
        e[i] = step
        assert_allclose(J[:, i], (model.f(x + e, 2.5) - model.f(x - e, 2.5)) / (2 * step), rtol=1e-6, atol=1e-5)


def test_turn_jacobian_at_zero_rate():
    """df/dw at w = 0: (-vy T^2/2, -vy T, vx T^2/2, vx T, 1)."""
    model = om.CoordinatedTurn(2, acceleration_sd=1.0, turn_rate_sd=0.01)
    J = model.F(np.array([1.0, 20.0, 2.0, 30.0, 0.0]), 2.0)
    assert_allclose(J[:, -1], [-30 * 2, -30 * 2, 20 * 2, 20 * 2, 1])
    straight = om.ConstantVelocity(2, acceleration_sd=1.0)
    assert_allclose(J[:4, :4], straight.F(None, 2.0))


MODELS = [
    om.ConstantVelocity(3, acceleration_sd=[1.0, 2.0, 3.0]),
    om.ConstantAcceleration(1, acceleration_increment_sd=0.3),
    om.ConstantAcceleration(2, jerk_psd=0.3),
    om.Singer(2, 3.0, 20.0),
    om.CoordinatedTurn(3, acceleration_psd=1.0, turn_rate_sd=0.01),
    om.CoordinatedTurn(2, acceleration_sd=1.0, turn_rate_psd=0.01),
    om.KnownTurn(2, 0.1, acceleration_sd=1.0),
]


@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.name}-{m.axes}")
def test_no_time_no_change(model):
    x = np.arange(1.0, model.n + 1) / 10
    assert_allclose(model.F(x, 0.0), np.eye(model.n), atol=1e-15)
    assert_allclose(model.f(x, 0.0), x)
    assert_allclose(model.Q(0.0), 0)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.name}-{m.axes}")
def test_noise_is_symmetric_and_not_negative(model):
    for dt in STEPS:
        Q = model.Q(dt)
        assert_allclose(Q, Q.T)
        scale = np.sqrt(np.diag(Q))
        assert np.linalg.eigvalsh(Q / np.outer(scale, scale)).min() > -1e-14


def test_known_input_moves_position_and_velocity_only():
    G = om.CoordinatedTurn(3, acceleration_sd=1.0, turn_rate_sd=0.1).input_matrix(2.0)
    assert_allclose(G @ [1.0, 10.0, 100.0], [2, 2, 20, 20, 200, 200, 0])
    G = om.ConstantAcceleration(1, jerk_psd=1.0).input_matrix(2.0)
    assert_allclose(G @ [3.0], [6, 6, 0])


def test_discrete_noise_is_rank_one_per_axis():
    Q = om.ConstantVelocity(1, acceleration_sd=0.5).Q(2.0)
    assert_allclose(Q, 0.25 * np.outer([2, 2], [2, 2]))
    Q = om.ConstantAcceleration(1, acceleration_increment_sd=0.5).Q(2.0)
    assert_allclose(Q, 0.25 * np.outer([2, 2, 1], [2, 2, 1]))
    Q = om.CoordinatedTurn(2, acceleration_sd=0.5, turn_rate_sd=0.1).Q(2.0)
    assert_allclose(Q[-1, -1], 0.01)  # per step, not per second
