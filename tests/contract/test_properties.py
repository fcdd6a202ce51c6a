"""Whatever the steps, noise ratios, misses and outliers: never a NaN, never an indefinite covariance, or a
clear error.
"""

from __future__ import annotations

import numpy as np
import pytest
from agreement import assert_agrees
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from oracle import twin as tw
from oracle.situations import SITUATIONS, flight
from subjects import assert_positive

import jink

decades = st.floats(-12, 12).map(lambda e: 10.0**e)
steps = st.one_of(st.just(0.0), st.floats(-6, 4).map(lambda e: 10.0**e))


@st.composite
def motion(draw, level):
    """Any model, its noise at a level given relative to the sensor's."""
    kind = draw(st.sampled_from(["cv", "cv-psd", "ca", "ca-steps", "singer", "ct", "turn"]))
    sd = level
    return {
        "cv": lambda: jink.ConstantVelocity(acceleration_sd=sd),
        "cv-psd": lambda: jink.ConstantVelocity(acceleration_psd=sd**2),
        "ca": lambda: jink.ConstantAcceleration(jerk_psd=sd**2),
        "ca-steps": lambda: jink.ConstantAcceleration(acceleration_increment_sd=sd),
        "singer": lambda: jink.Singer(acceleration_sd=sd, time_constant=draw(st.sampled_from([0.1, 10.0, 1e4]))),
        "ct": lambda: jink.CoordinatedTurn(acceleration_sd=sd, turn_rate_sd=draw(st.sampled_from([1e-6, 1e-3, 0.1]))),
        "turn": lambda: jink.KnownTurn(draw(st.sampled_from([-0.3, 0.0, 1e-9, 0.05])), acceleration_sd=sd),
    }[kind]()


@st.composite
def filters(draw):
    sensor_sd = 10.0 ** draw(st.floats(-3, 6))
    ratios = draw(st.lists(decades, min_size=1, max_size=3))
    motions = [draw(motion(sensor_sd * np.sqrt(r))) for r in ratios]
    strict = jink.Outliers(share=0.2, extent=1e3, restart_after=3)
    more = {
        "initial": draw(st.sampled_from([jink.OnePoint(velocity_sd=100.0), jink.TwoPoint(velocity_sd=100.0)])),
        "outliers": draw(st.sampled_from([None, jink.Outliers(), strict])),
    }
    sensor = jink.Position(sd=sensor_sd, axes=2)
    if len(motions) == 1:
        return jink.Kalman(motions[0], sensor, **more), sensor_sd
    chain = draw(st.sampled_from([0.5, 0.97, 1 - 1e-12, jink.Sojourn(seconds=[30.0] * len(motions))]))
    mixing = draw(st.sampled_from(["prior", "unbiased"]))
    return jink.IMM(motions, sensor, chain, mixing=mixing, **more), sensor_sd


@st.composite
def data(draw, sensor_sd):
    N = draw(st.integers(1, 30))
    dt = np.array(draw(st.lists(steps, min_size=N, max_size=N)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    z = np.cumsum(rng.normal(0, 100.0, (N, 2)), axis=0) + rng.normal(0, sensor_sd, (N, 2))
    z[rng.random((N, 2)) < draw(st.sampled_from([0.0, 0.1, 0.6]))] = np.nan
    jump = draw(st.sampled_from([0.0, 5e4, 1e9]))
    z[rng.random(N) < 0.1] += jump
    return np.cumsum(dt), z


@settings(max_examples=250)
@given(st.data())
def test_finite_and_positive_or_a_clear_error(draws):
    f, sensor_sd = draws.draw(filters())
    t, z = draws.draw(data(sensor_sd))
    for run in (f.filter, f.smooth):
        est = run(t, z)
        there = est.status > 0
        assert np.isfinite(est.x[there]).all()
        assert np.isnan(est.x[~there]).all()
        assert_positive(est.P, est.status)
        assert np.isfinite(est.log_likelihood_scan).all()
        assert np.isfinite(est.nis[(est.status == 1) & (est.log_likelihood_scan != 0)]).all()
        assert_allclose(est.mode_probability[there].sum(axis=1), 1, rtol=1e-9)
        assert (est.mode_probability[there] >= 0).all()


@pytest.mark.parametrize(
    ("noises", "stay", "t"),
    [((3.2, 1e5), 0.5, [0, 1000, 1001]), ((1.0, 3e4, 1e-4), 0.97, [0, 0, 0, 0, 100, 200])],
)
def test_smoothing_modes_of_very_different_noise(noises, stay, t):
    """Found by the search above: process noise up to 1e21 times the sensor's over one step."""
    f = jink.IMM(
        [jink.ConstantVelocity(acceleration_sd=s) for s in noises],
        jink.Position(sd=1.0),
        stay,
        initial=jink.OnePoint(velocity_sd=100.0),
    )
    z = np.random.default_rng(0).normal(0, 80.0, (len(t), 2))
    est = f.smooth(np.array(t, float), z)
    assert np.isfinite(est.x).all()
    assert_positive(est.P, est.status)


def test_smoothing_a_track_that_is_given_up_over_a_gap():
    """Found by the search above: 100 s at 1e10 m/s² leave a covariance that is singular to rounding."""
    motions = [
        jink.ConstantVelocity(acceleration_sd=1e6),
        jink.ConstantAcceleration(acceleration_increment_sd=1.3e10),
    ]
    f = jink.IMM(
        motions,
        jink.Position(sd=1e6),
        0.5,
        initial=jink.OnePoint(velocity_sd=100.0),
        outliers=jink.Outliers(share=0.2, extent=1e3, restart_after=3),
    )
    est = f.smooth(np.array([0.0, 100.0, 100.0]), np.array([[0.0, 2e6], [1.9e5, -6e5], [-4e5, -1e6]]))
    assert np.isfinite(est.x).all()
    assert_positive(est.P, est.status)


@settings(max_examples=60)
@given(st.data())
def test_gating_never_raises_the_likelihood_by_rejecting(draws):
    """log[(1-e) N + e/V] lies above twice the outliers' part where a row is used, below it where rejected.

    A row may be used below it once innovations were large (tests/filters/test_surprise.py), not while they are small.
    """
    f, sensor_sd = draws.draw(filters())
    t, z = draws.draw(data(sensor_sd))
    if f.outliers is None:
        return
    est = f.filter(t, z)
    gated = np.isin(est.status, (3, 4))
    floor = np.log(f.outliers.share) - est.nis_dof * np.log(f.outliers.extent)
    assert (est.log_likelihood_scan[gated] <= floor[gated] + np.log(2) + 1e-9).all()
    used = (est.status == 1) & (est.log_likelihood_scan != 0)
    surprising = np.nan_to_num(est.nis) > 4 * est.nis_dof
    used &= len(est.modes) == 1 and not surprising[used].any()
    assert (est.log_likelihood_scan[used] >= floor[used] + np.log(2) - 1e-9).all()


@given(st.data())
def test_rows_after_do_not_change_rows_before(draws):
    """A filter is causal: cutting the track leaves the earlier rows bit for bit."""
    f, sensor_sd = draws.draw(filters())
    t, z = draws.draw(data(sensor_sd))
    cut = len(t) // 2 + 1
    whole, part = f.filter(t, z), f.filter(t[:cut], z[:cut])
    for name in ("x", "P", "mode_probability", "log_likelihood_scan", "status"):
        assert_array_equal(getattr(whole, name)[:cut], getattr(part, name))


@settings(max_examples=80)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(-3, 3),
    st.lists(steps.filter(lambda dt: dt < 100), min_size=3, max_size=25),
    st.sampled_from(["kalman-cv-1", "imm-mixed", "imm-robust", "imm-turns-and-ca"]),
)
@example(0, 1.0, [0.0, 0.0, 1e-6], "imm-turns-and-ca")  # a speed of 0.3 mm/s has a direction, but hardly
def test_native_is_the_oracle_whatever_the_steps(seed, exponent, dts, name):
    """As test_oracle_native, with steps and noise chosen against us."""
    twin = SITUATIONS[name]
    rng = np.random.default_rng(seed)
    t = np.cumsum(dts)
    N, sensor = len(t), twin.sensors[0].sensor()
    p, v = flight(t, twin.axes, rng)
    z = np.array([sensor.h(p[k], v[k]) for k in range(N)])
    z += rng.normal(size=z.shape) * np.sqrt(np.diag(sensor.R)) * 10.0 ** min(exponent, 1.0)
    z[2:][rng.random(N - 2) < 0.2] = np.nan
    R = np.tile(sensor.R * 10.0 ** (2 * exponent), (N, 1, 1))
    assert_agrees(twin, tw.Data(t, z, R=R))
