"""What was learned, as tables and sentences for people."""

from __future__ import annotations

from ..filters.aided import Aided
from ..learn.learning import BASE, NAMED, Learned
from .race_table import show as show_race

FEW = 15  # lines of rules that a terminal shows


def show(learned: Learned) -> None:
    """Print it on standard output, in colour where the terminal has it."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    console.print(Text(heading(learned), style="bold"))
    lines = rules(learned)
    for line in lines if len(lines) <= FEW else (each for each in lines if each.startswith("mode")):
        console.print(Text(f"  {line}"))
    if len(lines) > FEW:
        console.print(Text("  all of them in words: --report", style="dim"))
    console.print()
    show_race(learned.race)
    console.print()
    console.print(Text(learned.verdict(), style="bold"))
    for name, said in learned.verdicts().items():
        if name not in (BASE, NAMED):  # of the others the race has spoken
            continue
        console.print(Text(f"  against {name}: {said}"))
    for line in learned.warnings:
        console.print(Text(f"warning: {line}", style="yellow"))


def heading(learned: Learned) -> str:
    """What was learned on what."""
    return f"{learned.name}, learned on {learned.training}, in {learned.seconds:.1f} s"


def rules(learned: Learned) -> list[str]:
    """The fuzzy rules of each mode as sentences; nothing where there are none."""
    lines = []
    inner = learned.filter.filter_ if isinstance(learned.filter, Aided) else learned.filter
    for k, motion in enumerate(inner.motions, start=1):
        found = getattr(motion, "rules", None)
        if found is not None:
            lines.append(f"mode {k}, {len(found)} rule{'s' if len(found) > 1 else ''}:")
            lines += [f"  {line}" for line in found.describe()]
    return lines
