"""Gradients of filters that adapt, and what those without one say: every kind of number that can be fitted."""

from __future__ import annotations

import numpy as np
import pytest
from oracle.situations import SITUATIONS
from test_gradient import assert_gradient, assert_round_trip, tracks_of

import jink
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS
from jink.filters.adaptive_imm import aimm
from jink.fit.gradient import differentiable, gradient
from jink.fit.parameters import Parameters
from jink.learn import mlp
from jink.models.noise_network import NoiseNetwork
from jink.models.tracks import Tracks

CV = jink.ConstantVelocity(acceleration_sd=2.0)
LIMITS = jink.CurrentStatistical(limits=jink.FuzzyLimits(threshold=60.0, operating=50.0), time_constant=9.0)
WIDE = jink.CurrentStatistical(
    limits=jink.FuzzyLimits(threshold=60.0, operating=50.0, threshold_down=40.0, operating_down=30.0),
    widening=jink.LimitWidening(nis=8.0, times=1.5),
    time_constant=9.0,
)
ALONG = jink.CurrentStatistical(
    limits=jink.FuzzyLimits(threshold=60.0, operating=50.0, membership="triangular"),
    across=jink.FuzzyLimits(threshold=30.0, operating=25.0, membership="triangular"),
    widening=jink.LimitWidening(nis=8.0, times=1.5),
    time_constant=9.0,
)
STATISTICAL = jink.CurrentStatistical(acceleration_max=40.0, acceleration_min=30.0, time_constant=9.0)
RULES = jink.FuzzyRules.of([[0, 20, 0, 30, 1], [40, 30, 10, 25, 30], [-50, 20, -10, 25, 60]])
SOME = jink.FuzzyRules.of([[10, 20, 0, 30, 2], [50, 30, 10, 25, 40]])
CHOOSING = jink.NetworkNoise(
    CV,
    NoiseNetwork(
        network=mlp.as_network(mlp.initial([3, 4, 1], np.random.default_rng(3))),
        inputs="log-nis",
        output="log-variance",
        centre=(2.0, 0.0, 0.0),
        scale=(2.0, 2.0, 2.0),
        least=0.1,
        most=400.0,
        start=4.0,
    ),
)
BIAS = jink.AugmentedAcceleration(acceleration_sd=1.0, bias_sd=1.0, bias_prior_sd=10.0)
TWO_STAGE = jink.TwoStageAcceleration(acceleration_sd=1.0, bias_sd=1.0, bias_prior_sd=10.0)
P1, PLANE = jink.Position(sd=25.0, axes=1), jink.Position(sd=25.0)
ADAPTIVE = {
    "csaf": jink.Kalman(STATISTICAL, PLANE),
    "facs": jink.Kalman(LIMITS, PLANE),
    "facs-wide": jink.Kalman(WIDE, PLANE),
    "facs-along": jink.Kalman(ALONG, PLANE),
    "imm-csaf": jink.IMM([CV, STATISTICAL], PLANE, 0.9),
    "imm-facs": jink.IMM([CV, LIMITS], PLANE, jink.Sojourn([40.0, 9.0]), outliers=jink.Outliers()),
    "fuzzy": jink.Kalman(jink.FuzzyNoise(CV, RULES), PLANE),
    "imm-fuzzy": jink.IMM([CV, jink.FuzzyNoise(CV, RULES)], PLANE, 0.9),
    "fuzzy-along": jink.Kalman(jink.FuzzyNoise(CV, RULES, SOME), PLANE),
    "network": jink.Kalman(CHOOSING, PLANE),
    "imm-network": jink.IMM([CV, CHOOSING], PLANE, 0.9),
    "levels": jink.IMM([CV, *(jink.AccelerationLevel(CV, (a, 1.0)) for a in (-9.0, 7.0))], PLANE, 0.9),
    "augmented": jink.Kalman(BIAS, PLANE),
    "two-stage": jink.Kalman(TWO_STAGE, PLANE),
    "aimm": aimm([-8.0, 0.0, 8.0], P1, acceleration_sd=1.0, estimator=TWO_STAGE),
    "aimm-in-sd": aimm([-2.0, 0.0, 2.0], P1, acceleration_sd=1.0, estimator=TWO_STAGE, in_sd=True),
    "aimm-augmented": aimm([-8.0, 0.0, 8.0], PLANE, acceleration_sd=1.0, estimator=BIAS),
    "gpb1": jink.GPB1([CV, STATISTICAL], PLANE, 0.9),
    "gpb2": jink.GPB2([CV, jink.Singer(acceleration_sd=5.0, time_constant=9.0)], PLANE, 0.9),
    "static": jink.StaticMM([CV, jink.ConstantVelocity(acceleration_sd=9.0)], PLANE),
}
NOT_SMOOTH = ("vsmm-ds", "vsmm-ad", "vsmm-ag", "input-estimation", "variable-dimension", "anfis-kf", "nn-kf")


def tracks_for(filter):
    """The same for any filter of positions."""
    twin = SITUATIONS["kalman-cv-1" if filter.axes == 1 else "imm-mixed"]
    given = tracks_of(twin)
    truth = np.random.default_rng(9).normal(0, 100.0, (given.rows, len(filter.components)))
    return Tracks(given.time, given.z, given.offsets, truth=truth, components=filter.components)


@pytest.mark.parametrize("figure", ["likelihood", "tracking"])
@pytest.mark.parametrize("name", ADAPTIVE)
def test_gradient_of_filters_that_adapt(name, figure):
    """Fuzzy rules and limits, network weights, acceleration levels, side estimators, manoeuvre frequencies: every
    number.
    """
    filter = ADAPTIVE[name]
    assert differentiable(filter)
    assert_gradient(filter, tracks_for(filter), figure)


def test_every_kind_of_number_is_found():
    """By name, in the filters above."""
    found = {name for filter in ADAPTIVE.values() for name in Parameters(filter, free=["*"]).names}
    for name in (
        "current_statistical.acceleration_max",
        "current_statistical.time_constant",
        "current_statistical.limits.up",
        "current_statistical.limits.threshold_down",
        "current_statistical.across.threshold",
        "current_statistical.widening.nis",
        "current_statistical.widening.times",
        "fuzzy_constant_velocity.rule_2.centre.change",
        "fuzzy_constant_velocity.rule_3.variance",
        "fuzzy_constant_velocity.across.rule_2.variance",
        "outliers.share",
        "network_constant_velocity.network.layer_1.weight_2_3",
        "network_constant_velocity.network.layer_2.bias_1",
        "acceleration_level.acceleration.x",
        "estimator.bias_sd",
        "two_stage_acceleration.bias_sd",
        "singer.time_constant",
        "sensor.sd",
        "sojourn.constant_velocity",
        "transition.constant_velocity.current_statistical",
    ):
        assert name in found, sorted(found)


@pytest.mark.parametrize("name", NOT_SMOOTH)
def test_filters_that_choose_say_that_they_have_no_gradient(name):
    filter = FILTERS[name](Purpose(sensor=jink.Position(sd=25.0), kind="fighter")).filter
    assert not differentiable(filter)
    parameters = Parameters(filter)
    assert 1 <= len(parameters) <= 40
    moved = parameters.filter(parameters.start + 0.1)
    for name, value in parameters.values(parameters.start + 0.1).items():
        assert value == pytest.approx(Parameters(moved).values(Parameters(moved).start)[name])
    with pytest.raises(TypeError, match="cannot be differentiated"):
        gradient(filter, np.zeros((1, filter.numbers.size)), tracks_for(filter))


def test_parameters_of_adaptive_filters_round_trip():
    for name, filter in ADAPTIVE.items():
        if "fuzzy" not in name:  # whose rules are in units of the sensor's sd
            assert_round_trip(name, filter)
