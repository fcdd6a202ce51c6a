"""Candidates of fuzzy filters, run natively over training runs, many at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._engine import native
from ..checks import Array, thread_count
from ..frozen import frozen
from ..models.fuzzy import FuzzyRules
from .data import Runs


@frozen(kw_only=True, eq=False)
class Errors:
    """RMS errors of each candidate at each scan: position (I, S) m and velocity (I, S) m/s; NaN before tracks start."""

    position: Array
    velocity: Array


def errors_of(
    tables: Array,
    count: NDArray[np.int64],
    runs: Runs,
    *,
    transition: Array | None = None,
    probability: Array | None = None,
    threads: int | None = None,
) -> Errors:
    """Run candidates on every axis of the runs and tell their errors.

    tables (I, M, R, 5) rows c₁ s₁ c₂ s₂ w in SI units, of which the first count (I, M) hold; for M > 1 modes also
    transition (I, M, M) and initial probability (I, M). Each is a filter per axis, state [p v], two-point start, whose
    modes' noise variance comes from its rules (core/run/population.cpp); many candidates cost little more than one.
    Errors: ValueError where arrays do not fit.
    """
    apart = runs.axes_apart()
    individuals, modes = tables.shape[:2]
    scans = apart.time.shape[1]
    if transition is None:
        transition = np.broadcast_to(np.eye(modes), (individuals, modes, modes))
    if probability is None:
        probability = np.full((individuals, modes), 1 / modes)
    sums = np.empty((individuals, scans, 2))
    given: Any = (tables, np.asarray(count, dtype=np.int64), transition, probability, apart.time, *_flat(apart))
    native.population_errors(
        *(np.ascontiguousarray(array) for array in given),
        variance=runs.sd**2,
        result=sums,
        threads=thread_count(threads),
    )
    scored = _scored(apart)
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(sums / scored[None, :, None])
    return Errors(position=rms[..., 0], velocity=rms[..., 1])


def errors_of_rules(
    modes: Sequence[FuzzyRules],
    runs: Runs,
    *,
    transition: ArrayLike | None = None,
    probability: ArrayLike | None = None,
) -> Errors:
    """The same of one filter, its modes' rules given."""
    tables, count = stacked([modes])
    matrices = [None if m is None else np.asarray(m, dtype=float)[None] for m in (transition, probability)]
    return errors_of(tables, count, runs, transition=matrices[0], probability=matrices[1])


def stacked(candidates: Sequence[Sequence[FuzzyRules]]) -> tuple[Array, NDArray[np.int64]]:
    """tables (I, M, R, 5) and count (I, M) of candidates of equally many modes."""
    count = np.array([[len(rules) for rules in modes] for modes in candidates], dtype=np.int64)
    tables = np.ones((*count.shape, count.max(), 5))
    for i, modes in enumerate(candidates):
        for j, rules in enumerate(modes):
            tables[i, j, : len(rules)] = rules.table()
    return tables, count


def _flat(runs: Runs) -> list[Array]:
    return [array[..., 0] for array in (runs.z, runs.position, runs.velocity)]


def _scored(runs: Runs) -> Array:
    """How many runs are scored at each scan: those whose second measurement lies before, and whose truth is known."""
    seen = np.cumsum(np.isfinite(runs.z[..., 0]), axis=1)
    before = np.pad(seen, ((0, 0), (1, 0)))[:, :-1] >= 2
    return (before & np.isfinite(runs.position[..., 0])).sum(axis=0).astype(float)


def normalised(errors: Errors, runs: Runs, first: int = 2) -> tuple[Array, Array]:
    """ζ of position and velocity (I,): the mean over scans, from index ``first``, of RMS error over that of the
    measurement.

    The measured velocity is the backward difference of the measurements. Source: Lee, Joo & Park 2003, §4.
    """
    step = np.diff(runs.time, axis=1)[..., None]
    measured = np.diff(runs.z, axis=1) / step
    raw_p = np.sqrt(np.nanmean((runs.z - runs.position)[:, first:] ** 2, axis=(0, 2)))
    raw_v = np.sqrt(np.nanmean((measured - runs.velocity[:, 1:])[:, first - 1 :] ** 2, axis=(0, 2)))
    return (errors.position[:, first:] / raw_p).mean(axis=1), (errors.velocity[:, first:] / raw_v).mean(axis=1)
