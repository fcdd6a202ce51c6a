"""Scales on which every value of a number is allowed, and where in a filter's description the number stands.

positive σ: u = ln σ;   beyond one: u = ln (value − 1);   of either sign: u = value / unit;   probability p: u = ln
p/(1 − p);   rows that sum to one: uⱼ = ln pⱼ/p_ref
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from ..checks import Array
from ..frozen import frozen

Path = tuple[str | int, ...]


class Part(Protocol):
    """size elements of u, one name each, read from a description's body and written to it; values in their own
    units.
    """

    @property
    def size(self) -> int: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    def read(self, body: Any) -> list[float]: ...
    def write(self, body: Any, u: Array) -> None: ...
    def values(self, body: Any) -> list[float]: ...


@frozen
class Number:
    """One number, at one place of a filter's description or at several that stay equal."""

    name: str
    paths: tuple[Path, ...]
    scale: str  # log, beyond one, logit or plain
    unit: float = 1.0  # of a plain one
    size: int = 1

    @property
    def names(self) -> tuple[str, ...]:
        return (self.name,)

    def read(self, body: Any) -> list[float]:
        value = float(at(body, self.paths[0]))
        if self.scale == "log":
            return [math.log(value)]
        if self.scale == "beyond one":
            return [math.log(value - 1.0)]
        return [logit(value)] if self.scale == "logit" else [value / self.unit]

    def write(self, body: Any, u: Array) -> None:
        value = float(u[0])
        if self.scale == "log":
            value = math.exp(value)
        elif self.scale == "beyond one":
            value = 1.0 + math.exp(value)
        elif self.scale == "logit":
            value = logistic(value)
        else:
            value *= self.unit
        for path in self.paths:
            at(body, path[:-1])[path[-1]] = value

    def values(self, body: Any) -> list[float]:
        return [float(at(body, self.paths[0]))]


@frozen
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
        row = at(body, self.path)
        return [math.log(row[j] / row[self.reference]) for j in self._others()]

    def write(self, body: Any, u: Array) -> None:
        logits = np.r_[0.0, u]
        p = np.exp(logits - logits.max())
        row = at(body, self.path)
        for place, value in zip([self.reference, *self._others()], p / p.sum(), strict=True):
            row[place] = float(value)

    def values(self, body: Any) -> list[float]:
        row = at(body, self.path)
        return [float(row[j]) for j in self._others()]


@frozen
class Limits:
    """Fuzzy limits, kept where they are valid: a_th above a_up, k₁ and k₂ below a_th ln(a_th/a_up)/(a_th − a_up).

    u = ln(a_th/a_up − 1), and ln k/(bound − k) of each k, or ln k of a triangular membership, which has no bound. two:
    a₋th is a number of its own. Source of the bound: :class:`jink.FuzzyLimits`.
    """

    path: Path
    owner: str
    two: bool = False

    @property
    def size(self) -> int:
        return len(self._fields())

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"{self.owner}.{name}" for name in self._fields())

    def _fields(self) -> tuple[str, ...]:
        return ("threshold", "up", "down", "threshold_down") if self.two else ("threshold", "up", "down")

    def read(self, body: Any) -> list[float]:
        limits = at(body, self.path)
        u = []
        for name in self._fields():
            if name.startswith("threshold"):
                u.append(math.log(limits[name] / _operating(limits, name) - 1.0))
            elif limits.get("membership") == "triangular":
                u.append(math.log(limits[name]))
            else:
                u.append(logit(min(limits[name] / _bound(limits, name), 1.0 - 1e-9)))
        return u

    def write(self, body: Any, u: Array) -> None:
        limits = at(body, self.path)
        values = dict(zip(self._fields(), map(float, u), strict=True))
        for name in (n for n in values if n.startswith("threshold")):
            limits[name] = _operating(limits, name) * (1.0 + math.exp(values[name]))
        for name in ("up", "down"):
            if limits.get("membership") == "triangular":
                limits[name] = math.exp(values[name])
            else:
                limits[name] = _bound(limits, name) * logistic(values[name])

    def values(self, body: Any) -> list[float]:
        limits = at(body, self.path)
        return [float(limits[name]) for name in self._fields()]


@frozen
class Together:
    """Positive numbers of many modes that keep their proportions; u = ln of the first."""

    name: str
    paths: tuple[Path, ...]
    size: int = 1

    @property
    def names(self) -> tuple[str, ...]:
        return (self.name,)

    def read(self, body: Any) -> list[float]:
        return [math.log(at(body, self.paths[0]))]

    def write(self, body: Any, u: Array) -> None:
        times = math.exp(float(u[0])) / at(body, self.paths[0])
        for path in self.paths:
            at(body, path[:-1])[path[-1]] *= times

    def values(self, body: Any) -> list[float]:
        return [float(at(body, self.paths[0]))]


@frozen
class Stay:
    """The probability to stay in the first of many modes; the other rows' chances to leave keep their proportions to
    its.
    """

    name: str
    path: Path
    size: int = 1

    @property
    def names(self) -> tuple[str, ...]:
        return (self.name,)

    def read(self, body: Any) -> list[float]:
        return [logit(at(body, self.path)[0][0])]

    def write(self, body: Any, u: Array) -> None:
        matrix = np.array(at(body, self.path), dtype=float)
        leaving = 1.0 - np.diag(matrix)
        now = np.minimum(leaving * (1.0 - logistic(float(u[0]))) / leaving[0], 1.0 - 1e-9)
        matrix *= (now / leaving)[:, None]
        np.fill_diagonal(matrix, 1.0 - now)
        at(body, self.path[:-1])[self.path[-1]] = matrix.tolist()

    def values(self, body: Any) -> list[float]:
        return [float(at(body, self.path)[0][0])]


def at(body: Any, path: Path) -> Any:
    """What stands at a place of a description."""
    for step in path:
        body = body[step]
    return body


def logit(p: float) -> float:
    """ln p/(1 − p)."""
    return math.log(p / (1.0 - p))


def logistic(u: float) -> float:
    """1/(1 + exp(−u))."""
    return 1.0 / (1.0 + math.exp(-u))


def _operating(limits: dict[str, Any], threshold: str) -> float:
    own = limits.get("operating_down") if threshold == "threshold_down" else None
    return float(limits["operating"] if own is None else own)


def _bound(limits: dict[str, Any], exponent: str) -> float:
    side = "threshold_down" if exponent == "down" and limits.get("threshold_down") is not None else "threshold"
    a_th, a_up = limits[side], _operating(limits, "threshold_down" if exponent == "down" else "threshold")
    return (1.0 - 1e-12) * a_th * math.log(a_th / a_up) / (a_th - a_up)
