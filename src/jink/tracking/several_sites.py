"""Several radars in one table: the plots of each, seen from its own site, become places on the map.

The noise of each radar is estimated in range and angles first; it goes along as a covariance of every place.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from ..io.errors import InputError
from ..io.geodesy import SiteFrame
from ..io.measurements import Measurements
from .cleaning import measured_rows
from .converted import as_positions
from .noise_level import noise_levels
from .placing import lay

COVARIANCE = ("cov_ee", "cov_en", "cov_nn")  # m², east and north
KEPT = ("range", "azimuth", "elevation", "range_rate")  # what a place on the map no longer has


def to_the_map(
    measurements: Measurements, sites: Mapping[str, SiteFrame], given: Mapping[str, float], kind: str
) -> None:
    """Turn ranges and azimuths into latitude, longitude and altitude, in place. Errors: InputError."""
    if measurements.position != "polar":
        raise InputError("site: sites by name are for range and azimuth; give one site for x and y")
    rows = measurements.rows
    sources = rows["source"].unique(maintain_order=True).to_list()
    if "source" not in measurements.named and len(measurements.rows["file"].unique()) < 2:
        raise InputError("site: no column says which radar measured; --columns source=NAME names it")
    named = {source: sites.get(source) or sites.get(_stem(source)) for source in sources}
    missing = [source for source, site in named.items() if site is None]
    if missing:
        raise InputError(
            f"site: no site is given for {', '.join(map(repr, missing[:5]))}; given are {', '.join(sites)}"
        )
    parts = []
    for source, site in named.items():
        assert site is not None
        mine = rows.filter(pl.col("source") == source).sort("target", "time", maintain_order=True)
        part, note = _placed(mine, site, given, kind)
        parts.append(part)
        measurements.notes.append(f"{source} at {site.latitude:g}, {site.longitude:g}: {note}")
    measurements.rows = pl.concat(parts, how="diagonal")
    measurements.position = "geographic"


def _stem(source: str) -> str:
    """A file's name without folder and ending."""
    return source.rsplit("/", 1)[-1].split(".")[0]


def _placed(rows: pl.DataFrame, site: SiteFrame, given: Mapping[str, float], kind: str) -> tuple[pl.DataFrame, str]:
    """One radar's rows on the map, and its noise in words."""
    third = next((n for n in ("elevation", "altitude") if n in rows.columns and rows[n].is_finite().any()), None)
    rows = rows.with_columns(part=pl.lit(0, pl.Int32), measured=measured_rows(rows, "polar"))
    seen = lay(rows, "polar", site, 3 if third else 2, third)
    level = noise_levels(seen, given, kind)
    placed, noise = as_positions(seen, level)
    x, y = seen.plane.T
    up = seen.height if third else None
    # without a height a plot lies as far along the ground as its range is long
    flat = np.zeros(len(x)) if up is None else np.nan_to_num(up)
    latitude, longitude, turned, altitude = site.to_geographic(x, y, None if up is None else flat)
    cos, sin = np.cos(turned), np.sin(turned)
    # a course in the site's frame is a true one less the convergence: x, y to east, north
    turn = np.stack([np.stack([cos, sin], -1), np.stack([-sin, cos], -1)], -2)
    R = turn @ noise.covariance[:, :2, :2] @ np.swapaxes(turn, -1, -2)
    columns: dict[str, Any] = {"latitude": latitude, "longitude": longitude}
    if altitude is not None and up is not None:
        columns["altitude"] = np.where(np.isfinite(up), altitude, np.nan)
        columns["altitude_sd"] = np.sqrt(noise.covariance[:, 2, 2])
    columns |= dict(zip(COVARIANCE, (R[:, 0, 0], R[:, 0, 1], R[:, 1, 1]), strict=True))
    kept = rows.drop("part", "measured", *(name for name in KEPT if name in rows.columns))
    line = level.sources[0]
    words = [
        f"{name} {line[f'{name}_sd'] * factor:.2g} {unit} ({line[f'{name}_sd_from']})"
        for name, factor, unit in (("range", 1.0, "m"), ("azimuth", 1e3, "mrad"), ("elevation", 1e3, "mrad"))
        if f"{name}_sd" in line
    ]
    assert len(placed.z) == kept.height
    return kept.with_columns(pl.Series(name, value) for name, value in columns.items()), ", ".join(words)
