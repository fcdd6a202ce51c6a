"""Write what commands and examples print into README.md and docs/ anew, or check it with --check.

`<!-- run: jink … -->` stands above the text block that the command prints; ` | head -N` at its end keeps the first N
lines. `<!-- printed -->` stands above what the Python block before it prints. Everything runs in an empty folder with
examples/ in it. Times taken (those of commands, fits and filters, the last column of a race) and sizes of files do not
count as differences.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
COMMAND = re.compile(r"(<!-- run: ([^\n]+?) -->\n```text\n)(.*?\n)??(```\n)", re.DOTALL)
EXAMPLE = re.compile(
    r"^```python\n(.*?)^```\n(?:(\s*<!-- printed -->\n```text\n)(.*?)(```\n))?", re.DOTALL | re.MULTILINE
)
VARIES = re.compile(
    r"\([\d.]+ [kMG]?B\)|^Took .*|(?<=% ) *\d+\.\d\d$| +(µs|–)$|in [\d.]+ s(?= of CPU$|;|$)", re.MULTILINE
)


def printed(command: str, folder: Path) -> str:
    """What a command prints on a terminal of 120 columns; jink and python are those of this environment."""
    command, _, count = command.partition(" | head -")
    program, *arguments = shlex.split(command)
    start = [sys.executable, "-m", "jink"] if program == "jink" else [sys.executable]
    done = subprocess.run([*start, *arguments], cwd=folder, capture_output=True, text=True, check=True)
    lines = done.stdout.strip("\n").splitlines()
    return "\n".join(line.rstrip() for line in lines[: int(count) if count else None]) + "\n"


def examples(text: str, folder: Path) -> str:
    """The page with what its marked Python blocks print; all of its blocks run, in one namespace."""
    names: dict[str, object] = {"__name__": "example"}

    def run(block: re.Match[str]) -> str:
        out = io.StringIO()
        with contextlib.chdir(folder), contextlib.redirect_stdout(out):
            exec(compile(block[1], "example", "exec"), names)
        return f"```python\n{block[1]}```\n" + (block[2] + out.getvalue() + block[4] if block[2] else "")

    return EXAMPLE.sub(run, text) if "<!-- printed -->" in text else text


def anew(page: Path) -> str:
    """The page with every output as it is printed now."""
    with tempfile.TemporaryDirectory() as name:
        folder = ROOT if "python -m benchmarks" in page.read_text(encoding="utf-8") else Path(name)
        if folder != ROOT:
            (folder / "examples").symlink_to(ROOT / "examples")
        text = COMMAND.sub(lambda m: m[1] + printed(m[2], folder) + m[4], page.read_text(encoding="utf-8"))
        return examples(text, folder)


def main() -> int:
    """Of the pages named, or of all that have such marks."""
    os.environ |= {"COLUMNS": "120", "POLARS_TABLE_WIDTH": "120"}
    named = [Path(name) for name in sys.argv[1:] if name != "--check"]
    differ = 0
    for page in named or [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        before = page.read_text(encoding="utf-8")
        now = anew(page)
        if "--check" not in sys.argv:
            page.write_text(now, encoding="utf-8")
        elif VARIES.sub("", now) != VARIES.sub("", before):
            print(f"{page} is out of date: python scripts/run_in_docs.py {page}")
            differ += 1
    return int(differ > 0)


if __name__ == "__main__":
    sys.exit(main())
