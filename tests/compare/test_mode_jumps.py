"""The delay of modes behind the target: by hand on few scans, and on a scenario of choi-2001."""

from __future__ import annotations

import math

import numpy as np
import pytest

from jink.compare import simulated
from jink.compare.mode_jumps import count, mode_jump_delay, phases
from jink.compare.race import compare
from jink.compare.scores import JACKKNIFE, Tally
from jink.scenarios import SCENARIOS


def tally_of(leaders, runs: int = 4) -> Tally:
    """Runs whose leading mode, of three, is the same scan by scan."""
    tally = Tally()
    tally.responses["runs"] = np.bincount(np.arange(runs) % JACKKNIFE, minlength=JACKKNIFE).astype(float)
    probability = np.full((runs, len(leaders), 3), 0.1)
    probability[:, np.arange(len(leaders)), leaders] = 0.8
    count(tally, np.arange(runs), probability)
    return tally


def test_scans_until_the_mode_leads_that_leads_at_the_end_of_the_phase():
    leaders = [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 0, 0]
    figure = mode_jump_delay(tally_of(leaders), [(0, 4), (4, 10), (10, 12)])
    assert figure.value == pytest.approx((2 + 0) / 2) and figure.se == 0  # from 4 to 6, and at once


def test_a_start_on_the_wrong_mode_counts_as_a_jump():
    assert mode_jump_delay(tally_of([0, 0, 0, 1, 1, 1]), [(0, 6)]).value == 3


def test_no_jump_no_delay():
    assert math.isnan(mode_jump_delay(tally_of([0] * 6), [(0, 3), (3, 6)]).value)
    assert math.isnan(mode_jump_delay(Tally(), [(0, 3)]).value)


def test_phases_are_those_of_the_scenario():
    """choi-2001's test 4: accelerations in scans 4-6, 11-13, 17-18; scan k's input acts until scan k + 1."""
    found = phases(SCENARIOS["choi-2001-4"].simulate(3), 2)
    assert found == [(2, 4), (4, 7), (7, 11), (11, 14), (14, 17), (17, 19)]
    assert phases(SCENARIOS["random-turns"].simulate(3), 2) == []
    assert phases(SCENARIOS["choi-2001-1"].simulate(3), 2) == [(2, 20)]


def test_the_race_has_it_of_every_filter_with_modes():
    """By hand from the engine's probabilities: choi-2001-3 changes once, from a circle to a line."""
    race = compare("choi-2001-3", ["singer", "imm"], runs=20, seed=1)
    s = SCENARIOS["choi-2001-3"].simulate(20, 1)
    estimate = race.entrants["imm"].filter.filter(**s.batch())
    leads = estimate.mode_probability.reshape(20, 20, -1).mean(axis=0)
    (begin, middle), (_, end) = phases(s, 2)
    first = leads[middle - (middle - begin) // 3 : middle].sum(axis=0).argmax()
    last = leads[end - (end - middle) // 3 : end].sum(axis=0).argmax()
    assert first != last
    before = (leads[begin:middle].argmax(axis=1) == first).argmax()
    after = (leads[middle:end].argmax(axis=1) == last).argmax()
    # the first phase is a jump where the track starts on another mode
    jumps = [after] if leads[begin].argmax() == first else [before, after]
    body = race.as_dict()["filters"]
    assert body["imm"]["mode_jump_delay"]["value"] == pytest.approx(np.mean(jumps)) and after > 0
    assert "mode_jump_delay" not in body["singer"] and "mode_jump_delay" not in body["raw"]


def test_no_delay_where_runs_change_at_scans_of_their_own(monkeypatch):
    """A chunk of one run has changes that it shares with itself alone."""
    monkeypatch.setattr(simulated, "CHUNK_ROWS", 180)
    race = compare("random-turns", ["gpb2"], runs=2, seed=1)
    assert "mode_jump_delay" not in race.figures("gpb2") and "modes" not in race.tallies["gpb2"].responses


def test_runs_add_up_in_whatever_chunks():
    rng = np.random.default_rng(0)
    probability = rng.dirichlet(np.ones(3), (30, 8))
    whole, parts = Tally(), Tally()
    count(whole, np.arange(30), probability)
    for rows in (slice(0, 7), slice(7, 30)):
        count(parts, np.arange(30)[rows], probability[rows])
    np.testing.assert_allclose(whole.responses["modes"], parts.responses["modes"], rtol=1e-13)
