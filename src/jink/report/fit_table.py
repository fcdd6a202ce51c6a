"""A fit as tables for people: parameters with intervals, the race on held-out data, verdicts and warnings."""

from __future__ import annotations

import math
from typing import Any

from ..fit.result import FITTED, START, Fit
from ..metrics import Figure
from .race_table import show as show_race

LONG = 42  # letters of a parameter's name that fit beside its figures in 80 columns


def show(fit: Fit) -> None:
    """Print a fit on standard output, in colour where the terminal has it."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    console.print(Text(heading(fit), style="bold"))
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="bold", pad_edge=False)
    table.add_column("parameter", overflow="fold")
    for column in ("before", "after", "95% interval"):
        table.add_column(column, justify="right", no_wrap=True)
    for row in fit.table():
        table.add_row(
            broken(row["parameter"]),
            number(row["before"]),
            number(row["after"]),
            interval(row["low"], row["high"]),
        )
    console.print(table)
    console.print()
    show_race(fit.race)
    console.print()
    if parts := part_rows(fit):
        table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold", pad_edge=False)
        table.add_column("NIS inside its 95% band")
        for column in ("rows", "before", "fitted"):
            table.add_column(column, justify="right", no_wrap=True)
        for row in parts:
            table.add_row(*row)
        console.print(table)
        console.print()
    console.print(Text(verdict(fit), style="bold"))
    for line in fit.verdicts():
        console.print(Text(f"  {line}"))
    for line in fit.warnings:
        console.print(Text(f"warning: {line}", style="yellow"))


def heading(fit: Fit) -> str:
    """What was fitted on what, and how far the figure came."""
    kind = f" for {fit.record['kind']}" if fit.name == "imm" else ""
    return (
        f"{fit.name}{kind}, fitted on {fit.training}\n{fit.objective} {fit.before:.4f} → {fit.after:.4f} "
        f"(smaller is better), {fit.evaluations} evaluations in {fit.seconds:.1f} s"
    )


def part_rows(fit: Fit) -> list[list[str]]:
    """For each part of held-out tracks: its name, rows, and the share of NIS inside the band before and after."""
    before, after = ({s.part: s for s in fit.parts.get(name, ())} for name in (START, FITTED))
    return [
        [
            name,
            f"{s.rows:,}",
            *(share(each[name].inside) if name in each else "–" for each in (before, after)),
        ]
        for name, s in after.items()
    ]


def share(figure: Figure) -> str:
    """In percent, with its standard error."""
    error = f" ±{100 * figure.se:.1f}" if math.isfinite(figure.se) else ""
    return f"{100 * figure.value:.1f}{error} %"


def verdict(fit: Fit) -> str:
    """One sentence."""
    return f"On held-out data: {'a' if fit.gain else 'no'} gain over the filter as it was."


def broken(name: str) -> str:
    """A long name on two lines, parted at its last dot."""
    first, dot, last = name.rpartition(".")
    return f"{first}\n  {dot}{last}" if len(name) > LONG and dot else name


def number(value: Any) -> str:
    return f"{value:.4g}"


def interval(low: float | None, high: float | None) -> str:
    return "unknown" if low is None or high is None else f"{low:.3g} … {high:.3g}"
