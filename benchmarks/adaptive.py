"""Every adaptive filter against the plain one it should not cost much more than: as many modes of the same state, fixed
noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import jink
from jink.filters.adaptive_imm import AugmentedAcceleration, TwoStageAcceleration, aimm
from jink.filters.aided import Aided
from jink.filters.current_statistical import csaf, facs
from jink.filters.fuzzy_imm import fuzzy_imm
from jink.filters.input_estimation import InputEstimation
from jink.filters.neural_vsmm import NetworkNoise, NeuralModes
from jink.filters.pseudo_bayesian import GPB1, GPB2, StaticMM
from jink.filters.variable_dimension import VariableDimension
from jink.filters.variable_structure import (
    CHOI_2001,
    ActiveDigraph,
    AdaptiveGrid,
    DigraphSwitching,
    line_transition,
    noise_levels,
)
from jink.models.anfis import Anfis
from jink.models.corrector import Corrector
from jink.models.network import Network
from jink.models.noise_network import ModeNetwork, NoiseNetwork

from .cases import ACCELERATION_SD, POSITION_SD, STAY, VELOCITY_PRIOR_SD, Case, regular
from .race import Job

LEE_SD = 500.0  # m: the sensor that lee-2003's rules are about
HIDDEN = 16
INNOVATIONS = 8


@dataclass(frozen=True)
class Contest:
    """A filter by name, the plain one it is held against, and how many times dearer it may be."""

    name: str
    against: str
    limit: float


CONTESTS = (
    Contest("csaf", "Kalman CA", 3),
    Contest("facs", "Kalman CA", 3),
    Contest("facs", "csaf", 1.25),
    Contest("augmented", "Kalman CA", 3),
    Contest("two-stage", "Kalman CA", 3),
    Contest("aimm3, axis by axis", "IMM 3 × CV, one axis", 3),
    Contest("aimm5, axis by axis", "IMM 5 × CV, one axis", 3),
    Contest("aimm5, two axes", "IMM 5 × CV", 3),
    Contest("mm", "IMM 3 × CV", 3),
    Contest("gpb1", "IMM 3 × CV", 3),
    Contest("gpb2", "IMM 3 × CV", 4.5),
    Contest("vsmm-ds, 3 of 40 alive", "IMM 3 × CV", 3),
    Contest("vsmm-ad, 3 of 40 alive", "IMM 3 × CV", 3),
    Contest("vsmm-ag over 40 levels", "IMM 3 × CV", 3),
    Contest("input-estimation, 8 onsets", "Kalman CV", 3),
    Contest("input-estimation, 8 onsets", "IMM 8 × CV", 3),
    Contest("variable-dimension", "IMM CV, CA", 3),
    Contest("fuzzy-imm, lee-2003's rules", "IMM 3 × CV", 6),
    Contest("nnvsmm, noise by a network", "Kalman CV", 3),
    Contest("nnvsmm, network weighs 3 modes", "IMM 3 × CV", 3),
    Contest("Kalman CA + ANFIS", "Kalman CA", 3),
    Contest("IMM 3 × CV + network", "IMM 3 × CV", 3),
)


def jobs(tracks: int, scans: int) -> dict[str, Job]:
    """Every job of the adaptive filters' race by name: plain filters first."""
    case = regular(tracks, scans)
    made: dict[str, Callable[[], Any]] = {**_plain(), **_adaptive()}
    out = {}
    for name, make in made.items():
        z = case.z
        if "axis" in name:
            z = np.ascontiguousarray(z[:, :1])
        elif "lee-2003" in name:
            z = z * (LEE_SD / POSITION_SD)
        out[name] = _batch(make(), case, z)
    return out


def _plain() -> dict[str, Callable[[], Any]]:
    cv = [jink.ConstantVelocity(acceleration_sd=sd) for sd in np.linspace(*ACCELERATION_SD[::2], 8)]
    ca = jink.ConstantAcceleration(jerk_psd=4.0)

    def imm(motions: Any, axes: int = 2) -> Any:
        return jink.IMM(motions, _sensor(axes), STAY, initial=_start())

    return {
        "Kalman CV": lambda: jink.Kalman(cv[0], _sensor(), initial=_start()),
        "Kalman CA": lambda: jink.Kalman(ca, _sensor(), initial=_start()),
        "IMM 3 × CV, one axis": lambda: imm(cv[:3], 1),
        "IMM 5 × CV, one axis": lambda: imm(cv[:5], 1),
        "IMM 3 × CV": lambda: imm(cv[:3]),
        "IMM 5 × CV": lambda: imm(cv[:5]),
        "IMM 8 × CV": lambda: imm(cv),
        "IMM CV, CA": lambda: imm([cv[0], ca]),
    }


def _adaptive() -> dict[str, Callable[[], Any]]:
    plain = _plain()
    three = [jink.ConstantVelocity(acceleration_sd=sd) for sd in ACCELERATION_SD]
    ca: Any = jink.ConstantAcceleration(jerk_psd=4.0)
    forty, moves = noise_levels(CHOI_2001), line_transition(len(CHOI_2001), stay=0.95)
    drift = {"acceleration_sd": 1.0, "bias_sd": 2.0, "bias_prior_sd": 10.0}
    two_stage, augmented = TwoStageAcceleration(**drift), AugmentedAcceleration(**drift)
    first = {"initial": _start()}

    def adaptive_imm(levels: tuple[float, ...], axes: int) -> Any:
        return aimm(levels, _sensor(axes), acceleration_sd=1.0, estimator=two_stage, **first)

    return {
        "csaf": lambda: csaf(_sensor(), **first),
        "facs": lambda: facs(_sensor(), **first),
        "augmented": lambda: _kalman(augmented),
        "two-stage": lambda: _kalman(two_stage),
        "aimm3, axis by axis": lambda: adaptive_imm((-40.0, 0.0, 40.0), 1),
        "aimm5, axis by axis": lambda: adaptive_imm((-40.0, -20.0, 0.0, 20.0, 40.0), 1),
        "aimm5, two axes": lambda: adaptive_imm((-40.0, 0.0, 40.0), 2),
        "mm": lambda: StaticMM(three, _sensor(), **first),
        "gpb1": lambda: GPB1(three, _sensor(), STAY, **first),
        "gpb2": lambda: GPB2(three, _sensor(), STAY, **first),
        "vsmm-ds, 3 of 40 alive": lambda: DigraphSwitching(forty, _sensor(), moves, **first),
        "vsmm-ad, 3 of 40 alive": lambda: ActiveDigraph(forty, _sensor(), moves, **first),
        "vsmm-ag over 40 levels": lambda: AdaptiveGrid(forty, _sensor(), **first),
        "input-estimation, 8 onsets": lambda: InputEstimation(three[0], _sensor(), **first),
        "variable-dimension": lambda: VariableDimension(three[0], ca, _sensor(), **first),
        "fuzzy-imm, lee-2003's rules": lambda: fuzzy_imm(jink.Position(sd=LEE_SD), **first),
        "nnvsmm, noise by a network": lambda: _kalman(NetworkNoise(three[0], _noise_network())),
        "nnvsmm, network weighs 3 modes": lambda: NeuralModes(three, _sensor(), _mode_network(3), **first),
        "Kalman CA + ANFIS": lambda: Aided(plain["Kalman CA"](), _anfis()),
        "IMM 3 × CV + network": lambda: Aided(plain["IMM 3 × CV"](), _correction()),
    }


def _sensor(axes: int = 2) -> jink.Position:
    return jink.Position(sd=POSITION_SD, axes=axes)


def _start() -> jink.TwoPoint:
    return jink.TwoPoint(velocity_sd=VELOCITY_PRIOR_SD)


def _kalman(motion: Any) -> Any:
    return jink.Kalman(motion, _sensor(), initial=_start())


def _network(inputs: int, outputs: int) -> Network:
    """Small random weights: what a network says does not change what it costs."""
    generator = np.random.default_rng(0)
    shapes = [(HIDDEN, inputs), (outputs, HIDDEN)]
    weights = [0.1 * generator.standard_normal(shape) for shape in shapes]
    return Network([w.tolist() for w in weights], [[0.0] * len(w) for w in weights])


def _noise_network() -> NoiseNetwork:
    scaling = {"centre": [0.0] * 3, "scale": [1.0] * 3}
    limits = {"least": 1.0, "most": 196.0, "start": 1.0}
    return NoiseNetwork(network=_network(3, 1), inputs="log-nis", output="log-variance", **scaling, **limits)


def _mode_network(modes: int) -> ModeNetwork:
    return ModeNetwork(
        network=_network(2 * modes, modes), centre=[0.0] * 2 * modes, scale=[1.0] * 2 * modes, best=modes - 1
    )


def _anfis() -> Corrector:
    """Titi & Güney's: two inputs with four triangles each, sixteen rules."""
    peaks, width = np.linspace(-1.0, 1.0, 4), 2.0 / 3.0
    triangles = [(p - width, p, p + width) for p in peaks.tolist()]
    model = Anfis("triangular", [triangles, triangles], np.full((16, 1, 3), 1e-3).tolist())
    return _corrector(model, "titi-guney", 2, 3 * POSITION_SD)


def _correction() -> Corrector:
    return _corrector(_network(INNOVATIONS, 1), "innovations", INNOVATIONS, 3.0)


def _corrector(model: Any, inputs: str, count: int, reach: float) -> Corrector:
    return Corrector(
        model=model,
        inputs=inputs,
        low=[-reach] * count,
        high=[reach] * count,
        centre=[0.0] * count,
        scale=[reach] * count,
        output_scale=[1.0],
    )


def _batch(estimator: Any, case: Case, z: Any) -> Job:
    def run(_: None) -> Any:
        estimate = estimator.filter(case.time, z, offsets=case.offsets, threads=1, outputs=("x", "log_likelihood"))
        return estimate.x.reshape(case.tracks, case.scans, -1)

    return Job(run, case.updates)
