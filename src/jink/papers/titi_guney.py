"""Titi & Güney: a Kalman filter whose output an adaptive neuro-fuzzy system corrects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Array
from ..filters.kalman import Kalman
from ..motion import ConstantAcceleration
from ..named import Named, Purpose
from ..named.single import kalman_ca
from ..race import Race
from ..scenarios import SCENARIOS, Observation, Scenario, Schedule
from ..scenarios.draws import Draws
from ..scenarios.truth import Kinematics, Truth
from ..sensor import Position
from .drawing import Chart, Drawing, Line
from .paper import POSITION, Experiment, Paper, named

SOURCE = "Titi & Güney, Adaptive Neuro-Fuzzy Aided Kalman Filter for Target Tracking"
SD = 50.0  # m
SLUGGISH = 1e-4  # times the tuned noise
RATES = {
    "20 Hz": Schedule(start=0.0, interval=0.05, count=3300),
    "1 Hz": Schedule(start=0.0, interval=1.0, count=166),
}


@dataclass(frozen=True)
class Along:
    """One axis of a truth."""

    truth: Truth
    axis: int

    @property
    def runs(self) -> int:
        """As the truth's."""
        return self.truth.runs

    def at(self, time: Array) -> Kinematics:
        """Kinematics (B, n, 1)."""
        return Kinematics(*(a[..., self.axis : self.axis + 1] for a in self.truth.at(time)))

    def breaks(self) -> Array:
        """As the truth's."""
        return self.truth.breaks()


def target(number: int, rate: str) -> Scenario:
    """The x coordinate (north) of a benchmark aircraft: the paper shows x alone, and a linear filter treats axes alike."""
    base = SCENARIOS[f"benchmark-{number}"]

    def truth(draws: Draws) -> Truth:
        return Along(base.truth(draws), 1)

    return replace(
        base,
        name=f"{base.name}-x-{rate.replace(' ', '').lower()}",
        summary=f"x of target {number}, {rate}, sd {SD:g} m",
        truth=truth,
        axes=1,
        observation=Observation(sensor=Position(sd=SD, axes=1)),
        schedule=RATES[rate],
    )


def sluggish(purpose: Purpose) -> Named:
    """The tuned constant-acceleration filter with a ten-thousandth of its noise."""
    tuned = kalman_ca(purpose)
    motion = tuned.filter.motions[0]
    slow = ConstantAcceleration(
        jerk_psd=SLUGGISH * motion.jerk_psd, acceleration_prior_sd=motion.acceleration_prior_sd
    )
    return named(
        "the tuned filter with 1e-4 of its jerk_psd",
        Kalman(slow, purpose.seen),
        purpose.fitted,
    )


FILTERS: dict[str, Callable[[Purpose], Named]] = {"kalman-ca/1e4": sluggish}


def experiments() -> list[Experiment]:
    """Target 1, as often as the size of the training matrix suggests, and once a second."""
    return [
        Experiment(
            name=rate,
            words=f"x of target 1 (cargo aircraft), sd {SD:g} m",
            scenario=target(1, rate),
            filters=FILTERS,
            metrics=(POSITION,),
        )
        for rate in RATES
    ]


def draw(races: Mapping[str, Race]) -> list[Drawing]:
    """Figures 2, 4 and 5 for the filters there are, on one run."""
    path = SCENARIOS["benchmark-1"].simulate(1).truth.position[0] / 1000
    run = target(1, "1 Hz").simulate([0], seed=races["1 Hz"].seed)
    time, truth = run.time[0], run.truth.position[0, :, 0]
    errors = []
    for name in ("kalman-ca", "kalman-ca/1e4"):
        estimate = races["1 Hz"].entrants[name].filter.filter(**run.batch(), outputs=("x",))
        errors.append(Line(name, time, estimate.x[:, 0] - truth))
    return [
        Chart(
            title="Figure 2: trajectory of target 1",
            x="east km",
            y="north km",
            lines=[Line("", path[:, 0], path[:, 1])],
            square=True,
        ),
        Chart(
            title="Figure 4: x of target 1, one run at 1 Hz",
            x="s",
            y="km",
            lines=[
                Line("true", time, truth / 1000, faint=True),
                *(Line(e.label, time, (np.asarray(e.y) + truth) / 1000) for e in errors),
            ],
        ),
        Chart(title="Figure 5: error in x, the same run", x="s", y="m", lines=errors),
    ]


TITI_GUNEY = Paper(
    name="titi-guney",
    source=SOURCE,
    runs=100,
    quick_runs=20,
    experiments=experiments,
    draw=draw,
    readings=(
        "The aircraft are those of Blair et al. 1998, rebuilt from its table; target 1 (cargo aircraft), x alone, as in the paper, "
        "which is taken to be north.",
        "A training matrix of 3300 rows fits 20 Hz over 165 s; 1 Hz is run as well.",
        "Noises are not stated: position sd 50 m; the Kalman filter's noise is tuned on other runs, and “sluggish” has 1e-4 of it.",
        "The paper prints figures and no table: there is nothing published to set beside.",
        "Predicted and estimated range are interchanged in one sentence of the paper; inputs are z − x(t|t) and x(t|t−1) − x(t|t).",
    ),
)
