"""Outputs are whole or not there; what a killed run leaves is taken away by the next one, and by no one before."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import pytest

from jink.io.temporary import PREFIX, atomically, folder_in, take_away_left

HOLDS = (
    "import sys, time; from pathlib import Path; from jink.io.temporary import atomically\n"
    "with atomically(Path(sys.argv[1])) as (name,):\n"
    "    name.write_text('half')\n"
    "    print(flush=True)\n"
    "    time.sleep(60)\n"
)


def left(folder):
    return [entry.name for entry in folder.iterdir() if entry.name.startswith(PREFIX)]


@pytest.fixture
def running(tmp_path):
    """A process that is half way through writing `t.csv`."""
    with subprocess.Popen([sys.executable, "-c", HOLDS, tmp_path / "t.csv"], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"\n"
        yield process
        process.kill()


@pytest.mark.skipif(sys.platform == "win32", reason="has no such locks")
def test_what_a_killed_run_leaves_goes_with_the_next(tmp_path, running):
    take_away_left(tmp_path)
    assert len(left(tmp_path)) == 1  # it lives
    running.kill()
    running.wait()
    assert len(left(tmp_path)) == 1 and not (tmp_path / "t.csv").exists()
    with atomically(tmp_path / "t.csv") as (name,):
        name.write_text("whole")
        assert len(left(tmp_path)) == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ["t.csv"] and (tmp_path / "t.csv").read_text() == "whole"


@pytest.mark.skipif(sys.platform == "win32", reason="has no such locks")
def test_two_runs_in_a_folder_leave_each_other_alone(tmp_path, running):
    for _ in range(3):
        with atomically(tmp_path / "other.csv", tmp_path / "third.csv") as names:
            for name in names:
                name.write_text("whole")
    assert len(left(tmp_path)) == 1 and running.poll() is None
    assert sorted(entry.name for entry in tmp_path.iterdir() if entry.name[0] != ".") == ["other.csv", "third.csv"]


def test_what_only_looks_like_it_stays(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "kept").touch()
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / f"{PREFIX}file").touch()
    (folder / f"{PREFIX}link").symlink_to(elsewhere)
    take_away_left(folder)
    assert sorted(left(folder)) == [f"{PREFIX}file", f"{PREFIX}link"] and (elsewhere / "kept").exists()


def test_a_failure_leaves_the_file_as_it_was(tmp_path):
    target = tmp_path / "t.csv"
    target.write_text("before")
    with pytest.raises(RuntimeError), atomically(target) as (name,):
        name.write_text("after")
        raise RuntimeError
    assert target.read_text() == "before" and left(tmp_path) == []
    with atomically(target) as (name,):
        name.write_text("after")
    umask = os.umask(0)
    os.umask(umask)
    assert target.read_text() == "after" and target.stat().st_mode & 0o777 == 0o666 & ~umask


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nowhere'$"), folder_in(tmp_path / "nowhere"):
        pass


def test_a_name_that_no_file_can_have_is_named_before_anything_is_done(tmp_path):
    name = tmp_path / ("a" * 256)
    with pytest.raises(OSError, match=r"a{256}'$"), atomically(tmp_path / "t.csv", name):
        pytest.fail("the work was begun")
    assert left(tmp_path) == []


def test_many_folders_at_once(tmp_path):
    """The lock of a new folder and its removal by another run do not meet."""
    script = (
        "import sys; from pathlib import Path; from jink.io.temporary import atomically\n"
        "for k in range(200):\n"
        "    with atomically(Path(sys.argv[1])) as (name,):\n"
        "        name.write_text('whole')\n"
    )
    runs = [subprocess.Popen([sys.executable, "-c", script, tmp_path / f"{k}"]) for k in range(4)]
    deadline = time.monotonic() + 60
    assert [run.wait(deadline - time.monotonic()) for run in runs] == [0] * 4
    assert left(tmp_path) == [] and {entry.read_text() for entry in tmp_path.iterdir()} == {"whole"}
