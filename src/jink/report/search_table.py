"""A search for people: the candidates from best to worst, why the best one, and its fit."""

from __future__ import annotations

import math
from typing import Any

from ..fit.result import UNITS, WORDS
from ..fit.search import Ranked, Search
from .fit_table import show as show_fit


def show(search: Search) -> None:
    """Print a search on standard output, then the best candidate's fit."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    head, rows = table(search)
    drawn = Table(box=None, padding=(0, 1, 0, 0), header_style="bold", pad_edge=False)
    for k, column in enumerate(head):
        drawn.add_column(column, justify="left" if k in (0, len(head) - 1) else "right", no_wrap=k == 0)
    for row in rows:
        drawn.add_row(*row)
    console.print(Text(heading(search), style="bold"))
    console.print(drawn)
    for name, why in search.left.items():
        console.print(Text(f"without {name}: {why}", style="dim"))
    console.print()
    for line in search.explanation:
        console.print(Text(line))
    console.print()
    show_fit(search.fit)


def heading(search: Search) -> str:
    """What was searched for how long."""
    cut = ", some cut short" if search.partial else ""
    return f"{len(search.ranked)} candidates fitted on {search.fit.training} in {search.seconds:.0f} s{cut}; held-out figures:"


def table(search: Search) -> tuple[list[str], list[list[str]]]:
    """Columns' heads and rows of text."""
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
