"""What was learned, as tables and sentences."""

from __future__ import annotations

from ..filters.aided import Aided
from ..learn.learning import BASE, CONSTANTS, NAMED, Learned
from ..models.fuzzy import FuzzyRules
from .race_table import show as show_race
from .terminal import print_line, standard_output

# lines of rules that a terminal shows
FEW = 15


def show(learned: Learned) -> None:
    """Print it on standard output, in colour if the terminal has it."""
    console = standard_output()
    print_line(console, heading(learned), "bold")
    lines = rules(learned)
    for line in lines if len(lines) <= FEW else (each for each in lines if each.startswith("mode")):
        print_line(console, f"  {line}")
    if len(lines) > FEW:
        print_line(console, "  --report shows all rules in words", "dim")
    console.print()
    show_race(learned.race)
    console.print()
    print_line(console, learned.verdict(), "bold")
    # the race above has said it of the others
    for name in (name for name in learned.verdicts() if name in (BASE, CONSTANTS, NAMED)):
        print_line(console, f"  against {name}: {learned.verdicts()[name]}")
    for line in learned.warnings:
        print_line(console, f"warning: {line}", "yellow")


def heading(learned: Learned) -> str:
    """Which filter was learned from which data, and how long the processor's cores took together."""
    return f"{learned.name}, learned on {learned.training}, in {learned.cpu_seconds:.1f} s of CPU"


def rules(learned: Learned) -> list[str]:
    """The fuzzy rules of each mode as sentences; empty if there are none."""
    lines = []
    inner = learned.filter.filter_ if isinstance(learned.filter, Aided) else learned.filter
    for k, motion in enumerate(inner.motions, start=1):
        found, across = getattr(motion, "rules", None), getattr(motion, "across", None)
        for where, of in (("" if across is None else " along the track", found), (" across the track", across)):
            if isinstance(of, FuzzyRules):
                lines.append(f"mode {k}, {len(of)} rule{'s' if len(of) > 1 else ''}{where}:")
                lines += [f"  {line}" for line in of.describe()]
    return lines
