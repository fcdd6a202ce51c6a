"""How the adaptive IMMs of lee-2003 were fitted: Qa and, of levels in standard deviations, c, by maximum likelihood."""

from __future__ import annotations

import numpy as np

from ...filters.adaptive_imm import AdaptiveIMM, AugmentedAcceleration, TwoStageAcceleration, aimm
from ...fit.objectives import Likelihood
from ...fit.optimise import Search
from ...fit.parameters import Parameters
from ...models.sensor import Position
from ...models.tracks import Tracks
from ...scenarios import SCENARIOS
from .trainer import Trainer

SD, NOISE, BIAS, BIAS_PRIOR = 500.0, 1.0, 10.0, float(np.sqrt(1e3))  # m, and m/s² as in the paper
FIXED, IN_SD = (40.0,), (2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # m/s²; c


def runs(count: int, seed: int) -> Tracks:
    """Runs of the paper's target, one axis after the other."""
    seen = SCENARIOS["lee-2003"].seen_by(SD).simulate(count, seed)
    z = np.moveaxis(seen.z, 2, 0).reshape(-1, seen.z.shape[1], 1)
    time = np.broadcast_to(seen.time[:1], z.shape[:2]).reshape(-1)
    return Tracks(time, z.reshape(-1, 1), np.arange(len(z) + 1) * z.shape[1])


def fitted(kind: type[AugmentedAcceleration], *, in_sd: bool) -> Trainer:
    """AIMM3 around the estimate of this kind: Qa fitted for each interval, the likeliest kept."""

    def make(seed: int, quick: bool) -> AdaptiveIMM:
        tracks = runs(5 if quick else 100, seed + 5)
        found = []
        for step in (IN_SD if in_sd else FIXED)[: 1 if quick else None]:
            beside = kind(acceleration_sd=NOISE, bias_sd=BIAS, bias_prior_sd=BIAS_PRIOR)
            levels, sensor = (-step, 0.0, step), Position(sd=SD, axes=1)
            start = aimm(levels, sensor, 0.97, acceleration_sd=NOISE, estimator=beside, in_sd=in_sd)
            others = [name for name in Parameters(start).names if name != "estimator.bias_sd"]
            parameters = Parameters(start, fixed=others)
            best = Search(parameters, Likelihood(), tracks, starts=1, seed=seed).run()
            found.append((best.value, parameters.filter(best.u)))
        return min(found, key=lambda each: each[0])[1]

    return make


MODELS: dict[str, Trainer] = {
    "lee-2003-aimm3": fitted(TwoStageAcceleration, in_sd=False),
    "lee-2003-aimm3-in-sd": fitted(TwoStageAcceleration, in_sd=True),
    "lee-2003-aimm3-augmented-in-sd": fitted(AugmentedAcceleration, in_sd=True),
}
