"""What the plan view shows of plots without identity: plots, tentative tracks, truth, and where false plots are."""

from __future__ import annotations

from typing import Any

import numpy as np
import polars as pl

from ..tracking.sky_picture import SkyPicture
from .arrays import ArrayBlock
from .plan import EARTH_RADIUS
from .rows import TrackRows

MOST_PLOTS = 150_000  # that are drawn; the clutter map is made of all
IN_A_CELL = 6.0  # false plots in a cell of the map on average, so that its own noise is below a half
MOST_CELLS = 60  # along one side


def add_sky(block: ArrayBlock, sky: SkyPicture, frame: dict[str, float] | None, rows: TrackRows) -> dict[str, Any]:
    """Pack the layers; returns what the page is told of them. Times are seconds since the first plot."""
    x, y = _plan(sky.plots, frame)
    time = _seconds(sky.plots["time"])
    begin = float(time[0]) if len(time) else 0.0
    lone, used = sky.plots["lone"].to_numpy(), sky.plots["used"].to_numpy()
    told = _add_map(block, x, y, np.where(used, 0.0, lone), sky.scans, frame)
    middle = [float(np.median(v)) if len(v) else 0.0 for v in (x, y)]
    some = np.arange(len(x))
    if len(x) > MOST_PLOTS:
        some = np.sort(np.random.default_rng(0).choice(len(x), MOST_PLOTS, replace=False))
    block.add("plot_x", x[some] - middle[0])
    block.add("plot_y", y[some] - middle[1])
    block.add("plot_time", time[some] - begin)
    block.add("plot_used", used[some], "u1")
    told |= {"plots": len(x), "drawn": len(some), "middle": middle, "begin": begin, "period": _period(time)}
    for name, table, key in (("tentative", sky.tentative, "track"), ("truth", sky.truth, "target")):
        if table is not None and table.height:
            _add_lines(block, name, table.sort(key, "time"), key, middle, begin, frame)
            told[name] = table[key].n_unique()
    if sky.series:
        names = list(dict.fromkeys(sky.series.values()))
        told["series"] = names
        block.add("series", np.array([names.index(sky.series[name]) for name in rows.names]), "u1")
    return told


def _period(time: np.ndarray) -> float:
    """Seconds between scans."""
    steps = np.diff(np.unique(time))
    return float(np.median(steps)) if len(steps) else 1.0


def _seconds(time: pl.Series) -> np.ndarray:
    return time.cast(pl.Float64).to_numpy()


def _plan(table: pl.DataFrame, frame: dict[str, float] | None) -> tuple[np.ndarray, np.ndarray]:
    """Where the plan view draws these places."""
    if frame is None:
        return table["x"].to_numpy(), table["y"].to_numpy()
    turn = (table["longitude"].to_numpy() - frame["longitude"] + 180.0) % 360.0 - 180.0
    east = frame["radius"] * np.cos(np.radians(frame["latitude"])) * np.radians(turn)
    return east, frame["radius"] * np.radians(table["latitude"].to_numpy() - frame["latitude"])


def _add_lines(
    block: ArrayBlock,
    name: str,
    table: pl.DataFrame,
    key: str,
    middle: list[float],
    begin: float,
    frame: dict[str, float] | None,
) -> None:
    x, y = _plan(table, frame)
    block.add(f"{name}_x", x - middle[0])
    block.add(f"{name}_y", y - middle[1])
    block.add(f"{name}_time", _seconds(table["time"]) - begin)
    block.add(f"{name}_first", np.flatnonzero(np.r_[True, np.diff(table[key].rle_id().to_numpy()) != 0]), "i4")


def clutter_map(
    x: np.ndarray, y: np.ndarray, weight: np.ndarray, scans: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Density (rows from the south, columns) of false plots per m² and scan, sides (2,) of a cell, south-west corner.

    density = Σ p(plot is no track's) / (scans × area) over the plots in a cell, then the mean with its neighbours by
    weights 1, 2, 1 in each direction.
    """
    low, high = np.array([x.min(), y.min()]), np.array([x.max(), y.max()])
    extent = np.maximum(high - low, 1e-9)
    cells = max(float(weight.sum()) / IN_A_CELL, 1.0)
    # what is as narrow as a line is cut along its length alone
    side = max(float(np.sqrt(extent.prod() / cells)), float(extent.max()) / min(cells, MOST_CELLS))
    columns, rows = (max(round(float(e) / side), 1) for e in extent)
    sides = extent / (columns, rows)
    column = np.minimum(((x - low[0]) / sides[0]).astype(int), columns - 1)
    row = np.minimum(((y - low[1]) / sides[1]).astype(int), rows - 1)
    total = np.bincount(row * columns + column, weights=weight, minlength=rows * columns).reshape(rows, columns)
    return _with_neighbours(total) / (max(scans, 1) * sides.prod()), sides, low


def _with_neighbours(cells: np.ndarray) -> np.ndarray:
    """Means by weights 1, 2, 1 along both axes, of the cells that there are."""
    for axis in (0, 1):
        total, weight = 2.0 * cells, np.full(cells.shape[axis], 2.0)
        after, before = (
            np.take(cells, range(*cut), axis) for cut in ((1, cells.shape[axis]), (0, cells.shape[axis] - 1))
        )
        np.swapaxes(total, 0, axis)[:-1] += np.swapaxes(after, 0, axis)
        np.swapaxes(total, 0, axis)[1:] += np.swapaxes(before, 0, axis)
        weight[:-1] += 1.0
        weight[1:] += 1.0
        cells = total / (weight[:, None] if axis == 0 else weight)
    return cells


def _add_map(
    block: ArrayBlock, x: np.ndarray, y: np.ndarray, weight: np.ndarray, scans: int, frame: dict[str, float] | None
) -> dict[str, Any]:
    good = np.isfinite(x) & np.isfinite(y)
    if not good.any():
        return {}
    density, sides, corner = clutter_map(x[good], y[good], weight[good], scans)
    if frame is not None:
        # the plan stretches east and west as at its middle
        north = corner[1] + sides[1] * (np.arange(len(density)) + 0.5)
        true = np.cos(np.radians(frame["latitude"] + np.degrees(north / EARTH_RADIUS)))
        density *= (np.cos(np.radians(frame["latitude"])) / np.maximum(true, 0.05))[:, None]
    block.add("clutter", density * 1e6)
    return {"map": {"columns": density.shape[1], "sides": sides, "corner": corner, "most": 1e6 * float(density.max())}}
