"""What targets and radars report of motion beside positions: put into a filter's measurement where that helps.

Reported velocities are late, held over, rounded, or in another unit than they seem. So their noise is what they differ
by from the smoothed positions, and held-out positions decide: a rate is used if the positions, each predicted from what
came before it, become likelier by more than two standard errors. Horizontal and vertical rates are judged apart.

A speed without a course measures the velocity along the way that the last positions show, and nothing across it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..io.errors import InputError
from ..io.geodesy import DevelopedFrame
from ..io.rates import FASTEST
from .held_out import gain, measured_places, position_scores
from .noise_level import NoiseLevel
from .placing import Placed
from .scatter import MEDIAN, component_sd, rough_velocity

SAMPLE = 6_000  # rows that decide
RADAR_SAMPLE = 20_000  # a range rate every 50 ms tells little more than the positions do: more rows show it
CAUTIOUS, UNKNOWN_SPEED = 3.0, 1e4  # sds of an unknown velocity that are allowed for, and the largest (m/s)
ENOUGH = 50  # rows of a sample below which nothing can be decided
FAR = 6.0  # sds from the motion that positions show: such a report is wrong
LEAST = 1e-3  # m/s
SCALES = (1.0, 2.0, 4.0)  # of the estimated sds
FEW_REPEATS = 0.95  # share of reports that differ from the one before: with more, repeats are not looked at
TURN = 0.05  # rad/s: a target may turn so while its last positions tell its way
Choose = Callable[[tuple[str, ...], Mapping[str, float]], Any]


@dataclass(frozen=True)
class Rates:
    """Velocities in the frame of the positions, rows by components vx, vy and vz (NaN: not reported).

    way (N, 2): unit vectors along which vx and vy were measured, None where both are; slack (N,): what an uncertain way
    adds along it (m/s). fresh (N,): the report differs from the one before.
    """

    velocity: np.ndarray
    way: np.ndarray | None
    slack: np.ndarray
    fresh: np.ndarray

    def some(self, rows: slice) -> Rates:
        """Rows of it."""
        way = None if self.way is None else self.way[rows]
        return Rates(self.velocity[rows], way, self.slack[rows], self.fresh[rows])


@dataclass
class Used:
    """What was found of rates: the sds of those that are used (m/s), and sentences for the summary."""

    sd: dict[str, float] = field(default_factory=dict)
    origin: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    gains: dict[str, float] = field(default_factory=dict)


def rates_of(placed: Placed) -> Rates | None:
    """The reported velocities of rows with a position; None where there are none."""
    rows, count = placed.rows, placed.rows.height
    known = np.isfinite(placed.plane).all(axis=1)

    def column(name: str) -> np.ndarray:
        return np.where(known, rows[name].to_numpy(), np.nan) if name in rows.columns else np.full(count, np.nan)

    speed, course, slack, way = column("speed"), column("course"), np.zeros(count), None
    speed = np.where(np.abs(speed) < FASTEST, speed, np.nan)
    east, north = column("velocity_x"), column("velocity_y")
    if not np.isfinite(east).any() and np.isfinite(course).any():
        east, north = speed * np.sin(course), speed * np.cos(course)
    if np.isfinite(east).any():
        turned = placed.frame.anchor_convergence if isinstance(placed.frame, DevelopedFrame) else np.zeros(count)
        cos, sin = np.cos(turned), np.sin(turned)
        east, north = east * cos - north * sin, east * sin + north * cos
    elif np.isfinite(speed).any():
        way, slack = _way(placed, speed)
        east, north = speed * way[:, 0], speed * way[:, 1]
    up = column("vertical_rate") if placed.axes == 3 else np.full(count, np.nan)
    velocity = np.column_stack([east, north, up])
    if not np.isfinite(velocity).any():
        return None
    report = np.column_stack([speed, course, column("velocity_x"), column("velocity_y"), column("vertical_rate")])
    return Rates(velocity, way, slack, _fresh(report, placed.new))


def _fresh(report: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Rows whose report is not that of the row before: receivers fill old ones in."""
    same = ((report[1:] == report[:-1]) | (np.isnan(report[1:]) & np.isnan(report[:-1]))).all(axis=1)
    return new | np.r_[True, ~same]


def _way(placed: Placed, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (N, 2) along which the last positions lead, and what their error makes of the speed (m/s)."""
    rows = np.flatnonzero(np.isfinite(placed.plane).all(axis=1))
    part = np.cumsum(placed.new)[rows]
    plane, time = placed.plane[rows], placed.time[rows]
    noise = 1.5 * _roughness(placed)
    steps = np.hypot(*np.diff(plane, axis=0).T)[np.diff(part) == 0]
    usual = float(np.median(steps)) if steps.size else 0.0
    reach = int(np.clip(np.ceil(20.0 * noise / max(usual, 1e-9)), 1, 10))
    before = np.maximum(np.arange(rows.size) - reach, 0)
    moved = plane - plane[before]
    length = np.hypot(*moved.T)
    good = (part == part[before]) & (before < np.arange(rows.size)) & (length > 10.0 * noise)
    way, slack = np.full((placed.rows.height, 2), np.nan), np.zeros(placed.rows.height)
    way[rows[good]] = moved[good] / length[good][:, None]
    angle = (noise / length[good]) ** 2 + (0.5 * TURN * (time - time[before])[good]) ** 2
    slack[rows[good]] = 0.5 * np.nan_to_num(speed[rows[good]]) * np.minimum(angle, 1.0)
    return way, slack


def _roughness(placed: Placed) -> float:
    """About how far a measured position is off (m)."""
    known = np.isfinite(placed.plane).all(axis=1)
    new = np.r_[True, np.diff(np.cumsum(placed.new)[known]) > 0] if known.any() else np.zeros(0, bool)
    group = np.zeros(int(known.sum()), int)
    sds = [component_sd(placed.time[known], placed.plane[known, axis], new, group, 1)[0] for axis in (0, 1)]
    return float(np.nanmax(sds)) if np.isfinite(sds).any() else 0.0


def with_rates(
    placed: Placed, level: NoiseLevel, given: Mapping[str, float], choose: Choose
) -> tuple[Placed, NoiseLevel, Used]:
    """Measurements with the rates that help, their noise with it; the same as came in where none does."""
    if placed.components[0] == "range":
        return _with_range_rate(placed, level, given, choose)
    rates = rates_of(placed)
    if rates is None:
        return placed, level, Used()
    sample = _sample(placed)
    some, reports = placed.some(sample), rates.some(sample)
    covariance = level.covariance[sample]
    plain = choose(placed.components, level.typical)
    if getattr(plain, "counts_rows", False) or not hasattr(plain, "smooth"):
        return placed, level, Used(notes=["reported velocities are not used: this filter counts rows"])
    places = measured_places(some, covariance)
    before = position_scores(plain, some, covariance, places)
    sds = _sds(plain, some, reports, covariance, given)
    if not sds:
        return placed, level, Used()
    try:
        best = _search(some, covariance, reports, sds, given, level, choose, before, places)
    except InputError as error:
        return placed, level, Used(notes=[f"reported velocities are not used: {error}"])
    return _decided(placed, level, rates, best, given)


@dataclass(frozen=True)
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
    covariance: np.ndarray,
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
    repeats = bool(np.mean(rates.fresh) < FEW_REPEATS)
    scales = [scale for scale in SCALES if scale == 1.0 or not set(sds) <= set(given)]
    for scale, fresh_only in [*((scale, True) for scale in scales), *([(0.0, False)] if repeats else [])]:
        # the last round: at the sds found, with the repeated reports
        tried_sd = {
            name: best[name].sd if scale == 0.0 else sd * (1.0 if name in given else scale) for name, sd in sds.items()
        }
        tried, noise = _joined(placed, covariance, rates, tried_sd, fresh_only)
        after = position_scores(choose(tried.components, level.typical | tried_sd), tried, noise, places)
        for column, name in enumerate(("velocity", "vertical_rate")):
            if name in sds:
                found = Tried(tried_sd[name], fresh_only, *gain(before[:, column], after[:, column]))
                best[name] = max(best[name], found, key=lambda each: each.sure)
    return best


def _decided(
    placed: Placed, level: NoiseLevel, rates: Rates, best: Mapping[str, Tried], given: Mapping[str, float]
) -> tuple[Placed, NoiseLevel, Used]:
    """With the rates that help; what was decided, in words."""
    used = Used()
    velocity = rates.velocity.copy()
    for name, columns in (("velocity", slice(0, 2)), ("vertical_rate", slice(2, 3))):
        if name not in best:
            velocity[:, columns] = np.nan
            continue
        way = best[name]
        what = "the reported " + name.replace("_", " ")
        if not way.sure > 0.0:
            velocity[:, columns] = np.nan
            used.notes.append(f"{what} is not used: held-out positions are no likelier with it")
            continue
        used.sd[name], used.gains[name] = way.sd, way.gain
        used.origin[name] = "given" if name in given else "estimated"
        if way.fresh_only:
            velocity[~rates.fresh, columns] = np.nan
        only = "; repeated reports are left out" if way.fresh_only and not rates.fresh.all() else ""
        used.notes.append(
            f"{what} is used: held-out positions are likelier by {way.gain:.2g} ± {way.error:.1g} a row{only}; "
            "--no-velocity leaves it out"
        )
    if not used.sd:
        return placed, level, used
    joined, covariance = _joined(placed, level.covariance, replace(rates, velocity=velocity), used.sd, False)
    sources = [line | _figures(used) for line in level.sources]
    return joined, NoiseLevel(covariance, level.typical | used.sd, sources), used


def _figures(used: Used) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for name, sd in used.sd.items():
        figures |= {f"{name}_sd": float(sd), f"{name}_sd_from": used.origin[name]}
    return figures


def _sample(placed: Placed, most: int = SAMPLE) -> slice:
    """Whole parts from the middle of the table, as many rows as decide; of a long part its first rows."""
    offsets = placed.offsets
    if offsets[-1] <= most:
        return slice(0, int(offsets[-1]))
    first = int(np.searchsorted(offsets, (offsets[-1] - most) // 2, side="right")) - 1
    begin = int(offsets[first])
    last = int(np.searchsorted(offsets, begin + most, side="right")) - 1
    return slice(begin, int(offsets[last]) if last > first else begin + most)


def _joined(
    placed: Placed, covariance: np.ndarray, rates: Rates, sds: Mapping[str, float], fresh_only: bool
) -> tuple[Placed, np.ndarray]:
    """Measurements of position and velocity (N, 2 axes), and their covariances."""
    axes, count = placed.axes, placed.rows.height
    velocity = rates.velocity[:, :axes].copy()
    if fresh_only:
        velocity[~rates.fresh] = np.nan
    velocity[:, :2][_contradicted(placed, rates, sds)] = np.nan
    R = np.zeros((count, 2 * axes, 2 * axes))
    R[:, :axes, :axes] = covariance
    along = sds.get("velocity", 1.0) ** 2 + rates.slack**2
    R[:, axes, axes] = R[:, axes + 1, axes + 1] = along
    if rates.way is not None:
        # nothing is known across the way but that a target does not move across it faster than along it
        way = np.nan_to_num(rates.way)
        across = np.column_stack([-way[:, 1], way[:, 0]])
        wide = (np.nan_to_num(np.hypot(*rates.velocity[:, :2].T)) + 10.0 * np.sqrt(along)) ** 2
        block = along[:, None, None] * way[:, :, None] * way[:, None, :]
        block += wide[:, None, None] * across[:, :, None] * across[:, None, :]
        known = np.isfinite(rates.way[:, 0])
        R[known, axes : axes + 2, axes : axes + 2] = block[known]
    if axes == 3:
        R[:, 5, 5] = sds.get("vertical_rate", 1.0) ** 2
    names = (*placed.components[:axes], *("vx", "vy", "vz")[:axes])
    z = np.ascontiguousarray(np.column_stack([placed.z[:, :axes], velocity]))
    return replace(placed, z=z, components=names), R


def _contradicted(placed: Placed, rates: Rates, sds: Mapping[str, float]) -> np.ndarray:
    """Rows whose reported velocity is far from the motion that their positions show."""
    known = np.isfinite(placed.plane).all(axis=1)
    part = np.cumsum(placed.new)[known]
    starts = np.r_[True, np.diff(part) > 0] if part.size else np.zeros(0, bool)
    rough = np.full((placed.rows.height, 2), np.nan)
    rough[known] = rough_velocity(placed.time[known], placed.plane[known], starts)
    error = rates.velocity[:, :2] - rough
    off = np.hypot(*error.T) if rates.way is None else np.abs((error * rates.way).sum(axis=1))
    usual = MEDIAN * np.nanmedian(off) if np.isfinite(off).any() else 0.0
    return off > FAR * max(usual, sds.get("velocity", 0.0))


def _sds(
    filter: Any, placed: Placed, rates: Rates, covariance: np.ndarray, given: Mapping[str, float]
) -> dict[str, float]:
    """Sds of the horizontal and of the vertical rate: given, or what they differ by from smoothed positions.

    The smoothed velocity's own error is taken off; what the reports scatter by themselves is the least.
    """
    smoothed = not getattr(filter, "not_smoothed", "")
    verb = filter.smooth if smoothed else filter.filter
    found = verb(placed.time, placed.z, offsets=placed.offsets, covariance=covariance, outputs=("x", "P"))
    index = [found.components.index(f"v{axis}") for axis in "xyz"[: placed.axes]]
    own = np.sqrt(np.diagonal(found.P, axis1=1, axis2=2)[:, index])
    error = rates.velocity[:, : placed.axes] - found.x[:, index]
    error[~rates.fresh] = np.nan
    sds: dict[str, float] = {}
    flat = error[:, :2] if rates.way is None else (error[:, :2] * rates.way).sum(axis=1, keepdims=True)
    for name, some, sd in (("velocity", flat, own[:, :2]), ("vertical_rate", error[:, 2:], own[:, 2:])):
        known = np.isfinite(some).all(axis=1) if some.size else np.zeros(0, bool)
        if known.sum() < ENOUGH:
            continue
        scatter = MEDIAN * float(np.median(np.abs(some[known])))
        rest = np.sqrt(max(scatter**2 - float(np.median(sd[known])) ** 2, 0.0))
        sds[name] = given.get(name, max(rest, 0.3 * scatter, LEAST))
    return sds


def _with_range_rate(
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
    rows = _sample(placed, RADAR_SAMPLE)
    some = placed.some(rows)
    try:
        plain = choose(placed.components, level.typical)
        filter = choose(joined.components, full.typical)
    except InputError as error:
        return placed, level, Used(notes=[f"the range rate is not used: {error}"])
    if getattr(plain, "counts_rows", False):
        return placed, level, Used(notes=["the range rate is not used: this filter counts rows"])
    places = measured_places(some, level.covariance[rows])
    before = position_scores(plain, some, level.covariance[rows], places)[:, : placed.axes - 1].sum(axis=1)
    after = position_scores(filter, joined.some(rows), full.covariance[rows], places)[:, : placed.axes - 1].sum(axis=1)
    mean, error = gain(before, after)
    if not mean > 2.0 * error:
        return placed, level, Used(notes=["the range rate is not used: held-out positions are no likelier with it"])
    used = Used({"range_rate": sd}, {"range_rate": "given" if "range_rate" in given else "estimated"})
    used.gains["range_rate"] = mean
    used.notes.append(
        f"the range rate is used: held-out positions are likelier by {mean:.2g} ± {error:.1g} a row; "
        "--no-velocity leaves it out"
    )
    return joined, replace(full, sources=[line | _figures(used) for line in level.sources]), used


def _range_rate(placed: Placed) -> np.ndarray:
    """Of rows with a position."""
    return np.where(np.isfinite(placed.plane).all(axis=1), placed.rows["range_rate"].to_numpy(), np.nan)


def _scatter(placed: Placed, rate: np.ndarray) -> float | None:
    """The sd (m/s) of a range rate, from itself; None where there is too little of it."""
    known = np.isfinite(rate)
    if known.sum() < ENOUGH:
        return None
    part = np.cumsum(placed.new)[known]
    starts, group = np.r_[True, np.diff(part) > 0], np.zeros(int(known.sum()), int)
    sd = float(component_sd(placed.time[known], rate[known], starts, group, 1)[0])
    return max(sd, LEAST) if np.isfinite(sd) else None


def _appended(placed: Placed, level: NoiseLevel, rate: np.ndarray, sd: float) -> tuple[Placed, NoiseLevel]:
    """A radar's measurements with their range rate.

    A range rate tells the velocity along the line of sight, whose direction is known to the angle's sd. While the
    velocity across it is not known, that makes an error of sd times velocity, which no linearisation shows: it is
    added to the variance. After n rows in t seconds the velocity's sd is about √(12/n) · range · angle's sd / t.
    """
    joined = replace(placed, z=np.column_stack([placed.z, rate]), components=(*placed.components, "range_rate"))
    angles = [column for column, name in enumerate(placed.components) if name in ("azimuth", "elevation")]
    angle = np.sqrt(level.covariance[:, angles].sum(axis=1))
    lengths = np.diff(placed.offsets)
    first = np.repeat(placed.offsets[:-1], lengths)
    count = np.arange(len(rate)) - first + 1.0
    step = float(np.median(np.diff(placed.time)[~placed.new[1:]])) if len(rate) > lengths.size else 1.0
    unknown = np.sqrt(12.0 / count) * np.nan_to_num(placed.z[:, 0]) * angle / np.maximum(placed.time, max(step, 1e-3))
    variance = sd**2 + (CAUTIOUS * angle * np.minimum(unknown, UNKNOWN_SPEED)) ** 2
    covariance = np.column_stack([level.covariance, variance])
    return joined, NoiseLevel(covariance, level.typical | {"range_rate": sd}, level.sources)


def as_the_filter_measures(placed: Placed, level: NoiseLevel, filter: Any) -> tuple[Placed, NoiseLevel]:
    """With the rates that the sensor of a user's filter has, where the table has them too."""
    wanted = tuple(getattr(next(iter(getattr(filter, "sensors", ())), None), "components", ()))
    if "range_rate" in wanted and "range_rate" in placed.rows.columns:
        return _appended(placed, level, _range_rate(placed), 1.0)
    if "vx" in wanted and placed.components[0] != "range" and (rates := rates_of(placed)) is not None:
        if rates.way is not None:
            # a sensor of its own noise cannot say that it measures along the way alone
            rates.velocity[:, :2] = np.nan
        joined, covariance = _joined(placed, level.covariance, rates, {}, False)
        return joined, NoiseLevel(covariance, level.typical, level.sources)
    return placed, level
