"""Several radars in one table: the plots of each, seen from its own site, become places on the map.

The noise of each radar is estimated in range and angles first; it goes along as a covariance of every place.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.targets import kind_of
from ..filters.row_noise import RowNoise
from ..frozen import frozen
from ..io.errors import InputError
from ..io.geodesy import SiteFrame
from ..io.measurements import Measurements
from .cleaning import measured_rows
from .converted import as_positions
from .noise_level import NoiseLevel, noise_levels
from .placing import UNKNOWN_HEIGHT, Placed, lay
from .several_heights import between, told_by
from .unknown_height import BEARING, VARIANCE, TargetHeight, height_of, on_the_ground

COVARIANCE = ("cov_ee", "cov_en", "cov_nn")  # m², east and north
KEPT = ("range", "azimuth", "elevation", "range_rate")  # what a place on the map no longer has
ORDER = "order in the table"
NO_RATE = "the range rate is not used, because plots of several sites become places on the map"


@frozen
class Seen:
    """One radar's rows by target and time, where it stands, and the noise of its plots."""

    rows: pl.DataFrame
    site: SiteFrame
    placed: Placed
    level: NoiseLevel

    @property
    def has_height(self) -> np.ndarray:
        """Which plots say how high their target is (N,)."""
        return np.isfinite(self.placed.height)


def to_the_map(
    measurements: Measurements,
    sites: Mapping[str, SiteFrame],
    given: Mapping[str, float],
    kind: str,
    height: TargetHeight | None = None,
) -> None:
    """Turn ranges and azimuths into latitude, longitude and altitude, in place. Errors: InputError.

    height: of targets that have none in the table; None: that of the kind, where the ranges are slant ranges.
    """
    rows = measurements.rows.with_row_index(ORDER)
    radars = []
    for source, site in _of_sources(sites, measurements).items():
        mine = rows.filter(pl.col("source") == source).sort("target", "time", maintain_order=True)
        radars.append(_seen(mine, site, given, kind))
        words = _in_words(radars[-1].level.sources[0])
        measurements.notes.append(f"{source} at {site.latitude:g}, {site.longitude:g}: {words}")
    tables = [_with_heights(seen) for seen in radars]
    told = told_by(tables)
    unknown = _height_of_the_rest(measurements, told, kind, height)
    for seen in radars:
        tables += _without_heights(seen, told, kind, unknown)
    if "range_rate" in rows.columns and rows["range_rate"].is_finite().any():
        measurements.notes.append(NO_RATE)
    found = pl.concat(tables, how="diagonal").sort(ORDER).drop(ORDER)
    measurements.rows = found.with_columns(pl.col(n).fill_null(0.0) for n in (VARIANCE, BEARING) if n in found.columns)
    measurements.position = "geographic"


def _of_sources(sites: Mapping[str, SiteFrame], measurements: Measurements) -> dict[str, SiteFrame]:
    """Where each source of the table stands. Errors: InputError."""
    if measurements.position != "polar":
        raise InputError("site: sites by name are for range and azimuth; give one site for x and y")
    rows = measurements.rows
    sources = rows["source"].unique(maintain_order=True).to_list()
    if "source" not in measurements.named and len(rows["file"].unique()) < 2:
        raise InputError("site: no column says which radar measured; --columns source=NAME names it")
    named = {source: sites.get(source) or sites.get(_stem(source)) for source in sources}
    missing = [source for source, site in named.items() if site is None]
    if missing:
        raise InputError(
            f"site: no site is given for {', '.join(map(repr, missing[:5]))}; given are {', '.join(sites)}"
        )
    return {source: site for source, site in named.items() if site is not None}


def _stem(source: str) -> str:
    """A file's name without folder and ending."""
    return source.rsplit("/", 1)[-1].split(".")[0]


def _seen(rows: pl.DataFrame, site: SiteFrame, given: Mapping[str, float], kind: str) -> Seen:
    third = next((n for n in ("elevation", "altitude") if n in rows.columns and rows[n].is_finite().any()), None)
    rows = rows.with_columns(part=pl.lit(0, pl.Int32), measured=measured_rows(rows, "polar"))
    placed = lay(rows, "polar", site, 3 if third else 2, third)
    return Seen(rows, site, placed, noise_levels(placed, given, kind))


def _in_words(line: Mapping[str, Any]) -> str:
    """The noise of a radar."""
    return ", ".join(
        f"{name} {line[f'{name}_sd'] * factor:.2g} {unit} ({line[f'{name}_sd_from']})"
        for name, factor, unit in (("range", 1.0, "m"), ("azimuth", 1e3, "mrad"), ("elevation", 1e3, "mrad"))
        if f"{name}_sd" in line
    )


def _with_heights(seen: Seen) -> pl.DataFrame:
    """Plots that say how high their target is, on the map."""
    which = np.flatnonzero(seen.has_height)
    third = seen.placed.components[2] if seen.placed.axes == 3 else None
    placed = lay(seen.rows[which], "polar", seen.site, 3 if third else 2, third)
    return _mapped(placed, seen.level.covariance.some(which), seen.site)


def _height_of_the_rest(
    measurements: Measurements, told: pl.DataFrame, kind: str, given: TargetHeight | None
) -> TargetHeight:
    """What is taken for targets without any height, and a note of it where there are such targets."""
    if measurements.rows.join(told, on="target", how="anti").is_empty():
        return TargetHeight(0.0, 0.0)
    found, words = height_of(given, kind, measurements.named.get("range", ""), not told.is_empty())
    measurements.notes += [words] if words else []
    return found


def _without_heights(seen: Seen, told: pl.DataFrame, kind: str, unknown: TargetHeight) -> list[pl.DataFrame]:
    """Plots that do not say it, on the map: at the height that others tell of the target, or at an unknown one."""
    which = np.flatnonzero(~seen.has_height)
    rows, noise = seen.rows[which], seen.level.covariance.some(which)
    usual = kind_of(kind)
    altitude, variance = between(rows, told, usual.climbs[0], max(usual.height[1], UNKNOWN_HEIGHT))
    known = np.isfinite(altitude)
    tables = []
    if known.any():
        mine = rows.with_columns(altitude=altitude).filter(known)
        placed = lay(mine, "polar", seen.site, 3, "altitude")
        table = _mapped(placed, noise.first(2).some(known).beside([variance[known]]), seen.site)
        tables.append(table.drop("altitude", "altitude_sd"))
    if not known.all():
        placed = lay(rows.filter(~known), "polar", seen.site, 2, None)
        placed = placed if unknown.is_ground else on_the_ground(placed, unknown)
        tables.append(_mapped(placed, noise.first(2).some(~known), seen.site))
    return tables


def _mapped(placed: Placed, noise: RowNoise, site: SiteFrame) -> pl.DataFrame:
    """Rows of plots with their places on the map, and the covariances of these.

    noise: of range, azimuth and the third component. What an unknown height does to a place counts as its
    noise too, so that radars that see the target from elsewhere do not contradict.
    """
    places = as_positions(placed, NoiseLevel(noise, {}))[1].covariance[:]
    x, y = placed.plane.T
    up = placed.height if placed.axes == 3 else None
    latitude, longitude, turned, altitude = site.to_geographic(x, y, up)
    cos, sin = np.cos(turned), np.sin(turned)
    # a course in the site's frame is a true one less the convergence: x, y to east, north
    turn = np.stack([np.stack([cos, sin], -1), np.stack([-sin, cos], -1)], -2)
    R = turn @ places[:, :2, :2] @ np.swapaxes(turn, -1, -2)
    columns: dict[str, Any] = {"latitude": latitude, "longitude": longitude}
    if altitude is not None:
        columns |= {"altitude": altitude, "altitude_sd": np.sqrt(places[:, 2, 2])}
    if VARIANCE in placed.rows.columns:
        columns[BEARING] = np.arctan2(x, y) + turned
        along = np.stack([np.sin(columns[BEARING]), np.cos(columns[BEARING])], -1)
        R = R + placed.rows[VARIANCE].to_numpy()[:, None, None] * along[:, :, None] * along[:, None, :]
    columns |= dict(zip(COVARIANCE, (R[:, 0, 0], R[:, 0, 1], R[:, 1, 1]), strict=True))
    kept = placed.rows.drop("part", "measured", *KEPT, "altitude", strict=False)
    return kept.with_columns(pl.Series(name, value) for name, value in columns.items())
