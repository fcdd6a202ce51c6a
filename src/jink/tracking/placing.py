"""From cleaned rows to what a filter takes: flat times, measurement vectors, offsets, and the way back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import polars as pl

from ..catalogue.choose import EARTH_RADIUS
from ..filters.row_noise import RowNoise
from ..frozen import frozen
from ..io.geodesy import DevelopedFrame, SiteFrame, develop
from ..io.stages import stage
from ..models.observed import to_positions
from .cleaning import changes

EXACT = 0.01  # m: how well heights above the sphere of a site have the altitudes that were measured
UNKNOWN_HEIGHT = 300.0  # m: how far the height may have been from the first one that was reported


@frozen
class Placed:
    """Parts with the same number of axes.

    rows: the cleaned rows; time (N,) s since the part's first row; z (N, m) measurements, NaN: missing; plane
    (N, 2) the measured position in metres; new (N,) marks first rows; frame leads back to the map (None:
    there is no map); sensors_named: a column says which sensor measured.
    """

    rows: pl.DataFrame
    time: np.ndarray
    z: np.ndarray
    plane: np.ndarray
    height: np.ndarray
    new: np.ndarray
    axes: int
    components: tuple[str, ...]
    frame: DevelopedFrame | SiteFrame | None
    sensors_named: bool = False

    @property
    def offsets(self) -> np.ndarray:
        """Where parts begin, and the end: (B + 1,)."""
        return np.r_[np.flatnonzero(self.new), self.new.size].astype(np.int64)

    @property
    def measured(self) -> np.ndarray:
        """Rows (N,) with a horizontal position."""
        return np.isfinite(self.plane[:, 0]) & np.isfinite(self.plane[:, 1])

    def starts(self, which: np.ndarray) -> np.ndarray:
        """First rows of each part among the rows `which`."""
        part = np.cumsum(self.new)[which]
        return np.r_[True, np.diff(part) > 0] if part.size else np.zeros(0, bool)

    def some(self, rows: slice | np.ndarray) -> Placed:
        """Whole parts of it, or rows by their numbers."""
        cut = {name: getattr(self, name)[rows] for name in ("rows", "time", "z", "plane", "height", "new")}
        frame = self.frame.rows(rows) if isinstance(self.frame, DevelopedFrame) else self.frame
        return replace(self, **cut, frame=frame)


@stage("place")
def place(
    rows: pl.DataFrame,
    position: str,
    site: SiteFrame | None,
    axes: int | None = None,
    sensors_named: bool = False,
) -> list[Placed]:
    """Split parts into those with a third axis and those without; `axes` decides for all."""
    third = {"geographic": ["altitude"], "cartesian": ["z"], "polar": ["elevation", "altitude"]}[position]
    name = next((n for n in third if n in rows.columns), None)
    if name is None or axes == 2:
        return [lay(rows, position, site, 2, None, sensors_named)] if rows.height else []
    new = changes(rows["target"], rows["part"])
    index = np.cumsum(new) - 1
    # a height counts beside a position alone
    known = (rows[name].is_finite() & rows["measured"]).fill_null(False).to_numpy()
    heights = np.bincount(index, weights=known, minlength=int(new.sum()))
    has = (heights >= 2)[index]
    groups = [(has, 3, name), (~has, 2, None)]
    return [
        lay(rows if mask.all() else rows.filter(pl.Series(mask)), position, site, n, third, sensors_named)
        for mask, n, third in groups
        if mask.any()
    ]


def lay(
    rows: pl.DataFrame,
    position: str,
    site: SiteFrame | None,
    axes: int,
    third: str | None,
    sensors_named: bool = False,
) -> Placed:
    """Rows of whole parts with `axes` axes; `third` names the column of the vertical one."""
    new = changes(rows["target"], rows["part"])
    time = rows["time"].to_numpy()
    starts = np.flatnonzero(new)
    time = time - np.repeat(time[starts], np.diff(np.r_[starts, time.size]))
    measured = rows["measured"].to_numpy()

    def column(name: str) -> np.ndarray:
        return np.where(measured, rows[name].to_numpy(), np.nan)

    vertical = column(third) if third else np.full(rows.height, np.nan)
    frame: DevelopedFrame | SiteFrame | None = site
    if position == "geographic":
        frame = develop(column("latitude"), column("longitude"), new)
        first, second = frame.x, frame.y
        names = ("x", "y", "altitude")
    elif position == "cartesian":
        first, second = column("x"), column("y")
        names = ("x", "y", "z")
    else:
        first, second = column("range"), column("azimuth")
        names = ("range", "azimuth", third or "elevation")
        if third == "altitude":
            vertical = heights_at(site, first, second, vertical)
    z = np.column_stack([first, second, vertical][:axes])
    plane, height = np.column_stack([first, second]), vertical
    if position == "polar":
        plane, height = _flat(z, names[:axes], site)
    return Placed(rows, time, np.ascontiguousarray(z), plane, height, new, axes, names[:axes], frame, sensors_named)


def heights_at(site: SiteFrame | None, distance: np.ndarray, azimuth: np.ndarray, altitude: np.ndarray) -> np.ndarray:
    """Heights (N,) above the sphere of a site that plots of such altitudes (m, above the ellipsoid) have.

    A filter knows the sphere. Its height of a place far from the site is not the altitude: at 300 km they differ by
    up to 24 m, which depends on the direction.
    """
    if site is None:
        return altitude
    height = altitude - site.altitude
    for _ in range(5):
        place = _flat(np.column_stack([distance, azimuth, height]), ("range", "azimuth", "altitude"), site)
        *_, found = site.from_space(*place[0].T, place[1])
        off = np.nan_to_num(altitude - found)
        height = height + off
        if not (np.abs(off) > EXACT).any():
            break
    return height


def begin_with_height(placed: Placed, noise: RowNoise) -> None:
    """Let parts whose first rows have no height start with the first one known, as uncertain as it is.

    A filter starts from complete positions. The first two positions of such a part get that height in `z` and
    its variance in `noise`, both changed in place; the rows after them stay without one.
    """
    if placed.axes < 3 or placed.components[2] == "elevation":
        return
    known, measured = np.isfinite(placed.z[:, 2]), np.isfinite(placed.z[:, 0])
    index = np.cumsum(placed.new) - 1
    starts = np.flatnonzero(placed.new)
    if known[starts].all():
        return
    first = np.full(starts.size, np.inf)
    some = np.flatnonzero(known)
    begins = np.flatnonzero(np.diff(index[some], prepend=-1))
    first[index[some[begins]]] = some[begins]
    before = measured & (np.arange(index.size) < first[index])
    rank = np.cumsum(before) - np.concatenate([[0], np.cumsum(before)])[starts][index]
    chosen = np.flatnonzero(before & (rank <= 2))
    placed.z[chosen, 2] = placed.z[first[index[chosen]].astype(int), 2]
    noise.variance(2)[chosen] = UNKNOWN_HEIGHT**2


def _flat(z: np.ndarray, names: Sequence[str], site: SiteFrame | None) -> tuple[np.ndarray, np.ndarray]:
    """East and north (N, 2), and up (N,), of slant range and azimuth, with elevation or altitude where there is one."""
    known = z.copy()
    third = np.full(len(z), np.nan) if len(names) < 3 else z[:, 2]
    known[:, 2:] = np.nan_to_num(known[:, 2:])
    radius = site.earth_radius if site else EARTH_RADIUS
    called = ["height" if name == "altitude" else name for name in names]
    place = to_positions(known, called, (0.0, 0.0, 0.0), "north", radius)
    return place[:, :2], np.where(np.isnan(third), np.nan, place[:, -1])
