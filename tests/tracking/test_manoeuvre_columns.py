"""What `manoeuvring` and `segment` say of tracks whose accelerations are known."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_array_equal
from scipy.stats import ncx2

import jink
from jink._engine import native
from jink.catalogue.targets import KINDS
from jink.io.errors import InputError
from jink.tracking.manoeuvring import GRAVITY, Manoeuvres, Moving, Segments, between

TURN = slice(150, 210)  # s
CLIMB = slice(300, 330)


def flight(g: float, climb_g: float = 0.0, sd: float = 5.0, seed: int = 1) -> pl.DataFrame:
    """200 m/s for 450 s, one row a second: a turn of so many g, later a pull-up of so many g."""
    rng, time = np.random.default_rng(seed), np.arange(450.0)
    rate = np.zeros(450)
    rate[TURN] = g * GRAVITY / 200.0
    course = np.cumsum(rate)
    up = np.zeros(450)
    up[CLIMB] = climb_g * GRAVITY
    z = 3000.0 + np.cumsum(np.cumsum(up))
    x, y = 200.0 * np.cumsum(np.cos(course)), 200.0 * np.cumsum(np.sin(course))
    seen = [values + rng.normal(0, sd, 450) for values in (x, y, z)]
    return pl.DataFrame({"target": "a", "time": time, "x": seen[0], "y": seen[1], "z": seen[2]})


@pytest.mark.parametrize("dimensions, error", [(1, 1e-3), (2, 0.02)])
def test_the_probability_beyond_a_threshold_is_that_of_noncentral_chi_square(dimensions, error):
    rng = np.random.default_rng(0)
    mean, variance = rng.uniform(0, 2, 2000), 10.0 ** rng.uniform(-4, 1, 2000)
    wanted = ncx2.sf(0.5**2 / variance, dimensions, mean**2 / variance)
    # a velocity of this size and variance a second after one of zero, in modes that manoeuvre
    velocity = np.zeros((dimensions, 4000))
    velocity[-1, 2000:] = mean
    moving = Moving(
        time=np.repeat([0.0, 1.0], 2000),
        new=np.ones(4000, bool),
        mode=np.ones(4000),
        velocity=(velocity,),
        variance=(np.r_[np.zeros(2000), variance],),
        acceleration=(None,),
        spread=(None,),
    )
    rows = np.arange(2000)
    (found,) = between(moving, Manoeuvres((0.5, 0.5), 4.0), rows, rows + 2000)
    assert np.abs(found - wanted).max() < error


@pytest.mark.parametrize("components", [1, 2])
def test_velocity_and_acceleration_are_weighed_as_the_textbook_says(components):
    """Against the formulas, row by row, missing values among them."""
    rng, count = np.random.default_rng(components), 37
    time, mode = np.cumsum(rng.uniform(0.0, 3.0, count)), rng.uniform(0, 1, count)
    velocity, acceleration = rng.normal(0, 3, (2, components, count))
    variance, spread = 10.0 ** rng.uniform(-2, 1, (2, count))
    mode[5] = velocity[0, 9] = acceleration[0, 20] = np.nan
    first = np.maximum(np.arange(count) - rng.integers(0, 3, count), 0)
    moving = Moving(time, np.ones(count, bool), mode, (velocity,), (variance,), (acceleration,), (spread,))
    (found,) = between(moving, Manoeuvres((0.7, 0.7), 4.0, (0.2, 0.2)), first, np.arange(count))
    for k in range(count):
        elapsed = time[k] - time[first[k]]
        T, still = (elapsed, False) if elapsed >= 1e-3 else (4.0, True)
        change = (velocity[:, k] - velocity[:, first[k]]) / T
        doubt = 1e12 if still else (variance[k] + variance[first[k]]) / T**2
        straight = np.sqrt(max(change @ change - components * doubt, 0.0)) / (1.0 + doubt / 0.7**2)
        own = acceleration[:, k] / mode[k]
        wide = max((spread[k] + np.mean(acceleration[:, k] ** 2)) / mode[k] - np.mean(own**2), 1e-9)
        mean = own + wide / (wide + doubt) * (change - own)
        tails = [
            ncx2.sf(0.7**2 / v, components, m**2 / v)
            for m, v in ((straight, 0.2 / T), (np.linalg.norm(mean), min(wide, doubt)))
        ]
        wanted = (1.0 - mode[k]) * tails[0] + mode[k] * tails[1]
        assert np.isnan(found[k]) if np.isnan(wanted) else abs(found[k] - wanted) < 0.02


def test_a_turn_manoeuvres_in_the_plane_and_a_climb_in_the_vertical():
    tracks = jink.track(flight(0.15, 0.1), smooth=True, sensor_sd={"position": 5.0, "z": 5.0})
    level, up = tracks["manoeuvring"].to_numpy(), tracks["manoeuvring_vertical"].to_numpy()
    assert level[TURN][5:-5].min() > 0.9 and up[TURN][5:-5].max() < 0.3
    assert up[CLIMB][5:-5].min() > 0.9 and level[CLIMB][5:-5].max() < 0.3
    assert tracks["segment"][-1] == 2 and tracks["segment"][180] == 1


def test_the_threshold_is_the_kind_s_or_the_one_that_is_asked_for():
    data = flight(0.15)
    options = {"smooth": True, "sensor_sd": 5.0}
    usual = jink.track(data, **options)["manoeuvring"].to_numpy()
    same = jink.track(data, manoeuvre_g=KINDS["aircraft"].manoeuvre_g[0], **options)["manoeuvring"].to_numpy()
    higher = jink.track(data, manoeuvre_g=0.3, **options)["manoeuvring"].to_numpy()
    assert_array_equal(usual, same)
    assert usual[180] > 0.9 > 0.1 > higher[180]
    with pytest.raises(InputError, match="manoeuvre_g is 0"):
        jink.track(data, manoeuvre_g=0.0)


def test_noise_of_a_poor_radar_is_no_manoeuvre():
    data = pl.concat([flight(0.0, sd=100.0, seed=k).with_columns(target=pl.lit(str(k))) for k in range(20)])
    tracks = jink.track(data.filter(pl.col("time") % 10 == 0), sensor_sd={"position": 100.0, "z": 100.0})
    # mean share of rows above one half: 0.05 of rows at most, of 900 rows that are correlated over some ten each
    assert (tracks["manoeuvring"] > 0.5).mean() < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 90)


def test_rows_one_by_one_and_in_pieces_have_the_same_segments():
    rng = np.random.default_rng(5)
    probability = np.clip(0.5 + 0.4 * np.sin(np.arange(400) / 7.0) + rng.normal(0, 0.2, 400), 0, 1)
    time, new = np.cumsum(rng.uniform(0.5, 2.0, 400)), np.arange(400) == 0
    whole = Segments(4.0).numbers(probability, time, new)
    one_by_one = Segments(4.0)
    assert_array_equal(whole, [one_by_one.next(p, t, n) for p, t, n in zip(probability, time, new, strict=True)])
    assert whole[-1] > 5
    for back in (False, True):
        whole, cut, ahead = Segments(4.0, back).numbers(probability, time, new), Segments(4.0, back), 12
        got = []
        for a, b in pairwise([0, 57, 58, 200, 333, 400]):
            some, more = slice(a, min(b + ahead, 400)), min(ahead, 400 - b)
            got.append(cut.numbers(probability[some], time[some], new[some], more))
        assert_array_equal(whole, np.concatenate(got))


def test_a_stretch_that_does_not_last_is_none():
    probability = np.r_[np.zeros(10), np.ones(3), np.zeros(10), np.ones(10), np.zeros(10)]
    time, new = np.arange(43.0), np.arange(43) == 0
    late, back = (Segments(4.0, back).numbers(probability, time, new) for back in (False, True))
    assert_array_equal(np.flatnonzero(np.diff(late)) + 1, [27, 37])
    assert_array_equal(np.flatnonzero(np.diff(back)) + 1, [23, 33])


def test_what_is_said_to_manoeuvre_does():
    """Flights seen by 20 m: their velocity is hardly known at first, and never much better than the threshold."""
    rng = np.random.default_rng(3)
    turns = {str(k): float(g) for k, g in enumerate(rng.uniform(0.0, 0.15, 60))}
    data = pl.concat([flight(g, sd=20.0, seed=int(k)).with_columns(target=pl.lit(k)) for k, g in turns.items()])
    tracks = jink.track(data, sensor_sd=20.0)
    window = KINDS["aircraft"].manoeuvre_seconds
    inside = pl.min_horizontal("time", TURN.stop) - pl.max_horizontal(pl.col("time") - window, TURN.start)
    mean_g = inside.clip(0.0) / window * pl.col("target").replace_strict(turns)
    true = (mean_g > KINDS["aircraft"].manoeuvre_g[0]).alias("true")
    sure = tracks.filter(pl.col("manoeuvring") > 0.9).select("target", "time", true)
    assert sure.height > 100
    # so many flights that the share's standard error, over flights, is about .03
    assert sure["true"].mean() > 0.85
    beginning = tracks.filter(pl.col("time").is_between(2.0, 20.0))
    assert (beginning["manoeuvring"] > 0.5).mean() < 0.05


@pytest.mark.parametrize("ahead", [0.0, 7.0])
def test_windows_reach_as_far_as_they_may(ahead):
    rng = np.random.default_rng(3)
    time = 1.5e9 + np.cumsum(rng.choice([0.0, 1.0, 4.0, 20.0], 300))
    begins = rng.random(300) < 0.05
    begins[0] = True
    first, last = native.windows(time, begins, 7.0, ahead)
    track = np.cumsum(begins)
    for row in range(300):
        own = np.flatnonzero(track == track[row])
        within = own[(time[own] >= time[row] - 7.0) & (time[own] <= time[row] + ahead)]
        assert first[row] == max(min(within[0], row - 1), own[0])
        assert last[row] == (row if not ahead else max(within[-1], min(row + 1, own[-1])))
