"""Coasts behind the tracks, and where radars stand."""

import numpy as np
import pytest

from jink.report.arrays import ArrayBlock
from jink.report.plan import plan_point
from jink.report.world import add_world, lines_within

RADIUS = 6_371_008.8
KM = 1000.0


def frame_at(latitude: float, longitude: float) -> dict[str, float]:
    return {"latitude": latitude, "longitude": longitude, "radius": RADIUS}


@pytest.mark.parametrize(
    ("place", "coast_near"),
    [
        ((51.12, 1.31), (51.114, 1.37)),  # South Foreland by Dover
        ((-34.35, 18.5), (-34.357, 18.497)),  # Cape of Good Hope
        ((-16.8, 179.9), (-16.79, 180.0)),  # Taveuni, on the date line
    ],
)
def test_a_coast_is_where_it_is(place, coast_near):
    frame = frame_at(*place)
    kinds, lines = lines_within(frame, np.array([-40 * KM, -40 * KM]), np.array([40 * KM, 40 * KM]))
    coast = np.concatenate([line for kind, line in zip(kinds, lines, strict=True) if kind == 0])
    x, y = plan_point(frame, *coast_near)
    assert np.hypot(coast[:, 0] - x, coast[:, 1] - y).min() < 8 * KM  # vertices, not the line: kilometres apart


def test_nothing_in_the_middle_of_an_ocean():
    block = ArrayBlock()
    assert not add_world(block, frame_at(-48.0, -125.0), np.array([0.0, KM]), np.array([0.0, KM]))
    assert block.manifest == {}


def test_no_frame_no_world():
    assert not add_world(ArrayBlock(), None, np.zeros(3), np.zeros(3))


def test_lines_stay_near_their_box():
    low, high = np.array([-300 * KM, -200 * KM]), np.array([300 * KM, 200 * KM])
    _, lines = lines_within(frame_at(47.0, 8.0), low, high)
    for line in lines:
        inside = ((line >= low - 500) & (line <= high + 500)).all(axis=1)
        assert inside[1:-1].all()


def test_a_point_beyond_the_date_line_is_near():
    x, y = plan_point(frame_at(0.0, 179.5), 0.0, -179.5)
    assert x == pytest.approx(np.radians(1.0) * RADIUS) and y == 0.0
