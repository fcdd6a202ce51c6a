"""One run to look at: the truth, the measurements, and what every filter made of them."""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..scenarios import Simulation
from .estimates import Answer

WINDOW = 15  # rows that curves of recorded tracks run over


@frozen
class Track:
    """Position (S, axes) of one filter, probabilities (S, M) of its modes."""

    position: Array
    modes: tuple[str, ...] = ()
    probability: Array | None = None


@frozen
class Example:
    """The first run: time (S,), measured and true positions (S, axes), busy (S,) where the target manoeuvres.

    name of the run; truth and busy are None where nobody knows it; curves: title, quantity and a line (S,) per filter.
    """

    name: str
    time: Array
    measured: Array
    truth: Array | None
    busy: np.ndarray | None
    tracks: dict[str, Track]
    curves: dict[str, tuple[str, str, dict[str, Array]]] = field(default_factory=dict)


def example(simulation: Simulation, answers: dict[str, Answer], busy: np.ndarray) -> Example:
    """What is shown of the first run of a chunk."""
    tracks: dict[str, Any] = {
        name: Track(
            answer.position[0].copy(),
            answer.modes,
            None if answer.probability is None else answer.probability[0].copy(),
        )
        for name, answer in answers.items()
        if name != "raw"
    }
    measured = simulation.scenario.observation.sensor.positions(simulation.z[:1])[0]
    name = f"run {int(simulation.runs[0])}"
    truth = simulation.truth.position[0]
    distance = {
        filter: np.linalg.norm(answer.position[0] - truth[:, : answer.position.shape[2]], axis=1)
        for filter, answer in answers.items()
    }
    return Example(
        name=name,
        time=simulation.time[0].copy(),
        measured=measured.copy(),
        truth=np.array(truth),
        busy=np.array(busy[0]),
        tracks=tracks,
        curves={"distance": (f"Distance from the truth, {name}", "length", distance)},
    )


def recorded_example(recording: Any, filters: dict[str, Any], answers: dict[str, dict[str, Any]]) -> Example:
    """What is shown of the recorded part with most scored rows: no truth, but how well the next row was predicted.

    answers: squared prediction errors (m²) and log densities of all rows by filter; filters by name, None for raw.
    """
    measured = recording.tracks
    scored = np.add.reduceat(recording.scored.astype(int), measured.first)
    part = int(np.argmax(scored))
    rows, shown = measured.at(part), measured.some(np.array([part]))
    tracks: dict[str, Track] = {}
    for name, filter in filters.items():
        if filter is None:
            continue
        estimate = filter.filter(**shown.keywords(), outputs=("x", "mode_probability"))
        place = [estimate.components.index(c) for c in ("px", "py")]
        several = len(estimate.modes) > 1
        probability = estimate.mode_probability if several else None
        tracks[name] = Track(estimate.x[:, place], tuple(estimate.modes) if several else (), probability)
    error = {name: np.sqrt(_running(answer["prediction_rmse"][rows])) for name, answer in answers.items()}
    score = {
        name: _running(answer["prediction_score"][rows])
        for name, answer in answers.items()
        if "prediction_score" in answer
    }
    return Example(
        name=f"part {part + 1} of {len(measured)}",
        time=shown.time - shown.time[0],
        measured=recording.sensor.positions(shown.z),
        truth=None,
        busy=None,
        tracks=tracks,
        curves={
            "error": (f"RMS prediction error over {WINDOW} rows", "length", error),
            "score": (f"ln p of the next row, mean over {WINDOW}", "", score),
        },
    )


def _running(values: Array) -> Array:
    """Mean of what is there in the last WINDOW values, NaN where that is less than a third."""
    there = np.isfinite(values)
    sums = [np.cumsum(np.concatenate([[0.0], each])) for each in (np.where(there, values, 0.0), there)]
    first = np.maximum(np.arange(1, len(values) + 1) - WINDOW, 0)
    total, number = (each[1:] - each[first] for each in sums)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(number >= WINDOW / 3, total / number, np.nan)
