"""What each stage of `jink track` took, as a table on standard error."""

from __future__ import annotations

from collections.abc import Mapping

from .terminal import ENDLESS, print_table


def show_timings(figures: Mapping[str, Mapping[str, float]], rows: int) -> None:
    """Print wall and processor seconds of each stage, and the latter for each row."""
    from rich.console import Console

    print_table(Console(stderr=True, highlight=False, width=ENDLESS), *lines(figures, rows), space=2)


def lines(figures: Mapping[str, Mapping[str, float]], rows: int) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The table's head and its rows; the last is all stages together."""
    total = {kind: sum(each[kind] for each in figures.values()) for kind in ("wall", "cpu")}
    cells = [
        (name, f"{each['wall']:.2f}", f"{each['cpu']:.2f}", f"{1e6 * each['cpu'] / max(rows, 1):.2f}")
        for name, each in [*figures.items(), ("together", total)]
    ]
    return ("stage", "s", "s of CPU", "µs of CPU a row"), cells
