"""Whether plots come from an antenna that turns is told from their azimuths and times."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from jink.tracking.antenna import antenna_of


def looks(rng, turns=40, per_turn=30, period=4.0, sense=1.0, stamps=0):
    """Times and azimuths (rad) of plots that an antenna sees; stamps: times are rounded to so many of a turn."""
    place = np.sort(rng.random((turns, per_turn)), axis=1)
    time = period * (np.arange(turns)[:, None] + place)
    if stamps:
        time = period / stamps * np.floor(time * stamps / period)
    azimuth = sense * 2 * np.pi * place + 1.0 + 2e-3 * rng.standard_normal(place.shape)
    return time.ravel(), (azimuth % (2 * np.pi)).ravel()


@pytest.mark.parametrize("period", [None, 4.0, 4.03])
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("per_turn, stamps", [(5, 0), (30, 0), (400, 0), (100, 16), (100, 32)])
def test_its_period_and_sense_are_found(per_turn, stamps, sense, period):
    time, azimuth = looks(np.random.default_rng(per_turn), per_turn=per_turn, sense=sense, stamps=stamps)
    found = antenna_of(time, azimuth, period)
    assert found is not None and found.clockwise == (sense > 0)
    assert found.period == pytest.approx(4.0, rel=1e-2 if stamps else 3e-3)


def test_an_antenna_that_turns_unevenly_is_one_too():
    """A turn takes 4 ± 0.2 s, as in wind."""
    rng = np.random.default_rng(2)
    time, azimuth = looks(rng)
    knots = np.cumsum(np.r_[0.0, rng.normal(4.0, 0.2, 40)])
    found = antenna_of(np.interp(time, 4.0 * np.arange(41), knots), azimuth, 4.0)
    assert found is not None and found.together > 0.95


@pytest.mark.parametrize("period", [None, 4.0])
@pytest.mark.parametrize("how", ["at once", "at once, sorted", "random", "one target", "few", "other"])
def test_others_are_none(how, period):
    rng = np.random.default_rng(5)
    time, azimuth = looks(rng)
    if how.startswith("at once"):
        time = 4.0 * np.repeat(np.arange(40), 30)
        azimuth = rng.uniform(0, 2 * np.pi, (40, 30))
        azimuth = (np.sort(azimuth, axis=1) if "sorted" in how else azimuth).ravel()
    elif how == "random":
        time = np.sort(rng.uniform(0, 160, time.size))
    elif how == "one target":
        time, azimuth = 4.0 * np.arange(100), 1.0 + 1e-3 * np.arange(100)
    elif how == "few":
        time, azimuth = time[:20], azimuth[:20]
    elif period:
        period = 5.0
    else:
        # each plot is right by itself, and three in ten are another's
        azimuth = np.where(rng.random(time.size) < 0.3, rng.uniform(0, 2 * np.pi, time.size), azimuth)
    assert antenna_of(time, azimuth, period) is None


def test_the_example_s_radar_stamps_plots_otherwise():
    plots = pl.read_csv(Path(__file__).parents[2] / "examples" / "radar.csv").sort("time_s")
    assert antenna_of(plots["time_s"].to_numpy(), np.radians(plots["azimuth_deg"].to_numpy()), 4.0) is None
