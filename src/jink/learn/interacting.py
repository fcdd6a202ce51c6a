"""Fuzzy rules of all modes of an IMM and its transition matrix, found together on tracking errors."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..checks import Array
from ..models.fuzzy import FuzzyRules
from ..models.provenance import Trained
from .data import Runs, fingerprint
from .evolution import Chromosome, cma_es, search
from .genetic import FIELDS, NARROWEST, WIDEST
from .population import Errors, errors_of

RAREST = 9.0  # −log of the least odds of leaving for another mode


@dataclass(frozen=True)
class FuzzyModes:
    """Modes and how they switch: rules of each, transition[i, j] per scan."""

    modes: tuple[FuzzyRules, ...]
    transition: Array


@dataclass(frozen=True, kw_only=True)
class ModesEncoding:
    """Genes in [0, 1]: per mode and rule c1 s1 c2 s2 and the noise's sd (m/s², in logarithms from least to most), then
    the odds of going from mode i to mode j, e^−9 to 1 against staying."""

    modes: int
    rules: int
    reach: tuple[float, float]
    least: float
    most: float

    @property
    def chromosome(self) -> Chromosome:
        """Its shape."""
        return Chromosome(genes=self.modes * self.rules * FIELDS + self.modes * (self.modes - 1), group=FIELDS)

    def decode(self, x: Array) -> tuple[Array, Array]:
        """tables (I, M, R, 5) in SI units and transition (I, M, M)."""
        M, R = self.modes, self.rules
        genes = x[:, : M * R * FIELDS].reshape(len(x), M, R, FIELDS)
        tables = np.empty_like(genes)
        for i, reach in enumerate(self.reach):
            tables[..., 2 * i] = reach * (2 * genes[..., 2 * i] - 1)
            tables[..., 2 * i + 1] = reach * NARROWEST * (WIDEST / NARROWEST) ** genes[..., 2 * i + 1]
        tables[..., 4] = (self.least * (self.most / self.least) ** genes[..., 4]) ** 2
        odds = np.ones((len(x), M, M))
        odds[:, ~np.eye(M, dtype=bool)] = np.exp(-RAREST * x[:, M * R * FIELDS :])
        return tables, odds / odds.sum(axis=2, keepdims=True)

    def modes_of(self, x: Array) -> FuzzyModes:
        """One chromosome's modes, quietest first."""
        tables, transition = self.decode(x[None])
        order = np.argsort(tables[0, :, :, 4].mean(axis=1))
        modes = tuple(FuzzyRules.of(tables[0, j]) for j in order)
        return FuzzyModes(modes, transition[0][np.ix_(order, order)])


def identify_modes(
    runs: Runs,
    *,
    modes: int = 3,
    rules: int = 2,
    interval: tuple[float, float] = (0.1, 200.0),
    velocity_share: float = 0.5,
    population: int = 24,
    generations: int = 300,
    seed: int = 0,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[int, float], None] | None = None,
) -> FuzzyModes:
    """Modes whose rules and transition matrix make the mean error over the runs' scans small, by CMA-ES.

    Loss: (1 − velocity_share) ζ_p + velocity_share ζ_v, each over its value for three constant noises at a stay
    probability of .97; interval of the noise's sd in m/s²; reach of the rules 6 and 8 sd of the measurement.
    """
    encoding = ModesEncoding(
        modes=modes, rules=rules, reach=(6 * runs.sd, 8 * runs.sd), least=interval[0], most=interval[1]
    )
    usual = _mean_errors(_usual(runs))

    def loss(x: Array) -> Array:
        tables, transition = encoding.decode(x)
        count = np.full((len(x), modes), rules)
        position, velocity = _mean_errors(errors_of(tables, count, runs, transition=transition))
        return (1 - velocity_share) * position / usual[0] + velocity_share * velocity / usual[1]

    start = cma_es(encoding.chromosome, population=population, seed=seed)
    best, least = search(
        loss,
        start,
        generations,
        checkpoint=checkpoint,
        about=f"{encoding}, population {population}, seed {seed}, {fingerprint(runs)}",
        progress=(lambda generation, value, _: progress(generation, value)) if progress else None,
    )
    found = encoding.modes_of(best)
    trained = Trained(
        data=str(runs),
        method=f"cma on rules and transition matrix, population {population}, {generations} generations",
        seeds=(seed,),
        figures=(("error on the training runs over that of constant noises", least),),
    )
    return FuzzyModes(
        tuple(FuzzyRules(m.centres, m.spreads, m.variances, trained) for m in found.modes), found.transition
    )


def _usual(runs: Runs) -> Errors:
    tables = np.ones((1, 3, 1, FIELDS))
    tables[0, :, 0, 4] = np.array([1.0, 10.0, 100.0]) ** 2
    stay = np.full((1, 3, 3), 0.015)
    stay[0][np.diag_indices(3)] = 0.97
    return errors_of(tables, np.ones((1, 3), dtype=np.int64), runs, transition=stay)


def _mean_errors(errors: Errors) -> tuple[Array, Array]:
    return np.nanmean(errors.position, axis=1), np.nanmean(errors.velocity, axis=1)
