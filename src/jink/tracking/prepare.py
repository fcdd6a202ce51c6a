"""From measurements to what a filter takes: clean, place, tell the noise, choose the filter.

Tracks of files, streams and races on recorded positions all come this way, so that they give a target the same filter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import polars as pl

from ..catalogue.choose import EARTH_RADIUS, axes_of, chosen, purpose_of
from ..catalogue.purpose import Purpose
from ..catalogue.targets import kind_of
from ..filters.row_noise import Repeated, RowNoise
from ..frozen import frozen
from ..io.errors import InputError
from ..io.geodesy import SiteFrame
from ..io.measurements import Measurements
from ..io.values import codes_of, order_of
from . import range_rate, velocity_use
from .cleaning import Cleaned, Cleaning, clean
from .converted import as_positions
from .finding import Finding
from .ground import lowest_ground
from .held_out import Used
from .hours_apart import hours_apart
from .lag import Lag
from .noise_level import NoiseLevel, noise_levels
from .placing import Placed, begin_with_height, place
from .seen_by_radar import with_lines_of_sight
from .several_sites import to_the_map
from .unknown_height import TargetHeight, height_of, on_the_ground

SHIPS = ("mmsi", "imo")  # columns that name ships
SHIP = "an MMSI or IMO number names a ship, and the filter is that of an aircraft; --kind vessel takes that of a ship"
FAR = 100e3  # m from a radar: beyond, slant ranges and those along the ground differ by a hundred metres
FLAT = (
    "x and y without z are taken along the ground from the site; beyond 100 km those of slant ranges differ from them "
    "by a hundred metres and more: give z, or slant ranges and azimuths"
)
EVIDENCE = 1_000_000  # rows that tell what holds for all targets of a larger table


LARGEST = 1e300  # times and counts are compared with floats


def _real(value: object) -> bool:
    return isinstance(value, float) or (isinstance(value, int) and value < LARGEST)


@frozen
class Settings:
    """Everything that `track` can be told, checked."""

    filter: Any = None
    kind: str = "aircraft"
    smooth: bool = False
    lag: Lag | None = None
    sensor_sd: dict[str, float] = field(default_factory=dict)
    site: SiteFrame | None = None
    gap: float | None = None
    min_points: int = 4
    sort: bool = True
    drop_duplicates: bool = True
    drop_stale: bool = True
    check: bool = True
    threads: int | None = None
    velocity: bool = True
    every: float | None = None
    manoeuvre_g: float | None = None
    target_height: TargetHeight | None = None
    sites: dict[str, SiteFrame] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kind_of(self.kind)
        if self.smooth and self.lag is not None:
            raise InputError(f"lag is {self.lag}; expected none beside smooth, which uses the whole track")
        if self.gap is not None and not (_real(self.gap) and self.gap >= 0):
            raise InputError(f"gap is {self.gap!r}; expected seconds, 0 for never")
        for name in ("threads", "min_points"):
            given = getattr(self, name)
            if (given is not None or name == "min_points") and not (isinstance(given, int) and 1 <= given < LARGEST):
                raise InputError(f"{name} is {given!r}; expected 1 or more")
        if self.manoeuvre_g is not None and not (_real(self.manoeuvre_g) and 0 < self.manoeuvre_g < math.inf):
            raise InputError(
                f"manoeuvre_g is {self.manoeuvre_g!r}; expected an acceleration in g above 0, such as 0.05"
            )

    @property
    def smoothing(self) -> dict[str, Any] | None:
        """The arguments of a filter's ``smooth``; None where tracks are only filtered."""
        return self.lag.options() if self.lag else {} if self.smooth else None

    def said(self) -> dict[str, Any]:
        """What the summary says of the settings."""
        smoothed = self.smoothing is not None
        sites = self.sites if self.site is None else {"": self.site}
        places = {name: [site.latitude, site.longitude] for name, site in sites.items()}
        said = {"kind": self.kind, "smoothed": smoothed}
        return said | ({"lag": str(self.lag)} if self.lag else {}) | ({"sites": places} if places else {})


class Pace(NamedTuple):
    """step (s): the usual time between two positions of a target, 0 where unknown; gap (s): without a position for
    longer a track begins anew, 0: never; wait (s): the longest that a filter is prepared for."""

    step: float
    gap: float
    wait: float

    @classmethod
    def of(cls, step: float, settings: Settings) -> Pace:
        """The kind's gap, or what was asked for."""
        usual = kind_of(settings.kind).gap(step)
        gap = usual if settings.gap is None else settings.gap
        return cls(step, gap, max(gap, usual))


@frozen
class Group:
    """Parts with the same number of axes: their rows, noise, the purpose a filter is made for, and the filter.

    covariance of each row's measurement; None where the filter's sensor says it, or `repeated` does. rates: what
    reported velocities are used, and why. ground (m): no height is below it; NaN: it is not known.
    """

    placed: Placed
    level: NoiseLevel
    purpose: Purpose
    filter: Any
    covariance: RowNoise | None
    rates: Used = field(default_factory=Used)
    ground: float = math.nan
    repeated: Repeated | None = None


@frozen
class Prepared:
    """What was cleaned and how, the groups that are left, none where no row is, and sources whose clocks are apart."""

    cleaned: Cleaned
    pace: Pace
    groups: list[Group]
    apart: list[Finding] = field(default_factory=list)


@frozen
class Known:
    """What some targets of a large table show, and what holds for all of them: pace, and by number of axes the noise
    and the filter.
    """

    pace: Pace
    levels: dict[int, NoiseLevel]
    filters: dict[int, tuple[Purpose, Any]]
    rates: dict[int, Used]
    grounds: dict[int, float] = field(default_factory=dict)

    @property
    def noise(self) -> list[dict[str, Any]]:
        """The lines of the summary on noise."""
        return [line | {"axes": axes} for axes, level in self.levels.items() for line in level.sources]

    @classmethod
    def of(cls, prepared: Prepared, *, some: bool) -> Known:
        """As the prepared rows show it; some: there are others, which may be lower, so that no ground is known."""
        levels = {
            group.placed.axes: NoiseLevel(
                group.level.covariance.some(slice(1)), group.level.typical, group.level.sources, group.level.step
            )
            for group in prepared.groups
        }
        filters = {group.placed.axes: (group.purpose, group.filter) for group in prepared.groups}
        rates = {group.placed.axes: group.rates for group in prepared.groups}
        grounds = {} if some else {group.placed.axes: group.ground for group in prepared.groups}
        return cls(prepared.pace, levels, filters, rates, grounds)


def prepare(measurements: Measurements, settings: Settings, known: Known | None = None) -> Prepared:
    """Clean, place, tell the noise and choose filters; the measurements' own rows are let go. Errors: InputError.

    known: what holds for all rows of a larger table. Where there are more rows than `EVIDENCE`, targets of about so
    many tell pace, noise and filter for all.
    """
    if settings.sites:
        to_the_map(measurements, settings.sites, settings.sensor_sd, settings.kind, settings.target_height)
    apart = hours_apart(measurements.rows, measurements.position) if known is None else []
    if known is None and (some := evidence(measurements.rows)) is not None:
        rows = measurements.rows.join(some, on="target", how="semi", maintain_order="left")
        known = Known.of(prepare(replace(measurements, rows=rows), replace(settings, sites={})), some=True)
    ships = measurements.named.get("target", "").lower() in SHIPS
    if ships and settings.kind == "aircraft" and SHIP not in measurements.notes:
        measurements.notes.append(SHIP)
    pace = known.pace if known else Pace.of(usual_step(measurements.rows), settings)
    fastest = kind_of(settings.kind).speed if settings.check else 0.0
    how = Cleaning(pace.gap, settings.min_points, settings.sort, settings.drop_duplicates, settings.drop_stale, fastest)
    rows, measurements.rows = measurements.rows.clone(), measurements.rows.clear()
    cleaned = clean(rows, measurements.position, how)
    site = None if measurements.position == "geographic" else settings.site
    named = "source" in measurements.named
    placed = place(cleaned.rows, measurements.position, site, axes_of(settings.filter), named)
    placed = _without_heights(placed, measurements, settings)
    if settings.site is not None:
        _far_in_the_plane(placed, measurements)
        placed = [with_lines_of_sight(each, settings.site) for each in placed]
    return Prepared(cleaned, pace, [_group(each, pace, settings, known) for each in placed], apart)


def _without_heights(placed: list[Placed], measurements: Measurements, settings: Settings) -> list[Placed]:
    """Ranges of a radar whose targets have no height, along the ground; what that takes for granted is noted."""
    some = [k for k, each in enumerate(placed) if each.components == ("range", "azimuth")]
    if not some:
        return placed
    name, others = measurements.named.get("range", ""), len(some) < len(placed)
    height, words = height_of(settings.target_height, settings.kind, name, others)
    measurements.notes += [words] if words and words not in measurements.notes else []
    if height.is_ground:
        return placed
    return [on_the_ground(each, height) if k in some else each for k, each in enumerate(placed)]


def _far_in_the_plane(placed: list[Placed], measurements: Measurements) -> None:
    """Note what x and y without z are taken for, where they are far from the site."""
    flat = [each.plane for each in placed if each.axes == 2 and measurements.position == "cartesian"]
    if any((np.hypot(*plane.T) > FAR).any() for plane in flat) and FLAT not in measurements.notes:
        measurements.notes.append(FLAT)


def evidence(rows: pl.DataFrame) -> pl.DataFrame | None:
    """Whole targets of about `EVIDENCE` rows, drawn by their names; None where these are all. rows: with `target`."""
    if rows.height <= EVIDENCE:
        return None
    return drawn(rows.group_by("target").len("rows"))


def drawn(counts: pl.DataFrame) -> pl.DataFrame | None:
    """The same from `target` and its number of `rows`."""
    some = counts.filter(pl.col("rows") <= EVIDENCE)
    if not some.height:
        some = counts.sort("rows", "target").head(1)
    else:
        some = some.sort(pl.col("target").hash(seed=1), "target").filter(pl.col("rows").cum_sum() <= EVIDENCE)
    return some.select("target") if some.height and some.height < counts.height else None


def _group(placed: Placed, pace: Pace, settings: Settings, known: Known | None) -> Group:
    of_all = known.levels.get(placed.axes) if known else None
    level = noise_levels(placed, settings.sensor_sd, settings.kind, of_all, pace.step or None)
    if level.lasting is not None:
        placed = replace(placed, rows=placed.rows.with_columns(lasting=level.lasting))
    named = settings.filter is None or isinstance(settings.filter, str)
    polar, converted, used = placed.components[0] == "range", False, Used()
    if named and settings.velocity:
        use = range_rate if polar else velocity_use
        if known is not None and of_all is not None:
            used = known.rates[placed.axes]
            placed, level = use.as_decided(placed, level, used)
        else:
            plain = partial(choose, pace=pace, settings=settings, corrected=False)
            placed, level, used = use.decided(placed, level, settings.sensor_sd, lambda *of: plain(*of)[1])
    elif not named:
        placed, level = _as_measured(placed, level, settings.filter)
        converted = polar and placed.components[0] != "range"
    if known is not None and of_all is not None:
        purpose, filter = known.filters[placed.axes]
    else:
        purpose, filter = choose(placed.components, level.typical, pace, settings, settings.smoothing is None)
    covariance = None
    # made for this table, with its typical noise in the sensor, or fitted with the noise of each row
    if named or getattr(filter, "fitted", {}).get("noise") == "of each row":
        begin_with_height(placed, level.covariance)
        covariance = None if known is None and level.covariance.uniform else level.covariance
    elif settings.sensor_sd or converted:
        covariance = level.covariance
    # the lowest height of some rows is not that of all
    ground = known.grounds.get(placed.axes, math.nan) if known else lowest_ground(placed, level.covariance)
    return Group(placed, replace(level, velocity=None), purpose, filter, covariance, used, ground)


def _as_measured(placed: Placed, level: NoiseLevel, filter: Any) -> tuple[Placed, NoiseLevel]:
    """With the rates that the sensor of a user's filter has, where the table has them too."""
    wanted = getattr(next(iter(getattr(filter, "sensors", ())), None), "components", ())
    if "range_rate" in wanted and placed.components[0] == "range":
        return range_rate.as_measured(placed, level)
    if tuple(wanted) == ("x", "y", "z")[: placed.axes] and placed.components[0] == "range":
        return as_positions(placed, level)
    if "vx" in wanted and placed.components[0] != "range":
        return velocity_use.as_measured(placed, level)
    return placed, level


def choose(
    components: Sequence[str], sd: Mapping[str, float], pace: Pace, settings: Settings, corrected: bool = True
) -> tuple[Purpose, Any]:
    """What a filter of these measurements is made for, and the filter. Errors: InputError.

    corrected: the default filter may have a learned correction, which does nothing where estimates are smoothed.
    """
    radius = settings.site.earth_radius if settings.site else EARTH_RADIUS
    purpose = purpose_of(components, sd, settings.kind, pace.wait, pace.step or 1.0, radius)
    return purpose, chosen(settings.filter, purpose, components, corrected)


def sites_of(given: Mapping[str, Sequence[float]]) -> tuple[SiteFrame | None, dict[str, SiteFrame]]:
    """The one site without a name, and sites by the names of their sources."""
    for at in given.values():
        if isinstance(at, str) or not isinstance(at, Sequence | np.ndarray) or len(at) not in (2, 3):
            raise InputError(f"site: expected a latitude and a longitude, got {at!r}")
    frames = {name: SiteFrame(*place) for name, place in given.items()}
    return frames.pop("", None), frames


def usual_step(rows: pl.DataFrame) -> float:
    """The median time between two positions of a target (s), those at the same time left out; 0 where there are
    none.
    """
    codes, time = codes_of(rows["target"]), rows["time"].to_numpy()
    if (np.diff(codes, prepend=-1) != 0).sum() > rows.height / 2:  # targets take turns
        order = order_of(codes, time)
        codes, time = codes[order], time[order]
    step = np.diff(time)[np.diff(codes) == 0]
    step = step[step > 0]
    return float(np.median(step)) if step.size else 0.0
