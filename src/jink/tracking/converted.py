"""A radar's plots as positions in metres, for filters that measure positions alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..catalogue.choose import purpose_of
from ..filters.row_noise import RowNoise
from .held_out import measured_places
from .noise_level import NoiseLevel
from .placing import Placed


def as_positions(placed: Placed, level: NoiseLevel) -> tuple[Placed, NoiseLevel]:
    """Range, azimuth and perhaps elevation or altitude to x, y and z; covariances to the first order, by row."""
    axes = placed.axes
    position, covariance = measured_places(placed, level.covariance[:])
    good = np.isfinite(covariance).all(axis=(1, 2))
    covariance[~good] = np.eye(axes)
    across = np.sqrt(0.5 * (covariance[good, 0, 0] + covariance[good, 1, 1]))
    typical = {"position": float(np.median(across)) if good.any() else 1.0}
    if axes == 3:
        typical["altitude"] = float(np.median(np.sqrt(covariance[good, 2, 2]))) if good.any() else 1.0
    converted = replace(placed, z=np.ascontiguousarray(position), components=("x", "y", "z")[:axes])
    return converted, NoiseLevel(RowNoise.of_covariances(covariance), typical, level.sources)


def in_metres(group: Any, kind: str) -> Any:
    """A group of a radar's plots as one of positions; others stay as they are."""
    if group.placed.components[0] != "range":
        return group
    placed, level = as_positions(group.placed, group.level)
    purpose = group.purpose
    made = purpose_of(placed.components, level.typical, kind, purpose.gap or 0.0, purpose.interval)
    return replace(group, placed=placed, level=level, covariance=level.covariance, purpose=made)
