"""Slant ranges of targets whose heights nobody reports: a height per target, unknown, with a prior of its kind.

A radar sees a target at height h and ground range g at r² = h² + 4 R (R + h) sin²(g / 2R), R the radius of the earth.
Plots tell h hardly at all, so g is taken as its mean over the prior of h, and what is not known of it is an error along
the line of sight that lasts.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import polars as pl

from ..catalogue.choose import EARTH_RADIUS
from ..catalogue.targets import kind_of
from ..frozen import frozen
from ..io.errors import InputError
from ..io.geodesy import DevelopedFrame
from ..models.observed import to_positions
from .placing import Placed

GROUND = "ground"
VARIANCE = "ground_range_variance"  # column (m²) of rows whose height is not known
BEARING = "line_of_sight_bearing"  # column (rad, clockwise from north) of rows that a radar elsewhere has seen
STEEPEST = 0.95  # of the range, at most the height
EXPECTED = "expected METRES,SD above the radar, such as 3000,2500, or ground"


@frozen
class TargetHeight:
    """Mean and standard deviation of targets' heights above the radar (m); both 0: ranges are along the ground."""

    mean: float
    sd: float

    @classmethod
    def of(cls, given: str | None) -> TargetHeight | None:
        """From ``"3000,2500"`` or ``"ground"``. Errors: InputError."""
        if given is None:
            return None
        if not isinstance(given, str):
            raise InputError(f"target_height is {given!r}; {EXPECTED}")
        if given.strip() == GROUND:
            return cls(0.0, 0.0)
        try:
            mean, sd = (float(part) for part in given.split(","))
        except ValueError:
            raise InputError(f"target_height is {given!r}; {EXPECTED}") from None
        if not (np.isfinite([mean, sd]).all() and mean >= 0 and sd >= 0):
            raise InputError(f"target_height is {given!r}; {EXPECTED}")
        return cls(mean, sd)

    @property
    def is_ground(self) -> bool:
        """Are there no heights?"""
        return self.mean == 0.0 and self.sd == 0.0

    def ground_range(self, slant: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and variance (N,) of the range along the ground of slant ranges (N,), over the prior."""
        nodes, weights = np.polynomial.hermite_e.hermegauss(15)
        ground = along_the_ground(slant[:, None], np.clip(self.mean + self.sd * nodes, 0.0, None))
        weights = weights / weights.sum()
        mean = ground @ weights
        return mean, np.maximum(ground**2 @ weights - mean**2, 0.0)


def along_the_ground(slant: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Ranges along the ground of slant ranges to targets so high above the radar (m)."""
    height = np.minimum(height, STEEPEST * slant)
    chord = (slant**2 - height**2) / (4.0 * EARTH_RADIUS * (EARTH_RADIUS + height))
    return 2.0 * EARTH_RADIUS * np.arcsin(np.sqrt(np.minimum(chord, 1.0)))


def is_slant(name: str) -> bool:
    """Whether the name of a column says that its ranges are slant ranges."""
    return bool(re.search(r"slant|(^|_)rho(_|$)", name.lower()))


def height_of(given: TargetHeight | None, kind: str, name: str, others_have: bool) -> tuple[TargetHeight, str]:
    """The heights of targets that have none in a table, and what is to be said of them.

    name: of the column of ranges; others_have: other targets of the table have heights.
    """
    usual = TargetHeight(*kind_of(kind).height)
    mend = "--columns altitude=NAME gives heights, --target-height METRES,SD what is known of them"
    if given is None and usual.is_ground:
        return usual, ""
    if given is not None or is_slant(name) or others_have:
        found = given or usual
        if found.is_ground:
            return found, ""
        return found, (
            f"slant ranges without heights: targets are taken to be {found.mean:.6g} ± {found.sd:.6g} m above the "
            f"radar, and positions are as uncertain along the line of sight as that makes them; {mend}"
        )
    near, far = (float(r - usual.ground_range(np.array([r]))[0][0]) for r in (20e3, 100e3))
    return TargetHeight(0.0, 0.0), (
        f"ranges without heights are taken as ranges along the ground; if they are slant ranges of {kind}, positions "
        f"lie about {near:.0f} m too far out at 20 km and {far:.0f} m at 100 km; {mend}, "
        "--target-height ground keeps this"
    )


def on_the_ground(placed: Placed, height: TargetHeight, above: np.ndarray | None = None) -> Placed:
    """Ranges along the ground, and of each row the variance of what the unknown height leaves.

    above (N,): heights above the radar of the rows that have one, NaN of the others.
    """
    slant = placed.z[:, 0]
    mean, variance = (slant, np.zeros(slant.size)) if height.is_ground else height.ground_range(slant)
    if above is not None:
        known = np.isfinite(above)
        mean, variance = np.where(known, along_the_ground(slant, above), mean), np.where(known, 0.0, variance)
    z = placed.z.copy()
    z[:, 0] = mean
    plane = to_positions(z[:, :2], ("range", "azimuth"), (0.0, 0.0, 0.0), "north")
    return replace(placed, z=z, plane=plane, rows=placed.rows.with_columns(pl.Series(VARIANCE, variance)))


def along_the_line(placed: Placed, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The variance of unknown heights in covariances xx, yy and xy (N,) of positions x, y seen from the origin, or
    along the bearings of the rows.

    A row that measured nothing has the last variance, and bearing, of the rows before it.
    """

    def column(name: str) -> np.ndarray:
        return np.asarray(placed.rows[name].fill_nan(None).forward_fill().fill_null(0.0).to_numpy())

    variance = column(VARIANCE)
    if BEARING in placed.rows.columns:
        turned = placed.frame.anchor_convergence if isinstance(placed.frame, DevelopedFrame) else 0.0
        east, north = np.sin(column(BEARING) - turned), np.cos(column(BEARING) - turned)
    else:
        far = np.maximum(np.hypot(x, y), 1.0)
        east, north = x / far, y / far
    return variance * east * east, variance * north * north, variance * east * north
