"""The notebooks are those of the guides, and every cell runs."""

import contextlib
import io
import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from jink.cli.main import app

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


def test_they_are_in_step_with_the_guides():
    done = subprocess.run([sys.executable, str(ROOT / "scripts" / "notebooks.py"), "--check"], check=False)
    assert done.returncode == 0, "run scripts/notebooks.py"
    assert len(NOTEBOOKS) == len(list((ROOT / "docs").glob("guide-*.md"))) == 4


def test_links_lead_somewhere():
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            for link in "".join(cell["source"]).split("](../../")[1:]:
                assert (ROOT / link.split(")")[0].split("#")[0]).exists(), link


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_runs(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    names: dict[str, object] = {"__name__": "__main__"}
    codes = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert len(codes) >= 3
    for cell in codes:
        source = "".join(cell["source"])
        if not source.startswith("!"):
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(source, str(path), "exec"), names)
            continue
        for line in source.splitlines():
            run(line.removeprefix("!"))


def run(command: str) -> None:
    """A command, in this process where it reads no standard input."""
    if "<" in command:
        subprocess.run(f"{sys.executable} -m {command}", shell=True, check=True, capture_output=True)
        return
    done = CliRunner().invoke(app, shlex.split(command)[1:])
    assert done.exit_code == 0, f"{command}\n{done.stderr}"
