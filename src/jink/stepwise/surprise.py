"""How much larger a track's innovations are than its filter says: core/scan/surprise.hpp in NumPy.

t(v; ν, κS) = |S|^(−1/2) (2πκ)^(−m/2) (1 + NIS / (νκ))^(−(ν + m)/2),   ν = Σ w dof,   κ = Σ w NIS / ν
"""

from typing import NamedTuple

import numpy as np

from .functions import Array
from .states import States

FORGET, LARGEST_MEAN, FEWEST, MOST = 0.9, 4.0, 1.5, 25.0


class BestFit(NamedTuple):
    """Of the mode that fits a measurement best: NIS and det S."""

    nis: Array
    det: Array


def best_fit(nis: list[Array], det: list[Array]) -> BestFit:
    """Of the modes' NIS and det S."""
    all_nis, rows = np.stack(nis), np.arange(len(nis[0]))
    best = all_nis.argmin(axis=0)
    return BestFit(all_nis[best, rows], np.stack(det)[best, rows])


def explains(s: States, best: BestFit, dof: Array, log_target_share: float, log_outlier: Array) -> Array:
    """Where a track has not been moving as its models say, and explains the measurement better than an outlier does."""
    degrees = np.maximum(s.surprise_dof, 1e-9)
    scale = s.surprise / degrees
    tail = (degrees + dof) * np.log1p(best.nis / np.maximum(s.surprise, 1e-9))
    log_t = -0.5 * (np.log(best.det) + dof * np.log(2 * np.pi * np.maximum(scale, 1e-9)) + tail)
    return (degrees > FEWEST * dof) & (scale > LARGEST_MEAN) & (log_t + log_target_share > log_outlier)


def scale_with(s: States, best: BestFit, dof: Array) -> Array:
    """The scale of the innovations, this one included."""
    return (s.surprise + best.nis) / np.maximum(s.surprise_dof + dof, 1e-9)


def add(s: States, best: BestFit, dof: Array, accepted: Array) -> None:
    """Remember a row that was accepted."""
    nis = np.minimum(best.nis, MOST * dof)
    s.surprise = np.where(accepted, FORGET * s.surprise + nis, s.surprise)
    s.surprise_dof = np.where(accepted, FORGET * s.surprise_dof + dof, s.surprise_dof)
