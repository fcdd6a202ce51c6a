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


def test_what_is_declared_stays_unless_it_is_to_be_learned():
    made = tracker()
    for scan in SKY.run(0, 2).scans[:20]:
        made.scan(scan.time, scan.z)
    assert made.detection == {"radar": 0.98}


@pytest.mark.parametrize("declared", [0.7, 0.98])
def test_the_share_of_scans_with_a_plot_is_learned(declared):
    found = []
    for number in range(4):
        made = tracker(detection=declared, learn_detection=True)
        for scan in SKY.run(number, 2).scans:
            made.scan(scan.time, scan.z)
        found.append(made.detection["radar"])
    # some 250 track-scans a run, and what is declared counts as 30 more
    assert np.mean(found) == pytest.approx((30 * declared + 250 * 0.9) / 280, abs=3 * np.sqrt(0.09 / 1000))


def test_the_mean_of_a_beta_distribution():
    assert Detections(90.0, 100.0).probability(0.7) == pytest.approx((0.7 * WEIGHT + 90) / (WEIGHT + 100))
    assert Detections(0.0, 1e9).probability(0.9) == 0.05
    assert Detections(1e9, 1e9).probability(0.9) == 0.99


def test_what_was_learned_goes_with_the_saved_state():
    one = tracker(learn_detection=True)
    scans = SKY.run(1, 2).scans
    for scan in scans[:30]:
        one.scan(scan.time, scan.z)
    other = tracker(learn_detection=True)
    other.load(one.save())
    for scan in scans[30:50]:
        a, b = one.scan(scan.time, scan.z), other.scan(scan.time, scan.z)
        np.testing.assert_array_equal(a.existence, b.existence)
    assert one.detection == other.detection != {"radar": 0.98}
