"""The rows a filter is given, checked: measurements, track bounds, noise per row."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._engine import native
from ..checks import Array, numbers, whole
from ..frozen import frozen
from ..models.start import Prior
from ..times import seconds
from .row_noise import RowNoise


class Added(NamedTuple):
    """Rows that were put in: where they are, which lie before their track's first row, and whose they are."""

    row: NDArray[np.int64]
    early: NDArray[np.bool_]
    offsets: NDArray[np.int64]


@frozen
class Batch:
    """Rows of tracks laid end to end, checked: what the engine runs on.

    time (N,), z (N, columns), offsets (B + 1,); of each row or None: sensor, noise (variances, covariances or what is
    not zero in them), input; prior x, P.
    """

    time: Array
    z: Array
    offsets: NDArray[np.int64]
    sensor: NDArray[np.int32] | None
    noise: Array | RowNoise | None
    input: Array | None
    prior: tuple[Array, Array] | tuple[None, None]

    @classmethod
    def of(
        cls,
        time: ArrayLike,
        z: ArrayLike,
        *,
        offsets: ArrayLike | None,
        sensor: ArrayLike | None,
        covariance: ArrayLike | RowNoise | None,
        input: ArrayLike | None,
        prior: Prior | None,
        columns: int,
        sensors: int,
        axes: int,
        components: tuple[str, ...],
    ) -> Batch:
        """Errors: ValueError or TypeError naming the argument, and the row where there is one."""
        rows = measurements(z, columns)
        times = np.ascontiguousarray(seconds(time), dtype=float).reshape(-1)
        n = len(rows)
        if len(times) != n:
            raise ValueError(f"time: has {len(times)} rows where z has {n}")
        bounds = track_offsets(offsets, n)
        return cls(
            times,
            rows,
            bounds,
            sensor_index(sensor, n, sensors),
            batch_noise(covariance, n, columns),
            None if input is None else array_of("input", input, (n, axes)),
            (None, None) if prior is None else prior_of_tracks(prior, components, len(bounds) - 1),
        )

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(self.z)

    @property
    def tracks(self) -> int:
        """How many tracks there are."""
        return len(self.offsets) - 1

    def part(self, first: int, end: int) -> Batch:
        """The tracks from one to before another."""
        rows = slice(int(self.offsets[first]), int(self.offsets[end]))
        cut = {name: _cut(getattr(self, name), rows) for name in ("time", "z", "sensor", "noise", "input")}
        x, P = self.prior
        prior = (None, None) if x is None or P is None else (x[first:end], P[first:end])
        return replace(self, **cut, offsets=self.offsets[first : end + 1] - rows.start, prior=prior)

    def only(self, rows: NDArray[np.int64], offsets: NDArray[np.int64]) -> Batch:
        """These rows, which belong to tracks as ``offsets`` say."""
        cut = {name: _cut(getattr(self, name), rows) for name in ("time", "z", "sensor", "noise", "input")}
        return replace(self, **cut, offsets=offsets)

    def options(self, row: int) -> dict[str, Any]:
        """What is told live of one row beside its time and measurement."""
        found: dict[str, Any] = {} if self.sensor is None else {"sensor": int(self.sensor[row])}
        if self.noise is not None:
            found["covariance"] = self.noise[row : row + 1][0]
        return found if self.input is None else found | {"input": self.input[row]}

    def with_times(self, times: list[Array]) -> tuple[Batch, Added]:
        """The same with a row without a measurement at each of a track's own times, after the rows of that time.

        A known input goes on until the next row, and ends with the last. Errors: ValueError for a track without rows.
        """
        old, new, ends, where, early = [], [], [0], [], []
        for track, wanted in enumerate(times):
            first, end = int(self.offsets[track]), int(self.offsets[track + 1])
            if first == end and len(wanted):
                raise ValueError(f"times: target {track} has no rows")
            before = wanted < self.time[first] if len(wanted) else np.empty(0, dtype=bool)
            inside = wanted[~before]
            after = first + np.searchsorted(self.time[first:end], inside, "right")
            every = np.r_[self.time[first:end], inside]
            order = np.argsort(every, kind="stable")
            place = np.full(len(wanted), ends[-1])
            place[~before] = ends[-1] + np.argsort(order, kind="stable")[end - first :]
            old.append(np.r_[np.arange(first, end), after][order])
            new.append(np.where(order < end - first, np.nan, every[order]))
            ends.append(ends[-1] + len(order))
            where.append(place)
            early.append(before)
        row, at = np.concatenate([*old, np.empty(0)]).astype(np.int64), np.concatenate([*new, np.empty(0)])
        last = np.repeat(self.offsets[1:] - 1, np.diff(ends))
        wider = self.only(np.minimum(row, last), np.array(ends, dtype=np.int64))
        put = np.isfinite(at)
        wider.time[put], wider.z[put] = at[put], np.nan
        if wider.input is not None:
            wider.input[row > last] = 0.0
        lengths = np.r_[0, np.cumsum([len(wanted) for wanted in times])].astype(np.int64)
        return wider, Added(np.concatenate(where).astype(np.int64), np.concatenate(early), lengths)

    def until(self, lag: int | None, lag_seconds: float | None) -> NDArray[np.int64] | None:
        """Per row the last row of its track that its estimate uses; None: all.

        Errors: ValueError unless the lag is a whole number of scans, or seconds, and not both.
        """
        if lag is None and lag_seconds is None:
            return None
        if lag is not None and lag_seconds is not None:
            raise ValueError("lag, lag_seconds: expected one of them, got both")
        rows, last = np.arange(self.rows), np.repeat(self.offsets[1:] - 1, np.diff(self.offsets))
        if lag is not None:
            if isinstance(lag, bool):
                raise ValueError(f"lag: expected a whole number of scans, got {lag!r}")
            return np.minimum(rows + min(whole("lag", lag, 0, of=" of scans"), len(rows)), last)
        seconds_after = float(numbers("lag_seconds", lag_seconds or 0.0, "seconds").reshape(-1)[:1].sum())
        if not (np.isfinite(seconds_after) and seconds_after >= 0.0):
            raise ValueError(f"lag_seconds: expected seconds, not negative, got {lag_seconds!r}")
        until = np.empty(self.rows, dtype=np.int64)
        for first, end in zip(self.offsets[:-1], self.offsets[1:], strict=True):
            times = self.time[first:end]
            until[first:end] = first + np.searchsorted(times, times + seconds_after, "right") - 1
        return until

    def arguments(self) -> tuple[Any, ...]:
        """In the order in which the engine takes them."""
        noise, full = self.noise, isinstance(self.noise, np.ndarray) and self.noise.ndim == 3
        if isinstance(noise, RowNoise):
            noise, full = noise.columns(), noise.full
        columns = self.z.shape[1]
        return (self.time, self.z, columns, self.offsets, self.sensor, noise, full, self.input, *self.prior)


def _cut(array: Array | None, rows: Any) -> Any:
    return None if array is None else array[rows]


def measurements(z: ArrayLike, columns: int) -> Array:
    """z as (N, columns) floats; None is a missing row or component, and so is what a mask of NumPy hides."""
    try:
        if isinstance(z, np.ma.MaskedArray):
            z = np.ma.filled(z.astype(float), np.nan)
        array = np.asarray(z, dtype=float)
    except (TypeError, ValueError, OverflowError):
        array = _with_missing_rows(z, columns)
    if array.ndim == 1 and columns == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"z: expected shape (N, {columns}), one column per measured component, got {array.shape}")
    return np.ascontiguousarray(array)


def _with_missing_rows(z: Any, columns: int) -> Array:
    try:
        return np.array([[np.nan] * columns if row is None else row for row in z], dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"z: expected numbers, NaN or None, in rows of {columns}") from None


def track_offsets(offsets: ArrayLike | None, n: int) -> NDArray[np.int64]:
    if offsets is None:
        return np.array([0, n], dtype=np.int64)
    bounds = indices("offsets", offsets)
    if bounds.ndim != 1 or len(bounds) < 1 or bounds.dtype.kind not in "iu":
        raise ValueError("offsets: expected whole numbers (B + 1,)")
    bounds = np.array(bounds, dtype=np.int64)  # a copy, which nobody changes while the engine runs
    if bounds[0] != 0 or bounds[-1] != n or np.any(np.diff(bounds) < 0):
        raise ValueError(f"offsets: expected to rise from 0 to the number of rows {n}, got {bounds[0]} to {bounds[-1]}")
    return bounds


def batch_noise(covariance: ArrayLike | RowNoise | None, n: int, columns: int) -> Array | RowNoise | None:
    """The noise of rows of a batch, checked."""
    if not isinstance(covariance, RowNoise):
        return row_noise(covariance, n, columns)
    if (len(covariance), covariance.size) != (n, columns):
        raise ValueError(f"covariance: expected {n} rows of {columns}, got {len(covariance)} of {covariance.size}")
    wrong = covariance.first_indefinite()
    if wrong >= 0:
        _refuse(covariance[wrong : wrong + 1][0], wrong)
    return covariance


def row_noise(covariance: ArrayLike | None, n: int, columns: int) -> Array | None:
    if covariance is None:
        return None
    R = np.ascontiguousarray(numbers("covariance", covariance))
    if R.shape not in ((n, columns), (n, columns, columns)):
        raise ValueError(
            f"covariance: expected ({n}, {columns}, {columns}), or ({n}, {columns}) variances, got {R.shape}"
        )
    if R.ndim == 3 and columns > 1:
        wrong = native.first_indefinite(R)
        if wrong >= 0:
            _refuse(R[wrong], wrong)
    else:
        _check_variances(R.reshape(n, columns), 0)
    return R


def _refuse(R: Array, row: int) -> None:
    """Say what is wrong with the variances (m,) or the covariance (m, m) of a row."""
    _check_variances((np.diagonal(R) if R.ndim == 2 else R)[None], row)
    raise ValueError(f"covariance: row {row} is not symmetric and positive definite")


def _check_variances(variances: Array, first: int) -> None:
    """variances (N, m) of the rows from `first` on."""
    # NaN is below nothing
    if variances.size and not (variances.min() > 0 and variances.max() < np.inf):
        bad = ~(np.isfinite(variances) & (variances > 0)).all(axis=1)
        raise ValueError(f"covariance: row {first + int(np.argmax(bad))} has a variance that is not positive")


def indices(name: str, value: ArrayLike) -> NDArray[Any]:
    try:
        return np.asarray(value)
    except ValueError:
        raise ValueError(f"{name}: expected whole numbers in one row, got {value!r}") from None


def array_of(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.ascontiguousarray(numbers(name, value))
    if array.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: has values that are not finite")
    return array


def sensor_index(sensor: ArrayLike | None, n: int, sensors: int) -> NDArray[np.int32] | None:
    """Which of so many sensors measured each of n rows."""
    if sensor is None:
        return None
    index = np.array(indices("sensor", sensor))  # a copy, as of offsets
    if index.shape != (n,) or index.dtype.kind not in "iu":
        raise ValueError(f"sensor: expected {n} integers, one per row, got {index.dtype} of shape {index.shape}")
    if n and (index.min() < 0 or index.max() >= sensors):
        raise ValueError(f"sensor: expected indices 0 to {sensors - 1}, got {index.min()} to {index.max()}")
    return np.ascontiguousarray(index, dtype=np.int32)


def prior_of_tracks(prior: Prior, components: tuple[str, ...], tracks: int) -> tuple[Array, Array]:
    """x (tracks, n) and P (tracks, n, n) of a start that is given for all tracks or for each."""
    n = len(components)
    if not isinstance(prior, Prior):
        raise TypeError(f"initial: expected a jink.Prior, got {type(prior).__name__}")
    x, P = numbers("initial.x", prior.x), numbers("initial.P", prior.P)
    if x.shape not in ((n,), (tracks, n)) or P.shape not in ((n, n), (tracks, n, n)):
        raise ValueError(
            f"initial: expected x ({n},) or ({tracks}, {n}) and P to match, components {', '.join(components)}; "
            f"got {x.shape} and {P.shape}"
        )
    try:
        np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        raise ValueError("initial: P is not positive definite") from None
    return (
        np.ascontiguousarray(np.broadcast_to(x, (tracks, n))),
        np.ascontiguousarray(np.broadcast_to(P, (tracks, n, n))),
    )
