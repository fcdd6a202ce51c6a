"""A fit as tables: parameters with intervals, the race on held-out data, verdicts and warnings."""

from __future__ import annotations

import math
from typing import Any

from ..fit.result import FITTED, START, Fit
from ..metrics import Figure
from .race_table import show as show_race
from .terminal import print_line, print_table, standard_output

# letters of a parameter's name that fit beside its figures in 80 columns
LONG = 42


def show(fit: Fit) -> None:
    """Print a fit on standard output, in colour if the terminal has it."""
    console = standard_output()
    print_line(console, heading(fit), "bold")
    rows = [
        [broken(row["parameter"]), number(row["before"]), number(row["after"]), interval(row["low"], row["high"])]
        for row in fit.table()
    ]
    print_table(console, ["parameter", "before", "after", "95% interval"], rows)
    console.print()
    show_race(fit.race)
    console.print()
    if parts := part_rows(fit):
        print_table(console, ["NIS inside its 95% band", "rows", "before", "fitted"], parts, space=2)
        console.print()
    print_line(console, verdict(fit), "bold")
    for line in fit.verdicts():
        print_line(console, f"  {line}")
    for line in fit.warnings:
        print_line(console, f"warning: {line}", "yellow")


def heading(fit: Fit) -> str:
    """What was fitted on which data, and the objective before and after."""
    kind = f" for {fit.record['kind']}" if fit.name == "imm" else ""
    return (
        f"{fit.name}{kind}, fitted on {fit.training}\n{fit.objective} {fit.before:.4f} → {fit.after:.4f} "
        f"(smaller is better), {fit.evaluations} evaluations in {fit.seconds:.1f} s"
    )


def part_rows(fit: Fit) -> list[list[str]]:
    """For each part of the held-out tracks: name, rows, and the share of NIS inside the band before and after."""
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
    """A long name on two lines, split at its last dot."""
    first, dot, last = name.rpartition(".")
    return f"{first}\n  {dot}{last}" if len(name) > LONG and dot else name


def number(value: Any) -> str:
    return f"{value:.4g}"


def interval(low: float | None, high: float | None) -> str:
    return "unknown" if low is None or high is None else f"{low:.3g} … {high:.3g}"
