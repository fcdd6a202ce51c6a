"""Rules along and across the track: candidates run by the engine as each filter alone, and what a search finds."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose

import jink
from jink.filters.loading import load
from jink.learn.candidates import errors_along_track, filter_of
from jink.learn.data import from_scenario
from jink.learn.interacting import ModesEncoding, identify_modes
from jink.learn.learning import learn
from jink.report.learn_table import rules
from jink.scenarios import by_name


@pytest.fixture(scope="module")
def runs():
    return from_scenario("random-turns", 4, 3)


def encoding(modes, rules=2):
    return ModesEncoding(modes=modes, rules=rules, reach=(300.0, 400.0), least=0.05, most=40.0, along_track=True)


def alone(filter, runs):
    """RMS errors per scan and axis of one filter, from the scan after the second measurement on."""
    est = filter.filter(**runs.batch())
    x = est.x.reshape(len(runs), -1, 2 * runs.axes)
    off = [x[..., k::2] - truth for k, truth in enumerate((runs.position, runs.velocity))]
    return [np.sqrt((d[:, 2:] ** 2).mean(axis=(0, 2))) for d in off]


@pytest.mark.parametrize("modes", [1, 3])
def test_candidates_are_as_each_filter_alone(runs, modes):
    of = encoding(modes)
    x = np.random.default_rng(modes).uniform(0, 1, (11, of.chromosome.genes))
    tables, transition = of.decode(x)
    found = errors_along_track(tables, transition, runs)
    assert np.isnan(found.position[:, :2]).all()
    for i in (0, 7, 8, 10):
        position, velocity = alone(filter_of(tables[i], transition[i], runs), runs)
        assert_allclose(found.position[i, 2:], position, rtol=1e-9)
        assert_allclose(found.velocity[i, 2:], velocity, rtol=1e-9)


def test_the_result_does_not_depend_on_threads(runs):
    of = encoding(2)
    tables, transition = of.decode(np.random.default_rng(1).uniform(0, 1, (17, of.chromosome.genes)))
    one, two = (errors_along_track(tables, transition, runs, threads=n) for n in (1, 2))
    assert np.array_equal(one.position, two.position, equal_nan=True)


def test_rules_across_the_track_have_no_sign():
    of = encoding(2)
    tables, _ = of.decode(np.random.default_rng(1).uniform(0, 1, (50, of.chromosome.genes)))
    assert tables.shape == (50, 2, 2, 2, 5)
    assert tables[:, :, 0, :, 0].min() < 0 <= tables[:, :, 1, :, 0].min()


def test_a_search_finds_rules_better_than_those_it_starts_from(runs):
    some = from_scenario("random-turns", 5, 3)
    first, later = (
        identify_modes(some, interval=(0.1, 60.0), population=12, generations=n, along_track=True, seed=2)
        for n in (1, 25)
    )
    assert len(later.across) == len(later.modes) == 3
    figure = [
        (lambda f: sum(np.nanmean(e) for e in alone(f, runs)))(
            filter_of(
                np.array([[a.table(), c.table()] for a, c in zip(m.modes, m.across, strict=True)]), m.transition, runs
            )
        )
        for m in (first, later)
    ]
    assert figure[1] < 0.95 * figure[0]


def test_one_axis_has_no_track(runs):
    of = encoding(1)
    tables, transition = of.decode(np.full((1, of.chromosome.genes), 0.5))
    with pytest.raises(ValueError, match="runs: expected two or three axes, got one"):
        errors_along_track(tables, transition, runs.along([0]))


@pytest.mark.parametrize("name", ["fuzzy-imm", "fuzzy-kalman"])
def test_learned_saved_and_tracked_with(name, tmp_path):
    learned = learn(
        name,
        "random-turns",
        runs=8,
        check_runs=6,
        optimiser="together",
        along_track=True,
        generations=2,
        population=12,
        rules=2,
    )
    assert all(motion.across is not None for motion in learned.filter.motions)
    assert any("across the track:" in line for line in rules(learned))
    learned.save(tmp_path / "rules.json")
    seen = by_name("random-turns").simulate(1, 3)
    rows = {"target": np.zeros(len(seen.time[0])), "time": seen.time[0], "x": seen.z[0, :, 0], "y": seen.z[0, :, 1]}
    tracked = jink.track(pl.DataFrame(rows), filter=load(tmp_path / "rules.json"), kind="fighter")
    assert np.isfinite(tracked["x"].to_numpy()[2:]).all()
