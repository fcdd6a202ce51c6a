"""A fit as tables for people: parameters with intervals, the race on held-out data, verdicts and warnings."""

from __future__ import annotations

from typing import Any

from .fit_result import Fit
from .race.table import show as show_race


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
            row["parameter"], number(row["before"]), number(row["after"]), interval(row["low"], row["high"])
        )
    console.print(table)
    console.print()
    show_race(fit.race)
    console.print()
    console.print(Text(verdict(fit), style="bold"))
    for line in fit.verdicts():
        console.print(Text(f"  {line}"))
    for line in fit.warnings:
        console.print(Text(f"warning: {line}", style="yellow"))


def heading(fit: Fit) -> str:
    """What was fitted on what, and how far the figure came."""
    return (
        f"{fit.name}, fitted on {fit.training}\n{fit.objective} {fit.before:.4f} → {fit.after:.4f} "
        f"(smaller is better), {fit.evaluations} evaluations in {fit.seconds:.1f} s"
    )


def verdict(fit: Fit) -> str:
    """One sentence."""
    return "On held-out data: a gain." if fit.gain else "On held-out data: no gain."


def number(value: Any) -> str:
    return f"{value:.4g}"


def interval(low: float | None, high: float | None) -> str:
    return "unknown" if low is None or high is None else f"{low:.3g} … {high:.3g}"
