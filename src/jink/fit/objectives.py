"""What a fit minimises, and its exact gradient: likelihood, prediction error, or error against the truth.

Each is a mean, so that figures of more and of less data compare, and comes with the scores of every owner of tracks (a
target, a run): what each adds to the gradient. From their spread standard errors follow.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..checks import Array
from ..estimate import Status
from ..frozen import frozen
from ..models.tracks import Tracks
from .gradient import differentiable, gradient
from .parameters import Parameters

TWO_POINT = 2  # rows that start a track
LEAST = 1e-300


class Evaluation(NamedTuple):
    """value; slope (P,); scores (owners, P), which add up to the slope; count: how much data the mean is over."""

    value: float
    slope: Array
    scores: Array
    count: float


class NotFinite(ValueError):
    """A figure or derivative that is no number; the message names the parameter and the track."""


class Objective(Protocol):
    """Smaller is better. `evaluate` needs a filter with a gradient, `value` none."""

    @property
    def name(self) -> str: ...
    def evaluate(self, parameters: Parameters, u: Array, tracks: Tracks) -> Evaluation: ...
    def value(self, filter: Any, tracks: Tracks) -> float: ...


@frozen
class Likelihood:
    """−(1/n) Σ ln p(z), n the measured rows after the start of their track, without those that only repeat
    (`Tracks.new`).
    """

    name: str = "likelihood"

    def evaluate(self, parameters: Parameters, u: Array, tracks: Tracks) -> Evaluation:
        weight = None if tracks.new is None else tracks.new[:, None].astype(float)
        filter, tangents = parameters.filter(u), parameters.tangents(u)
        value, slope = gradient(filter, tangents, tracks, "likelihood", weight=weight)
        check_finite(value, slope, parameters, tracks)
        n = scored_rows(tracks)
        scores = _by_owner(-slope[:, :, 0].T / n, tracks)
        return Evaluation(-float(value.sum()) / n, scores.sum(axis=0), scores, n)

    def value(self, filter: Any, tracks: Tracks) -> float:
        if tracks.new is None:
            found = filter.filter(**tracks.keywords(), outputs=("log_likelihood",))
            return -float(found.log_likelihood.sum()) / scored_rows(tracks)
        found = filter.filter(**tracks.keywords(), outputs=("log_likelihood_scan",))
        return -float(np.nansum(found.log_likelihood_scan[tracks.new])) / scored_rows(tracks)


def scored_rows(tracks: Tracks) -> float:
    """Rows with a (new) measurement, without the two that start each track; at least one."""
    there = np.isfinite(tracks.z).any(axis=1)
    seen = np.r_[0, np.cumsum(there if tracks.new is None else there & tracks.new)][tracks.offsets]
    return max(float(np.maximum(np.diff(seen) - TWO_POINT, 0).sum()), 1.0)


@frozen
class Prediction:
    """Mean over families and measured components of ln RMSE(z − h(x predicted `ahead` scans before)), where rows
    count.
    """

    ahead: int = 1
    name: str = "prediction"

    def evaluate(self, parameters: Parameters, u: Array, tracks: Tracks) -> Evaluation:
        counts = _counting(tracks, np.isfinite(tracks.z))
        value, slope = gradient(
            parameters.filter(u),
            parameters.tangents(u),
            tracks,
            "prediction",
            ahead=self.ahead,
            weight=counts,
        )
        check_finite(value, slope, parameters, tracks)
        return _from_sums(value, slope, counts, tracks, [[c] for c in range(tracks.z.shape[1])])

    def value(self, filter: Any, tracks: Tracks) -> float:
        counts = _counting(tracks, np.isfinite(tracks.z))
        if differentiable(filter):
            none = np.zeros((0, filter.numbers.size))
            sums, _ = gradient(filter, none, tracks, "prediction", ahead=self.ahead, weight=counts)
        elif self.ahead == 1:
            sums = _of_tracks(counts * np.nan_to_num(predicted_residual(filter, tracks)) ** 2, tracks)
        else:
            raise ValueError(f"ahead: expected 1 for a filter without gradients, got {self.ahead}")
        return _from_sums(sums, np.zeros((0, *sums.shape)), counts, tracks, [[c] for c in range(sums.shape[1])]).value


def predicted_residual(filter: Any, tracks: Tracks) -> Array:
    """z − prediction (N, m) of positions: every row is given twice, first without its measurement."""
    z = np.repeat(tracks.z, 2, axis=0)
    z[::2] = np.nan
    covariance = None if tracks.covariance is None else np.repeat(tracks.covariance, 2, axis=0)
    found = filter.filter(
        np.repeat(tracks.time, 2), z, offsets=2 * tracks.offsets, covariance=covariance, outputs=("x",)
    )
    index = [found.components.index(f"p{axis}") for axis in "xyz"[: tracks.z.shape[1]]]
    return tracks.z - found.x[::2][:, index]


@frozen
class Tracking:
    """Mean over families and quantities (position, velocity, …) of ln RMSE against the truth, where rows count.

    Per scan ("normalised") the RMSE of a quantity is the mean over scans of √(mean square over tracks): the normalised
    errors of :func:`jink.metrics.normalised_error` where the measurements are as good in every scan.
    """

    name: str = "tracking"

    @property
    def per_scan(self) -> bool:
        return self.name == "normalised"

    def evaluate(self, parameters: Parameters, u: Array, tracks: Tracks) -> Evaluation:
        filter, tangents = parameters.filter(u), parameters.tangents(u)
        if self.per_scan:
            value, weight, count = self._by_scan(filter, tracks)
            sums, slope = gradient(filter, tangents, tracks, "tracking", weight=weight)
            check_finite(sums, slope, parameters, tracks)
            scores = _by_owner(slope.sum(axis=2).T, tracks)
            return Evaluation(value, scores.sum(axis=0), scores, count)
        assert tracks.truth is not None
        counts = _counting(tracks, np.isfinite(tracks.truth))
        sums, slope = gradient(filter, tangents, tracks, "tracking", weight=counts)
        check_finite(sums, slope, parameters, tracks)
        return _from_sums(sums, slope, counts, tracks, quantities(tracks))

    def value(self, filter: Any, tracks: Tracks) -> float:
        if self.per_scan:
            return self._by_scan(filter, tracks)[0]
        square = _squares(filter, tracks)
        counts = _counting(tracks, np.isfinite(square))
        sums = _of_tracks(counts * np.nan_to_num(square), tracks)
        return _from_sums(sums, np.zeros((0, *sums.shape)), counts, tracks, quantities(tracks)).value

    def _by_scan(self, filter: Any, tracks: Tracks) -> tuple[float, Array, float]:
        """The figure, its derivative by each squared error (N, c), and how many there are."""
        square = _squares(filter, tracks)
        counts = _counting(tracks, np.isfinite(square))
        length = np.diff(tracks.offsets)
        scan = np.arange(tracks.rows) - np.repeat(tracks.offsets[:-1], length)
        scans, families = int(length.max()), int(_family(tracks).max()) + 1
        place = np.repeat(_family(tracks), length) * scans + scan
        weight, value, parts = np.zeros(square.shape), 0.0, quantities(tracks)
        for columns in parts:
            total, n = (
                np.bincount(place, (counts * a)[:, columns].sum(axis=1), families * scans)
                for a in (np.nan_to_num(square), np.ones(square.shape))
            )
            root = np.sqrt(np.maximum(total, LEAST) / np.maximum(n, 1.0)).reshape(families, scans)
            used = (n > 0).reshape(families, scans)
            mean = np.where(used, root, 0.0).sum(axis=1) / used.sum(axis=1)
            value += float(np.log(mean).mean()) / len(parts)
            each = 0.5 / (root * np.maximum(n, 1.0).reshape(root.shape) * (mean * used.sum(axis=1))[:, None])
            weight[:, columns] = (each.reshape(-1)[place] / (families * len(parts)))[:, None] * counts[:, columns]
        return value, weight, float(counts.sum())


def quantities(tracks: Tracks) -> list[list[int]]:
    """Columns of the truth that are errors of the same kind: positions, velocities, …"""
    kinds = list(dict.fromkeys(name[0] for name in tracks.components))
    return [[k for k, name in enumerate(tracks.components) if name[0] == kind] for kind in kinds]


def _squares(filter: Any, tracks: Tracks) -> Array:
    assert tracks.truth is not None
    found = filter.filter(**tracks.keywords(), outputs=("x",))
    index = [found.components.index(name) for name in tracks.components]
    return (found.x[:, index] - tracks.truth) ** 2


def _counting(tracks: Tracks, there: np.ndarray) -> Array:
    """(N, c) one where a row counts and has something to compare."""
    return (there if tracks.counts is None else there & tracks.counts[:, None]).astype(float)


def _family(tracks: Tracks) -> np.ndarray:
    return np.zeros(len(tracks), int) if tracks.family is None else tracks.family


def _of_tracks(rows: Array, tracks: Tracks) -> Array:
    """Sums (B, c) over each track's rows."""
    return np.diff(np.vstack([np.zeros(rows.shape[1]), np.cumsum(rows, axis=0)])[tracks.offsets], axis=0)


def _from_sums(sums: Array, slope: Array, counts: Array, tracks: Tracks, parts: list[list[int]]) -> Evaluation:
    """ln RMSE of squared sums (B, c) with slopes (P, B, c), meant over families and parts of the columns."""
    n, family = _of_tracks(counts, tracks), _family(tracks)
    families = int(family.max()) + 1
    value, scores = 0.0, np.zeros((len(tracks), len(slope)))
    for columns in parts:
        total, number = (np.bincount(family, a[:, columns].sum(axis=1), families) for a in (sums, n))
        total, number = np.maximum(total, LEAST), np.maximum(number, 1.0)
        value += 0.5 * float(np.log(total / number).mean()) / len(parts)
        share = 0.5 / (total * families * len(parts))
        scores += (slope[:, :, columns].sum(axis=2) * share[family]).T
    owners = _by_owner(scores, tracks)
    return Evaluation(value, owners.sum(axis=0), owners, float(counts.sum()))


def _by_owner(scores: Array, tracks: Tracks) -> Array:
    """(B, P) to (owners, P)."""
    if tracks.owner is None:
        return scores
    names, index = np.unique(tracks.owner, return_inverse=True)
    out = np.zeros((len(names), scores.shape[1]))
    np.add.at(out, index, scores)
    return out


def check_finite(value: Array, slope: Array, parameters: Parameters, tracks: Tracks) -> None:
    """Errors: NotFinite, naming the track whose figure is no number, or the parameter and track of a derivative."""

    def named(b: int) -> str:
        return f"track {b}" + ("" if tracks.owner is None else f" (of {tracks.owner[b]})")

    if not np.isfinite(value).all():
        raise NotFinite(f"the figure of {named(int(np.argwhere(~np.isfinite(value))[0, 0]))} is not finite")
    if not np.isfinite(slope).all():
        k, b, _ = np.argwhere(~np.isfinite(slope))[0]
        raise NotFinite(f"the derivative by {parameters.names[k]} of {named(int(b))} is not finite")


def believed(filter: Any, tracks: Tracks) -> Tracks:
    """The tracks with rows that this filter gates left out of what counts, so that no fit gains by gating."""
    status = filter.filter(**tracks.keywords(), outputs=("status",)).status
    gated = np.isin(status, (Status.gated, Status.restarted))
    counts = ~gated if tracks.counts is None else tracks.counts & ~gated
    return replace(tracks, counts=counts)
