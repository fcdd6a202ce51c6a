"""The smoothers on what adaptive and learned filters recorded of their noise and known inputs, against the textbook.

Filters that cannot be smoothed are in subjects.NOT_SMOOTHED; here also those that no registered name has.
"""

from __future__ import annotations

import numpy as np
import pytest
from networks import random_network
from oracle import many
from oracle import motion as om
from oracle.adaptive_imm import adaptive_imm, levels
from oracle.fuzzy import fuzzy_imm
from oracle.many import Estimates
from oracle.neural_vsmm import by_parameter, log_inputs
from oracle.pseudo_bayesian import gpb1, gpb2, static
from oracle.recorded import smoothed
from test_native_adaptive import ESTIMATORS, LIMITED, R, assert_close, bank, position, reports, stay
from test_native_learned import fuzzy_modes, rules

import jink
from jink.models.noise_network import ModeNetwork, NoiseNetwork

ONE = np.ones((1, 1))
BOTH_WAYS = 1e-8  # rounding of two passes


def flights(axes, **more):
    return reports(axes, tracks=3, scans=32, **more)


def run(filter, time, z):
    B, N, axes = z.shape
    est = filter.smooth(np.tile(time, B), z.reshape(-1, axes), offsets=np.arange(B + 1) * N)
    return tuple(a.reshape(B, N, *a.shape[1:]) for a in (est.x, est.P, est.mode_probability))


def assert_smoothed(f, motions, time, z, Pi, filtered: Estimates):
    """Rows from the second: before it the textbook of many tracks has none."""
    want = smoothed(motions, time, z, R(z.shape[2]), Pi, filtered)
    assert_close(run(f, time, z), want.x, want.P, want.mu, tolerance=BOTH_WAYS)
    x, sd = filtered.x, np.sqrt(np.einsum("...ii->...i", filtered.P))
    assert (np.abs(want.x - x)[:, 1:] > 0.1 * sd[:, 1:]).mean() > 0.2  # it did smooth


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("name", ["csaf", "csaf-low", "facs", *LIMITED])
def test_current_statistical(name, axes):
    """The mean acceleration is a known input: Singer's transition carries the gain."""
    time, z = flights(axes)
    native, oracle = bank([name], axes)
    filtered = many.imm(oracle, time, z, R(axes), ONE, np.ones(1))
    assert_smoothed(jink.Kalman(native[0], position(axes)), oracle, time, z, ONE, filtered)


@pytest.mark.parametrize("axes", [1, 2])
@pytest.mark.parametrize("names", [["cv", "facs"], ["csaf", "facs"], ["cv", "ca", "facs"]], ids="+".join)
@pytest.mark.parametrize("method", ["imm", "gpb1", "mm"])
def test_current_statistical_among_others(method, names, axes):
    time, z = flights(axes)
    native, oracle = bank(names, axes)
    Pi, mu = stay(0.9, len(names)), np.full(len(names), 1 / len(names))
    if method == "mm":
        f = jink.StaticMM(native, position(axes), mode_probability=mu)
        return assert_smoothed(f, oracle, time, z, np.eye(len(names)), static(oracle, time, z, R(axes), mu))
    f = {"imm": jink.IMM, "gpb1": jink.GPB1}[method](native, position(axes), Pi, mode_probability=mu)
    filtered = {"imm": many.imm, "gpb1": gpb1}[method](oracle, time, z, R(axes), Pi, mu)
    return assert_smoothed(f, oracle, time, z, Pi, filtered)


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("names", [["cv", "brisk"], ["cv", "ca"], ["ca", "singer", "cv"]], ids="+".join)
@pytest.mark.parametrize("method", ["gpb1", "gpb2", "mm"])
def test_other_interactions(method, names, axes):
    """What comes after a scan says the same of a mode however the modes came to where they are."""
    time, z = flights(axes)
    native, oracle = bank(names, axes)
    M = len(names)
    Pi, mu = stay(0.9, M), np.arange(1.0, M + 1) / np.arange(1.0, M + 1).sum()
    if method == "mm":
        f = jink.StaticMM(native, position(axes), mode_probability=mu)
        Pi, filtered = np.eye(M), static(oracle, time, z, R(axes), mu)
    else:
        f = {"gpb1": jink.GPB1, "gpb2": jink.GPB2}[method](native, position(axes), Pi, mode_probability=mu)
        filtered = {"gpb1": gpb1, "gpb2": gpb2}[method](oracle, time, z, R(axes), Pi, mu)
    assert_smoothed(f, oracle, time, z, Pi, filtered)


@pytest.mark.parametrize("axes", [1, 2])
@pytest.mark.parametrize("jump", [50.0, 100.0])
def test_modes_that_lie_far_apart(jump, axes):
    """A target that jumps leaves the modes many of their sds apart: messages are spread without losing digits."""
    time, z = flights(axes, misses=False)
    z[:, 16:, 0] += jump
    native, oracle = bank(["cv", "brisk", "ca"], axes)
    Pi, mu = stay(0.9, 3), np.full(3, 1 / 3)
    f = jink.IMM(native, position(axes), Pi, mode_probability=mu)
    assert_smoothed(f, oracle, time, z, Pi, many.imm(oracle, time, z, R(axes), Pi, mu))


def test_static_models_are_smoothed_each_by_itself():
    """Exactly: Rauch-Tung-Striebel of each, weighed by what the whole track says of it."""
    time, z = flights(2)
    native, _ = bank(["cv", "brisk", "left"], 2)
    f = jink.StaticMM(native, position(2), mode_probability=[0.2, 0.3, 0.5])
    mu = np.repeat(run_filter(f, time, z)[2][:, -1:], len(time), axis=1)
    each = [run(jink.Kalman(m, position(2)), time, z) for m in native]
    w = np.moveaxis(mu, -1, 0)
    x = sum(a[..., None] * e[0] for a, e in zip(w, each, strict=True))
    P = sum(a[..., None, None] * (e[1] + many.outer(e[0] - x)) for a, e in zip(w, each, strict=True))
    assert_close(run(f, time, z), x, P, mu)


def run_filter(f, time, z):
    B, N, axes = z.shape
    est = f.filter(np.tile(time, B), z.reshape(-1, axes), offsets=np.arange(B + 1) * N)
    return tuple(a.reshape(B, N, *a.shape[1:]) for a in (est.x, est.P, est.mode_probability))


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_fuzzy_noise(axes):
    """One mode and two; a missed scan keeps its noise."""
    time, z = flights(axes)
    modes, oracle = fuzzy_modes(), rules()[1]
    cv = om.ConstantVelocity(axes, acceleration_sd=0.0)
    alone = fuzzy_imm(time, z, R(axes), oracle[:1], ONE, np.ones(1), [1.0])
    assert_smoothed(jink.Kalman(modes[0], position(axes)), [cv], time, z, ONE, alone)
    Pi, mu = stay(0.9, 2), np.array([0.6, 0.4])
    both = fuzzy_imm(time, z, R(axes), oracle, Pi, mu, [1.0, 25.0])
    f = jink.IMM(modes, position(axes), 0.9, mode_probability=mu)
    assert_smoothed(f, [cv, cv], time, z, Pi, both)


def test_noise_that_a_network_chooses():
    time, z = flights(2)
    network = NoiseNetwork(
        network=random_network([3, 6, 1], 6),
        least=0.5,
        most=400.0,
        start=4.0,
        inputs="log-nis",
        output="log-variance",
        centre=[2.0, 0.0, 0.0],
        scale=[2.0, 2.0, 2.0],
    )
    f = jink.Kalman(jink.NetworkNoise(jink.ConstantVelocity(acceleration_sd=1.0), network), position(2))
    filtered = by_parameter(network, time, z, R(2), 4.0, log_inputs)
    assert_smoothed(f, [om.ConstantVelocity(2, acceleration_sd=0.0)], time, z, ONE, filtered)


@pytest.mark.parametrize("side", ESTIMATORS)
def test_adaptive_imm(side):
    """The acceleration found beside the modes is a known input of theirs, as it was."""
    time, z = flights(1)
    Pi, mu = stay(0.97, 3), np.array([0.6, 0.2, 0.2])
    filtered = adaptive_imm(time, z, R(1), [20.0], 0.7, 3.0, 64.0, Pi, mu, side)
    cv = jink.ConstantVelocity(acceleration_sd=0.7)
    motions = [jink.AccelerationLevel(cv, level, estimated=True) for level in levels([20.0])]
    f = jink.AdaptiveIMM(motions, position(1), 0.97, estimator=ESTIMATORS[side], mode_probability=mu)
    assert_smoothed(f, [om.ConstantVelocity(1, acceleration_sd=0.7)] * 3, time, z, Pi, filtered)


class Augmented(om.ConstantAcceleration):
    """Constant velocity with acceleration noise, driven by an acceleration that is a random walk."""

    def Q(self, dt):
        G = np.array([dt**2 / 2, dt, 0.0])
        step = 9.0 * (dt > 0)
        return np.kron(np.eye(self.axes), 0.49 * np.outer(G, G) + np.diag([0.0, 0.0, step]))


@pytest.mark.parametrize("axes", [1, 2])
def test_augmented_acceleration(axes):
    time, z = flights(axes)
    oracle = [Augmented(axes, jerk_psd=1.0, acceleration_prior_sd=8.0)]
    filtered = many.imm(oracle, time, z, R(axes), ONE, np.ones(1))
    assert_smoothed(jink.Kalman(ESTIMATORS["augmented"], position(axes)), oracle, time, z, ONE, filtered)


def test_combinations_that_cannot_be_smoothed_say_so():
    """Part by part, wherever the part is: and the filter still filters."""
    time, z = flights(2)
    two_stage, (facs, cv) = ESTIMATORS["two-stage"], bank(["facs", "cv"], 2)[0]
    scores = ModeNetwork(network=random_network([4, 5, 2], 5), centre=[0.0] * 4, scale=[1.0] * 4, best=1)
    for f, why in (
        (jink.IMM([two_stage, cv], position(2), 0.9), "smooth a jink.AugmentedAcceleration"),
        (jink.GPB2([facs, cv], position(2), 0.9), "does not keep the noise.*; smooth a jink.IMM"),
        (jink.NeuralModes([cv, facs], position(2), scores), "scores, not probabilities; smooth .*jink.IMM"),
        (
            jink.AdaptiveGrid([cv, jink.ConstantVelocity(acceleration_sd=9.0)] * 2, position(2)),
            "set of modes changes.*jink.IMM",
        ),
    ):
        assert np.isfinite(f.filter(time, z[0]).x[1:]).all()
        for refused in (lambda f=f: f.smooth(time, z[0]), lambda f=f: f.start(lag=1)):
            with pytest.raises(ValueError, match=why):
                refused()
