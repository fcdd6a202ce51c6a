"""One filter fitted on two random families of targets, scored on fresh draws of them and on a scenario it was never
fitted on.

    python -m benchmarks.families [--modes aligned|joint] [--runs 400] [--check-runs 2000] [--seed 0] [-o families.json]
    python -m benchmarks.families --filter benchmarks/families.json      # score a filter from a file

Fitted on training draws of random-accelerations and random-turns together, by the error against the truth; efficiency
as in ``benchmarks.efficiency``. joint: constant velocity, acceleration, turn. aligned: five modes, with accelerations
along x, along y and along both, which suits manoeuvres that lie along the axes, as those of random-accelerations and
lee-2003 do; the family turned by random headings shows what that is worth where they do not. ``families.json`` is what
the first command, with its defaults, wrote: some minutes of work, which the tests spare themselves.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import jink
from jink.fit.data import Training
from jink.fit.fitting import chosen_objective, training_data
from jink.fit.optimise import Search
from jink.fit.parameters import Parameters
from jink.scenarios import SCENARIOS

from .efficiency import CHUNK, FAMILIES, against, planes, squares

TRAINED_ON = "random-accelerations,random-turns"
REACH = {
    "lee-2003": (1.09, 1.09),
    "random-accelerations": (1.09, 1.11),
    "random-turns": (1.07, 1.11),
}
CROSSING = 0.01  # m/s²: accelerations across a mode's own axis, and how they change


def acceleration(increment: Any, prior: Any) -> jink.ConstantAcceleration:
    """Constant acceleration, changes and prior in m/s²."""
    return jink.ConstantAcceleration(acceleration_increment_sd=increment, acceleration_prior_sd=prior)


def modes(name: str) -> tuple[list[Any], jink.Sojourn]:
    """Where a fit starts: motion models, and how long each lasts."""
    straight = jink.ConstantVelocity(acceleration_sd=0.5)
    turn = jink.CoordinatedTurn(acceleration_sd=2.0, turn_rate_sd=3e-4, turn_rate_prior_sd=0.06)
    if name == "joint":
        to = [[0, 0.5, 0.5], [0.95, 0, 0.05], [0.95, 0.05, 0]]
        return [straight, acceleration(1.0, 50.0), turn], jink.Sojourn([40.0, 15.0, 15.0], to)
    along = [acceleration((1.0, CROSSING), (50.0, CROSSING)), acceleration((CROSSING, 1.0), (CROSSING, 50.0))]
    to = [
        [0, 0.2, 0.2, 0.05, 0.55],
        [0.75, 0, 0.005, 0.24, 0.005],
        [0.75, 0.005, 0, 0.24, 0.005],
        [0.02, 0.48, 0.48, 0, 0.02],
        [0.94, 0.01, 0.01, 0.04, 0],
    ]
    return [straight, *along, acceleration(1.0, 50.0), turn], jink.Sojourn([27.0, 14.0, 14.0, 8.0, 15.0], to)


# of the modes along one axis these stay as they are: what lies across, and how constant the acceleration is along it
HELD = (
    "constant_acceleration.*.y",
    "constant_acceleration_2.*.x",
    "constant_acceleration*.acceleration_increment_sd.[xy]",
)


def fitted(name: str, runs: int, seed: int) -> tuple[Any, dict[str, Any]]:
    """The filter fitted on both families, and a record of it."""
    training: Training = training_data(
        TRAINED_ON, runs=runs, check_runs=1, seed=seed, kind="fighter", columns=None, truth=None
    )
    motions, stays = modes(name)
    start = jink.IMM(motions, jink.Position(sd=500.0), stays)  # each row brings its own noise
    parameters = Parameters(start, fixed=HELD if name == "aligned" else ())
    search = Search(parameters, chosen_objective("tracking", training, 1), training.tracks, starts=1, seed=seed)
    began = time.perf_counter()
    found = search.run()
    record = {"scenario": TRAINED_ON, "runs": runs, "seed": seed, "apart": "all", "objective": "tracking"}
    print(
        f"{name}: {len(parameters)} parameters fitted in {time.perf_counter() - began:.0f} s, {found.evaluations} "
        "evaluations"
    )
    return parameters.filter(found.u), record


def scored(filter: Any, scenario: str, runs: int, seed: int) -> Any:
    """Mean squared errors (runs, 2) of each fresh run: position, velocity."""
    import numpy as np

    parts = []
    for first in range(0, runs, CHUNK):
        made = SCENARIOS[scenario].simulate(range(first, min(first + CHUNK, runs)), seed)
        batch = made.batch()
        variance = float(made.scenario.observation.sensor.sd) ** 2
        noise = np.full(batch["z"].shape, variance)
        parts.append(squares(made, *planes(made, filter.filter(**batch, covariance=noise, outputs=("x",)))))
    return np.concatenate(parts)


def report(filter: Any, runs: int, seed: int) -> None:
    """Print a line of efficiencies for each scenario."""
    print(f"{'efficiency, ' + str(runs) + ' fresh runs':<30}{'position':>16}{'reach':>7}{'velocity':>18}{'reach':>7}")
    for family in FAMILIES:
        square = scored(filter, family.scenario, runs, seed)
        cells = []
        for k in (0, 1):
            value, se = against(family.published[k], square[:, k])
            reach = REACH.get(family.scenario)
            cells.append(f"{value:.3f} ± {se:.3f}{'' if reach is None else f'{reach[k]:.2f}':>8}")
        print(f"{family.scenario:<32}{cells[0]:<24}{cells[1]}")


def main() -> None:
    """Fit, or read a filter; print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--modes", choices=("aligned", "joint"), default="aligned")
    parser.add_argument("--filter", metavar="FILE", help="a filter to score instead of fitting one")
    parser.add_argument("--runs", type=int, default=400, help="training draws of each family")
    parser.add_argument("--check-runs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", "--output", metavar="FILE.json")
    given = parser.parse_args()
    filter, record = (jink.load(given.filter), {}) if given.filter else fitted(given.modes, given.runs, given.seed)
    if given.output:
        filter.save(given.output, fitted=record)
    report(filter, given.check_runs, given.seed + 1)


if __name__ == "__main__":
    main()
