"""The default filters: every kind on every sensor, and the fighters' efficiency on fresh runs."""

import numpy as np
import pytest

import jink
from benchmarks.efficiency import FAMILIES, against, measure
from jink.kinds import KINDS, default_filter

SENSORS = (
    jink.Position(sd=25.0),
    jink.Position(sd=25.0, axes=3),
    jink.PositionVelocity(sd=25.0, velocity_sd=2.0, axes=3),
    jink.Polar(range_sd=50.0, azimuth_sd=2e-3),
    jink.Polar(range_sd=50.0, azimuth_sd=2e-3, elevation_sd=2e-3, range_rate_sd=1.0),
    jink.Polar(range_sd=50.0, azimuth_sd=2e-3, height_sd=30.0, method="converted"),
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sensor", SENSORS, ids=lambda s: "-".join(s.components))
def test_follows_a_straight_line(kind, sensor):
    """No gating and an error within five sd of the sensor's, at the kind's usual speed."""
    imm = default_filter(kind, sensor)
    time = np.arange(60.0)
    velocity = KINDS[kind].speed * np.array([0.6, 0.8, 0.0])
    truth = np.array([5000.0, 8000.0, 1000.0]) + time[:, None] * velocity
    ranges = np.linalg.norm(truth[:, : int(sensor.axes or 2)], axis=1)
    columns = {
        "x": truth[:, 0], "y": truth[:, 1], "z": truth[:, 2],
        "vx": velocity[0] + 0 * time, "vy": velocity[1] + 0 * time, "vz": 0 * time,
        "range": ranges, "azimuth": np.arctan2(truth[:, 0], truth[:, 1]), "height": truth[:, 2],
        "elevation": np.arctan2(truth[:, 2], np.hypot(truth[:, 0], truth[:, 1])),
        "range_rate": (truth @ velocity) / ranges,
    }  # fmt: skip
    sds = np.sqrt(np.asarray(sensor.native()[9]))
    z = np.column_stack([columns[name] for name in sensor.components])
    z = z + sds * np.random.default_rng(3).normal(size=z.shape)
    est = imm.filter(time, z)
    assert set(est.status[2:]) == {1}
    assert np.hypot(est["px"] - truth[:, 0], est["py"] - truth[:, 1])[5:].max() < 5 * 50.0


@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.scenario)
def test_efficiency_on_fresh_runs(family):
    """Within the stated figures and three standard errors, 300 runs of a seed nothing was fitted on."""
    errors = measure(family, 300, 4242, reference=False)
    for k in range(2):
        value, se = against(family.published[k], errors.filtered[:, k])
        assert value < family.reach[k] + 3 * se


def test_saved_and_loaded(tmp_path):
    for kind in KINDS:
        imm = default_filter(kind, jink.Position(sd=10.0, axes=3))
        imm.save(tmp_path / "f.json")
        time, z = np.arange(30.0), np.random.default_rng(1).normal(size=(30, 3)).cumsum(axis=0) * 10
        np.testing.assert_array_equal(jink.load(tmp_path / "f.json").filter(time, z).x, imm.filter(time, z).x)


def test_an_unknown_kind_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="did you mean vessel"):
        default_filter("vesel", jink.Position(sd=1.0))
    with pytest.raises(ValueError, match="expected a sensor of 2 or 3 axes"):
        default_filter("drone", jink.Position(sd=1.0, axes=1))
