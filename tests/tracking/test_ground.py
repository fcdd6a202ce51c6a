"""No height runs below the lowest ground that was measured, and an estimate that is lifted there claims no more."""

import json

import numpy as np
import polars as pl
import pytest

import jink
from jink.io.loading import Reading
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings


def descent(unmeasured=30):
    """Descends at 8 m/s to 40 m; then its heights are not measured any more."""
    time = 2.0 * np.arange(60.0 + unmeasured)
    rng = np.random.default_rng(7)
    z = 1000.0 - 8.0 * time + rng.normal(0.0, 5.0, time.size)
    z[60:] = np.nan
    x = 70.0 * time + rng.normal(0.0, 10.0, time.size)
    return pl.DataFrame({"target": "A", "time": time, "x": x, "y": rng.normal(0.0, 10.0, time.size), "z": z})


@pytest.mark.parametrize("how", [{}, {"smooth": True}, {"lag": 2}, {"every": "1s"}])
def test_a_height_that_is_not_measured_stays_above_the_lowest_that_was(how):
    flight = descent()
    tracks = jink.track(flight, sensor_sd={"position": 10.0, "z": 5.0}, **how)
    floor = flight["z"].min() - 15.0
    coasting = tracks.filter(pl.col("time") > 118.0)
    assert coasting["z"].min() == pytest.approx(floor)
    assert set(coasting["altitude_status"]) == {"predicted"}
    down = coasting.filter(pl.col("z") < floor + 1e-6)
    assert down.height > 10 and (down["climb_rate"] == 0.0).all()


def test_a_lifted_height_says_how_far_it_was_lifted():
    flight = descent()
    free = jink.track(flight, sensor_sd={"position": 10.0, "z": 5.0}).filter(pl.col("time") > 118.0)
    # beside a target whose ground lies lower
    low = pl.DataFrame({"target": "B", "time": flight["time"], "x": flight["x"], "y": flight["y"] + 9e3, "z": -5000.0})
    both = jink.track(pl.concat([flight, low]), sensor_sd={"position": 10.0, "z": 5.0})
    as_it_was = both.filter(pl.col("target") == "A", pl.col("time") > 118.0)
    depth = (free["z"] - as_it_was["z"]).to_numpy()
    assert depth.max() > 50.0 and depth.min() >= 0.0
    np.testing.assert_allclose(free["z_sd"] ** 2, as_it_was["z_sd"] ** 2 + depth**2)
    np.testing.assert_allclose(free["x"], as_it_was["x"])


def test_a_stream_has_the_ground_that_it_has_shown():
    lines = [json.dumps(row) for row in descent().fill_nan(None).iter_rows(named=True)]
    tracks = LiveTracks(Reading(), Settings(sensor_sd={"position": 10.0, "z": 5.0}))
    one_by_one = "".join(tracks.take([line.encode()])[0] for line in lines)
    together = LiveTracks(Reading(), Settings(sensor_sd={"position": 10.0, "z": 5.0}))
    assert together.take([line.encode() for line in lines])[0] == one_by_one
    heights = [json.loads(line)["z"] for line in one_by_one.splitlines()]
    assert min(heights[60:]) == pytest.approx(descent()["z"].min() - 15.0)
