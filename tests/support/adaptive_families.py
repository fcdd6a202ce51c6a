"""Adaptive and learned filters of any size, for the property tests: every length in them in units of the sensor's sd.

A family is a function of a draw of numbers and a unit of length (m) that returns a filter; doubling the unit doubles
every length.
"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from networks import membership_functions, random_network

import jink
from jink.filters.variable_structure import line_transition
from jink.models.anfis import Anfis
from jink.models.corrector import Corrector
from jink.models.noise_network import ModeNetwork, NoiseNetwork

ratios = st.floats(-2, 2).map(lambda e: 10.0**e)  # accelerations over one second, in the sensor's sd


class Draw:
    """What is drawn once and built as often as needed: a few ratios, a seed, a choice of what is common to all."""

    def __init__(self, ratios, seed, outliers, two_points):
        self.ratios, self.seed, self.outliers, self.two_points = sorted(ratios), seed, outliers, two_points

    def common(self, unit):
        start = jink.TwoPoint if self.two_points else jink.OnePoint
        more = {"initial": start(velocity_sd=50.0 * unit)}
        if self.outliers:
            more["outliers"] = jink.Outliers(share=0.05, extent=1e4 * unit, velocity_extent=1e3 * unit, restart_after=2)
        return jink.Position(sd=unit, axes=2), more


draws = st.builds(Draw, st.lists(ratios, min_size=4, max_size=4), st.integers(0, 99), st.booleans(), st.booleans())


def cv(d, unit, k=0):
    return jink.ConstantVelocity(acceleration_sd=d.ratios[k] * unit)


def ca(d, unit):
    return jink.ConstantAcceleration(jerk_psd=(d.ratios[1] * unit) ** 2, acceleration_prior_sd=d.ratios[2] * unit)


def current(d, unit, fuzzy):
    limit = 3.0 * d.ratios[-1] * unit
    limits = (
        {"limits": jink.FuzzyLimits(threshold=limit, operating=0.9 * limit)} if fuzzy else {"acceleration_max": limit}
    )
    return jink.CurrentStatistical(**limits, time_constant=15.0, acceleration_prior_sd=d.ratios[2] * unit)


def surprised(d, unit, along):
    """Fuzzy limits that widen, of both signs apart, along each axis or along and across the track."""
    limit = 3.0 * d.ratios[-1] * unit
    sides = {"threshold_down": 0.7 * limit, "operating_down": 0.6 * limit} if along else {}
    return jink.CurrentStatistical(
        limits=jink.FuzzyLimits(threshold=limit, operating=0.9 * limit, **sides),
        across=jink.FuzzyLimits(threshold=0.5 * limit, operating=0.4 * limit) if along else None,
        widening=jink.LimitWidening(nis=6.0, times=1.5),
        time_constant=15.0,
        acceleration_prior_sd=d.ratios[2] * unit,
    )


def biased(d, unit):
    return {
        "acceleration_sd": d.ratios[0] * unit,
        "bias_sd": d.ratios[1] * unit,
        "bias_prior_sd": d.ratios[2] * unit,
    }


def fuzzy(d, unit, along=False):
    rng = np.random.default_rng(d.seed)

    def table():
        places = [draw(*of, 4) for draw, of in ((rng.normal, (0, 3)), (rng.uniform, (0.5, 4))) * 2]
        return jink.FuzzyRules.of(np.column_stack([*places, np.square(d.ratios)]), unit=unit)

    return jink.FuzzyNoise(cv(d, unit), table(), table() if along else None)


def network_noise(d, unit):
    network = NoiseNetwork(
        network=random_network([3, 4, 1], d.seed),
        inputs="log-nis",
        output="log-variance",
        centre=[0.0] * 3,
        scale=[2.0] * 3,
        least=d.ratios[0] ** 2,
        most=2 * d.ratios[-1] ** 2,
        start=d.ratios[-1] ** 2,
        sensor_sd=1.0,
    )
    return jink.NetworkNoise(cv(d, unit), network.scaled(unit))


def aimm(d, unit):
    sensor, more = d.common(unit)
    axis = [[0.0, 0.0]] + [
        [s * d.ratios[-1] * unit * (a == 0), s * d.ratios[-1] * unit * (a == 1)] for a in (0, 1) for s in (-1, 1)
    ]
    modes = [jink.AccelerationLevel(cv(d, unit), level, estimated=True) for level in axis]
    return jink.AdaptiveIMM(modes, sensor, 0.9, estimator=jink.TwoStageAcceleration(**biased(d, unit)), **more)


def several(kind, fuzzy_mode=False):
    def build(d, unit):
        sensor, more = d.common(unit)
        modes = [cv(d, unit), current(d, unit, True) if fuzzy_mode else ca(d, unit)]
        chain = () if kind is jink.StaticMM else (0.9,)
        return kind(modes, sensor, *chain, **more)

    return build


def structure(kind, **options):
    def build(d, unit):
        sensor, more = d.common(unit)
        modes = [
            jink.ConstantVelocity(acceleration_sd=float(sd))
            for sd in np.geomspace(d.ratios[0], 2 * d.ratios[-1], 7) * unit
        ]
        chain = () if kind is jink.AdaptiveGrid else (line_transition(7),)
        return kind(modes, sensor, *chain, **options, **more)

    return build


def alone(motion):
    def build(d, unit):
        sensor, more = d.common(unit)
        return jink.Kalman(motion(d, unit), sensor, **more)

    return build


def fuzzy_imm(d, unit):
    sensor, more = d.common(unit)
    return jink.IMM([fuzzy(d, unit), cv(d, unit, 3)], sensor, 0.9, **more)


def input_estimation(d, unit):
    sensor, more = d.common(unit)
    return jink.InputEstimation(cv(d, unit), sensor, window=6, **more)


def variable_dimension(d, unit):
    sensor, more = d.common(unit)
    return jink.VariableDimension(cv(d, unit), ca(d, unit), sensor, window=4, **more)


def scored(d, unit):
    sensor, more = d.common(unit)
    network = ModeNetwork(
        network=random_network([4, 4, 2], d.seed), centre=[0.0] * 4, scale=[2.0] * 4, best=1 + d.seed % 2
    )
    return jink.NeuralModes([cv(d, unit), ca(d, unit)], sensor, network, **more)


def aided(inputs):
    def build(d, unit):
        model = random_network([2, 4, 1], d.seed)
        if d.seed % 2:
            functions = [membership_functions("gaussian", 3, -1.0, 1.0)] * 2
            rules = np.random.default_rng(d.seed).normal(size=(9, 1, 3))
            model = Anfis("gaussian", functions, rules.tolist())
        length = unit if inputs == "titi-guney" else 1.0
        corrector = Corrector(
            model=model,
            inputs=inputs,
            low=[-5 * length] * 2,
            high=[5 * length] * 2,
            centre=[0.0, 0.0],
            scale=[3 * length] * 2,
            output_scale=[0.5 * length],
            fade=0.5,
        )
        return jink.Aided(several(jink.IMM)(d, unit), corrector)

    return build


FAMILIES = {
    "csaf": alone(lambda d, unit: current(d, unit, False)),
    "facs": alone(lambda d, unit: current(d, unit, True)),
    "facs-wide": alone(lambda d, unit: surprised(d, unit, False)),
    "facs-along": alone(lambda d, unit: surprised(d, unit, True)),
    "imm-facs": several(jink.IMM, True),
    "two-stage": alone(lambda d, unit: jink.TwoStageAcceleration(**biased(d, unit))),
    "augmented": alone(lambda d, unit: jink.AugmentedAcceleration(**biased(d, unit))),
    "aimm": aimm,
    "gpb1": several(jink.GPB1),
    "gpb1-facs": several(jink.GPB1, True),
    "gpb2": several(jink.GPB2),
    "mm": several(jink.StaticMM),
    "vsmm-ds": structure(jink.DigraphSwitching, first_mode=3),
    "vsmm-ad": structure(jink.ActiveDigraph, first_mode=3),
    "vsmm-ag": structure(jink.AdaptiveGrid),
    "input-estimation": input_estimation,
    "variable-dimension": variable_dimension,
    "fuzzy-kalman": alone(fuzzy),
    "fuzzy-along": alone(lambda d, unit: fuzzy(d, unit, True)),
    "fuzzy-imm": fuzzy_imm,
    "nnvsmm": alone(network_noise),
    "nnvsmm-modes": scored,
    "aided-residuals": aided("titi-guney"),
    "aided-innovations": aided("innovations"),
}
