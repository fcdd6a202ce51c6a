"""The oracle's sensors against finite differences, and the converted measurement against quadrature over its
noise.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle import sensor as osn

POLARS = {
    "2d": osn.Polar(30.0, 0.01),
    "2d-rate": osn.Polar(30.0, 0.01, range_rate_sd=1.0, site=(100.0, -50.0)),
    "3d": osn.Polar(30.0, 0.01, elevation_sd=0.02, site=(100.0, -50.0, 20.0)),
    "3d-rate": osn.Polar(30.0, 0.01, elevation_sd=0.02, range_rate_sd=1.0, site=(100.0, -50.0, 20.0)),
    "height": osn.Polar(30.0, 0.01, height_sd=20.0),
    "height-earth": osn.Polar(30.0, 0.01, height_sd=20.0, site=(100.0, -50.0, 20.0), earth_radius=6.4e6),
    "height-rate": osn.Polar(30.0, 0.01, height_sd=20.0, range_rate_sd=1.0),
}


@pytest.mark.parametrize("name", POLARS)
def test_jacobian(name):
    sensor, rng = POLARS[name], np.random.default_rng(1)
    n = sensor.axes
    for _ in range(20):
        p, v = rng.normal(0, 5000, n), rng.normal(0, 100, n)
        by_position, by_velocity = sensor.H(p, v)
        for i in range(n):
            e = np.zeros(n)
            e[i] = 1e-3
            d = sensor.h(p + e, v) - sensor.h(p - e, v)
            assert_allclose(by_position[:, i], d / 2e-3, rtol=1e-4, atol=1e-7)
            d = sensor.h(p, v + e) - sensor.h(p, v - e)
            assert_allclose(by_velocity[:, i], d / 2e-3, rtol=1e-4, atol=1e-7)


def test_bearing_jacobian():
    sensor, e = osn.Bearing(0.01, site=(10.0, 20.0)), 1e-3
    p = np.array([-300.0, 400.0, 50.0])
    by_position, by_velocity = sensor.H(p, np.zeros(3))
    for i in range(2):
        d = np.eye(3)[i] * e
        assert_allclose(by_position[0, i], (sensor.h(p + d, p) - sensor.h(p - d, p))[0] / (2 * e), rtol=1e-6)
    assert by_position[0, 2] == 0 and not by_velocity.any()


def test_azimuth_is_clockwise_from_north():
    compass = {(0, 1): 0, (1, 0): 90, (0, -1): 180, (-1, 0): -90, (1, 1): 45}
    for (x, y), degrees in compass.items():
        z = POLARS["2d"].h(np.array([x, y], float), np.zeros(2))
        assert_allclose(np.rad2deg(osn.wrap(z[1] - np.deg2rad(degrees))), 0, atol=1e-12)
        assert_allclose(osn.Bearing(1.0).h(np.array([x, y], float), np.zeros(2)), z[1])


def test_wrap():
    assert_allclose(
        osn.wrap(np.array([0.1, np.pi + 0.1, -np.pi - 0.1, 7 * np.pi])),
        [0.1, -np.pi + 0.1, np.pi - 0.1, -np.pi],
    )


def grid(sds, nodes=40):
    """Gauss-Hermite nodes and weights for independent Gaussians."""
    u, w = np.polynomial.hermite_e.hermegauss(nodes)
    points = np.stack(np.meshgrid(*[u * s for s in sds], indexing="ij"), -1).reshape(-1, len(sds))
    weights = np.prod(np.stack(np.meshgrid(*[w] * len(sds), indexing="ij"), -1).reshape(-1, len(sds)), axis=1)
    return points, weights / weights.sum()


def cartesian(r, azimuth, elevation=None):
    if elevation is None:
        return np.stack([r * np.sin(azimuth), r * np.cos(azimuth)], -1)
    level = r * np.cos(elevation)
    return np.stack([level * np.sin(azimuth), level * np.cos(azimuth), r * np.sin(elevation)], -1)


@pytest.mark.parametrize("z", [[5000.0, 0.7], [80.0, -2.4], [5000.0, 3.0, 0.4], [3000.0, -0.5, -0.9]])
@pytest.mark.parametrize("angle_sd", [1e-3, 0.05, 0.4])
def test_conversion_is_unbiased_and_its_covariance_the_mean_square_given_z(z, angle_sd):
    sds = [20.0, angle_sd, 0.7 * angle_sd][: len(z)]
    R, elevation = np.diag(np.square(sds)), len(z) == 3
    noise, weight = grid(sds)
    truth = np.array(z)  # unbiased given the truth: average over the measurements it gives
    measured = cartesian(*(truth + noise).T) / np.exp(-(sds[1] ** 2) / 2)
    if elevation:
        measured /= np.exp(-(sds[2] ** 2) / 2)
        measured[:, 2] *= np.exp(-(sds[1] ** 2) / 2)
    assert_allclose(weight @ measured, cartesian(*truth), rtol=1e-9, atol=1e-9 * z[0])
    x, C = osn.unbiased_conversion(truth, R, elevation)  # the covariance: average over the truths given z
    for n, m in zip(noise[::37], measured[::37], strict=True):
        assert_allclose(osn.unbiased_conversion(truth + n, R, elevation)[0], m, rtol=1e-12)
    error = x - cartesian(*(truth - noise).T)
    assert_allclose((error * weight[:, None]).T @ error, C, rtol=1e-7, atol=1e-9 * np.trace(C))


def test_conversion_keeps_its_digits_far_away():
    """At 400 km with 1 mrad the covariance is sd^2 taken from r^2: along the line of sight sd_r^2 + 1.5 r^2
    sd_a^4.
    """
    r, sd_r, sd_a = 4e5, 10.0, 1e-3
    _, C = osn.unbiased_conversion(np.array([r, 0.0]), np.diag([sd_r**2, sd_a**2]), False)
    assert_allclose(C[1, 1], sd_r**2 * (1 + np.exp(-2 * sd_a**2)) / 2 + 1.5 * r**2 * sd_a**4, rtol=1e-6)
    assert_allclose(C[0, 0], r**2 * sd_a**2, rtol=1e-5)
    assert_allclose(C[0, 1], 0, atol=1e-9)


@pytest.mark.parametrize("truth", [[20e3, 5e3, 3e3], [8e3, 2e3, 6e3]])
def test_fix_by_height_against_samples(truth):
    """Slant range and height: the ground range's error is correlated with the height's, -(h/g) sd_h^2."""
    rng, p = np.random.default_rng(0), np.array(truth)
    sensor = POLARS["height"]
    z = sensor.h(p, np.zeros(3)) + rng.normal(size=(20_000, 3)) * np.sqrt(np.diag(sensor.R))
    errors = np.array([sensor.fix(row, sensor.R)[0] for row in z]) - p
    want = sensor.fix(sensor.h(p, np.zeros(3)), sensor.R)[1]
    sd = np.sqrt(np.diag(want))
    assert_allclose(np.cov(errors.T) / np.outer(sd, sd), want / np.outer(sd, sd), atol=0.03)
    assert_allclose(errors.mean(axis=0) / sd, 0, atol=0.03)
