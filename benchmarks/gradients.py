"""What exact gradients cost: the log-likelihood of an IMM of three modes and its derivatives by ten parameters, on one
core.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import jink
from jink.fit.gradient import gradient
from jink.fit.parameters import Parameters
from jink.models.tracks import Tracks

from .cases import regular
from .race import Job, Lap, compare
from .targets import Row, reason, times

TRACKS, SCANS, DERIVATIVES, LIMIT = 200, 200, 10, 30  # ms
VALUE, SLOPES = "value", "value and derivatives"


def filter_of_three() -> jink.IMM:
    """Three constant velocities: three noises, six chances to switch, the outliers' share and the sensor's sd."""
    modes = [jink.ConstantVelocity(acceleration_sd=sd) for sd in (0.5, 3.0, 20.0)]
    return jink.IMM(modes, jink.Position(sd=25.0), 0.95, outliers=jink.Outliers())


def jobs(tracks: int, scans: int) -> dict[str, Job]:
    """The likelihood alone, as ``filter`` gives it, and with its derivatives."""
    case, filter = regular(tracks, scans), filter_of_three()
    given = Tracks(case.time, case.z, case.offsets)
    parameters = Parameters(filter)
    assert len(parameters) == DERIVATIVES
    tangents = parameters.tangents(parameters.start)

    def value(_: Any) -> Any:
        return filter.filter(**given.keywords(), threads=1, outputs=("log_likelihood",)).log_likelihood

    def slopes(_: Any) -> Any:
        return np.vstack([part[..., 0].reshape(-1, tracks) for part in gradient(filter, tangents, given, threads=1)])

    return {VALUE: Job(value, tracks * scans), SLOPES: Job(slopes, tracks * scans)}


def rows(results: dict[str, Any]) -> list[Row]:
    """One line of the report."""
    what = f"log-likelihood and {DERIVATIVES} derivatives, {TRACKS} tracks × {SCANS} scans, IMM of 3 modes, one core"
    must, costs = f"≤ {LIMIT} ms", results.get("gradients", {})
    if SLOPES not in costs:
        return [Row(what, reason(results, "gradients"), must)]
    lap = Lap(tuple(costs[SLOPES]))
    ms = 1e3 * TRACKS * SCANS * lap.median
    ratio = compare(lap, Lap(tuple(costs[VALUE])))
    words = f"{ms:.1f} ms; the value alone {times(ratio)} as fast" if math.isfinite(ms) else "no figure"
    return [Row(what, words, must, ms <= LIMIT)]
