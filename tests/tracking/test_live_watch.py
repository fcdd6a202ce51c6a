"""A stream says once per target what cannot be true of it."""

from __future__ import annotations

import json

import numpy as np

from jink.io.loading import Reading
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings


def said(places, step=4.0, **settings):
    """What is said of a target that is seen at these places (m)."""
    tracks = LiveTracks(Reading(), Settings(sensor_sd={"position": 20.0}, **settings))
    for k, (x, y) in enumerate(places):
        tracks.take([json.dumps({"id": "A", "time": step * k, "x": float(x), "y": float(y)}).encode()])
    return [note for note in tracks.notes if note.startswith("warning")]


def straight(speed, count=60):
    rng = np.random.default_rng(0)
    return np.column_stack([4.0 * speed * np.arange(count), np.zeros(count)]) + rng.normal(0, 20.0, (count, 2))


def test_a_flight_raises_nothing():
    assert said(straight(200.0)) == []


def test_two_targets_under_one_name_are_said_once():
    places = straight(6.0)
    places[1::2] += 4e4
    found = said(places, kind="vessel")
    assert len(found) == 1 and "several targets under one name" in found[0]
    assert said(places, kind="vessel", check=False) == []


def test_a_jet_is_no_ship():
    found = said(straight(60.0), kind="vessel")
    assert any("another kind" in note and "37.5 m/s" in note for note in found)
