"""A detection probability that was declared wrong is corrected by the tracks."""

from __future__ import annotations

import numpy as np
import pytest

import jink
from jink.association.detection import WEIGHT, Detections
from jink.scenarios.skies import sky_called

SKY = sky_called("sky-four")


def tracker(**radar):
    options = {"detection": 0.98, "clutter_per_scan": SKY.clutter, "area": SKY.area} | radar
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=0.02), jink.Position(sd=SKY.sd))
    return jink.Tracker(filter, jink.Radar(**options), targets=4, new_per_hour=18, stay=100.0, speed_sd=1.0)


def test_what_is_declared_stays_where_it_is_not_to_be_learned():
    made = tracker(learn_detection=False)
    for scan in SKY.run(0, 2).scans:
        made.scan(scan.time, scan.z)
    assert made.detection == {"radar": 0.98}


def test_what_is_declared_stays_where_it_is_true():
    for number in range(4):
        made = tracker(detection=0.9)
        for scan in SKY.run(number, 2).scans:
            made.scan(scan.time, scan.z)
            assert made.detection == {"radar": 0.9}


def test_an_outage_says_nothing_of_other_scans():
    found = Detections()
    for _ in range(5):
        found.take({"seen": 180, "sure": 200}, 0.9)
    found.take({"seen": 0, "sure": 200}, 0.9)
    assert found.probability(0.9) == 0.9


def test_a_sensor_that_sees_far_less_is_believed_in_the_end():
    found = Detections()
    for _ in range(80):
        found.take({"seen": 80, "sure": 200}, 0.9)
    assert found.probability(0.9) == pytest.approx(0.4, abs=0.02)


@pytest.mark.parametrize("declared", [0.7, 0.98])
def test_the_share_of_scans_with_a_plot_is_learned(declared):
    found = []
    for number in range(4):
        made = tracker(detection=declared)
        for scan in SKY.run(number, 2).scans:
            made.scan(scan.time, scan.z)
        found.append(made.detection["radar"])
    # some 220 track-scans a run, and what is declared counts as 10 more
    assert np.mean(found) == pytest.approx((10 * declared + 220 * 0.9) / 230, abs=3 * np.sqrt(0.09 / 880))


def test_a_track_is_counted_by_what_is_known_before_the_scan():
    """A sure track that is missed counts; one that is unsure does not, though its plot makes it sure."""
    made = tracker(detection=0.5, clutter_per_scan=1e-3)
    counts = []
    for k in range(9):
        counts.append(made.scan(float(k), [] if k in (6, 7) else [[100.0 + k, 100.0]]).report)
    # five plots in scans 0 to 4
    assert [(each["sure"], each["seen"]) for each in counts[:7]] == [(0, 0)] * 5 + [(1, 1), (1, 0)]
    made = tracker(detection=0.99, clutter_per_scan=1e-3)
    for k in range(9):
        report = made.scan(float(k), [] if k in (6, 7) else [[100.0 + k, 100.0]]).report
    assert (report["sure"], report["seen"]) == (0, 0)


def test_only_what_contradicts_a_declared_probability_corrects_it():
    # 0.85 of 100 lies 1.7 standard errors from 0.9, of 400 3.3
    assert Detections(85.0, 100.0).probability(0.9) == 0.9
    assert Detections(340.0, 400.0).probability(0.9) == pytest.approx((0.9 * WEIGHT + 340) / (WEIGHT + 400))
    assert Detections(0.0, 1e9).probability(0.9) == 0.05
    assert Detections(1e9, 1e9).probability(0.9) == 0.99
    assert Detections().probability(0.9) == 0.9


def test_what_was_learned_goes_with_the_saved_state():
    one = tracker()
    scans = SKY.run(1, 2).scans
    for scan in scans[:30]:
        one.scan(scan.time, scan.z)
    other = tracker()
    other.load(one.save())
    for scan in scans[30:50]:
        a, b = one.scan(scan.time, scan.z), other.scan(scan.time, scan.z)
        np.testing.assert_array_equal(a.existence, b.existence)
    assert one.detection == other.detection != {"radar": 0.98}
