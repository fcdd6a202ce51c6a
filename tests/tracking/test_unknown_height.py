"""Radars that measure no heights: slant ranges are not silently those along the ground."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest

import jink
from jink.catalogue.choose import EARTH_RADIUS
from jink.io.errors import InputError
from jink.tracking.unknown_height import TargetHeight, is_slant

HEIGHTS = np.array([500.0, 2000.0, 4000.0, 6500.0])


def seen(name: str, seed: int = 0) -> tuple[pl.DataFrame, np.ndarray]:
    """Straight flights at several heights past a radar of 70 m and .068 degrees every 12 s; their ground positions."""
    rng, time = np.random.default_rng(seed), 12.0 * np.arange(60)
    tables, truth = [], []
    for k, height in enumerate(HEIGHTS):
        x, y = 200.0 * time - 70e3, np.full(60, 25e3)
        slant = np.sqrt(x**2 + y**2 + height**2) + rng.normal(0, 70.0, 60)
        azimuth = np.degrees(np.arctan2(x, y)) + rng.normal(0, 0.068, 60)
        tables.append(pl.DataFrame({"target": str(k), "time": time, name: slant, "azimuth_deg": azimuth % 360.0}))
        truth.append(np.column_stack([x, y]))
    return pl.concat(tables), np.concatenate(truth)


def errors(tracks: pl.DataFrame, truth: np.ndarray) -> np.ndarray:
    off = tracks.sort("target", "time").select("x", "y").to_numpy() - truth
    return off.reshape(len(HEIGHTS), -1, 2)[:, 8:]


def test_the_mean_and_the_variance_are_those_over_the_prior():
    height, rng = TargetHeight(4000.0, 3500.0), np.random.default_rng(1)
    drawn = np.clip(rng.normal(4000.0, 3500.0, 400_000), 0.0, None)
    for slant in (20e3, 60e3, 200e3, 400e3):
        # the triangle of the earth's centre, the radar and the target
        to_target = EARTH_RADIUS + np.minimum(drawn, 0.95 * slant)
        angle = np.arccos((EARTH_RADIUS**2 + to_target**2 - slant**2) / (2 * EARTH_RADIUS * to_target))
        ground = EARTH_RADIUS * angle
        mean, variance = (float(each[0]) for each in height.ground_range(np.array([slant])))
        # a clipped normal is not smooth, so 15 nodes give its mean to two hundredths of its sd
        assert mean == pytest.approx(ground.mean(), abs=0.03 * ground.std())
        assert variance == pytest.approx(ground.var(), rel=0.1)


def test_slant_ranges_are_corrected_and_their_sds_cover_the_errors():
    data, truth = seen("slant_range")
    found = jink.track(data, details=True)
    assert any("slant ranges without heights: targets are taken to be 3000" in n for n in found.summary["notes"])
    plain = jink.track(data, target_height="ground", details=True)
    assert not any("without heights" in note for note in plain.summary["notes"])
    off, before = errors(found.tracks, truth), errors(plain.tracks, truth)
    assert np.sqrt((off**2).sum(axis=2).mean()) < 0.8 * np.sqrt((before**2).sum(axis=2).mean())

    def inside(tracks: pl.DataFrame, errors: np.ndarray) -> float:
        sds = tracks.sort("target", "time").select("x_sd", "y_sd").to_numpy().reshape(len(HEIGHTS), -1, 2)[:, 8:]
        return float((np.abs(errors) <= 2.0 * sds).mean())

    assert inside(found.tracks, off) > 0.93 > 0.85 > inside(plain.tracks, before)


def test_far_slant_ranges_are_those_over_a_curved_earth():
    """At 400 km and 8 km of height the ground is 270 m nearer; a plane knew 80 m of it, with an sd of 30 m."""
    mean, variance = TargetHeight(8000.0, 2000.0).ground_range(np.array([400e3]))
    assert 400e3 - mean[0] == pytest.approx(270.0, abs=2.0)
    assert np.sqrt(variance[0]) == pytest.approx(
        400e3 * 2000.0 / (2 * EARTH_RADIUS) + 8000.0 * 2000.0 / 400e3, rel=0.02
    )


def test_ranges_that_do_not_say_what_they_are_are_named():
    data, _ = seen("range")
    found = jink.track(data, details=True)
    (note,) = (n for n in found.summary["notes"] if "ranges without heights are taken as ranges along the ground" in n)
    assert "--target-height" in note and "m too far out at 20 km" in note
    same = jink.track(data, target_height="3000,2500")
    assert same.equals(jink.track(data.rename({"range": "slant_range"})).select(same.columns))
    assert not any("heights" in n for n in jink.track(data, kind="vessel", details=True).summary["notes"])


def test_targets_without_heights_among_others_are_slant():
    data, _ = seen("range")
    height = pl.when(pl.col("target") == "2").then(None).otherwise(pl.col("target").cast(pl.Float64) * 2000.0 + 1000.0)
    found = jink.track(data.with_columns(altitude_m=height), details=True)
    assert any("slant ranges without heights" in n for n in found.summary["notes"])


def test_a_stream_takes_the_same_heights():
    data, _ = seen("slant_range")
    tracker = jink.LiveTracker(sensor_sd={"range": 70.0, "azimuth_deg": 0.068})
    rows = tracker.update_many(data.sort("time").to_dicts())
    whole = jink.track(data, sensor_sd={"range": 70.0, "azimuth_deg": 0.068})
    last = whole.filter(pl.col("time") == whole["time"].max()).sort("target")
    for row, wanted in zip(sorted(rows[-4:], key=lambda r: r["target"]), last.to_dicts(), strict=True):
        for name in ("x", "y", "x_sd", "y_sd"):
            assert row[name] == pytest.approx(wanted[name], rel=1e-6)
    assert any("slant ranges without heights" in note for note in tracker.notes)
    assert json.dumps(rows[-1])


@pytest.mark.parametrize("given", ["high", "4000", "-1,5", "1,nan"])
def test_heights_that_are_none_are_refused(given):
    with pytest.raises(InputError, match="target_height is"):
        TargetHeight.of(given)


def test_names_that_say_slant():
    assert is_slant("slant_range") and is_slant("RHO") and not is_slant("range") and not is_slant("rhodes")
