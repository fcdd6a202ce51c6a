"""The page of `jink report FOLDER`: where and when targets were seen, and those that are least consistent."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import polars as pl

from ..archive.tracked import Tracks
from ..papers.drawing import Chart, Line
from .cards import consistency_card, group, summary_cards
from .density_map import density_map
from .shell import escape, plain_page, write_page
from .survey import SPANS, Survey
from .svg import drawn
from .tracks_page import page_text as tracks_text

SHOWN = 20  # targets of each table
_COMPARED = 50  # rows with NIS that a target needs to be judged
_ROWS = 500_000  # of all targets that can be looked at
_UNITS = (("days", 86_400.0), ("hours", 3_600.0), ("minutes", 60.0), ("seconds", 0.0))


def write_overview(tracks: Tracks, found: Survey, path: str | os.PathLike[str], tiles: str | None = None) -> Path:
    """Write the page, and beside it the tracks of the targets that it names; returns the path of the second one.

    Errors: OSError where one of them cannot be written.
    """
    page = Path(path)
    beside = page.with_name(f"{page.stem}.targets{page.suffix or '.html'}")
    worst, longest = least_consistent(found.targets), found.targets.sort("rows", "target", descending=[True, False])
    worst, longest = worst.head(SHOWN), longest.head(SHOWN)
    linked = _affordable(worst, longest)
    write_page(beside, tracks_text(tracks.of_targets(linked), {}, f"Targets of {tracks.store.where}", tiles=tiles))
    write_page(page, page_text(tracks, found, worst, longest, set(linked), beside.name))
    return beside


def least_consistent(targets: pl.DataFrame) -> pl.DataFrame:
    """Those with enough rows to judge, the smallest share of NIS in its band first."""
    judged = targets.filter(pl.col("compared") >= _COMPARED)
    return judged.sort(pl.col("inside") / pl.col("compared"), "target")


def _affordable(*tables: pl.DataFrame) -> list[str]:
    """Targets of the tables, in turn, as long as one page can hold their rows; at least one."""
    every = pl.concat(tables).unique(subset="target", maintain_order=True)
    few = every.filter((pl.col("rows").cum_sum() <= _ROWS) | (pl.int_range(pl.len()) == 0))
    return few["target"].to_list()


def page_text(
    tracks: Tracks, found: Survey, worst: pl.DataFrame, longest: pl.DataFrame, linked: set[str], beside: str
) -> str:
    """The page as HTML."""

    def table(title: str, rows: pl.DataFrame, note: str) -> str:
        return _table(title, rows, found.clock, note, linked, beside)

    rows = int(found.targets["rows"].sum())
    gated = int(found.targets["gated"].sum())
    lede = f"{group(found.targets.height)} targets · {group(rows)} rows · {_moment(found.begin, found.clock)} to "
    title = f"Tracks in {tracks.store.where}"
    body = (
        f'<header class="masthead"><div class="names"><h1>{escape(title)}</h1>'
        f'<p class="lede">{escape(lede + _moment(found.end, found.clock))}</p></div></header>'
        f'<main class="paper"><div class="drawings">{density_map(found)}{drawn(_over_time(found))}</div>'
        f'<div class="sheets">'
        f"{table('Least consistent', worst, f'Of the targets with at least {_COMPARED} rows that have NIS.')}"
        f"{table('Most rows', longest, 'Names lead to the tracks, as far as one page can hold them.')}</div></main>"
        f'<section class="cards">{consistency_card(found.check, gated)}{summary_cards(_said(tracks.summary))}</section>'
    )
    return plain_page(title=title, body=body, style="reproduce.css")


def _said(summary: dict[str, Any]) -> dict[str, Any]:
    """The summary of the run; many files are counted, and what was settled stands under noise and filter already."""
    files = summary.get("files")
    many = {"files": f"{len(files)} files"} if isinstance(files, list) and len(files) > 5 else {}
    return {name: value for name, value in (summary | many).items() if name != "settled"}


def _over_time(found: Survey) -> Chart:
    """How many targets have rows in each span of time."""
    whole = max(found.end - found.begin, 1e-9)
    words, unit = next((name, size) for name, size in _UNITS if whole >= 3.0 * size)
    unit = unit or 1.0
    edges = np.linspace(0.0, whole, SPANS + 1) / unit
    span = f"{whole / SPANS:.3g} s"
    return Chart(
        title=f"Targets over time, in spans of {span}",
        x=f"{words} after {_moment(found.begin, found.clock)}",
        y="targets",
        lines=[Line("", np.repeat(edges, 2)[1:-1], np.repeat(found.active, 2))],
    )


def _table(title: str, rows: pl.DataFrame, clock: bool, note: str, linked: set[str], beside: str) -> str:
    head = "".join(
        f'<th scope="col">{name}</th>'
        for name in ("target", "rows", "from", "seconds", "gated", "NIS in its 95 % band")
    )
    body = ""
    for row in rows.iter_rows(named=True):
        name = escape(row["target"])
        if row["target"] in linked:
            name = f'<a href="{escape(quote(beside))}#target={escape(quote(row["target"], safe=""))}">{name}</a>'
        share = f"{100.0 * row['inside'] / row['compared']:.1f} %" if row["compared"] else "–"
        cells = (
            group(row["rows"]),
            _moment(row["begin"], clock),
            f"{row['end'] - row['begin']:,.0f}",
            f"{100.0 * row['gated'] / row['rows']:.1f} %",
            share,
        )
        body += f'<tr><th scope="row">{name}</th>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}</tr>'
    return (
        f'<section><h3>{escape(title)}</h3><div class="sheet"><table><thead><tr>{head}</tr></thead>'
        f'<tbody>{body}</tbody></table><p class="note">{escape(note)}</p></div></section>'
    )


def _moment(seconds: float, clock: bool) -> str:
    if not clock:
        return f"{seconds:.6g} s"
    return f"{pl.Series([int(seconds * 1e6)]).cast(pl.Datetime('us'))[0]:%Y-%m-%d %H:%M} UTC"
