"""Published beside measured, as tables for people."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..compare.result import Race
from ..papers.paper import BASELINES, Experiment, Metric, Row, median
from ..papers.run import Outcome

BESIDE = (*BASELINES, "clairvoyant", "imm-cv-ca")  # of the race, not of the paper


def show(outcome: Outcome, console: Any = None) -> None:
    """Print every table, then what the paper leaves open; on standard output, unless a rich console is given."""
    from rich.console import Console
    from rich.text import Text

    console = console or Console(highlight=False)
    paper = outcome.paper
    console.print(Text(f"{paper.name}: {paper.source}", style="bold"))
    console.print(
        f"{outcome.runs:,} runs, seed {outcome.seed}; measured ± standard error; dim: baselines that the paper leaves out"
    )
    for sheet in sheets(outcome):
        console.print(Text(f"\n{sheet.title}", style="bold"))
        console.print(_table(sheet))
        for line in sheet.notes:
            console.print(Text(line, style="dim"))
    for title, said in (
        ("What the paper leaves open, and the reading taken", paper.readings),
        ("To be said of it", paper.remarks),
    ):
        if said:
            console.print(Text(f"\n{title}", style="bold"))
            for line in said:
                console.print(Text(f"• {line}"))
    if outcome.partial:
        console.print(Text("PARTIAL: interrupted before all runs were done", style="bold red"))


@dataclass(frozen=True)
class Line:
    """A filter's figures by metric; beside: it is one of the race's own, not of the paper."""

    label: str
    beside: bool
    words: str
    rows: dict[str, Row]


@dataclass(frozen=True)
class Sheet:
    """One table: metrics, each with whether the paper gives a figure for any filter; lines; footnotes."""

    title: str
    columns: list[tuple[Metric, bool]]
    lines: list[Line]
    notes: list[str]


def sheets(outcome: Outcome) -> list[Sheet]:
    """A table for every experiment, or for every group of them."""
    groups: dict[str, list[Experiment]] = {}
    for experiment in outcome.experiments:
        groups.setdefault(experiment.group or f"{experiment.name}: {experiment.words}", []).append(experiment)
    return [_sheet(outcome, title, members) for title, members in groups.items()]


def _sheet(outcome: Outcome, title: str, members: list[Experiment]) -> Sheet:
    lines, notes = [], []
    for experiment in members:
        race = outcome.races[experiment.name]
        found: dict[str, dict[str, Row]] = {}
        shown: list[str] = []
        for row in outcome.of(experiment):
            found.setdefault(row.filter, {})[row.metric] = row
        for name, rows in found.items():
            label = f"{name}: {experiment.name}" if experiment.group else name
            member = median(experiment, race, name, experiment.metrics[0])[0]
            seeds = sum(each in race.tallies for each in experiment.members(name))
            words = race.entrants[member].words if member in race.entrants else "not part of this version"
            if seeds > 1:
                label, words = f"{label} (median of {seeds})", f"{words}: the median of {seeds} seeds"
            lines.append(Line(label + marks(race, member), name in BESIDE, words, rows))
            shown.append(member)
        notes += footnotes(race, shown)
    columns = []
    for metric in members[0].metrics:
        mine = [line.rows[metric.name] for line in lines if metric.name in line.rows]
        if mine:
            columns.append((metric, any(row.published is not None for row in mine)))
    return Sheet(title, columns, lines, list(dict.fromkeys(notes)))


def marks(race: Race, name: str) -> str:
    """* fitted on other runs of this scenario; ! worse than the raw measurements."""
    if name not in race.tallies:
        return ""
    return (" *" if race.entrants[name].fitted else "") + (" !" if race.worse_than_raw(name) else "")


def measured(row: Row | None) -> str:
    """A value with its standard error, to the digits that the error leaves."""
    if row is None or row.measured is None:
        return "–"
    if not row.se:
        return f"{row.measured:.4g}"
    digits = min(max(1 - math.floor(math.log10(row.se)), 0), 6)
    return f"{row.measured:.{digits}f} ±{row.se:.{digits}f}"


def published(row: Row | None) -> str:
    """A paper's figure as it stands there."""
    return "" if row is None or row.published is None else f"{row.published:g}"


def footnotes(race: Race, names: list[str]) -> list[str]:
    """What the marks of these filters mean, where there are any; who could not take part."""
    used = "".join(marks(race, name) for name in names)
    said = ["* parameters fitted on other runs of this scenario"] if "*" in used else []
    if "!" in used:
        said.append("! worse than not filtering")
    missing: dict[tuple[str, str], int] = {}
    for name, why in race.skipped.items():
        key = name.partition(" #")[0], why
        missing[key] = missing.get(key, 0) + 1
    seeds = {count: f" ({count} seeds)" if count > 1 else "" for count in missing.values()}
    return said + [f"without {name}{seeds[count]}: {why}" for (name, why), count in missing.items()]


def _table(sheet: Sheet) -> Any:
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold", pad_edge=False)
    table.add_column("filter", no_wrap=True)
    for metric, known in sheet.columns:
        if known:
            table.add_column("published", justify="right", no_wrap=True)
        table.add_column(metric.words, justify="right", no_wrap=True)
    for line in sheet.lines:
        cells = []
        for metric, known in sheet.columns:
            row = line.rows.get(metric.name)
            cells += [published(row), measured(row)] if known else [measured(row)]
        table.add_row(line.label, *cells, style="dim" if line.beside else "")
    return table
