"""Every Python example in the documentation runs, file by file, from top to bottom."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)#]+)")

OTHERS = ("filterpy", "stonesoup")  # packages that jink[interop] brings


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    text = page.read_text(encoding="utf-8")
    names: dict[str, object] = {"__name__": "example"}
    for match in BLOCK.finditer(text):
        line = text[: match.start()].count("\n") + 2
        code = compile("\n" * (line - 1) + match.group(1), str(page), "exec")
        try:
            exec(code, names)
        except ModuleNotFoundError as error:
            if error.name not in OTHERS:
                raise
            pytest.skip(f"{error.name} is not installed; pip install 'jink[interop]'")


def test_the_tables_of_what_jink_reads_are_those_of_the_code():
    done = subprocess.run([sys.executable, str(ROOT / "scripts" / "reading_docs.py"), "--check"], check=False)
    assert done.returncode == 0, "run scripts/reading_docs.py"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    missing = [link for link in LINK.findall(page.read_text(encoding="utf-8")) if not (page.parent / link).exists()]
    assert not missing
