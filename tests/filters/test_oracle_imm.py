"""The oracle's IMM filter and smoother against the sum over every sequence of modes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle import exact, pairwise
from oracle import motion as om
from oracle import sensor as osn
from oracle.chain import PerScan
from oracle.mixture import combine
from oracle.smoother import smooth
from oracle.start import Fix, OnePoint, Prior, one_point
from oracle.tracker import Filter, track

nan = np.nan


def manoeuvre(seed, N=7):
    """A short track that starts to turn, in modes CV (little noise), CV (much) and CA."""
    models = [
        om.ConstantVelocity(1, acceleration_sd=0.2),
        om.ConstantAcceleration(1, jerk_psd=0.1, acceleration_prior_sd=6.0),
    ]
    rng = np.random.default_rng(seed)
    t = np.arange(N, dtype=float)
    truth = 5.0 * t + 3.0 * np.clip(t - N // 2, 0, None) ** 2
    z = (truth + rng.normal(0, 2.0, N))[:, None]
    starts = [one_point(m, Fix(0.0, np.array([0.0]), np.eye(1) * 16), 8.0) for m in models]
    return models, starts, t, z


def test_imm_is_exact_for_two_scans_and_near_afterwards():
    chain, mu = PerScan(0.85, 2), np.array([0.6, 0.4])
    models, starts, t, z = manoeuvre(1)
    sensor = osn.Position(1, sd=2.0)
    f = Filter(models, [sensor], chain, Prior(starts), mode_probability=mu)
    est, dts = track(f, t, z), np.r_[0, np.diff(t)]
    for k in range(len(t)):
        p, modes, log_likelihood = exact.enumerate_sequences(
            models, starts, mu, chain, dts[: k + 1], z[: k + 1], sensor.R
        )
        tight = {"rtol": 1e-9, "atol": 1e-9} if k == 0 else {"rtol": 0.1, "atol": 0.1}
        assert_allclose(est.mode_probability[k], p[k], **tight)
        assert_allclose(est.log_likelihood_scan[: k + 1].sum(), log_likelihood, **tight)
        assert_allclose(est.x[k], combine(models, modes[k], p[k]).x, **({**tight, "atol": 0.5} if k else tight))


def test_identical_modes_are_one_mode():
    model, sensor = om.ConstantAcceleration(2, jerk_psd=0.2), osn.Position(2, sd=1.5)
    rng = np.random.default_rng(5)
    time, z = np.cumsum(rng.uniform(0.2, 2, 12)), rng.normal(0, 10, (12, 2))
    z[5] = nan
    single = Filter([model], [sensor], PerScan(1.0, 1), OnePoint(10.0))
    double = Filter([model, model], [sensor], PerScan([[0.9, 0.1], [0.3, 0.7]], 2), OnePoint(10.0))
    a, b = track(single, time, z), track(double, time, z)
    pairs = [(a, b), (smooth(single, a), smooth(double, b))]
    pairs += [(smooth(single, a), pairwise.smooth(double, b, rule)) for rule in ("kim", "point", "density", "future")]
    for p, q in pairs:
        assert_allclose(p.x, q.x, rtol=1e-9, atol=1e-9)
        assert_allclose(p.P, q.P, rtol=1e-9, atol=1e-9)
        assert_allclose(q.mode_probability, np.tile([0.75, 0.25], (12, 1)), rtol=1e-9)
    assert_allclose(a.log_likelihood_scan, b.log_likelihood_scan, rtol=1e-9)
    assert_allclose(a.nis, b.nis, rtol=1e-9)


def distance_from_exact(smoother):
    """RMS distance of position and velocity from the sum over every mode sequence, of the filter and of a
    smoother.
    """
    chain, mu, sensor = PerScan(0.85, 2), np.array([0.6, 0.4]), osn.Position(1, sd=2.0)
    filtered, smoothed = [], []
    for seed in range(4):
        models, starts, t, z = manoeuvre(seed)
        f = Filter(models, [sensor], chain, Prior(starts), mode_probability=mu)
        p, modes, _ = exact.enumerate_sequences(models, starts, mu, chain, np.r_[0, np.diff(t)], z, sensor.R)
        want = np.array([combine(models, m, q).x for m, q in zip(modes, p, strict=True)])
        est = track(f, t, z)
        back = smoother(f, est)
        filtered.append((est.x - want)[:, :2])
        smoothed.append((back.x - want)[:, :2])
        assert_allclose(back.x[-1], est.x[-1])
        for s in back.scans:
            assert all(np.linalg.eigvalsh(m.P).min() > 0 for m in s.modes)
            assert_allclose(s.mu.sum(), 1)
    return [np.sqrt(np.mean(np.square(e), axis=(0, 1))) for e in (filtered, smoothed)]


@pytest.mark.parametrize("smoother", [smooth, pairwise.smooth], ids=["messages", "pairs-future"])
def test_imm_smoother_is_near_the_exact_one(smoother):
    filtered, smoothed = distance_from_exact(smoother)
    assert np.all(smoothed < 0.2 * filtered)


@pytest.mark.parametrize("rule", ["kim", "point", "density"])
def test_smoothing_towards_a_state_that_forgets_its_past_is_worse(rule):
    """Why what is measured later is divided out of mode j's smoothed state, or sent back on its own."""
    _, ours = distance_from_exact(smooth)
    _, other = distance_from_exact(lambda f, est: pairwise.smooth(f, est, rule))
    assert np.all(other > 2 * ours)


def test_last_two_scans_of_the_imm_smoother_are_exact():
    """One step back from the last scan nothing has been approximated but the mixing: equal when the filter is
    exact.
    """
    chain, mu, sensor = PerScan(0.85, 2), np.array([0.6, 0.4]), osn.Position(1, sd=2.0)
    models, starts, t, z = manoeuvre(2)
    f = Filter(models, [sensor], chain, Prior(starts), mode_probability=mu)
    back = smooth(f, track(f, t[:2], z[:2]))
    p, modes, _ = exact.enumerate_sequences(models, starts, mu, chain, [0.0, 1.0], z[:2], sensor.R)
    assert_allclose(back.mode_probability[0], p[0], rtol=0.02)
    assert_allclose(back.x[0], combine(models, modes[0], p[0]).x, rtol=0.02, atol=0.05)
