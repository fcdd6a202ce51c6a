"""What manoeuvres do to the error, and how filters notice them, counted run by run in bounded memory.

The figures are those of :func:`jink.metrics.response` and :func:`jink.metrics.detection` of all runs.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ..catalogue.targets import KINDS
from ..checks import Array
from ..frozen import frozen
from ..metrics import Figure, events, manoeuvring
from ..metrics.figure import jackknife
from ..metrics.manoeuvres import BEFORE, Bools, aligned, noticed, settling_time
from ..scenarios import Simulation
from ..tracking.manoeuvring import GRAVITY
from .scores import JACKKNIFE, NAN, Tally

EVENTS: tuple[Literal["onset", "end"], ...] = ("onset", "end")
HALF = 0.5  # probability from which on a scan is said to manoeuvre
QUIET_SHARE = 0.05  # of what the kind of target pulls: where nothing is commanded, less is no manoeuvre
METRICS = (
    "onset_peak",
    "onset_settling",
    "end_peak",
    "end_settling",
    "detection_delay",
    "noticed",
    "false_alarms",
    "detection",
    "false_alarm",
)


def busy(simulation: Simulation, axes: int = 3) -> Bools:
    """(B, S): did the target manoeuvre since the scan before, along the first so many axes? Commanded, or by its true
    acceleration.
    """
    if simulation.input is not None and simulation.turn_rate is not None:
        out = (simulation.input[..., :axes] != 0).any(axis=2) | (simulation.turn_rate != 0)
        out[:, 0] = out[:, min(1, out.shape[1] - 1)]  # nothing is known of the time before the first scan
        return out
    threshold = QUIET_SHARE * KINDS[simulation.scenario.kind].acceleration
    return manoeuvring(simulation.truth.acceleration[..., :axes], threshold)


def accelerated(simulation: Simulation) -> Bools:
    """(B, S): does the target truly pull more in the plane than the threshold from which its kind manoeuvres?"""
    threshold = KINDS[simulation.scenario.kind].manoeuvre_g[0] * GRAVITY
    return manoeuvring(simulation.truth.acceleration[..., :2], threshold)


@frozen
class Truth:
    """What is true of each scan (B, S): whether the target manoeuvres in any direction, which errors show; in the
    plane, which a probability of a manoeuvre should notice; and whether it pulls more than its kind's threshold there.
    """

    busy: Bools
    level: Bools
    pulls: Bools

    @classmethod
    def of(cls, simulation: Simulation) -> Truth:
        """Of simulated runs."""
        return cls(busy(simulation), busy(simulation, axes=2), accelerated(simulation))


def count(tally: Tally, runs: np.ndarray, error: Array, probability: Array | None, true: Truth) -> None:
    """Add chunks of position errors (B, S, axes), NaN where they do not count, and manoeuvre probabilities (B, S)."""
    tally.add_response(runs, "runs", np.ones(len(runs)))
    for event in EVENTS:
        rows, member = aligned(error, true.busy, event), events(true.busy, event)[:, 0]
        there = np.isfinite(rows)
        for what, values in (("square", np.where(there, rows, 0.0)), ("there", there.astype(float))):
            tally.add_response(runs[member], f"{event}_{what}", values)
    if probability is not None:
        for name, (total, number) in noticed(probability, true.level).items():
            tally.add(runs, name, total, number)
        says = probability >= HALF
        for name, those in (("detection", true.pulls), ("false_alarm", ~true.pulls)):
            those = those & np.isfinite(probability)
            tally.add(runs, name, (says & those).sum(axis=1).astype(float), those.sum(axis=1).astype(float))


def figure(tally: Tally, metric: str) -> Figure:
    """Peak (m) or settling (scans, inf if it never does) after onsets or ends. NaN without such events.

    Settled is 1.5 times the RMSE in the scans before onsets, for ends as well: back to what it is in quiet flight.
    """
    event, _, what = metric.partition("_")
    square, there = (tally.responses.get(f"{event}_{each}") for each in ("square", "there"))
    if square is None or there is None or not there.any():
        return NAN
    used = tally.responses["runs"] > 0
    level = 1.5 * _quiet(tally)

    def peak(square: Array, there: Array) -> float:
        c = _curve(square, there)
        return float(np.nanmax(c)) if np.isfinite(c).any() else math.nan

    def settling(square: Array, there: Array) -> float:
        return settling_time(_curve(square, there), level)

    return jackknife(peak if what == "peak" else settling, square[used], there[used], groups=JACKKNIFE)


def _quiet(tally: Tally) -> float:
    """RMSE (m) in the scans before onsets, NaN without any."""
    total, number = (tally.responses[f"onset_{each}"][:, :BEFORE].sum() for each in ("square", "there"))
    return math.sqrt(total / number) if number else math.nan


def _curve(square: Array, there: Array) -> Array:
    """RMSE from the event on, over the groups of runs given."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(square.sum(axis=0) / there.sum(axis=0))[BEFORE:]
