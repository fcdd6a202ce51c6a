"""The measurement noise of every row: given, stated by ADS-B, or estimated from the data per source."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from .._engine import native
from ..catalogue.targets import KINDS
from ..filters.row_noise import RowNoise
from ..io.errors import InputError
from ..io.geodesy import DevelopedFrame
from ..io.stages import stage
from ..io.units import ANGLE, LENGTH, SPEED, TIME
from ..io.values import numbered
from . import seen_by_radar
from .cleaning import changes
from .decided import Decided
from .lasting import kept, lasting_errors, said
from .placing import Placed
from .scatter import WIDEST, component_sd, plane_scatter, rough_velocity

USUAL_ALTITUDE_SD = 10.0
USUAL_POLAR_SD = {"range": 50.0, "azimuth": 2e-3, "elevation": 2e-3, "altitude": 30.0}
GIVEN = {
    "position": LENGTH,
    "altitude": LENGTH,
    "z": LENGTH,
    "time": TIME,
    "range": LENGTH,
    "azimuth": ANGLE,
    "elevation": ANGLE,
    "velocity": SPEED,
    "vertical_rate": SPEED,
    "range_rate": SPEED,
}


@dataclass
class NoiseLevel:
    """The noise of each row, typical sds, and a line per source.

    step: of time, that the figures are for (s; None: the median of the rows). lasting (N,): what positions keep of
    errors that last, a variance (m²) that no filter takes out; None where errors are independent. velocity (K, 2):
    rough ones (m/s) of the rows with a position, None where nobody has asked for them.
    """

    covariance: RowNoise
    typical: dict[str, float]
    sources: list[dict[str, Any]] = field(default_factory=list)
    step: float | None = None
    lasting: np.ndarray | None = None
    velocity: np.ndarray | None = None

    def figure(self, source: str, name: str) -> float:
        """A source's figure, NaN where it is not known."""
        return next((float(line.get(name, math.nan)) for line in self.sources if line["source"] == source), math.nan)


def parse_sensor_sd(given: float | str | Mapping[str, float] | None) -> dict[str, float]:
    """`25` (metres), `position=25,time=0.2` or `range=50,azimuth_deg=0.1`: component to SI value."""
    if given is None:
        return {}
    if isinstance(given, Mapping):
        pairs = [(str(key), value) for key, value in given.items()]
    else:
        pairs = [tuple(item.split("=", 1)) if "=" in item else ("position", item) for item in str(given).split(",")]
    values: dict[str, float] = {}
    for key, text in pairs:
        key = key.strip()
        name, _, unit = (key, "", "") if key in GIVEN else key.rpartition("_")
        if name not in GIVEN or (unit and unit not in GIVEN[name]):
            raise InputError(
                f"sensor-sd: {key!r} is not known; known are {', '.join(GIVEN)}, also with a unit (azimuth_deg)"
            )
        try:
            value = float(text) * (GIVEN[name][unit] if unit else 1.0)
        except (ValueError, TypeError, OverflowError):
            value = math.nan
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"sensor-sd: {key} is {text!r}; expected a positive number")
        values[name] = value
    return values


@stage("noise")
def noise_levels(
    placed: Placed,
    given: Mapping[str, float],
    kind: str,
    known: NoiseLevel | None = None,
    step: float | None = None,
) -> NoiseLevel:
    """Noise of every row of `placed`, from what is given, stated and estimated, in this order.

    known: that of other rows of the same table, which holds for these too. step: the usual one of the table (s).
    """
    step = known.step if known else _spacing(placed, step)
    if placed.components[0] == "range":
        level = _polar(placed, given, known)
    else:
        level = _plane(placed, given, kind, known, step)
    level = replace(level, step=step)
    return level if known is None else replace(level, typical=known.typical, sources=known.sources)


def _spacing(placed: Placed, step: float | None) -> float | None:
    """The usual step (s), or that between measured positions where most rows repeat one that two stations received."""
    measured = placed.measured
    own = native.usual_step(np.ascontiguousarray(placed.time[measured]), placed.starts(measured), 1)
    return own if step is not None and own > WIDEST * step else step


def _plane(
    placed: Placed, given: Mapping[str, float], kind: str, known_level: NoiseLevel | None, usual: float | None
) -> NoiseLevel:
    vertical = placed.components[2] if placed.axes == 3 else None
    measured = placed.measured
    # of all rows a view is enough
    which = slice(None) if measured.all() else measured
    starts = placed.starts(measured)
    source, group, of_source = _groups(placed)
    time, plane, known = placed.time[which], placed.plane[which], None
    if known_level:
        known = Decided(known_level, source, of_source, _by_target(placed))
    velocity = None
    found = stamps = np.full(of_source.size, np.nan)
    # what a sample has decided or compared with what is given is not looked at again
    if not (known and ("position" in given or known.settles("position_sd", "time_sd"))):
        velocity = rough_velocity(time, plane, starts, usual=usual)
        some = partial(plane_scatter, time, plane, velocity, starts, usual=usual)
        found, stamps = _told(some, group[which], of_source, known is None)
    scatter = found
    if known:
        found, stamps = known.figures("position_sd", found), known.figures("time_sd", stamps)
    lasting = np.full((2, of_source.size), np.nan)
    if "position" not in given:
        if not known or known.lasts():
            # where time stamps err, that lasts too, and is in the noise along the track
            white = np.where(np.nan_to_num(stamps) > 0, np.nan, found)
            lasting = lasting_errors(time, plane, starts, group[which], white, of_source)
        if known:
            lasting = known.lasting(lasting)
        found = np.fmax(found, lasting[0])
    position, origin = _decide(given.get("position"), found, of_source, KINDS[kind].position_sd)
    stamps = np.where(np.isnan(found), 0.0, stamps)
    if "position" in given or "time" in given:
        stamps = np.full(stamps.shape, given.get("time", 0.0))
    figures = {"position_sd": position, "time_sd": stamps}
    origins = {"position_sd": origin}
    if vertical:
        figures["altitude_sd"], origins["altitude_sd"] = _heights(placed, given, group, of_source, known, usual)
    lines = _lines(source, of_source, figures, origins, np.bincount(group[measured], minlength=of_source.size))
    lines = [line | said(lasting, of_source, number) for number, line in enumerate(lines)]
    if "position" in given:
        _scatter(lines, "position_sd", scatter, of_source)
    sd = {name: figure[group] for name, figure in figures.items()}
    if "given" not in origins["position_sd"] and "dilution" in placed.rows.columns:
        sd["position_sd"] = sd["position_sd"] * placed.rows["dilution"].to_numpy()
    kept_errors, estimated = kept(lasting, group), sd["position_sd"]
    for name in ("position_sd", "altitude_sd"):
        if name in sd and "given" not in origins[name]:
            sd[name] = _stated(placed, sd[name], name, lines)
    variance = sd["position_sd"] ** 2
    plain = RowNoise(2, {(0, 0): variance, (1, 1): variance})
    if stamps.any():
        if velocity is None:
            velocity = rough_velocity(time, plane, starts, usual=usual)
        plain = _with_time_stamps(variance, velocity * sd["time_sd"][which, None], which)
    if "cov_ee" in placed.rows.columns:
        plain, sd["position_sd"] = _as_placed(placed, plain, sd["position_sd"])
    decided = (known_level.sources or [{}])[0] if known_level else None
    radar = seen_by_radar.covariances(placed, measured, starts, group, of_source.size, given, plain, decided)
    if radar is not None:
        plain = plain.where(measured, radar[0])
        for number, line in enumerate(lines):
            for name, each in zip(("range", "azimuth"), radar[1:], strict=True):
                line[f"{name}_sd"] = float(np.median(each[of_source == number]))
                line[f"{name}_sd_from"] = "given" if name in given else "estimated"
        sd["position_sd"] = np.sqrt(0.5 * (plain.variance(0) + plain.variance(1)))
        kept_errors = None
    if kept_errors is not None:
        kept_errors[sd["position_sd"] != estimated] = 0.0  # of rows whose accuracy is stated
    names = {"position": "position_sd", "altitude": "altitude_sd"}
    typical = known_level.typical if known_level else _typical(sd, names)
    if vertical:
        plain = plain.beside([sd["altitude_sd"] ** 2])
    return NoiseLevel(plain, typical, lines, lasting=kept_errors, velocity=velocity)


def _with_time_stamps(variance: np.ndarray, along: np.ndarray, which: slice | np.ndarray) -> RowNoise:
    """Of positions that err alike in x and y, and by `along` (n, 2) m in the rows whose time stamps err."""
    xx, yy, xy = variance.copy(), variance.copy(), np.zeros(len(variance))
    x, y = along.T
    xx[which] += x**2
    yy[which] += y**2
    xy[which] = x * y
    return RowNoise(2, {(0, 0): xx, (0, 1): xy, (1, 1): yy})


def _told(
    estimate: Callable[[np.ndarray, int], tuple[np.ndarray, ...]],
    group: np.ndarray,
    of_source: np.ndarray,
    these_are_all: bool,
) -> tuple[np.ndarray, ...]:
    """What `estimate` finds of rows of groups (n,), (G,) each.

    If all groups of a source are too short to tell the first figure, their rows tell it together. If there are other
    rows, these have told it.
    """
    found = estimate(group, of_source.size)
    sources = int(of_source.max(initial=-1)) + 1
    short = np.bincount(of_source, np.isfinite(found[0]), sources) == 0
    if not (short.any() and these_are_all) or sources == of_source.size:
        return found
    together = estimate(of_source[group], sources)
    mine = short[of_source]
    return tuple(np.where(mine, of_all[of_source], each) for each, of_all in zip(found, together, strict=True))


def _heights(
    placed: Placed,
    given: Mapping[str, float],
    group: np.ndarray,
    of_source: np.ndarray,
    decided: Decided | None,
    usual: float | None,
) -> tuple[np.ndarray, np.ndarray]:
    """The sd of heights by group, and where it comes from."""
    asked = given.get("altitude", given.get("z"))
    found = np.full(of_source.size, np.nan)
    if asked is None and not (decided and decided.settles("altitude_sd")):
        known = np.isfinite(placed.height)
        if "grounded" in placed.rows.columns:
            # heights that were filled in say nothing of the noise of those that were measured
            known &= ~placed.rows["grounded"].to_numpy()
        some = partial(component_sd, placed.time[known], placed.height[known], placed.starts(known), usual=usual)
        (found,) = _told(lambda *groups: (some(*groups),), group[known], of_source, decided is None)
    if decided:
        found = decided.figures("altitude_sd", found)
    return _decide(asked, found, of_source, USUAL_ALTITUDE_SD)


def _as_placed(placed: Placed, other: RowNoise, sd: np.ndarray) -> tuple[RowNoise, np.ndarray]:
    """The noise of a radar's plots on the map, in the axes of the frame, and its sds (N,); that of the other rows."""
    names = ("cov_ee", "cov_en", "cov_nn")
    east, both, north = (placed.rows[name].to_numpy() for name in names)
    turned = placed.frame.anchor_convergence if isinstance(placed.frame, DevelopedFrame) else np.zeros(len(sd))
    cos, sin = np.cos(turned), np.sin(turned)
    xx = cos**2 * east - 2.0 * cos * sin * both + sin**2 * north
    yy = sin**2 * east + 2.0 * cos * sin * both + cos**2 * north
    xy = cos * sin * (east - north) + (cos**2 - sin**2) * both
    good = np.isfinite(xx + yy + xy)
    noise = other.where(good, RowNoise(2, {(0, 0): xx, (0, 1): xy, (1, 1): yy}))
    return noise, np.where(good, np.sqrt(0.5 * np.where(good, xx + yy, 1.0)), sd)


def _polar(placed: Placed, given: Mapping[str, float], known_level: NoiseLevel | None) -> NoiseLevel:
    source, group, of_source = _groups(placed)
    figures, origins, scatter = {}, {}, {}
    for column, name in enumerate(placed.components):
        known = np.isfinite(placed.z[:, column])
        # as reported: above a site's sphere the height of a level flight changes by millimetres
        value = (placed.rows[name].to_numpy() if name == "altitude" else placed.z[:, column])[known]
        value = np.unwrap(value) if name == "azimuth" else value
        found = component_sd(placed.time[known], value, placed.starts(known), group[known], of_source.size)
        scatter |= {f"{name}_sd": found} if name in given else {}
        if known_level:
            found = Decided(known_level, source, of_source, False).figures(f"{name}_sd", found)
        figures[f"{name}_sd"], origins[f"{name}_sd"] = _decide(given.get(name), found, of_source, USUAL_POLAR_SD[name])
    counts = np.bincount(group, minlength=of_source.size)
    sd = {name: figure[group] for name, figure in figures.items()}
    lines = _lines(source, of_source, figures, origins, counts)
    for name, found in scatter.items():
        _scatter(lines, name, found, of_source)
    return NoiseLevel(
        RowNoise.of_variances(each**2 for each in sd.values()),
        _typical(sd, {n: f"{n}_sd" for n in placed.components}),
        lines,
    )


def _groups(placed: Placed) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names of the sources, the group of every row, and the source of every group.

    A group is a source, or a source's target where targets report themselves (places on the map without a
    sensor's column).
    """
    names, source = numbered(placed.rows["source"])
    if not _by_target(placed):
        return names, source, np.arange(len(names))
    offsets = placed.offsets
    target = np.repeat(np.cumsum(changes(placed.rows["target"][offsets[:-1]])) - 1, np.diff(offsets))
    if len(names) == 1:
        return names, target, np.zeros(int(target[-1]) + 1, np.int64)
    pair, group = np.unique(target * len(names) + source, return_inverse=True)
    return names, group, pair % len(names)


def _by_target(placed: Placed) -> bool:
    """Whether targets report themselves, so that each is a source of its own."""
    return placed.components[:2] == ("x", "y") and isinstance(placed.frame, DevelopedFrame) and not placed.sensors_named


def _lines(
    names: list[str],
    of_source: np.ndarray,
    figures: Mapping[str, np.ndarray],
    origins: Mapping[str, np.ndarray],
    counts: np.ndarray,
) -> list[dict[str, Any]]:
    """One line per source: median of its groups, how it was come by, and the range of several."""
    lines = []
    for number, name in enumerate(names):
        mine = of_source == number
        line: dict[str, Any] = {"source": name, "rows": int(counts[mine].sum()), "groups": int(mine.sum())}
        for key, figure in figures.items():
            line[key] = float(np.median(figure[mine]))
            if mine.sum() > 1:
                line[f"{key}_range"] = [float(figure[mine].min()), float(figure[mine].max())]
            if key in origins:
                line[f"{key}_from"] = str(max(set(origins[key][mine].tolist()), key=origins[key][mine].tolist().count))
        lines.append(line)
    return lines


def _scatter(lines: list[dict[str, Any]], name: str, found: np.ndarray, of_source: np.ndarray) -> None:
    """Beside a given figure, the one that the data show, where they show one."""
    for number, line in enumerate(lines):
        mine = found[(of_source == number) & (found > 0)]
        if mine.size:
            line[f"{name}_seen"] = float(np.median(mine))


def _typical(sd: Mapping[str, np.ndarray], names: Mapping[str, str]) -> dict[str, float]:
    return {short: float(np.median(sd[name])) for short, name in names.items() if name in sd}


def _decide(
    given: float | None, found: np.ndarray, of_source: np.ndarray, usual: float
) -> tuple[np.ndarray, np.ndarray]:
    """A figure per group and where it comes from: given, estimated, its source's median, or what is usual."""
    if given is not None:
        return np.full(found.shape, given), np.full(found.shape, "given")
    found = np.where(found > 0, found, np.nan)  # what never changes (level flight) says nothing of its error
    figure, origin = found.copy(), np.where(np.isnan(found), "assumed", "estimated")
    for number in np.unique(of_source[np.isnan(found)]):
        mine = of_source == number
        others = found[mine & np.isfinite(found)]
        figure[mine & np.isnan(found)] = np.median(others) if others.size else usual
        if others.size:
            origin[mine] = "estimated"
    return figure, origin


def _stated(placed: Placed, sd: np.ndarray, name: str, lines: list[dict[str, Any]]) -> np.ndarray:
    """Where ADS-B says how accurate it is (NACp, NIC, GVA), that is the noise."""
    stated = placed.rows[name].to_numpy()
    known = np.isfinite(stated)
    if known.any():
        for line in lines:
            line[f"{name}_stated_rows"] = int((known & (placed.rows["source"] == line["source"]).to_numpy()).sum())
    return np.where(known, stated, sd)
