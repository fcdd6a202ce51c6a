"""The six benchmark trajectories against the published table, written down here a second time."""

import numpy as np
import pytest

from jink.metrics.draws import Draws
from jink.scenarios import SCENARIOS

G = 9.80665
# north, east, altitude, speed, course (degrees); begin, end, course change, lateral g of every turn
TABLE = {
    1: ((72947, 29474, 1258, 289.6, -153.4), [(60, 80, 63, 1.72), (110, 132, 109, 2.8)]),
    2: ((45705, -42864, 4572, 304.8, 180), [(30, 52, -90, 2.3), (100, 114, 90, 3.7)]),
    3: ((60944, 60944, 3048, 457, -135), [(30, 41, 45, 3.9), (75, 92, -90, 3.9)]),
    4: ((30480, 9130, 2286, 274, -90), [(30, 36, -45, 3.8), (70, 84, -136, 5.8)]),
    5: ((80950, 970, 1448, 274, 135), [(30, 38, 44, 4.85), (60, 72, -90, 6.85), (117, 130, -85, 5.84)]),
    6: (
        (65939, 29384, 1548, 426, 180),
        [(30, 43, 90, 6.84), (70, 85, -90, 5.5), (115, 127, 144, 5.8), (150, 157, -55, 6.83)],
    ),
}
# target, time, speed
SPEEDS = [
    (3, 92, 316),
    (3, 114, 274),
    (4, 84, 255),
    (4, 141, 411),
    (5, 30, 398),
    (6, 85, 309),
    (6, 115, 253),
    (6, 127, 209),
    (6, 150, 350),
    (1, 185, 289.6),
    (2, 185, 304.8),
]
# target, begin, end, altitude then
HEIGHTS = [(2, 55, 113, 3048), (4, 90, 141, 4570), (5, 131, 155, 4496), (6, 70, 85, 786)]


def path(number: int, time: np.ndarray):
    truth = SCENARIOS[f"benchmark-{number}"].truth(Draws(0, [0]))
    return [values[0] for values in truth.at(time[None, :])]


def lateral(v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Acceleration to the right of the course (g)."""
    return (a[:, 0] * v[:, 1] - a[:, 1] * v[:, 0]) / np.hypot(v[:, 0], v[:, 1]) / G


@pytest.mark.parametrize("number", TABLE)
def test_start(number):
    (north, east, altitude, speed, course), _ = TABLE[number]
    p, v, _ = path(number, np.array([0.0]))
    np.testing.assert_allclose(p[0], [east, north, altitude])
    np.testing.assert_allclose(np.linalg.norm(v[0]), speed)
    np.testing.assert_allclose(np.cos(np.arctan2(v[0, 0], v[0, 1]) - np.radians(course)), 1.0)


@pytest.mark.parametrize(("number", "turn"), [(n, turn) for n, (_, turns) in TABLE.items() for turn in turns])
def test_turns(number, turn):
    begin, end, change, g = turn
    time = np.linspace(begin - 1.0, end + 1.0, 2001)
    _, v, a = path(number, time)
    course = np.degrees(np.unwrap(np.arctan2(v[:, 0], v[:, 1])))
    inside = (time >= begin) & (time <= end)
    assert course[inside][-1] - course[inside][0] == pytest.approx(change, abs=1.0)
    load = np.abs(lateral(v, a))
    assert load[~inside].max() < 0.02
    peak = load.max() / g
    assert 0.85 < peak < 1.15
    rising = time[load > 0.9 * load.max()]
    assert 0.8 < rising[0] - begin < 3.0
    assert 0.8 < end - rising[-1] < 3.0


@pytest.mark.parametrize("number", TABLE)
def test_limits_and_straight_legs(number):
    time = np.linspace(0.0, 185.0, 18501)
    _, v, a = path(number, time)
    load = np.abs(lateral(v, a))
    assert load.max() < 7.0
    speed = np.linalg.norm(v, axis=1)
    along = (a * v).sum(axis=1) / speed / G
    assert np.abs(along).max() < 2.0
    turning = np.zeros(len(time), bool)
    for begin, end, _, _ in TABLE[number][1]:
        turning |= (time >= begin) & (time <= end)
    assert load[~turning].max() < 1e-6
    jerk = np.abs(np.diff(a, axis=0)).max() / 0.01
    assert jerk < 12 * G  # no jumps: the whole load takes a second or more


@pytest.mark.parametrize(("number", "time", "expected"), SPEEDS)
def test_speeds(number, time, expected):
    _, v, _ = path(number, np.array([float(time)]))
    np.testing.assert_allclose(np.linalg.norm(v[0]), expected, rtol=1e-9)


@pytest.mark.parametrize(("number", "begin", "end", "altitude"), HEIGHTS)
def test_heights(number, begin, end, altitude):
    p, v, _ = path(number, np.array([begin, end, 185.0]))
    np.testing.assert_allclose(p[:, 2], [TABLE[number][0][2], altitude, altitude], atol=1e-6)
    np.testing.assert_allclose(v[:, 2], 0.0, atol=1e-6)


def test_climb_rates():
    time = np.linspace(0.0, 185.0, 1851)
    assert path(2, time)[1][:, 2].min() == pytest.approx(-32.0, rel=0.01)
    assert path(5, time)[1][:, 2].max() == pytest.approx(275.0, rel=0.03)


def test_braking_and_acceleration():
    time = np.linspace(0.0, 185.0, 18501)
    for number, extreme, g in ((3, np.min, -1.1), (5, np.max, 0.42)):
        _, v, a = path(number, time)
        along = (a * v).sum(axis=1) / np.linalg.norm(v, axis=1) / G
        assert extreme(along) == pytest.approx(g, rel=0.05)
    _, v, a = path(3, np.array([92.0]))
    assert (a[0] @ v[0]) / np.linalg.norm(v[0]) / G == pytest.approx(-0.4, rel=0.05)
