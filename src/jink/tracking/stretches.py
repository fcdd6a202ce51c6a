"""Rows in bounded pieces: whole parts together, a long part in overlapping stretches.

A filter forgets where it began. So a stretch of a long part is run from some rows before it, as a track of its own
beside the others of its piece; to be smoothed, it goes on to some rows after it. At every seam the two stretches that
meet must have the same estimate, to `SAME` of its standard deviation. Where they have not, the overlap grows. A filter
that remembers more than `MOST` rows goes through the part once, and carries its state from piece to piece.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from ..estimate import Estimate, covariance_name, covariance_pair
from ..filters.bank import Bank
from ..filters.row_noise import Repeated, RowNoise
from ..frozen import frozen
from .manoeuvring import Manoeuvres, Moving, Told, probabilities
from .placing import Placed
from .state import State, covariances_read

CHUNK = 60_000  # rows that are filtered at once: bounds the memory that covariances take
STRETCHES = 16  # of one piece: the lanes of two packs
OVERLAP, MOST = 512, 16_384  # rows, to begin with and at most
SAME = 1e-11  # of a standard deviation, and of a probability
# Of a coordinate, at an overlap of `OVERLAP` rows. Errors of rounding are independent from row to row, so those of n
# rows that a filter remembers add up to sqrt(n) of one; the overlap it needs is in proportion to n.
ROUNDING = 8 * np.finfo(float).eps
OUTPUTS = ("x", "mode_probability", "nis", "nis_dof", "status")


@frozen
class Piece:
    """Rows `rows` of the parts, which are whole (`part` is None), or a piece of the long part whose rows are `part`."""

    rows: slice
    part: slice | None


def pieces(offsets: np.ndarray, most: int = CHUNK) -> Iterator[Piece]:
    """All rows in pieces of about `most`, in their order."""
    begin = 0
    while begin < offsets.size - 1:
        end = int(np.searchsorted(offsets, offsets[begin] + most))
        end = min(max(end, begin + 1), offsets.size - 1)
        if end > begin + 1 and offsets[end] - offsets[end - 1] > 2 * most:
            end -= 1  # a long part comes by itself
        first, last = int(offsets[begin]), int(offsets[end])
        if end == begin + 1 and last - first > 2 * most:
            count = -(-(last - first) // most)
            bounds = np.linspace(first, last, count + 1).astype(int).tolist()
            for low, high in pairwise(bounds):
                yield Piece(slice(low, high), slice(first, last))
        else:
            yield Piece(slice(first, last), None)
        begin = end


@frozen
class Run:
    """A piece and the estimates of its rows."""

    piece: Piece
    estimate: Estimate
    state: State
    moving: Moving

    @classmethod
    def of(cls, piece: Piece, estimate: Estimate, placed: Placed) -> Run:
        """A piece of `placed`."""
        rows, part = piece.rows, piece.part
        new = placed.new[rows] if part is None else np.arange(rows.start, rows.stop) == part.start
        estimate = replace(estimate, source=None)
        return cls(piece, estimate, State(estimate), Moving.of(estimate, placed.time[rows], new))


class Stretched:
    """Runs one verb of a filter, `filter` or `smooth`, on pieces, one after the other."""

    def __init__(
        self,
        filter: Any,
        placed: Placed,
        covariance: RowNoise | Repeated | None,
        smoothing: Mapping[str, Any] | None,
        threads: int | None,
    ):
        """smoothing: what `filter.smooth` is told; None: the rows are filtered."""
        self.verb = filter.filter if smoothing is None else partial(filter.smooth, **smoothing)
        self.time, self.z, self.offsets, self.covariance = placed.time, placed.z, placed.offsets, covariance
        self.smooth, self.threads = smoothing is not None, threads
        self.overlap = OVERLAP
        self.end: dict[str, np.ndarray] | None = None  # the last row's estimate of the piece before, of the same part
        self.carried: Carried | None = None
        self.filter = filter
        self.covariances = covariances_read(filter.components)

    def run(self, piece: Piece) -> Estimate:
        """The estimates of a piece's rows."""
        if piece.part is None:
            first, last = np.searchsorted(self.offsets, [piece.rows.start, piece.rows.stop])
            return self._filtered(piece.rows, self.offsets[first : last + 1] - piece.rows.start)
        if piece.rows.start == piece.part.start:
            self.end = None
        while True:
            found = self._stretches(piece.rows, piece.part)
            if found is not None:
                self.end = {name: value[-1:].copy() for name, value in found.results.items()}
                return found
            self.overlap *= 4

    def _filtered(self, rows: Any, offsets: np.ndarray) -> Estimate:
        alone = isinstance(self.filter, Bank)
        found = self.verb(
            self.time[rows],
            self.z[rows],
            offsets=offsets,
            covariance=None if self.covariance is None else self.covariance.piece(rows),
            threads=self.threads,
            outputs=(*OUTPUTS, *(self.covariances if alone else ["P"])),
        )
        return found if alone else _apart(found, self.covariances)

    def _stretches(self, rows: slice, part: slice) -> Estimate | None:
        """The piece's estimates, or None where two stretches that meet do not agree."""
        bounds = np.linspace(rows.start, rows.stop, STRETCHES + 1).astype(int)
        low = np.maximum(bounds[:-1] - self.overlap, part.start)
        high = np.minimum(bounds[1:] + self.overlap, part.stop) if self.smooth else bounds[1:]
        if self.overlap > MOST:
            return self._whole(rows, part) if self.smooth else self._carried(rows, part)
        offsets = np.r_[0, np.cumsum(high - low)]
        which = np.concatenate([np.arange(a, b) for a, b in zip(low, high, strict=True)])
        found = self._filtered(which, offsets)
        place = offsets[:-1] - low  # of a row in each stretch: its number and this
        seams = bounds[1:-1] - 1
        rounding = ROUNDING * math.sqrt(self.overlap / OVERLAP)
        seam, after = _at(found.results, place[:-1] + seams), _at(found.results, place[1:] + seams)
        if not _agree(found, seam, after, rounding):
            return None
        before = place[:1] + rows.start - 1
        if self.end is not None and not _agree(found, self.end, _at(found.results, before), rounding):
            return None
        inner = [slice(a + p, b + p) for a, b, p in zip(bounds[:-1], bounds[1:], place, strict=True)]
        return _taken_out(found, inner)

    def _whole(self, rows: slice, part: slice) -> Estimate:
        """The piece's estimates out of those of the whole part."""
        whole = self._filtered(part, np.array([0, part.stop - part.start]))
        return _rows_of(whole, np.arange(rows.start, rows.stop) - part.start)

    def _carried(self, rows: slice, part: slice) -> Estimate:
        """The piece's estimates by a filter that stands at its first row."""
        if self.carried is None or self.carried.row != rows.start:
            self.carried = Carried(self.filter, part.start)
            for first in range(part.start, rows.start, CHUNK):
                self.carried.run(self, slice(first, min(first + CHUNK, rows.start)))
        return self.carried.run(self, rows)


class Carried:
    """A live filter that goes through a part; row: the next one."""

    def __init__(self, filter: Any, row: int):
        self.live, self.row = filter.start(1, outputs=(*OUTPUTS, "P")), row
        self.own = getattr(filter, "declaration", None) is None  # models that run in Python

    def run(self, of: Stretched, rows: slice) -> Estimate:
        """The estimates of the rows from `row` on."""
        self.row = rows.stop
        if not self.own:
            noise = None if of.covariance is None else of.covariance[rows]
            return _apart(self.live.follow(of.time[rows], of.z[rows], covariance=noise), of.covariances)
        found = [_apart(self._next(of, row), of.covariances) for row in range(rows.start, rows.stop)]
        names = found[0].results
        return replace(
            found[0], results={name: np.concatenate([each.results[name] for each in found]) for name in names}
        )

    def _next(self, of: Stretched, row: int) -> Estimate:
        noise = None if of.covariance is None else of.covariance[row : row + 1]
        return self.live.update(of.time[row], of.z[row : row + 1], covariance=noise)


def _at(results: Mapping[str, np.ndarray], rows: np.ndarray) -> dict[str, np.ndarray]:
    return {name: value[rows] for name, value in results.items()}


def _rows_of(estimate: Estimate, rows: np.ndarray) -> Estimate:
    return replace(estimate, results=_at(estimate.results, rows), source=None)


def _apart(estimate: Estimate, names: list[str]) -> Estimate:
    """With single covariances in place of P."""
    found = {name: value for name, value in estimate.results.items() if name != "P"}
    for name in names:
        i, j = covariance_pair(name, estimate.components) or (0, 0)
        found[name] = estimate.P[:, i, j].copy()
    return replace(estimate, results=found)


def _taken_out(estimate: Estimate, inner: list[slice]) -> Estimate:
    """The estimate of these rows, one slice after the other. The whole one is let go array by array, the largest first:
    where stretches overlap by much, it has several times as many rows.
    """
    whole = estimate.results
    results = {}
    for name in sorted(whole, key=lambda name: whole[name].nbytes, reverse=True):
        value = whole.pop(name)
        results[name] = np.concatenate([value[rows] for rows in inner])
        del value
    return replace(estimate, results=results, source=None)


def _agree(of: Estimate, one: dict[str, np.ndarray], other: dict[str, np.ndarray], rounding: float) -> bool:
    """Whether rows of two results are the same; NaN is equal to NaN. rounding: of a coordinate."""
    x, y = one["x"], other["x"]
    sd = np.stack([np.sqrt(one[covariance_name(name, name)]) for name in of.components], axis=1)
    # far from the origin, coordinates have fewer digits behind the point, and all that follows from them too
    most = SAME + rounding * np.max(np.abs(x) / sd, axis=1, initial=0.0)
    near = [np.abs(x - y) / sd, np.abs(one["mode_probability"] - other["mode_probability"])]
    for name in one:
        if pair := covariance_pair(name, of.components):
            near.append((np.abs(one[name] - other[name]) / sd[:, pair].prod(axis=1))[:, None])
    agree = [each.max(axis=1) <= most for each in near]
    neither = np.isnan(x).all(axis=1) & np.isnan(y).all(axis=1)
    return bool(np.all(neither | np.logical_and.reduce(agree)))


class ManoeuvresGoOn:
    """Manoeuvres of rows in pieces: those of a long part need some rows of the pieces before and after."""

    def __init__(self, what: Manoeuvres):
        self.what = what
        self.segments = what.segments()
        self.before: Moving | None = None

    def told(self, moving: Moving, after: Moving | None) -> Told:
        """Of one piece of a long part, and the piece after it (None: it is the last)."""
        window, rows, known = self.what.window, moving.time.size, [moving]
        begin = ahead = 0
        if self.before is not None:
            back = int(np.searchsorted(self.before.time, moving.time[0] - window - 1.0))
            back = min(back, self.before.time.size - 1)
            begin = self.before.time.size - back
            known.insert(0, self.before.some(slice(back, None)))
        if after is not None:
            ahead = max(int(np.searchsorted(after.time, moving.time[-1] + window + 1.0)), 1)
            known.append(after.some(slice(0, ahead)))
        found = [each[begin:] for each in probabilities(Moving.joined(known), self.what)]
        time = np.concatenate([moving.time, after.time[:ahead]]) if after is not None else moving.time
        new = np.arange(time.size) == (0 if self.before is None else -1)
        segment = self.segments.numbers(found[0], time, new, ahead)
        self.before = moving if after is not None else None
        return Told(found[0][:rows], found[1][:rows] if len(found) > 1 else None, segment)
