"""A lag when live: the lagged estimates are those of a file with that lag, beside the current ones."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose

import jink
from jink.io.errors import InputError
from jink.io.loading import Reading
from jink.metrics.figure import ratio
from jink.tracking.lag import Lag
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings


def rows(geographic: bool, targets: int = 3, scans: int = 40) -> list[dict]:
    rng, out = np.random.default_rng(2), []
    for k in range(scans):
        for b in range(targets):
            x, y = 150.0 * 5 * k + rng.normal(0, 30), 4e3 * np.sin(k / 9.0) + 2e4 * b + rng.normal(0, 30)
            place = {"lat": 49.0 + y / 111e3, "lon": 8.0 + x / 73e3} if geographic else {"x": x, "y": y}
            out.append({"target": f"t{b}", "time": 5.0 * k, **place})
    return out


@pytest.mark.parametrize("geographic", [False, True])
@pytest.mark.parametrize("apart", [False, True])
def test_lagged_columns_are_those_of_a_file_with_that_lag(geographic, apart):
    data, lag = rows(geographic), 2
    live = LiveTracks(Reading(), Settings(sensor_sd={"position": 30.0}, lag=Lag.of(lag)), apart=apart)
    lines = [json.dumps(row).encode() for row in data]
    said = "".join(live.take(lines[k : k + 7])[0] for k in range(0, len(lines), 7))
    found = pl.DataFrame([json.loads(line) for line in said.splitlines()], infer_schema_length=None)
    current = jink.track(pl.DataFrame(data), sensor_sd=30.0).sort("row")
    whole = jink.track(pl.DataFrame(data), sensor_sd=30.0, lag=lag)
    assert_allclose(found["speed"][12:], current["speed"][12:], rtol=1e-6)
    late = found.filter(pl.col("lagged_row").is_not_null())
    assert late.height == len(data) - 3 * lag
    beside = late.join(whole.with_columns(lagged_row=pl.col("row").cast(pl.Int64)), on="lagged_row", suffix="_whole")
    assert beside.height == late.height
    place = ["latitude", "longitude"] if geographic else ["x", "y"]
    for name in [*place, "speed", "speed_sd", "course", "manoeuvring"]:
        other = name if name not in late.columns else f"{name}_whole"
        assert_allclose(beside[f"lagged_{name}"], beside[other], rtol=1e-6, atol=1e-6, err_msg=name)
    assert_allclose(beside["time"] - beside["lagged_time"], 10.0)
    # what one lag gains, on average over rows
    assert late["lagged_speed_sd"].mean() < 0.9 * late["speed_sd"].mean()


def test_an_object_gives_the_same_and_goes_on_from_its_state():
    data = rows(False)
    tracker, plain = jink.LiveTracker(sensor_sd=30.0, lag=1), jink.LiveTracker(sensor_sd=30.0)
    first, second = tracker.update_many(data[:60]), plain.update_many(data[:60])
    assert "lagged_x" not in second[-1] and first[-1]["lagged_row"] == 56
    assert first[-1]["x"] == second[-1]["x"]
    again = jink.LiveTracker.load(tracker.save())
    assert again.update_many(data[60:])[-1]["lagged_row"] == len(data) - 4


def test_a_lag_of_seconds_and_one_without_a_smoother_are_refused():
    with pytest.raises(InputError, match="a stream takes a number of scans"):
        LiveTracks(Reading(), Settings(lag=Lag.of("8s")))
    tracker = jink.LiveTracker(filter="input-estimation", lag=2)
    with pytest.raises(InputError, match=r"lag: .* cannot be smoothed"):
        tracker.update("a", 0.0, x=1.0, y=2.0)


def test_covariances_with_a_lag_are_those_of_the_errors():
    # targets that move as the filter says: two modes of noise with sojourns of 40 and 15 s
    rng, runs, scans, T = np.random.default_rng(8), 400, 60, 4.0
    level, quiet = np.array([0.05, 9.0]), rng.random(runs) < 40 / 55
    x = np.zeros((runs, 2, 2))
    x[:, :, 1] = rng.normal(0, 100, (runs, 2))
    Q = np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
    truth, root = np.empty((runs, scans, 4)), np.linalg.cholesky(Q)
    leave = 55 / (40 * 15)
    to_quiet = np.array([[1 - np.exp(-leave * T)]]) * np.array([[40 / 55]])
    for k in range(scans):
        chance = np.where(quiet, 1 - (1 - np.exp(-leave * T)) * 15 / 55, to_quiet[0, 0])
        quiet = rng.random(runs) < chance
        noise = rng.normal(size=(runs, 2, 2)) @ root.T * np.sqrt(np.where(quiet, *level))[:, None, None]
        x = np.stack([x[:, :, 0] + T * x[:, :, 1], x[:, :, 1]], axis=2) + noise
        truth[:, k] = x.reshape(runs, 4)
    z = truth[:, :, [0, 2]] + rng.normal(0, 50, (runs, scans, 2))
    motions = [jink.ConstantVelocity(acceleration_psd=q) for q in level]
    filter = jink.IMM(motions, jink.Position(sd=50.0), jink.Sojourn([40.0, 15.0]))
    time, offsets = np.tile(np.arange(scans) * T, runs), np.arange(runs + 1) * scans
    for lag in (0, 1, 3):
        found = filter.smooth(time, z.reshape(-1, 2), offsets=offsets, lag=lag)
        error = (found.x - truth.reshape(-1, 4)).reshape(runs, scans, 4)[:, 10:-3]
        P = found.P.reshape(runs, scans, 4, 4)[:, 10:-3]
        nees = np.einsum("rsi,rsij,rsj->rs", error, np.linalg.inv(P), error) / 4
        mean, error_of_mean = ratio(nees.sum(axis=1), np.full(runs, float(nees.shape[1])))
        # a merged mixture is not Gaussian, so its NEES is 1 to some hundredths; three standard errors beside
        assert abs(mean - 1.0) < 0.06 + 3 * error_of_mean, (lag, mean, error_of_mean)


def test_a_tracker_with_a_lag_says_where_its_tracks_were():
    rng, T, lag, scans = np.random.default_rng(3), 4.0, 2, 60
    filter = jink.default_filter("aircraft", jink.Position(sd=50.0), interval=T)
    options = {"new_per_hour": 1.0, "targets": 3.0}
    radar = jink.Radar(detection=0.95, clutter_per_scan=2.0, area=(-1e4, 7e4, -1e4, 9e4))
    tracker, plain = (jink.Tracker(filter, radar, lag=k, **options) for k in (lag, 0))
    there = lambda k: np.array([[200.0 * T * k, 3e4 * b + 6e3 * np.sin(k / 12.0)] for b in range(3)])  # noqa: E731
    errors: dict[str, list[float]] = {"now": [], "lagged": []}
    for k in range(scans):
        seen = there(k) + rng.normal(0, 50, (3, 2))
        plots = np.vstack([seen[rng.random(3) < 0.95], rng.uniform([-1e4, -1e4], [7e4, 9e4], (2, 2))])
        picture, same = tracker.scan(T * k, plots), plain.scan(T * k, plots)
        assert same.lagged is None and picture.lagged is not None
        assert_allclose(picture.estimate.x, same.estimate.x)
        known = np.isfinite(picture.lagged.time) & picture.confirmed
        if k < 15:
            continue
        assert_allclose(picture.lagged.time[known], T * (k - lag))
        for name, estimate, then in (("now", picture.estimate, k), ("lagged", picture.lagged, k - lag)):
            for place in np.column_stack([estimate["px"], estimate["py"]])[known]:
                off = np.hypot(*(there(then) - place).T).min()
                errors[name] += [off] if off < 1e3 else []
    # two scans later an error is about .65 of the current one; there are some 130 errors, correlated over a few
    assert len(errors["now"]) > 100
    assert np.mean(np.square(errors["lagged"])) < 0.75**2 * np.mean(np.square(errors["now"]))
    with pytest.raises(ValueError, match="lag: expected none beside history"):
        jink.Tracker(filter, radar, lag=1, history=2)
