"""The arrays that a batch writes its results into: new ones, or those of an earlier estimate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..checks import Array, items
from ..estimate import Estimate, covariance_pair
from .memory import empty

OUTPUTS = (
    "x",
    "P",
    "mode_probability",
    "log_likelihood",
    "log_likelihood_scan",
    "nis",
    "nis_dof",
    "pit",
    "status",
)
DEFAULT_OUTPUTS = tuple(name for name in OUTPUTS if name != "pit")


class Slots(NamedTuple):
    """Results by name; the same in the engine's order, None where not wanted; the status; and single covariances by
    row and column of P.
    """

    results: dict[str, NDArray[Any]]
    arrays: list[Array | None]
    status: NDArray[np.uint8] | None
    covariances: list[tuple[int, int, Array]]


def allocate(
    outputs: Sequence[str] | None,
    out: Estimate | None,
    *,
    rows: int,
    tracks: int,
    components: tuple[str, ...],
    modes: int,
    columns: int,
) -> Slots:
    """Where results go. Errors: ValueError for an unknown output, or an ``out`` without an array of the shape and type
    that is wanted.
    """
    wanted = DEFAULT_OUTPUTS if outputs is None else items("outputs", outputs, "names of outputs")
    if out is not None and not isinstance(getattr(out, "results", None), dict):
        raise TypeError(f"out: expected an estimate to write into, got {type(out).__name__}")
    pairs = {name: covariance_pair(name, components) for name in wanted if isinstance(name, str)}
    unknown = [name for name in wanted if not isinstance(name, str) or not (name in OUTPUTS or pairs[name])]
    if unknown:
        known = ", ".join(OUTPUTS)
        raise ValueError(f"outputs: {unknown[0]!r} is not one of {known}, or a covariance such as P[px,py]")
    shapes: dict[str, tuple[int, ...]] = {name: (rows,) for name in (*OUTPUTS, *pairs)}
    shapes["x"], shapes["P"] = (rows, len(components)), (rows, len(components), len(components))
    shapes["mode_probability"], shapes["pit"] = (rows, modes), (rows, columns)
    shapes["log_likelihood"] = (tracks,)
    old = out.results if out is not None else {}
    for name in wanted if out is not None else ():
        _check_old(name, old.get(name), shapes[name])
    results: dict[str, NDArray[Any]] = {
        name: old[name] if name in old else empty(shapes[name]) for name in wanted if name != "status"
    }
    status = old.get("status", np.empty(rows, dtype=np.uint8)) if "status" in wanted else None
    arrays: list[Array | None] = [results.get(name) for name in OUTPUTS[:-1]]
    if status is not None:
        results["status"] = status
    return Slots(results, arrays, status, [(*pair, results[name]) for name, pair in pairs.items() if pair])


def _check_old(name: str, array: Any, shape: tuple[int, ...]) -> None:
    """An array that the engine can write into."""
    kind = np.dtype(np.uint8 if name == "status" else np.float64)
    if not isinstance(array, np.ndarray) or array.shape != shape:
        raise ValueError(f"out: expected an estimate with {name} of shape {shape}")
    if array.dtype != kind or not array.flags.c_contiguous or not array.flags.writeable:
        how = ("" if array.flags.c_contiguous else ", strided") + ("" if array.flags.writeable else ", read-only")
        raise ValueError(f"out: expected {name} as a contiguous, writable array of {kind}, got {array.dtype}{how}")
