"""The contract of every filter: each clause one test, run over every subject that claims it.

A subject that does not claim a clause is named in subjects.NOT_CLAIMED with the reason; nothing is skipped
silently. Clauses about batches, threads, live use and files are in test_contract_batch.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle import exact
from oracle import motion as om
from oracle.mixture import Mode
from oracle.situations import flight, times
from subjects import (
    CA,
    CV,
    NOT_CLAIMED,
    NOT_SMOOTHED,
    SUBJECTS,
    assert_close,
    assert_positive,
    build,
    claims,
    fleet,
    runs,
    scene,
)

import jink


def test_exclusions_name_subjects():
    for clause, names in NOT_CLAIMED.items():
        assert set(names) <= set(SUBJECTS), clause
        assert all(names.values())


@claims("linear_gaussian")
def test_linear_gaussian_is_the_kalman_filter(name):
    """An IMM of one mode, and the filter itself, give the conditional mean: here against a batch least
    squares.
    """
    rng = np.random.default_rng(1)
    filter_ = build(name)
    oracle_motion = oracle_of(name)
    n = oracle_motion.n
    root = rng.normal(size=(n, n))
    start = Mode(rng.normal(size=n) * 10, root @ root.T * 20 + np.eye(n))
    filter_ = build(name, initial=jink.Prior(start.x, start.P))
    t = np.cumsum(rng.uniform(0.2, 2.0, 8))
    z = rng.normal(0, 30.0, (8, 2))
    z[3], z[5, 1] = np.nan, np.nan
    est = filter_.filter(t, z)
    want, log_likelihood = exact.condition([oracle_motion], [0] * 8, start, np.r_[0, np.diff(t)], z, 625.0 * np.eye(2))
    assert_allclose(est.x[-1], want[-1].x, rtol=1e-9)
    assert_allclose(est.P[-1], want[-1].P, rtol=1e-8, atol=1e-9)
    assert_allclose(est.log_likelihood, log_likelihood, rtol=1e-10)
    smooth = filter_.smooth(t, z)
    for k in range(8):
        assert_allclose(smooth.x[k], want[k].x, rtol=1e-7, atol=1e-7)
        assert_allclose(smooth.P[k], want[k].P, rtol=1e-7, atol=1e-7)


def oracle_of(name):
    """The oracle's motion model of a linear subject."""
    return {
        "kalman-cv": om.ConstantVelocity(2, **CV),
        "kalman-cv-discrete": om.ConstantVelocity(2, acceleration_sd=1.0),
        "kalman-ca": om.ConstantAcceleration(2, **CA),
        "kalman-singer": om.Singer(2, acceleration_sd=5.0, time_constant=15.0),
        "kalman-known-turn": om.KnownTurn(2, 0.05, acceleration_psd=1.0),
    }[name]


@claims("identical_modes")
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
def test_identical_modes_are_their_single_mode(name, smooth):
    """Twice the first mode in an IMM: the Kalman filter of that mode; the probabilities stay stationary."""
    motion = SUBJECTS[name].motions()[-1]
    more = {"initial": jink.TwoPoint(velocity_sd=300.0)}
    if name.endswith("ukf"):
        more["linearisation"] = "ukf"
    single = jink.Kalman(motion, jink.Position(sd=25.0, axes=2), **more)
    double = jink.IMM([motion, motion], jink.Position(sd=25.0, axes=2), [[0.9, 0.1], [0.3, 0.7]], **more)
    t, z = scene()
    a, b = (f.smooth(t, z) if smooth else f.filter(t, z) for f in (single, double))
    assert a.components == b.components
    rtol = 1e-7 if smooth else 1e-9
    sd = np.sqrt(np.nanmax(np.einsum("kii->ki", a.P), axis=0))
    assert np.all(np.abs(b.x - a.x)[1:] <= rtol * (np.abs(a.x)[1:] + sd))
    assert np.all(np.abs(b.P - a.P)[1:] <= rtol * sd[:, None] * sd)
    assert_allclose(b.mode_probability, np.tile([0.75, 0.25], (len(t), 1)), rtol=1e-8)
    assert_allclose(b.log_likelihood, a.log_likelihood, rtol=1e-9)


@claims("miss")
def test_a_miss_is_prediction_only(name):
    """A missing row gives what the live filter predicts for its time, and leaves what follows as if it were
    not there.
    """
    t, z = scene(missing=0.0)
    z[30] = np.nan
    est = build(name).filter(t, z)
    live = build(name).start()
    for k in range(30):
        live.update(t[k], z[k])
    predicted = live.predict(t[30])
    assert est.status[30] == 2
    assert_allclose(est.x[30], predicted.x, rtol=1e-12)
    assert_allclose(est.P[30], predicted.P, rtol=1e-11, atol=1e-9)
    assert_allclose(est.mode_probability[30], predicted.mode_probability, rtol=1e-12, atol=1e-12)
    assert est.log_likelihood_scan[30] == 0


@claims("split_gap_state")
def test_splitting_a_gap_leaves_the_state(name):
    t, z = scene(missing=0.0)
    t[25:] += 37.0
    split_t = np.insert(t, 25, t[24] + 11.3)
    split_z = np.insert(z, 25, np.nan, axis=0)
    whole, split = build(name).filter(t, z), build(name).filter(split_t, split_z)
    assert_close(whole, split, rows=np.r_[:25, 26:51])
    assert_allclose(whole.log_likelihood, split.log_likelihood, rtol=1e-9)


@claims("split_gap_probability")
def test_splitting_a_gap_leaves_the_probabilities(name):
    """Sojourn times: over a gap only time counts, not how many rows lie in it."""
    t, z = scene(missing=0.0)
    t, z = np.append(t, t[-1] + 41.0), np.vstack([z, [np.nan, np.nan]])
    split_t = np.insert(t, 50, t[49] + [3.0, 17.0])
    split_z = np.insert(z, 50, np.full((2, 2), np.nan), axis=0)
    whole, split = build(name).filter(t, z), build(name).filter(split_t, split_z)
    assert_allclose(whole.mode_probability[-1], split.mode_probability[-1], rtol=1e-10)


@claims("rotation")
@pytest.mark.parametrize("angle", [0.7, -2.5])
def test_rotating_the_plane_rotates_the_answer(name, angle):
    a, b = rotated(name, angle)
    assert_allclose(a.mode_probability, b.mode_probability, atol=1e-8)


@claims("quarter_turn")
def test_a_quarter_turn_rotates_the_answer(name):
    """What filters claim as well that treat each axis by itself; modes along an axis change places."""
    a, b = rotated(name, np.pi / 2)
    a, b = (np.sort(e.mode_probability, axis=1) for e in (a, b))
    assert_allclose(a, b, atol=1e-8)


def rotated(name, angle):
    """Estimates of a flight and of the same flight rotated, found equal but for the rotation."""
    t, z = scene(seed=2)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    a, b = build(name).filter(t, z), build(name).filter(t, z @ turn.T)
    M = np.eye(len(a.components))
    for letter in "pva":
        if letter + "x" in a.components:
            i, j = a.components.index(letter + "x"), a.components.index(letter + "y")
            M[np.ix_([i, j], [i, j])] = turn
    sd = np.sqrt(np.einsum("kii->ki", b.P))
    assert np.all(np.abs(a.x @ M.T - b.x) <= 1e-8 * (np.abs(b.x) + sd + 1e-12))
    assert np.all(np.abs(M @ a.P @ M.T - b.P) <= 1e-7 * np.nanmax(sd, axis=0) * np.nanmax(sd, axis=0)[:, None] + 1e-12)
    assert_allclose(a.log_likelihood_scan, b.log_likelihood_scan, rtol=1e-7, atol=1e-7)
    return a, b


@claims("inputs")
def test_inputs_are_not_changed(name):
    t, z, offsets, _ = fleet()
    given = {"covariance": np.tile(625.0 * np.eye(2), (len(t), 1, 1)), "input": np.zeros((len(t), 2))}
    copies = [a.copy() for a in (t, z, offsets, *given.values())]
    for run in runs(name, build(name)):
        run(t, z, offsets=offsets, **given)
    for before, after in zip(copies, (t, z, offsets, *given.values()), strict=True):
        assert_array_equal(before, after)
    for a in (t, z, offsets):
        a.setflags(write=False)
    build(name).filter(t, z, offsets=offsets)


@claims("positive")
def test_covariances_stay_positive_over_a_hundred_thousand_scans(name):
    rng = np.random.default_rng(3)
    N = 100_000
    t = np.cumsum(rng.uniform(0.5, 1.5, N))
    z = np.c_[1e4 * np.sin(t / 90.0), 1e4 * np.cos(t / 70.0)] + rng.normal(0, 25.0, (N, 2))
    z[rng.random(N) < 0.05] = np.nan
    est = build(name).filter(t, z)
    assert np.isfinite(est.x[2:]).all()
    assert_positive(est.P[:: 97 if name.startswith("imm") else 31], est.status[:: 97 if name.startswith("imm") else 31])
    assert_positive(est.P[-100:], est.status[-100:])
    assert_allclose(np.nansum(est.mode_probability[-100:], axis=1), 1, rtol=1e-12)


@claims("outlier")
def test_fifty_kilometre_outlier(name):
    """Everything stays finite, positive and normalised."""
    t, z = scene(80, missing=0.0)
    z[40] += 5e4
    for run in runs(name, build(name)):
        est = run(t, z)
        assert np.isfinite(est.x).all()
        assert np.isfinite(est.log_likelihood_scan).all()
        assert_positive(est.P, est.status)
        assert_allclose(est.mode_probability.sum(axis=1), 1, rtol=1e-12)


@claims("outlier_forgotten")
def test_after_the_outlier_the_filter_comes_back(name):
    t, z = scene(80, missing=0.0)
    clean = build(name).filter(t, z)
    z[40] += 5e4
    est = build(name).filter(t, z)
    p = [est.components.index(c) for c in ("px", "py")]
    assert np.abs(est.x[-1, p] - clean.x[-1, p]).max() < 1000.0
    if name == "imm-robust":
        assert est.status[40] == 3
        assert np.abs(est.x[41:, p] - clean.x[41:, p]).max() < 100.0


@claims("noise_levels")
@pytest.mark.parametrize("variance", [1e-6, 1e-2, 1.0, 1e4, 1e8, 1e12])
def test_measurement_noise_over_eighteen_decades(name, variance):
    t, z = scene(200)
    for run in runs(name, build(name, jink.Position(sd=np.sqrt(variance), axes=2))):
        est = run(t, z)
        assert np.isfinite(est.x[2:]).all(), run
        assert_positive(est.P, est.status)


@pytest.mark.parametrize("name", NOT_SMOOTHED)
def test_smoothing_is_refused(name):
    """Before anything runs, saying why, and what to smooth instead; live with a lag as well."""
    f = build(name)
    t, z = scene()
    for run, argument in ((lambda: f.smooth(t, z), "smooth"), (lambda: f.start(lag=2), "lag")):
        with pytest.raises(ValueError, match=rf"^{argument}: .*{type(f).__name__}.*; smooth .*jink\."):
            run()


@claims("smooth")
def test_smoothing_does_not_hurt(name):
    """The last row is the filter's; variances do not grow; the truth is nearer on average."""
    rng = np.random.default_rng(5)
    better = []
    for _ in range(4):
        t = times(80, rng, 0.0)
        p, _ = flight(t, 2, rng)
        z = p + rng.normal(0, 25.0, p.shape)
        f, s = build(name).filter(t, z), build(name).smooth(t, z)
        # smoothing leaves a learned correction in the plane out: what is smoothed is the filter under it
        last = f if not isinstance(build(name), jink.Corrected) else build(name).filter_.filter(t, z)
        assert_allclose(s.x[-1], last.x[-1], rtol=1e-9)
        at = [f.components.index(c) for c in ("px", "py")]
        rms = [np.sqrt(np.mean((e.x[5:-3][:, at] - p[5:-3]) ** 2)) for e in (f, s)]
        better.append(rms[1] / rms[0])
        assert_positive(s.P, s.status)
    assert np.mean(better) < (1.0 if name == "kalman-known-turn" else 0.9)
