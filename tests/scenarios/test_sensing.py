"""Sensors to combine with any scenario: what they measure, how noisy, how often, and what goes wrong."""

import numpy as np
import pytest

import jink
from jink.scenarios import RADARS, SCENARIOS, Observation, Schedule

SENSORS = {
    "position": jink.Position(sd=[3.0, 30.0, 10.0], axes=3),
    "correlated": jink.Position(covariance=[[25.0, 12.0], [12.0, 16.0]]),
    "velocity": jink.PositionVelocity(sd=20.0, velocity_sd=2.0),
    "bearing": jink.Bearing(0.01, site=(500.0, -400.0)),
    "bearing east": jink.Bearing(0.01, reference="east"),
    "plane": jink.Polar(range_sd=30.0, azimuth_sd=0.002, range_rate_sd=1.5, site=(1e3, 2e3)),
    "elevation": jink.Polar(
        range_sd=30.0, azimuth_sd=0.002, elevation_sd=0.003, range_rate_sd=1.5, site=(1e3, 2e3, 50.0)
    ),
    "height": jink.Polar(range_sd=30.0, azimuth_sd=0.002, height_sd=8.0, site=(1e3, 2e3, 50.0)),
}


def expected(sensor, p: np.ndarray, v: np.ndarray) -> list[float]:
    """h of one position and velocity, from the definitions."""
    if isinstance(sensor, jink.Position):
        return list(p[: sensor.axes])
    if isinstance(sensor, jink.PositionVelocity):
        return [*p[:2], *v[:2]]
    d = p[: sensor.axes] - np.array(sensor.site)[: sensor.axes]
    azimuth = np.arctan2(d[0], d[1]) if sensor.reference == "north" else np.arctan2(d[1], d[0])
    if isinstance(sensor, jink.Bearing):
        return [azimuth]
    z = [np.linalg.norm(d), azimuth]
    z += [np.arcsin(d[2] / np.linalg.norm(d))] if sensor.elevation_sd else []
    z += [p[2]] if sensor.height_sd else []
    return z + ([d @ v[: sensor.axes] / np.linalg.norm(d)] if sensor.range_rate_sd else [])


@pytest.mark.parametrize("name", SENSORS)
def test_noise_around_the_truth(name):
    """Over many runs, z − h(truth) has mean 0 and the covariance that the sensor states."""
    sensor = SENSORS[name]
    made = SCENARIOS["benchmark-6"].seen_by(sensor).simulate(400, seed=2)
    p, v = made.truth.position[0], made.truth.velocity[0]
    h = np.array([expected(sensor, *each) for each in zip(p, v, strict=True)])
    error = made.z - h
    for column, component in enumerate(sensor.components):
        if component == "azimuth":
            assert np.abs(made.z[..., column]).max() <= np.pi
            error[..., column] = np.angle(np.exp(1j * error[..., column]))
    error = error.reshape(-1, error.shape[-1])
    R = np.asarray(getattr(sensor, "covariance", None) or np.diag(sds(sensor) ** 2))
    scale = np.sqrt(np.diag(R))
    np.testing.assert_allclose(error.mean(axis=0) / scale, 0.0, atol=5 / np.sqrt(len(error)))
    np.testing.assert_allclose(np.cov(error.T) / np.outer(scale, scale), R / np.outer(scale, scale), atol=0.02)


def sds(sensor) -> np.ndarray:
    if isinstance(sensor, jink.Position):
        return np.array(sensor.sd)
    if isinstance(sensor, jink.PositionVelocity):
        return np.array([sensor.sd] * 2 + [sensor.velocity_sd] * 2)
    if isinstance(sensor, jink.Bearing):
        return np.array([sensor.sd])
    return np.array([getattr(sensor, f"{c}_sd") for c in sensor.components])


@pytest.mark.parametrize("name", RADARS)
@pytest.mark.parametrize("scenario", ["random-turns", "benchmark-3", "vessel", "choi-2001-4"])
def test_radars_see_every_scenario(name, scenario):
    observation, interval, jitter = RADARS[name]
    chosen = SCENARIOS[scenario].seen_by(name)
    made = chosen.simulate(2, seed=1)
    assert np.isfinite(made.z).all()
    assert made.z.shape[-1] == len(observation.components)
    assert chosen.schedule.end <= SCENARIOS[scenario].schedule.end + 1e-9
    np.testing.assert_allclose(np.diff(made.time, axis=1), interval, atol=2 * jitter + 1e-9)


def test_the_truth_does_not_depend_on_the_sensor():
    own = SCENARIOS["random-accelerations"]
    radar = own.seen_by("radar-4s", detection=0.5, jitter=0.0)
    here, there = own.simulate(3, 1), radar.simulate(3, 1)
    np.testing.assert_array_equal(here.time[:, ::4], there.time)
    np.testing.assert_array_equal(here.truth.position[:, ::4], there.truth.position)


def test_misses_outliers_and_bias_leave_the_other_numbers_as_they_were():
    own = SCENARIOS["lee-2003"]
    plain = own.simulate(200, 1).z
    missed = own.seen_by(own.observation, detection=0.8).simulate(200, 1).z
    seen = np.isfinite(missed)
    assert (seen.all(axis=2) == seen.any(axis=2)).all()
    assert seen.mean() == pytest.approx(0.8, abs=0.01)
    np.testing.assert_array_equal(missed[seen], plain[seen])
    biased = own.seen_by(own.observation, bias=(100.0, -50.0)).simulate(200, 1).z
    np.testing.assert_allclose(biased - plain, np.broadcast_to([100.0, -50.0], plain.shape))
    gross = own.seen_by(own.observation, outlier_share=0.1).simulate(200, 1)
    changed = (gross.z != plain).any(axis=2)
    assert changed.mean() == pytest.approx(0.1, abs=0.01)
    error = gross.z[changed] - gross.truth.position[changed]
    assert error.std() == pytest.approx(20 * 500.0, rel=0.05)


def test_jitter_moves_scans_but_not_past_each_other():
    time = SCENARIOS["lee-2003"].seen_by(500.0, jitter=0.3).simulate(50, 1).time
    off = time - np.arange(1.0, 181.0)
    assert off.min() < -0.29 and off.max() > 0.29
    assert (np.diff(time, axis=1) > 0).all()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda: Observation(sensor=jink.Position(sd=1.0), detection=0.0), "detection: expected"),
        (lambda: Observation(sensor=jink.Position(sd=1.0), outlier_share=1.0), "outlier_share: expected"),
        (lambda: Observation(sensor=jink.Position(sd=1.0), outlier_scale=-1.0), "outlier_scale: expected"),
        (
            lambda: Observation(sensor=jink.Position(sd=1.0), bias=(1.0,)),
            "bias: expected one number for each of x, y",
        ),
        (lambda: Schedule(interval=0.0), "interval: expected"),
        (lambda: Schedule(count=0), "count: expected"),
        (lambda: Schedule(jitter=0.5), "jitter: expected"),
        (lambda: SCENARIOS["drone"].seen_by("radar-5s"), "did you mean radar-4s"),
        (lambda: SCENARIOS["drone"].seen_by(-5.0), "sd: expected"),
    ],
)
def test_wrong_settings_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        wrong()


def test_a_sensor_that_is_none_is_refused():
    with pytest.raises(TypeError, match="expected one of Position, PositionVelocity, Bearing, Polar"):
        Observation(sensor=object())  # type: ignore[arg-type]
