"""Short geodesics by series: the same as pyproj's, near the poles and across the date line too."""

import numpy as np
import pytest
from pyproj import Geod

from jink.io.short_geodesics import AHEAD, BETWEEN, BLOCK, geodesics_ahead, geodesics_between

GEOD = Geod(ellps="WGS84")
MICROMETRE = 1e-6  # m, which the module promises


def _places(rng: np.random.Generator, longest: float) -> tuple[np.ndarray, ...]:
    """Starts everywhere, some at a pole and at the date line; azimuths; lengths up to `longest`, some 0."""
    count = 2 * BLOCK + 100
    latitude, longitude = rng.uniform(-90, 90, count), rng.uniform(-180, 180, count)
    longitude[::7] = 180.0 - rng.uniform(0, 0.01, longitude[::7].size)
    latitude[::101] = 90.0 - rng.uniform(0, 0.01, latitude[::101].size)
    length = longest * rng.uniform(0, 1, count) ** 2
    length[::50] = 0.0
    return latitude, longitude, rng.uniform(-180, 180, count), length


@pytest.mark.parametrize("longest", [10.0, BETWEEN, 30 * BETWEEN])
def test_between_two_places_it_is_the_geodesic(longest):
    latitude, longitude, azimuth, length = _places(np.random.default_rng(1), longest)
    to_longitude, to_latitude, _ = GEOD.fwd(longitude, latitude, azimuth, length)
    start, end, length = GEOD.inv(longitude, latitude, to_longitude, to_latitude)
    turn = np.radians((np.asarray(end) + 180.0 - start + 180.0) % 360.0 - 180.0)
    east, north, turned = geodesics_between(latitude, longitude, to_latitude, to_longitude)
    middle = np.radians(start) + 0.5 * turn
    np.testing.assert_allclose(east, length * np.sin(middle), atol=MICROMETRE, rtol=0)
    np.testing.assert_allclose(north, length * np.cos(middle), atol=MICROMETRE, rtol=0)
    moving = np.asarray(length) > 0.0
    np.testing.assert_allclose((turned - turn)[moving] * length[moving], 0.0, atol=MICROMETRE)


@pytest.mark.parametrize("longest", [10.0, AHEAD, 30 * AHEAD])
def test_ahead_of_a_place_it_is_the_geodesic(longest):
    latitude, longitude, azimuth, length = _places(np.random.default_rng(2), longest)
    to_longitude, to_latitude, back = GEOD.fwd(longitude, latitude, azimuth, length)
    turn = np.radians((np.asarray(back) + 180.0 - azimuth + 180.0) % 360.0 - 180.0)
    way = length * np.sin(np.radians(azimuth)), length * np.cos(np.radians(azimuth))
    found_latitude, found_longitude, turned = geodesics_ahead(latitude, longitude, *way)
    assert np.abs(found_longitude).max() <= 180.0
    apart = GEOD.inv(found_longitude, found_latitude, to_longitude, to_latitude)[2]
    np.testing.assert_allclose(apart, 0.0, atol=MICROMETRE)
    np.testing.assert_allclose((turned - turn) * length, 0.0, atol=MICROMETRE)


def test_no_rows_are_no_rows():
    none = np.zeros(0)
    assert all(part.size == 0 for part in (*geodesics_between(*4 * [none]), *geodesics_ahead(*4 * [none])))
