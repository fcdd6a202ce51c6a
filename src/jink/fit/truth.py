"""Filters against the truth that a file of measurements has in further columns: errors beside what a race without truth
says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..checks import Array
from ..compare.recorded import Recording
from ..compare.result import Race
from ..compare.scores import part

ERRORS = {"p": "position_rmse", "v": "velocity_rmse"}


def score_truth(race: Race, recording: Recording, truth: Array, components: Sequence[str]) -> None:
    """Add the errors of every filter against truth (N, c) in these components, on the rows that are scored, to a race.

    Raw measurements have an error of position alone. Filters that do not estimate a component have none of its kind.
    """
    rows = np.flatnonzero(recording.scored & np.isfinite(truth).all(axis=1))
    found = [metric for kind, metric in ERRORS.items() if any(name[0] == kind for name in components)]
    for name, entrant in race.entrants.items():
        known = _estimates(entrant.filter, recording, components)
        for metric in found:
            columns = [k for k, c in enumerate(components) if ERRORS[c[0]] == metric]
            square = ((known - truth)[rows][:, columns] ** 2).sum(axis=1)
            race.tallies[name].add(recording.unit[rows], metric, *part(square[:, None]))
    race.words = race.words.replace("without truth", "with truth")
    race.metrics = (*found, *race.metrics)
    race.compared = (*found, *race.compared)


def _estimates(filter: object, recording: Recording, components: Sequence[str]) -> Array:
    """What a filter estimates of the components, NaN what it does not: (N, c); None: what is measured."""
    out = np.full((recording.tracks.rows, len(components)), np.nan)
    if filter is None:
        there = recording.sensor.positions(recording.tracks.z)
        for k, name in enumerate(components):
            if name[0] == "p" and "xyz".index(name[1]) < there.shape[1]:
                out[:, k] = there[:, "xyz".index(name[1])]
        return out
    estimate = filter.filter(**recording.tracks.keywords(), outputs=("x",))  # type: ignore[attr-defined]
    for k, name in enumerate(components):
        if name in estimate.components:
            out[:, k] = estimate.x[:, estimate.components.index(name)]
    return out
