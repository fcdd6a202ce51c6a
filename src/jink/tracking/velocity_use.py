"""Whether reported velocities are used: held-out positions decide.

Reported velocities are late, held over, rounded, or in another unit than they seem. So their noise is what they differ
by from the smoothed positions, and a rate is used if the positions, each predicted from what came before it, become
likelier by more than two standard errors. Horizontal and vertical rates are judged apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..filters.row_noise import RowNoise
from ..frozen import frozen
from ..io.errors import InputError
from ..io.stages import stage
from .held_out import WORTH, Choose, Used, gain, measured_places, position_scores, sample_of
from .noise_level import NoiseLevel
from .placing import Placed
from .reported import RATES, Rates, joined, rates_of
from .scatter import MEDIAN

SAMPLE = 6_000  # rows that decide
ENOUGH = 50  # rows of a sample below which nothing can be decided
LEAST = 1e-3  # m/s
SCALES = (1.0, 2.0, 4.0)  # of the estimated sds
FEW_REPEATS = 0.95  # share of reports that differ from the one before: with more, repeats are not looked at
UNITS = {"velocity": "speed_kt", "vertical_rate": "vertical_rate_fpm"}
ANOTHER_UNIT = (0.7, 1.4)  # reported over found speed: beyond, the report is in another unit, or is another quantity


@stage("noise")
def decided(
    placed: Placed, level: NoiseLevel, given: Mapping[str, float], choose: Choose
) -> tuple[Placed, NoiseLevel, Used]:
    """Measurements with the rates that help, their noise with it; the same as came in where none does."""
    rates = rates_of(placed, level)
    if rates is None:
        return placed, level, Used()
    some, rows = sample_of(placed, SAMPLE)
    reports, noise = rates.some(rows), level.covariance.some(rows)
    plain = choose(placed.components, level.typical)
    if getattr(plain, "counts_rows", False) or not hasattr(plain, "smooth"):
        return placed, level, Used(notes=["reported velocities are not used: this filter counts rows"])
    covariance = noise[:]
    places = measured_places(some, covariance)
    before = position_scores(plain, some, covariance, places)
    sds, notes = _sds(plain, some, reports, covariance, given)
    if not sds:
        return placed, level, Used(notes=notes)
    try:
        best = _search(some, noise, reports, sds, given, level, choose, before, places)
    except InputError as error:
        return placed, level, Used(notes=[f"reported velocities are not used: {error}"])
    return _decided(placed, level, rates, best, given, notes)


@frozen
class Tried:
    """One way to use a rate: its sd (m/s), without repeated reports or with them, and what it gains in a row."""

    sd: float
    fresh_only: bool
    gain: float = 0.0
    error: float = np.inf

    @property
    def sure(self) -> float:
        """The gain less two standard errors."""
        return self.gain - 2.0 * self.error


def _search(
    placed: Placed,
    noise: RowNoise,
    rates: Rates,
    sds: Mapping[str, float],
    given: Mapping[str, float],
    level: NoiseLevel,
    choose: Choose,
    before: np.ndarray,
    places: tuple[np.ndarray, np.ndarray],
) -> dict[str, Tried]:
    """The best way to use each rate. Errors of reports last over many rows: some multiple of their sd does best."""
    best = {name: Tried(sd, True) for name, sd in sds.items()}
    part = np.cumsum(placed.new)
    repeats = bool(np.mean(rates.fresh) < FEW_REPEATS)
    scales = [scale for scale in SCALES if scale == 1.0 or not set(sds) <= set(given)]
    stated = rates.stated
    ways = [{name: sd * (1.0 if name in given else scale) for name, sd in sds.items()} for scale in scales]
    if set(stated) & set(sds) - set(given):
        ways.append({name: sd if name in given else stated.get(name, sd) for name, sd in sds.items()})
    for tried_sd, fresh_only in [*((way, True) for way in ways), *([(None, False)] if repeats else [])]:
        # the last round: at the sds found, with the repeated reports
        tried_sd = {name: each.sd for name, each in best.items()} if tried_sd is None else tried_sd
        tried, both = joined(placed, noise, rates, tried_sd, sds if fresh_only else (), stated)
        after = position_scores(choose(tried.components, level.typical | tried_sd), tried, both[:], places)
        for column, name in enumerate(("velocity", "vertical_rate")):
            if name in sds:
                found = Tried(tried_sd[name], fresh_only, *gain(before[:, column], after[:, column], part))
                best[name] = max(best[name], found, key=lambda each: each.sure)
    return best


def _decided(
    placed: Placed,
    level: NoiseLevel,
    rates: Rates,
    best: Mapping[str, Tried],
    given: Mapping[str, float],
    notes: list[str],
) -> tuple[Placed, NoiseLevel, Used]:
    """With the rates that help; what was decided, in words."""
    used = Used(notes=notes, stated=rates.stated)
    for name, way in best.items():
        what = "the reported " + name.replace("_", " ")
        if not (way.sure > 0.0 and way.gain > WORTH):
            used.notes.append(f"{what} is not used: held-out positions are no likelier with it")
            continue
        used.sd[name], used.gains[name] = way.sd, way.gain
        used.origin[name] = "given" if name in given else _origin(way.sd, used.stated.get(name))
        used.fresh_only |= {name} if way.fresh_only else set()
        only = "; repeated reports are left out" if way.fresh_only and not rates.fresh.all() else ""
        used.notes.append(
            f"{what} is used: held-out positions are likelier by {way.gain:.2g} ± {way.error:.1g} a row{only}; "
            "--no-velocity leaves it out"
        )
    return *as_decided(placed, level, used, rates), used


def as_decided(placed: Placed, level: NoiseLevel, used: Used, rates: Rates | None = None) -> tuple[Placed, NoiseLevel]:
    """Measurements with the rates that are used, and their noise with it; rates: of the rows, if they are known."""
    if not used.sd:
        return placed, level
    rates = rates or rates_of(placed, level) or Rates.none(placed)
    used.usual = rates.usual if used.usual is None else used.usual
    rates = replace(rates, usual=used.usual)
    both, covariance = joined(placed, level.covariance, rates, used.sd, used.fresh_only, used.stated)
    sources = [line | used.figures() for line in level.sources]
    return both, replace(level, covariance=covariance, typical=level.typical | used.sd, sources=sources, velocity=None)


def _sds(
    filter: Any, placed: Placed, rates: Rates, covariance: np.ndarray, given: Mapping[str, float]
) -> tuple[dict[str, float], list[str]]:
    """Sds of the horizontal and of the vertical rate: given, or what they differ by from smoothed positions; and
    sentences on those that are something else. The smoothed velocity's own error is taken off.
    """
    verb = filter.filter if getattr(filter, "not_smoothed", "") else filter.smooth
    found = verb(placed.time, placed.z, offsets=placed.offsets, covariance=covariance, outputs=("x", "P"))
    index = [found.components.index(f"v{axis}") for axis in "xyz"[: placed.axes]]
    x, own = found.x[:, index], np.sqrt(np.diagonal(found.P, axis1=1, axis2=2)[:, index])
    said, way = rates.velocity[:, : placed.axes], rates.way
    fresh = np.where(rates.fresh[:, None], said, np.nan)
    # a rate that hardly ever changes is told by its repeats as well
    said = np.where(np.isfinite(fresh).sum(axis=0) < ENOUGH, said, fresh)
    flat = said[:, :2] - x[:, :2] if way is None else ((said[:, :2] - x[:, :2]) * way).sum(axis=1, keepdims=True)
    sds: dict[str, float] = {}
    notes: list[str] = []
    for name, error, columns in (
        ("velocity", flat, RATES["velocity"]),
        ("vertical_rate", said[:, 2:] - x[:, 2:], RATES["vertical_rate"]),
    ):
        known = np.isfinite(error).all(axis=1) if error.size else np.zeros(0, bool)
        if known.sum() < ENOUGH:
            if name in rates.stated:
                sds[name] = given.get(name, rates.stated[name])
            elif known.any():
                notes.append(f"the reported {name.replace('_', ' ')} is not used: {known.sum()} rows tell too little")
            continue
        scatter, doubt = MEDIAN * float(np.median(np.abs(error[known]))), float(np.median(own[known, columns]))
        there, here = (np.linalg.norm(each[known, columns], axis=1) for each in (said, x))
        ratio = _ratio(there, here, doubt)
        if not ANOTHER_UNIT[0] < ratio < ANOTHER_UNIT[1]:
            notes.append(
                f"the reported {name.replace('_', ' ')} is not used: it is {ratio:.2g} times what the positions show; "
                f"--columns {UNITS[name]}=NAME sets its unit"
            )
            continue
        sds[name] = given.get(name, max(np.sqrt(max(scatter**2 - doubt**2, 0.0)), 0.3 * scatter, LEAST))
    return sds, notes


def _origin(sd: float, stated: float | None) -> str:
    return "as the source states" if sd == stated else "estimated"


def _ratio(said: np.ndarray, found: np.ndarray, doubt: float) -> float:
    """The median of reported over found speeds, of rows that clearly move; 1 where there are few."""
    moving = found > 5.0 * doubt
    return float(np.median(said[moving] / found[moving])) if moving.sum() >= ENOUGH else 1.0


def as_measured(placed: Placed, level: NoiseLevel) -> tuple[Placed, NoiseLevel]:
    """With all velocities, for a filter whose sensor says their noise."""
    rates = rates_of(placed, level)
    if rates is None:
        return placed, level
    if rates.way is not None:
        # a sensor of its own noise cannot say that it measures along the way alone
        rates.velocity[:, :2] = np.nan
    both, covariance = joined(placed, level.covariance, rates, {}, names=RATES)
    return both, replace(level, covariance=covariance)
