"""A velocity from two positions is that of a target of the kind; positions that contradict each other start anew."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest

import jink
from jink.io.loading import Reading
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings


def walk(wrong: dict[int, float], count: int = 120, seed: int = 0) -> pl.DataFrame:
    """Someone who walks east at 1.4 m/s, seen every second with 3 m; some rows are so far off to the north."""
    rng = np.random.default_rng(seed)
    time = np.arange(float(count))
    x, y = 1.4 * time + rng.normal(0.0, 3.0, count), rng.normal(0.0, 3.0, count)
    for row, by in wrong.items():
        y[row] += by
    return pl.DataFrame({"target": "A", "time": time, "x": x, "y": y})


def check(tracks: pl.DataFrame) -> None:
    """No speed that is known is more than three sds from the truth."""
    known = tracks.filter(pl.col("speed").is_not_null())
    error = (known.select("velocity_x", "velocity_y").to_numpy() - [1.4, 0.0]) / known.select(
        "velocity_x_sd", "velocity_y_sd"
    ).to_numpy()
    assert np.abs(error).max() < 4.0
    assert known["speed"].max() < 15.0


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("wrong", [{0: 65.0}, {0: 130.0, 1: 65.0}, {0: -300.0}])
@pytest.mark.parametrize("smooth", [False, True])
def test_a_fix_that_converges_in_jumps_makes_no_speed(wrong, seed, smooth):
    tracks = jink.track(walk(wrong, seed=seed), kind="person", sensor_sd=3.0, smooth=smooth, check_coordinates=False)
    check(tracks)
    assert (tracks["status"][5:] == "updated").mean() > 0.97


def test_so_it_does_after_a_gap():
    before, after = walk({}), walk({0: 64.6}, seed=1).with_columns(pl.col("time") + 900.0)
    tracks = jink.track(pl.concat([before, after]), kind="person", sensor_sd=3.0, check_coordinates=False)
    assert tracks["part"].max() == 1
    check(tracks)


def test_so_it_does_in_a_stream():
    lines = [json.dumps(row) for row in walk({0: 65.0}).iter_rows(named=True)]
    tracks = LiveTracks(Reading(), Settings(kind="person", sensor_sd={"position": 3.0}))
    rows = [json.loads(line) for line in "".join(tracks.take([line.encode()])[0] for line in lines).splitlines()]
    assert [row["status"] for row in rows[:3]] == ["initialised"] * 3
    assert rows[0]["speed"] is None and rows[1]["speed"] is None
    check(pl.DataFrame(rows))


def test_a_first_report_that_is_wrong_is_given_up():
    """An airliner at 220 m/s whose first report lies 12 km off."""
    rng = np.random.default_rng(4)
    time = 10.0 * np.arange(60)
    x, y = 220.0 * time + rng.normal(0, 3.0, 60), rng.normal(0, 3.0, 60)
    y[0] += 12e3
    data = pl.DataFrame({"target": "A", "time": time, "x": x, "y": y})
    tracks = jink.track(data, sensor_sd=3.0, check_coordinates=False)
    fast = tracks.filter(pl.col("speed") > 300.0)
    assert fast.height <= 3 and tracks["speed"][4:].max() < 225.0
    checked = jink.track(data, sensor_sd=3.0, details=True)
    assert checked.tracks["speed"].max() < 225.0 and checked.rejected["row"].to_list() == [0]


def test_a_target_of_another_kind_is_believed_in_the_end():
    """What is too fast three times over is that fast: the warning names the kind."""
    time = np.arange(100.0)
    data = pl.DataFrame({"target": "A", "time": time, "x": 220.0 * time, "y": 0.0 * time})
    tracked = jink.track(data, kind="person", sensor_sd=3.0, check_coordinates=False, details=True)
    speed = tracked.tracks["speed"]
    assert speed[:3].null_count() == 3 and np.allclose(speed[10:], 220.0, rtol=0.02)


def test_sds_of_starts_are_true():
    """Of many starts, the velocity after two positions is off by as much as its sd says."""
    rng = np.random.default_rng(2)
    velocity = rng.normal(0.0, 10.0, (4000, 2))
    z = np.stack([rng.normal(0, 8.0, (4000, 2)), velocity + rng.normal(0, 8.0, (4000, 2))], axis=1)
    filter = jink.Kalman(
        jink.ConstantVelocity(acceleration_psd=1e-6),
        jink.Position(sd=8.0),
        initial=jink.TwoPoint(velocity_sd=10.0, bounded=True),
    )
    found = filter.filter(np.tile([0.0, 1.0], 4000), z.reshape(-1, 2), offsets=2 * np.arange(4001))
    x, P = found.x[1::2], found.P[1::2]
    v = [found.components.index(name) for name in ("vx", "vy")]
    squares = (x[:, v] - velocity) ** 2 / np.einsum("nii->ni", P)[:, v]
    assert squares.mean() == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / squares.size))
    # without the bound the same start is as unsure as two positions are
    assert np.sqrt(P[0, v[0], v[0]]) < 8.0 < np.sqrt(2.0) * 8.0
