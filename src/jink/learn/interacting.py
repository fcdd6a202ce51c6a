"""Fuzzy rules of all modes of an IMM and its transition matrix, found together on tracking errors."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import field, replace

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..models.fuzzy import FuzzyRules
from ..models.provenance import VERSION, Trained
from .candidates import errors_along_track
from .data import Runs, fingerprint
from .evolution import Chromosome, cma_es, search
from .genetic import FIELDS, NARROWEST, WIDEST
from .population import Errors, errors_of

# so that rules about a residual of zero still reach 0.3 sd of the sensor, the least that rules in metres may
NARROWEST_ALONG = 0.03
RAREST = 9.0  # −log of the least odds of leaving for another mode


@frozen
class FuzzyModes:
    """Modes and how they switch: rules of each, transition[i, j] per scan; ``across``: those across the track, where
    ``modes`` hold along it.
    """

    modes: tuple[FuzzyRules, ...]
    transition: Array
    across: tuple[FuzzyRules, ...] = ()


@frozen(kw_only=True)
class ModesEncoding:
    """Genes in [0, 1]: per mode and rule c1 s1 c2 s2 and the noise's sd (m/s², in logarithms from least to most), then
    the odds of going from mode i to mode j, e^−9 to 1 against staying. along_track: every mode has as many rules across
    the track, after those along it, whose residual has no sign."""

    modes: int
    rules: int
    reach: tuple[float, float]
    least: float
    most: float
    along_track: bool = field(default=False, repr=False)

    @property
    def rules_of_mode(self) -> int:
        """Of both directions where there are two."""
        return self.rules * (1 + self.along_track)

    @property
    def chromosome(self) -> Chromosome:
        """Its shape."""
        M = self.modes
        return Chromosome(genes=M * self.rules_of_mode * FIELDS + M * (M - 1), group=FIELDS)

    def decode(self, x: Array) -> tuple[Array, Array]:
        """tables (I, M, R, 5) in SI units, or (I, M, 2, R, 5) along and across the track, and transition (I, M, M)."""
        M, R = self.modes, self.rules_of_mode
        genes = x[:, : M * R * FIELDS].reshape(len(x), M, R, FIELDS)
        tables = np.empty_like(genes)
        narrowest = NARROWEST_ALONG if self.along_track else NARROWEST
        for i, reach in enumerate(self.reach):
            tables[..., 2 * i] = reach * (2 * genes[..., 2 * i] - 1)
            tables[..., 2 * i + 1] = reach * narrowest * (WIDEST / narrowest) ** genes[..., 2 * i + 1]
        tables[..., 4] = (self.least * (self.most / self.least) ** genes[..., 4]) ** 2
        odds = np.ones((len(x), M, M))
        odds[:, ~np.eye(M, dtype=bool)] = np.exp(-RAREST * x[:, M * R * FIELDS :])
        if self.along_track:
            tables = tables.reshape(len(x), M, 2, self.rules, FIELDS)
            tables[:, :, 1, :, 0] = 0.5 * (tables[:, :, 1, :, 0] + self.reach[0])
        return tables, odds / odds.sum(axis=2, keepdims=True)

    def modes_of(self, x: Array) -> FuzzyModes:
        """One chromosome's modes, quietest first."""
        tables, transition = self.decode(x[None])
        directions = tables[0].reshape(self.modes, -1, self.rules, FIELDS)
        order = np.argsort(directions[..., 4].mean(axis=(1, 2)))
        modes, *across = (tuple(FuzzyRules.of(directions[j, d]) for j in order) for d in range(directions.shape[1]))
        return FuzzyModes(modes, transition[0][np.ix_(order, order)], *across)


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
    along_track: bool = False,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[int, float], None] | None = None,
) -> FuzzyModes:
    """Modes whose rules and transition matrix make the mean error over the runs' scans small, by CMA-ES.

    Loss: (1 − velocity_share) ζ_p + velocity_share ζ_v, each over its value for three constant noises at a stay
    probability of .97; interval of the noise's sd in m/s²; reach of the rules 6 and 8 sd of the measurement. Each axis
    is a run of its own; ``along_track``: rules hold along and across the track, axes stay together.
    """
    encoding = ModesEncoding(
        modes=modes,
        rules=rules,
        reach=(6 * runs.sd, 8 * runs.sd),
        least=interval[0],
        most=interval[1],
        along_track=along_track,
    )
    what = f"{encoding}{', along the track' if along_track else ''}"
    usual = _mean_errors(_usual(runs))

    def loss(x: Array) -> Array:
        tables, transition = encoding.decode(x)
        if along_track:
            errors = errors_along_track(tables, transition, runs)
        else:
            errors = errors_of(tables, np.full((len(x), modes), rules), runs, transition=transition)
        position, velocity = _mean_errors(errors)
        return (1 - velocity_share) * position / usual[0] + velocity_share * velocity / usual[1]

    start = cma_es(encoding.chromosome, population=population, seed=seed)
    best, least = search(
        loss,
        start,
        generations,
        checkpoint=checkpoint,
        about=f"{what}, population {population}, seed {seed}, {fingerprint(runs)}",
        progress=(lambda generation, value, _: progress(generation, value)) if progress else None,
    )
    found = encoding.modes_of(best)
    trained = Trained(
        data=str(runs),
        method=f"cma on rules and transition matrix, population {population}, {generations} generations",
        seeds=(seed,),
        figures=(("error on the training runs over that of constant noises", least),),
        version=VERSION,
    )
    return replace(
        found,
        modes=tuple(replace(m, trained=trained) for m in found.modes),
        across=tuple(replace(m, trained=trained) for m in found.across),
    )


def _usual(runs: Runs) -> Errors:
    tables = np.ones((1, 3, 1, FIELDS))
    tables[0, :, 0, 4] = np.array([1.0, 10.0, 100.0]) ** 2
    stay = np.full((1, 3, 3), 0.015)
    stay[0][np.diag_indices(3)] = 0.97
    return errors_of(tables, np.ones((1, 3), dtype=np.int64), runs, transition=stay)


def _mean_errors(errors: Errors) -> tuple[Array, Array]:
    return np.nanmean(errors.position, axis=1), np.nanmean(errors.velocity, axis=1)
