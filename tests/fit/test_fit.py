"""jink fit on a scenario: it gains on runs it has not seen, and its file comes back as the same filter."""

from __future__ import annotations

from pathlib import Path

import pytest

import jink
from jink.fit import fit
from jink.io.errors import InputError
from jink.scenarios import SCENARIOS
from jink.scenarios.table import simulation_table


def test_fit_gains_on_fresh_runs_and_round_trips(tmp_path):
    found = fit("lee-2003", "imm-cv-ca", objective="normalised", runs=60, check_runs=100, starts=1)
    assert found.after < found.before
    assert found.gain
    assert found.race.figure("fitted", "normalised_position").value < 0.5
    path = tmp_path / "fitted.json"
    found.save(path)
    again = jink.load(path)
    assert again.numbers == pytest.approx(found.filter.numbers)
    assert again.fitted["scenario"] == "lee-2003"


def test_refusals():
    with pytest.raises(InputError, match="there is no file"):
        fit("nowhere.csv")
    with pytest.raises(InputError, match="is a folder, but none that jink track wrote"):
        fit(str(Path(__file__).parent))
    with pytest.raises(InputError, match="did you mean imm"):
        fit("lee-2003", "imx")


def test_a_fit_on_several_scenarios_says_which_one_it_was_checked_on():
    both = fit("random-turns,random-accelerations", "kalman-cv", runs=12, check_runs=10, starts=1)
    assert any("the check used random-turns alone" in line for line in both.warnings)
    one = fit("random-turns", "kalman-cv", runs=12, check_runs=10, starts=1)
    assert not any("alone" in line for line in one.warnings)


def test_a_fit_that_is_worse_than_what_is_run_without_it_says_so(tmp_path):
    made = SCENARIOS["random-turns"].simulate(12, 3)
    path = tmp_path / "radar.csv"
    simulation_table(made).select("target", "time", "x", "y").write_csv(path)
    found = fit(path, filter="kalman-cv", starts=1)
    assert "imm-corrected" in found.race.tallies
    assert any(
        "runs imm-corrected, which is better on held-out data in log-likelihood" in each for each in found.warnings
    )
