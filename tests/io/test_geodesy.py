"""The developed frame: straight is straight, far is as far as it is, and the way back is exact."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod, Transformer

from jink.io.geodesy import DevelopedFrame, SiteFrame, develop

GEOD = Geod(ellps="WGS84")


def _along(latitude: float, longitude: float, azimuth: float, distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    full = [np.full(distances.shape, value) for value in (longitude, latitude, azimuth)]
    lon, lat, _ = GEOD.fwd(*full, distances)
    return np.asarray(lat), np.asarray(lon)


def _one(latitude: np.ndarray, longitude: np.ndarray) -> DevelopedFrame:
    return develop(latitude, longitude, np.arange(latitude.size) == 0)


@pytest.mark.parametrize(
    ("latitude", "longitude", "azimuth"),
    [(50, -3, 285), (-5, 170, 80), (85, 10, 0), (-80, 100, 200), (0, 0, 90)],
    ids=["ocean", "date line", "over the pole", "past the south pole", "equator"],
)
def test_a_geodesic_of_six_thousand_kilometres_is_a_straight_line(latitude, longitude, azimuth):
    distances = np.linspace(0.0, 6e6, 400)
    frame = _one(*_along(latitude, longitude, azimuth, distances))
    course = np.radians(azimuth)
    np.testing.assert_allclose(frame.x, distances * np.sin(course), atol=1e-3)
    np.testing.assert_allclose(frame.y, distances * np.cos(course), atol=1e-3)


@given(st.floats(-89.9, 89.9), st.floats(-180, 180), st.integers(0, 2**32 - 1))
def test_the_way_back_is_exact(latitude, longitude, seed):
    rng = np.random.default_rng(seed)
    steps = rng.uniform(1.0, 50_000.0, 20)
    lat, lon = [latitude], [longitude]
    for step, azimuth in zip(steps, rng.uniform(-180, 180, 20), strict=True):
        next_lon, next_lat, _ = GEOD.fwd(lon[-1], lat[-1], azimuth, step)
        lat.append(next_lat)
        lon.append(next_lon)
    frame = _one(np.array(lat), np.array(lon))
    back_lat, back_lon, _ = frame.to_geographic(frame.x, frame.y)
    assert max(GEOD.inv(lon, lat, back_lon, back_lat)[2]) < 1e-6
    np.testing.assert_allclose(np.hypot(np.diff(frame.x), np.diff(frame.y)), steps, rtol=1e-9, atol=1e-6)


def test_an_offset_goes_back_in_the_right_direction_far_from_the_start():
    lat, lon = _along(60.0, -30.0, 70.0, np.linspace(0, 4e6, 200))
    frame = _one(lat, lon)
    ahead = np.degrees(np.arctan2(*(np.array([np.diff(frame.x)[-1], np.diff(frame.y)[-1]]))))
    unit = np.sin(np.radians(ahead)), np.cos(np.radians(ahead))
    new_lat, new_lon, convergence = frame.to_geographic(frame.x + 1000 * unit[0], frame.y + 1000 * unit[1])
    azimuth, _, distance = GEOD.inv(lon[-1], lat[-1], new_lon[-1], new_lat[-1])
    assert distance == pytest.approx(1000, abs=1e-5)
    leg = GEOD.inv(lon[-2], lat[-2], lon[-1], lat[-1])[1] + 180.0
    assert (azimuth - leg) % 360 == pytest.approx(0, abs=1e-6) or (azimuth - leg) % 360 == pytest.approx(360, abs=1e-6)
    true_course = (ahead + np.degrees(convergence[-1])) % 360
    reverse = (GEOD.inv(lon[-1], lat[-1], new_lon[-1], new_lat[-1])[1] + 180.0) % 360
    assert true_course == pytest.approx(reverse, abs=1e-6)


def test_tracks_do_not_leak_into_each_other_and_misses_hang_on_the_last_position():
    lat = np.array([10.0, 10.1, np.nan, 10.2, 60.0, np.nan, 60.1])
    lon = np.array([20.0, 20.0, np.nan, 20.0, -120.0, np.nan, -120.0])
    first = np.array([True, False, False, False, True, False, False])
    frame = develop(lat, lon, first)
    alone = _one(lat[4:], lon[4:])
    np.testing.assert_allclose(frame.y[4:], alone.y, rtol=0, atol=1e-9)
    assert np.isnan(frame.x[[2, 5]]).all() and frame.x[4] == 0.0 and frame.y[4] == 0.0
    assert frame.anchor_latitude[2] == 10.1 and frame.anchor_latitude[5] == 60.0
    part = frame.rows(slice(4, 7))
    back = part.to_geographic(np.array([0.0, 0.0, 0.0]), np.array([0.0, 1000.0, part.y[2]]))
    assert back[0][2] == pytest.approx(60.1, abs=1e-11) and 60.0 < back[0][1] < 60.01


def test_what_comes_before_the_first_position_has_no_place():
    lat = np.array([10.0, 10.1, np.nan, 10.2, 10.3])
    frame = develop(lat, np.full(5, 20.0), np.array([True, False, True, False, False]))
    assert np.isnan([*frame.to_geographic(np.zeros(5), np.zeros(5))])[:, 2].all() and np.isnan(frame.x[2])
    assert frame.x[3] == frame.y[3] == frame.anchor_convergence[2] == 0.0 and frame.y[4] > 1e4


@pytest.mark.parametrize("again", [1, 2])
def test_a_lone_position_on_another_continent_does_not_bend_what_follows(again):
    """Nor do two, apart from each other."""
    lat, lon = _along(48.0, 2.0, 30.0, np.arange(50) * 200.0)
    clean = _one(lat.copy(), lon.copy())
    away = np.array([20, 30])[:again]
    lat[away], lon[away] = -33.0, 151.0
    frame = _one(lat, lon)
    azimuth, _, length = GEOD.inv(lon[away - 1], lat[away - 1], lon[away], lat[away])
    way = np.radians(azimuth) - clean.anchor_convergence[away - 1]
    np.testing.assert_allclose(frame.x[away], clean.x[away - 1] + length * np.sin(way), atol=1e-6)
    np.testing.assert_allclose(frame.y[away], clean.y[away - 1] + length * np.cos(way), atol=1e-6)
    keep = ~np.isin(np.arange(50), away)
    np.testing.assert_allclose(frame.x[keep], clean.x[keep], atol=1e-6)


@given(st.floats(-85, 85), st.floats(-180, 180), st.floats(-2e5, 2e5), st.floats(-2e5, 2e5), st.floats(0, 2e4))
def test_the_frame_of_a_site_agrees_with_proj(latitude, longitude, x, y, z):
    frame = SiteFrame(latitude, longitude, 300.0)
    lat, lon, _, altitude = frame.to_geographic(np.array([x]), np.array([y]), np.array([z]))
    assert altitude is not None
    origin = f"+lon_0={longitude} +lat_0={latitude} +h_0=300"
    steps = f"+proj=pipeline +step +proj=cart +ellps=WGS84 +step +proj=topocentric +ellps=WGS84 {origin}"
    back = Transformer.from_pipeline(steps).transform(lon[0], lat[0], altitude[0])
    np.testing.assert_allclose(back, (x, y, z), atol=1e-5)


def test_a_flat_site_measures_along_the_ground():
    frame = SiteFrame(48.0, 11.0)
    lat, lon, convergence, altitude = frame.to_geographic(np.array([30_000.0, np.nan]), np.array([40_000.0, 0.0]))
    azimuth, back, distance = GEOD.inv(11.0, 48.0, lon[0], lat[0])
    assert (
        distance == pytest.approx(50_000)
        and azimuth == pytest.approx(np.degrees(np.arctan2(3, 4)))
        and altitude is None
    )
    assert np.degrees(convergence[0]) == pytest.approx(back + 180.0 - azimuth, abs=1e-9) and np.isnan(lat[1])
