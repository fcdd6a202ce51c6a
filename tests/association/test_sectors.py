"""An antenna that turns clockwise is followed sector by sector."""

from itertools import pairwise

import numpy as np
import pytest

import jink
from jink.association.sectors import Sectors

PERIOD, SD = 12.0, 60.0
# along the cut of a turn, across it clockwise, across it anticlockwise, and far from it
PLACE = np.array([[100.0, 20e3], [-6e3, 30e3], [6e3, 42e3], [-20e3, -30e3]])
VELOCITY = np.array([[0.0, 150.0], [200.0, 0.0], [-200.0, 0.0], [150.0, 100.0]])


def looks(turns, rng, detection=1.0, false=0):
    """Times, plots and targets (−1: false) of all looks, in order of time."""
    found = []
    for target, (place, velocity) in enumerate(zip(PLACE, VELOCITY, strict=True)):
        time = np.linspace(0, PERIOD * turns, 12_000 * turns // 10)
        there = place + velocity * time[:, None]
        behind = time / PERIOD - np.unwrap(np.arctan2(there[:, 0], there[:, 1])) / (2 * np.pi)
        for k in np.flatnonzero(np.floor(behind[1:]) > np.floor(behind[:-1])):
            if rng.random() < detection:
                found.append((time[k], *(there[k] + SD * rng.normal(size=2)), target))
    for _ in range(false * turns):
        x, y = rng.uniform(-6e4, 6e4, 2)
        turn = rng.integers(turns)
        found.append((PERIOD * (turn + np.arctan2(x, y) / (2 * np.pi) % 1), x, y, -1))
    found = np.array(sorted(found))
    return found[:, 0], found[:, 1:3], found[:, 3].astype(int)


def tracker(clutter, half=6e4):
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=0.5), jink.Position(sd=SD))
    radar = jink.Radar(detection=0.9, clutter_per_scan=clutter, area=(-half, half, -half, half))
    return jink.Tracker(filter, radar, targets=4, new_per_hour=10, report=0.0)


def test_each_target_is_looked_at_once_in_a_turn_also_where_it_crosses_the_cut():
    time, z, target = looks(20, np.random.default_rng(1))
    sectors = Sectors(tracker(1e-3), PERIOD)
    pictures = [
        p
        for a, b in zip(np.r_[0:81:9, len(z)][:-1], np.r_[0:81:9, len(z)][1:], strict=True)
        for p in sectors.take(time[a:b], z[a:b])
    ]
    pictures += sectors.finish()
    last = pictures[-1]
    assert last.confirmed.sum() == 4 == len(last)
    # every look was taken by the track of its target, and existence never fell: there was no miss
    taken = {int(n): int(i) for p in pictures for n, i in zip(p.plot, p.ids, strict=True) if n >= 0}
    assert sorted(taken) == list(range(len(z)))
    for k in range(4):
        assert len({taken[n] for n in np.flatnonzero(target == k)[2:]}) == 1
    sure = {i: [] for i in last.ids}
    for p in pictures:
        for i, r, age in zip(p.ids, p.existence, p.age, strict=True):
            if age >= 3 and i in sure:
                sure[i].append(r)
    assert min(min(r) for r in sure.values()) > 0.99


def test_turn_by_turn_a_target_that_crosses_the_cut_is_missed_or_seen_twice():
    """What sectors are for: the same looks, cut where the antenna points north."""
    time, z, _ = looks(20, np.random.default_rng(1))
    whole = tracker(1e-3)
    least = 1.0
    for k in range(20):
        mine = (time // PERIOD).astype(int) == k
        p = whole.scan(PERIOD * (k + 0.5), z[mine], times=time[mine])
        if k > 3:
            least = min(least, p.existence[p.age >= 3].min())
    assert least < 0.99


def test_in_clutter_with_misses_all_are_held():
    time, z, _ = looks(20, np.random.default_rng(2), detection=0.9, false=25)
    follower = tracker(25)
    sectors = Sectors(follower, PERIOD, count=8)
    pictures = sectors.take(time, z) + sectors.finish()
    last = pictures[-1]
    assert last.confirmed.sum() == 4
    truth = PLACE + VELOCITY * last.times[last.confirmed].mean()
    apart = np.linalg.norm(last.positions[last.confirmed][:, None] - truth, axis=2)
    assert sorted(apart.argmin(axis=1)) == [0, 1, 2, 3]
    assert follower.clutter_per_scan["radar"] == pytest.approx(25, rel=0.4)
    assert [p.report["sector"] for p in pictures[:3]] == [pictures[0].report["sector"] + k for k in range(3)]


@pytest.mark.parametrize("true", [0.9, 0.6])
def test_the_detection_probability_is_learned_from_hits_one_sector_early_too(true):
    time, z, _ = looks(150, np.random.default_rng(4), detection=true)
    t = tracker(1e-3, half=4e5)
    sectors = Sectors(t, PERIOD, count=4)
    edges = np.searchsorted(time, PERIOD / 4 * np.arange(4 * 150 + 1))
    for a, b in pairwise(edges):
        sectors.take(time[a:b], z[a:b])
    sectors.finish()
    # 4 targets, 150 turns: 4 standard errors are 0.08 at 0.6; 0.9 is what was declared, and nothing contradicts it
    assert t.detection["radar"] == pytest.approx(true, abs=0.08 if true < 0.9 else 0.0)


def test_a_sector_waits_until_the_next_one_has_closed():
    sectors = Sectors(tracker(1e-3), PERIOD, count=4)
    # 45°, 135° and 225°: sectors 0, 1 and 2
    first = sectors.take([1.5, 4.5], [[1e4, 1e4], [1e4, -1e4]])
    assert first == []
    closed = sectors.take([7.5], [[-1e4, -1e4]])
    assert [p.report["sector"] for p in closed] == [0]
    assert [p.report["sector"] for p in sectors.finish()] == [1, 2]


@pytest.mark.parametrize(
    "call, says",
    [
        (lambda s: s.take([1.0, 0.0], [[1.0, 2.0], [3.0, 4.0]]), "in order of time"),
        (lambda s: s.take([1.0], [[1.0, 2.0], [3.0, 4.0]]), "a time for each of 2 plots"),
        (lambda s: Sectors(s.tracker, 0.0), "period"),
        (lambda s: Sectors(s.tracker, 4.0, count=2), "count"),
        (lambda s: Sectors(s.tracker, 4.0, sensor="north"), "was not declared"),
    ],
)
def test_what_makes_no_sense_is_refused(call, says):
    with pytest.raises(ValueError, match=says):
        call(Sectors(tracker(1.0), PERIOD))
