"""Reproduce a paper: race by race, then its rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ..compare.result import Race
from ..compare.simulated import race
from ..io.errors import InputError
from .learned import Models, retrained, shipped
from .paper import Experiment, Paper, Row, rows_of


@dataclass
class Outcome:
    """What was measured of a paper: rows, and the race behind every experiment; partial: interrupted before all were
    done.
    """

    paper: Paper
    runs: int
    seed: int
    experiments: list[Experiment] = field(default_factory=list)
    races: dict[str, Race] = field(default_factory=dict)
    rows: list[Row] = field(default_factory=list)
    partial: bool = False

    def add(self, experiment: Experiment, race: Race) -> None:
        """One experiment is done, or interrupted."""
        self.experiments.append(experiment)
        self.races[experiment.name] = race
        self.rows += rows_of(experiment, race)
        self.partial = race.partial

    def of(self, experiment: Experiment) -> list[Row]:
        """The rows of one experiment."""
        return [row for row in self.rows if row.experiment == experiment.name]

    def as_dict(self) -> dict[str, Any]:
        """What `--json` writes: "rows" are {"experiment", "filter", "metric", "published", "measured", "se"}, null
        where there is none.
        """
        return {
            "paper": self.paper.name,
            "runs": self.runs,
            "rows": [row.as_dict() for row in self.rows],
            "seed": self.seed,
            "partial": self.partial,
            "source": self.paper.source,
            "readings": list(self.paper.readings),
            "remarks": list(self.paper.remarks),
            "filters": {e.name: {n: t.words for n, t in self.races[e.name].entrants.items()} for e in self.experiments},
        }


def run(
    paper: Paper,
    runs: int | None = None,
    seed: int = 0,
    *,
    quick: bool = False,
    retrain: bool = False,
    models: Models | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Outcome:
    """Every experiment of the paper over so many Monte Carlo runs (by default the paper's own entry; fewer when quick).

    retrain: train the learned filters again instead of taking those that come with the package; models: take them from
    there. progress(experiment, runs done, runs). Interrupted (Ctrl-C), the experiments with any finished runs are
    returned, ``partial`` being true. Errors: InputError for runs below 2 (which have no standard error) or a negative
    seed.
    """
    count = runs if runs is not None else paper.quick_runs if quick else paper.runs
    if count < 2:
        raise InputError(f"runs is {count}; expected at least 2")
    if seed < 0:
        raise InputError(f"seed is {seed}; expected a whole number from 0")
    outcome = Outcome(paper, count, seed)
    source = models or (retrained(quick) if retrain else shipped)
    for experiment in paper.experiments(source):
        try:
            done = _one(experiment, count, seed, progress)
        except KeyboardInterrupt:
            if not outcome.races:
                raise
            outcome.partial = True
            return outcome
        outcome.add(experiment, done)
        if outcome.partial:
            return outcome
    return outcome


def _one(experiment: Experiment, runs: int, seed: int, progress: Callable[[str, int, int], None] | None) -> Race:
    def say(done: int, asked: int) -> None:
        if progress:
            progress(experiment.name, done, asked)

    return race(
        experiment.scenario,
        list(experiment.baselines),
        max(2, round(experiment.share * runs)),
        seed,
        first=experiment.first,
        more=experiment.makers(),
        progress=say,
    )
