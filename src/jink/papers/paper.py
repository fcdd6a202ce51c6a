"""What a paper is here: its experiments with their published figures, and what it leaves open."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any

import numpy as np

from ..catalogue.purpose import Named, Purpose
from ..checks import Array
from ..compare.result import Race
from ..compare.scores import NAN, Tally, efficiency
from ..frozen import frozen
from ..metrics import Figure
from ..metrics.figure import ratio_influence, spread
from ..scenarios import Scenario, Simulation
from .drawing import Drawing
from .learned import Models

Maker = Callable[[Purpose], Named]
BASELINES = ("raw", "kalman-cv", "kalman-ca", "imm")
TIMED_RUNS, ROUNDS = 200, 15  # of a comparison of run times


@frozen
class Metric:
    """A figure of merit: name in the JSON, words with the unit for people, and how it is read off a race."""

    name: str
    words: str
    measure: Callable[[Race, str], Figure]


def of_race(name: str, words: str) -> Metric:
    """A metric that the race itself has (see :data:`jink.compare.result.METRICS`)."""
    return Metric(name, words, lambda race, filter: race.figure(filter, name))


POSITION = of_race("position_rmse", "position m")
VELOCITY = of_race("velocity_rmse", "velocity m/s")
ACCELERATION = of_race("acceleration_rmse", "accel. m/s²")
NEES = of_race("nees", "NEES per component")
MODE_DELAY = of_race("mode_jump_delay", "mode delay scans")


def peak(name: str, words: str, begin: int, end: int) -> Metric:
    """The largest position RMSE (m) of the scans begin … end − 1, counted from 1, and its standard error."""

    def measure(race: Race, filter: str) -> Figure:
        value, se = race.tallies[filter].over_time("position")
        skipped = race.skipped_scans
        scans = slice(begin - 1 - skipped, end - 1 - skipped)
        k = int(value[scans].argmax())
        return Figure(float(value[scans][k]), float(se[scans][k]))

    return Metric(name, words, measure)


def peak_over(reference: str, begin: int, end: int) -> Metric:
    """That peak over another filter's."""
    own = peak("", "", begin, end)

    def measure(race: Race, filter: str) -> Figure:
        if filter == reference or reference not in race.tallies or filter in BASELINES:
            return NAN
        mine, other = own.measure(race, filter), own.measure(race, reference)
        ratio = mine.value / other.value
        return Figure(ratio, ratio * math.hypot(mine.se / mine.value, other.se / other.value))

    return Metric(f"peak_over_{reference}", f"peak ÷ {reference.upper()}", measure)


def over_within(reference: str, quantity: str, words: str, begin: int, end: int) -> Metric:
    """The RMSE of position, velocity or acceleration over another filter's, both over the scans begin … end − 1
    alone, counted from 1; paired run by run.
    """

    def measure(race: Race, filter: str) -> Figure:
        if filter == reference or reference not in race.tallies or filter in BASELINES:
            return NAN
        scans = slice(max(begin - 1 - race.skipped_scans, 0), end - 1 - race.skipped_scans)
        (mine, a), (theirs, b) = (_within(race.tallies[name], quantity, scans) for name in (filter, reference))
        return Figure(mine / theirs, spread((a - mine / theirs * b) / theirs))

    return Metric(f"{quantity}_rmse_over_{reference}_{begin}_{end - 1}", words, measure)


def _within(tally: Tally, quantity: str, scans: slice) -> tuple[float, Array]:
    """RMSE over some scans, and the influence of each group of runs on it."""
    kept = tally.curves["runs"][:, 0] > 0
    square, count = (tally.curves[f"{quantity}_{each}"][kept, scans].sum(axis=1) for each in ("square", "there"))
    value, influence = ratio_influence(square, count)
    root = math.sqrt(value)
    return root, influence / (2 * root)


def over(reference: str, metric: Metric, words: str) -> Metric:
    """The filter's figure over that of another filter of the race, paired run by run."""

    def measure(race: Race, filter: str) -> Figure:
        if filter == reference or reference not in race.tallies or filter in BASELINES:
            return NAN
        mine, other = race.tallies[filter], race.tallies[reference]
        if metric.name not in mine.totals or metric.name not in other.totals:
            return NAN
        return efficiency(mine, other, metric.name)

    return Metric(f"{metric.name}_over_{reference}", words, measure)


def time_over(reference: str, words: str, scenario: Scenario) -> Metric:
    """The filter's processor time over another's: median of rounds in which both, in turn, filter the same runs."""

    def measure(race: Race, filter: str) -> Figure:
        if filter == reference or reference not in race.tallies or filter in BASELINES:
            return NAN
        simulation = scenario.simulate(TIMED_RUNS, race.seed)
        mine, other = race.entrants[filter].filter, race.entrants[reference].filter
        ratios = np.array([_seconds(mine, simulation) / _seconds(other, simulation) for _ in range(ROUNDS)])
        return Figure(float(np.median(ratios)), 1.253 * float(ratios.std(ddof=1)) / math.sqrt(ROUNDS))

    return Metric(f"time_over_{reference}", words, measure)


def _seconds(filter: Any, simulation: Simulation) -> float:
    began = clock.process_time()
    filter.filter(**simulation.batch(), threads=1, outputs=("x",))
    return clock.process_time() - began


@frozen(kw_only=True)
class Experiment:
    """A race on one scenario: the paper's filters beside the baselines that it left out.

    filters by name, each made for the purpose, or several of one name, trained from different seeds, whose median
    counts; metrics; published (filter, metric name): the paper's figures, also of filters that do not take part; first:
    scans that do not count; baselines: names in the race; group: experiments of one group share a table of that
    heading; share of the asked runs that this one takes.
    """

    name: str
    scenario: Scenario
    filters: Mapping[str, Maker | Sequence[Maker]]
    metrics: tuple[Metric, ...]
    published: Mapping[tuple[str, str], float] = field(default_factory=dict)
    first: int = 2
    baselines: tuple[str, ...] = BASELINES
    words: str = ""
    group: str = ""
    share: float = 1.0

    def members(self, name: str) -> list[str]:
        """What the filters of this name are called in the race."""
        given = self.filters.get(name)
        return [f"{name} #{k}" for k in range(len(given))] if isinstance(given, Sequence) else [name]

    def makers(self) -> dict[str, Maker]:
        """All filters as the race takes them."""
        out: dict[str, Maker] = {}
        for name, given in self.filters.items():
            out.update(zip(self.members(name), given if isinstance(given, Sequence) else [given], strict=True))
        return out


@frozen(kw_only=True)
class Paper:
    """One paper: what it is, its experiments, the readings taken where it leaves something open, its drawings.

    runs and quick_runs: Monte Carlo runs by default and with --quick; experiments(models) with the learned filters as
    they come with the package or trained again; draw(experiment name → race) → the paper's figures.
    """

    name: str
    source: str
    runs: int
    quick_runs: int
    experiments: Callable[[Models], list[Experiment]]
    readings: tuple[str, ...]
    remarks: tuple[str, ...] = ()
    draw: Callable[[Mapping[str, Race]], list[Drawing]] = lambda races: []


@frozen
class Row:
    """One figure: published (None where the paper gives none) beside measured (None where nothing was), with its se."""

    experiment: str
    filter: str
    metric: str
    published: float | None
    measured: float | None
    se: float | None

    def as_dict(self) -> dict[str, Any]:
        """As the JSON has it."""
        return dict(self.__dict__)


def named(words: str, filter: Any, fitted: str = "") -> Named:
    """A filter of a paper and what it is, in words."""
    return Named(filter=filter, words=words, fitted=fitted)


def rows_of(experiment: Experiment, race: Race) -> list[Row]:
    """The paper's filters first, then what it left out; a metric that a filter lacks has no row."""
    published = dict.fromkeys(name for name, _ in experiment.published)
    rows = []
    for name in dict.fromkeys([*experiment.filters, *published, *experiment.baselines]):
        for metric in experiment.metrics:
            claimed = experiment.published.get((name, metric.name))
            found = median(experiment, race, name, metric)[1]
            if claimed is None and math.isnan(found.value):
                continue
            rows.append(Row(experiment.name, name, metric.name, claimed, _plain(found.value), _plain(found.se)))
    return rows


def median(experiment: Experiment, race: Race, name: str, metric: Metric) -> tuple[str, Figure]:
    """The race's name and figure of a filter; of several seeds the one in the middle. NaN where it did not take
    part.
    """
    there = [member for member in experiment.members(name) if member in race.tallies]
    found = sorted(((member, metric.measure(race, member)) for member in there), key=lambda each: each[1].value)
    return found[(len(found) - 1) // 2] if found else (name, NAN)


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
