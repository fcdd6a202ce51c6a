"""The engine's geodesics: the same as pyproj's, near the poles and across the date line too."""

import os
import subprocess
import sys

import numpy as np
import pytest
from pyproj import Geod

from jink._engine import installed, native
from jink.io.geodesy import LONG, SiteFrame, develop, geodesics_between

GEOD = Geod(ellps="WGS84")
ERROR = 1e-7  # m, which the module promises
HALF_ROUND = 2e7  # m


def _wrapped(degrees: np.ndarray) -> np.ndarray:
    return (degrees + 180.0) % 360.0 - 180.0


def _places(seed: int, longest: float) -> tuple[np.ndarray, ...]:
    """Starts everywhere, some at a pole and at the date line; azimuths; lengths up to `longest`, some 0; latitude and
    longitude of the ends, and the turns on the way (rad).
    """
    rng = np.random.default_rng(seed)
    count = 20_001
    latitude, longitude = rng.uniform(-90, 90, count), rng.uniform(-180, 180, count)
    longitude[::7] = 180.0 - rng.uniform(0, 0.01, longitude[::7].size)
    latitude[::101] = 90.0 - rng.uniform(0, 0.01, latitude[::101].size)
    length = longest * rng.uniform(0, 1, count) ** 2
    length[::50] = 0.0
    azimuth = rng.uniform(-180, 180, count)
    to_longitude, to_latitude, back = GEOD.fwd(longitude, latitude, azimuth, length)
    turned = np.radians(_wrapped(np.asarray(back) + 180.0 - azimuth))
    return latitude, longitude, azimuth, length, np.asarray(to_latitude), np.asarray(to_longitude), turned


# on both sides of where the series end, and of where pyproj begins
@pytest.mark.parametrize("longest", [10.0, 2e4, 3e5, LONG, 1.5 * LONG])
def test_between_two_places_it_is_the_geodesic(longest):
    latitude, longitude, *_, to_latitude, to_longitude, _ = _places(1, longest)
    start, end, length = map(np.asarray, GEOD.inv(longitude, latitude, to_longitude, to_latitude))
    found, turned, long = geodesics_between(latitude, longitude, to_latitude, to_longitude)
    np.testing.assert_allclose(long, length, atol=ERROR, rtol=0)
    np.testing.assert_allclose(np.radians(_wrapped(np.degrees(found) - start)) * length, 0.0, atol=ERROR)
    np.testing.assert_allclose(np.radians(_wrapped(np.degrees(turned) - end + start - 180.0)) * length, 0.0, atol=ERROR)


@pytest.mark.parametrize("longest", [10.0, 2e3, 1e5, HALF_ROUND])
def test_ahead_of_a_place_it_is_the_geodesic(longest):
    latitude, longitude, azimuth, length, to_latitude, to_longitude, turn = _places(2, longest)
    zero, way = np.zeros(length.size), np.radians(azimuth)
    found = native.geodesics_ahead(length * np.sin(way), length * np.cos(way), zero, zero, latitude, longitude, zero)
    assert np.abs(found[1]).max() <= 180.0
    apart = GEOD.inv(found[1], found[0], to_longitude, to_latitude)[2]
    np.testing.assert_allclose(apart, 0.0, atol=ERROR)
    # over a pole the meridian turns at once: a direction is known as well as the place where it is
    nearest = np.cos(np.radians(np.minimum(np.abs(to_latitude), 90.0 - 1e-6)))
    np.testing.assert_allclose((found[2] - turn + np.pi) % (2 * np.pi) - np.pi, 0.0, atol=ERROR / 6e6 / nearest.min())


def test_the_way_in_a_turned_plane():
    """Anchors away from the origin, x and y columns of one table."""
    table = np.random.default_rng(3).uniform(-1e5, 1e5, (1001, 2))
    anchor, turn = np.full(1001, 7e4), np.full(1001, 0.3)
    found = native.geodesics_ahead(*table.T, anchor, anchor, *SiteFrame(48.0, 11.0).beside(anchor), turn)
    east, north = table.T - 7e4
    azimuth = np.degrees(np.arctan2(east, north) + 0.3)
    here = np.full(1001, 11.0), np.full(1001, 48.0)
    longitude, latitude, back = GEOD.fwd(*here, azimuth, np.hypot(east, north))
    np.testing.assert_allclose(found[:2], [latitude, longitude], rtol=0, atol=ERROR / 1e5)
    turned = np.radians(_wrapped(np.asarray(back) + 180.0 - azimuth))
    np.testing.assert_allclose(found[2], 0.3 + turned, rtol=0, atol=1e-12)


@pytest.mark.parametrize("latitude", [0.0, 51.0, 79.0, 88.0, -90.0])
def test_a_target_that_stands_does_not_move(latitude):
    place = np.full(9, latitude), np.full(9, 180.0)
    turned, length = geodesics_between(*place, *place)[1:]
    assert not turned.any() and not length.any()
    frame = develop(*place, np.arange(9) == 0)
    assert not frame.x.any() and not frame.y.any() and not frame.anchor_convergence.any()
    np.testing.assert_array_equal(frame.to_geographic(frame.x, frame.y), [*place, np.zeros(9)])


@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_has_no_place_and_leaves_its_neighbours_alone(nothing):
    latitude, longitude, azimuth, length, to_latitude, to_longitude, _ = (part[:64] for part in _places(4, 1e5))
    clean = geodesics_between(latitude, longitude, to_latitude, to_longitude)
    zero, x, y = np.zeros(64), length * np.sin(azimuth), length * np.cos(azimuth)
    ahead = native.geodesics_ahead(x, y, zero, zero, latitude, longitude, zero)
    for row in (3, 20, 63):
        latitude[row] = x[row] = nothing
    good = np.isfinite(latitude)
    found = geodesics_between(latitude, longitude, to_latitude, to_longitude)
    assert np.isnan(found[:, ~good]).all()
    np.testing.assert_array_equal(found[:, good], clean[:, good])
    for start, way in ((latitude, y), (np.zeros(64), x)):
        assert np.isnan(native.geodesics_ahead(way, y, zero, zero, start, longitude, zero)[:, ~good]).all()
    found = native.geodesics_ahead(x, y, zero, zero, latitude, longitude, zero)
    np.testing.assert_array_equal(found[:, good], ahead[:, good])


def test_no_rows_are_no_rows():
    none = np.zeros(0)
    assert geodesics_between(*4 * [none]).shape == native.geodesics_ahead(*7 * [none]).shape == (3, 0)
    assert develop(none, none, np.zeros(0, bool)).x.size == 0


def test_levels_of_the_engine_agree_and_nothing_imports_pyproj():
    code = """
import sys
import numpy as np
from jink.io.geodesy import develop
rng = np.random.default_rng(5)
latitude, longitude = 60.0 + np.cumsum(rng.normal(0, 0.05, 500)), np.cumsum(rng.normal(0, 0.2, 500))
frame = develop(latitude, longitude, np.arange(500) % 100 == 0)
print(*frame.x, *frame.y, *frame.to_geographic(frame.x + 5e3, frame.y)[1])
assert "pyproj" not in sys.modules
"""
    shown = [
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"JINK_ISA": each},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        for each in installed
    ]
    for other in shown[1:]:
        np.testing.assert_allclose(np.array(other, float), np.array(shown[0], float), rtol=1e-12, atol=1e-7)
