"""Recipes of filters whose process noise comes from fuzzy rules, and of the constants they are measured against."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import numpy as np

from ..checks import Array
from ..filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..models.fuzzy import FuzzyRules
from ..models.motion import ConstantVelocity
from ..models.sensor import Position
from . import evolution
from .candidates import fuzzy_along_track
from .constants import best_constant
from .data import Runs
from .genetic import Settings, identify, training_runs
from .how import RANGE, SHARES, How
from .interacting import FuzzyModes, identify_modes

OPTIMISERS = (*evolution.OPTIMISERS, "together")
STAY = 0.97  # per scan
SEARCHED = ("fuzzy-imm", "fuzzy-kalman")  # by populations: these have optimisers, rules and checkpoints


def fuzzy_modes(training: Runs, validation: Runs, how: How) -> IMM:
    """One set of rules per input, each by its own search; or all and the transition matrix together."""
    if how.optimiser == "together":
        found = _together(training, how, 3)
        return IMM(
            _motions(found),
            Position(sd=training.sd, axes=training.axes),
            found.transition,
            mode_probability=np.full(3, 1 / 3),
        )
    inputs = _inputs(how)
    rules = [_identified(each, how.quiet_sd, _on_input(each, training, how), how, k) for k, each in enumerate(inputs)]
    return fuzzy_imm(Position(sd=training.sd, axes=training.axes), rules, STAY)


def constant_modes(name: str, training: Runs, how: How) -> IMM | Kalman | None:
    """The same modes with one constant noise each, found on the same runs within the same bounds; None for what has no
    rules.
    """
    if name not in SEARCHED:
        return None
    if how.optimiser == "together":
        modes = 3 if name == "fuzzy-imm" else 1
        alone = replace(how, rules=1, checkpoint=None, progress=None)
        found = _together(training, alone, modes)
        if how.along_track:
            return _several(_motions(found), training, found.transition, np.full(modes, 1 / modes))
        sds = [float(np.sqrt(table.variances[0])) for table in found.modes]
        return _constants(sds, training, found.transition, np.full(modes, 1 / modes))
    if name == "fuzzy-kalman":
        middle, spread = _whole_range(how)
        sds = [best_constant(middle, training, _settings(training, how, spread), SHARES[0] * middle)]
    else:
        runs = [(each, _on_input(each, training, how)) for each in _inputs(how)]
        sds = [best_constant(each, on, _settings(on, how), how.quiet_sd) for each, on in runs]
    first = np.r_[0.6, np.full(len(sds) - 1, 0.4 / max(len(sds) - 1, 1))]
    return _constants(sds, training, STAY, first)


def _constants(sds: list[float], training: Runs, transition: Any, first: Array) -> IMM | Kalman:
    return _several([ConstantVelocity(acceleration_sd=sd) for sd in sds], training, transition, first)


def _several(motions: list[Any], training: Runs, transition: Any, first: Array) -> IMM | Kalman:
    if len(motions) == 1:
        return Kalman(motions[0], Position(sd=training.sd, axes=training.axes))
    return IMM(motions, Position(sd=training.sd, axes=training.axes), transition, mode_probability=first)


def _inputs(how: How) -> tuple[float, ...]:
    inputs = how.inputs or tuple(share * how.acceleration for share in SHARES)
    if len(inputs) == 1:
        raise ValueError("inputs: an IMM has at least two modes; fuzzy-kalman has one")
    return inputs


def _on_input(acceleration: float, training: Runs, how: How) -> Runs:
    """What a sub-model learns on: the data, or a target of its own input seen by the data's sensor."""
    if not how.own_inputs:
        return training
    interval = float(np.nanmedian(np.diff(training.time, axis=1)))
    return training_runs(acceleration, sd=training.sd, process_sd=how.quiet_sd, interval=interval, seed=how.seed)


def fuzzy_mode(training: Runs, validation: Runs, how: How) -> Kalman:
    """One set of rules for the whole range of what the targets do."""
    if len(how.inputs) > 1:
        raise ValueError("inputs: fuzzy-kalman has one mode; fuzzy-imm has one for each")
    if how.optimiser == "together":
        return Kalman(_motions(_together(training, how, 1))[0], Position(sd=training.sd, axes=training.axes))
    middle, spread = _whole_range(how)
    rules = _identified(middle, SHARES[0] * middle, training, how, 0, widen=spread)
    return Kalman(_fuzzy(rules), Position(sd=training.sd, axes=training.axes))


def _whole_range(how: How) -> tuple[float, float]:
    """The middle of the noise's range in m/s², and how far it reaches to both sides: from a hundredth of what the
    targets pull up to that.
    """
    most, spread = (how.inputs or (how.acceleration,))[0], (2 * SHARES[0]) ** -0.5
    return most / spread, spread


def _motions(found: FuzzyModes) -> list[Any]:
    if not found.across:
        return [_fuzzy(rules) for rules in found.modes]
    return [fuzzy_along_track(along, across) for along, across in zip(found.modes, found.across, strict=True)]


def _fuzzy(rules: FuzzyRules) -> Any:
    return FuzzyNoise(ConstantVelocity(acceleration_sd=float(np.sqrt(np.mean(rules.variances)))), rules)


def _identified(
    acceleration: float, process_sd: float, training: Runs, how: How, place: int, widen: float = 1.0
) -> FuzzyRules:
    settings = _settings(training, how, widen)

    def tell(generation: int, fitness: float, rules: int) -> None:
        if how.progress:
            words = f"{acceleration:g} m/s², generation: best fitness {fitness:.4g} with {rules} rules"
            how.progress(words, generation + 1, settings.generations)

    checkpoint = None if how.checkpoint is None else f"{os.fspath(how.checkpoint)}.{place}.npz"
    return identify(
        acceleration,
        training,
        settings=settings,
        process_sd=process_sd,
        seed=how.seed,
        checkpoint=checkpoint,
        progress=tell,
    )


def _settings(training: Runs, how: How, widen: float = 1.0) -> Settings:
    """As in the paper, whose kilometre is two sds of its measurement: so errors weigh against rules as there."""
    return Settings(
        weight=how.weight,
        optimiser=how.optimiser,
        widen=widen,
        unit=2 * training.sd * training.time.shape[1] / 60,
        **how.given(generations="generations", population="population", most_rules="rules"),
    )


def _together(training: Runs, how: How, modes: int) -> FuzzyModes:
    if how.along_track and training.axes < 2:
        raise ValueError("rules along and across the track need measurements of two or three axes, got one")
    generations = how.generations or 250
    return identify_modes(
        training,
        modes=modes,
        interval=(RANGE[0] * how.acceleration, 2 * how.acceleration),
        seed=how.seed,
        rules=how.rules or (2 if modes > 1 else 6),
        generations=generations,
        along_track=how.along_track,
        checkpoint=None if how.checkpoint is None else f"{os.fspath(how.checkpoint)}.0.npz",
        progress=how.counting("generation", generations),
        **how.given(population="population"),
    )
