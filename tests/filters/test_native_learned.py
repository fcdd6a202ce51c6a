"""The native filters that decide, follow rules or were learned against the textbook, as in test_native_adaptive."""

from __future__ import annotations

import numpy as np
import pytest
from networks import membership_functions, random_network
from numpy.testing import assert_allclose
from oracle import motion as om
from oracle.aided import Anfis, Perceptron, aided_position, within
from oracle.fuzzy import Rules, fuzzy_imm
from oracle.input_estimation import input_estimation
from oracle.neural_vsmm import by_mode, by_parameter, log_inputs, published_inputs
from oracle.variable_dimension import VariableDimension
from test_native_adaptive import SD, R, assert_close, assert_same, position, reports, run, stay

import jink
from jink.metrics.chi_square import quantile
from jink.models.anfis import Anfis as NativeAnfis
from jink.models.corrector import Corrector
from jink.models.noise_network import ModeNetwork, NoiseNetwork

TABLES = [
    [(0.0, 6.0, 0.0, 9.0, 0.2), (9.0, 5.0, 4.0, 8.0, 4.0), (-9.0, 5.0, -4.0, 8.0, 3.0)],
    [(0.0, 5.0, 1.0, 7.0, 20.0), (15.0, 9.0, -3.0, 6.0, 300.0)],
]


def rules(tables=TABLES):
    """jink's and the oracle's."""
    return [jink.FuzzyRules.of(t, unit=1.0) for t in tables], [Rules.table(t) for t in tables]


def fuzzy_modes(tables=TABLES, starts=(1.0, 5.0)):
    return [
        jink.FuzzyNoise(jink.ConstantVelocity(acceleration_sd=sd), table)
        for sd, table in zip(starts, rules(tables)[0], strict=False)
    ]


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_fuzzy_noise(axes):
    """One filter, and an IMM; a scan that is missed, whole or in part, keeps the last variance."""
    time, z = reports(axes)
    z[2, 2] = np.nan  # nothing measured yet: the declared variance holds
    modes, oracle = fuzzy_modes(), rules()[1]
    alone = fuzzy_imm(time, z, R(axes), oracle[:1], np.ones((1, 1)), np.ones(1), [1.0])
    assert_same(jink.Kalman(modes[0], position(axes)), alone, time, z)
    mu = np.array([0.6, 0.4])
    both = fuzzy_imm(time, z, R(axes), oracle, stay(0.9, 2), mu, [1.0, 25.0])
    f = jink.IMM(modes, position(axes), 0.9, mode_probability=mu)
    assert_same(f, both, time, z)


@pytest.mark.parametrize("jump", [2e4, -1e6, 1e9])
def test_far_outside_the_rules_the_nearest_answers(jump):
    """Firing strengths of exp(-1e15): in logarithms they still have an order."""
    time, z = reports(1)
    z[3, 25] += jump
    f = jink.IMM(fuzzy_modes(), position(1), 0.9, mode_probability=[0.6, 0.4])
    want = fuzzy_imm(time, z, R(1), rules()[1], stay(0.9, 2), np.array([0.6, 0.4]), [1.0, 25.0])
    assert_same(f, want, time, z)
    assert np.isfinite(want.x[:, 1:]).all()


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize(("window", "shortest"), [(8, None), (5, 1), (6, 4)])
def test_input_estimation(axes, window, shortest):
    time, z = reports(axes)
    false_alarm = 1e-2
    motion = jink.ConstantVelocity(acceleration_sd=2.0)
    f = jink.InputEstimation(motion, position(axes), window=window, shortest=shortest, false_alarm=false_alarm)
    got = run(f, time, z)
    threshold = quantile(1 - false_alarm, axes)
    found = 0
    for b in range(len(z)):
        want = input_estimation(
            om.ConstantVelocity(axes, acceleration_sd=2.0),
            time,
            z[b],
            R(axes),
            window,
            threshold,
            shortest or max(1, window // 2),
        )
        found += int(want.detected.sum())
        assert_close(tuple(a[b : b + 1] for a in got), want.x[None], want.P[None])
    assert found >= 5


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("window", [3, 5])
def test_variable_dimension(axes, window):
    time, z = reports(axes, scans=80)
    quiet = {"acceleration_sd": 3.0}
    busy = {"jerk_psd": 2.0, "acceleration_prior_sd": 8.0}
    f = jink.VariableDimension(
        jink.ConstantVelocity(**quiet), jink.ConstantAcceleration(**busy), position(axes), window=window
    )
    got = run(f, time, z)
    _, rise, fall = f._thresholds()
    oracle = VariableDimension(
        om.ConstantVelocity(axes, **quiet), om.ConstantAcceleration(axes, **busy), R(axes), window, rise, fall
    )
    began, ended = 0, 0
    for b in range(len(z)):
        want = oracle.track(time, z[b])
        began += int((want.begun >= 0).sum())
        ended += int((np.diff(want.manoeuvring.astype(int)) < 0).sum())
        mu = np.stack([~want.manoeuvring, want.manoeuvring], axis=-1).astype(float)
        assert_close(tuple(a[b : b + 1] for a in got), want.x[None], want.P[None], mu[None])
    assert began >= 3 and ended >= 1


FORMS = {
    "published": {
        "inputs": "likelihood",
        "output": "variance",
        "centre": [20.0, 0.03, 0.03],
        "scale": [30.0, 0.05, 0.05],
        "output_centre": 30.0,
        "output_scale": 20.0,
    },
    "logarithmic": {
        "inputs": "log-nis",
        "output": "log-variance",
        "centre": [2.0, 0.0, 0.0],
        "scale": [2.0, 2.0, 2.0],
    },
}


@pytest.mark.parametrize("form", FORMS)
def test_a_network_that_chooses_the_noise(form):
    time, z = reports(2)
    network = NoiseNetwork(network=random_network([3, 6, 1], 6), least=0.5, most=400.0, start=4.0, **FORMS[form])
    f = jink.Kalman(jink.NetworkNoise(jink.ConstantVelocity(acceleration_sd=1.0), network), position(2))
    chosen = []

    def answer(u):
        chosen.append(network(u))
        return chosen[-1]

    inputs = published_inputs if form == "published" else log_inputs
    want = by_parameter(answer, time, z, R(2), 4.0, inputs)
    assert_same(f, want, time, z)
    q = np.concatenate(chosen)
    assert q.max() > 1.5 * q.min()  # it does choose


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("best", [1, 2, 4])
def test_a_network_that_weighs_the_modes(best, axes):
    time, z = reports(axes)
    z[np.isnan(z).any(axis=2)] = np.nan  # a partial scan weighs by what it has: below
    M, variances = 4, [0.5, 4.0, 30.0, 200.0]
    network = ModeNetwork(
        network=random_network([2 * M, 6, M], 5),
        centre=[0.2] * M + [0.0] * M,
        scale=[0.5] * M + [2.0] * M,
        best=best,
    )
    motions = [jink.ConstantVelocity(acceleration_sd=np.sqrt(v)) for v in variances]
    f = jink.NeuralModes(motions, position(axes), network)

    def scores(u):
        return network.network((u - np.asarray(network.centre)) / np.asarray(network.scale))

    want = by_mode(scores, time, z, R(axes), variances, best)
    assert_same(f, want, time, z)
    assert ((want.mu[:, 2:] > 0).sum(axis=-1) == best).all()
    assert len(np.unique(want.mu[:, 2:].argmax(axis=-1))) >= 2


def models(kind, inputs):
    """jink's model of one output, and the oracle's of u (..., inputs)."""
    if kind == "network":
        n = random_network([inputs, 5, 4, 1], 7)
        oracle = Perceptron([(np.asarray(w), np.asarray(b)) for w, b in zip(n.weights, n.biases, strict=True)])
        return n, lambda u: oracle(u)[..., 0]
    functions = [membership_functions(kind, 4, -1.0, 1.0), membership_functions(kind, 3, -1.5, 1.2)]
    consequents = np.random.default_rng(8).normal(size=(4, 3, 3))
    native = NativeAnfis(kind, functions, consequents.reshape(12, 1, 3).tolist())
    as_oracle = functions
    if kind == "bell":  # (half width, slope, centre) there
        as_oracle = [[(a, b, c) for c, a, b in f] for f in functions]
    oracle = Anfis(kind, tuple(as_oracle), consequents)
    return native, lambda u: oracle(u[..., 0], u[..., 1])


def predictions(f, time, z):
    """Of every scan the position and its variance before the measurement, (N, axes), by the filter live."""
    live = f.start()
    p = [f.components.index("p" + a) for a in "xyz"[: f.axes]]
    out = np.full((2, len(time), f.axes), np.nan)
    for k in range(len(time)):
        if k > 1:
            ahead = live.predict(time[k])
            out[0, k], out[1, k] = ahead.x[p], np.diag(ahead.P)[p]
        live.update(time[k], z[k])
    return out


BASES = {
    "kalman": lambda axes: jink.Kalman(
        jink.ConstantAcceleration(jerk_psd=0.01, acceleration_prior_sd=3.0), position(axes)
    ),
    "imm": lambda axes: jink.IMM(
        [jink.ConstantVelocity(acceleration_sd=0.3), jink.ConstantAcceleration(jerk_psd=1.0)],
        position(axes),
        0.9,
    ),
    "gpb2": lambda axes: jink.GPB2(
        [jink.ConstantVelocity(acceleration_sd=0.3), jink.ConstantAcceleration(jerk_psd=1.0)],
        position(axes),
        0.9,
    ),
}


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("kind", ["triangular", "gaussian", "bell", "network"])
def test_an_aid_on_residuals(kind, axes, base):
    """The estimate plus the corrector's answer; inside its range, at its edge and far outside."""
    time, z = reports(axes)
    z[0, 30:33] += 300.0
    native, oracle = models(kind, 2)
    low, high = np.array([-40.0, -30.0]), np.array([35.0, 30.0])
    centre, scale = np.array([1.0, -2.0]), np.array([25.0, 20.0])
    corrector = Corrector(
        model=native,
        inputs="titi-guney",
        low=low,
        high=high,
        centre=centre,
        scale=scale,
        output_scale=[6.0],
        fade=0.5,
    )

    def correct(x1, x2):
        u = np.stack([x1, x2], axis=-1)
        return within(u, low, high, 0.5) * 6.0 * oracle((np.clip(u, low, high) - centre) / scale)

    f = BASES[base](axes)
    plain, aided = run(f, time, z), run(jink.Aided(f, corrector), time, z)
    np.testing.assert_array_equal(plain[1], aided[1])
    p = [f.components.index("p" + a) for a in "xyz"[:axes]]
    rest = [i for i in range(len(f.components)) if i not in p]
    np.testing.assert_array_equal(plain[0][..., rest], aided[0][..., rest])
    moved = 0
    for b in range(len(z)):
        before = predictions(f, time, z[b])[0]
        for a in range(axes):
            seen = np.where(np.isnan(z[b]).any(axis=1), np.nan, z[b, :, a])[2:]
            want = aided_position(correct, seen, plain[0][b, 2:, p[a]], before[2:, a])
            assert_allclose(aided[0][b, 2:, p[a]], want, rtol=1e-9, atol=1e-8)
            moved += int((np.abs(want - plain[0][b, 2:, p[a]]) > 0.1).sum())
    assert moved > 50


@pytest.mark.parametrize("axes", [1, 2])
def test_an_aid_on_the_last_innovations(axes):
    """u = nu/sqrt(S), the newest first, zero before the track began; the answer in units of sqrt(S), 2 sd at most."""
    time, z = reports(axes)
    count = 3
    native, oracle = models("network", count)
    low, high = np.full(count, -3.0), np.full(count, 3.0)
    corrector = Corrector(
        model=native,
        inputs="innovations",
        low=low,
        high=high,
        centre=np.zeros(count),
        scale=np.full(count, 1.5),
        output_scale=[0.4],
        fade=0.7,
    )
    f = BASES["imm"](axes)
    plain, aided = run(f, time, z)[0], run(jink.Aided(f, corrector), time, z)[0]
    p = [f.components.index("p" + a) for a in "xyz"[:axes]]
    for b in range(len(z)):
        before, variance = predictions(f, time, z[b])
        S = variance + SD**2
        for a in range(axes):
            past = np.zeros(count)
            for k in range(2, len(time)):
                want = plain[b, k, p[a]]
                if not np.isnan(z[b, k]).any():
                    past = np.r_[(z[b, k, a] - before[k, a]) / np.sqrt(S[k, a]), past[:-1]]
                    answer = within(past, low, high, 0.7) * 0.4 * oracle(np.clip(past, low, high) / 1.5)
                    want = want + min(np.sqrt(S[k, a]), 2.0 * SD) * answer
                assert abs(aided[b, k, p[a]] - want) <= 1e-9 * (abs(want) + 10.0)
