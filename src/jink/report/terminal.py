"""Tables and sentences in a terminal or a file: no cell is ever cut, whatever the width."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Collection, Iterator, Sequence
from typing import Any, TextIO

from ..io.printable import printable

# columns of a file or a pipe: more than any table needs, so that its lines are as long as they have to be
ENDLESS = 100_000
BLANKS = re.compile(" +$", re.MULTILINE)


def standard_output() -> Any:
    """The rich console that all tables go to: as wide as the terminal or as COLUMNS says, else as wide as needed."""
    from rich.console import Console

    if sys.stdout.isatty():
        return Console(highlight=False)
    # a file as far as a console is concerned
    file: Any = WithoutBlanks(sys.stdout)
    return Console(highlight=False, width=None if "COLUMNS" in os.environ else ENDLESS, file=file)


class WithoutBlanks:
    """A text file that leaves out blanks at the ends of lines, with which tables fill their last column."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def write(self, text: str) -> int:
        """Write whole lines."""
        return self._file.write(BLANKS.sub("", text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def print_line(console: Any, text: str = "", style: str = "") -> None:
    """A sentence as it stands: nothing in it is read as markup."""
    from rich.text import Text

    console.print(Text(printable(text), style=style))


def print_table(
    console: Any,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    styles: Sequence[str] = (),
    *,
    left: Collection[int] = (0,),
    space: int = 1,
    together: Sequence[Sequence[int]] | None = None,
) -> None:
    """A table, one style for each row; the columns in `left` are aligned left, `space` blanks are between columns.

    A table that is too wide folds into several, each with the first column; columns `together` stay in one of them.
    If even one column is too wide, the text in its cells folds.
    """
    from rich.cells import cell_len
    from rich.table import Table
    from rich.text import Text

    head, rows = [printable(name) for name in head], [[printable(cell) for cell in row] for row in rows]
    columns = list(zip(head, *rows, strict=True))
    widths = [max(cell_len(line) for cell in column for line in cell.split("\n")) for column in columns]
    groups = together or [[k] for k in range(1, len(head))]
    for number, shown in enumerate(folded(widths, groups, space, console.width)):
        if number:
            console.print()
        table = Table(box=None, padding=(0, space, 0, 0), header_style="bold", pad_edge=False, show_header=any(head))
        for k in shown:
            table.add_column(Text(head[k]), justify="left" if k in left else "right", overflow="fold")
        for row, style in zip(rows, styles or [""] * len(rows), strict=True):
            table.add_row(*(Text(row[k]) for k in shown), style=style)
        console.print(table)


def folded(widths: Sequence[int], groups: Sequence[Sequence[int]], space: int, room: int) -> Iterator[list[int]]:
    """The columns of each part of a table: the first one, and as many groups of others as there is room for."""
    shown, used = [0], widths[0]
    for group in groups:
        width = sum(space + widths[k] for k in group)
        if used + width > room and len(shown) > 1:
            yield shown
            shown, used = [0], widths[0]
        shown, used = [*shown, *group], used + width
    yield shown
