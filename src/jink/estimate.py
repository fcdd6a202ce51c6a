"""What a filter returns."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Status(IntEnum):
    """What became of a row; the engine has the same numbers under the same names."""

    none = 0  # the track has not started
    updated = 1
    predicted = 2  # nothing was measured
    gated = 3  # what was measured was not believed
    restarted = 4
    initialised = 5


STATUS = tuple(Status.__members__)  # the names, in the order of their numbers


@dataclass(repr=False)
class Estimate:
    """Estimates row by row, for the outputs that were asked for; the others raise AttributeError when looked at.

    x (N, n) and P (N, n, n): mean and covariance in ``components``; mode_probability (N, M) of ``modes``;
    log_likelihood (B,) per track and log_likelihood_scan (N,) per row; nis (N,) of the moment-matched innovation with
    nis_dof components (for several modes not exactly χ²: pit (N, m), the probability integral transform of each
    measured component given those before it, is uniform for a consistent filter); status (N,) of :class:`Status`. NaN
    before a track starts. non_manoeuvring: of each mode whether a target in it does not manoeuvre
    (:mod:`jink.models.non_manoeuvring`).
    """

    components: tuple[str, ...]
    modes: tuple[str, ...]
    results: dict[str, NDArray[Any]]
    non_manoeuvring: tuple[bool, ...] = ()

    @property
    def manoeuvring(self) -> NDArray[np.float64]:
        """Probability (N,) of the modes in which a target manoeuvres; NaN for a filter whose modes do not tell
        manoeuvres apart.
        """
        mu = self.mode_probability
        if not any(self.non_manoeuvring):
            return np.full(mu.shape[:-1], np.nan)
        return np.clip(1.0 - mu[..., np.array(self.non_manoeuvring)].sum(axis=-1), 0.0, 1.0)

    @property
    def scored(self) -> NDArray[np.bool_]:
        """Rows (N,) whose measurement met a prediction, believed or not: those that have a likelihood and a NIS to
        compare.
        """
        return np.isin(self.status, (Status.updated, Status.gated))

    def __getattr__(self, name: str) -> NDArray[Any]:
        results = self.__dict__.get("results", {})
        if name in results:
            return results[name]
        raise AttributeError(f"{name}: not among the outputs asked for, {', '.join(results)}")

    def __getitem__(self, component: str) -> NDArray[np.float64]:
        """One component's estimate, by name."""
        return self.x[..., self._index(component)]

    def sd(self, component: str) -> NDArray[np.float64]:
        """One component's standard deviation, by name."""
        k = self._index(component)
        return np.sqrt(self.P[..., k, k])

    def _index(self, component: str) -> int:
        if component not in self.components:
            raise KeyError(f"{component!r}: expected one of {', '.join(self.components)}")
        return self.components.index(component)

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in self.results.items())
        return f"Estimate({shapes}; components {' '.join(self.components)}; modes {' '.join(self.modes)})"
