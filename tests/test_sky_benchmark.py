"""The skies' benchmark judges every figure that has a limit, and its figures are what they are called."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import skies, sky_radars, sky_switches
from benchmarks.sky_measures import figures, measure, side_by_side, tracker_of
from benchmarks.sky_rows import MUST, Row, most, rows
from jink.metrics.figure import Figure
from jink.metrics.skies import Picture, sky_figures
from jink.scenarios.skies import sky_called


def test_a_figure_beyond_its_limit_is_said_to_be_missed():
    found = {"gospa": Figure(2.0, 0.2), "separation": Figure(1.5, 0.01), "ms": Figure(0.3, math.nan)}
    text, missed = skies.judged("A", found, most(gospa=1.9, ms=0.4) | {"separation": (0.95, 1.4)})
    assert missed == 2
    assert "MISS gospa 2, wanted ≤ 1.9, within one standard error" in text
    assert "MISS separation 1.5, wanted 0.95 to 1.4\n" in text
    assert "reached ms ≤ 0.4" in text


def test_a_figure_that_is_not_a_number_is_missed():
    assert skies.judged("A", {"swaps": Figure(math.nan, math.nan)}, most(swaps=0.25))[1] == 1


def test_ratio_is_of_the_same_runs():
    true, wrong = {"gospa": [3.0, 4.0, 5.0]}, {"gospa": [3.3, 4.4, 5.5]}
    value, se = figures(wrong, true)["ratio"]
    assert value == pytest.approx(1.1)
    assert se == pytest.approx(0.0, abs=1e-12)  # every run is worse by the same factor
    assert figures(true)["gospa"].value == pytest.approx(math.sqrt(50 / 3))


def test_tracks_that_change_places_are_counted():
    ids = np.arange(2)
    truth = [Picture(ids, np.array([[0.0, 50.0], [0.0, -50.0]]))] * 40
    kept = [Picture(ids, np.array([[0.0, 60.0], [0.0, -60.0]]))] * 40
    swapped = kept[:35] + [Picture(ids[::-1], kept[0].points)] * 5
    expected = {"separation": 1.2, "separation throughout": 1.2, "swaps": 0.0}
    assert side_by_side(truth, kept, 300.0) == pytest.approx(expected)
    assert side_by_side(truth, swapped, 300.0)["swaps"] == 1.0


def test_separation_is_of_the_end_of_the_flight_side_by_side_and_of_all_of_it():
    ids = np.arange(2)
    truth = [Picture(ids, np.array([[0.0, d], [0.0, -d]])) for d in [500.0] * 10 + [50.0] * 20 + [500.0] * 5]
    far = Picture(ids, np.array([[0.0, 100.0], [0.0, -100.0]]))
    near = Picture(ids, np.array([[0.0, 60.0], [0.0, -60.0]]))
    found = side_by_side(truth, [far] * 20 + [near] * 15, 1000.0)
    assert (found["separation"], found["separation throughout"]) == pytest.approx((1.2, 1.6))


def test_duplicates_are_tracks_beside_a_track_of_the_same_target():
    truth = Picture(np.arange(1), np.zeros((1, 2)))
    found = Picture(np.arange(3), np.array([[5.0, 0.0], [0.0, 40.0], [500.0, 0.0]]))
    assert sky_radars.duplicates(truth, found, 100.0) == (1, 3)


def test_every_row_of_the_aims_has_a_limit_and_runs():
    assert all(row.limits for row in MUST)
    assert all(row.limits for row in rows([], False) if row.against)
    found = figures(measure(replace(MUST[4], runs=2), 3))
    assert set(MUST[4].limits) <= set(found)


def test_every_switch_has_a_cause():
    sky = sky_called("sky-parallel-50")
    found, counted = [], 0.0
    for run in sky.runs(4, 3):
        tracker = tracker_of(sky, Row("C", "sky-parallel-50", 1))
        pictures = [Picture(p.ids[p.confirmed], p.positions[p.confirmed]) for p in sky_switches.scanned(tracker, run)]
        found += sky_switches.switches(sky, run, pictures)
        counted += sky_figures([run.truth], [pictures], sky.cutoff).switches.value
    assert len(found) == counted > 1
    # two aircraft that live from the first scan to the last exchange tracks
    assert {each.cause for each in found} == {"exchanged"} and not any(each.young for each in found)
