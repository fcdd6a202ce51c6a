"""Identification of fuzzy rules by a genetic algorithm: structure and parameters together."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..checks import Array, positive
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.fuzzy import FuzzyRules
from ..models.provenance import VERSION, Trained
from ..models.sensor import Position
from ..scenarios import Observation, Scenario, Schedule
from ..scenarios.legs import Legs
from .data import Runs, fingerprint, from_scenario
from .evolution import OPTIMISERS, Chromosome, cma_es, genetic, search
from .population import errors_of

FIELDS = 5  # of a rule: c1 s1 c2 s2 w
NARROWEST, WIDEST = 0.02, 2.0  # a membership's spread, in ranges of its input


@frozen(kw_only=True)
class Settings:
    """Table 1 of the paper; weight is its λ. unit (m): errors count in it, the paper's in kilometres.

    widen: factor by which the noise's sd may leave the paper's interval at either end.
    """

    generations: int = 100
    most_rules: int = 50
    population: int = 500
    crossover: float = 0.9
    mutation: float = 0.01
    weight: float = 0.95
    unit: float = 1000.0
    widen: float = 1.0
    optimiser: str = "ga"

    def __post_init__(self) -> None:
        if self.optimiser not in OPTIMISERS:
            raise ValueError(f"optimiser: expected one of {', '.join(OPTIMISERS)}, got {self.optimiser!r}")
        if not 0 <= self.weight <= 1:
            raise ValueError(f"weight: expected a number from 0 to 1, got {self.weight:g}")
        for name in ("generations", "most_rules", "population"):
            if int(getattr(self, name)) != getattr(self, name) or getattr(self, name) < 1:
                raise ValueError(f"{name}: expected a whole number from 1, got {getattr(self, name)!r}")
        positive("unit", self.unit)
        if positive("widen", self.widen) < 1:
            raise ValueError(f"widen: expected a number from 1, got {self.widen:g}")


@frozen(kw_only=True)
class Encoding:
    """Chromosomes and what they mean: a parameter string, five genes a rule, and a binary string of the rules that
    hold.

    Genes run from 0 to 1 over: centres ± reach of the residual and of its change (m), spreads from .02 to 2 reaches in
    logarithms, noise sd (m/s²) from ``least`` to ``most``.
    """

    rules: int
    reach: tuple[float, float]
    least: float
    most: float

    @property
    def chromosome(self) -> Chromosome:
        """Its shape."""
        return Chromosome(genes=self.rules * (FIELDS + 1), bits=self.rules, group=FIELDS)

    def decode(self, x: Array) -> tuple[Array, NDArray[np.int64]]:
        """tables (I, 1, rules, 5) in SI units with the rules that hold first, and their count (I, 1), at least one."""
        parameters = x[:, : self.rules * FIELDS].reshape(len(x), self.rules, FIELDS)
        holds = x[:, self.rules * FIELDS :] >= 0.5
        holds[~holds.any(axis=1), 0] = True
        tables = np.empty_like(parameters)
        for i, reach in enumerate(self.reach):
            tables[..., 2 * i] = reach * (2 * parameters[..., 2 * i] - 1)
            tables[..., 2 * i + 1] = reach * NARROWEST * (WIDEST / NARROWEST) ** parameters[..., 2 * i + 1]
        tables[..., 4] = (self.least + (self.most - self.least) * parameters[..., 4]) ** 2
        order = np.argsort(~holds, axis=1, kind="stable")
        tables = np.take_along_axis(tables, order[..., None], axis=1)
        return tables[:, None], holds.sum(axis=1, dtype=np.int64)[:, None]

    def rules_of(self, x: Array) -> FuzzyRules:
        """One chromosome's rules."""
        tables, count = self.decode(x[None])
        return FuzzyRules.of(tables[0, 0, : count[0, 0]])


def fitness(error: Array, rules: NDArray[np.int64], weight: float) -> Array:
    """λ/(error + 1) + (1 − λ)/(rules + 1). Source: Lee, Joo & Park 2003, eq. 16."""
    return weight / (error + 1) + (1 - weight) / (rules + 1)


def total_error(position: Array, velocity: Array) -> Array:
    """√((Σ position error)² + (Σ velocity error)²), the sums over the scans (I, S) of errors; eq. 17."""
    return np.sqrt(np.nansum(position, axis=-1) ** 2 + np.nansum(velocity, axis=-1) ** 2)


def noise_interval(acceleration: float, process_sd: float) -> tuple[float, float]:
    """½(a_M + √q) ≤ σ* ≤ a_M + √q, m/s². Source: Lee, Joo & Park 2003, eq. 15 (Bar-Shalom & Li 1993)."""
    return 0.5 * (acceleration + process_sd), acceleration + process_sd


def training_runs(
    acceleration: float,
    *,
    runs: int = 10,
    scans: int = 60,
    sd: float = 500.0,
    process_sd: float = 1.0,
    interval: float = 1.0,
    seed: int = 0,
) -> Runs:
    """A target that accelerates by ± acceleration (m/s²) in the middle third of its scans, interval s apart, along one
    axis.

    The paper does not say what it trained on: this is the plainest target with the sub-model's input and the paper's
    noises.
    """
    positive("acceleration", acceleration)

    def truth(draws: Draws) -> Legs:
        command = np.zeros((len(draws), scans, 1))
        sign = np.where(draws.runs % 2 == 0, 1.0, -1.0)
        command[:, scans // 3 : 2 * scans // 3, 0] = acceleration * sign[:, None]
        noise = process_sd * draws.normal(scans, 1)
        return Legs(
            interval * np.arange(scans, dtype=np.float64)[None, :],
            np.zeros((1, 1)),
            np.full((1, 1), 15.0),
            command,
            noise=noise,
        )

    return from_scenario(
        Scenario(
            name=f"input-{acceleration:g}",
            summary=f"± {acceleration:g} m/s² in the middle third",
            truth=truth,
            observation=Observation(sensor=Position(sd=sd, axes=1)),
            schedule=Schedule(start=interval, interval=interval, count=scans),
            axes=1,
        ),
        runs,
        seed,
    )


def encoding_for(acceleration: float, runs: Runs, settings: Settings, process_sd: float = 1.0) -> Encoding:
    """The ranges for a sub-model: residuals as a filter of the middle noise shows them on the runs, noise by eq. 15."""
    least, most = noise_interval(acceleration, process_sd)
    return Encoding(
        rules=settings.most_rules,
        reach=_reach(runs, np.sqrt(least * most)),
        least=least / settings.widen,
        most=most * settings.widen,
    )


def _reach(runs: Runs, acceleration_sd: float) -> tuple[float, float]:
    """The largest residual and change of it, in m, of a filter with constant noise."""
    from ..filters.kalman import Kalman
    from ..models.motion import ConstantVelocity
    from .aid import watch

    apart = runs.axes_apart()
    motion = ConstantVelocity(acceleration_sd=acceleration_sd)
    seen = watch(Kalman(motion, Position(sd=runs.sd, axes=1)), apart)
    residual = np.where(seen.updated, seen.innovation, np.nan)[..., 0]
    change = np.diff(residual, axis=1)
    return float(np.nanmax(np.abs(residual))), float(np.nanmax(np.abs(change)))


def identify(
    acceleration: float,
    runs: Runs | None = None,
    *,
    settings: Settings | None = None,
    process_sd: float = 1.0,
    seed: int = 0,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[int, float, int], None] | None = None,
) -> FuzzyRules:
    """The rules of the sub-model for inputs of so many m/s², found on the runs (by default :func:`training_runs`).

    progress is called with the generation, the best fitness so far and the number of its rules; checkpoint as in
    :func:`jink.learn.evolution.search`. The same seed finds the same rules.
    Source: Lee, Joo & Park 2003, §3.1; operators and premise ranges, which it leaves out, in docs/learning.md.
    """
    s = settings or Settings()
    data = runs if runs is not None else training_runs(acceleration, process_sd=process_sd, seed=seed)
    encoding = encoding_for(acceleration, data, s, process_sd)

    def loss(x: Array) -> Array:
        tables, count = encoding.decode(x)
        errors = errors_of(tables, count, data)
        error = total_error(errors.position / s.unit, errors.velocity / s.unit)
        return -fitness(error, count[:, 0], s.weight)

    def tell(generation: int, least: float, best: Array) -> None:
        if progress:
            progress(generation, -least, len(encoding.rules_of(best)))

    start = (
        genetic(encoding.chromosome, population=s.population, crossover=s.crossover, mutation=s.mutation, seed=seed)
        if s.optimiser == "ga"
        else cma_es(encoding.chromosome, population=s.population, seed=seed)
    )
    best, least = search(
        loss,
        start,
        s.generations,
        checkpoint=checkpoint,
        about=f"{s}, input {acceleration:g} m/s², seed {seed}, {fingerprint(data)}",
        progress=tell,
    )
    found = encoding.rules_of(best)
    trained = Trained(
        data=f"{data}, input {acceleration:g} m/s²",
        method=f"{s.optimiser}, population {s.population}, {s.generations} generations, at most {s.most_rules} "
        f"rules, λ = {s.weight:g}",
        seeds=(seed,),
        figures=(("fitness on the training runs", -least),),
        version=VERSION,
    )
    return FuzzyRules(found.centres, found.spreads, found.variances, trained)
