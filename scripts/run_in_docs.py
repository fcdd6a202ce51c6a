"""Write the outputs of commands in docs/ anew: the text block after each mark `<!-- run: jink … -->`.

A mark that ends in ` | head -N` shows the first N lines.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
MARK = re.compile(r"(<!-- run: ([^\n]+?) -->\n```text\n)(?:.*?\n)??(```\n)", re.DOTALL)


def printed(command: str) -> str:
    """What a command prints on a terminal of 120 columns."""
    command, _, count = command.partition(" | head -")
    program, *arguments = shlex.split(command)
    done = subprocess.run(
        [str(Path(sys.executable).with_name(program)), *arguments],
        cwd=ROOT,
        env={**os.environ, "COLUMNS": "120"},
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stdout.strip().splitlines()
    return "\n".join(line.rstrip() for line in lines[: int(count) if count else None])


def main() -> None:
    """Of the pages named, or of all that have such marks."""
    for page in map(Path, sys.argv[1:]) if sys.argv[1:] else sorted((ROOT / "docs").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        if MARK.search(text):
            text = MARK.sub(lambda m: m[1] + printed(m[2]) + "\n" + m[3], text)
            page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
