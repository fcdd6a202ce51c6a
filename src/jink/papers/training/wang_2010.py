"""How the fitted filters of wang-2010 were made: by maximum likelihood on runs of all three of its targets together."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...filters.current_statistical import CurrentStatistical, FuzzyLimits, LimitWidening
from ...filters.kalman import Kalman
from ...fit.objectives import Likelihood
from ...fit.optimise import Search
from ...fit.parameters import Parameters
from ...models.motion import Singer
from ...models.sensor import Position
from ...models.tracks import Tracks
from ...scenarios import SCENARIOS
from .trainer import Trainer

SD = 50.0  # m
TARGETS = ("velocity", "circle", "step")
# where the search starts: a target that flies below `operating` (m/s²), the paper's k and 1/α
LIMITS = FuzzyLimits(threshold=30.0, operating=5.0)
WIDENING = LimitWidening(nis=12.0, times=2.0)


def runs(count: int, seed: int, axes: int) -> Tracks:
    """Runs of the three targets: one axis after the other, or in the plane, where a target on a line stays at y = 0.

    Every other run is mirrored, so that nothing is learned of the sign of an acceleration.
    """
    time, z, lengths = [], [], []
    for k, name in enumerate(TARGETS):
        seen = SCENARIOS[f"wang-2010-{name}"].seen_by(SD).simulate(count, seed)
        measured = seen.z * np.where(np.arange(count) % 2, 1.0, -1.0)[:, None, None]
        if axes == 1:
            measured = np.moveaxis(measured, 2, 0).reshape(-1, measured.shape[1], 1)
        elif measured.shape[2] == 1:
            still = np.random.default_rng([seed, k]).normal(0.0, SD, measured.shape)
            measured = np.concatenate([measured, still], axis=2)
        time.append(np.broadcast_to(seen.time[:1], measured.shape[:2]).reshape(-1))
        z.append(measured.reshape(-1, axes))
        lengths += [measured.shape[1]] * measured.shape[0]
    return Tracks(np.concatenate(time), np.concatenate(z), np.concatenate([[0], np.cumsum(lengths)]))


def fitted(motion: Any, *, axes: int = 1, fixed: tuple[str, ...] = ("*.acceleration_prior_sd",)) -> Trainer:
    """All of a motion model's numbers but the start's, on 100 runs of each target."""

    def make(seed: int, quick: bool) -> Kalman:
        parameters = Parameters(Kalman(motion, Position(sd=SD, axes=axes)), fixed=fixed)
        tracks = runs(10 if quick else 100, seed + 5, axes)
        filter: Kalman = parameters.filter(Search(parameters, Likelihood(), tracks, starts=1, seed=seed).run().u)
        return filter

    return make


def statistical(**parts: Any) -> CurrentStatistical:
    """The model with 1/α of the paper's experiments as read here."""
    return CurrentStatistical(**parts, time_constant=20.0, acceleration_prior_sd=30.0)


MODELS: dict[str, Trainer] = {
    "wang-2010-facs": fitted(statistical(limits=LIMITS)),
    # 1/α as it was: left free it runs to 1 s, which suits the step and is worse in the paper's own experiments
    "wang-2010-facs-widened": fitted(
        statistical(limits=LIMITS, widening=WIDENING), fixed=("*.acceleration_prior_sd", "*.time_constant")
    ),
    "wang-2010-facs-along": fitted(
        statistical(limits=LIMITS, across=LIMITS, widening=WIDENING),
        axes=2,
    ),
    "wang-2010-csaf": fitted(statistical(acceleration_max=90.0)),
    "wang-2010-singer": fitted(Singer(acceleration_sd=10.0, time_constant=20.0), fixed=()),
}
