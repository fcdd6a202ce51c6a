"""Heights that are not measured: their sds grow by what the climb rate may do meanwhile, in files and in streams."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest

import jink
from jink.io.loading import Reading
from jink.tracking.lag import Lag
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings
from jink.tracking.unseen_heights import variances

CLIMBS = (8.0, 100.0)
INTENSITY = 2.0 * 8.0**2 / 100.0


def test_variances_are_those_of_a_random_walk_between_what_is_known():
    height, climb = variances(np.array([0.0, 5.0, 5.0, 30.0]), np.array([9.0, np.inf, 5.0, 0.0]), CLIMBS)
    np.testing.assert_allclose(height, INTENSITY * np.array([0.0, 125.0 / 3.0, 125.0 / 24.0, 0.0]), rtol=1e-12)
    np.testing.assert_allclose(climb, INTENSITY * np.array([0.0, 5.0, 5.0 / 8.0, 0.0]), rtol=1e-12)


def test_variances_between_two_ends_are_those_of_a_gaussian_given_both():
    """Positions and rates of a random walk at 4, 10 and 15 s; the ones at 10 given the others, by conditioning."""
    t = np.array([4.0, 10.0, 15.0])
    early, late = np.minimum(t[:, None], t), np.maximum(t[:, None], t)
    zz, vv = early**2 * (3.0 * late - early) / 6.0, early
    zv = np.where(t[:, None] <= t, 0.5 * t[:, None] ** 2, t * t[:, None] - 0.5 * t**2)
    C = INTENSITY * np.block([[zz, zv], [zv.T, vv]])
    given, wanted = [0, 2, 3, 5], [1, 4]
    left = C[np.ix_(wanted, wanted)] - C[np.ix_(wanted, given)] @ np.linalg.solve(
        C[np.ix_(given, given)], C[np.ix_(given, wanted)]
    )
    height, climb = variances(np.array([6.0]), np.array([5.0]), CLIMBS)
    np.testing.assert_allclose([height[0], climb[0]], np.diag(left), rtol=1e-9)


def test_no_rate_is_less_certain_than_the_kind_allows():
    height, climb = variances(np.array([1e4]), np.array([np.inf]), CLIMBS)
    assert height == pytest.approx((8.0 * 1e4) ** 2) and climb == pytest.approx(64.0)


def climbing(rows: int = 120, heights: slice = slice(0, 0)) -> pl.DataFrame:
    """Straight on at 200 m/s; level, and from the middle on climbing at 10 m/s. Some heights are missing."""
    rng, t = np.random.default_rng(2), 4.0 * np.arange(rows)
    z = 3000.0 + 10.0 * np.maximum(t - t[rows // 2], 0.0)
    seen = z + rng.normal(0, 7.0, rows)
    seen[heights] = np.nan
    x, y = 200.0 * t + rng.normal(0, 10.0, rows), rng.normal(0, 10.0, rows)
    return pl.DataFrame({"target": "a", "time": t, "x": x, "y": y, "z": seen, "truth": z}).with_columns(
        pl.col("z").fill_nan(None)
    )


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("missing", [slice(50, 75), slice(0, 70), slice(55, 120)])
def test_a_climb_that_no_height_shows_is_within_three_sds(smooth, missing):
    """In the middle, before the first height and after the last one."""
    data = climbing(heights=missing)
    tracks = jink.track(data.drop("truth"), smooth=smooth)
    error = np.abs(tracks["z"].to_numpy() - data["truth"].to_numpy())[missing]
    assert (error <= 3.0 * tracks["z_sd"].to_numpy()[missing]).all()
    assert (tracks["z_sd"].to_numpy()[missing] > 7.0).all()


@pytest.mark.parametrize("missing", [slice(50, 75), slice(50, 120, 2)])
def test_streams_say_the_same_sds_as_files(missing):
    data = climbing(heights=missing).drop("truth")
    whole = jink.track(data, sensor_sd={"position": 10.0, "z": 7.0}, lag="2")
    filtered = jink.track(data, sensor_sd={"position": 10.0, "z": 7.0})
    live = LiveTracks(Reading(), Settings(sensor_sd={"position": 10.0, "z": 7.0}, lag=Lag.of("2")))
    lines = [json.dumps(row).encode() for row in data.iter_rows(named=True)]
    rows = [json.loads(text) for line in lines for text in live.take([line])[0].splitlines()]
    for name in ("z_sd", "climb_rate_sd", "velocity_z_sd"):
        np.testing.assert_allclose([row[name] for row in rows[4:]], filtered[name].to_numpy()[4:], rtol=1e-6)
        late = [row[f"lagged_{name}"] for row in rows[10:]]
        np.testing.assert_allclose(late, whole[name].to_numpy()[8:-2], rtol=1e-6)
