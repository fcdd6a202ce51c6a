"""Write the tables of docs/reproduce.md anew: what `jink reproduce all` prints, each between its two marks."""

import io
import re
import sys
from pathlib import Path

from rich.console import Console

from jink.papers import PAPERS, run
from jink.report.papers_table import show

PAGE = Path(__file__).parents[1] / "docs" / "reproduce.md"


def main() -> None:
    """Measure every paper (or those named) with the default runs and seed 0, and put the tables into the page."""
    page = PAGE.read_text(encoding="utf-8")
    for name in sys.argv[1:] or PAPERS:
        printed = io.StringIO()
        show(run(PAPERS[name]), Console(file=printed, width=140, highlight=False))
        text = "\n".join(line.rstrip() for line in printed.getvalue().splitlines())
        marks = rf"(<!-- {name} -->\n```text\n).*?(\n```\n<!-- end -->)"
        page, found = re.subn(marks, lambda m, text=text: m[1] + text + m[2], page, flags=re.DOTALL)
        if found != 1:
            raise SystemExit(f"{PAGE}: expected one place for {name}, found {found}")
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
