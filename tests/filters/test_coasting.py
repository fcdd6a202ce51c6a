"""While nothing is measured a target ceases to manoeuvre and to climb, and does not go backwards."""

from dataclasses import replace

import numpy as np
import pytest

import jink
from jink.filters.loading import load

SD = [15.0, 15.0, 6.0]


def landing(rows=30, blind=30, brake=-1.5, step=5.0):
    """Braking and sinking in z = (x, y, height), then nothing but times."""
    time = step * np.arange(rows + blind)
    going = np.minimum(time, step * (rows - 1))
    x = 230.0 * going + 0.5 * brake * going**2
    z = np.stack([0.6 * x, 0.8 * x, 900.0 - 4.0 * going], axis=1)
    z += np.random.default_rng(3).normal(size=z.shape) * SD
    z[rows:] = np.nan
    return time, z


def default(kind="aircraft"):
    return jink.default_filter(kind, jink.Position(sd=SD, axes=3), coast=0)


def without(filter):
    named = {name: getattr(filter, name) for name in filter.arguments if name not in ("coasting", "transition")}
    return jink.IMM(filter.motions, filter.sensors[0], filter.transition, **named)


def velocity(estimate):
    return np.stack([estimate.x[:, estimate.components.index(v)] for v in ("vx", "vy", "vz")], axis=1)


@pytest.mark.parametrize("smooth", [False, True])
def test_a_landed_aircraft_neither_reverses_nor_sinks_on(smooth):
    time, z = landing(brake=-1.58)
    run = default().smooth if smooth else default().filter
    estimate = run(time, z)
    v = velocity(estimate)
    along = v[:, :2] @ [0.6, 0.8]
    assert along[29:].min() > -0.5
    assert abs(v[-1, 2]) < 0.2 and v[29, 2] < -2.0
    height = estimate.x[:, estimate.components.index("pz")]
    free = without(default())
    straight_on = (free.smooth if smooth else free.filter)(time, z)
    other, lower = velocity(straight_on), straight_on.x[:, straight_on.components.index("pz")]
    assert height[29] - height[-1] < 0.7 * (lower[29] - lower[-1])
    assert other[-1, 2] < -2.0 and (other[29:, :2] @ [0.6, 0.8]).min() < -1.0


def test_a_turn_straightens():
    """w' = -w / m after `after` seconds: the rate at the end, and the angle turned, in closed form."""
    turns = [jink.CoordinatedTurn(acceleration_psd=1e-6, turn_rate_psd=1e-12)] * 2
    start = jink.Prior(x=[0.0, 50.0, 0.0, 0.0, 0.1], P=np.diag([1.0, 0.01, 1.0, 0.01, 1e-8]))
    coasting = jink.Coasting(after=4.0, manoeuvre=3.0, climb=5.0)
    filter = jink.IMM(turns, jink.Position(sd=1.0), 0.9, coasting=coasting, initial=start)
    x = filter.filter(np.array([0.0, 10.0]), np.full((2, 2), np.nan)).x[-1]
    angle = 0.1 * (4.0 + 3.0 * (1.0 - np.exp(-2.0)))
    assert x[4] == pytest.approx(0.1 * np.exp(-2.0))
    assert np.arctan2(x[3], x[1]) == pytest.approx(angle) and np.hypot(x[1], x[3]) == pytest.approx(50.0)


def test_a_height_that_is_not_measured_levels_while_the_plane_goes_on():
    time, z = landing(brake=0.0)
    z[30:, :2] = np.stack([0.6 * 230.0 * time[30:], 0.8 * 230.0 * time[30:]], axis=1)
    v = velocity(default().filter(time, z))
    assert abs(v[-1, 2]) < 0.2 and abs(v[-1, :2] @ [0.6, 0.8] - 230.0) < 3.0
    assert velocity(without(default()).filter(time, z))[-1, 2] < -2.0


def test_measured_tracks_are_the_same_to_the_bit():
    time, z = landing(rows=60, blind=0, brake=-0.5)
    ours, free = default().filter(time, z), without(default()).filter(time, z)
    assert np.array_equal(ours.x, free.x) and np.array_equal(ours.P, free.P)


def test_live_and_predict_coast_alike():
    time, z = landing()
    batch, live = default().filter(time, z), default().start()
    for t, row in zip(time, z, strict=True):
        now = live.update(t, row)
    np.testing.assert_allclose(now.x, batch.x[-1], rtol=1e-12, atol=1e-9)
    live = default().start()
    for t, row in zip(time[:30], z[:30], strict=True):
        live.update(t, row)
    assert live.predict(time[29] + 150.0).x[list(batch.components).index("vz")] > -0.2


def test_it_is_kept_in_files_and_checked(tmp_path):
    filter = default()
    filter.save(tmp_path / "f.json")
    assert load(tmp_path / "f.json").coasting == filter.coasting
    with pytest.raises(ValueError, match="climb"):
        replace(filter.coasting, climb=0.0)
    with pytest.raises(TypeError, match="coasting: expected"):
        jink.IMM(filter.motions, filter.sensors[0], filter.transition, coasting=3.0)


def test_by_the_equations_of_one_mode():
    """a' = -a / m after `after` seconds, closed form; split in two or not."""
    coasting = jink.Coasting(after=4.0, manoeuvre=3.0, climb=5.0)
    motions = [jink.ConstantAcceleration(jerk_psd=1e-6)] * 2
    filter = jink.IMM(motions, jink.Position(sd=1.0, axes=3), 0.9, coasting=coasting, initial=prior())
    start = np.array([0.0, 50.0, -2.0, 0.0, 0.0, 0.5, 0.0, 3.0, 0.0])
    for times in ([0.0, 10.0], [0.0, 6.0, 10.0]):
        z = np.full((len(times), 3), np.nan)
        x = filter.filter(np.array(times), z).x[-1]
        kept, pull = np.exp(-6.0 / 3.0), 3.0 * (1.0 - np.exp(-6.0 / 3.0))
        for axis in (0, 3):
            p, v, a = start[axis : axis + 3]
            early = p + 4.0 * v + 8.0 * a
            assert x[axis + 2] == pytest.approx(a * kept, abs=1e-9)
            assert x[axis + 1] == pytest.approx(v + a * (4.0 + pull), abs=1e-9)
            assert x[axis] == pytest.approx(early + 6.0 * (v + 4.0 * a) + 3.0 * a * (6.0 - pull), abs=1e-8)
        assert x[7] == pytest.approx(3.0 * np.exp(-6.0 / 5.0))
        assert x[6] == pytest.approx(3.0 * (4.0 + 5.0 * (1.0 - np.exp(-6.0 / 5.0))))


def prior():
    x = np.array([0.0, 50.0, -2.0, 0.0, 0.0, 0.5, 0.0, 3.0, 0.0])
    return jink.Prior(x=x, P=np.diag([1.0, 1.0, 0.01] * 3))
