"""Checks of what callers pass in: each says the parameter's name, what it was and what was expected."""

import os
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
PerAxis = float | Sequence[float]


def numbers(name: str, value: ArrayLike, what: str = "numbers") -> Array:
    """An array of floats."""
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: expected {what}, got {_short(value)}") from None


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def positive(name: str, value: float, *, zero: bool = False) -> float:
    """A finite number above zero (or at least zero)."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: expected a number, got {_short(value)}") from None
    if not np.isfinite(number) or number < 0 or (number == 0 and not zero):
        raise ValueError(f"{name}: expected a {'non-negative' if zero else 'positive'} number, got {number:g}")
    return number


def whole(name: str, value: float, least: int, most: int, of: str = "") -> int:
    """A whole number from least to most; ``of`` says what of."""
    if not isinstance(value, int | float) or not least <= value <= most or int(value) != value:
        raise ValueError(f"{name}: expected a whole number{of} from {least} to {most}, got {_short(value)}")
    return int(value)


def probability(name: str, value: float) -> float:
    """A number between 0 and 1, neither of them."""
    if not isinstance(value, int | float) or not 0 < value < 1:
        raise ValueError(f"{name}: expected a probability between 0 and 1, got {_short(value)}")
    return float(value)


def per_axis(name: str, value: PerAxis, axes: int, *, zero: bool = False) -> list[float]:
    """One number for all axes, or one for each."""
    values = np.atleast_1d(numbers(name, value))
    if values.shape not in ((1,), (axes,)):
        raise ValueError(f"{name}: expected one number or one for each of {axes} axes, got {values.size}")
    return [positive(name, v, zero=zero) for v in np.broadcast_to(values, (axes,))]


def exactly_one(owner: str, **given: object) -> str:
    """The name of the one argument that is not None."""
    names = [name for name, value in given.items() if value is not None]
    if len(names) != 1:
        raise ValueError(f"{owner}: give exactly one of {' or '.join(given)}, got {', '.join(names) or 'none'}")
    return names[0]


def covariance(name: str, value: ArrayLike, size: int) -> Array:
    """A symmetric positive definite matrix of the given size."""
    matrix = numbers(name, value)
    if matrix.shape != (size, size):
        raise ValueError(f"{name}: expected a {size} by {size} matrix, got shape {matrix.shape}")
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
        raise ValueError(f"{name}: is not symmetric")
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise ValueError(f"{name}: is not positive definite") from None
    return matrix


def packed(matrix: Array) -> list[float]:
    """The lower triangle, row by row."""
    return [float(matrix[i, j]) for i in range(len(matrix)) for j in range(i + 1)]


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """The message for an unknown name: the nearest names, then all."""
    import difflib  # for messages only

    names = list(known)
    close = difflib.get_close_matches(name, names, 3, 0.5)
    nearest = f"; did you mean {' or '.join(close)}?" if close else ""
    return f"unknown {what} {name!r}{nearest}\n  Known: {', '.join(names)}"


MOST_THREADS = 4096  # the engine starts no more than are of use


def thread_count(threads: int | None) -> int:
    """As many threads as asked for, or one for each core there is leave to run on."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if int(threads) != threads or threads < 1:
        raise ValueError(f"threads: expected a whole number from 1, got {threads!r}")
    return min(int(threads), MOST_THREADS)
