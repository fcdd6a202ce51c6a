"""Finished tracks are smoothed with all plots that they have taken, each as surely as it was."""

import numpy as np
import polars as pl
import pytest

import jink
from jink.association.batch import Scans, track_scans
from jink.association.smoothing import Taken, _existence, _smoother, smoothed, together
from jink.scenarios.skies import sky_called

STRAIGHT = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=50.0))


def scans_of(run):
    begin = np.r_[0, np.cumsum([len(s.z) for s in run.scans])]
    return Scans(np.array([s.time for s in run.scans]), begin, np.vstack([s.z for s in run.scans]))


def tracker_of(filter, **more):
    radar = jink.Radar(detection=0.9, clutter_per_scan=more.pop("clutter", 1e-3), area=(0, 7e4, 0, 3e4))
    return jink.Tracker(filter, radar, targets=1, new_per_hour=10, **more)


def taken(weights, spread):
    """One track that has taken plots 0, 1, … with these weights."""
    n = len(weights)
    return Taken(np.array([0, n]), np.arange(n), np.array(weights), np.array([spread], float))


def test_alone_in_a_clear_sky_it_is_the_smoother():
    rng = np.random.default_rng(1)
    time = 4.0 * np.arange(30)
    z = np.column_stack([3e4 + 150 * time, np.full(30, 1.5e4)]) + rng.normal(0, 50, (30, 2))
    tracker = tracker_of(STRAIGHT)
    scans = Scans(time, np.arange(31), z)
    found = track_scans(tracker, scans, keep=True)
    got = smoothed(tracker, scans, found)
    want = _smoother(tracker).smooth(time, z)
    assert len(got.id) == 30 and (got.plot == np.arange(30)).all()
    # "no plot" keeps β₀ ≈ (1 − Pd) λ / (Pd l) ≈ 1e-6 of the weight, and pulls by that share of the residual
    assert got.estimate.x[:, [0, 2]] == pytest.approx(want.x[:, [0, 2]], abs=1e-2)
    np.testing.assert_allclose(got.estimate.P, want.P, rtol=1e-3, atol=1e-6)
    assert got.estimate.P[5, 0, 0] < 0.7 * found.estimate.P[5, 0, 0]


def test_one_plot_that_may_be_none_gains_as_in_data_association():
    P, R, w = np.diag([900.0, 400.0]), np.diag([2500.0, 2500.0]), 0.6
    z, noise = together(taken([w], P), np.array([[30.0, -40.0]]), R[None], jink.Position(sd=50.0))
    assert z == pytest.approx(np.array([[30.0, -40.0]]))
    gain = P @ np.linalg.inv(P + noise[0])
    assert gain == pytest.approx(w * P @ np.linalg.inv(P + R))


def test_plots_together_are_their_mean_and_as_far_apart_as_they_are():
    plots, R = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 400.0]]), np.diag([2500.0, 1600.0])
    w = np.array([0.5, 0.3, 0.2])
    z, noise = together(taken(w, np.eye(2)), plots, np.tile(R, (3, 1, 1)), jink.Position(sd=50.0))
    mean = w @ plots
    assert z[0] == pytest.approx(mean)
    assert noise[0] == pytest.approx(R + np.einsum("k,ki,kj->ij", w, plots - mean, plots - mean))


def test_angles_do_not_wrap_and_a_predicted_place_is_turned_into_range_and_azimuth():
    radar = jink.Polar(range_sd=50.0, azimuth_sd=1e-3)
    plots = np.array([[10_000.0, np.pi - 0.01], [10_000.0, -np.pi + 0.01]])
    noise = np.tile(radar.noise, (2, 1, 1))
    # 100 m along the line of sight, which runs along y at azimuth π, counted from north, and 300 m across
    z, R = together(taken([0.25, 0.25], np.diag([9e4, 1e4])), plots, noise, radar)
    assert abs(np.angle(np.exp(1j * (z[0, 1] - np.pi)))) < 1e-9
    spread, along, across = 0.01**2, 1e4, 9e4
    assert R[0, 0, 0] == pytest.approx((50.0**2 + 0.5 * along) / 0.5, rel=1e-3)
    assert R[0, 1, 1] == pytest.approx((1e-6 + spread + 0.5 * across / 1e8) / 0.5, rel=1e-3)


def test_a_scan_without_plots_is_a_miss():
    z, R = together(
        Taken(np.array([0, 0]), np.zeros(0, int), np.zeros(0), np.eye(2)[None]), *_one(), jink.Position(sd=5.0)
    )
    assert np.isnan(z).all() and np.isfinite(R).all()


def _one():
    return np.zeros((1, 2)), 25.0 * np.eye(2)[None]


def test_in_dense_clutter_marginals_are_better_than_the_likeliest_plot():
    from benchmarks.sky_smoothing import of_run

    sky = sky_called("sky-dense")
    errors = np.array([of_run(sky, sky.run(k, 31)) for k in range(3)])[:, :, 0]
    filtered, assigned, marginals = np.sqrt(errors.mean(axis=0))
    assert marginals < assigned < filtered and marginals < 0.65 * filtered


def test_existence_is_that_of_all_lives_weighed():
    """A target is there at first with p, lives on with s; scan k has the likelihood ratio L_k, there over not there."""
    p, s, ratios = 0.3, 0.9, np.array([2.0, 0.4, 5.0, 0.2, 0.1])
    r, before = np.zeros(5), p
    for k, ratio in enumerate(ratios):
        r[k] = before * ratio / (1 - before + before * ratio)
        before = s * r[k]
    # lives of 0 to 5 scans
    weight = np.array(
        [1 - p, *(p * s**k * (1 - s) * ratios[: k + 1].prod() for k in range(4)), p * s**4 * ratios.prod()]
    )
    want = [weight[k + 1 :].sum() / weight.sum() for k in range(5)]
    got = _existence(r, np.arange(5.0), np.arange(5) == 0, -1.0 / np.log(s))
    assert got == pytest.approx(np.array(want))


def test_existence_is_smoothed_track_by_track():
    run = sky_called("sky-parallel-200").run(0, 4)
    scans = scans_of(run)
    tracker = tracker_of(STRAIGHT, clutter=21, stay=800.0)
    found = track_scans(tracker, scans, keep=True)
    got = smoothed(tracker, scans, found)
    ends = np.flatnonzero(np.r_[np.diff(found.id) != 0, True])
    assert got.existence[ends] == pytest.approx(found.existence[ends])
    assert (np.diff(got.existence)[np.diff(got.id) == 0] <= 1e-12).all()
    with_lag = smoothed(tracker, scans, found, lag=1)
    assert (with_lag.existence == found.existence).all()


def test_a_table_is_smoothed_too():
    run = sky_called("sky-parallel-200").run(0, 4)
    plots = pl.concat([pl.DataFrame({"time": s.time, "x": s.z[:, 0], "y": s.z[:, 1]}) for s in run.scans])
    plain = tracker_of(STRAIGHT, clutter=21).run(plots)
    smooth = tracker_of(STRAIGHT, clutter=21).run(plots, smooth=True)
    assert smooth.select("id", "time", "row", "status").equals(plain.select("id", "time", "row", "status"))
    assert smooth["px_sd"].mean() < 0.8 * plain["px_sd"].mean()


def test_a_filter_that_cannot_be_smoothed_is_refused():
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=50.0))
    filter.not_smoothed = "it forgets"
    plots = pl.DataFrame({"time": [0.0, 4.0], "x": [0.0, 1.0], "y": [0.0, 1.0]})
    with pytest.raises(ValueError, match="Kalman cannot be smoothed: it forgets"):
        tracker_of(filter).run(plots, smooth=True)
