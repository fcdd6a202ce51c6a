"""A search as tables: the candidates from best to worst, why the best one is the best, and its fit."""

from __future__ import annotations

import math
from typing import Any

from ..fit.result import UNITS, WORDS
from ..fit.search import Ranked, Search
from .fit_table import show as show_fit
from .terminal import print_line, print_table, standard_output


def show(search: Search) -> None:
    """Print a search on standard output, then the best candidate's fit."""
    console = standard_output()
    head, rows = table(search)
    print_line(console, heading(search), "bold")
    print_table(console, head, rows, left=(0, len(head) - 1))
    for name, why in search.left.items():
        print_line(console, f"without {name}: {why}", "dim")
    console.print()
    for line in search.explanation:
        print_line(console, line)
    console.print()
    show_fit(search.fit)


def heading(search: Search) -> str:
    """How many candidates were fitted on which data, and how long it took."""
    cut = ", some cut short" if search.partial else ""
    what = f"{len(search.ranked)} candidates fitted on {search.fit.training}"
    return f"{what} in {search.seconds:.0f} s{cut}; held-out figures:"


def table(search: Search) -> tuple[list[str], list[list[str]]]:
    """The heads of the columns, and the rows as text."""
    metrics = list(search.ranked[0].figures)
    head = ["filter", "parameters", *(f"{WORDS[m]}{UNITS[m]}" for m in metrics)]
    head += [f"behind the best{UNITS[m]}" for m in metrics] + [""]
    rows = []
    for ranked in search.ranked:
        figures = [f"{ranked.figures[m]:.4g}" if math.isfinite(ranked.figures[m]) else "–" for m in metrics]
        rows.append(
            [
                ranked.name,
                str(ranked.parameters),
                *figures,
                *(_behind(ranked, m) for m in metrics),
                remark(ranked),
            ]
        )
    return head, rows


def _behind(ranked: Ranked, metric: str) -> str:
    c: Any = ranked.behind.get(metric)
    return "" if c is None else f"{c.low:+.3g} … {c.high:+.3g}"


def remark(ranked: Ranked) -> str:
    """What the figures alone do not say."""
    said = ["cut short"] if ranked.partial else []
    if ranked.behind and not ranked.worse:
        said.insert(0, "not told apart")
    return "best" + "".join(f", {s}" for s in said) if not ranked.behind else ", ".join(said)
