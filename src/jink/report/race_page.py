"""The page of `jink compare --report`: errors over time, one run, the table with intervals, how to do it again."""

from __future__ import annotations

import os
from typing import Any

from ..compare.result import AGAINST, Race
from . import race_data
from .arrays import ArrayBlock
from .race_table import ordered, remarks
from .shell import PLAN_AND_CHARTS, escape, fill, page, version, write_page

_SCRIPTS = (*PLAN_AND_CHARTS, "race_plan.js", "race_panels.js", "race.js")
_METRICS = {"position_rmse": "position RMSE, m", "prediction_rmse": "RMS prediction error, m"}
_CHOSEN = {True: "picked without regard to its result", False: "the track with most scored rows"}
_LEGEND = '<span class="key truth">truth</span> <span class="key busy">manoeuvring</span> '
_SHOWN = 10  # filters that are drawn at first


def write_race_report(race: Race, path: str | os.PathLike[str], *, command: str = "", title: str | None = None) -> None:
    """Write one HTML file that shows a race and needs no network, no server and no other file.

    command: what does it again, shown as it is. Every number is that of `race.as_dict()`; intervals are 95%.
    Errors: OSError where `path` cannot be written.
    """
    write_page(path, page_text(race, command, title or f"Filters on {os.path.basename(race.scenario)}"))


def page_text(race: Race, command: str, title: str) -> str:
    """The page as HTML."""
    block = ArrayBlock()
    charts = race_data.panels(race, block)
    names = ordered(race)
    run = race_data.run(race.example, names, block) if race.example is not None else None
    meta = {
        "clock": False,
        "series": race_data.series(race),
        "columns": race_data.columns(race),
        "bound": bool(race.bound),
        "panels": charts,
        "run": run,
        "shown": _SHOWN,
    }
    simulated = race.unit == "runs"
    body = fill(
        "race.html",
        title=escape(title),
        lede=escape(_lede(race)),
        partial="" if race.partial else " hidden",
        interrupted=escape(f"Interrupted after {race.runs:,} of {race.asked:,} {race.unit}."),
        over_time="Errors over time" if simulated else "Predictions over time",
        hint=_hint(race),
        plan="Truth and tracks" if simulated else "Tracks",
        run=escape(f"{run['name']}, {_CHOSEN[simulated]}" if run else ""),
        legend=_LEGEND if run and run["truth"] else "",
        board="board race" if run and run["plane"] else "board race single",
        metric=escape(_METRICS.get(race.compared[0], race.compared[0])),
        comparisons=_comparisons(race),
        cards="\n".join(_cards(race, command)),
        footer=escape(f"jink {version()}. Every number is computed from all {race.runs:,} {race.unit}."),
    )
    return page(title=title, body=body, scripts=_SCRIPTS, meta=meta, block=block)


def _lede(race: Race) -> str:
    parts = [race.words, f"{race.runs:,} {race.unit}", f"seed {race.seed}"]
    return " · ".join([*parts, race.seen] if race.seen else parts)


def _hint(race: Race) -> str:
    if race.unit == "runs":
        more = "Bands: ± 2 standard errors over runs. The ribbon shows where the target manoeuvres."
    else:
        more = "Curves far above the chosen filter are cut off."
    return f"Drag to zoom in time; double-click to show the whole time. {more}"


def _comparisons(race: Race) -> str:
    """Paired differences with intervals; coloured only where the interval excludes zero."""
    rows = race_data.comparisons(race)
    others = [name for name in AGAINST if any(name in row for row in rows)]
    head = "".join(f'<th scope="col">minus {escape(name)}</th>' for name in others)
    lines = []
    for row in rows:
        cells = [f'<th scope="row">{escape(row["name"])}</th>']
        for other in others:
            c = row.get(other)
            if c is None:
                cells.append('<td class="undecided">–</td>')
                continue
            verdict = "" if c.verdict == "undecided" else f" {c.verdict}"
            interval = f"<small>({c.low:+.3g} … {c.high:+.3g})</small>"
            cells.append(f'<td class="{c.verdict}">{c.difference:+.3g} {interval}{verdict}</td>')
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f'<table class="paired"><thead><tr><th></th>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table>'


def _cards(race: Race, command: str) -> list[str]:
    setup: dict[str, Any] = {"scenario": f"{race.scenario}: {race.words}"}
    if race.seen:
        setup["seen by"] = race.seen
    setup |= {"scored": f"{race.runs:,} {race.unit}, seed {race.seed}", "made by": f"jink {version()}"}
    if race.unit == "runs":
        setup["counted"] = "scans from the third on; every standard error is computed over runs"
        setup["common random numbers"] = "all filters saw the same truth and the same measurements"
    if race.bound:
        setup["PCRB"] = (
            "position {:.4g} m, velocity {:.4g} m/s: posterior Cramér–Rao bound for filters that know the "
            "manoeuvres".format(race.bound["position_rmse"], race.bound["velocity_rmse"])
        )
    again = f"<h4>Command that repeats this</h4><p><code>{escape(command)}</code></p>" if command else ""
    cards = [_card("Set-up", _pairs(setup) + again)]
    filters = []
    for name in ordered(race):
        entrant = race.entrants[name]
        said = [entrant.words]
        if entrant.fitted:
            said.append(
                "fitted on the same runs that are scored here" if entrant.in_sample else f"fitted: {entrant.fitted}"
            )
        said += [entrant.note] if entrant.note else []
        filters.append((name, "; ".join(said)))
    cards.append(_card("The filters in words", _pairs(dict(filters))))
    cards.append(
        _card(
            "Conclusions and notes",
            "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in remarks(race)[1:]) + "</ul>",
        )
    )
    return cards


def _card(title: str, content: str) -> str:
    return f'<section class="card"><h3>{escape(title)}</h3>{content}</section>'


def _pairs(values: dict[str, str]) -> str:
    rows = "".join(f'<tr><th scope="row">{escape(k)}</th><td>{escape(v)}</td></tr>' for k, v in values.items())
    return f'<table class="said"><tbody>{rows}</tbody></table>'
