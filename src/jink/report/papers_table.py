"""Published and measured figures side by side, as tables."""

from __future__ import annotations

import math
from typing import Any

from ..compare.result import Race
from ..frozen import frozen
from ..papers.paper import BASELINES, Experiment, Metric, Row, median
from ..papers.run import Outcome
from .terminal import print_line, print_table, standard_output

# filters that jink adds to the paper's own
BESIDE = (*BASELINES, "clairvoyant", "imm-cv-ca")


def show(outcome: Outcome, console: Any = None) -> None:
    """Print every table, then what the paper leaves open; on standard output, unless a rich console is given."""
    console = console or standard_output()
    paper = outcome.paper
    print_line(console, f"{paper.name}: {paper.source}", "bold")
    what = "measured ± standard error; dim: baselines that the paper leaves out"
    print_line(console, f"{outcome.runs:,} runs, seed {outcome.seed}; {what}")
    for sheet in sheets(outcome):
        print_line(console, f"\n{sheet.title}", "bold")
        _print_sheet(console, sheet)
        for line in sheet.notes:
            print_line(console, line, "dim")
    for title, said in (
        ("What the paper leaves open, and the reading taken", paper.readings),
        ("Remarks", paper.remarks),
    ):
        if said:
            print_line(console, f"\n{title}", "bold")
            for line in said:
                print_line(console, f"• {line}")
    if outcome.partial:
        print_line(console, "PARTIAL: interrupted before all runs were done", "bold red")


@frozen
class Line:
    """A filter's figures by metric; beside: jink added it to the paper's own."""

    label: str
    beside: bool
    words: str
    rows: dict[str, Row]


@frozen
class Sheet:
    """One table: metrics, each with whether the paper has a figure of any filter; lines; footnotes."""

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
            if name in experiment.filters and (note := getattr(race.entrants.get(member), "note", "")):
                notes.append(f"{name}: {note}")
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


def _print_sheet(console: Any, sheet: Sheet) -> None:
    """A published figure stays beside the measured one, however narrow the terminal is."""
    head, together = ["filter"], []
    for metric, known in sheet.columns:
        names = ["published", metric.words] if known else [metric.words]
        together.append(list(range(len(head), len(head) + len(names))))
        head += names
    rows = []
    for line in sheet.lines:
        cells = [line.label]
        for metric, known in sheet.columns:
            row = line.rows.get(metric.name)
            cells += [published(row), measured(row)] if known else [measured(row)]
        rows.append(cells)
    styles = ["dim" if line.beside else "" for line in sheet.lines]
    print_table(console, head, rows, styles, space=2, together=together)
