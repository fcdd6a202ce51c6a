"""What makes no sense is refused before anything runs: every message names the parameter, what it was and what was
expected.

The same through files and the command: test_bad_files.
"""

from __future__ import annotations

import pytest
from networks import random_network
from own_models import Gauge, Straight

import jink
from jink.filters.adaptive_imm import aimm, symmetric_levels
from jink.filters.variable_structure import line_transition

PLANE = jink.Position(sd=25.0, axes=2)
CV, CA = jink.ConstantVelocity(acceleration_sd=1.0), jink.ConstantAcceleration(jerk_psd=1.0)
LEVELS = [jink.ConstantVelocity(acceleration_sd=sd) for sd in (1.0, 3.0, 9.0, 27.0)]
SIDE = jink.TwoStageAcceleration(acceleration_sd=1.0, bias_sd=10.0, bias_prior_sd=30.0)
AROUND = jink.AccelerationLevel(CV, 10.0, estimated=True)
ISLAND = [[0.9, 0.1, 0, 0], [0.1, 0.9, 0, 0], [0, 0, 0.9, 0.1], [0, 0, 0.1, 0.9]]

REFUSED = {  # a call, and what its message must say
    "operating above threshold": (
        lambda: jink.FuzzyLimits(threshold=100.0, operating=120.0),
        "FuzzyLimits.operating: expected a value below the threshold 100 m/s², the largest that a_max reaches, got 120",
    ),
    "operating at the threshold": (
        lambda: jink.FuzzyLimits(threshold=80.0, operating=80.0),
        "FuzzyLimits.operating: expected a value below the threshold 80 m/s², the largest that a_max reaches, got 80",
    ),
    "exponent beyond its bound": (
        lambda: jink.FuzzyLimits(threshold=100.0, operating=90.0, up=1.06),
        "FuzzyLimits.up: expected at most 1.0536, got 1.06",
    ),
    "exponent downwards beyond its bound": (
        lambda: jink.FuzzyLimits(threshold=50.0, operating=20.0, down=1.6),
        "FuzzyLimits.down: expected at most 1.5272, got 1.6",
    ),
    "limits twice": (
        lambda: jink.CurrentStatistical(acceleration_max=30.0, limits=jink.FuzzyLimits()),
        "exactly one of acceleration_max and limits",
    ),
    "operating downwards at the threshold": (
        lambda: jink.FuzzyLimits(threshold=100.0, operating=90.0, threshold_down=80.0),
        "FuzzyLimits.operating_down: expected a value below the threshold 80 m/s², the largest that a_max reaches, "
        "got 90",
    ),
    "exponent beyond its own side's bound": (
        lambda: jink.FuzzyLimits(down=1.06, threshold_down=100.0, operating_down=95.0),
        "FuzzyLimits.down: expected at most 1.0259, got 1.06; beyond it a_max(a) < |a| somewhere below operating_down "
        "95 m/s²",
    ),
    "a threshold downwards below zero": (
        lambda: jink.FuzzyLimits(threshold_down=-100.0),
        "FuzzyLimits.threshold_down: expected",
    ),
    "a membership that is not known": (
        lambda: jink.FuzzyLimits(membership="gaussian"),
        "FuzzyLimits.membership: expected 'exponential' or 'triangular', got 'gaussian'",
    ),
    "limits across without limits along": (
        lambda: jink.CurrentStatistical(acceleration_max=30.0, across=jink.FuzzyLimits()),
        "CurrentStatistical.across: expected limits too, which hold along the velocity, got none",
    ),
    "limits of two memberships": (
        lambda: jink.CurrentStatistical(limits=jink.FuzzyLimits(), across=jink.FuzzyLimits(membership="triangular")),
        "CurrentStatistical.across: expected the membership of limits, exponential, got triangular",
    ),
    "widening of a number": (
        lambda: jink.CurrentStatistical(limits=jink.FuzzyLimits(), widening=9.0),  # pyright: ignore[reportArgumentType]
        "CurrentStatistical.widening: expected LimitWidening, got float",
    ),
    "limits that widen at once": (
        lambda: jink.LimitWidening(nis=1.0),
        "LimitWidening.nis: expected more than 1, the mean of the NIS, got 1",
    ),
    "limits that widen by nothing": (lambda: jink.LimitWidening(times=0.0), "LimitWidening.times: expected"),
    "a level in deviations of no estimate": (
        lambda: jink.AccelerationLevel(CV, 2.0, in_sd=True),
        "AccelerationLevel.in_sd: expected estimated=True too, whose standard deviation is the unit, got False",
    ),
    "an island in the transition": (
        lambda: jink.DigraphSwitching(LEVELS, PLANE, ISLAND),
        "graph: mode 2 cannot be reached from mode 0, nor can 1 others",
    ),
    "an island in the graph": (
        lambda: jink.ActiveDigraph(LEVELS, PLANE, 0.9, graph=[[1], [0, 2], [1], [2]]),
        "graph: mode 3 cannot be reached from mode 0",
    ),
    "a column of zeros": (
        lambda: jink.IMM([CV, CA], PLANE, [[1, 0], [1, 0]]),
        "transition: mode 1 cannot be reached",
    ),
    "a neighbour that does not exist": (
        lambda: jink.DigraphSwitching(LEVELS, PLANE, 0.9, graph=[[1], [2], [3], [4]]),
        "graph: mode 3 has neighbours [4]; modes are 0 to 3",
    ),
    "neighbours of too few": (
        lambda: jink.DigraphSwitching(LEVELS, PLANE, 0.9, graph=[[1], [0]]),
        "graph: expected the neighbours of each of 4 modes, got 2 lists",
    ),
    "a first mode that does not exist": (
        lambda: jink.DigraphSwitching(LEVELS, PLANE, 0.9, first_mode=4),
        "first_mode: expected a whole number from 0 to 3, got 4",
    ),
    "an even number of levels": (
        lambda: aimm((-40.0, -20.0, 20.0, 40.0), PLANE, acceleration_sd=1.0, estimator=SIDE),
        "levels: expected an odd number of accelerations symmetric about zero",
    ),
    "levels that are not symmetric": (
        lambda: aimm((-40.0, 0.0, 30.0), PLANE, acceleration_sd=1.0, estimator=SIDE),
        "levels: expected an odd number of accelerations symmetric about zero",
    ),
    "steps that fall": (
        lambda: symmetric_levels(CV, [3.0, 2.0], 2),
        "steps: expected positive accelerations in rising",
    ),
    "rows that do not sum to one": (
        lambda: jink.AdaptiveIMM([AROUND, CV], PLANE, [[0.9, 0.2], [0.1, 0.9]], estimator=SIDE),
        "transition: transition[i, j] = p(j | i), so each row must sum to one; got [1.1",
    ),
    "rows of pairs that do not sum to one": (
        lambda: jink.GPB2([CV, CA], PLANE, [[0.9, 0.1], [0.1, 0.8]]),
        "each row must sum to one; got [1. ",
    ),
    "ends of sojourns that do not sum to one": (
        lambda: jink.IMM([CV, CA], PLANE, jink.Sojourn(seconds=[9.0, 9.0], to=[[0, 0.5], [1, 0]])),
        "Sojourn.to: rows must sum to one",
    ),
    "a sojourn without a rate": (
        lambda: jink.IMM([CV, CA], PLANE, jink.Sojourn(seconds=[9.0, 5e-324])),
        "Sojourn.seconds: expected at least 1e-150, got 4.94066e-324",
    ),
    "a step without a rate": (
        lambda: jink.IMM([CV, CA], PLANE, 0.9, transition_step=1e-300),
        "transition_step: expected at least 1e-150, got 1e-300",
    ),
    "three points want three rows": (
        lambda: jink.AdaptiveGrid(LEVELS, PLANE, line_transition(4)),
        "transition: expected a 3 by 3 matrix, got shape (4, 4)",
    ),
    "a grid over different models": (
        lambda: jink.AdaptiveGrid([CV, CA], PLANE),
        "motions: expected modes of one motion",
    ),
    "three points between two modes": (
        lambda: jink.AdaptiveGrid(LEVELS[:2], PLANE, least_step=0.5),
        "motions: expected at least 3 modes for a grid of three points, got 2",
    ),
    "thresholds that overlap": (
        lambda: jink.AdaptiveGrid(LEVELS, PLANE, unlikely=0.9, likely=0.8),
        "unlikely: expected 0 ≤ unlikely < likely ≤ 1, got 0.9 and 0.8",
    ),
    "one alive": (
        lambda: jink.ActiveDigraph(LEVELS, PLANE, 0.9, alive=1),
        "alive: expected a whole number of modes from 2 to 4, got 1",
    ),
    "nothing that adapts": (
        lambda: jink.AdaptiveIMM([CV, CA], PLANE, 0.9, estimator=SIDE),
        "motions: expected at least one AccelerationLevel with estimated=True",
    ),
    "an estimate that nobody makes": (
        lambda: jink.IMM([AROUND, CV], PLANE, 0.9),
        "AccelerationLevel.estimated needs the estimate of a jink.AdaptiveIMM; IMM has none; expected estimated=False",
    ),
    "an estimate that nobody makes, deeper": (
        lambda: jink.Kalman(jink.FuzzyNoise(AROUND, jink.FuzzyRules.constant(3.0, 50.0)), PLANE),
        "AccelerationLevel.estimated needs the estimate",
    ),
    "an estimate of a word": (
        lambda: jink.AccelerationLevel(CV, 3.0, estimated="yes"),  # pyright: ignore[reportArgumentType]
        "AccelerationLevel.estimated: expected True or False, got 'yes'",
    ),
    "a level beside a model of your own": (
        lambda: jink.IMM([Straight(1.0), jink.AccelerationLevel(CV, 3.0)], PLANE, 0.9),
        "motions: AccelerationLevel adapts its noise or adds an acceleration; beside models of your own, expected",
    ),
    "noise that adapts beside a sensor of your own": (
        lambda: jink.Kalman(jink.CurrentStatistical(acceleration_max=30.0), Gauge(25.0)),
        "motions: CurrentStatistical adapts its noise or adds an acceleration",
    ),
    "two stages beside a model of your own": (
        lambda: jink.IMM([Straight(1.0), SIDE], PLANE, 0.9),
        "motions: TwoStageAcceleration adapts its noise or adds an acceleration",
    ),
    "a level on a model of your own": (
        lambda: jink.IMM([jink.AccelerationLevel(Straight(1.0), 3.0), CV], PLANE, 0.9),
        "AccelerationLevel.motion: expected one of jink's motion models, got Straight",
    ),
    "an infinite level": (
        lambda: jink.AccelerationLevel(CV, float("inf")),
        "AccelerationLevel.acceleration: expected finite numbers, got inf",
    ),
    "levels of other axes": (
        lambda: jink.IMM([jink.AccelerationLevel(CV, [1.0, 2.0, 3.0]), CV], PLANE, 0.9),
        "AccelerationLevel.acceleration: expected one number or one for each of 2 axes, got 3",
    ),
    "pairs without a memory": (
        lambda: jink.GPB2(
            [jink.AccelerationLevel(jink.FuzzyNoise(CV, jink.FuzzyRules.constant(3.0, 50.0)), 1.0), CV],
            PLANE,
            0.9,
        ),
        "motions: GPB2 keeps no memory for a pair of modes",
    ),
    "a window of nothing": (
        lambda: jink.InputEstimation(CV, PLANE, window=0),
        "window: expected a whole number of scans from 1 to 64, got 0",
    ),
    "an onset before the window": (
        lambda: jink.InputEstimation(CV, PLANE, window=5, shortest=6),
        "shortest: expected a whole number of scans from 1 to 5, got 6",
    ),
    "a manoeuvre in a quiet filter": (
        lambda: jink.InputEstimation(CA, PLANE),
        "motion: expected a ConstantVelocity, got ConstantAcceleration",
    ),
    "a false alarm every time": (
        lambda: jink.VariableDimension(CV, CA, PLANE, false_alarm=1.0),
        "false_alarm: expected a probability between 0 and 1, got 1.0",
    ),
    "filters in the wrong order": (
        lambda: jink.VariableDimension(CA, CV, PLANE),  # pyright: ignore[reportArgumentType]
        "quiet: expected a ConstantVelocity, got ConstantAcceleration",
    ),
    "rules in kilometres": (
        lambda: jink.IMM([jink.FuzzyNoise(CV, rules_in_km()), CV], PLANE, 0.9),
        "expected metres and (m/s²)²",
    ),
    "rules in kilometres, deeper": (
        lambda: jink.Kalman(jink.AccelerationLevel(jink.FuzzyNoise(CV, rules_in_km()), 0.0), PLANE),
        "expected metres and (m/s²)²",
    ),
    "a network of another sensor": (
        lambda: jink.Kalman(jink.NetworkNoise(CV, noise_network(sensor_sd=0.025)), PLANE),
        "was trained on measurements of sd 0.025 m, and the sensor's is 25 m; expected metres",
    ),
    "a start outside the network's range": (
        lambda: noise_network(start=0.1),
        "NoiseNetwork.start: expected 0.5 to 400, got 0.1",
    ),
    "a network in space": (
        lambda: jink.Kalman(jink.NetworkNoise(CV, noise_network()), jink.Position(sd=25.0, axes=3)),
        "NetworkNoise.network: has 3 inputs; expected 4 with 3 axes",
    ),
}


def rules_in_km():
    return jink.FuzzyRules.of([(0.5, 0.2, 0.0, 1.0, 1e-6)])


def noise_network(**changed):
    given = {
        "least": 0.5,
        "most": 400.0,
        "start": 4.0,
        "inputs": "log-nis",
        "output": "log-variance",
        "centre": [0.0] * 3,
        "scale": [1.0] * 3,
    }
    return jink.models.noise_network.NoiseNetwork(network=random_network([3, 4, 1], 6), **{**given, **changed})


@pytest.mark.parametrize("what", REFUSED)
def test_constructors_refuse(what):
    call, message = REFUSED[what]
    with pytest.raises((ValueError, TypeError)) as refusal:
        call()
    assert message in str(refusal.value)
