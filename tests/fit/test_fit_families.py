"""One filter fitted on two random families reaches what it must on fresh draws of them, and on a scenario it never
saw.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import jink
from benchmarks.efficiency import FAMILIES, against
from benchmarks.families import REACH, fitted, scored

STORED = Path(__file__).resolve().parents[2] / "benchmarks" / "families.json"
PUBLISHED = {family.scenario: family.published for family in FAMILIES}


def assert_reached(filter, scenario, runs, errors):
    """Within so many standard errors of the efficiencies to reach."""
    square = scored(filter, scenario, runs, seed=11)
    for k in (0, 1):
        value, se = against(PUBLISHED[scenario][k], square[:, k])
        assert value < REACH[scenario][k] + errors * se, (scenario, k, value, se)


@pytest.mark.parametrize("scenario", REACH)
def test_the_filter_that_is_kept(scenario):
    filter = jink.load(STORED)
    assert filter.fitted["scenario"] == "random-accelerations,random-turns"
    assert_reached(filter, scenario, 300, 3)


def test_a_fit_on_few_runs(capsys):
    filter, record = fitted("joint", 30, 0)
    assert "12 parameters fitted" in capsys.readouterr().out
    assert record["runs"] == 30
    for scenario in ("random-accelerations", "random-turns"):
        assert_reached(filter, scenario, 200, 4)
