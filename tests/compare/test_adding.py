"""Adding chunks of runs to shared rows, and taking an interrupted chunk back."""

import copy

import numpy as np
import pytest

from jink.compare import compare, simulated
from jink.compare.adding import add_at
from jink.compare.scores import Tally
from jink.scenarios import SCENARIOS


@pytest.mark.parametrize("shape", [(7,), (7, 3), (7, 2, 3)])
def test_sums_are_those_of_numpy_to_the_bit(shape):
    """Runs without a row of their own, several times, and not at all."""
    rng = np.random.default_rng(1)
    for runs in (np.arange(5), np.arange(30), np.sort(rng.integers(0, 40, 60)), np.zeros(0, dtype=int)):
        values = rng.normal(size=(len(runs), *shape[1:])) * 10.0 ** rng.integers(-8, 8, (len(runs), *shape[1:]))
        mine, theirs = rng.normal(size=(2, *shape))
        theirs[...] = mine
        add_at(mine, runs, values)
        np.add.at(theirs, runs % len(theirs), values)
        assert (mine == theirs).all()


def test_what_was_added_is_taken_back():
    tally, runs = Tally(groups=4, scan_groups=3), np.arange(5)
    tally.add(runs, "old", np.arange(5.0), np.ones(5))
    tally.add_distances(runs, np.ones((5, 2)))
    before = copy.deepcopy(tally)
    take_back = tally.before(np.arange(5, 7))
    for name in ("old", "new"):
        tally.add(np.arange(5, 7), name, np.ones(2), np.ones(2))
        tally.add_curve(np.arange(5, 7), name, np.ones((2, 3)))
        tally.add_response(np.arange(5, 7), name, np.ones((2, 3)))
    tally.add_distances(np.arange(5, 7), np.ones((2, 2)))
    tally.runs[1] += 1
    tally.costs.append((1.0, 2))
    assert tally.bins.sum() == before.bins.sum() + 4
    take_back()
    for store in ("totals", "counts", "curves", "responses"):
        mine, theirs = getattr(tally, store), getattr(before, store)
        assert mine.keys() == theirs.keys()
        assert all((mine[name] == theirs[name]).all() for name in mine)
    assert (tally.bins == before.bins).all() and (tally.runs == before.runs).all() and tally.costs == before.costs


def test_interrupted_within_a_chunk_all_filters_keep_the_runs_before_it(monkeypatch):
    scenario = SCENARIOS["random-turns"]
    monkeypatch.setattr(simulated, "CHUNK_ROWS", 10 * scenario.schedule.count)
    count, calls = simulated._count, []

    def stop(tally, *given):
        count(tally, *given)
        calls.append(tally)
        if len({id(each) for each in calls}) * 2 == len(calls) - 1:
            raise KeyboardInterrupt

    whole = compare(scenario, ["kalman-cv"], 20, seed=3)
    monkeypatch.setattr(simulated, "_count", stop)
    race = compare(scenario, ["kalman-cv"], 30, seed=3)
    assert race.partial and race.runs == 20
    for name in whole.tallies:
        assert race.figure(name, "position_rmse") == whole.figure(name, "position_rmse")
        assert race.tallies[name].runs.sum() == 20
