"""States of different modes in common, named components."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from .functions import Array
from .modes import Mode

KINEMATIC = (*(f"{c}{axis}" for axis in "xyz" for c in "pva"), "turn_rate")


def union(modes: Sequence[Mode]) -> tuple[str, ...]:
    """The components reported: px vx (ax) py ..., the turn rate, then those of the user's own names.

    Where all modes have the same components they are left as they are.
    """
    if len({mode.components for mode in modes}) == 1:
        return modes[0].components
    names = dict.fromkeys(chain.from_iterable(mode.components for mode in modes))
    return (*(c for c in KINEMATIC if c in names), *(c for c in names if c not in KINEMATIC))


class Seen:
    """A mode's state in given components: those it has, and what its kinematics say of those it lacks.

    In a turn the acceleration is ω × v; with an acceleration the turn rate is (v × a)/|v|²; a constant
    velocity has neither. ``unknown``: the places of components it says nothing of.
    """

    def __init__(self, mode: Mode, names: Sequence[str]) -> None:
        self.own = {name: k for k, name in enumerate(mode.components)}
        self.names = tuple(names)
        self.same = self.names == mode.components
        self.known_turn = mode.known_turn
        self.at = np.array([self.own.get(name, -1) for name in names])
        self.unknown = [k for k, name in enumerate(names) if name not in self.own and not self._derived(name)]

    def _has(self, *names: str) -> bool:
        return all(name in self.own for name in names)

    def _derived(self, name: str) -> bool:
        return self._has("vx") and (name == "turn_rate" or (name[0] == "a" and self._has(f"v{name[1:]}")))

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """X (B, k) and dX/dx (B, k, n); zero where unknown."""
        tracks, n = x.shape
        X, J = np.zeros((tracks, len(self.names))), np.zeros((tracks, len(self.names), n))
        has = np.flatnonzero(self.at >= 0)
        X[:, has] = x[:, self.at[has]]
        J[:, has, self.at[has]] = 1.0
        index = {name: k for k, name in enumerate(self.names)}
        if not self._has("ax") and not self._has("ay") and self._has("vx", "vy"):
            self._acceleration(x, X, J, index)
        if "turn_rate" in index and "turn_rate" not in self.own:
            self._turn_rate(x, X, J, index["turn_rate"])
        return X, J

    def _acceleration(self, x: Array, X: Array, J: Array, index: dict[str, int]) -> None:
        rate = self.own.get("turn_rate")
        if rate is None and self.known_turn is None:
            return
        w = x[:, rate] if rate is not None else np.full(len(x), self.known_turn)
        for name, other, sign in (("ax", self.own["vy"], -1.0), ("ay", self.own["vx"], 1.0)):
            if name in index:
                X[:, index[name]] = sign * w * x[:, other]
                J[:, index[name], other] = sign * w
                if rate is not None:
                    J[:, index[name], rate] = sign * x[:, other]

    def _turn_rate(self, x: Array, X: Array, J: Array, at: int) -> None:
        if self.known_turn is not None:
            X[:, at] = self.known_turn
        if not self._has("vx", "ax", "vy", "ay"):
            return
        places = [self.own[name] for name in ("vx", "ax", "vy", "ay")]
        vx, ax, vy, ay = (x[:, k] for k in places)
        over = 1.0 / np.maximum(vx * vx + vy * vy, 1e-6)
        w = (vx * ay - vy * ax) * over
        X[:, at] = w
        for place, slope in zip(places, (ay - 2 * w * vx, -vy, -(ax + 2 * w * vy), vx), strict=True):
            J[:, at, place] = slope * over
