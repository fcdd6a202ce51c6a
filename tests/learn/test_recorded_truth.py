"""Recorded tracks as truth: what is known of them, how radars see them, and a corrector that learns on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose

import jink
from jink.compare.recorded import read
from jink.io.errors import InputError
from jink.learn.learning import BASE, LEARNED, learn
from jink.learn.plane_inputs import Weighing, pairs_of
from jink.learn.plane_recorded import halves, padded
from jink.learn.recorded import Flown, Radar, drawn, local_cubic, sampled, seen

FLIGHTS = str(Path(__file__).parents[2] / "examples" / "flights.parquet")


def turning(count=400, noise=0.0):
    """A target that turns with 3 m/s² after half of the time, seen every second."""
    time = np.arange(float(count))
    heading = 0.015 * np.maximum(time - count / 2, 0.0)
    velocity = 200.0 * np.stack([np.cos(heading), np.sin(heading), 0 * heading], axis=1)
    position = np.cumsum(np.vstack([np.zeros(3), 0.5 * (velocity[1:] + velocity[:-1])]), axis=0)
    return time, position + noise * np.random.default_rng(0).standard_normal(position.shape), velocity


def test_the_cubic_knows_a_turn_from_noisy_positions():
    time, z, velocity = turning(noise=5.0)
    z[50, :2] += 5e3  # a gross error
    position, found, acceleration = local_cubic(time, z)
    inner = slice(20, -20)
    assert np.sqrt(np.mean((position - turning()[1])[inner] ** 2)) < 2.5
    assert np.sqrt(np.mean((found - velocity)[inner] ** 2)) < 1.0
    pull = np.hypot(*acceleration[:, :2].T)
    assert np.median(pull[30:180]) < 0.6 and 2.5 < np.median(pull[220:-20]) < 3.5
    assert np.isnan(position[0]).all() and np.isnan(position[-1]).all()


def test_nothing_is_known_where_positions_are_sparse():
    time, z, _ = turning()
    assert np.isnan(local_cubic(10.0 * time, z)[0]).all()


def test_pieces_end_where_the_truth_is_unknown_for_a_minute():
    known = np.ones(400, bool)
    known[100:170], known[300:320] = False, False
    rows = sampled(np.arange(400.0), known, 4.0, 10)
    assert [(run[0], run[-1]) for run in rows] == [(0, 96), (170, 396)]
    assert all((np.diff(run) >= 4).all() for run in rows)
    assert not sampled(np.arange(400.0), known, 4.0, 100)


@pytest.mark.parametrize("azimuth", [None, 0.05])
@pytest.mark.parametrize("axes", [2, 3])
def test_plots_err_as_their_covariance_says(azimuth, axes):
    time, z, _ = turning()
    flight = Flown("a", time, *local_cubic(time, z))
    radar = Radar(period=1.0, sd=40.0, azimuth_sd=azimuth, axes=axes)
    tracks = seen([flight] * 40, radar, np.random.default_rng(1))
    off = tracks.z[:, :2] - tracks.truth[:, :2]
    P = tracks.covariance[:, :2, :2]
    assert tracks.z.shape[1] == axes and len(tracks) == 40 and tracks.rows > 10_000
    assert_allclose(np.einsum("ni,nij,nj->n", off, np.linalg.inv(P), off).mean(), 2.0, rtol=0.03)
    smallest = np.linalg.eigvalsh(P)  # that of the range: the radar is far off
    assert_allclose(smallest if azimuth is None else smallest[:, 0], 1600.0, rtol=1e-6)


def test_drawn_radars_differ_and_err_grossly_as_they_say():
    rng = np.random.default_rng(2)
    some = [drawn(rng, 2) for _ in range(300)]
    assert 0.25 < np.mean([r.azimuth_sd is None for r in some]) < 0.55
    assert min(r.period for r in some) < 1.0 and max(r.period for r in some) > 11.0
    time, z, _ = turning()
    tracks = seen([Flown("a", time, *local_cubic(time, z))] * 40, Radar(period=1.0, sd=10.0, gross=0.01), rng)
    far = np.abs(tracks.z - tracks.truth[:, :2]).max(axis=1) > 60.0
    assert 0.004 < far.mean() < 0.012


def counted(*how):
    """Without the rows that are only remembered."""
    pairs = pairs_of(*how)
    return pairs.some(pairs.weight[:, 0] > 0)


def test_squares_of_turns_and_of_lost_tracks_count_as_said():
    rng, B, S = np.random.default_rng(3), 30, 120
    time, z, velocity = turning(S)
    p = np.broadcast_to(z[:, :2], (B, S, 2))
    v = np.broadcast_to(velocity[:, :2], (B, S, 2))
    a = np.where((np.arange(S) > S / 2)[:, None], 3.0 / np.sqrt(2.0), 0.0) * np.ones((B, S, 2))
    filter = jink.default_filter("aircraft", jink.Position(sd=50.0))
    seen_ = p + 50.0 * rng.standard_normal(p.shape)
    rows = np.broadcast_to(time, (B, S)), seen_, 2500.0 * np.eye(2), p, v, a
    for weighing in (Weighing(), Weighing(turning=0.5), Weighing(turning=0.5, cap=0.5)):
        pairs = counted(filter, *rows, weighing)
        count = (pairs.weight * pairs.error**2).reshape(-1, 2, 2).sum(axis=2)
        assert_allclose(count.mean(axis=0), 1.0, rtol=1e-4)
        share = count.reshape(B, -1, 2)[:, S // 2 - 4 :].sum(axis=(0, 1)) / count.sum(axis=0)
        if weighing.turning and np.isinf(weighing.cap):
            plain = counted(filter, *rows)
            there = (plain.weight * plain.error**2).reshape(-1, 2, 2).sum(axis=2).reshape(B, -1, 2)
            usual = there[:, S // 2 - 4 :].sum(axis=(0, 1)) / there.sum(axis=(0, 1))
            assert_allclose(share, 0.5 + 0.5 * usual, rtol=1e-3)
    whole = counted(filter, *rows, Weighing())
    capped = counted(filter, *rows, Weighing(cap=0.5))
    nees = np.einsum("ni,nij,nj->n", whole.error, whole.inverse, whole.error) / 4
    ratio = (capped.weight / whole.weight)[:, 0]
    high, low = np.argmax(nees), np.argmin(nees)
    assert_allclose(ratio[low] / ratio[high], (1 + nees[high] / 0.5) / (1 + nees[low] / 0.5), rtol=1e-3)


def test_rows_of_unequal_tracks_are_filled_up():
    time, z, _ = turning()
    flight = Flown("a", time, *local_cubic(time, z))
    short = Flown("b", *(getattr(flight, n)[:150] for n in ("time", "position", "velocity", "acceleration")))
    tracks = seen([flight, short], Radar(period=2.0, sd=20.0), np.random.default_rng(4))
    t, measured, R, p, _, a = padded(tracks)
    assert t.shape == measured.shape[:2] == R.shape[:2] and np.isnan(measured[1, -1]).all() and np.isnan(a[1, -1]).all()
    assert_allclose(p[1, : tracks.lengths[1]], tracks.truth[tracks.at(1), :2])


@pytest.fixture(scope="module")
def learned():
    return learn("corrector", FLIGHTS, families=20, epochs=1, seed=3)


def test_a_corrector_learns_on_half_of_the_flights(learned, tmp_path):
    recording = read(FLIGHTS, "aircraft", 3, positions=True)
    one, other = ({each.target for each in half} for half in halves(recording))
    assert one and other and not one & other
    assert learned.race.runs == len(other)
    assert f"{len(one)} recorded targets" in learned.training
    for metric in ("position_rmse", "velocity_rmse"):
        ratio = learned.race.figure(LEARNED, metric).value / learned.race.figure(BASE, metric).value
        assert 0.8 < ratio < 1.01  # measured .999 and .984
    learned.save(tmp_path / "corrector.json")
    again = jink.load(tmp_path / "corrector.json")
    assert again.corrector == learned.filter.corrector
    assert [name for name, _ in again.corrector.trained.figures][2:] == [
        "position error ÷ default's, unseen recorded tracks",
        "velocity error ÷ default's, unseen recorded tracks",
    ]


def test_the_same_seed_learns_the_same(learned):
    assert learn("corrector", FLIGHTS, families=20, epochs=1, seed=3).filter.corrector == learned.filter.corrector


def test_too_few_targets_are_refused(tmp_path):
    few = pl.read_parquet(FLIGHTS)
    few.filter(pl.col("icao24").is_in(sorted(set(few["icao24"]))[:5])).write_parquet(tmp_path / "few.parquet")
    with pytest.raises(InputError, match="expected at least 8 targets with dense positions"):
        learn("corrector", str(tmp_path / "few.parquet"), families=20, epochs=1)
    flight = Flown("a", np.arange(50.0), *(np.full((50, 2), np.nan) for _ in range(3)))
    with pytest.raises(ValueError, match="no track has 30 known positions 1 s apart"):
        seen([flight], Radar(period=1.0, sd=10.0), np.random.default_rng(0))
