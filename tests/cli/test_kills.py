"""Commands that are killed, and disks that are full: no torn output, no input changed, one line of error."""

from __future__ import annotations

import gzip
import os
import random
import resource
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import polars as pl
import pytest
from small_disk import mounted, place_for_a_disk

from benchmarks.kills import COMMANDS, Counts, alive, killed_at, left_behind, make_inputs, start, whole

pytestmark = pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks at processes and limits of Linux")


@pytest.fixture
def folder(tmp_path):
    make_inputs(tmp_path, large=0)
    return tmp_path


@pytest.mark.parametrize("what", ["track", "compare --report"])
def test_a_killed_command_tears_nothing(folder, what):
    counts, rng = Counts(), random.Random(what)
    for _ in range(3):
        killed_at(folder, COMMANDS[what], rng.uniform(0.3, 2.5), counts)
    assert counts.faults == 0
    assert start(folder, COMMANDS[what].words).wait() == 0
    assert left_behind(folder) == [] and all(whole(folder / name) for name in COMMANDS[what].outputs)


@pytest.mark.parametrize("what", ["track", "fit", "learn", "compare --report"])
def test_a_kill_between_writing_and_renaming(folder, what):
    """The moment when most is there and nothing is finished."""
    command = COMMANDS[what]
    slow = (
        "import sys, time; from jink.io import temporary\n"
        "real = temporary._to_disk\n"
        "temporary._to_disk = lambda path: (real(path), print(flush=True), time.sleep(60))\n"
        "from jink.cli.main import main\n"
        f"sys.argv = ['jink', *{command.words!r}]\n"
        "main()\n"
    )
    with subprocess.Popen([sys.executable, "-c", slow], cwd=folder, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"\n"
        process.send_signal(signal.SIGKILL)
    assert len(left_behind(folder)) == 1
    there = {entry.name for entry in folder.iterdir() if entry.name[0] != "."}
    assert there - set(command.kept) == {"plots.parquet"}
    if what == "track":
        assert start(folder, command.words).wait() == 0 and left_behind(folder) == []


def test_workers_end_with_the_command(folder):
    process = start(folder, ("fit", "plots.parquet", "--search", "--minutes", "2", "-o", "s.json", "-q"))
    deadline = time.monotonic() + 90
    while len(alive(process.pid)) < 3 and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.05)
    try:
        assert len(alive(process.pid)) >= 3
        process.kill()
        process.wait()
        deadline = time.monotonic() + 30
        while alive(process.pid) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert alive(process.pid) == []
    finally:
        for other in alive(process.pid):
            with suppress(ProcessLookupError):
                os.kill(other, signal.SIGKILL)


SHARES = "from jink.tracking import large; large.fits = lambda *_: False; from jink.cli.main import main; main()"


def limited(folder: Path, *words: str, most: int, shares: bool = False) -> subprocess.CompletedProcess[str]:
    """A command whose files may not be longer than `most` bytes. shares: as if the table were larger than memory."""
    return subprocess.run(
        [sys.executable, *(("-c", SHARES) if shares else ("-m", "jink")), *words],
        cwd=folder,
        # compiled modules that are cut off would stay
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
    )


OUTPUTS = ["t.parquet", "t.csv", "t.csv.gz", "t.jsonl", "t.arrow"]
WRITERS = {
    **{f"track {name}": ("track", "plots.parquet", "-o", name, "-q") for name in OUTPUTS},
    **{f"shares {name}": ("track", "plots.parquet", "-o", name, "-q") for name in OUTPUTS},
    "report": ("track", "plots.parquet", "--report", "t.html", "-q"),
    "fit": ("fit", "plots.parquet", "--starts", "1", "--minutes", "0.01", "-o", "f.json", "--report", "f.html", "-q"),
    "learn": (*COMMANDS["learn"].words,),
    "compare": ("compare", "lee-2003", "--runs", "5", "--json", "c.json", "--report", "c.html", "-q"),
    "simulate": ("simulate", "lee-2003", "--runs", "9", "-o", "s.csv", "-q"),
}


@pytest.mark.parametrize("what", WRITERS)
def test_no_room_is_one_line(folder, what):
    words = WRITERS[what]
    before = (folder / "plots.parquet").read_bytes()
    done = limited(folder, *words, most=4_000, shares=what.startswith("shares"))
    assert done.returncode in (1, 2) and done.stderr.startswith("jink: ") and done.stderr.count("\n") == 1, done.stderr
    assert "defect" not in done.stderr
    # a fit whose filter cannot be written goes on with --resume
    kept = {"f.json.checkpoint"} if what == "fit" else set()
    assert {entry.name for entry in folder.iterdir()} == {"plots.parquet", *kept}
    assert (folder / "plots.parquet").read_bytes() == before


@pytest.fixture
def disk(tmp_path):
    with place_for_a_disk(tmp_path) as disk:
        yield disk


@pytest.mark.parametrize("name", ["t.parquet", "t.csv", "t.csv.gz", "t.jsonl", "t.html"])
def test_a_full_disk_is_one_line(folder, disk, name):
    if not mounted(disk, "size=200k"):
        pytest.skip("mounting is not allowed")
    (disk / name).write_text("before")
    option = "--report" if name.endswith(".html") else "-o"
    done = limited(folder, "track", "plots.parquet", option, str(disk / name), "-q", most=resource.RLIM_INFINITY)
    assert done.returncode == 1 and "No space left on device" in done.stderr and done.stderr.count("\n") == 1
    assert [entry.name for entry in disk.iterdir()] == [name] and (disk / name).read_text() == "before"


READ_ONLY = {
    "track": "track plots.parquet -o disk/t.csv -q",
    "report": "track plots.parquet --report disk/t.html -q",
    "fit": "fit plots.parquet --starts 1 --minutes 0.01 -o disk/f.json -q",
    "learn": COMMANDS["learn"].line.replace("n.json", "disk/n.json").replace("n.html", "disk/n.html"),
    "compare": "compare lee-2003 --runs 5 --json disk/c.json --report disk/c.html -q",
    "simulate": "simulate lee-2003 --runs 9 -o disk/s.csv -q",
}


@pytest.mark.parametrize("what", READ_ONLY)
def test_a_folder_that_cannot_be_written_is_one_line(folder, disk, what):
    if os.geteuid() != 0:
        disk.chmod(0o555)
    elif not mounted(disk, "ro"):
        pytest.skip("root may write everywhere, and mounting is not allowed")
    began = time.monotonic()
    done = limited(folder, *READ_ONLY[what].split(), most=resource.RLIM_INFINITY)
    assert done.returncode in (1, 2) and done.stderr.count("\n") == 1 and done.stderr.startswith("jink: ")
    assert "disk" in done.stderr and "defect" not in done.stderr, (what, done.stderr, time.monotonic() - began)


def test_a_reader_that_goes_early(folder):
    """`jink track FILE -o - | head -1` ends without a word, and without the rest."""
    line = f"{sys.executable} -m jink track plots.parquet -o - -q | head -n 1"
    done = subprocess.run(["sh", "-c", line], cwd=folder, capture_output=True, check=False)
    assert done.stdout.count(b"\n") == 1 and done.stderr == b""


@pytest.mark.parametrize("what", ["track", "fit", "learn", "compare --report"])
def test_what_nobody_reads_loses_no_file(folder, what):
    """Standard output is a pipe that was closed before: the files are whole all the same."""
    command = COMMANDS[what]
    reader, writer = os.pipe()
    os.close(reader)
    words = [word for word in command.words if word != "-q"]
    with os.fdopen(writer, "wb") as pipe:
        done = subprocess.run(
            [sys.executable, "-m", "jink", *words], cwd=folder, stdout=pipe, stderr=subprocess.PIPE, check=False
        )
    # the status shows that something was to be read
    assert done.returncode == 141 and b"jink:" not in done.stderr and b"Traceback" not in done.stderr, done.stderr
    assert all(whole(folder / name) for name in command.outputs)


def test_what_was_written_is_whole(folder):
    """So that `whole` tells a torn file from a whole one."""
    table = pl.read_parquet(folder / "plots.parquet")
    content = (folder / "plots.parquet").read_bytes()
    (folder / "torn.parquet").write_bytes(content[:-9])
    (folder / "t.csv.gz").write_bytes(gzip.compress(table.write_csv().encode())[:-3000])
    (folder / "t.json").write_text('{"a": [1, 2')
    (folder / "t.html").write_text("<html><body>")
    assert whole(folder / "plots.parquet")
    assert not any(whole(folder / name) for name in ("torn.parquet", "t.csv.gz", "t.json", "t.html"))
