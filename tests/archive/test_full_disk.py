"""A disk that is full ends an archive with one line, and the same command goes on from there."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from small_disk import mounted, place_for_a_disk
from test_archive import SAME, flights, hashes, in_files, track
from typer.testing import CliRunner

from jink.archive import mapping
from jink.cli.main import app

AGAIN = "and run the same command again, it goes on from here"


@pytest.fixture
def hours(tmp_path):
    return in_files(tmp_path, flights())


@pytest.fixture
def disk(tmp_path):
    with place_for_a_disk(tmp_path) as disk:
        yield disk


def stopped(hours: list[Path], output: Path) -> str:
    """What is said of a run that the disk ends."""
    done = CliRunner().invoke(app, ["track", *map(str, hours), "-o", f"{output}/", *SAME, "--quiet"])
    assert done.exit_code == 1 and done.stderr.count("\n") == 1, done.output
    return done.stderr


@pytest.mark.parametrize(
    "number, said", [(28, "the disk is full; make room"), (122, "the quota of the disk is used up; make room")]
)
def test_it_is_said_and_the_run_goes_on_later(tmp_path, hours, monkeypatch, number, said):
    def full(*_):
        raise OSError(number, os.strerror(number))

    with monkeypatch.context() as patch:
        patch.setattr(mapping, "_write", full)
        assert f"{said} {AGAIN}" in stopped(hours, tmp_path / "tracks")
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)


def test_files_that_may_not_be_so_large(tmp_path, hours):
    """Dividing needs files of 40 kB, tracks need files of 130 kB."""
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    arguments = [*map(str, hours), "-o", f"{tmp_path}/tracks/", "--threads", "2", "--quiet"]
    done = subprocess.run(
        [sys.executable, "-m", "jink", "track", *arguments],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (70_000, 70_000)),
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert f"a file is larger than the system allows; raise its limit (ulimit -f) {AGAIN}" in done.stderr
    kept = sorted((tmp_path / "tracks/.jink/map").iterdir())
    before = [path.stat().st_mtime_ns for path in kept]
    assert len([path for path in kept if path.suffix == ".json"]) == 4
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert hashes(tmp_path / "tracks") == hashes(tmp_path / "whole")
    assert [path.stat().st_mtime_ns for path in kept] == before


@pytest.mark.parametrize("size", ["100k", "700k"])
def test_a_disk_that_is_full_while_files_are_divided_and_while_targets_are_tracked(tmp_path, hours, disk, size):
    if not mounted(disk, f"size={size}"):
        pytest.skip("mounting is not allowed")
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    assert f"the disk is full; make room {AGAIN}" in stopped(hours, disk / "tracks")
    assert mounted(disk, "remount,size=8m")
    track(*hours, "-o", f"{disk}/tracks/", *SAME)
    assert hashes(disk / "tracks") == hashes(tmp_path / "whole")
