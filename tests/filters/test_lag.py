"""Smoothing with a lag: between filtering and smoothing, and what live tracking with that lag gives."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import jink

FILTER = jink.IMM(
    [jink.ConstantVelocity(acceleration_sd=0.5), jink.ConstantAcceleration(jerk_psd=20.0)], jink.Position(sd=10.0), 0.95
)
KALMAN = jink.Kalman(jink.ConstantVelocity(acceleration_sd=2.0), jink.Position(sd=10.0))


def ragged(seed=0, tracks=21):
    """Tracks of 1 to 60 rows, irregular in time, a tenth of the measurements missing."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(1, 61, tracks)
    offsets = np.r_[0, np.cumsum(lengths)]
    time = np.concatenate([np.cumsum(rng.uniform(0.5, 2.0, n)) for n in lengths])
    z = np.cumsum(rng.normal(size=(offsets[-1], 2)) * 20.0, axis=0)
    z[rng.random(offsets[-1]) < 0.1] = np.nan
    return time, z, offsets


def assert_same(a, b, tolerance=0.0):
    for name in ("x", "P", "mode_probability"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=tolerance, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("f", [FILTER, KALMAN], ids=["imm", "kalman"])
def test_no_lag_is_the_filter_and_a_long_one_the_smoother(f):
    time, z, offsets = ragged()
    assert_same(f.smooth(time, z, offsets=offsets, lag=0), f.filter(time, z, offsets=offsets))
    assert_same(f.smooth(time, z, offsets=offsets, lag=60), f.smooth(time, z, offsets=offsets))
    assert_same(f.smooth(time, z, offsets=offsets, lag_seconds=1e6), f.smooth(time, z, offsets=offsets))


@pytest.mark.parametrize("f", [FILTER, KALMAN], ids=["imm", "kalman"])
@pytest.mark.parametrize("lag", [1, 3])
def test_equals_live_tracking_with_that_lag(f, lag):
    time, z, offsets = ragged()
    batch = f.smooth(time, z, offsets=offsets, lag=lag)
    for first, end in itertools.pairwise(offsets):
        live = f.start(lag=lag)
        late = [live.update(time[k], z[k]).x for k in range(first, end)][lag:]
        np.testing.assert_allclose(
            np.reshape(late, (-1, batch.x.shape[1])), batch.x[first : end - lag][: len(late)], rtol=1e-9
        )


def test_a_lag_in_seconds_uses_the_rows_of_those_seconds():
    time, z, offsets = ragged()
    batch = FILTER.smooth(time, z, offsets=offsets, lag_seconds=4.0)
    first, end = offsets[3], offsets[4]
    for k in range(first, end):
        seen = first + np.searchsorted(time[first:end], time[k] + 4.0, "right")
        whole = FILTER.smooth(time[first:seen], z[first:seen])
        np.testing.assert_allclose(batch.x[k], whole.x[k - first], rtol=1e-12)


def test_threads_and_neighbours_change_nothing():
    time, z, offsets = ragged(tracks=40)
    one = FILTER.smooth(time, z, offsets=offsets, lag=2, threads=1)
    assert_same(one, FILTER.smooth(time, z, offsets=offsets, lag=2, threads=2))
    first, end = offsets[9], offsets[10]
    np.testing.assert_array_equal(one.x[first:end], FILTER.smooth(time[first:end], z[first:end], lag=2).x)


def test_a_lag_lies_between_filter_and_smoother():
    """On random turns each scan of lag makes the error smaller: 200 tracks, differences of many standard errors."""
    rng = np.random.default_rng(5)
    n, tracks = 60, 200
    course = np.cumsum(np.repeat(rng.normal(0.0, 0.03, (tracks, n // 10)), 10, axis=1), axis=1)
    truth = np.cumsum(200.0 * np.stack([np.cos(course), np.sin(course)], axis=2), axis=1)
    z = truth + rng.normal(0.0, 10.0, truth.shape)
    time, offsets = np.tile(np.arange(n, dtype=float), tracks), np.arange(tracks + 1) * n

    def rms(estimate):
        x = estimate.x[:, [estimate.components.index("px"), estimate.components.index("py")]]
        return np.sqrt(np.nanmean((x.reshape(tracks, n, 2)[:, 10:] - truth[:, 10:]) ** 2))

    flat = z.reshape(-1, 2)
    errors = [rms(FILTER.filter(time, flat, offsets=offsets))]
    errors += [rms(FILTER.smooth(time, flat, offsets=offsets, lag=lag)) for lag in (1, 3)]
    errors.append(rms(FILTER.smooth(time, flat, offsets=offsets)))
    assert errors[0] > 1.1 * errors[1] and errors[1] > 1.02 * errors[2] and errors[2] > errors[3], errors


def test_models_of_ones_own_and_axes_apart():
    class Straight:
        components = ("px", "vx", "py", "vy")

        def f(self, x, dt):
            return x + np.stack([x[:, 1] * dt, 0 * dt, x[:, 3] * dt, 0 * dt], axis=1)

        def Q(self, dt):
            block = np.stack([np.stack([dt**4 / 4, dt**3 / 2], -1), np.stack([dt**3 / 2, dt**2], -1)], -2) * 4.0
            out = np.zeros((len(dt), 4, 4))
            out[:, :2, :2] = out[:, 2:, 2:] = block
            return out

    own = jink.Kalman(Straight(), jink.Position(sd=10.0))
    time, z, offsets = ragged(tracks=5)
    got, want = (f.smooth(time, z, offsets=offsets, lag=2) for f in (own, KALMAN))
    np.testing.assert_allclose(got.x, want.x, rtol=1e-7, atol=1e-6)
    with pytest.raises(ValueError, match="lag_seconds"):
        own.smooth(time, z, offsets=offsets, lag_seconds=3.0)
    apart = jink.AxisByAxis(jink.Kalman(jink.ConstantVelocity(acceleration_sd=2.0), jink.Position(sd=10.0, axes=1)), 2)
    np.testing.assert_allclose(apart.smooth(time, z, offsets=offsets, lag=2).x, want.x, rtol=1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"lag": -1}, "lag: expected a whole number of scans"),
        ({"lag": 1.5}, "lag: expected a whole number of scans"),
        ({"lag": True}, "lag: expected a whole number of scans"),
        ({"lag_seconds": -1.0}, "lag_seconds: expected seconds"),
        ({"lag_seconds": float("nan")}, "lag_seconds: expected seconds"),
        ({"lag": 1, "lag_seconds": 2.0}, "lag, lag_seconds: expected one of them"),
    ],
)
def test_a_wrong_lag_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        KALMAN.smooth([0.0, 1.0], np.zeros((2, 2)), **options)


def test_a_filter_that_cannot_be_smoothed_says_so():
    f = jink.InputEstimation(jink.ConstantVelocity(acceleration_sd=1.0), jink.Position(sd=10.0))
    with pytest.raises(ValueError, match="cannot smooth"):
        f.smooth([0.0, 1.0], np.zeros((2, 2)), lag=1)
