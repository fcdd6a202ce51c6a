"""How sure a fit is of its parameters: standard errors from the curvature of the figure and the spread of its
scores.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..checks import Array
from ..models.tracks import Tracks
from .objectives import Objective
from .parameters import Parameters

STEP = 0.02  # of u: small against standard errors that matter, large against the steps of gating
MOST = 60_000  # rows that are enough for a curvature


class Uncertainty(NamedTuple):
    """sd (P,) of u, infinite where the data say nothing; covariance (P, P)."""

    sd: Array
    covariance: Array


def standard_errors(
    parameters: Parameters, objective: Objective, u: Array, tracks: Tracks, *, seed: int = 0
) -> Uncertainty:
    """cov(u) = H⁻¹ (Σ s sᵀ) H⁻¹, H the figure's Hessian (differences of the exact gradient), s the owners' scores at u.

    Right even where the filter is not the true model and the rows of an owner depend on one another; with fewer than
    ten owners the likelihood's H⁻¹/n instead. Directions in which the figure does not curve upwards have infinite
    errors. Source: Huber, Proc. Fifth Berkeley Symposium 1, 1967; White, Econometrica 50(1), 1982.
    """
    some = _some(tracks, seed)
    share = some.rows / tracks.rows
    H = hessian(parameters, objective, u, some)
    found = objective.evaluate(parameters, u, some)
    scores = found.scores
    meat = scores.T @ scores if len(scores) >= 10 else H / found.count
    values, axes = np.linalg.eigh(H)
    flat = values <= 1e-9 * max(values.max(initial=0.0), 1e-12)
    inverse = (axes[:, ~flat] / values[~flat]) @ axes[:, ~flat].T
    covariance = inverse @ meat @ inverse * share
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    lost = (axes[:, flat] ** 2).sum(axis=1) > 0.1
    return Uncertainty(np.where(lost, np.inf, sd), covariance)


def hessian(parameters: Parameters, objective: Objective, u: Array, tracks: Tracks) -> Array:
    """Second derivatives (P, P) of the figure by u."""
    rows = []
    for k in range(len(u)):
        step = np.zeros(len(u))
        step[k] = STEP
        above, below = (objective.evaluate(parameters, u + s * step, tracks).slope for s in (1.0, -1.0))
        rows.append((above - below) / (2 * STEP))
    H = np.array(rows)
    return 0.5 * (H + H.T)


def _some(tracks: Tracks, seed: int) -> Tracks:
    if tracks.rows <= MOST:
        return tracks
    owner = np.arange(len(tracks)) if tracks.owner is None else tracks.owner
    names = np.random.default_rng(seed).permutation(np.unique(owner))
    rows = np.array([np.diff(tracks.offsets)[owner == name].sum() for name in names[:1000]])
    kept = names[: max(int(np.searchsorted(np.cumsum(rows), MOST)), min(20, len(names)))]
    return tracks.some(np.flatnonzero(np.isin(owner, kept)))
