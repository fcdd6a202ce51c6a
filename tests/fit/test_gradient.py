"""Gradients through the filter: equal to central differences, for every kind of filter, sensor and parameter."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.situations import P2, SITUATIONS, make_data

import jink
from jink.fit.gradient import differentiable, gradient
from jink.fit.parameters import Parameters
from jink.models.tracks import Tracks

TOLERANCE = 1e-6


def tracks_of(twin, tracks=3, N=50):
    """Some tracks of a situation, of different lengths, with made-up truth of every component."""
    made = [make_data(twin, N=N - 7 * k, seed=k) for k in range(tracks)]
    time, z = np.concatenate([d.time for d in made]), np.concatenate([d.z for d in made])
    sensor = None if made[0].sensor is None else np.concatenate([d.sensor for d in made]).astype(np.int32)
    components = twin.native().components
    truth = np.random.default_rng(9).normal(0, 100.0, (len(time), len(components)))
    truth[::5] = np.nan
    offsets = np.r_[0, np.cumsum([len(d.time) for d in made])]
    return Tracks(time, z, offsets, sensor=sensor, truth=truth, components=components)


def with_differences(figure, parameters, u, k, step):
    """Fourth-order central difference of figure(filter) by the k-th parameter."""

    def at(h):
        moved = u.copy()
        moved[k] += h
        return figure(parameters.filter(moved))

    return (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step)


def assert_gradient(filter, tracks, name="likelihood", **options):
    """Every parameter's derivative, scaled by the size of the figure and of all derivatives."""
    parameters = Parameters(filter, free=["*"])
    u, none = parameters.start, np.zeros((0, filter.numbers.size))
    value, slope = gradient(filter, parameters.tangents(u), tracks, name, threads=1, **options)

    def figure(moved):
        return gradient(moved, none, tracks, name, threads=1, **options)[0]

    size = np.abs(value).max() + np.abs(slope).max()
    for k, each in enumerate(parameters.names):
        expected = with_differences(figure, parameters, u, k, 1e-3)
        assert np.abs(slope[k] - expected).max() / size < TOLERANCE, each
        assert np.isfinite(slope[k]).all(), each


@pytest.mark.parametrize("name", SITUATIONS)
def test_likelihood_gradient(name):
    twin = SITUATIONS[name]
    assert_gradient(twin.native(), tracks_of(twin))


@pytest.mark.parametrize("name", ["kalman-ca-1", "imm-mixed-3", "imm-sensors", "imm-turns-and-ca", "imm-ukf"])
@pytest.mark.parametrize("ahead", [1, 3])
def test_prediction_gradient(name, ahead):
    twin = SITUATIONS[name]
    assert_gradient(twin.native(), tracks_of(twin), "prediction", ahead=ahead)


@pytest.mark.parametrize("name", ["kalman-ca-1", "imm-mixed", "imm-turns-and-ca", "imm-robust"])
def test_tracking_gradient(name):
    twin = SITUATIONS[name]
    assert_gradient(twin.native(), tracks_of(twin), "tracking")


@pytest.mark.parametrize("name", SITUATIONS)
def test_likelihood_value(name):
    twin = SITUATIONS[name]
    filter, tracks = twin.native(), tracks_of(twin)
    none = np.zeros((0, filter.numbers.size))
    value, slope = gradient(filter, none, tracks)
    est = filter.filter(**tracks.keywords())
    assert slope.shape == (0, 3, 1)
    assert_allclose(value[:, 0], est.log_likelihood, rtol=1e-10)


def test_tracking_value():
    twin = SITUATIONS["imm-mixed-3"]
    filter, tracks = twin.native(), tracks_of(twin)
    tangents = Parameters(filter).tangents(Parameters(filter).start)
    weight = np.random.default_rng(1).uniform(0, 2, tracks.truth.shape)
    value, _ = gradient(filter, tangents, tracks, "tracking", weight=weight)
    est = filter.filter(**tracks.keywords())
    square = np.nan_to_num(weight * (est.x - tracks.truth) ** 2)
    assert_allclose(value, np.add.reduceat(square, tracks.offsets[:-1]), rtol=1e-9)


@pytest.mark.parametrize("ahead", [1, 2, 4])
def test_prediction_value(ahead):
    """The prediction for a row is the estimate there when its measurement and those just before are missing."""
    twin = SITUATIONS["imm-mixed"]
    filter, tracks = twin.native(), tracks_of(twin, tracks=1, N=40)
    tangents = Parameters(filter).tangents(Parameters(filter).start)
    value, _ = gradient(filter, tangents, tracks, "prediction", ahead=ahead)
    expected = np.zeros(2)
    for n in range(ahead + 1, tracks.rows):
        z = tracks.z[: n + 1].copy()
        z[n + 1 - ahead :] = np.nan
        est = filter.filter(tracks.time[: n + 1], z)
        expected += np.nan_to_num((tracks.z[n] - [est["px"][-1], est["py"][-1]]) ** 2)
    assert_allclose(value[0], expected, rtol=1e-9)


def test_neighbours_and_threads_change_nothing():
    twin = SITUATIONS["imm-sojourn"]
    filter, tracks = twin.native(), tracks_of(twin, tracks=5, N=60)
    tangents = Parameters(filter).tangents(Parameters(filter).start)
    value, slope = gradient(filter, tangents, tracks, threads=3)
    for b in range(len(tracks)):
        alone = gradient(filter, tangents, tracks.some(np.array([b])), threads=1)
        assert_array_equal(alone[0][0], value[b])
        assert_array_equal(alone[1][:, 0], slope[:, b])


def test_weights_choose_rows():
    twin = SITUATIONS["kalman-robust"]
    filter, tracks = twin.native(), tracks_of(twin)
    tangents = Parameters(filter).tangents(Parameters(filter).start)
    est = filter.filter(**tracks.keywords())
    weight = (np.arange(tracks.rows) % 3 == 0).astype(float)[:, None]
    value, _ = gradient(filter, tangents, tracks, weight=weight)
    each = np.add.reduceat(weight[:, 0] * est.log_likelihood_scan, tracks.offsets[:-1])
    assert_allclose(value[:, 0], each, rtol=1e-10)


def test_noise_of_each_row_and_a_given_start():
    twin = SITUATIONS["imm-mixed"]
    tracks = tracks_of(twin)
    noise = np.random.default_rng(2).uniform(100.0, 900.0, tracks.z.shape)
    n = len(twin.native().components)
    start = jink.Prior(np.zeros(n), 1e6 * np.eye(n))
    filter = jink.IMM(
        [m.native() for m in twin.motions],
        P2.native(),
        twin.transition,
        initial=start,
        outliers=jink.Outliers(),
    )
    given = Tracks(tracks.time, tracks.z, tracks.offsets, covariance=noise)
    fitted = Parameters(filter)
    value, slope = gradient(filter, fitted.tangents(fitted.start), given)
    assert_allclose(value[:, 0], filter.filter(**given.keywords()).log_likelihood, rtol=1e-10)
    assert np.isfinite(slope).all()


def test_refusals():
    twin = SITUATIONS["kalman-cv-1"]
    filter, tracks = twin.native(), tracks_of(twin)
    tangents = Parameters(filter).tangents(Parameters(filter).start)
    with pytest.raises(ValueError, match="tangents: expected"):
        gradient(filter, tangents[:, :-1], tracks)
    with pytest.raises(ValueError, match="figure: expected"):
        gradient(filter, tangents, tracks, "error")
    with pytest.raises(ValueError, match="ahead"):
        gradient(filter, tangents, tracks, "prediction", ahead=0)
    with pytest.raises(ValueError, match="lies before the row before"):
        gradient(filter, tangents, Tracks(tracks.time[::-1].copy(), tracks.z, tracks.offsets))
    with pytest.raises(ValueError, match="no truth"):
        gradient(filter, tangents, Tracks(tracks.time, tracks.z, tracks.offsets), "tracking")


class Drifting:
    """A model of one's own."""

    components = ("px", "vx")

    def f(self, x, dt):
        return np.stack([x[:, 0] + dt * x[:, 1], x[:, 1]], axis=1)

    def Q(self, dt):
        return np.asarray(dt)[:, None, None] * np.eye(2)


def test_own_models_say_that_they_have_no_gradient():
    filter = jink.Kalman(Drifting(), jink.Position(sd=1.0, axes=1))
    assert not differentiable(filter)
    with pytest.raises(TypeError, match="cannot be differentiated"):
        gradient(filter, np.zeros((1, 1)), Tracks(np.arange(3.0), np.zeros((3, 1)), np.array([0, 3])))


def test_parameters_round_trip():
    for name, twin in SITUATIONS.items():
        assert_round_trip(name, twin.native())


def assert_round_trip(name, filter):
    """Every number is named once; writing what was read gives the same filter, and a move is found again."""
    parameters = Parameters(filter, free=["*"])
    assert len(set(parameters.names)) == len(parameters.names) == len(parameters), name
    same = Parameters(parameters.filter(parameters.start), free=["*"])
    assert_allclose(same.start, parameters.start, rtol=1e-12, atol=1e-12)
    moved = parameters.start + np.random.default_rng(0).normal(0, 0.3, len(parameters))
    again = Parameters(parameters.filter(moved), free=["*"])
    assert_allclose(again.start, moved, rtol=1e-9, atol=1e-9)


def test_free_and_fixed_by_pattern():
    filter = SITUATIONS["imm-robust"].native()
    assert not any("sensor" in name for name in Parameters(filter).names)
    assert "sensor.sd" in Parameters(filter, free=["sensor.sd"]).names
    few = Parameters(filter, fixed=["transition.*", "outliers.*"]).names
    assert set(few) == {
        "constant_velocity.acceleration_sd",
        "constant_acceleration.jerk_psd",
        "constant_acceleration.acceleration_prior_sd",
        "coordinated_turn.acceleration_sd",
        "coordinated_turn.turn_rate_sd",
        "coordinated_turn.turn_rate_prior_sd",
    }
    with pytest.raises(ValueError, match=r"this filter has no parameter 'jerk'; its parameters are constant_velocity"):
        Parameters(filter, fixed=["jerk"])
    with pytest.raises(ValueError, match="no parameter is left to fit"):
        Parameters(filter, fixed=["*"])
