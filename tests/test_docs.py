"""Every Python example in the documentation runs, file by file, from top to bottom."""

import contextlib
import importlib
import re
import shlex
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

import jink
from jink.cli.main import app

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


def test_names_of_the_library_are_there():
    def there(name: str) -> bool:
        known: object = jink
        for part in name.split(".")[1:]:
            if not hasattr(known, part) and isinstance(known, ModuleType):
                with contextlib.suppress(ImportError):
                    importlib.import_module(f"{known.__name__}.{part}")
            known = getattr(known, part, None)
            if known is None:
                return False
        return True

    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "src").rglob("*.py")]
    names = {name for page in pages for name in re.findall(r"`~?(jink(?:\.\w+)+)`", page.read_text(encoding="utf-8"))}
    assert len(names) > 50
    assert [name for name in sorted(names) if not there(name)] == []


def commands(page: Path) -> list[str]:
    """What a page tells to type: indented lines, and code in tables, that call jink; without those with an output."""
    text = page.read_text(encoding="utf-8")
    lines = re.findall(r"^    (jink .*)$", text, re.MULTILINE)
    found = lines + re.findall(r"(?<=[|d] )`(jink [^`|]*)`", text)
    return [command for command in found if f"run: {command}" not in text]


def test_the_readmes_commands_run_as_printed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    found = commands(ROOT / "README.md")
    assert len(found) >= 10 and any("compare" in command for command in found)
    for command in found:
        if "<" in command:
            told = f"{sys.executable} -m {command}"
            assert subprocess.run(told, shell=True, capture_output=True, check=False).returncode == 0, command
        else:
            done = CliRunner().invoke(app, shlex.split(command)[1:])
            assert done.exit_code == 0, f"{command}\n{done.stderr}"
    assert (tmp_path / "plots.parquet").exists() and (tmp_path / "archive").is_dir()


def test_the_readmes_targets_of_make_exist():
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    named = re.findall(r"\bmake ([a-z-]+)", re.sub(r"```.*?```", "", (ROOT / "README.md").read_text(), flags=re.DOTALL))
    assert len(named) >= 4 and set(named) <= set(targets)


def test_outputs_in_the_readme_and_the_guides_are_those_of_today():
    pages = [ROOT / "README.md", ROOT / "docs" / "trust.md", *sorted((ROOT / "docs").glob("guide-*.md"))]
    script = str(ROOT / "scripts" / "run_in_docs.py")
    done = subprocess.run([sys.executable, script, "--check", *map(str, pages)], check=False)
    assert done.returncode == 0, "run scripts/run_in_docs.py"


def test_the_gallery_has_every_scenario_as_it_is():
    done = subprocess.run([sys.executable, str(ROOT / "scripts" / "gallery.py"), "--check"], check=False)
    assert done.returncode == 0, "run scripts/gallery.py"


def test_the_tables_of_what_jink_reads_are_those_of_the_code():
    done = subprocess.run([sys.executable, str(ROOT / "scripts" / "reading_docs.py"), "--check"], check=False)
    assert done.returncode == 0, "run scripts/reading_docs.py"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    missing = [link for link in LINK.findall(page.read_text(encoding="utf-8")) if not (page.parent / link).exists()]
    assert not missing
