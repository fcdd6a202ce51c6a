"""A race on recorded tracks whose truth is known: whose estimates lie nearest to it?"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arguments import Array
from ..fit_data import Training
from ..io.errors import InputError
from ..learn.gradient import Tracks
from ..named import Unfit
from ..seeing import sensor_in_words
from ..sensor import Position
from .entrants import Entrant, enter
from .result import Race
from .tally import Tally, part

RIVALS = ("kalman-cv", "kalman-ca", "imm")
METRICS = ("position_rmse", "velocity_rmse", "us_per_update")
KINDS = {"p": "position_rmse", "v": "velocity_rmse"}


def against_truth(training: Training, entrants: Sequence[Entrant], sd: float) -> Race:
    """The entrants, the raw measurements and the usual filters, tuned to the truth of the training tracks, on the tracks held out.

    All believe in the same noise, sd (m). Errors: InputError where no row of these has a truth.
    """
    held_out = training.held_out
    sensor = Position(sd=sd, axes=held_out.z.shape[1])
    # what a filter is tuned to: the truth, rather than the next measurement
    purpose = replace(
        training.purpose, sensor=sensor, sd=sd, loss=lambda filter: _loss(filter, training.tracks)
    )
    everyone = {entrant.name: entrant for entrant in entrants}
    skipped: dict[str, str] = {}
    for name in RIVALS:
        try:
            everyone[name] = enter(name, purpose)
        except Unfit as reason:
            skipped[name] = str(reason)
    everyone["raw"] = Entrant(name="raw", words="the measurements themselves")
    answers = {name: _errors(entrant.filter, held_out) for name, entrant in everyone.items()}
    owner = _owners(held_out)
    counted = np.ones(held_out.rows, dtype=bool) if held_out.counts is None else held_out.counts.copy()
    for answer in answers.values():
        counted &= np.isfinite(answer["position_rmse"])
    if not counted.any():
        raise InputError(f"{training.name}: none of the rows held out has a measurement and a truth")
    units = len(np.unique(owner[counted]))
    return Race(
        scenario=training.name,
        words=f"{int(counted.sum()):,} rows held out, scored against their truth",
        runs=units,
        asked=units,
        seed=0,
        entrants=everyone,
        tallies={name: _tally(answer, owner, counted) for name, answer in answers.items()},
        skipped=skipped,
        seen=f"{sensor_in_words(sensor)}: noise as the truth shows it",
        unit=training.unit,
        metrics=METRICS,
        compared=("position_rmse", "velocity_rmse"),
    )


def _errors(filter: Any, tracks: Tracks) -> dict[str, Any]:
    """Squared errors (N,) of position and velocity; NaN where there is no estimate, measurement or truth."""
    assert tracks.truth is not None
    seen = np.isfinite(tracks.z).all(axis=1)
    if filter is None:
        names = [c for c in tracks.components if c[0] == "p"]
        found = tracks.z[:, ["xyz".index(c[1]) for c in names]]
        return {"position_rmse": _square(found, tracks, names)}
    began = clock.perf_counter()
    estimate = filter.filter(tracks.time, tracks.z, offsets=tracks.offsets, outputs=("x",))
    out: dict[str, Any] = {"seconds": clock.perf_counter() - began}
    for letter, metric in KINDS.items():
        names = [c for c in tracks.components if c[0] == letter and c in estimate.components]
        if names:
            square = _square(estimate.x[:, [estimate.components.index(c) for c in names]], tracks, names)
            out[metric] = np.where(seen, square, np.nan)
    return out


def _square(found: Array, tracks: Tracks, names: Sequence[str]) -> Array:
    assert tracks.truth is not None
    return ((found - tracks.truth[:, [tracks.components.index(c) for c in names]]) ** 2).sum(axis=1)


def _loss(filter: Any, tracks: Tracks) -> float:
    square = _errors(filter, tracks)["position_rmse"]
    if tracks.counts is not None:
        square = square[tracks.counts]
    return float(np.nanmean(square)) if np.isfinite(square).any() else math.inf


def _owners(tracks: Tracks) -> np.ndarray:
    track = np.repeat(np.arange(len(tracks)), np.diff(tracks.offsets))
    if tracks.owner is None:
        return track
    return np.unique(tracks.owner, return_inverse=True)[1].reshape(-1)[track]


def _tally(answer: dict[str, Any], owner: np.ndarray, counted: np.ndarray) -> Tally:
    tally = Tally()
    rows = np.flatnonzero(counted)
    np.add.at(tally.runs, np.unique(owner[rows]) % tally.groups, 1.0)
    for name, values in answer.items():
        if name == "seconds":
            tally.costs.append((values, len(owner)))
        else:
            tally.add(owner[rows], name, *part(values[rows, None]))
    return tally
