"""Tables in a file and in narrow terminals: every cell is there in full."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from rich.console import Console

import jink
from jink.report.summary_table import lines
from jink.report.terminal import ENDLESS, folded, print_table, standard_output

FLIGHTS = str(Path(__file__).parents[2] / "examples" / "flights.parquet")
FIT = ("fit", "random-turns", "--runs", "20", "--check-runs", "10", "--starts", "1")
COMMANDS = {
    "reproduce": ("reproduce", "wang-2010", "--runs", "4"),
    "compare": ("compare", "random-turns", "--runs", "4", "--filters", "imm-cv-ct,singer"),
    "fit": (*FIT, "--filter", "imm-cv-ct"),
    "search": (*FIT, "--search", "--filter", "cv,ca"),
    "learn": ("learn", "nn-kf", "random-turns", "--runs", "8", "--check-runs", "4", "--epochs", "2"),
    "track": ("track", FLIGHTS, "-o", "tracks.parquet"),
}


def printed(command: str, folder: Path, columns: int | None) -> str:
    """What a command prints into a pipe; columns: as a terminal of this width would show it."""
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    environment |= {} if columns is None else {"COLUMNS": str(columns)}
    asked = [sys.executable, "-m", "jink", *COMMANDS[command]]
    done = subprocess.run(asked, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def cut(text: str) -> list[str]:
    """Lines with an ellipsis that stands for what was cut; between the ends of an interval it stands for itself."""
    return [line for line in text.splitlines() if "…" in re.sub(r"(^|\s)…(\s|$)", " ", line)]


@pytest.mark.parametrize("command", COMMANDS)
def test_nothing_is_cut(command, tmp_path):
    """In a file a table has one line for each row; in 60 columns it has all the same words on lines that fit."""
    whole, narrow = (printed(command, tmp_path, columns) for columns in (None, 60))
    assert not cut(whole) and not cut(narrow)
    assert max(map(len, narrow.splitlines())) <= 60 < max(map(len, whole.splitlines()))


def shown(width: int, head: list[str], rows: list[list[str]], **options) -> str:
    file = io.StringIO()
    print_table(Console(file=file, width=width), head, rows, **options)
    return file.getvalue()


def test_a_wide_table_folds_into_parts_with_the_first_column():
    rows = [["first", "1.25 ±0.01", "22.5", "[300]"], ["second", "2.5", "–", "4"]]
    head = ["filter", "position m", "lost", "delay"]
    assert shown(40, head, rows).splitlines()[1].split() == ["first", "1.25", "±0.01", "22.5", "[300]"]
    parts = shown(24, head, rows).split("\n\n")
    assert [part.splitlines()[0].split() for part in parts] == [
        ["filter", "position", "m", "lost"],
        ["filter", "delay"],
    ]
    kept = shown(24, head, rows, together=[[1], [2, 3]]).split("\n\n")
    assert [part.split()[-1] for part in kept] == ["2.5", "4"]
    tiny = shown(5, head, rows)
    assert "…" not in tiny and max(map(len, tiny.splitlines())) <= 5
    letters = [character for text in (*head, *rows[0], *rows[1]) for character in text if character != " "]
    assert not set(letters) - set(tiny)


def test_every_column_is_in_one_part():
    for room in range(1, 60):
        parts = list(folded([8, 5, 9, 30, 2], [[1], [2], [3], [4]], 1, room))
        assert [k for part in parts for k in part[1:]] == [1, 2, 3, 4] and all(part[0] == 0 for part in parts)


def test_only_a_terminal_or_columns_limit_the_width(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    assert standard_output().width == ENDLESS
    monkeypatch.setenv("COLUMNS", "72")
    assert standard_output().width == 72


def test_json_and_tables_are_not_mixed(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "jink", *COMMANDS["compare"], "--json", "-"], capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout)["runs"] == 4


def test_the_summary_tells_the_sources_apart(tmp_path):
    """Of files the last part of the path where that is enough, of other sources the whole name."""
    time = 4.0 * np.arange(30)
    rng = np.random.default_rng(0)
    table = pl.DataFrame({"target": "a", "time": time, "x": 50.0 * time + rng.normal(0, 5, 30), "y": 0.0})
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        table.with_columns(pl.col("time") + 2.0 * (folder == "two")).write_csv(tmp_path / folder / "x.csv")
    radars = table.with_columns(pl.col("time") + 1.0, source=pl.Series(["25/201", "26/201"] * 15))
    radars.write_csv(tmp_path / "radars.csv")

    def noise(*inputs: str) -> list[str]:
        summary = jink.track([tmp_path / name for name in inputs], details=True).summary
        shown = list(lines(summary))
        first = [name for name, _ in shown].index("Noise")
        return [text.partition(":")[0] for _, text in shown[first : first + 2]]

    assert noise("one/x.csv", "two/x.csv") == [str(tmp_path / folder / "x.csv") for folder in ("one", "two")]
    assert noise("one/x.csv", "radars.csv") == ["x.csv", "25/201"]
    assert noise("radars.csv") == ["25/201", "26/201"]
