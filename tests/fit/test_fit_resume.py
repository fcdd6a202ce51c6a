"""A fit that is stopped and taken up again ends where it would have ended; what is not a number is said by name."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import pytest

import jink
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS
from jink.fit.checkpoint import Checkpoint
from jink.fit.data import from_scenarios
from jink.fit.objectives import Likelihood, NotFinite, Tracking
from jink.fit.optimise import Search, State
from jink.fit.parameters import Parameters
from jink.io.errors import InputError
from jink.models.tracks import Tracks


@pytest.fixture(scope="module")
def turns():
    """70 training runs of random turns: batches of 6,000 and of all rows."""
    return from_scenarios(["random-turns"], 70, 0, 10).tracks


def begun(name, tracks, **options):
    filter = FILTERS[name](Purpose(sensor=jink.Position(sd=50.0), kind="fighter", sd=50.0)).filter
    return Search(Parameters(filter), Tracking(), tracks, starts=2, **options)


@pytest.mark.parametrize("name", ["imm-cv-ct", "input-estimation"])
def test_taken_up_again_it_ends_where_it_would_have_ended(name, turns):
    """Whatever the evaluation it was interrupted at, with a gradient and without, through a file's JSON."""
    tracks = turns if name == "imm-cv-ct" else turns.some(np.arange(5))
    through = begun(name, tracks).run()
    assert not through.partial
    for stop in (3, through.evaluations - 2):
        count = 0

        def interrupt(words, stage, stages, stop=stop):
            nonlocal count
            count += 1
            if count == stop:
                raise KeyboardInterrupt

        first = begun(name, tracks, report=interrupt)
        half = first.run()
        assert half.partial and half.interrupted
        assert half.evaluations == stop
        kept = State(**json.loads(json.dumps(asdict(first.state))))
        again = begun(name, tracks, state=kept).run()
        assert not again.partial
        assert again.evaluations == through.evaluations
        np.testing.assert_array_equal(again.u, through.u)
        assert again.value == through.value


def test_cut_short_it_keeps_the_best_so_far(turns):
    search = begun("imm-cv-ct", turns, deadline=0.0)
    found = search.run()
    assert found.partial and not found.interrupted
    assert found.evaluations == 1
    start = search.parameters.filter(search.parameters.start)
    assert found.value <= Tracking().value(start, turns)


def test_one_parameter_without_a_gradient(turns):
    """Golden section, since CMA-ES needs two."""
    filter = FILTERS["input-estimation"](Purpose(sensor=jink.Position(sd=50.0), kind="fighter")).filter
    parameters = Parameters(filter, fixed=["false_alarm"])
    assert len(parameters) == 1
    tracks = turns.some(np.arange(10))
    found = Search(parameters, Tracking(), tracks).run()
    for step in (-0.5, 0.5):
        assert found.value < Tracking().value(parameters.filter(found.u + step), tracks)


def test_a_checkpoint_of_other_data(tmp_path, turns):
    path = tmp_path / "kept.json"
    search = begun("imm-cv-ct", turns)
    mine = Checkpoint.of(path, search.parameters, Tracking(), turns, 0, 3)
    mine.write(State(stage=1, u=[0.0]))
    assert mine.read().stage == 1
    other = Checkpoint.of(path, search.parameters, Tracking(), turns.some(np.arange(5)), 0, 3)
    with pytest.raises(InputError, match="different data"):
        other.read()
    with pytest.raises(InputError, match="different objective and seed"):
        Checkpoint.of(path, search.parameters, Likelihood(), turns, 1, 3).read()
    path.write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match="does not hold a checkpoint of jink fit"):
        mine.read()


def test_a_figure_that_is_no_number_is_named(monkeypatch):
    """Where a search begins that is an error; on the way such a place is passed by and counted."""
    from jink.fit import objectives

    true = objectives.gradient

    def without_one(*given, **more):
        value, slope = true(*given, **more)
        value[1] = np.nan
        return value, slope

    monkeypatch.setattr(objectives, "gradient", without_one)
    time = np.tile(np.arange(20.0), 3)
    z = np.random.default_rng(0).normal(0, 10.0, (60, 1))
    tracks = Tracks(time, z, np.arange(4) * 20, owner=np.array(["a", "b", "c"]))
    motion = jink.ConstantVelocity(acceleration_sd=1.0)
    parameters = Parameters(jink.Kalman(motion, jink.Position(sd=10.0, axes=1)))
    with pytest.raises(NotFinite, match=r"track 1 \(of b\) is not finite"):
        Search(parameters, Likelihood(), tracks).run()


def test_derivatives_that_are_no_numbers_are_named_and_passed_by(monkeypatch, turns):
    from jink.fit import objectives

    true, count = objectives.gradient, 0

    def sometimes(*given, **more):
        nonlocal count
        count += 1
        value, slope = true(*given, **more)
        if count % 4 == 0:
            slope[1, 7] = np.nan
        return value, slope

    monkeypatch.setattr(objectives, "gradient", sometimes)
    few = turns.some(np.arange(20))
    search = begun("imm-cv-ct", few)
    found = search.run()
    words, number = found.stumbled
    assert number > 0
    assert words.startswith(f"the derivative by {search.parameters.names[1]} of track 7")
    assert found.value < Tracking().value(search.parameters.filter(search.parameters.start), few)
