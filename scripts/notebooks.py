"""Make examples/notebooks/*.ipynb from the guides in docs/; with --check say which of them are not up to date.

A Python block becomes a cell, a command that reads the samples a cell that begins with "!", all else text. What a page
says that a command prints is the output of its cell.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "examples" / "notebooks"
PIECE = re.compile(
    r"^```python\n(?P<python>.*?)^```\n(?:\s*<!-- printed -->\n```text\n(?P<printed>.*?)```\n)?"
    r"|(?P<commands>(?:^    jink [^\n]*\n)+)(?:\n<!-- run: [^\n]*\n```text\n(?P<output>.*?)```\n)?",
    re.DOTALL | re.MULTILINE,
)
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)]+)\)")
BEGIN = """import os

if not os.path.isdir("examples"):  # the folder of the repository, where the samples are
    os.chdir("../..")
"""


def cells(page: Path) -> list[dict[str, object]]:
    """The cells of a page, in its order."""
    text = page.read_text(encoding="utf-8")
    out: list[dict[str, object]] = []
    last = 0
    for piece in PIECE.finditer(text):
        prose(out, text[last : piece.start()], page)
        last = piece.end()
        if len(out) == 1:
            code(out, BEGIN)
        if piece["python"]:
            code(out, piece["python"], piece["printed"])
        else:
            commands = re.sub(r"^    ", "!", re.sub(r"  +#.*$", "", piece["commands"], flags=re.MULTILINE), flags=re.M)
            code(out, commands, piece["output"])
    prose(out, text[last:], page)
    return [cell | {"id": f"cell-{k}"} for k, cell in enumerate(out)]


def prose(out: list[dict[str, object]], text: str, page: Path) -> None:
    """A cell of text whose links lead from the notebook's folder."""
    if text.strip():
        there = LINK.sub(lambda link: f"](../../{page.parent.relative_to(ROOT)}/{link[1]})", text.strip())
        out.append({"cell_type": "markdown", "metadata": {}, "source": there.splitlines(keepends=True)})


def code(out: list[dict[str, object]], text: str, printed: str | None = None) -> None:
    """A cell of code with what it prints, where the page says that."""
    shown = [{"name": "stdout", "output_type": "stream", "text": printed.splitlines(keepends=True)}] if printed else []
    source = text.strip().splitlines(keepends=True)
    out.append({"cell_type": "code", "metadata": {}, "execution_count": None, "outputs": shown, "source": source})


def notebook(page: Path) -> str:
    """The file of a page's notebook."""
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {
        "cells": cells(page),
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(whole, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def main() -> int:
    """Write all of them, or check."""
    pages = sorted((ROOT / "docs").glob("guide-*.md"))
    wanted = {FOLDER / f"{page.stem.removeprefix('guide-')}.ipynb": notebook(page) for page in pages}
    known = set(FOLDER.glob("*.ipynb"))
    stale = [path for path, text in wanted.items() if path not in known or path.read_text(encoding="utf-8") != text]
    if "--check" in sys.argv:
        out_of_date = [*stale, *(known - set(wanted))]
        print("\n".join(f"{path.name} is out of date: python scripts/notebooks.py" for path in out_of_date))
        return int(bool(out_of_date))
    FOLDER.mkdir(parents=True, exist_ok=True)
    for path in known - set(wanted):
        path.unlink()
    for path in stale:
        path.write_text(wanted[path], encoding="utf-8")
    print(f"{len(wanted)} notebooks, {sum(len(text) for text in wanted.values()) / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
