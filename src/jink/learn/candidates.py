"""Candidates of filters whose rules hold along and across the track, run by the engine over training runs, many at
once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .._engine import native
from ..checks import Array, thread_count
from ..filters.fuzzy_imm import FuzzyNoise
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..models.fuzzy import FuzzyRules
from ..models.motion import ConstantVelocity
from ..models.sensor import Position
from .data import Runs
from .population import Errors


def errors_along_track(tables: Array, transition: Array, runs: Runs, *, threads: int | None = None) -> Errors:
    """Run candidates on the runs in their plane, or in space, and tell their errors, per axis as
    :func:`jink.learn.population.errors_of` does.

    tables (I, M, 2, R, 5): rows c₁ s₁ c₂ s₂ w of the rules along the track and of those across it, in SI units;
    transition (I, M, M). Modes start equally likely. Errors: ValueError for runs of one axis.
    """
    if runs.axes < 2:
        raise ValueError("runs: expected two or three axes, got one; a line has nothing across it")
    like = filter_of(tables[0], transition[0], runs)
    numbers = _numbers(like, tables, transition)
    scans = runs.time.shape[1]
    sums = np.empty((len(tables), scans, 3))
    batch = {name: np.ascontiguousarray(array) for name, array in runs.batch().items()}
    truth = np.concatenate([runs.position, runs.velocity], axis=2).reshape(-1, 2 * runs.axes)
    native.candidate_errors(
        like.engine,
        numbers,
        batch["time"],
        batch["z"],
        batch["offsets"],
        np.ascontiguousarray(truth),
        sums,
        threads=thread_count(threads),
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(sums[..., :2] / (runs.axes * sums[..., 2:]))
    return Errors(position=rms[..., 0], velocity=rms[..., 1])


def filter_of(tables: Array, transition: Array, runs: Runs) -> IMM | Kalman:
    """One candidate (M, 2, R, 5) as a filter."""
    sensor = Position(sd=runs.sd, axes=runs.axes)
    motions: list[Any] = [fuzzy_along_track(*(FuzzyRules.of(table) for table in mode)) for mode in tables]
    if len(motions) == 1:
        return Kalman(motions[0], sensor)
    return IMM(motions, sensor, transition, mode_probability=np.full(len(motions), 1 / len(motions)))


def fuzzy_along_track(along: FuzzyRules, across: FuzzyRules) -> FuzzyNoise:
    """A constant velocity with such rules, and with their mean noise before the first residual."""
    mean = np.mean([*along.variances, *across.variances])
    return FuzzyNoise(ConstantVelocity(acceleration_sd=float(np.sqrt(mean))), along, across)


def _numbers(like: IMM | Kalman, tables: Array, transition: Array) -> Array:
    """The engine's numbers of every candidate: those of ``like``, with its own rules, first noise and transitions."""
    count, M = tables.shape[:2]
    numbers = np.tile(like.numbers, (count, 1))
    rules = tables.reshape(count, M, -1, 5).copy()
    rules[..., [1, 3]] = 1 / rules[..., [1, 3]]
    first = rules[..., 4].mean(axis=2)
    at = 0
    for j, motion in enumerate(like.motions):
        assert isinstance(motion, FuzzyNoise)  # as `filter_of` makes them
        mode = motion.native(like.axes)
        noises, table = len(mode.parameters), rules[:, j].reshape(count, -1)
        numbers[:, at : at + noises] = first[:, j, None]
        at += noises + len(mode.prior_variance) + len(mode.level)
        numbers[:, at : at + table.shape[1]] = table
        at += table.shape[1]
    if M > 1:
        at += like.axes  # the sensor's variances
        numbers[:, at : at + M * M] = transition.reshape(count, -1)
    return np.ascontiguousarray(numbers)
