"""How close the default filter of fast targets comes to the best that is possible, on random families of targets.

    python -m benchmarks.efficiency [--runs 500] [--seed 1] [--family random-turns]

Efficiency = RMSE over both axes, scans 5 and later (counted from 0), over that of a reference that knows how the
targets are drawn. Printed against the references' published figures (position m, velocity m/s), and, with less
scatter, against the same reference run on the same measurements (``jink.references``). On lee-2003, which is one
fixed trajectory, the reference believes in random accelerations: values below 1 are possible there.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

from jink import default_filter
from jink.compare import Reference, near_optimal, near_optimal_turned
from jink.compare.priors import RandomAccelerations, RandomTurns
from jink.scenarios import SCENARIOS
from jink.scenarios.scenario import Simulation

FIRST = 5
CHUNK = 500  # runs at a time


@dataclass(frozen=True)
class Family:
    """A scenario, its reference's published RMSE in position and velocity, and the efficiencies to reach."""

    scenario: str
    prior: RandomAccelerations | RandomTurns | None
    published: tuple[float, float]
    reach: tuple[float, float]
    turned: bool = False  # the reference does not know by how much the axes are turned


ACCELERATIONS = RandomAccelerations()
FAMILIES = (
    Family("lee-2003", ACCELERATIONS, (342.4, 87.3), (1.09, 1.09)),
    Family("random-accelerations", ACCELERATIONS, (387.7, 125.5), (1.09, 1.11)),
    Family("random-accelerations-turned", ACCELERATIONS, (387.7, 125.5), (1.09, 1.11), turned=True),
    Family("random-turns", RandomTurns(), (37.99, 14.85), (1.08, 1.12)),
)


@dataclass(frozen=True)
class Errors:
    """Mean squared error of every run (runs, 2): position, velocity."""

    filtered: np.ndarray
    smoothed: np.ndarray
    reference: np.ndarray | None


def measure(family: Family, runs: int, seed: int, kind: str = "fighter", reference: bool = True) -> Errors:
    """Filter, smooth and (if asked, where there is one) run the reference on the same measurements."""
    parts: list[Errors] = []
    for first in range(0, runs, CHUNK):
        made = SCENARIOS[family.scenario].simulate(range(first, min(first + CHUNK, runs)), seed)
        sensor = made.scenario.observation.sensor
        imm = default_filter(kind, sensor)
        best = None
        if reference and family.prior is not None:
            tree = reference_of(family, made.z, float(sensor.sd))
            best = squares(made, tree.position, tree.velocity)
        verbs = (imm.filter, imm.smooth)
        found = (verb(**made.batch(), threads=1, outputs=("x",)) for verb in verbs)
        mine = [squares(made, *planes(made, estimate)) for estimate in found]
        parts.append(Errors(mine[0], mine[1], best))
    best = None if parts[0].reference is None else np.concatenate([p.reference for p in parts])
    return Errors(np.concatenate([p.filtered for p in parts]), np.concatenate([p.smoothed for p in parts]), best)


def reference_of(family: Family, z: np.ndarray, sd: float) -> Reference:
    """What can be known at best."""
    if family.turned:
        return near_optimal_turned(z, ACCELERATIONS, sd=sd)
    assert family.prior is not None
    return near_optimal(z, family.prior, sd=sd)


def planes(made: Simulation, estimate) -> list[np.ndarray]:
    """Position and velocity (runs, scans, 2) of an estimate of all runs laid end to end."""
    shape = (*made.z.shape[:2], -1)
    return [np.stack([estimate[c + "x"], estimate[c + "y"]], axis=-1).reshape(shape) for c in "pv"]


def squares(made: Simulation, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """(runs, 2) mean over scans of the squared distance to the truth."""
    pairs = ((position, made.truth.position), (velocity, made.truth.velocity))
    return np.stack([((a - b)[:, FIRST:] ** 2).sum(axis=-1).mean(axis=1) for a, b in pairs], axis=1)


def against(published: float, square: np.ndarray) -> tuple[float, float]:
    """RMSE over a published figure, and its standard error (the published figure's own not included)."""
    rmse = np.sqrt(square.mean())
    return rmse / published, square.std(ddof=1) / np.sqrt(len(square)) / (2 * rmse * published)


def paired(square: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """√(mean a / mean b) over the same runs, and its standard error by linearisation."""
    ratio = np.sqrt(square.mean() / other.mean())
    rest = (square - ratio**2 * other) / other.mean()
    return ratio, rest.std(ddof=1) / np.sqrt(len(square)) / (2 * ratio)


def lines(family: Family, errors: Errors) -> list[str]:
    """One line for position, one for velocity."""
    out = []
    for k, what in enumerate(("position", "velocity")):
        cells = [f"{family.scenario if not k else '':<28}{what:<10}{family.reach[k]:>6.2f}"]
        figures = [against(family.published[k], errors.filtered[:, k])]
        if errors.reference is not None:
            figures.append(paired(errors.filtered[:, k], errors.reference[:, k]))
        cells += [f"{value:.3f} ± {se:.3f}" for value, se in figures] + [" " * 13] * (2 - len(figures))
        gain = paired(errors.smoothed[:, k], errors.filtered[:, k])
        out.append("   ".join([*cells, f"{gain[0]:.3f} ± {gain[1]:.3f}"]))
    return out


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--family", choices=[family.scenario for family in FAMILIES])
    given = parser.parse_args()
    print(f"default filter of fighters, {given.runs} runs, seed {given.seed}")
    print(f"{'':<28}{'':<10}{'reach':>6}   {'published':<13}   {'same runs':<13}   smoothed/filtered")
    for family in FAMILIES:
        if given.family not in (None, family.scenario):
            continue
        print("\n".join(lines(family, measure(family, given.runs, given.seed))))


if __name__ == "__main__":
    main()
