"""The default fit, learning and race on every scenario, and on a file that jink simulate wrote for every sensor."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from jink.cli.simulate import SimulateRequest, run_simulate
from jink.compare.race import compare
from jink.fit import fit
from jink.io.errors import InputError
from jink.learn.learning import learn
from jink.scenarios import RADARS, SCENARIOS

SCANS = 40  # of a shortened scenario
SMALL = {"starts": 1, "minutes": 0.02}
QUICK = {"epochs": 2}
SENSORS = ("25", *RADARS)


def short(name):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=min(SCANS, scenario.schedule.count)))


def not_worse(found):
    """A start that is the best stays it: the way from numbers to their scales and back rounds by some 1e-15."""
    return found.after <= found.before + 1e-12 * abs(found.before)


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_default_race(name):
    race = compare(short(name), runs=2)
    assert {"raw", "kalman-cv", "imm"} <= set(race.tallies)
    assert all(math.isfinite(race.figure(each, "position_rmse").value) for each in ("raw", "kalman-cv", "imm"))


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_default_fit(name):
    found = fit(short(name), runs=20, check_runs=2, **SMALL)
    assert not_worse(found) and "fitted" in found.race.tallies


@pytest.mark.parametrize("name", SCENARIOS)
def test_learning(name):
    """A network aid, whose default needs no more than positions and their truth; a radar's plots are refused."""
    if not SCENARIOS[name].observation.sensor.cartesian:
        with pytest.raises(InputError, match="expected measured positions for a learned filter"):
            learn("nn-kf", short(name), runs=8, check_runs=2, **QUICK)
        return
    learned = learn("nn-kf", short(name), runs=8, check_runs=2, **QUICK)
    assert math.isfinite(learned.race.figure("learned", "position_rmse").value)


@pytest.fixture(scope="module", params=SENSORS)
def simulated(request, tmp_path_factory):
    """Runs with their truth, as jink simulate writes them."""
    path = tmp_path_factory.mktemp("every") / "runs.parquet"
    wanted = SimulateRequest(
        name="benchmark-2", runs=8, output=str(path), sensor=request.param, interval=4.0, quiet=True
    )
    assert run_simulate(wanted) == 0
    return str(path)


def test_a_file_of_every_sensor(simulated):
    race = compare(simulated, runs=4)
    assert math.isfinite(race.figure("imm", "position_rmse").value)
    assert not_worse(fit(simulated, **SMALL))
    assert not_worse(fit(simulated, truth="true", **SMALL))
    learned = learn("nn-kf", simulated, **QUICK)
    assert math.isfinite(learned.race.figure("learned", "position_rmse").value)
