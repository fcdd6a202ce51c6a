"""Whatever goes wrong, a command says it in one line and ends with status 1 or 2; a traceback needs `--debug`."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import polars as pl
import pytest

from jink.cli.exit_status import exit_status, guarded
from jink.cli.streams import Closed
from jink.report.summary_table import _noise

ROWS = [{"target": "a", "time": float(k), "x": 200.0 * k, "y": 30.0 * k} for k in range(30)]
unix = pytest.mark.skipif(sys.platform == "win32", reason="closed descriptors and full devices are those of Unix")


def jink(
    *arguments: object, shell: str = "", before: str = "", encoding: str = "utf-8"
) -> subprocess.CompletedProcess[bytes]:
    """The command in a shell, which redirects its streams."""
    line = [
        "sh",
        "-c",
        f'{before} "$@" {shell}',
        "sh",
        sys.executable,
        "-m",
        "jink",
        *map(os.fsencode, map(str, arguments)),
    ]
    environment = {**os.environ, "COLUMNS": "200", "NO_COLOR": "1", "PYTHONIOENCODING": encoding}
    return subprocess.run(line, env=environment, capture_output=True, check=False)


def one_line(done: subprocess.CompletedProcess[bytes], status: int, *pieces: str) -> None:
    said = done.stderr.decode("utf-8", "replace")
    assert done.returncode == status, said
    assert said.startswith("jink: ") and said.count("\n") == 1 and "Traceback" not in said, said
    assert all(piece in said for piece in pieces), said


@pytest.fixture
def plots(tmp_path) -> Path:
    path = tmp_path / "plots.csv"
    pl.DataFrame(ROWS).write_csv(path)
    return path


def raising(error: BaseException):
    def run() -> int:
        raise error

    return run


ERRORS = [
    (pl.exceptions.ComputeError("cannot write: No space left on device (os error 28)"), 1, "No space left on device"),
    (pl.exceptions.ComputeError("what polars says\nmore"), 1, "polars: what polars says"),
    (pl.exceptions.PanicException("out of range"), 1, "polars: out of range"),
    (OSError(40, "Too many levels of symbolic links", "a/b"), 1, "Too many levels of symbolic links: a/b"),
    (OSError("no number"), 1, "no number"),
    (MemoryError(), 1, "not enough memory"),
    (RecursionError("deep"), 2, "nested too deeply"),
    (__import__("csv").Error("field larger than field limit (131072)"), 2, "field larger"),
]


@pytest.mark.parametrize(("error", "status", "words"), ERRORS)
def test_errors_from_outside_are_one_line(error, status, words, capsys):
    class Nothing(ValueError):
        """No mistake of the input."""

    for run in (lambda: exit_status(raising(error), mistakes=Nothing), lambda: guarded(raising(error))):
        assert run() == status
        said = capsys.readouterr().err
        assert words in said and said.count("\n") == 1


def test_a_defect_is_one_line_and_a_traceback_only_where_it_is_asked_for(capsys, monkeypatch):
    assert guarded(raising(TypeError("none of these\nmore"))) == 1
    said = capsys.readouterr().err
    assert said == "jink: TypeError: none of these (a defect of jink; --debug shows where)\n"
    monkeypatch.setenv("JINK_DEBUG", "1")
    assert guarded(raising(TypeError("none of these"))) == 1
    assert "Traceback" in capsys.readouterr().err


def test_debug_may_stand_anywhere(plots):
    for arguments in (["--debug", "track", "nowhere.csv"], ["track", "nowhere.csv", "--debug"]):
        done = jink(*arguments)
        assert (
            done.returncode == 2
            and b"Traceback" in done.stderr
            and done.stderr.endswith(b"no such file: nowhere.csv\n")
        )


@unix
def test_closed_streams_are_named(plots, tmp_path):
    one_line(jink("track", "-", shell="<&-"), 1, "standard input is closed")
    one_line(jink("track", plots, "--json", shell=">&-"), 1, "standard output is closed")
    done = jink("track", plots, "-o", tmp_path / "out.parquet", "-q", shell="<&- >&- 2>&-")
    assert done.returncode == 0 and pl.read_parquet(tmp_path / "out.parquet").height == 30


@unix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_full_device_is_one_line(plots, tmp_path):
    one_line(jink("track", plots, "--json", shell=">/dev/full"), 1, "No space left on device")
    one_line(jink("track", plots, "-o", "-", "-q", shell=">/dev/full"), 1, "No space left on device")
    assert jink("track", "nowhere.csv", shell="2>/dev/full").returncode == 2


@unix
def test_a_reader_that_has_gone_is_no_error(plots):
    done = jink("track", plots, "-o", "-", "-q", shell="| true")
    assert done.stderr == b""
    many = plots.with_name("many.csv")
    pl.concat([pl.DataFrame(ROWS).with_columns(target=pl.lit(f"T{k}")) for k in range(200)]).write_csv(many)
    done = jink("track", many, "-o", "-", "-q", shell="; echo $? >&2) | head -1", before="(")
    assert done.stderr.split() == [b"141"] and done.stdout.count(b"\n") == 1


@unix
@pytest.mark.parametrize("words", [["--help"], ["track", "--help"], ["--version"], ["track", "plots.csv"]])
def test_help_and_tables_whose_reader_has_gone(plots, words):
    words = [plots if word == plots.name else word for word in words]
    done = jink(*words, shell="; echo $? >&2) | true", before="(sleep 0.2; ")
    assert done.stderr.split() == [b"141"]


def test_standard_output_in_ascii(plots):
    done = jink("track", plots, encoding="ascii")
    assert done.returncode == 0 and done.stdout and b"Traceback" not in done.stderr
    rows = "".join(json.dumps({**row, "target": "Flug é 🛩"}) + "\n" for row in ROWS)
    path = plots.with_name("plots.jsonl")
    path.write_text(rows, encoding="utf-8")
    summary = jink("track", path, "--json", encoding="ascii")
    assert summary.returncode == 0 and json.loads(summary.stdout.decode("ascii"))["rows"] == 30


@unix
@pytest.mark.skipif(sys.platform == "darwin", reason="its file names are UTF-8")
def test_names_that_are_not_utf_8(plots):
    folder = os.fsencode(plots.parent)
    table = pl.DataFrame(ROWS)
    for suffix, content in ((b".csv", table.write_csv().encode()), (b".parquet", _parquet(table))):
        name = os.path.join(folder, b"p\xff" + suffix)
        with open(name, "wb") as handle:
            handle.write(content)
        out = os.path.join(folder, b"o\xff" + suffix)
        done = subprocess.run(
            [sys.executable, "-m", "jink", "track", name, "-o", out, "--json"], capture_output=True, check=False
        )
        assert done.returncode == 0, done.stderr
        assert os.path.exists(out)
        assert json.loads(done.stdout)["files"][0].endswith("p\\xff" + suffix.decode())
    one_line(jink("track", os.fsdecode(os.path.join(folder, b"none\xff.csv"))), 2, "no such file")


def _parquet(table: pl.DataFrame) -> bytes:
    handle = io.BytesIO()
    table.write_parquet(handle)
    return handle.getvalue()


@unix
def test_links_in_a_circle(tmp_path, plots):
    os.symlink(tmp_path / "one.csv", tmp_path / "two.csv")
    os.symlink(tmp_path / "two.csv", tmp_path / "one.csv")
    one_line(jink("track", tmp_path / "one.csv"), 2, "no such file")
    one_line(jink("track", plots, "-o", tmp_path / "one.csv"), 2, "circle")


def test_csv_that_its_reader_refuses(tmp_path):
    wide = tmp_path / "wide.csv"
    wide.write_text("target,time,x,y," + "n" * 140_000 + "\na,0,0,0,0\n")
    one_line(jink("track", wide), 2, "wide.csv", "field larger")
    alone = tmp_path / "cr.csv"
    alone.write_bytes(b"target,time\rx,y\na,1,2,3\n")
    one_line(jink("track", alone), 2, "cr.csv")
    long = tmp_path / "long.csv"
    rows = "".join(f"a,{k},{k},{k},\n" for k in range(9))
    long.write_text("target,time,x,y,note\n" + rows + 'a,9,9,9,"' + "n" * 140_000 + '"\n' + "b,1\n")
    one_line(jink("track", long), 2, "long.csv", "field larger")


def test_old_line_ends_are_read(tmp_path):
    path = tmp_path / "old.csv"
    path.write_bytes(b"target,time,x,y\r" + b"".join(b"a,%d,%d,%d\r" % (k, 90 * k, k) for k in range(9)))
    assert jink("track", path, "-q", "-o", tmp_path / "out.csv").returncode == 0


def test_times_that_no_calendar_writes_are_rejected(tmp_path):
    for unit, wild in (("ms", -(2**62)), ("us", -(2**63) + 1), ("ns", 2**63 - 1), ("us", 2**63 - 1)):
        factor = {"ms": 1000, "us": 10**6, "ns": 10**9}[unit]
        times = [(1_600_000_000 + k) * factor for k in range(29)] + [wild]
        table = pl.DataFrame(ROWS).with_columns(pl.Series("time", times).cast(pl.Datetime(unit)))
        table.write_parquet(tmp_path / "wild.parquet")
        done = jink("track", tmp_path / "wild.parquet", "--json")
        assert done.returncode == 0, (unit, wild, done.stderr)
        # the last nanosecond lies in 2262, where one row alone is no track
        assert json.loads(done.stdout)["accepted"] == 29


def test_a_closed_stream_refuses_every_use():
    stream = Closed("standard output")
    assert not stream.isatty()
    for use in (lambda: stream.write("a"), lambda: stream.buffer.write(b"a"), stream.fileno):
        with pytest.raises(OSError, match="standard output is closed"):
            use()


@pytest.mark.parametrize(("spread", "said"), [([19.6, 20.4], "(estimated)"), ([18.0, 21.0], "18 to 21 m by target)")])
def test_a_range_over_the_targets_is_said_where_there_is_one(spread, said):
    line = {"position_sd": 20.0, "position_sd_from": "estimated", "position_sd_range": spread}
    assert next(_noise([{"source": "a.csv", **line}], ["a.csv"])).endswith(said)


@unix
def test_a_stream_that_is_no_json_says_what_it_reads(plots):
    done = jink("track", "-", shell=f"< '{plots}'")
    assert done.returncode == 2 and done.stderr.splitlines()[-1].endswith(
        b"none of 31 lines could be used; expected JSON Lines, and of other formats a file instead of -"
    )


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--site", "a=48,9,500", "--site", "b=49,9,100"), b"a stream takes one site"),
        (("--site", "a=48,9,500"), b"a stream takes one site"),
        (("--strict",), b"--strict is for a folder"),
        (("--append",), b"--append is for a folder"),
    ],
)
@unix
def test_a_stream_refuses_what_it_would_leave_out(given, said, plots):
    """Sites by name were left out without a word: plots of several radars shared one frame."""
    plots.write_text(
        '{"target": "a", "radar": "a", "time_s": 1, "range_km": 90, "azimuth_deg": 30, "altitude_m": 5000}\n'
    )
    done = jink("track", "-", *given, shell=f"< '{plots}'")
    assert done.returncode == 2 and not done.stdout
    one_line(done, 2, said.decode())
