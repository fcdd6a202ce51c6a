"""A radar's range rate: used where it makes held-out positions likelier."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..io.errors import InputError
from ..io.stages import stage
from .held_out import WORTH, Choose, Used, gain, measured_places, position_scores, sample_of
from .noise_level import NoiseLevel
from .placing import Placed
from .scatter import component_sd

SAMPLE = 20_000  # rows that decide: a range rate every 50 ms tells little more than the positions do
ENOUGH = 50  # range rates below which nothing can be decided
LEAST = 1e-3  # m/s
CAUTIOUS, UNKNOWN_SPEED = 3.0, 1e4  # sds of an unknown velocity that are allowed for, and the largest (m/s)


@stage("noise")
def decided(
    placed: Placed, level: NoiseLevel, given: Mapping[str, float], choose: Choose
) -> tuple[Placed, NoiseLevel, Used]:
    """A radar's measurements with its range rate, if that helps."""
    if "range_rate" not in placed.rows.columns:
        return placed, level, Used()
    rate = _range_rate(placed)
    sd = given.get("range_rate") or _scatter(placed, rate)
    if sd is None:
        return placed, level, Used(notes=["the range rate is not used: its noise could not be estimated"])
    joined, full = _appended(placed, level, rate, sd)
    some, rows = sample_of(placed, SAMPLE)
    both = replace(some, z=joined.z[rows], components=joined.components)
    try:
        plain = choose(placed.components, level.typical)
        filter = choose(joined.components, full.typical)
    except InputError as error:
        return placed, level, Used(notes=[f"the range rate is not used: {error}"])
    if getattr(plain, "counts_rows", False):
        return placed, level, Used(notes=["the range rate is not used: this filter counts rows"])
    places = measured_places(some, level.covariance[rows])
    before = position_scores(plain, some, level.covariance[rows], places)[:, : placed.axes - 1].sum(axis=1)
    after = position_scores(filter, both, full.covariance[rows], places)[:, : placed.axes - 1].sum(axis=1)
    mean, error = gain(before, after, np.cumsum(some.new))
    if not mean > max(2.0 * error, WORTH):
        return placed, level, Used(notes=["the range rate is not used: held-out positions are no likelier with it"])
    used = Used({"range_rate": sd}, {"range_rate": "given" if "range_rate" in given else "estimated"})
    used.gains["range_rate"] = mean
    used.notes.append(
        f"the range rate is used: held-out positions are likelier by {mean:.2g} ± {error:.1g} a row; "
        "--no-velocity leaves it out"
    )
    return joined, replace(full, sources=[line | used.figures() for line in level.sources]), used


def as_decided(placed: Placed, level: NoiseLevel, used: Used) -> tuple[Placed, NoiseLevel]:
    """Measurements with the range rate, where it is used."""
    if "range_rate" not in used.sd:
        return placed, level
    return _appended(placed, level, _range_rate(placed), used.sd["range_rate"])


def _range_rate(placed: Placed) -> np.ndarray:
    """Of rows with a position."""
    if "range_rate" not in placed.rows.columns:
        return np.full(placed.rows.height, np.nan)
    return np.where(placed.measured, placed.rows["range_rate"].to_numpy(), np.nan)


def _scatter(placed: Placed, rate: np.ndarray) -> float | None:
    """The sd (m/s) of a range rate, from itself; None where there is too little of it."""
    known = np.isfinite(rate)
    if known.sum() < ENOUGH:
        return None
    group = np.zeros(int(known.sum()), int)
    sd = float(component_sd(placed.time[known], rate[known], placed.starts(known), group, 1)[0])
    return max(sd, LEAST) if np.isfinite(sd) else None


def _appended(placed: Placed, level: NoiseLevel, rate: np.ndarray, sd: float) -> tuple[Placed, NoiseLevel]:
    """A radar's measurements with their range rate."""
    joined = replace(placed, z=np.column_stack([placed.z, rate]), components=(*placed.components, "range_rate"))
    angles = [column for column, name in enumerate(placed.components) if name in ("azimuth", "elevation")]
    angle = np.sqrt(sum((level.covariance.variance(column) for column in angles), np.zeros(len(rate))))
    variance = rate_variance(placed.z[:, 0], placed.time, placed.offsets, angle, sd, level.step or 1.0)
    return joined, replace(
        level, covariance=level.covariance.beside([variance]), typical=level.typical | {"range_rate": sd}
    )


def rate_variance(
    distance: np.ndarray, time: np.ndarray, offsets: np.ndarray, angle: np.ndarray, sd: float, step: float
) -> np.ndarray:
    """Variance (m²/s²) of each row's range rate, for a filter that linearises; angle (rad): sd of the line of sight.

    A range rate tells the velocity along the line of sight, whose direction is known to the angle's sd. While the
    velocity across it is not known, that makes an error of sd times velocity, which no linearisation shows: it is
    added to the variance. After n rows in t seconds the velocity's sd is about √(12/n) · range · angle's sd / t.
    """
    count = np.arange(len(time)) - np.repeat(offsets[:-1], np.diff(offsets)) + 1.0
    unknown = np.sqrt(12.0 / count) * np.nan_to_num(distance) * angle / np.maximum(time, max(step, 1e-3))
    return sd**2 + (CAUTIOUS * angle * np.minimum(unknown, UNKNOWN_SPEED)) ** 2


def as_measured(placed: Placed, level: NoiseLevel) -> tuple[Placed, NoiseLevel]:
    """With the range rate, for a filter whose sensor says its noise."""
    if "range_rate" not in placed.rows.columns:
        return placed, level
    return _appended(placed, level, _range_rate(placed), 1.0)
