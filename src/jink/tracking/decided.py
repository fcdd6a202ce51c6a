"""Figures of noise that other rows of the same table have decided, such as the sample of a large one."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..frozen import frozen
from .lasting import FIGURES


class Level(Protocol):
    """The noise of other rows (`noise_level.NoiseLevel`)."""

    def figure(self, source: str, name: str) -> float: ...


@frozen
class Decided:
    """What other rows of the same table say of some groups of rows.

    names of the sources; of_source (G,) the source of each group; by_target: each target is a group of its own.
    """

    level: Level
    names: list[str]
    of_source: np.ndarray
    by_target: bool

    def settles(self, *names: str) -> bool:
        """Whether the figures of these names are known, so that what the groups show would change nothing."""
        return not self.by_target and all(_counts(name, self._of_groups(name)).all() for name in names)

    def figures(self, name: str, found: np.ndarray) -> np.ndarray:
        """A source's figure is the known one; a target's is its own, where it has one."""
        known = self._of_groups(name)
        first, second = (found, known) if self.by_target else (known, found)
        return np.where(_counts(name, first), first, second)

    def lasts(self) -> bool:
        """Whether errors of any of the sources last."""
        return bool(np.isfinite(self._lasting()).any())

    def lasting(self, found: np.ndarray) -> np.ndarray:
        """Errors that last (2, G): only where those of the other rows do."""
        known = self._lasting()
        return np.where(np.isfinite(known) & np.isfinite(found), found, known)

    def _lasting(self) -> np.ndarray:
        return np.array([[self.level.figure(source, name) for source in self.names] for name in FIGURES])[
            :, self.of_source
        ]

    def _of_groups(self, name: str) -> np.ndarray:
        return np.array([self.level.figure(source, name) for source in self.names])[self.of_source]


def _counts(name: str, figure: np.ndarray) -> np.ndarray:
    """Figures that say something; only stamps of time may have no error."""
    return np.isfinite(figure) & ((figure > 0) | (name == "time_sd"))
