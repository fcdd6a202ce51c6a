"""What of a filter can be fitted: its numbers, on scales where every value is allowed.

positive σ: u = ln σ;   of either sign: u = value / unit;   probability p: u = ln p/(1 − p);   rows that sum to one: uⱼ = ln pⱼ/p_ref
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from ..arguments import Array
from ..filters.files import described
from ..filters.loading import built
from ..motion import mode_names
from ..noise import transition_rule

Path = tuple[str | int, ...]

POSITIVE = ("_sd", "_psd", "sd", "time_constant", "seconds", "psd")  # endings of names
PROBABILITIES = ("share",)
PLAIN = {"turn_rate": 0.05}  # of either sign, and the unit u has
USUALLY_FIXED = (
    "*sensor*",
    "start.*",
)  # unless asked for: the noise is mostly known, the start soon forgotten
FOURTH = (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0)  # of a derivative, at -2h, -h, h, 2h
STEP = 2e-3


@dataclass(frozen=True)
class Number:
    """One number, at one place of a filter's description or at several that stay equal."""

    name: str
    paths: tuple[Path, ...]
    scale: str  # log, logit or plain
    unit: float = 1.0  # of a plain one
    size: int = 1

    @property
    def names(self) -> tuple[str, ...]:
        return (self.name,)

    def read(self, body: Any) -> list[float]:
        value = float(_at(body, self.paths[0]))
        if self.scale == "log":
            return [np.log(value)]
        return [np.log(value / (1.0 - value))] if self.scale == "logit" else [value / self.unit]

    def write(self, body: Any, u: Array) -> None:
        value = float(u[0])
        if self.scale == "log":
            value = float(np.exp(value))
        elif self.scale == "logit":
            value = float(1.0 / (1.0 + np.exp(-value)))
        else:
            value *= self.unit
        for path in self.paths:
            _at(body, path[:-1])[path[-1]] = value

    def values(self, body: Any) -> list[float]:
        return [float(_at(body, self.paths[0]))]


@dataclass(frozen=True)
class Row:
    """Probabilities that sum to one, those of `places`; the others stay zero."""

    path: Path
    places: tuple[int, ...]
    reference: int  # the place the others are compared with
    names: tuple[str, ...]

    @property
    def size(self) -> int:
        return len(self.places) - 1

    def _others(self) -> list[int]:
        return [place for place in self.places if place != self.reference]

    def read(self, body: Any) -> list[float]:
        row = _at(body, self.path)
        return [float(np.log(row[j] / row[self.reference])) for j in self._others()]

    def write(self, body: Any, u: Array) -> None:
        logits = np.r_[0.0, u]
        p = np.exp(logits - logits.max())
        row = _at(body, self.path)
        for place, value in zip([self.reference, *self._others()], p / p.sum(), strict=True):
            row[place] = float(value)

    def values(self, body: Any) -> list[float]:
        row = _at(body, self.path)
        return [float(row[j]) for j in self._others()]


class Parameters:
    """The numbers of a filter that are fitted, as one vector u; the others stay as they are.

    free, fixed: patterns of names ("*.acceleration_psd"); free ones are fitted though they usually are not, fixed ones are
    not. Errors: ValueError if a pattern names nothing, or nothing is left to fit.
    """

    def __init__(self, filter: Any, *, free: Sequence[str] = (), fixed: Sequence[str] = ()) -> None:
        self.body = spelled_out(described(filter), len(filter.motions))
        found = list(each_part(self.body, mode_names(filter.motions)))
        known = [name for part in found for name in part.names]
        for pattern in (*free, *fixed):
            if not any(fnmatchcase(name, pattern) for name in known):
                raise ValueError(
                    f"{pattern!r} names no number of this filter; they are {', '.join(known) or 'none'}"
                )
        self.parts = [part for part in found if _wanted(part.names, free, fixed)]
        if not self.parts:
            raise ValueError(f"nothing is left to fit; numbers of this filter: {', '.join(known) or 'none'}")
        self.start = np.array([u for part in self.parts for u in part.read(self.body)], dtype=float)

    @property
    def names(self) -> tuple[str, ...]:
        """One for each element of u."""
        return tuple(name for part in self.parts for name in part.names)

    def __len__(self) -> int:
        return len(self.start)

    def described(self, u: Array) -> dict[str, Any]:
        """The description of the filter at u."""
        body = copy.deepcopy(self.body)
        at = 0
        for part in self.parts:
            part.write(body, u[at : at + part.size])
            at += part.size
        return body

    def filter(self, u: Array) -> Any:
        """The filter at u."""
        return built(self.described(u))

    def values(self, u: Array) -> dict[str, float]:
        """The fitted numbers in their own units, by name."""
        body = self.described(u)
        values = [value for part in self.parts for value in part.values(body)]
        return dict(zip(self.names, values, strict=True))

    def tangents(self, u: Array) -> Array:
        """d numbers / d u (P, numbers) of the engine's numbers, by differences of fourth order.

        The map is smooth and cheap, its error about 1e-11 relative; the filter itself is differentiated exactly.
        """
        rows = []
        for k in range(len(u)):
            row: Any = 0.0
            for weight, step in zip(FOURTH, (-2, -1, 1, 2), strict=True):
                moved = u.copy()
                moved[k] += step * STEP
                row = row + weight / STEP * self.filter(moved).numbers
            rows.append(row)
        return np.ascontiguousarray(rows)


def _wanted(names: Sequence[str], free: Sequence[str], fixed: Sequence[str]) -> bool:
    def any_of(patterns: Sequence[str]) -> bool:
        return any(fnmatchcase(name, pattern) for name in names for pattern in patterns)

    return any_of(free) or not any_of([*USUALLY_FIXED, *fixed])


def spelled_out(body: dict[str, Any], modes: int) -> dict[str, Any]:
    """The description with every transition probability in it: a stay probability becomes a matrix."""
    transition = body.get("transition")
    if modes < 2 or transition is None:
        return body
    if isinstance(transition, dict):
        if "to" not in transition and modes > 2:
            transition["to"] = ((np.ones((modes, modes)) - np.eye(modes)) / (modes - 1)).tolist()
    else:
        _, matrix = transition_rule(transition, None, modes)
        body["transition"] = matrix.tolist()
    return body


def each_part(body: dict[str, Any], modes: Sequence[str]) -> Iterator[Number | Row]:
    """Everything of a description that can be fitted."""
    for j, motion in enumerate(body["motions"]):
        yield from _numbers(motion, ("motions", j), modes[j])
    for k, sensor in enumerate(body["sensors"]):
        yield from _numbers(
            sensor, ("sensors", k), "sensor" if len(body["sensors"]) == 1 else f"sensor_{k + 1}"
        )
    for setting, name in (("outliers", "outliers"), ("initial", "start")):
        if setting in body:
            yield from _numbers(body[setting], (setting,), name)
    if len(modes) > 1 and "transition" in body:
        yield from _switching(body["transition"], modes)
    if "mode_probability" in body and len(modes) > 1:
        yield from _row(body["mode_probability"], ("mode_probability",), 0, "start", modes)


def _numbers(part: dict[str, Any], path: Path, owner: str) -> Iterator[Number]:
    """The numbers of one object; equal ones of the first two axes are one."""
    for field, value in part.items():
        scale = _scale(field)
        if scale is None or isinstance(value, str | bool):
            continue
        name, at = f"{owner}.{field}", (*path, field)
        if isinstance(value, int | float):
            groups = [(name, (at,), value)]
        elif field in ("to", "seconds") or not all(isinstance(v, int | float) for v in value):
            continue
        else:
            groups = _axes(name, at, value)
        for label, paths, number in groups:
            if scale == "plain" or number > 0:
                yield Number(label, paths, scale, PLAIN.get(field, 1.0))


def _axes(name: str, at: Path, values: Sequence[float]) -> list[tuple[str, tuple[Path, ...], float]]:
    if len(values) >= 2 and values[0] == values[1]:
        level = [(f"{name}.horizontal", ((*at, 0), (*at, 1)), values[0])]
        return level + [(f"{name}.vertical", ((*at, 2),), v) for v in values[2:]]
    return [
        (f"{name}.{axis}", ((*at, a),), v) for a, (axis, v) in enumerate(zip("xyz", values, strict=False))
    ]


def _scale(field: str) -> str | None:
    if field in PROBABILITIES:
        return "logit"
    if field in PLAIN:
        return "plain"
    return "log" if field in POSITIVE or field.endswith(("_sd", "_psd")) else None


def _switching(transition: Any, modes: Sequence[str]) -> Iterator[Number | Row]:
    if not isinstance(transition, dict):
        for i, row in enumerate(transition):
            yield from _row(row, ("transition", i), i, f"transition.{modes[i]}", modes)
        return
    for i, name in enumerate(modes):
        yield Number(f"sojourn.{name}", (("transition", "seconds", i),), "log")
    for i, row in enumerate(transition.get("to", ())):
        others = [j for j, p in enumerate(row) if p > 0]
        if others:
            yield from _row(row, ("transition", "to", i), others[0], f"next.{modes[i]}", modes)


def _row(row: Sequence[float], path: Path, reference: int, owner: str, modes: Sequence[str]) -> Iterator[Row]:
    places = tuple(j for j, p in enumerate(row) if p > 0)
    if len(places) > 1:
        reference = reference if reference in places else places[0]
        names = tuple(f"{owner}.{modes[j]}" for j in places if j != reference)
        yield Row(path, places, reference, names)


def _at(body: Any, path: Path) -> Any:
    for step in path:
        body = body[step]
    return body
