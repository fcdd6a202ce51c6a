"""Identification of rules: the evaluator against the textbook filter, fitness by hand, recovery, stopping and
resuming.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.fuzzy import Rules, fuzzy_imm

from jink.learn import genetic as ga
from jink.learn.data import from_scenario
from jink.learn.evolution import Chromosome, cma_es, genetic, search
from jink.learn.interacting import identify_modes
from jink.learn.population import errors_of, errors_of_rules, normalised, stacked
from jink.models.fuzzy import PUBLISHED, FuzzyRules

pymoo = pytest.importorskip("pymoo")
STAY = np.full((3, 3), 0.015) + np.diag([0.955] * 3)
SMALL = ga.Settings(generations=6, population=24, most_rules=6)


def test_the_evaluator_is_the_textbook_filter():
    runs = from_scenario("lee-2003", 3, 1).axes_apart()
    runs.z[1, 30:33] = np.nan
    tables = [Rules.table(t.table(unit=1000.0), 1000.0, 1e6) for t in PUBLISHED["lee-2003"]]
    start = [float(t.q(np.zeros(1), np.zeros(1))[0]) for t in tables]
    expected = fuzzy_imm(runs.time[0], runs.z, np.array([[runs.sd**2]]), tables, STAY, np.array([0.6, 0.2, 0.2]), start)
    found = errors_of_rules(PUBLISHED["lee-2003"], runs, transition=STAY, probability=[0.6, 0.2, 0.2])
    for axis, truth, rms in ((0, runs.position, found.position), (1, runs.velocity, found.velocity)):
        error = expected.x[:, 3:, axis] - truth[:, 3:, 0]
        assert_allclose(rms[0, 3:], np.sqrt((error**2).mean(axis=0)), rtol=1e-9)


def test_candidates_do_not_see_each_other():
    runs = from_scenario("lee-2003", 2, 1)
    candidates = [[PUBLISHED["lee-2003"][k]] for k in (0, 1, 2, 0, 2)]
    tables, count = stacked(candidates)
    together = errors_of(tables, count, runs)
    for i, modes in enumerate(candidates):
        assert_allclose(errors_of(*stacked([modes]), runs).position[0], together.position[i], rtol=1e-13)
    assert_array_equal(errors_of(tables, count, runs, threads=1).position, together.position)


def test_published_rules_give_the_published_figures():
    runs = from_scenario("lee-2003", 500, 4)
    errors = errors_of_rules(PUBLISHED["lee-2003"], runs, transition=STAY, probability=[0.6, 0.2, 0.2])
    position, velocity = normalised(errors, runs)
    assert position[0] == pytest.approx(0.5198, abs=4 * 0.0045 / np.sqrt(5))
    assert velocity[0] == pytest.approx(0.0847, abs=4 * 0.0009 / np.sqrt(5))


def test_fitness_by_hand():
    position, velocity = np.array([[1.0, 2.0, 3.0]]), np.array([[0.5, 0.5, 7.0]])
    error = ga.total_error(position, velocity)
    assert error == pytest.approx(10.0)  # sqrt(6² + 8²)
    assert ga.fitness(error, np.array([4]), 0.95) == pytest.approx(0.95 / 11 + 0.05 / 5)


def test_the_fitness_reported_is_that_of_the_rules_returned():
    runs = ga.training_runs(10.0, runs=4, scans=30)
    said = []
    rules = ga.identify(10.0, runs, settings=SMALL, progress=lambda g, fitness, n: said.append((fitness, n)))
    errors = errors_of_rules([rules], runs)
    error = np.hypot(np.nansum(errors.position), np.nansum(errors.velocity)) / 1000
    assert said[-1] == (pytest.approx(0.95 / (error + 1) + 0.05 / (len(rules) + 1)), len(rules))
    assert [f for f, _ in said] == sorted(f for f, _ in said)
    assert rules.trained is not None and rules.trained.seeds == (0,)


def test_chromosomes_mean_what_the_paper_says():
    low, high = ga.noise_interval(10.0, 1.0)
    assert (low, high) == (5.5, 11.0)
    encoding = ga.Encoding(rules=3, reach=(1000.0, 2000.0), least=low, most=high)
    x = np.full((2, 18), 0.5)
    x[0, 15:], x[1, 15:] = (0, 1, 1), (0, 0, 0)
    x[0, 5:10] = (1.0, 0.0, 0.0, 1.0, 1.0)
    tables, count = encoding.decode(x)
    assert count.ravel().tolist() == [2, 1]  # a string without rules keeps the first
    assert_allclose(tables[0, 0, 0], [1000.0, 20.0, -2000.0, 4000.0, 121.0])
    assert_allclose(tables[0, 0, 1], [0.0, 200.0, 0.0, 400.0, 8.25**2])


def test_a_small_known_system_is_recovered():
    """Two rules found among six by their answers alone, number and surface."""
    truth = FuzzyRules(((-600.0, 0.0), (600.0, 0.0)), ((200.0, 500.0), (200.0, 500.0)), (36.0, 121.0))
    encoding = ga.Encoding(rules=6, reach=(1000.0, 1000.0), least=5.5, most=11.0)
    grid = np.linspace(-1000, 1000, 15)
    r, dr = (a.ravel() for a in np.meshgrid(grid, grid))
    wanted = np.sqrt(truth.variance(r, dr))

    def loss(x):
        tables, count = encoding.decode(x)
        out = []
        for table, n in zip(tables[:, 0], count[:, 0], strict=True):
            error = np.sqrt(np.mean((np.sqrt(FuzzyRules.of(table[:n]).variance(r, dr)) - wanted) ** 2))
            out.append(-ga.fitness(error, n, 0.95))
        return np.array(out)

    best, _ = search(loss, genetic(encoding.chromosome, population=100, mutation=0.03, seed=3), 40)
    found = encoding.rules_of(best)
    assert len(found) == 2
    assert np.sqrt(np.mean((np.sqrt(found.variance(r, dr)) - wanted) ** 2)) < 0.6  # of a range of 5


@pytest.mark.parametrize("optimiser", ["ga", "cma"])
def test_stopped_and_resumed_gives_the_same_rules(optimiser, tmp_path):
    settings, runs = replace(SMALL, optimiser=optimiser), ga.training_runs(10.0, runs=2, scans=30)
    whole = ga.identify(10.0, runs, settings=settings, seed=5)
    checkpoint = tmp_path / "search.npz"

    def interrupt(generation, fitness, rules):
        if generation == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ga.identify(10.0, runs, settings=settings, seed=5, checkpoint=checkpoint, progress=interrupt)
    resumed = ga.identify(10.0, runs, settings=settings, seed=5, checkpoint=checkpoint)
    assert resumed == whole
    assert ga.identify(10.0, runs, settings=settings, seed=6) != whole
    with pytest.raises(ValueError, match="was written by another search"):
        ga.identify(10.0, runs, settings=replace(settings, population=30), seed=5, checkpoint=checkpoint)


def test_a_resumed_search_evaluates_nothing_again(tmp_path):
    chromosome, calls = Chromosome(genes=4), []

    def loss(x):
        calls.append(len(x))
        return ((x - 0.3) ** 2).sum(axis=1)

    path = tmp_path / "search.npz"
    first = search(loss, cma_es(chromosome, population=8), 10, checkpoint=path)
    again = search(loss, cma_es(chromosome, population=8), 10, checkpoint=path)
    assert len(calls) == 10 and again[1] == first[1]
    assert_array_equal(again[0], first[0])


def test_rules_and_transition_found_together_beat_three_constants():
    runs, fresh = from_scenario("lee-2003", 30, 1), from_scenario("lee-2003", 200, 2)
    found = identify_modes(runs, rules=1, population=16, generations=40)
    assert_allclose(np.asarray(found.transition).sum(axis=1), 1)
    usual = [FuzzyRules.constant(sd, 1000.0) for sd in (1.0, 10.0, 100.0)]
    ours = normalised(errors_of_rules(found.modes, fresh, transition=found.transition), fresh)
    theirs = normalised(errors_of_rules(usual, fresh, transition=STAY), fresh)
    assert ours[0][0] < theirs[0][0] and ours[1][0] < theirs[1][0]


def test_settings_are_those_of_table_1():
    s = ga.Settings()
    table = (s.generations, s.most_rules, s.population, s.crossover, s.mutation, s.weight)
    assert table == (100, 50, 500, 0.9, 0.01, 0.95)
    with pytest.raises(ValueError, match="optimiser: expected one of ga, cma"):
        ga.Settings(optimiser="tabu")
    with pytest.raises(ValueError, match="weight: expected a number from 0 to 1"):
        ga.Settings(weight=2.0)
