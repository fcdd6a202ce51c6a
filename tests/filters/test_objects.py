"""Filters, estimates and live targets as objects: copies, equality, targets, other times, tables."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import polars as pl
import pytest
from subjects import NOT_SMOOTHED, SUBJECTS, build, scene

import jink

CV = jink.ConstantVelocity(acceleration_psd=4.0)
IMM = jink.IMM([CV, jink.ConstantAcceleration(jerk_psd=10.0)], jink.Position(sd=10.0), jink.Sojourn([60.0, 10.0]))
KALMAN = jink.Kalman(CV, jink.Position(sd=10.0))


class Straight:
    """A motion model of one's own: constant velocity."""

    components = ("px", "vx", "py", "vy")

    def f(self, x, dt):
        return x + np.stack([x[:, 1] * dt, 0 * dt, x[:, 3] * dt, 0 * dt], axis=1)

    def Q(self, dt):
        return np.ones((len(dt), 1, 1)) * np.eye(4)


def two_tracks(seed=0):
    rng = np.random.default_rng(seed)
    time = np.r_[np.arange(30.0), np.arange(20.0) * 2.0]
    z = np.cumsum(rng.normal(size=(50, 2)) * 30.0, axis=0)
    return time, z, np.array([0, 30, 50])


def estimate(filter=IMM, smooth=False, **more):
    time, z, offsets = two_tracks()
    return (filter.smooth if smooth else filter.filter)(time, z, offsets=offsets, **more)


def last_position(filter):
    time, z, offsets = two_tracks()
    return filter.filter(time, z, offsets=offsets).x[-1]


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.parametrize("copied", [lambda f: pickle.loads(pickle.dumps(f)), copy.deepcopy], ids=["pickle", "copy"])
def test_a_copy_of_every_filter_is_equal_and_gives_the_same(name, copied):
    filter, (t, z) = build(name), scene()
    other = copied(filter)
    assert other == filter and hash(other) == hash(filter) and other is not filter
    assert other.filter(t, z) == filter.filter(t, z)


@pytest.mark.parametrize("name", SUBJECTS)
def test_a_copy_of_a_live_target_goes_on_alike(name):
    filter, (t, z) = build(name), scene()
    live = filter.start()
    for k in range(20):
        live.update(t[k], z[k])
    other = pickle.loads(pickle.dumps(live))
    for k in range(20, 30):
        np.testing.assert_array_equal(other.update(t[k], z[k]).x, live.update(t[k], z[k]).x)


def test_copies_of_many_live_targets_of_own_models_and_of_axes():
    own = jink.Kalman(Straight(), jink.Position(sd=10.0))
    apart = jink.AxisByAxis(jink.Kalman(CV, jink.Position(sd=10.0, axes=1)), 2)
    for filter in (IMM, own):
        many = filter.start(3)
        many.update(0.0, np.zeros((3, 2)))
        other = copy.deepcopy(many)
        assert other.update(1.0, np.ones((3, 2))) == many.update(1.0, np.ones((3, 2)))
    live = own.start()
    live.update(0.0, [1.0, 2.0])
    np.testing.assert_array_equal(
        pickle.loads(pickle.dumps(live)).update(1.0, [2.0, 3.0]).x, live.update(1.0, [2.0, 3.0]).x
    )
    assert copy.deepcopy(own) != own and own == own
    assert pickle.loads(pickle.dumps(apart)).filter(*two_tracks()[:2], offsets=two_tracks()[2]) == estimate(apart)


def test_filters_are_equal_by_value():
    same = jink.IMM([CV, jink.ConstantAcceleration(jerk_psd=10.0)], jink.Position(sd=10.0), jink.Sojourn([60.0, 10.0]))
    other = jink.IMM([CV, jink.ConstantAcceleration(jerk_psd=9.0)], jink.Position(sd=10.0), jink.Sojourn([60.0, 10.0]))
    assert same == IMM != other and {IMM: 1}[same] == 1 and IMM != KALMAN and IMM != "IMM"


def test_a_pool_of_processes_runs_filters():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = list(pool.map(last_position, [IMM, KALMAN]))
    np.testing.assert_array_equal(found[0], last_position(IMM))
    np.testing.assert_array_equal(found[1], last_position(KALMAN))


def test_estimates_are_equal_by_value_and_survive_a_pickle():
    est = estimate()
    again = pickle.loads(pickle.dumps(est))
    assert again == est == copy.deepcopy(est) and est != estimate(KALMAN) and est != 1
    again.x[3, 0] += 1.0
    assert again != est
    with pytest.raises(TypeError, match="unhashable"):
        hash(est)


def test_targets_of_an_estimate():
    time, z, _ = two_tracks()
    est = estimate()
    assert len(est) == 2 and [len(one.x) for one in est] == [30, 20]
    alone = IMM.filter(time[30:], z[30:])
    assert est[1] == alone == est[-1] and est[0:2] == est and len(est[2:]) == 0
    np.testing.assert_array_equal(est[1].time, time[30:])
    np.testing.assert_array_equal(est[1]["vx"], est["vx"][30:])
    with pytest.raises(IndexError, match="target 2: there are 2"):
        est[2]
    with pytest.raises(ValueError, match="step of 1"):
        est[::2]
    with pytest.raises(KeyError, match="expected one of px"):
        est["speed"]
    assert "2 targets, 50 rows, 0 to 38 s" in repr(est)


def test_a_live_estimate_has_components_by_name():
    time, z, _ = two_tracks()
    live, many, own = IMM.start(), IMM.start(1), jink.Kalman(Straight(), jink.Position(sd=10.0)).start()
    for k in range(5):
        one, row, mine = live.update(time[k], z[k]), many.update(time[k], z[k : k + 1]), own.update(time[k], z[k])
    assert one.components == row.components == IMM.components and mine.components == ("px", "vx", "py", "vy")
    for name in one.components:
        np.testing.assert_allclose([one[name], one.sd(name)], [row[name][0], row.sd(name)[0]], rtol=1e-12)
    assert mine["px"] == mine.x[0] and mine.sd("vy") == np.sqrt(mine.P[3, 3])
    assert len(row) == 1 and row[0]["vx"][0] == row["vx"][0]
    for what in (one, mine):
        with pytest.raises(KeyError, match="expected one of px"):
            what["speed"]
        with pytest.raises(KeyError, match="expected one of px"):
            what.sd("speed")
    assert "updated at 4" in repr(one)


def test_other_times_are_the_filters_own_predictions():
    """At a row's time its estimate; between rows and beyond the last F x and F P F' + Q; before the first NaN."""
    est = estimate(KALMAN)
    at = est.at([100.0, -1.0, 5.0, 5.5])
    assert len(at) == 2 and at.time.tolist() == [100.0, -1.0, 5.0, 5.5] * 2
    assert np.isnan(at.x[1]).all() and at.status[1] == jink.Status.none
    np.testing.assert_allclose(at.x[2], est.x[5], rtol=1e-12)
    for row, k, dt in ((3, 5, 0.5), (0, 29, 71.0), (7, 32, 1.5), (4, 49, 62.0)):
        F = np.kron(np.eye(2), [[1.0, dt], [0.0, 1.0]])
        Q = np.kron(np.eye(2), 4.0 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]))
        np.testing.assert_allclose(at.x[row], F @ est.x[k], rtol=1e-9)
        np.testing.assert_allclose(at.P[row], F @ est.P[k] @ F.T + Q, rtol=1e-9)
    np.testing.assert_array_equal(est[1].at([5.5]).x[0], at.x[7])


@pytest.mark.parametrize("name", SUBJECTS)
def test_at_its_rows_an_estimate_is_itself(name):
    filter, (t, z) = build(name), scene()
    est = filter.filter(t, z)
    at = est.at(np.r_[t, t[10] + 0.3 * (t[11] - t[10])])
    np.testing.assert_allclose(at.x[:-1], est.x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(at.P[:-1], est.P, rtol=1e-6, atol=1e-6)
    assert at.status[-1] == jink.Status.predicted


def test_smoothed_estimates_are_interpolated_from_both_sides():
    """The smoothed estimate at a time equals that of the same track with a row without a measurement there."""
    time, z, _ = two_tracks()
    est = estimate(KALMAN, smooth=True)
    wider = KALMAN.smooth(np.insert(time[:30], 6, 5.5), np.insert(z[:30], 6, np.nan, axis=0))
    at = est[0].at([5.5])
    np.testing.assert_allclose(at.x[0], wider.x[6], rtol=1e-12)
    assert at.sd("px")[0] < estimate(KALMAN)[0].at([5.5]).sd("px")[0]
    np.testing.assert_allclose(est[0].at([5.0]).x[0], est.x[5], rtol=1e-9)


def test_known_accelerations_go_on_between_rows():
    time = np.arange(6.0)
    z = np.c_[0.5 * time**2, 0 * time]
    est = KALMAN.filter(time, z, input=np.tile([1.0, 0.0], (6, 1)))
    half, late = est.at([3.5]), est.at([7.0])
    np.testing.assert_allclose(half["vx"], est["vx"][3] + 0.5, rtol=1e-9)
    np.testing.assert_allclose(late["vx"], est["vx"][5], rtol=1e-9)


def test_resampled_from_first_to_last_row():
    est = estimate()
    every = est.resample("500ms")
    assert [len(one.time) for one in every] == [59, 77]
    np.testing.assert_allclose(every[1].time, np.arange(77) * 0.5)
    np.testing.assert_allclose(every[0].x[::2][5], est.x[5], rtol=1e-12)
    assert est.resample(0.5) == every


@pytest.mark.parametrize("step", [0, -1, "1 fortnight", "s", float("nan"), None])
def test_a_wrong_step_is_refused(step):
    with pytest.raises(ValueError, match="step: expected seconds"):
        estimate().resample(step)


def test_times_that_cannot_be_answered_are_refused():
    with pytest.raises(ValueError, match="times: expected finite"):
        estimate().at([np.nan])
    with pytest.raises(ValueError, match="with a lag"):
        estimate(smooth=True, lag=2).at([1.0])
    with pytest.raises(ValueError, match="target 1 has no rows"):
        KALMAN.smooth([0.0], [[0.0, 0.0]], offsets=[0, 1, 1]).at([0.5])
    live = KALMAN.start(2).update(0.0, np.zeros((2, 2)))
    with pytest.raises(ValueError, match="does not know the rows"):
        live.at([1.0])


def test_axes_apart_answer_as_together():
    apart = estimate(jink.AxisByAxis(jink.Kalman(CV, jink.Position(sd=10.0, axes=1)), 2))
    together = estimate(KALMAN)
    assert len(apart) == 2
    for times in ([3.5], [50.0, 1.0]):
        np.testing.assert_allclose(apart.at(times).x, together.at(times).x, rtol=1e-9)
        np.testing.assert_allclose(apart[1].at(times).x, together[1].at(times).x, rtol=1e-9)


def test_a_table_of_an_estimate():
    est = estimate()
    table = est.to_frame()
    assert isinstance(table, pl.DataFrame) and table.height == 50
    assert table.columns[:4] == ["target", "time", "px", "px_sd"] and table.columns[-1] == "status"
    np.testing.assert_array_equal(table["vx_sd"].to_numpy(), est.sd("vx"))
    assert table["target"].to_list() == [0] * 30 + [1] * 20 and table["status"][0] == "initialised"
    assert estimate(outputs=("x",)).to_frame().columns == ["target", "time", *est.components]
    with pytest.raises(ValueError, match="backend: expected one of polars, pandas, pyarrow"):
        est.to_frame("spark")
    html = est._repr_html_()
    assert html.count("<polyline") == 2 and "<table>" in html and "nan" not in html.split("<table>")[0]


@pytest.mark.parametrize("make", [lambda s, m: jink.Kalman(s, m), lambda s, m: jink.IMM([s, s], m, 0.9)])
def test_swapped_arguments_are_told(make):
    with pytest.raises(TypeError, match="got the sensor Position; expected the motion model first, then the sensor"):
        make(jink.Position(sd=1.0), CV)


def test_rooms_are_reached_from_the_package():
    assert jink.compare.__name__ == "jink.compare" and jink.metrics.__name__ == "jink.metrics"
    assert set(NOT_SMOOTHED) <= set(SUBJECTS)


@pytest.mark.parametrize("kind", [float, int])
def test_what_a_mask_hides_is_missing(kind):
    z = np.random.default_rng(5).normal(0, 900, (40, 2)).astype(kind)
    hidden = np.zeros(z.shape, bool)
    hidden[[7, 8, 20]], hidden[30, 1] = True, True
    with_nan = np.where(hidden, np.nan, z.astype(float))
    masked = KALMAN.filter(np.arange(40.0), np.ma.masked_array(z, mask=hidden))
    np.testing.assert_array_equal(masked.x, KALMAN.filter(np.arange(40.0), with_nan).x)
    assert not np.array_equal(masked.x, KALMAN.filter(np.arange(40.0), z).x)
