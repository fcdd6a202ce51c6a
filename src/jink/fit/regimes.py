"""Does the filter believe what it should where targets stand, fly straight, turn and climb? NIS by part of the held-out
tracks.

Which part a row is in is read off the positions around it (measured, or true where the truth is known), not off any
filter: from those `REACH` before and after,

    v₁ = (p(t) − p(t − W)) / W,   v₂ = (p(t + W) − p(t)) / W,   v = (v₁ + v₂) / 2

standing: |v| below `STANDING`; turning: the course of v₂ lies `TURNING` or more from that of v₁; climbing (or
descending): vertically `CLIMBING` of the speed or more; straight: what remains. Nothing counts as motion, turn or climb
that is not beyond `NOISE` of its own standard deviations. Ends of tracks and gaps are in no part.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..checks import Array
from ..compare.scores import inside
from ..metrics import Figure
from ..metrics.figure import ratio_influence, spread
from ..models.tracks import Tracks

PARTS = ("straight", "turning", "climbing", "standing")
REACH, STEPS = 10.0, 5.0  # W: seconds, or so many usual steps if they are longer
STANDING = 0.5  # m/s, as in cleaning
TURNING = math.radians(5.0)
CLIMBING = 0.01
NOISE = 3.0  # sds of its own within which a displacement is none
ROWS = 20_000  # filtered at once: each with a covariance


class PartShare(NamedTuple):
    """Rows of a part and the share of their NIS inside the 95% band, below and above it."""

    part: str
    rows: int
    inside: Figure
    below: float
    above: float

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers."""
        se = self.inside.se if math.isfinite(self.inside.se) else None
        return {**self._asdict(), "inside": self.inside.value, "standard_error": se}


def shares(filter: Any, tracks: Tracks) -> list[PartShare]:
    """NIS of a filter by part of tracks whose measurements are positions; none of other measurements.

    A component that repeats the reading before it exactly is left out of its row's NIS: a position at rest that is sent
    again, a height in steps of 25 ft in level flight are no test of the filter, their innovation is zero whatever it
    believes. Standard errors are over owners.
    """
    if not measures_positions(filter) or tracks.z.shape[1] < 2:
        return []
    part = parts(tracks, np.nanmedian(np.einsum("nii->ni", _noise(filter, tracks)), axis=0))
    owner = np.arange(len(tracks)) if tracks.owner is None else np.unique(tracks.owner, return_inverse=True)[1]
    of_row = owner[tracks.of_row]
    nis, dof = innovations(filter, tracks)
    counted = dof > 0 if tracks.counts is None else (dof > 0) & tracks.counts
    return [
        _share(name, nis[rows], dof[rows], of_row[rows])
        for k, name in enumerate(PARTS)
        if (rows := counted & (part == k)).any()
    ]


def measures_positions(filter: Any) -> bool:
    """Is there one sensor, of positions in two axes or three?"""
    sensors = getattr(filter, "sensors", ())
    return len(sensors) == 1 and sensors[0].components in (("x", "y"), ("x", "y", "z"))


def _share(name: str, nis: Array, dof: np.ndarray, owner: np.ndarray) -> PartShare:
    within = inside(nis, dof.astype(float)) == 1
    _, group = np.unique(owner, return_inverse=True)
    value, influence = ratio_influence(np.bincount(group, within).astype(float), np.bincount(group).astype(float))
    below = ~within & (nis < dof)
    figure = Figure(value, spread(influence) if len(influence) > 1 else math.nan)
    return PartShare(name, len(nis), figure, float(below.mean()), float((~within & ~below).mean()))


def innovations(filter: Any, tracks: Tracks) -> tuple[Array, np.ndarray]:
    """NIS (N,) of the components that do not repeat, νᵀ S⁻¹ ν, and how many these are (0: none, or the track only
    begins).
    """
    nis, dof = np.zeros(tracks.rows), np.zeros(tracks.rows, int)
    for some in _pieces(tracks):
        rows = slice(int(tracks.offsets[some[0]]), int(tracks.offsets[some[-1] + 1]))
        nis[rows], dof[rows] = _innovations(filter, tracks.some(some))
    return nis, dof


def _pieces(tracks: Tracks) -> Iterator[np.ndarray]:
    piece = tracks.offsets[1:] // ROWS
    for number in np.unique(piece):
        yield np.flatnonzero(piece == number)


def _innovations(filter: Any, tracks: Tracks) -> tuple[Array, np.ndarray]:
    """Every row is given twice, first without its measurement: that estimate is the prediction for its time."""
    m = tracks.z.shape[1]
    found = filter.filter(**tracks.doubled().keywords(), outputs=("x", "P", "status"))
    index = [found.components.index(f"p{axis}") for axis in "xyz"[:m]]
    used = np.isfinite(tracks.z) & ~tracks.repeated & found.scored[1::2, None]
    S = found.P[::2][:, index][:, :, index] + _noise(filter, tracks)
    S = np.where(used[:, :, None] & used[:, None, :], S, 0.0)
    S[:, range(m), range(m)] += ~used  # what is left out is independent, with no innovation
    residual = np.where(used, tracks.z - found.x[::2][:, index], 0.0)
    return np.einsum("ni,ni->n", residual, np.linalg.solve(S, residual[..., None])[..., 0]), used.sum(axis=1)


def _noise(filter: Any, tracks: Tracks) -> Array:
    """Covariance of each row's measurement, (N, m, m) or (1, m, m)."""
    m = tracks.z.shape[1]
    if tracks.covariance is None:
        return filter.sensors[0].noise[None]
    given = np.asarray(tracks.covariance)
    return given if given.ndim == 3 else given[:, :, None] * np.eye(m)


def parts(tracks: Tracks, variance: Array) -> np.ndarray:
    """Index into `PARTS` of every row, −1 where the positions around it do not tell; variance (m,) of a measured
    position.
    """
    steps = np.diff(tracks.time)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 1.0
    reach = max(REACH, STEPS * usual)
    position, noise = _positions(tracks, NOISE * np.sqrt(variance))
    before, here, after = (_around(tracks, position, shift, reach) for shift in (-reach, 0.0, reach))
    v1, v2, moved = (here - before)[:, :2], (after - here)[:, :2], after - before
    distance = np.hypot(moved[:, 0], moved[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        course = np.abs(np.arctan2(v1[:, 0] * v2[:, 1] - v1[:, 1] * v2[:, 0], (v1 * v2).sum(axis=1)))
        standing = distance < max(2.0 * reach * STANDING, math.sqrt(2.0) * noise[0])
        turning = course > np.maximum(TURNING, 2.0 * math.sqrt(6.0) * noise[0] / distance)
        climbing = np.zeros(len(moved), bool)
        if moved.shape[1] > 2:
            climbing = np.abs(moved[:, 2]) > np.maximum(CLIMBING * distance, math.sqrt(2.0) * noise[2])
    return np.where(np.isfinite(distance), np.select([standing, turning, climbing], [3, 1, 2], 0), -1)


def _positions(tracks: Tracks, noise: Array) -> tuple[Array, Array]:
    """True positions (N, m), which have no noise, or else the measured ones."""
    names = [f"p{axis}" for axis in "xyz"[: tracks.z.shape[1]]]
    if tracks.truth is None or not set(names) <= set(tracks.components):
        return tracks.z, noise
    return tracks.truth[:, [tracks.components.index(name) for name in names]], np.zeros_like(noise)


def _around(tracks: Tracks, position: Array, shift: float, reach: float) -> Array:
    """Positions (N, m) at each row's time plus shift, on the line between the known ones next to it; NaN in gaps over
    reach.
    """
    out = np.full(position.shape, np.nan)
    for first, end in zip(tracks.offsets[:-1], tracks.offsets[1:], strict=True):
        time = tracks.time[first:end]
        for k in range(position.shape[1]):
            known = np.flatnonzero(np.isfinite(position[first:end, k]))
            if len(known) < 2:
                continue
            t, wanted = time[known], time + shift
            value = np.interp(wanted, t, position[first:end, k][known], left=np.nan, right=np.nan)
            next_one = np.clip(np.searchsorted(t, wanted), 1, len(t) - 1)
            value[t[next_one] - t[next_one - 1] > reach] = np.nan
            out[first:end, k] = value
    return out
