"""Functions of the user's own over a batch of tracks: called in the form they are written in, and checked."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._engine import native

Array = NDArray[Any]  # of floats, indices or flags; the first axis is the track
Batch = Callable[[Array], Array]


class ModelError(ValueError):
    """A function of the user's own gave what cannot be used."""


@contextmanager
def at_scan(k: int) -> Iterator[None]:
    """Errors of the user's functions say in which scan."""
    try:
        yield
    except ModelError as error:
        raise ValueError(f"{error}, at scan {k}") from None
    except Exception as error:
        error.add_note(f"at scan {k}")
        raise


def checked(name: str, value: Any, shape: tuple[int, ...], given: str) -> Array:
    """A function's value as finite floats of the expected shape. Errors: ModelError naming both."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ModelError(f"{name}: expected floats of shape {shape} for {given}, got {type(value).__name__}") from None
    if array.shape != shape:
        raise ModelError(f"{name}: expected shape {shape} for {given}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ModelError(f"{name}: has NaN or infinite values for {given}")
    return array


def call(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """The function's value; an exception of its own says which function it was."""
    try:
        return function(*arguments)
    except Exception as error:
        error.add_note(f"raised by {name}")
        raise


class StepFunction:
    """f(x, dt), Q(dt) and the like for a whole batch: x (B, n), dt (B,), result (B, *shape).

    Written for arrays it is called once; written for one elapsed time (dt a float) once for each that occurs.
    Which it is is found out by trying it, on made-up states, when the filter is built.
    Errors: ValueError if it fits neither, with what happened.
    """

    def __init__(self, name: str, function: Callable[..., Any], shape: tuple[int, ...], states: int | None) -> None:
        self.name, self.function, self.shape, self.of_state = name, function, shape, states is not None
        tracks = max(shape) + 1  # so that no axis of the result is taken for the tracks
        every = getattr(getattr(function, "__self__", None), "step_seconds", None)
        dt = 0.5 + 0.25 * np.arange(tracks) if every is None else every * (1.0 + np.arange(tracks))
        x = 1.0 + 0.1 * np.arange(tracks * (states or 0)).reshape(tracks, -1)
        together, why = self._attempt(lambda: self._once(x, dt, dt))
        one_by_one, why_not = self._attempt(
            lambda: np.stack([self._once(x[[b]], dt[[b]], float(dt[b]))[0] for b in range(tracks)])
        )
        if together is None and one_by_one is None:
            raise ValueError(
                f"{name}: expected a function of dt as a float or an array. "
                f"With an array of shape ({tracks},): {why}. With a float: {why_not}"
            )
        self.takes_arrays = together is not None and (
            one_by_one is None or np.allclose(together, one_by_one, equal_nan=True)
        )

    def __call__(self, x: Array, dt: Array) -> Array:
        if self.takes_arrays:
            result = self._once(x, dt, dt)
        else:
            result = np.empty((len(dt), *self.shape))
            order = np.argsort(dt, kind="stable")
            for rows in np.split(order, np.flatnonzero(np.diff(dt[order])) + 1):
                if len(rows):
                    result[rows] = self._once(x[rows], dt[rows], float(dt[rows[0]]))
        return checked(self.name, result, (len(dt), *self.shape), self._given(x, dt))

    def _once(self, x: Array, dt: Array, step: Any) -> Array:
        value = call(self.name, self.function, *((x.copy(), step) if self.of_state else (step,)))
        array = np.asarray(value, dtype=float)
        shape = (len(dt), *self.shape)
        if array.shape == self.shape and not isinstance(step, np.ndarray) and len(self.shape) == 2:
            return np.broadcast_to(array, shape)
        if array.shape != shape:
            raise ModelError(f"{self.name}: expected shape {shape} for {self._given(x, dt)}, got {array.shape}")
        return array

    def _given(self, x: Array, dt: Array) -> str:
        return f"x {x.shape} and dt {dt.shape}" if self.of_state else f"dt {dt.shape}"

    @staticmethod
    def _attempt(compute: Callable[[], Array]) -> tuple[Array | None, str]:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("error")
            try:
                return compute(), ""
            except ModelError as error:
                return None, str(error).partition(": ")[2]
            except Exception as error:
                return None, f"raised {type(error).__name__}: {error}"


def jacobian_by_differences(function: Batch, x: Array, P: Array) -> Array:
    """dg/dx (B, m, n) of a batch function g by central differences of fourth order, without complex numbers.

    g' = (8 (g(x + h) − g(x − h)) − (g(x + 2h) − g(x − 2h))) / 12h, h a thousandth of the state's sd, or what
    rounding asks for.
    """
    tracks, n = x.shape
    sd = np.sqrt(np.einsum("bii->bi", P))
    h = np.maximum(np.maximum(1e-3 * sd, 6e-6 * np.abs(x)), 1e-6)
    h = (x + h) - x  # what the machine really adds
    points = np.broadcast_to(x, (4, n, tracks, n)).copy()
    for i in range(n):
        for k, share in enumerate((1.0, -1.0, 2.0, -2.0)):
            points[k, i, :, i] += share * h[:, i]
    g = function(points.reshape(-1, n)).reshape(4, n, tracks, -1)
    slope = (8.0 * (g[0] - g[1]) - (g[2] - g[3])) / (12.0 * h.T[:, :, None])
    return np.ascontiguousarray(slope.transpose(1, 2, 0))


def regression(function: Batch, x: Array, P: Array) -> tuple[Array, Array, Array]:
    """Mean (B, m) of g over the 2n points x ± √n Lᵢ, slopes (B, m, n) of g on x, the spread they leave.

    They belong together: the covariance of g is slopes P slopesᵀ + spread. The points are the engine's.
    """
    tracks, n = x.shape
    L = native.root(np.ascontiguousarray(P))
    step = np.sqrt(n) * L.transpose(2, 0, 1)
    g = function(np.concatenate([x + step, x - step]).reshape(-1, n)).reshape(2, n, tracks, -1)
    middle, half = 0.5 * (g[0] + g[1]), (g[0] - g[1]) * (0.5 / np.sqrt(n))
    mean = middle.mean(axis=0)
    slopes = native.solve(L, np.ascontiguousarray(half.transpose(1, 0, 2)), transposed=True).transpose(0, 2, 1)
    away = middle - mean
    return mean, np.ascontiguousarray(slopes), np.einsum("sbi,sbj->bij", away, away) / n
