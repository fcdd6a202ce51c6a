"""Every gradient that is written by hand against finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from jink.learn import anfis, end_to_end, mlp, modes, modes_end_to_end, noise
from jink.learn.data import from_scenario
from jink.models.noise_network import NoiseNetwork


def differences(loss, arrays, step=1e-5):
    """Central differences of a loss in every entry of some arrays."""
    out = [np.zeros_like(a) for a in arrays]
    for array, gradient in zip(arrays, out, strict=True):
        for where in np.ndindex(array.shape):
            kept = array[where]
            array[where] = kept + step
            above = loss()
            array[where] = kept - step
            gradient[where] = (above - loss()) / (2 * step)
            array[where] = kept
    return out


def assert_gradients(found, expected, rtol):
    for a, b in zip(found, expected, strict=True):
        assert_allclose(a, b, rtol=rtol, atol=rtol * max(np.abs(e).max() for e in expected))


@pytest.mark.parametrize("kind", ["triangular", "gaussian", "bell"])
def test_anfis(kind):
    rng = np.random.default_rng(1)
    u, y = rng.normal(size=(150, 3)), rng.normal(size=(150, 2))
    m = [anfis._spread(kind, 2 + i % 2, u[:, i]) for i in range(3)]
    m = [each + rng.normal(0, 0.05, each.shape) for each in m]
    c = rng.normal(size=(12, 2, 4))
    found_m, found_c = anfis._System(kind, m, u).gradient(y, c)
    loss = lambda: float(((anfis._System(kind, m, u).answer(c) - y) ** 2).sum(axis=1).mean())  # noqa: E731
    assert_gradients([*found_m, found_c], differences(loss, [*m, c], 1e-6), 1e-6)


@pytest.mark.parametrize("scores", [False, True])
def test_network(scores):
    rng = np.random.default_rng(2)
    u, y = rng.normal(size=(40, 3)), rng.random((40, 2))
    y = y / y.sum(axis=1, keepdims=True)
    values = mlp.initial([3, 5, 4, 2], rng)
    answer, layers = mlp.forward(values, u)
    found, in_u = mlp.backward(values, layers, mlp._slope(answer, y, scores) / len(u))
    loss = lambda: mlp._loss(mlp.forward(values, u)[0], y, scores) * (1 if scores else 2)  # noqa: E731
    expected = differences(loss, [*values, u])
    assert_gradients([*found, in_u], expected, 1e-7)


@pytest.mark.parametrize("share", [0.0, 0.4])
@pytest.mark.parametrize(
    ("inputs", "output", "centre", "scale"),
    [
        ("log-nis", "log-variance", (1.0, 0.1, 0.0), (2.0, 1.0, 2.0)),
        ("likelihood", "variance", (50.0, 0.1, 0.1), (50.0, 0.1, 0.1)),
    ],
)
def test_the_tracking_error_through_the_filter(inputs, output, centre, scale, share):
    runs = from_scenario("choi-2001-4", 3, 1)
    runs.time[:] = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, runs.time.shape), axis=1)
    values = mlp.initial([3, 6, 1], np.random.default_rng(3))
    model = NoiseNetwork(
        network=mlp.as_network(values),
        inputs=inputs,
        output=output,
        centre=centre,
        scale=scale,
        least=1.0,
        most=196.0,
        start=1.0,
        output_centre=60.0,
        output_scale=20.0,
    )
    rollout = noise.Rollout(model, runs)
    loss = lambda: end_to_end._loss(rollout.forward(values), runs, share)[0]  # noqa: E731
    expected = differences(loss, values)
    _, slopes = end_to_end._loss(rollout.forward(values), runs, share)
    assert len(slopes) == (2 if share else 1)
    assert_gradients(rollout.backward(values, *slopes), expected, 1e-6)


def test_the_tracking_error_through_the_modes():
    autograd = pytest.importorskip("autograd")
    runs = from_scenario("choi-2001-3", 2, 1)
    model = modes.untrained(3, hidden=4)
    values = mlp.parameters_of(model.network)
    variances = (1.0, 20.0, 196.0)
    found = autograd.grad(lambda v: modes_end_to_end.tracking_loss(v, model, variances, runs))(values)
    loss = lambda: float(modes_end_to_end.tracking_loss(values, model, variances, runs))  # noqa: E731
    assert_gradients(found, differences(loss, values), 1e-5)
