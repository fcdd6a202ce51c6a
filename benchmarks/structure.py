"""What a variable structure gains and loses: three modes alive of forty against all forty, speed and accuracy side by
side.

`slow`: of choi-2001's forty levels of acceleration noise the target's walks to a neighbour in one scan of twenty, which
is what the filters believe; positions of 10 m, so that the level matters (with the paper's 1 m all filters come within
2 %). `best level` is the Kalman filter of the level that turns out best. The adaptive grid runs over the same range in
equal ratios, its points never nearer than `APART` of forty levels, 6.6 times in variance; over choi-2001's equal
differences and with points that may come as near as a level, measurements cannot tell them apart and the grid does not
move. `IMM of 3` has three levels in equal ratios, which stay where they are. Then choi-2001's scenarios, where the
level that fits jumps from end to end.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import jink
from jink.filters.variable_structure import (
    CHOI_2001,
    ActiveDigraph,
    AdaptiveGrid,
    DigraphSwitching,
    line_transition,
    noise_levels,
)
from jink.scenarios import by_name

from .cases import STEP, Array
from .race import Job

SLOW_SD, CHOI_SD = 10.0, 1.0  # m
STAY = 0.95
SETTLED = 20  # scans of the slow scenario before its errors count
FIRST = 2  # scans of choi-2001's before theirs do: the two-point start
JUMPS = tuple(f"choi-2001-{k}" for k in "1234")
ALL, BEST = "IMM of 40", "best level"
GRID, APART = np.geomspace(CHOI_2001[0], CHOI_2001[-1], len(CHOI_2001)), 14.0
METHODS = {
    ALL: lambda modes, sensor, chain: jink.IMM(modes, sensor, chain, mode_probability=_first(len(modes))),
    "digraph switching": DigraphSwitching,
    "active digraph, 3 alive": ActiveDigraph,
    "adaptive grid": lambda modes, sensor, chain: AdaptiveGrid(noise_levels(GRID), sensor, STAY, least_step=APART),
    "adaptive grid, points a level apart": lambda modes, sensor, chain: AdaptiveGrid(modes, sensor, STAY),
    "IMM of 3": lambda modes, sensor, chain: jink.IMM(
        noise_levels(np.geomspace(CHOI_2001[0], CHOI_2001[-1], 3)), sensor, line_transition(3, stay=STAY)
    ),
}


def filters(sd: float) -> dict[str, Any]:
    """All forty levels, and three at a time by each method; tracks begin in the first."""
    modes, sensor = noise_levels(CHOI_2001), jink.Position(sd=sd)
    chain = line_transition(len(modes), stay=STAY)
    return {name: make(modes, sensor, chain) for name, make in METHODS.items()}


def slow(tracks: int, scans: int, seed: int = 7) -> dict[str, Any]:
    """Positions, measurements and times of targets whose level of acceleration noise walks slowly up and down."""
    generator = np.random.default_rng(seed)
    variance, level = np.asarray(CHOI_2001, dtype=float), np.zeros(tracks, dtype=int)
    position, velocity = np.zeros((tracks, scans, 2)), np.zeros((tracks, 2))
    for k in range(1, scans):
        moves = (generator.random(tracks) < 1 - STAY) * generator.choice([-1, 1], tracks)
        level = np.abs(level + moves)
        level = np.minimum(level, 2 * len(variance) - 2 - level)  # thrown back at both ends
        a = np.sqrt(variance[level])[:, None] * generator.standard_normal((tracks, 2))
        position[:, k] = position[:, k - 1] + STEP * velocity + STEP**2 / 2 * a
        velocity = velocity + STEP * a
    z = position + SLOW_SD * generator.standard_normal(position.shape)
    return {
        "position": position,
        "time": np.tile(np.arange(scans) * STEP, tracks),
        "z": z.reshape(-1, 2),
        "offsets": np.arange(tracks + 1) * scans,
    }


def jobs(tracks: int, scans: int) -> dict[str, Job]:
    """Each method over the slow scenario."""
    data = slow(tracks, scans)
    return {name: Job(_runner(each, data), tracks * scans) for name, each in filters(SLOW_SD).items()}


def accuracy(tracks: int, scans: int, runs: int) -> dict[str, dict[str, list[float]]]:
    """Position RMSE (m) and its standard error, by scenario and method; of raw measurements and of the best level
    too.
    """
    out = {"slow": _accuracy(slow(tracks, scans), min(SETTLED, scans // 2), SLOW_SD)}
    for name in JUMPS:
        seen = by_name(name).simulate(runs, seed=1)
        out[name] = _accuracy({"position": seen.truth.position, **seen.batch()}, FIRST, CHOI_SD)
    return out


def _accuracy(data: dict[str, Any], first: int, sd: float) -> dict[str, list[float]]:
    truth = data["position"]

    def rms(filter_: Any) -> list[float]:
        x = _runner(filter_, data)(None).reshape(*truth.shape[:2], -1)
        return _rms(x[:, first:, [0, 2]] - truth[:, first:])

    found = {name: rms(each) for name, each in filters(sd).items()}
    found[BEST] = min(rms(jink.Kalman(level, jink.Position(sd=sd))) for level in noise_levels(CHOI_2001))
    return {"raw": _rms(data["z"].reshape(truth.shape)[:, first:] - truth[:, first:]), **found}


def _runner(filter_: Any, data: dict[str, Any]) -> Any:
    def run(_: None) -> Array:
        return filter_.filter(
            data["time"], data["z"], offsets=data["offsets"], threads=1, outputs=("x", "log_likelihood")
        ).x

    return run


def _rms(error: Array) -> list[float]:
    """Of both axes together, and its standard error from run to run."""
    square = (error**2).sum(axis=-1).mean(axis=-1)
    rms = float(np.sqrt(square.mean()))
    return [rms, float(square.std(ddof=1) / np.sqrt(len(square)) / (2 * rms)) if len(square) > 1 else 0.0]


def _first(modes: int) -> list[float]:
    """As the variable structures begin: nearly all of it in the first mode, the rest in its neighbour."""
    return [0.95, 0.05, *[0.0] * (modes - 2)]
