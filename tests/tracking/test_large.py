"""A table that is larger than --memory has the tracks that it has in memory."""

from __future__ import annotations

import gzip
import io
import json
import re
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal
from typer.testing import CliRunner

from jink.cli.main import app
from jink.io import pieces
from jink.tracking import large, prepare, sampled
from jink.tracking.large_files import memory_of


def track(*arguments: object) -> dict:
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["track", *map(str, arguments), "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def flights(targets: int = 24, rows: int = 120) -> pl.DataFrame:
    """Aircraft in the order of time; half of them without altitude, one with too few rows, two rows without a place."""
    rng, frames = np.random.default_rng(3), []
    for k in range(targets):
        count = rows if k else 2
        t = 5.0 * np.arange(count) + k
        noise = rng.normal(scale=(10.0 + k) / 111_000, size=(2, count))
        high = 3000.0 + t + rng.normal(scale=8.0, size=count)
        frames.append(
            pl.DataFrame(
                {
                    "icao24": f"{(7919 * k) % 4096:03x}",
                    "time": 1.7e9 + t,
                    "latitude": 48.0 + 0.1 * k + 0.009 * np.arange(count) + noise[0],
                    "longitude": 11.0 + 0.004 * np.arange(count) * (-1) ** k + noise[1],
                    "altitude": np.where(k % 2, high, np.nan),
                }
            )
        )
    table = pl.concat(frames).sort("time")
    wrong = pl.int_range(pl.len()).is_in([5, 900])
    return table.with_columns(latitude=pl.when(wrong).then(95.0).otherwise("latitude"))


@pytest.fixture
def small(monkeypatch):
    """Limits for which the flights are a large table."""
    monkeypatch.setattr(prepare, "EVIDENCE", 900)
    monkeypatch.setattr(large, "EVIDENCE", 900)
    monkeypatch.setattr(large, "FEWEST", 500)
    monkeypatch.setattr(large, "PIECE", 400)
    monkeypatch.setattr(pieces, "BLOCK", 8_000)


@pytest.fixture
def divided(monkeypatch, small):
    def of(*arguments: object) -> dict:
        with monkeypatch.context() as patch:
            patch.setattr(large, "PER_ROW", 10**9)
            return track(*arguments)

    return of


def written(path: Path, table: pl.DataFrame) -> Path:
    plain = path.with_suffix("") if path.suffix == ".gz" else path
    {".parquet": table.write_parquet, ".csv": table.write_csv, ".jsonl": table.write_ndjson, ".arrow": table.write_ipc}[
        plain.suffix
    ](plain)
    if path.suffix == ".gz":
        path.write_bytes(gzip.compress(plain.read_bytes()))
    return path


def same(found: dict, whole: dict) -> None:
    """The summaries, but for what tells the two apart."""
    for name in ("rows", "accepted", "rejected", "targets", "parts", "start", "end", "columns", "unused_columns"):
        assert found[name] == whole[name], name
    for name in ("cleaning", "noise", "filter", "status", "gap_seconds", "warnings"):
        assert found[name] == whole[name], name
    assert found["consistency"] == pytest.approx(whole["consistency"])
    assert any("larger than --memory" in note for note in found["notes"])


@pytest.mark.parametrize("name", ["f.parquet", "f.csv", "f.csv.gz", "f.jsonl", "f.jsonl.gz", "f.arrow"])
def test_the_tracks_are_the_same(tmp_path, divided, name):
    source = written(tmp_path / name, flights().with_columns(pl.col("altitude").fill_nan(None)))
    whole = track(source, "-o", tmp_path / "whole.parquet")
    found = divided(source, "-o", tmp_path / "found.parquet")
    same(found, whole)
    assert_frame_equal(
        pl.read_parquet(tmp_path / "found.parquet"), pl.read_parquet(tmp_path / "whole.parquet"), rel_tol=1e-12
    )
    rejected = [pl.read_parquet(tmp_path / f"{n}.rejected.parquet").sort("row") for n in ("found", "whole")]
    assert_frame_equal(*rejected)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".jink")]


@pytest.mark.parametrize("name", ["csv", "csv.gz", "jsonl", "arrow"])
def test_every_format_that_is_written_as_it_comes(tmp_path, divided, name):
    source = written(tmp_path / "f.parquet", flights())
    track(source, "-o", tmp_path / f"whole.{name}")
    divided(source, "-o", tmp_path / f"found.{name}")
    read = {"csv": partial(pl.read_csv, infer_schema_length=None), "jsonl": pl.read_ndjson, "arrow": pl.read_ipc}[
        name.removesuffix(".gz")
    ]
    tables = []
    for which in ("found", "whole"):
        content = (tmp_path / f"{which}.{name}").read_bytes()
        tables.append(read(io.BytesIO(gzip.decompress(content) if name.endswith("gz") else content)))
    # legs of a path are summed over all tracks of a share, which rounds otherwise
    assert_frame_equal(*tables, rel_tol=1e-12)


def test_smoothed_and_several_files(tmp_path, divided):
    table = flights()
    for number, part in enumerate(table.iter_slices(1000)):
        part.write_parquet(tmp_path / f"part{number}.parquet")
    whole = track(tmp_path / "part*.parquet", "--smooth", "-o", tmp_path / "whole.parquet")
    found = divided(tmp_path / "part*.parquet", "--smooth", "-o", tmp_path / "found.parquet")
    same(found, whole)
    assert_frame_equal(
        pl.read_parquet(tmp_path / "found.parquet"), pl.read_parquet(tmp_path / "whole.parquet"), rel_tol=1e-12
    )


def test_targets_have_the_same_tracks_among_more_targets(tmp_path, divided):
    """The noise is given: a sample of more targets would tell another one."""
    table = flights()
    names = table["icao24"].unique().sort()[:12].to_list()
    noise = ("--sensor-sd", "position=20,altitude=8,time=0.01")
    found = []
    for name, rows in (("few", table.filter(pl.col("icao24").is_in(names))), ("all", table)):
        rows.write_parquet(tmp_path / "in.parquet")
        divided(tmp_path / "in.parquet", *noise, "-o", tmp_path / f"{name}.parquet")
        found.append(pl.read_parquet(tmp_path / f"{name}.parquet").filter(pl.col("target").is_in(names)))
    assert found[0].height > 1000
    assert found[0].drop("row").equals(found[1].drop("row"))


def test_identifiers_are_what_the_whole_column_says(tmp_path, divided):
    """A block of lines may hold numbers alone where others hold letters."""
    for letters in (True, False):
        table = (
            flights(12)
            .sort("icao24", "time")
            .with_columns(icao24=pl.col("icao24").rank("dense").cast(pl.String).str.zfill(4))
        )
        if letters:
            table = table.with_columns(icao24=pl.col("icao24").replace("0009", "0a09"))
        source = written(tmp_path / "f.csv", table)
        whole = track(source, "-o", tmp_path / "whole.parquet")
        same(divided(source, "-o", tmp_path / "found.parquet"), whole)
        names = [pl.read_parquet(tmp_path / f"{n}.parquet")["target"].unique().to_list() for n in ("whole", "found")]
        assert sorted(names[0]) == sorted(names[1])


def test_formats_for_maps_are_refused_before_the_work(tmp_path, small, monkeypatch):
    source = written(tmp_path / "f.parquet", flights())
    monkeypatch.setattr(large, "PER_ROW", 10**9)
    done = CliRunner().invoke(app, ["track", str(source), "-o", str(tmp_path / "f.geojson")])
    assert done.exit_code == 2 and "geojson is written whole" in done.output
    assert [path.name for path in tmp_path.iterdir()] == ["f.parquet"]


def test_no_plausible_track_leaves_no_file(tmp_path, small, monkeypatch):
    table = flights().with_columns(pl.col("time") * 1e-4 + 1.7e9)
    source = written(tmp_path / "f.parquet", table)
    monkeypatch.setattr(large, "PER_ROW", 10**9)
    done = CliRunner().invoke(app, ["track", str(source), "-o", str(tmp_path / "o.parquet"), "--kind", "vessel"])
    assert done.exit_code == 2 and ("no track is plausible" in done.output or "no track is left" in done.output)
    assert [path.name for path in tmp_path.iterdir()] == ["f.parquet"]


@pytest.mark.parametrize("output", [(), ("-o", "t.parquet")])
def test_a_page_of_a_streamed_run_is_a_sample_that_says_so(tmp_path, monkeypatch, small, output):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(large, "PER_ROW", 10**7)
    monkeypatch.setattr(sampled.Sampled.__init__, "__defaults__", (700, *sampled.Sampled.__init__.__defaults__[1:]))
    flights().write_parquet("f.parquet")
    summary = track("f.parquet", *output, "--report", "t.html", "--memory", "1GB")
    page = Path("t.html").read_text(encoding="utf-8")
    assert "t.html" in str(summary["written"]) and ("t.parquet" in str(summary["written"])) == bool(output)
    found = re.search(r"This page shows a sample: (\d+) of 23 targets with (\d+) of ([\d,]+) rows", page)
    assert found and 0 < int(found[1]) < 23 and int(found[2]) <= 700
    assert int(found[3].replace(",", "")) == summary["accepted"]
    assert Path("t.rejected.parquet").exists()


def test_a_sample_keeps_whole_targets_and_never_none():
    tables = [pl.DataFrame({"target": [f"{k}"] * 50, "x": range(50)}) for k in range(100)]
    some = sampled.Sampled(most=600)
    assert all(some.take(table) is table for table in tables)
    kept = some.tracks()
    assert 0 < kept.height <= 600 and set(kept.group_by("target").len()["len"]) == {50}
    assert f"{kept.height // 50} of 100 targets with {kept.height} of 5,000 rows" in some.said()
    one = sampled.Sampled(most=10)
    one.take(tables[0])
    assert one.tracks().height == 50 and one.said() == ""


def test_what_memory_may_be():
    assert (
        memory_of("2GB") == 2_000_000_000 and memory_of("1.5 GiB") == 3 * 2**29 and memory_of("700000000") == 7 * 10**8
    )
    assert memory_of(None) >= 600_000_000
    for wrong in ("much", "2XB", "-1GB", "10MB", "nan", ""):
        with pytest.raises(ValueError, match="--memory is"):
            memory_of(wrong)


@pytest.mark.parametrize("option", [("-o", "-"), ("--every", "1s", "-o", "t.csv")])
def test_what_is_needed_whole_is_refused_before_it_is_read(tmp_path, monkeypatch, option):
    """Where --memory was given and does not suffice; the default bound only decides how a table is tracked."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("jink.tracking.large.PER_ROW", 10**8)
    pl.DataFrame({"target": "a", "time": range(40), "x": [200.0 * k for k in range(40)], "y": 0.0}).write_csv("in.csv")
    refused = CliRunner(env={"COLUMNS": "400"}).invoke(app, ["track", "in.csv", *option, "--memory", "2GB"])
    assert refused.exit_code == 2 and "takes about 4." in refused.output and "allows 2.0 GB" in refused.output
    assert [entry.name for entry in tmp_path.iterdir()] == ["in.csv"]
    enough = CliRunner().invoke(app, ["track", "in.csv", *option, "--memory", "9GB"])
    assert enough.exit_code == 0, enough.output
