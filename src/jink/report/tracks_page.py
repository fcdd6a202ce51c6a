"""The page of `jink track --report`: plan view, estimates against time, cleaning, consistency."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from ..estimate import STATUS, Status
from ..frozen import frozen
from ..tracking.sky_picture import SkyPicture
from .arrays import ArrayBlock, round_mantissa
from .cards import consistency_card, group, summary_cards
from .consistency import Consistency, consistency
from .curves import Panel, panels
from .decimation import keep_rows
from .plan import measured_coordinates, plan_coordinates
from .rows import TrackRows, read_rows
from .settled import group_quantile, settled
from .shell import PLAN_AND_CHARTS, escape, fill, page, write_page
from .sites import site_places
from .sky_layers import add_sky
from .targets import target_table
from .tiles import Tiles
from .world import add_world

_SCRIPTS = (*PLAN_AND_CHARTS, "address.js", "replay.js", "exports.js", "space.js", "sky.js", "tracks.js")
_BYTES = 5_500_000  # aimed at for the arrays before compression, times two: keeps a page below 8 MB
_MOST_TARGETS = 5_000
_GATED_BONUS = 0.05
_COAST = 5


def write_report(
    tracks: pl.DataFrame,
    path: str | os.PathLike[str],
    *,
    summary: Mapping[str, Any],
    title: str | None = None,
    sky: SkyPicture | None = None,
    tiles: str | None = None,
) -> None:
    """Write one HTML file that shows `tracks` and needs no network, no server and no other file.

    tracks: the table that `jink.track` returns (needed: target, time, and latitude, longitude or x, y; the
    rest is shown when present). summary: counts and settings of the run, nested mappings of plain values,
    shown as tables. sky: plots, tentative tracks and false plots, where plots had no identity. tiles: the address of a
    map server's pictures with {z}, {x} and {y}; the page then asks that server for them. Raises
    ValueError naming missing columns, OSError when `path` cannot be written. Every
    number is computed from all rows; only what is drawn is decimated, keeping the shape of every curve.
    """
    write_page(path, page_text(tracks, summary, title, sky, tiles))


def page_text(
    tracks: pl.DataFrame,
    summary: Mapping[str, Any],
    title: str | None = None,
    sky: SkyPicture | None = None,
    tiles: str | None = None,
) -> str:
    """The page as HTML."""
    server = Tiles(tiles).origin if tiles else ""
    title = title or _title(summary)
    every = read_rows(tracks)
    check = _check(every)
    cards = consistency_card(check, int(np.sum(every.status == Status.gated)))
    listed, rows = _limit_targets(every)
    if rows is not every:
        check = _check(rows)
    table = target_table(rows, check)
    drawing = _draw(rows, summary, sky)
    meta = {
        "clock": rows.clock,
        "same_day": _same_day(rows),
        "frame": drawing.frame,
        "modes": rows.modes,
        "statuses": STATUS,
        "targets": {"name": rows.names, **{k: v for k, v in table.items() if k != "start"}},
        "panels": drawing.panels,
        "nis_band": _common_band(rows, check),
        "liveliest": _liveliest(table, rows),
        "sites": drawing.sites,
        "sky": drawing.sky,
        "tiles": tiles,
    }
    body = fill(
        "tracks.html",
        title=escape(title),
        lede=escape(" ".join(filter(None, (str(summary.get("sample", "")), _lede(every, sky))))),
        consistency=cards,
        summary=summary_cards(summary),
        footer=escape(
            _footer(drawing.drawn, len(every), listed, len(every.names))
            + _footer_of_sky(drawing.sky)
            + _of_lag(summary)
            + (f" The map's pictures come from {server}." if server and drawing.frame else "")
        ),
    )
    return page(title=title, body=body, scripts=_SCRIPTS, meta=meta, block=drawing.block, images=server)


def _title(summary: Mapping[str, Any]) -> str:
    """Tracks, and the names of the files they come from when the summary tells one or two."""
    files = summary.get("files")
    if isinstance(files, list | tuple) and 1 <= len(files) <= 2 and all(isinstance(f, str) for f in files):
        return f"Tracks of {' and '.join(os.path.basename(f) for f in files)}"
    return "Tracks"


def _check(rows: TrackRows) -> Consistency:
    accepted = rows.status == Status.updated
    return consistency(rows.target, len(rows.names), rows.column("nis"), rows.column("nis_dof"), accepted)


def _limit_targets(rows: TrackRows) -> tuple[int, TrackRows]:
    """(targets shown, their rows): the longest ones when there are more than a page can list."""
    if len(rows.names) <= _MOST_TARGETS:
        return len(rows.names), rows
    longest = np.argsort(-np.diff(rows.first), kind="stable")[:_MOST_TARGETS]
    chosen = np.isin(rows.target, longest)
    time = pl.from_epoch((pl.col("time") * 1e6).cast(pl.Int64), time_unit="us") if rows.clock else pl.col("time")
    return _MOST_TARGETS, read_rows(rows.frame.filter(pl.Series(chosen)).with_columns(time))


@frozen
class _Drawing:
    block: ArrayBlock
    panels: list[dict[str, Any]]
    frame: dict[str, float] | None
    sites: list[dict[str, float | str]]
    drawn: int
    sky: dict[str, Any] | None


def _draw(rows: TrackRows, summary: Mapping[str, Any], sky: SkyPicture | None) -> _Drawing:
    """Decimate and pack what is drawn."""
    east, north, frame = plan_coordinates(rows)
    shown = panels(rows)
    probability = [rows.column(f"probability_{mode}") for mode in rows.modes]
    manoeuvring = rows.column("manoeuvring")
    if "manoeuvring" not in rows.frame.columns:
        manoeuvring = np.zeros(len(rows))
    per_row = 24 + sum(7 * len(p.curves) for p in shown) + len(probability)
    keep = _choose(rows, [east, north], shown, manoeuvring, budget=2 * _BYTES // per_row)
    block = ArrayBlock()
    first = np.searchsorted(rows.target[keep], np.arange(len(rows.names) + 1))
    start = rows.time[rows.first[:-1]] if len(rows) else np.zeros(0)
    block.add("first", first, "i4")
    block.add("start", start, "f8")
    block.add("time", (rows.time - start[rows.target])[keep] if len(rows) else start)
    _add_positions(block, rows, keep, east, north, measured_coordinates(rows, east, north, frame))
    _add_states(block, rows, keep, manoeuvring, probability)
    add_world(block, frame, east, north)
    entries = [_add_panel(block, panel, keep) for panel in shown]
    layers = add_sky(block, sky, frame, rows) if sky is not None else None
    return _Drawing(block, entries, frame, site_places(summary, frame, east, north), keep.size, layers)


def _choose(
    rows: TrackRows, position: list[np.ndarray], shown: list[Panel], manoeuvring: np.ndarray, budget: int
) -> np.ndarray:
    """Rows to draw: all curves in units of their range within the target, where their sd has settled."""
    if len(rows) <= budget:
        return np.arange(len(rows))
    groups = len(rows.names)
    extent = np.fmax(*(_spread(p, np.isfinite(p), rows) for p in position))
    series = [p / np.maximum(extent, 1e-9)[rows.target] * 2.0 for p in position] + [manoeuvring]
    for panel in shown:
        for curve in panel.curves:
            usable = settled(curve.value, curve.sd, rows)
            noise = group_quantile(curve.sd, rows.target, groups)
            scale = np.fmax(np.fmax(_spread(curve.value, usable, rows), 4.0 * noise), 1e-9)
            series.append(np.where(usable, curve.value / scale[rows.target], 0.0))
    bonus = np.where(rows.status == Status.gated, _GATED_BONUS, 0.0)
    return keep_rows(rows.target, rows.time, np.stack(series).astype(np.float32), budget, bonus)


def _spread(values: np.ndarray, usable: np.ndarray, rows: TrackRows) -> np.ndarray:
    """Largest minus smallest usable value per target (T,)."""
    low = np.minimum.reduceat(np.where(usable, values, np.inf), rows.first[:-1])
    high = np.maximum.reduceat(np.where(usable, values, -np.inf), rows.first[:-1])
    return np.where(high > low, high - low, np.nan)


def _add_positions(
    block: ArrayBlock,
    rows: TrackRows,
    keep: np.ndarray,
    east: np.ndarray,
    north: np.ndarray,
    measured: tuple[np.ndarray, np.ndarray],
) -> None:
    """Positions as float32 from the middle of each target: exact to centimetres far from the origin too."""
    group_of, groups = rows.target, len(rows.names)
    for axis, values, seen in (("x", east, measured[0]), ("y", north, measured[1])):
        centre = np.nan_to_num(group_quantile(values, group_of, groups))
        name = {"x": "east", "y": "north"}[axis]
        block.add(f"centre_{axis}", centre, "f8")
        block.add(name, (values - centre[group_of])[keep])
        block.add(f"measured_{name}", (seen - centre[group_of])[keep])


def _add_states(
    block: ArrayBlock,
    rows: TrackRows,
    keep: np.ndarray,
    manoeuvring: np.ndarray,
    probability: list[np.ndarray],
) -> None:
    """Status, breaks between parts, NIS, and probabilities in steps of 1/254 (255: unknown)."""
    fresh = np.ones(len(rows), dtype=np.uint8)
    fresh[1:] = (np.diff(rows.target) != 0) | (np.diff(rows.part) != 0)
    broken = np.cumsum(fresh)[keep]
    block.add("fresh", np.diff(broken, prepend=0) > 0, "u1")
    block.add("status", rows.status[keep], "u1")
    block.add("coasting", _coasting(rows, np.cumsum(fresh))[keep], "u1")
    if rows.has("confirmed"):
        block.add("tentative", rows.column("confirmed")[keep] == 0.0, "u1")
    for name, values in [("manoeuvring", manoeuvring), *((f"mode{m}", p) for m, p in enumerate(probability))]:
        code = np.round(np.clip(values[keep], 0.0, 1.0) * 254.0)
        block.add(name, np.where(np.isfinite(code), code, 255), "u1")
    if rows.has("nis"):
        block.add("nis", round_mantissa(rows.column("nis")[keep], 9))


def _coasting(rows: TrackRows, part: np.ndarray) -> np.ndarray:
    """(N,) bool: rows within a run of at least _COAST predictions, which the plan view draws dashed."""
    predicted = rows.status == Status.predicted
    if not predicted.any():
        return predicted
    change = np.ones(len(rows), dtype=bool)
    change[1:] = (predicted[1:] != predicted[:-1]) | (part[1:] != part[:-1])
    run = np.cumsum(change) - 1
    return predicted & (np.bincount(run)[run] >= _COAST)


def _add_panel(block: ArrayBlock, panel: Panel, keep: np.ndarray) -> dict[str, Any]:
    curves = []
    for c, curve in enumerate(panel.curves):
        value, sd = f"{panel.key}{c}", f"{panel.key}{c}_sd"
        block.add(value, round_mantissa(curve.value[keep], 16))
        block.add(sd, round_mantissa(curve.sd[keep], 7))
        curves.append({"label": curve.label, "value": value, "sd": sd})
    return {"key": panel.key, "title": panel.title, "quantity": panel.quantity, "curves": curves}


def _common_band(rows: TrackRows, check: Consistency) -> tuple[float, float] | None:
    """The 95 % band for the commonest number of degrees of freedom."""
    if not check.bands:
        return None
    dof = rows.column("nis_dof")
    return check.bands[max(check.bands, key=lambda k: int(np.sum(dof == k)))]


def _liveliest(table: dict[str, np.ndarray], rows: TrackRows) -> int:
    """The target to show first: the one with most rows in manoeuvres, fewer gaps preferred."""
    if len(rows) == 0:
        return -1
    inside = np.zeros(len(rows))
    same = (np.diff(rows.target) == 0) & (np.diff(rows.part) == 0)
    inside[1:] = np.where(same, np.diff(rows.time), 0.0)
    covered = np.bincount(rows.target, weights=inside) / np.maximum(table["duration"], 1e-9)
    return int(np.argmax(np.nan_to_num(table["manoeuvring"]) * table["rows"] * covered))


def _same_day(rows: TrackRows) -> bool:
    """Whether all rows are of one UTC day, so that times need no dates."""
    return rows.clock and len(rows) > 0 and rows.time.min() // 86400 == rows.time.max() // 86400


def _lede(rows: TrackRows, sky: SkyPicture | None) -> str:
    if len(rows) == 0:
        return "no tracks"
    trackers = len(set(sky.series.values())) if sky is not None and sky.series else 0
    text = [
        f"{group(len(rows.names))} target{'s' if len(rows.names) > 1 else ''}"
        if not trackers
        else f"{group(len(rows.names))} tracks of {trackers} trackers",
        f"{group(len(rows))} rows",
    ]
    low, high = float(rows.time.min()), float(rows.time.max())
    if rows.clock:
        begin, end = (pl.Series([int(t * 1e6)]).cast(pl.Datetime("us"))[0] for t in (low, high))
        same = begin.date() == end.date()
        text.append(f"{begin:%Y-%m-%d %H:%M} to {end:{'%H:%M' if same else '%Y-%m-%d %H:%M'}} UTC")
    else:
        text.append(f"{low:.6g} s to {high:.6g} s")
    return " · ".join(text)


def _footer(drawn: int, total: int, listed: int, targets: int) -> str:
    if drawn == total:
        text = f"All {group(total)} rows are drawn."
    else:
        text = f"{group(drawn)} of {group(total)} rows are drawn, chosen to keep the shape of every curve. "
        text += "Every number is computed from all rows."
    if listed < targets:
        text += f" Of {group(targets)} targets the {group(listed)} with most rows are shown."
        text += " The consistency is that of all targets."
    return text


def _of_lag(summary: Mapping[str, Any]) -> str:
    """What estimates use, and what would be better for those who can wait."""
    if summary.get("lag"):
        return f" Every estimate uses what was measured up to {summary['lag']} later."
    if summary.get("smoothed") is False:
        return (
            " Every estimate uses what came before it alone; for all that can wait a scan, --lag 1 is the mode to use."
        )
    return ""


def _footer_of_sky(sky: dict[str, Any] | None) -> str:
    if sky is None:
        return ""
    if sky["drawn"] == sky["plots"]:
        return f" All {group(sky['plots'])} plots are drawn."
    return (
        f" {group(sky['drawn'])} of {group(sky['plots'])} plots are drawn, picked at random; the clutter map has all."
    )
