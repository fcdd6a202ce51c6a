import numpy as np
import polars as pl

from jink.report.plan import measured_coordinates, plan_coordinates, unwrap
from jink.report.rows import read_rows


def frame(latitude, longitude, **more):
    n = len(latitude)
    return pl.DataFrame(
        {
            "target": ["a"] * n,
            "time": np.arange(n) * 1.0,
            "latitude": latitude,
            "longitude": longitude,
            **more,
        }
    )


def test_unwrap_restarts_per_group_and_jumps_over_missing_values():
    angle = np.array([350.0, np.nan, 5.0, 20.0, 350.0, 340.0])
    group = np.array([0, 0, 0, 0, 1, 1])
    np.testing.assert_allclose(unwrap(angle, group, 360.0), [350, np.nan, 365, 380, 350, 340])
    np.testing.assert_allclose(unwrap(angle, group, 360.0, 0.0), [-10, np.nan, 5, 20, -10, -20])


def test_a_track_across_the_date_line_stays_in_one_piece():
    longitude = np.array([178.0, 179.5, -179.0, -177.5])
    east, north, origin = plan_coordinates(read_rows(frame(np.full(4, 10.0), longitude)))
    assert origin is not None
    np.testing.assert_allclose(np.diff(east), np.diff(east)[0])
    assert np.abs(east).max() < 3 * 111.3e3
    np.testing.assert_allclose(north, 0.0, atol=1e-6)


def test_scale_is_true_in_the_middle():
    east, north, _ = plan_coordinates(read_rows(frame([59.9, 60.1], [7.0, 7.2])))
    assert np.isclose(np.diff(north)[0], 0.2 * 111_195, rtol=1e-3)
    assert np.isclose(np.diff(east)[0], 0.2 * 111_195 * 0.5, rtol=1e-3)


def test_measured_residuals_are_turned_from_the_developed_frame_to_north():
    turned = np.radians(30.0)  # the frame's y axis points 30 degrees clockwise from true north
    course = np.radians([10.0, 10.0])
    dx, dy = 100.0, 50.0
    tracks = frame(
        [46.0, 46.0],
        [7.0, 7.0],
        x=[0.0, 0.0],
        y=[0.0, 0.0],
        measured_x=[dx, np.nan],
        measured_y=[dy, np.nan],
        velocity_x=np.sin(course - turned),
        velocity_y=np.cos(course - turned),
        course=course,
    )
    rows = read_rows(tracks)
    east, north, origin = plan_coordinates(rows)
    me, mn = measured_coordinates(rows, east, north, origin)
    assert np.isclose(me[0] - east[0], dx * np.cos(turned) + dy * np.sin(turned))
    assert np.isclose(mn[0] - north[0], dy * np.cos(turned) - dx * np.sin(turned))
    assert np.isnan(me[1]) and np.isnan(mn[1])


def test_metric_tracks_are_taken_as_they_are():
    tracks = pl.DataFrame(
        {"target": ["a"], "time": [0.0], "x": [5.0], "y": [6.0], "measured_x": [7.0], "measured_y": [8.0]}
    )
    rows = read_rows(tracks)
    east, north, origin = plan_coordinates(rows)
    assert (east[0], north[0], origin) == (5.0, 6.0, None)
    assert [v[0] for v in measured_coordinates(rows, east, north, origin)] == [7.0, 8.0]
