"""Heights that nothing climbs to and back are misses; climbs, level changes and what cannot be told stay."""

import numpy as np
import polars as pl
import pytest

import jink
from jink.tracking.height_jumps import CLIMB, LEAST, LONGEST, impossible_heights

AIRCRAFT = 300.0  # m/s
FOOT = 0.3048


def _found(height, time=None, new=None, fastest=AIRCRAFT) -> tuple[list[int], int]:
    height = np.array(height, float)
    time = np.arange(height.size, dtype=float) if time is None else np.array(time, float)
    new = np.arange(height.size) == 0 if new is None else np.array(new, bool)
    bad, jumps = impossible_heights(time, height, new, fastest)
    return np.flatnonzero(bad).tolist(), jumps


def _bad(*arguments, **more) -> list[int]:
    return _found(*arguments, **more)[0]


LEVEL = [3000.0] * 20


def test_few_heights_far_above_or_below_are_impossible():
    assert _bad([*LEVEL, 10_668.0, *LEVEL]) == [20]
    assert _bad([*LEVEL, 10_668.0, np.nan, 10_668.0, *LEVEL]) == [20, 22]
    assert _bad([*LEVEL, -30.0, *LEVEL]) == [20]
    climbing = 8.0 * np.arange(40.0)
    climbing[15] += 9_000.0
    assert _bad(climbing) == [15]


def test_a_climb_as_steep_as_the_kind_flies_is_believed():
    steep = CLIMB * AIRCRAFT * np.arange(30.0)
    assert _bad([*LEVEL, *(3000.0 + steep), *(3000.0 + steep[::-1]), *LEVEL]) == []
    assert _bad([*LEVEL, *[3000.0 + 0.9 * LEAST] * 5, *LEVEL]) == []


def test_what_may_be_the_truth_stays():
    assert _bad([*LEVEL, *[9000.0] * 20]) == []  # no way back
    assert _bad([*LEVEL, *[9000.0] * 3, *LEVEL[:2]]) == []  # as likely as what follows
    assert _bad([9000.0, *LEVEL]) == []  # nothing before it
    assert _bad([*LEVEL, 9000.0, *[6000.0] * 20]) == []  # before and after do not agree
    long = np.arange(0.0, 2.0 * LONGEST, 5.0)
    assert _bad([*LEVEL * 3, *0.0 * long, *LEVEL * 3], np.r_[:60, 60 + long, 200:260.0]) == []
    assert _bad([3000.0, 9000.0, np.nan]) == [] == _bad([]) == _bad([np.nan] * 5)


def test_jumps_that_are_left_are_counted():
    assert _found([*LEVEL, *[9000.0] * 20]) == ([], 1)
    assert _found([9000.0, *LEVEL, *[9000.0] * 3, *LEVEL]) == ([21, 22, 23], 1)
    assert _found([*LEVEL, *LEVEL])[1] == 0 == _found([*LEVEL, 9000.0, *LEVEL])[1]


def test_another_part_is_another_matter():
    new = np.isin(np.arange(41), (0, 20))
    assert _bad([*LEVEL, 10_668.0, *LEVEL], new=new) == []


@pytest.mark.parametrize("wrong", [1, 4])
def test_the_track_stays_at_its_height_and_the_heights_are_counted(wrong):
    time = np.arange(120.0)
    height = np.full(120, 3000.0) + np.random.default_rng(0).normal(0, 4.0, 120)
    height[60 : 60 + wrong] = 35_000 * FOOT
    rows = pl.DataFrame({"id": "a", "time": time, "lat": 48.0 + 0.001 * time, "lon": 2.0, "alt_m": height})
    found = jink.track(rows, details=True)
    assert found.summary["cleaning"]["impossible_heights"] == wrong
    assert found.tracks.height == 120 and np.abs(found.tracks["altitude"].to_numpy() - 3000.0).max() < 50.0
    missing = found.tracks["altitude_status"][60 : 60 + wrong]
    assert set(missing) == {"predicted"} and found.tracks["status"][60] == "updated"
