"""Inputs and outputs are kept apart, and a command that is stopped leaves nothing half done."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

from jink.cli.main import app


@pytest.fixture
def plots(tmp_path):
    t = np.arange(60.0)
    path = tmp_path / "a.rejected.parquet"
    pl.DataFrame({"target": "a", "time": t, "x": 200.0 * t, "y": 10.0 * np.sin(t)}).write_parquet(path)
    return path


def track(*arguments):
    return CliRunner().invoke(app, ["track", *map(str, arguments)])


def test_rejected_rows_do_not_go_over_the_input(plots):
    before = plots.read_bytes()
    done = track(plots, "-o", plots.with_name("a.parquet"))
    assert done.exit_code == 2 and "a.rejected.parquet is an input" in done.output
    assert plots.read_bytes() == before


def test_two_outputs_need_two_names(plots, tmp_path):
    done = track(plots, "-o", tmp_path / "t.csv", "--report", tmp_path / "t.csv")
    assert done.exit_code == 2 and "written twice" in done.output and not (tmp_path / "t.csv").exists()
    os.symlink(tmp_path / "t.csv", tmp_path / "link.csv")
    done = track(plots, "-o", tmp_path / "t.csv", "--report", tmp_path / "link.csv")
    assert done.exit_code == 2 and "written twice" in done.output


def test_links_in_a_circle_are_named(plots, tmp_path):
    os.symlink(tmp_path / "one.csv", tmp_path / "two.csv")
    os.symlink(tmp_path / "two.csv", tmp_path / "one.csv")
    done = track(plots, "-o", tmp_path / "one.csv")
    assert done.exit_code == 2 and "circle" in done.output


def test_the_longest_name_is_written(plots, tmp_path):
    name = tmp_path / ("a" * 228 + ".csv")
    assert track(plots, "-o", name).exit_code == 0
    assert name.exists()


def test_any_number_of_threads(plots, tmp_path):
    assert track(plots, "-o", tmp_path / "t.csv", "--threads", 2147483648).exit_code == 0


@pytest.mark.skipif(sys.platform == "win32", reason="has no SIGTERM")
def test_a_command_that_is_told_to_stop_leaves_nothing(plots, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    script = (
        "import sys, time\n"
        "from jink.io import writing\n"
        "real = writing.write_tracks\n"
        "def slow(*given):\n"
        "    print('writing', flush=True)\n"
        "    time.sleep(60)\n"
        "writing.write_tracks = slow\n"
        "from jink.cli.main import main\n"
        f"sys.argv = ['jink', 'track', {str(plots)!r}, '-o', {str(folder / 't.csv')!r}, '-q']\n"
        "main()\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "writing\n"
        time.sleep(0.2)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 143
    assert list(folder.iterdir()) == []
