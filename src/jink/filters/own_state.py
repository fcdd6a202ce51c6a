"""The state of a whole filter of your own: a dict of arrays whose first axis is the target, checked."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..checks import Array

State = dict[str, Any]


def checked_state(function: str, state: Any, targets: int, components: tuple[str, ...] = ()) -> State:
    """The state that a function gave. Errors: ValueError naming the function, the entry, and what was expected."""
    if not isinstance(state, Mapping) or "x" not in state:
        got = ", ".join(map(str, state)) if isinstance(state, Mapping) else type(state).__name__
        raise ValueError(f'{function}: expected a dict of arrays with "x" (B, n), and "P" (B, n, n); got {got}')
    arrays = {str(name): np.asarray(value) for name, value in state.items()}
    size = len(components) or (arrays["x"].shape[1] if arrays["x"].ndim == 2 else 0)
    shapes: dict[str, tuple[int, ...]] = {"x": (targets, size), "P": (targets, size, size)}
    shapes |= {"nis": (targets,), "log_likelihood": (targets,)}
    for name, value in arrays.items():
        expected = shapes.get(name, (targets, *value.shape[1:]))
        if value.shape != expected:
            raise ValueError(f"{function}: {name} has shape {value.shape} for {targets} targets; expected {expected}")
    for name in ("x", "P"):
        if name in arrays and not np.isfinite(arrays[name]).all():
            raise ValueError(f"{function}: {name} has NaN or infinite values")
    return arrays


def part_of(state: State, which: Any) -> State:
    """Copies of the entries of some targets."""
    return {name: value[which].copy() for name, value in state.items()}


def merged(whole: State, part: State, which: Any, targets: int) -> State:
    """The whole state with some targets replaced. Errors: ValueError where entries come and go."""
    if not whole:
        whole = {name: np.zeros((targets, *value.shape[1:]), dtype=value.dtype) for name, value in part.items()}
    if missing := whole.keys() ^ part.keys():
        raise ValueError(f"step: {sorted(missing)[0]} is in one state but not in the next; expected the same entries")
    for name, value in part.items():
        if value.dtype != whole[name].dtype:
            whole[name] = whole[name].astype(np.result_type(whole[name], value))
        whole[name][which] = value
    return whole


def probed(steps: Any, sensor: Any) -> State:
    """The state of three made-up targets after their first measurement."""
    places = 1000.0 * (1.0 + np.arange(9.0).reshape(3, 3))
    z: Array = sensor.observe(SimpleNamespace(position=places, velocity=np.ones((3, 3))))
    R = np.broadcast_to(sensor.noise, (3, z.shape[1], z.shape[1]))
    state = steps.begin(z.copy(), R.copy())
    return checked_state("begin", state, 3, tuple(getattr(steps, "components", ())))


def names_of(steps: Any, count: int, axes: int) -> tuple[str, ...]:
    """The components' names: its own, or px vx (ax) py … by their number. Errors: ValueError for another number."""
    if given := tuple(getattr(steps, "components", ())):
        return given
    kinds = {axes: "p", 2 * axes: "pv", 3 * axes: "pva"}.get(count, "")
    if not kinds:
        raise ValueError(
            f"components: x has {count} columns where the sensor has {axes} axes; expected {axes}, {2 * axes} or "
            f"{3 * axes} columns, or the names of the components"
        )
    return tuple(f"{kind}{axis}" for axis in "xyz"[:axes] for kind in kinds)
