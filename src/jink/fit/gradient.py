"""Figures of a filter on tracks, and their exact derivatives by its parameters, by dual numbers through the engine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from .._engine import Engine, native
from ..checks import Array, thread_count
from ..filters.rows import Batch, array_of
from ..models.start import Prior
from ..models.tracks import Tracks

Figure = Literal["likelihood", "prediction", "tracking"]
FIGURES: dict[Figure, native.Figure] = {
    "likelihood": native.Figure.log_likelihood,
    "prediction": native.Figure.prediction_error,
    "tracking": native.Figure.tracking_error,
}


def differentiable(filter: Any) -> bool:
    """Can the engine differentiate this filter? Models of your own, filters that choose among modes, watch for onsets
    or are aided by networks say no."""
    return isinstance(filter.engine, Engine) and native.differentiable(filter.engine)


def gradient(
    filter: Any,
    tangents: Array,
    tracks: Tracks,
    figure: Figure = "likelihood",
    *,
    ahead: int = 1,
    weight: Array | None = None,
    threads: int | None = None,
) -> tuple[Array, Array]:
    """A figure of every track and its derivatives: value (B, c), slope (P, B, c), exact.

    likelihood (c = 1): Σ w ln p(z); prediction, one c per measured component: Σ w (z − h(x predicted ``ahead`` scans
    before))²; tracking, one c of ``tracks.components``: Σ w (x − truth)². tangents (P, numbers): directions of
    differentiation among the engine's numbers, as :meth:`jink.fit.parameters.Parameters.tangents` gives them. weight
    (N, c), by default one. Where a filter gates or restarts the derivative is that of what it did. Errors: ValueError
    naming the argument; TypeError for a filter that cannot be differentiated. Source: Griewank & Walther, Evaluating
    Derivatives, 2008, chapter 3.
    """
    if not differentiable(filter):
        raise TypeError(f"{filter!r} cannot be differentiated; fit it without gradients")
    if figure not in FIGURES:
        raise ValueError(f"figure: expected one of {', '.join(FIGURES)}, got {figure!r}")
    columns, prior = filter.columns, filter.initial if isinstance(filter.initial, Prior) else None
    batch = Batch.of(
        tracks.time,
        tracks.z,
        offsets=tracks.offsets,
        sensor=tracks.sensor,
        covariance=tracks.covariance,
        input=None,
        prior=prior,
        columns=columns,
        sensors=len(filter.sensors),
        axes=filter.axes,
        components=filter.components,
    )
    components, truth = _target(filter, tracks) if figure == "tracking" else ([], None)
    c = 1 if figure == "likelihood" else columns if figure == "prediction" else len(components)
    weights = None if weight is None else array_of("weight", weight, (batch.rows, c))
    directions = np.ascontiguousarray(tangents, dtype=float)
    numbers = filter.numbers.size
    if directions.ndim != 2 or directions.shape[1] != numbers:
        raise ValueError(f"tangents: expected (P, {numbers}), got {directions.shape}")
    if int(ahead) != ahead or ahead < 1:
        raise ValueError(f"ahead: expected a number of scans from 1, got {ahead!r}")
    value, slope = np.empty((len(tracks), c)), np.empty((len(directions), len(tracks), c))
    native.gradient(
        filter.engine,
        *batch.arguments(),
        figure=FIGURES[figure],
        ahead=int(ahead),
        components=components,
        target=truth,
        weight=weights,
        tangents=directions,
        value=value,
        slope=slope,
        threads=thread_count(threads),
    )
    return value, slope


def _target(filter: Any, tracks: Tracks) -> tuple[Sequence[int], Array]:
    if tracks.truth is None:
        raise ValueError("tracks: these tracks have no truth; the figure 'tracking' needs it")
    unknown = [name for name in tracks.components if name not in filter.components]
    if unknown:
        raise ValueError(f"components: expected some of {', '.join(filter.components)}, got {unknown[0]!r}")
    return [filter.components.index(name) for name in tracks.components], np.ascontiguousarray(
        tracks.truth, dtype=float
    )
