"""Checks of what callers pass in: each says the parameter's name, what it was and what was expected."""

import ast
import functools
import inspect
import os
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
PerAxis = float | Sequence[float]
Given = ParamSpec("Given")
Answer = TypeVar("Answer")


def numbers(name: str, value: ArrayLike, what: str = "numbers") -> Array:
    """An array of floats."""
    try:
        array = np.asarray(value, dtype=float)
        if array.ndim == 0 and isinstance(value, str | bytes):
            raise TypeError
        return array
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: expected {what}, got {_short(value)}") from None


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


MOST = 1e150  # whose square is a number too


def real(name: str, value: float) -> float:
    """A number, which may be infinite or NaN."""
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: expected a number, got {_short(value)}") from None


def number(name: str, value: float) -> float:
    """A finite number."""
    given = real(name, value)
    if not np.isfinite(given):
        raise ValueError(f"{name}: expected a finite number, got {given:g}")
    return given


def positive(name: str, value: float, *, zero: bool = False) -> float:
    """A number above zero (or at least zero) whose square is one too."""
    what = "non-negative" if zero else "positive"
    try:
        given = number(name, value)
    except ValueError:
        raise ValueError(f"{name}: expected a {what} number, got {float(value):g}") from None
    if given < 0 or (given == 0 and not zero):
        raise ValueError(f"{name}: expected a {what} number, got {given:g}")
    if given > MOST:
        raise ValueError(f"{name}: expected at most {MOST:g}, got {given:g}")
    return given


def whole(name: str, value: float, least: int, most: float = np.inf, of: str = "") -> int:
    """A whole number from least to most; ``of`` says what of."""
    plain = isinstance(value, int | float | np.integer) and not isinstance(value, bool)
    fits = plain and least <= value <= most and abs(value) < np.inf
    if not fits or int(value) != value:
        limits = f"{least} to {most}" if most < np.inf else f"{least}"
        raise ValueError(f"{name}: expected a whole number{of} from {limits}, got {_short(value)}")
    return int(value)


def one_of(name: str, value: object, known: Iterable[str]) -> str:
    """One of some names."""
    names = list(known)
    if not isinstance(value, str) or value not in names:
        listed = f"{', '.join(map(repr, names[:-1]))} or {names[-1]!r}"
        raise ValueError(f"{name}: expected {listed}, got {_short(value)}")
    return value


def items(name: str, value: object, what: str) -> tuple[Any, ...]:
    """What a sequence holds."""
    if isinstance(value, str | bytes) or not np.iterable(value):
        raise TypeError(f"{name}: expected {what}, got {_short(value)}")
    return tuple(value)  # pyright: ignore[reportArgumentType]


def with_attributes(name: str, value: object, attributes: Sequence[str], what: str) -> None:
    """Check that an argument can do what is asked of it."""
    if isinstance(value, type) or not all(hasattr(value, attribute) for attribute in attributes):
        raise TypeError(f"{name}: expected {what}, got {_short(value)}")


def probability(name: str, value: float) -> float:
    """A number between 0 and 1, neither of them."""
    if not isinstance(value, int | float) or not 0 < value < 1:
        raise ValueError(f"{name}: expected a probability between 0 and 1, got {_short(value)}")
    return float(value)


def rare(name: str, value: float) -> float:
    """A probability whose complement is not rounded to one."""
    if probability(name, value) < 1e-12:
        raise ValueError(f"{name}: expected at least 1e-12, got {value:g}")
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
    close = difflib.get_close_matches(name, names, 3, 0.5) if isinstance(name, str) else []
    nearest = f"; did you mean {' or '.join(close)}?" if close else ""
    return f"unknown {what} {name!r}{nearest}\n  Known: {', '.join(names)}"


MOST_THREADS = 4096  # the engine starts no more than are of use


def thread_count(threads: int | None) -> int:
    """As many threads as asked for, or one for each core there is leave to run on."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(whole("threads", threads, 1), MOST_THREADS)


def by_hints(function: Callable[Given, Answer]) -> Callable[Given, Answer]:
    """A function whose arguments are checked by their annotations; errors name an argument.

    Arrays must hold numbers, ``int`` a whole number, ``float`` a number, a Literal one of its values, a Sequence or an
    Iterable several things. What goes wrong inside without naming an argument names them all, with their shapes.
    """
    signature = inspect.signature(function)
    hints = {name: str(parameter.annotation) for name, parameter in signature.parameters.items()}

    @functools.wraps(function)
    def checked(*args: Given.args, **options: Given.kwargs) -> Answer:
        given = signature.bind(*args, **options).arguments
        for name, value in given.items():
            _check_by_hint(name, hints[name], value)
        try:
            return function(*args, **options)
        except (TypeError, ValueError, IndexError, OverflowError, ZeroDivisionError, AttributeError) as error:
            if isinstance(error, ValueError | TypeError) and any(re.search(rf"\b{k}\b", str(error)) for k in given):
                raise
            said = ", ".join(f"{name} {_shape_of(value)}" for name, value in given.items())
            raise ValueError(f"{said}: do not fit ({error})") from error

    return checked


def _check_by_hint(name: str, hint: str, value: Any) -> None:
    if "None" in hint and value is None:
        return
    hint, given = hint.removesuffix(" | None"), cast(Any, value)
    if hint in ("ArrayLike", "Array"):
        numbers(name, given)
    elif hint == "float":
        real(name, given)
    elif hint == "int" and not (isinstance(given, int | np.integer) and abs(int(given)) < 2**31):
        raise TypeError(f"{name}: expected a whole number below 2³¹, got {_short(given)}")
    elif hint.startswith("Literal["):
        one_of(name, given, ast.literal_eval(f"({hint[8:-1]},)"))
    elif hint.startswith(("Sequence[", "Iterable[")) and (isinstance(given, str | bytes) or not np.iterable(given)):
        raise TypeError(f"{name}: expected several, got {_short(given)}")


def _shape_of(value: object) -> str:
    try:
        return str(np.shape(value)) if isinstance(value, np.ndarray | list | tuple) else _short(value)  # type: ignore[arg-type]
    except ValueError:  # rows of different lengths
        return _short(value)
