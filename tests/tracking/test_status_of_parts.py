"""What is not known or not measured is said: velocities of a start, heights without a measurement."""

import numpy as np
import polars as pl

import jink


def flight(count=40, jump=None, missing=()):
    time = 4.0 * np.arange(count)
    rng = np.random.default_rng(5)
    x, z = 200.0 * time + rng.normal(0, 20.0, count), 3000.0 + rng.normal(0, 5.0, count)
    if jump:
        x[jump:] += 90e3
    z[list(missing)] = np.nan
    return pl.DataFrame({"target": "A", "time": time, "x": x, "y": rng.normal(0, 20.0, count), "z": z})


def test_the_speed_of_a_first_row_is_null():
    tracks = jink.track(flight())
    for name in ("speed", "course", "course_sd", "velocity_x", "velocity_y", "velocity_z", "climb_rate"):
        assert tracks[name][0] is None and tracks[name][1] is not None, name
    assert tracks["velocity_x_sd"][0] > 100.0
    assert jink.track(flight(), smooth=True)["speed"][0] > 190.0


def test_the_speed_of_a_restarted_row_is_null():
    tracks = jink.track(flight(jump=20), sensor_sd=20.0, check_coordinates=False)
    restarted = tracks.filter(pl.col("status") == "restarted")
    assert restarted.height == 1 and restarted["speed"][0] is None


def test_heights_have_a_status_of_their_own():
    tracks = jink.track(flight(missing=range(20, 30)))
    assert set(tracks["status"][2:]) == {"updated"}
    height = tracks["altitude_status"].to_list()
    assert set(height[20:30]) == {"predicted"} and set(height[2:20] + height[30:]) == {"updated"}
    assert "altitude_status" not in jink.track(flight().drop("z")).columns
