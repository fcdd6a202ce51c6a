"""CSV for spreadsheets, and text for terminals: names of targets, columns and files come from outside."""

from __future__ import annotations

import gzip
import io
import json
import subprocess
import sys

import polars as pl
import pytest
from typer.testing import CliRunner

from jink.cli.exit_status import failed
from jink.cli.main import app
from jink.io.errors import InputError
from jink.io.printable import printable, printable_json
from jink.io.spreadsheets import check_is_csv, harmless
from jink.report.terminal import print_line, print_table, standard_output

FORMULA, COLOUR = "=cmd|' /C calc'!A0", "\x1b[31mred\x9b0m"
STARTS = ["=1", "+1", "-1", "@a", "\ta", "\ra"]


def write_plots(path, names=(FORMULA, COLOUR)):
    rows = [{"target": name, "time": float(k), "x": -200.0 * k, "y": 30.0 * k} for name in names for k in range(9)]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    return path


def run(*arguments):
    return CliRunner(env={"COLUMNS": "400"}).invoke(app, list(map(str, arguments)))


def test_text_alone_is_marked():
    table = pl.DataFrame(
        {"target": [*STARTS, "a=1", "", None], "x": [-1.0] * 9, "=y": [-2] * 9, "kind": ["-k"] * 9},
        schema_overrides={"kind": pl.Categorical},
    )
    done = harmless(table)
    assert done.columns == ["target", "x", "'=y", "kind"]
    assert done["target"].to_list() == [*(f"'{text}" for text in STARTS), "a=1", "", None]
    assert done["x"].to_list() == [-1.0] * 9 and done["'=y"].to_list() == [-2] * 9 and done["kind"][0] == "'-k"
    assert harmless(pl.DataFrame({"a": []}, schema={"a": pl.String})).height == 0


@pytest.mark.parametrize("suffix", [".csv", ".csv.gz"])
@pytest.mark.parametrize("memory", [(), ("--memory", "600MB")])
def test_track_writes_harmless_cells(tmp_path, monkeypatch, suffix, memory):
    if memory:  # share by share
        monkeypatch.setattr("jink.tracking.large.fits", lambda *_: False)
    plots, out = write_plots(tmp_path / "plots.jsonl"), tmp_path / f"t{suffix}"
    assert run("track", plots, "-o", out, "--safe-csv", *memory).exit_code == 0
    content = gzip.decompress(out.read_bytes()) if suffix.endswith(".gz") else out.read_bytes()
    table = pl.read_csv(io.BytesIO(content))
    assert set(table["target"]) == {f"'{FORMULA}", COLOUR} and table["x"].dtype == pl.Float64 and table["x"].min() < 0
    assert run("track", plots, "-o", out).exit_code == 0
    plain = gzip.decompress(out.read_bytes()) if suffix.endswith(".gz") else out.read_bytes()
    assert set(pl.read_csv(io.BytesIO(plain))["target"]) == {FORMULA, COLOUR}


def test_simulate_writes_harmless_cells(tmp_path):
    for name in ("lee-2003", "sky-regional"):
        assert run("simulate", name, "--runs", 1, "-o", tmp_path / "s.csv.gz").exit_code == 0
        assert gzip.decompress((tmp_path / "s.csv.gz").read_bytes()).count(b"\n") > 100
        out = tmp_path / "s.csv"
        assert run("simulate", name, "--runs", 1, "-o", out, "--safe-csv").exit_code == 0
        table = pl.read_csv(out)
        texts = [column for column in table.columns if table[column].dtype == pl.String]
        assert table.height and not any(table[c].str.contains("^[=+@\t\r-]").any() for c in texts)


@pytest.mark.parametrize("output", [("-o", "t.parquet"), ("-o", "-"), ()])
def test_another_format_has_no_cells(tmp_path, monkeypatch, output):
    monkeypatch.chdir(tmp_path)
    done = run("track", write_plots(tmp_path / "plots.jsonl"), "--safe-csv", *output)
    assert done.exit_code == 2 and "--safe-csv is for -o tracks.csv" in done.output
    with pytest.raises(InputError, match="the output is none"):
        check_is_csv(None, "")


CONTROL = [chr(code) for code in (*range(32), *range(127, 160), 0x202E, 0x2066, 0x2028) if chr(code) not in "\n\t"]


def test_no_control_character_is_printed_raw():
    text = printable("".join(CONTROL) + "é 🛩\n\t")
    assert not set(CONTROL) & set(text) and text.endswith("é 🛩\n\t") and "\\x1b" in text and "\\u202e" in text
    assert printable("a\nb", one_line=True) == "a\\nb"
    assert json.loads(printable_json(json.dumps(CONTROL, ensure_ascii=False))) == CONTROL


def test_messages_and_tables_print_no_control_character(capsys):
    failed(f"no such file: {COLOUR}", 2)
    console = standard_output()
    print_line(console, COLOUR)
    print_table(console, ["target", COLOUR], [[COLOUR, "1"]])
    said = "".join(capsys.readouterr())
    assert said.count("\\x1b[31mred\\x9b0m") == 4 and not set(said) & set(CONTROL)


def test_commands_print_no_control_character(tmp_path):
    plots = write_plots(tmp_path / f"{COLOUR}.jsonl")
    bad = write_plots(tmp_path / "bad.jsonl")
    bad.write_text(bad.read_text().replace('"y"', json.dumps(f"{COLOUR} y")))
    tried = [
        ("track", plots),
        ("track", plots, "--json"),
        ("track", plots, "--keep", COLOUR),
        ("track", tmp_path / f"no {COLOUR}"),
        ("track", bad),
        ("track", plots, "--filter", COLOUR),
        ("track", plots, "--columns", f"{COLOUR}=x"),
        ("simulate", COLOUR, "-o", tmp_path / "s.csv"),
        ("simulate", "lee-2003", "--runs", 1, "-o", tmp_path / f"{COLOUR}.csv"),
        ("compare", plots, "kalman-cv"),
        ("compare", COLOUR, "kalman-cv"),
        ("fit", COLOUR),
        ("learn", COLOUR),
        ("track", plots, f"--{COLOUR}"),
        (COLOUR,),
    ]
    for arguments in tried:
        done = run(*arguments)
        assert done.output and not set(done.output) & set(CONTROL), (arguments, done.output)


def test_a_pipe_prints_no_control_character(tmp_path):
    plots = write_plots(tmp_path / "plots.jsonl")
    lines = plots.read_text() + json.dumps({"target": COLOUR, "time": COLOUR, "x": COLOUR}) + f"\n{COLOUR}\n"
    done = subprocess.run(
        [sys.executable, "-m", "jink", "track", "-"], input=lines.encode(), capture_output=True, check=False
    )
    said = done.stderr.decode()
    assert done.returncode == 0 and "rejected" in said and not set(said) & set(CONTROL)
