"""What of a filter can be fitted: its numbers as one vector, on scales where every value is allowed."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from ..checks import Array
from ..filters.loading import built
from ..models.motion import mode_names
from .places import each_part, spelled_out
from .scales import Part

# unless asked for: the noise is mostly known, the start soon forgotten, the margin only keeps a filter from freezing
USUALLY_FIXED = ("*sensor*", "start.*", "*.least_margin")
FOURTH = (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0)  # of a derivative, at -2h, -h, h, 2h
STEP = 2e-3


class Parameters:
    """The numbers of a filter that are fitted, as one vector u; the others stay as they are.

    free, fixed: patterns of names ("*.acceleration_psd"); free ones are fitted though they usually are not, fixed ones
    are not. Errors: ValueError if a pattern names nothing, or nothing is left to fit.
    """

    def __init__(self, filter: Any, *, free: Sequence[str] = (), fixed: Sequence[str] = ()) -> None:
        self.body = spelled_out(filter.described(), len(filter.motions))
        found = list(each_part(self.body, mode_names(filter.motions)))
        self.all_names = known = [name for part in found for name in part.names]
        for pattern in (*free, *fixed):
            if not self.known(pattern):
                raise ValueError(
                    f"this filter has no parameter {pattern!r}; its parameters are {', '.join(known) or 'none'}"
                )
        self.parts: list[Part] = [part for part in found if _wanted(part.names, free, fixed)]
        if not self.parts:
            raise ValueError(
                f"no parameter is left to fit; the parameters of this filter are {', '.join(known) or 'none'}"
            )
        self.start = np.array([u for part in self.parts for u in part.read(self.body)], dtype=float)

    @property
    def names(self) -> tuple[str, ...]:
        """One for each element of u."""
        return tuple(name for part in self.parts for name in part.names)

    def __len__(self) -> int:
        return len(self.start)

    def known(self, pattern: str) -> bool:
        """Does a pattern name any number of this filter, fitted or not?"""
        return any(fnmatchcase(name, pattern) for name in self.all_names)

    def described(self, u: Array) -> dict[str, Any]:
        """The description of the filter at u."""
        body = copy.deepcopy(self.body)
        done = 0
        for part in self.parts:
            part.write(body, u[done : done + part.size])
            done += part.size
        return body

    def filter(self, u: Array) -> Any:
        """The filter at u."""
        return built(self.described(u), own=True)

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
