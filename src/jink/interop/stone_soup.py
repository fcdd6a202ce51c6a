"""Stone Soup: tracks, detections and ground truth in and out; a jink filter as a predictor and an updater.

Stone Soup's times are dates with microseconds, counted here from ``start``; a state's components stand in jink's order.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array
from ..estimate import Estimate
from ..filters.rows import track_offsets
from .needed import needed

START = datetime(1970, 1, 1, tzinfo=UTC)


class Rows(NamedTuple):
    """Rows of tracks laid end to end: time (N,) s, values (N, m), covariance (N, m, m) or None, offsets (B + 1,)."""

    time: Array
    values: Array
    covariance: Array | None
    offsets: np.ndarray


def dates(time: ArrayLike, start: datetime = START) -> list[datetime]:
    """Times in seconds as dates, to the microsecond."""
    return [start + timedelta(microseconds=round(float(t) * 1e6)) for t in np.atleast_1d(np.asarray(time, float))]


def tracks_of(estimate: Estimate, start: datetime = START) -> list[Any]:
    """One Stone Soup ``Track`` of ``GaussianState`` for each target; rows before a track starts are left out."""
    state = needed("stonesoup.types.state").GaussianState
    track = needed("stonesoup.types.track").Track
    out = []
    for first, end in zip(estimate.offsets[:-1], estimate.offsets[1:], strict=True):
        rows = [k for k in range(int(first), int(end)) if np.isfinite(estimate.x[k]).all()]
        when = dates(estimate.time[rows], start)
        out.append(track([state(estimate.x[k], estimate.P[k], timestamp=t) for k, t in zip(rows, when, strict=True)]))
    return out


def estimate_of(tracks: Iterable[Any], components: Sequence[str], start: datetime = START) -> Estimate:
    """The means and covariances of Stone Soup tracks, laid end to end; components: names of the state vector."""
    found = rows_of(tracks, start)
    if found.values.shape[1] != len(components):
        raise ValueError(f"components: expected {found.values.shape[1]} names, got {', '.join(components)}")
    results: dict[str, Any] = {"x": found.values, "time": found.time}
    if found.covariance is not None:
        results["P"] = found.covariance
    return Estimate(tuple(components), ("stone_soup",), results)


def rows_of(paths: Iterable[Iterable[Any]], start: datetime = START) -> Rows:
    """States of tracks or ground truth paths, or detections of several targets, laid end to end."""
    time, values, noise, lengths = [], [], [], []
    for path in paths:
        states = list(path)
        lengths.append(len(states))
        time += [_since(state.timestamp, start) for state in states]
        values += [np.asarray(state.state_vector, dtype=float).ravel() for state in states]
        noise += [_covariance(state) for state in states]
    known = bool(noise) and all(each is not None for each in noise)
    return Rows(
        np.array(time, dtype=float),
        np.stack(values) if values else np.empty((0, 0)),
        np.stack([np.asarray(each, dtype=float) for each in noise]) if known else None,
        np.cumsum([0, *lengths]),
    )


def paths_of(time: ArrayLike, x: ArrayLike, offsets: ArrayLike | None = None, start: datetime = START) -> list[Any]:
    """One ``GroundTruthPath`` for each target from true states x (N, n)."""
    state = needed("stonesoup.types.groundtruth").GroundTruthState
    path = needed("stonesoup.types.groundtruth").GroundTruthPath
    x, when = np.asarray(x, dtype=float), dates(time, start)
    bounds = track_offsets(offsets, len(x))
    return [
        path([state(x[k], timestamp=when[k]) for k in range(int(first), int(end))])
        for first, end in itertools.pairwise(bounds)
    ]


def detections_of(
    time: ArrayLike, z: ArrayLike, covariance: ArrayLike, offsets: ArrayLike | None = None, start: datetime = START
) -> list[list[Any]]:
    """Measured positions z (N, m) as lists of ``Detection`` by target, each with a linear measurement model of its own
    noise on states px vx py vy …; rows with NaN are left out.
    """
    detection = needed("stonesoup.types.detection").Detection
    linear = needed("stonesoup.models.measurement.linear").LinearGaussian
    z, when = np.asarray(z, dtype=float), dates(time, start)
    m = z.shape[1]
    noise = np.broadcast_to(np.asarray(covariance, dtype=float), (len(z), m, m))
    bounds = track_offsets(offsets, len(z))

    def one(k: int) -> Any:
        model = linear(ndim_state=2 * m, mapping=tuple(range(0, 2 * m, 2)), noise_covar=noise[k])
        return detection(z[k], timestamp=when[k], measurement_model=model)

    return [
        [one(k) for k in range(int(first), int(end)) if np.isfinite(z[k]).all()]
        for first, end in itertools.pairwise(bounds)
    ]


def _since(when: datetime, start: datetime) -> float:
    """Seconds, of whole microseconds. Dates without a zone are taken to be in that of the start."""
    if when.tzinfo is None and start.tzinfo is not None:
        when = when.replace(tzinfo=start.tzinfo)
    return ((when - start) // timedelta(microseconds=1)) / 1e6


def _covariance(state: Any) -> Any:
    model = getattr(state, "measurement_model", None)
    return model.covar() if model is not None else getattr(state, "covar", None)
