"""Write the tables of docs/reading.md anew from what the code knows: formats, layouts, names of columns, units, days.

With --check nothing is written, and the exit status is 1 if the page is not up to date.
"""

import re
import sys
from pathlib import Path

from jink.io.formats.registry import FORMATS
from jink.io.layouts import LAYOUTS
from jink.io.numeric_times import DAYS
from jink.io.roles import CUSTOMARY_UNIT, ROLES
from jink.io.units import ANGLE, LENGTH, SPEED, TIME

PAGE = Path(__file__).parents[1] / "docs" / "reading.md"
UNITS = {"lengths": LENGTH, "angles": ANGLE, "speeds": SPEED, "times": TIME}


def table(head: list[str], rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def names(words: tuple[str, ...] | list[str]) -> str:
    """Names in code type."""
    return ", ".join(f"`{word}`" for word in words)


def formats() -> str:
    """What one row is, and where its columns, times and noise come from."""
    rows = [[known.title, known.row, known.columns, known.time, known.noise] for known in FORMATS]
    return table(["format", "a row is", "columns", "time", "noise"], rows)


def layouts() -> str:
    """Tables that are known by their header."""
    rows = []
    for layout in LAYOUTS:
        told = sorted(layout.names) + ([f"one of {' '.join(sorted(layout.some))}"] if layout.some else [])
        rows.append([layout.title, names(told), layout.words])
    return table(["table", "known by its columns", "what that says"], rows)


def roles() -> str:
    """The names of every role."""
    return table(
        ["role", "names, the preferred first"], [[f"`{role}`", names(known)] for role, (_, known) in ROLES.items()]
    )


def units() -> str:
    """Endings of names, and names with a unit by custom."""
    rows = [[quantity, names(list(known))] for quantity, known in UNITS.items()]
    custom = {}
    for name, unit in CUSTOMARY_UNIT.items():
        custom.setdefault(f"{unit:.7g}", []).append(name)
    rows += [[f"by custom: {unit} SI units", names(known)] for unit, known in custom.items()]
    return table(["quantity", "endings"], rows)


def days() -> str:
    """Day numbers that are recognised."""
    rows = [[words, f"{least:,.1f} to {most:,.1f}"] for words, (least, most, _) in DAYS.items()]
    return table(["days", "numbers that are taken for it"], rows)


def main() -> None:
    """Put every table between its two marks."""
    before = page = PAGE.read_text(encoding="utf-8")
    for name, made in (("formats", formats), ("layouts", layouts), ("roles", roles), ("units", units), ("days", days)):
        marks = rf"(<!-- {name} -->\n).*?(\n<!-- end -->)"
        text = made()
        page, found = re.subn(marks, lambda m, text=text: m[1] + text + m[2], page, flags=re.DOTALL)
        if found != 1:
            raise SystemExit(f"{PAGE}: expected one place for {name}, found {found}")
    if "--check" in sys.argv:
        raise SystemExit(page != before)
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
