"""The default fit, learning and race on every scenario, and on a file that jink simulate wrote for every sensor."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from jink.compare.race import compare
from jink.fit import fit
from jink.scenarios import RADARS, SCENARIOS

SCANS = 40  # of a shortened scenario
SENSORS = ("position", "position-velocity", *RADARS)


def short(name):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=min(SCANS, scenario.schedule.count)))


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_default_race(name):
    race = compare(short(name), runs=2)
    assert {"raw", "kalman-cv", "imm"} <= set(race.tallies)
    assert all(math.isfinite(race.figure(each, "position_rmse").value) for each in ("raw", "kalman-cv", "imm"))


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_default_fit(name):
    found = fit(short(name), runs=20, check_runs=2, starts=1, minutes=0.02)
    assert found.after <= found.before and "fitted" in found.race.tallies
