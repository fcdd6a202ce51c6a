"""Two tracks that follow one target: the younger one ends after some scans, and two targets side by side do not."""

from __future__ import annotations

import numpy as np
import pytest

import jink

AREA = (0.0, 50e3, 0.0, 50e3)
STATE = np.array([20_000.0, 100.0, 20_000.0, 0.0])


def tracker(**rules):
    motion = jink.ConstantVelocity(acceleration_psd=1.0)
    # misses say little at so poor a detection, so that existence alone does not end the second track
    radar = jink.Radar(sd=50.0, detection=0.4, clutter_per_scan=5, area=AREA)
    # nothing is born, so that what is there was added
    made = jink.Tracker(jink.Kalman(motion, jink.Position(sd=50.0)), radar, targets=0, new_per_hour=0)
    for name, value in rules.items():
        setattr(made.rules, name, value)
    made.reset()
    return made


def at(scan, offset=0.0):
    return [STATE[0] + 4.0 * scan * STATE[1], STATE[2] + offset]


def twice(made):
    P = np.diag([50.0**2, 10.0**2] * 2)
    made.add(0.0, STATE, P)
    made.add(0.0, STATE, P)
    return made


def test_the_younger_of_two_tracks_of_one_target_ends():
    made, apart = twice(tracker()), twice(tracker(merge_after=0))
    merged = []
    for k in range(1, 6):
        picture = made.scan(4.0 * k, [at(k)])
        merged.append(picture.report["merged"])
        still = apart.scan(4.0 * k, [at(k)])
    assert merged == [0, 0, 0, 0, 1]
    assert list(picture.ids) == [0]
    assert list(still.ids) == [0, 1]


@pytest.mark.parametrize("after", [2, 3])
def test_scans_are_counted(after):
    made = twice(tracker(merge_after=after))
    for k in range(1, after):
        assert made.scan(4.0 * k, [at(k)]).report["merged"] == 0
    assert made.scan(4.0 * after, [at(after)]).report["merged"] == 1
    assert list(made.scan(4.0 * (after + 1), [at(after + 1)]).ids) == [0]


def test_the_count_goes_with_the_saved_state():
    made = twice(tracker(merge_after=3))
    for k in (1, 2):
        made.scan(4.0 * k, [at(k)])
    again = tracker(merge_after=3)
    again.load(made.save())
    assert again.scan(12.0, [at(3)]).report["merged"] == 1


def test_tracks_that_have_a_plot_each_are_two_targets():
    made = twice(tracker(merge_after=2))
    for k in range(1, 12):
        picture = made.scan(4.0 * k, [at(k, 15.0), at(k, -15.0)])
        assert picture.report["merged"] == 0
    assert list(picture.ids) == [0, 1]
