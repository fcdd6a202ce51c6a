"""How the fuzzy filters that come with the package were trained: as in lee-2003, and better."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...catalogue.targets import KINDS
from ...filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from ...filters.imm import IMM
from ...filters.kalman import Kalman
from ...learn.candidates import fuzzy_along_track
from ...learn.data import Runs, from_scenario, joined
from ...learn.genetic import Settings, identify
from ...learn.interacting import identify_modes
from ...learn.population import Errors, errors_of_rules, normalised
from ...models.fuzzy import FuzzyRules
from ...models.motion import ConstantVelocity
from ...models.provenance import VERSION
from ...models.sensor import Position
from .trainer import Trainer, test_runs

SD = 500.0  # m
SWEPT = (0.5, 0.8, 0.99)  # λ, beside the paper's 0.95 and 1
ACCELERATION = 100.0  # m/s²: of random-accelerations
INPUTS = (1.0, 10.0, 100.0)  # m/s²: the sub-models of lee-2003


def by_genetic_algorithm(weight: float) -> Trainer:
    """Three sub-models by the paper's GA, its transition matrix."""

    def make(seed: int, quick: bool) -> IMM:
        settings = Settings(weight=weight)
        if quick:
            settings = replace(settings, generations=10, population=60)
        rules = [identify(each, settings=settings, seed=seed) for each in INPUTS]
        test = from_scenario("lee-2003", test_runs(quick), seed + 1000)
        stay = np.full((3, 3), 0.015)
        stay[np.diag_indices(3)] = 0.97
        errors = errors_of_rules(rules, test, transition=stay, probability=[0.6, 0.2, 0.2])
        return fuzzy_imm(Position(sd=SD, axes=1), [_judged(r, errors, test) for r in rules], 0.97)

    return make


def _judged(rules: FuzzyRules, errors: Errors, test: Runs) -> FuzzyRules:
    assert rules.trained is not None
    position, velocity = (float(z[0]) for z in normalised(errors, test))
    figures = (*rules.trained.figures, (f"ζp, {test}", position), (f"ζv, {test}", velocity))
    return replace(rules, trained=replace(rules.trained, figures=figures, version=VERSION))


def with_transition(scenario: str, modes: int, rules: int) -> Trainer:
    """Rules and transition matrix together, on a scenario's own runs."""

    def make(seed: int, quick: bool) -> IMM | Kalman:
        runs = from_scenario(scenario, 20 if quick else 300, seed + 5)
        found = identify_modes(runs, modes=modes, rules=rules, generations=5 if quick else 250, seed=seed)
        test = from_scenario(scenario, test_runs(quick), seed + 1000)
        errors = errors_of_rules(found.modes, test, transition=found.transition)
        tables = [_judged(each, errors, test) for each in found.modes]
        motions = [_fuzzy(table) for table in tables]
        sensor = Position(sd=runs.sd, axes=1)
        if modes == 1:
            return Kalman(motions[0], sensor)
        return IMM(motions, sensor, found.transition, mode_probability=np.full(modes, 1 / modes))

    return make


def along_track(rules: int, interval: tuple[float, float]) -> Trainer:
    """Three modes with rules along and across the track and their transition matrix, on targets that turn, weave and
    accelerate in any direction. Lengths of the last are scaled, so that they pull what a fighter does.
    """

    def make(seed: int, quick: bool) -> IMM:
        each = 4 if quick else 40
        turns, weaves = (from_scenario(name, each, seed + 5) for name in ("random-turns", "weave"))
        share = KINDS["fighter"].acceleration / ACCELERATION
        pulls = from_scenario("random-accelerations-turned", each, seed + 5, sensor=turns.sd / share)
        lengths = {name: share * getattr(pulls, name) for name in ("z", "position", "velocity", "acceleration", "sd")}
        runs = joined([turns, weaves, replace(pulls, **lengths)])
        generations = 3 if quick else 300
        found = identify_modes(
            runs, rules=rules, interval=interval, generations=generations, seed=seed, along_track=True
        )
        along, across = ([_dated(table) for table in tables] for tables in (found.modes, found.across))
        motions = [fuzzy_along_track(*mode) for mode in zip(along, across, strict=True)]
        sensor = Position(sd=runs.sd, axes=runs.axes)
        return IMM(motions, sensor, found.transition, mode_probability=np.full(len(motions), 1 / len(motions)))

    return make


def _dated(rules: FuzzyRules) -> FuzzyRules:
    assert rules.trained is not None
    return replace(rules, trained=replace(rules.trained, version=VERSION))


def _fuzzy(table: FuzzyRules) -> FuzzyNoise:
    return FuzzyNoise(ConstantVelocity(acceleration_sd=float(np.sqrt(np.mean(table.variances)))), table)
