"""Many tracks laid end to end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..checks import Array
from ..frozen import frozen

OF_ROWS = ("time", "z", "covariance", "sensor", "truth", "counts", "new")
OF_TRACKS = ("owner", "family")


@frozen
class Tracks:
    """Measurements of many tracks laid end to end, as ``filter`` takes them, and what is known about them.

    time (N,), z (N, m) and offsets (B + 1,), where tracks begin and the last one ends; covariance (N, m, m) or
    variances (N, m) and sensor (N,) of each row, None where they do not differ. truth (N, c) in the reported
    ``components``, NaN where unknown; counts (N,) rows that errors are counted in; new (N,) rows that likelihoods are
    counted in, those that do not repeat the measurement before; owner (B,) whose tracks are never parted (a target, a
    run); family (B,) from 0, of data whose errors are measured apart.
    """

    time: Array
    z: Array
    offsets: np.ndarray
    covariance: Array | None = None
    sensor: np.ndarray | None = None
    truth: Array | None = None
    components: tuple[str, ...] = ()
    counts: np.ndarray | None = None
    new: np.ndarray | None = None
    owner: np.ndarray | None = None
    family: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def rows(self) -> int:
        """Number of rows of all tracks."""
        return len(self.time)

    @property
    def lengths(self) -> np.ndarray:
        """Rows of each track (B,)."""
        return np.diff(self.offsets)

    @property
    def first(self) -> np.ndarray:
        """First row of each track (B,)."""
        return self.offsets[:-1]

    @property
    def of_row(self) -> np.ndarray:
        """Which track each row is in (N,)."""
        return np.repeat(np.arange(len(self)), self.lengths)

    def at(self, track: int) -> slice:
        """The rows of one track."""
        return slice(int(self.offsets[track]), int(self.offsets[track + 1]))

    def keywords(self) -> dict[str, Any]:
        """For ``filter(**tracks.keywords())``."""
        names = ("time", "z", "offsets", "covariance", "sensor")
        return {name: getattr(self, name) for name in names}

    def some(self, tracks: np.ndarray) -> Tracks:
        """The tracks of these numbers, in this order."""
        return self.heads(tracks, self.lengths[tracks])

    def heads(self, tracks: np.ndarray, lengths: np.ndarray) -> Tracks:
        """The given number of rows from the beginning of each of these tracks."""
        offsets = np.r_[0, np.cumsum(lengths)]
        rows = np.repeat(self.first[tracks] - offsets[:-1], lengths) + np.arange(offsets[-1])
        return replace(self, **self._cut(OF_ROWS, rows), **self._cut(OF_TRACKS, tracks), offsets=offsets)

    def doubled(self) -> Tracks:
        """Every row twice, the first time without its measurement, which gives the prediction for its time.

        Only z, covariance and sensor are kept.
        """
        z = np.full((2 * self.rows, self.z.shape[1]), np.nan)
        z[1::2] = self.z
        twice: dict[str, Any] = {
            name: None if getattr(self, name) is None else np.repeat(getattr(self, name), 2, axis=0)
            for name in ("covariance", "sensor")
        }
        return Tracks(np.repeat(self.time, 2), z, 2 * self.offsets, **twice)

    def axes_apart(self) -> Tracks:
        """Every measured axis as a track of its own, all of x first; the truth of each axis is px, vx, … for all.

        Of covariances the variances are kept.
        """
        axes = self.z.shape[1]
        noise = self.covariance
        if noise is not None:
            noise = np.einsum("nii->ni", noise) if noise.ndim == 3 else noise
            noise = noise.T.reshape(-1, 1)
        kinds = [c for c in "pva" if all(c + a in self.components for a in "xyz"[:axes])]
        truth = None
        if self.truth is not None:
            columns = [[self.components.index(c + a) for c in kinds] for a in "xyz"[:axes]]
            truth = np.concatenate([self.truth[:, each] for each in columns])
        copied: dict[str, Any] = {
            name: None if getattr(self, name) is None else np.concatenate([getattr(self, name)] * axes)
            for name in ("time", "sensor", "counts", "new", *OF_TRACKS)
        }
        return replace(
            self,
            z=np.ascontiguousarray(self.z.T).reshape(-1, 1),
            offsets=np.r_[self.offsets, *(self.offsets[1:] + k * self.rows for k in range(1, axes))],
            covariance=noise,
            truth=truth,
            components=tuple(f"{c}x" for c in kinds) if truth is not None else (),
            **copied,
        )

    @property
    def repeated(self) -> np.ndarray:
        """Components (N, m) that equal the one measured before them in their track, to the last bit."""
        rows = np.arange(self.rows)
        first = np.repeat(self.first, self.lengths)
        out = np.zeros(self.z.shape, bool)
        for k in range(self.z.shape[1]):
            there = np.isfinite(self.z[:, k])
            latest = np.maximum.accumulate(np.where(there, rows, -1))
            before = np.r_[-1, latest[:-1]]
            out[:, k] = there & (before >= first) & (self.z[:, k] == self.z[np.maximum(before, 0), k])
        return out

    def _cut(self, names: Sequence[str], index: np.ndarray) -> dict[str, Any]:
        return {name: None if getattr(self, name) is None else getattr(self, name)[index] for name in names}


def joined(parts: Sequence[Tracks]) -> Tracks:
    """Tracks laid end to end; only what all of them know about rows and tracks is kept."""

    def all_of(name: str) -> Any:
        each = [getattr(part, name) for part in parts]
        return None if any(a is None for a in each) else np.concatenate(each)

    lengths = np.concatenate([part.lengths for part in parts])
    known = {name: all_of(name) for name in (*OF_ROWS, *OF_TRACKS)}
    return Tracks(offsets=np.r_[0, np.cumsum(lengths)], components=parts[0].components, **known)
