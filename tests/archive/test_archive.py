"""A folder of tracks has the tracks of one table in memory, row by row."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal
from typer.testing import CliRunner

from jink.archive import reducing, run, settling
from jink.cli.main import app
from jink.tracking import large, prepare

SAME = ("--threads", "1")


def track(*arguments: object) -> dict:
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["track", *map(str, arguments), "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def refused(*arguments: object) -> str:
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["track", *map(str, arguments), "--quiet"])
    assert done.exit_code == 2, done.output
    return done.stderr


def flights(targets: int = 30, rows: int = 80) -> pl.DataFrame:
    """Aircraft by time; a third without altitude, one of many rows, one of two, two rows without a place."""
    rng, frames = np.random.default_rng(3), []
    for k in range(targets):
        count = 2 if k == 0 else 700 if k == 1 else rows
        t = 5.0 * np.arange(count) + 7.0 * k
        noise = rng.normal(scale=(10.0 + k) / 111_000, size=(2, count))
        high = 3000.0 + t + rng.normal(scale=8.0, size=count)
        frames.append(
            pl.DataFrame(
                {
                    "icao24": f"{(7919 * k) % 4096:03x}",
                    "callsign": f"JNK{k}",
                    "time": 1.7e9 + t,
                    "latitude": 48.0 + 0.1 * k + 0.0009 * np.arange(count) + noise[0],
                    "longitude": 11.0 + 0.0004 * np.arange(count) * (-1) ** k + noise[1],
                    "altitude": np.where(k % 3, high, np.nan),
                }
            )
        )
    table = pl.concat(frames).sort("time", maintain_order=True)
    wrong = pl.int_range(pl.len()).is_in([5, 900])
    return table.with_columns(latitude=pl.when(wrong).then(95.0).otherwise("latitude"))


def in_files(folder: Path, table: pl.DataFrame, count: int = 4) -> list[Path]:
    """The table in hourly files: targets go on from one to the next."""
    paths = []
    for number in range(count):
        low, high = (number * table.height // count, (number + 1) * table.height // count)
        path = folder / f"hour{number}.parquet"
        table.slice(low, high - low).write_parquet(path)
        paths.append(path)
    return paths


def all_rows(folder: Path) -> pl.DataFrame:
    return (
        pl.scan_parquet(f"{folder}/*/*.parquet")
        .drop("bucket", strict=False)
        .collect()
        .sort("target", "time", maintain_order=True)
    )


def hashes(folder: Path) -> dict[str, str]:
    """Of all files with tracks."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.glob("bucket=*/*"))
    }


@pytest.fixture
def hours(tmp_path, monkeypatch):
    """Four files, of which a sample decides."""
    monkeypatch.setattr(prepare, "EVIDENCE", 900)
    monkeypatch.setattr(settling, "EVIDENCE", 900)
    monkeypatch.setattr(large, "EVIDENCE", 900)
    return in_files(tmp_path, flights())


@pytest.mark.parametrize("options", [(), ("--smooth",), ("--sensor-sd", "20", "--filter", "kalman-cv")])
def test_rows_are_those_of_a_table_in_memory(tmp_path, hours, options):
    whole = track(*hours, "-o", tmp_path / "whole.parquet", *options)
    summary = track(*hours, "-o", f"{tmp_path}/tracks/", *SAME, *options)
    expected = pl.read_parquet(tmp_path / "whole.parquet").sort("target", "time", maintain_order=True)
    assert_frame_equal(all_rows(tmp_path / "tracks"), expected, check_exact=True)
    rejected = [pl.read_parquet(tmp_path / f"{name}.rejected.parquet") for name in ("whole", "tracks")]
    order = "file", "row"
    assert_frame_equal(rejected[1].sort(order), rejected[0].sort(order))
    for name in ("rows", "accepted", "rejected", "targets", "parts", "start", "end", "cleaning", "status", "columns"):
        assert summary[name] == whole[name], name
    assert summary["settled"]["targets"] < summary["settled"]["of_targets"]


def test_a_small_table_decides_by_all_its_rows(tmp_path):
    rows_of_a_folder_are_those_of_a_file(tmp_path, in_files(tmp_path, flights()))


def test_speeds_without_a_course_are_used_by_the_figures_of_their_target(tmp_path):
    """One row in thirty reports a wrong speed: what is usual is known from all rows, not from those of a bucket."""
    table, rng = flights(), np.random.default_rng(8)
    wrong = np.where(rng.random(table.height) < 0.03, 15.0, 0.0)
    files = in_files(tmp_path, table.with_columns(speed=20.9 + wrong + rng.normal(0, 0.5, table.height)))
    rows_of_a_folder_are_those_of_a_file(tmp_path, files)
    summary = track(*files, "-o", tmp_path / "whole.parquet")
    assert any("the reported velocity is used" in note for note in summary["notes"])


def rows_of_a_folder_are_those_of_a_file(tmp_path, files):
    track(*files, "-o", tmp_path / "whole.parquet")
    track(*files, "-o", f"{tmp_path}/tracks/", *SAME)
    expected = pl.read_parquet(tmp_path / "whole.parquet").sort("target", "time", maintain_order=True)
    assert_frame_equal(all_rows(tmp_path / "tracks"), expected, check_exact=True)


def test_files_in_pieces_have_the_same_rows(tmp_path, hours, monkeypatch):
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    monkeypatch.setattr(run, "LEAST_PIECE", 250)
    monkeypatch.setattr(run, "PER_ROW", 10**9)
    track(*hours, "-o", f"{tmp_path}/pieces/", *SAME)
    assert_frame_equal(all_rows(tmp_path / "pieces"), all_rows(tmp_path / "whole"), check_exact=True)


@pytest.mark.parametrize("options", [(), ("--smooth",)])
def test_a_bucket_that_is_too_large_is_tracked_some_targets_at_a_time(tmp_path, hours, monkeypatch, options):
    """The rows, and their order in each bucket, are those of buckets that are tracked at once."""
    monkeypatch.setattr(run, "SHARE", 250)
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME, *options)
    monkeypatch.setattr(run, "LEAST_PIECE", 250)
    monkeypatch.setattr(run, "PER_ROW", 10**9)
    sizes, once = [], reducing.Shares.tables
    monkeypatch.setattr(
        reducing.Shares, "tables", lambda self, rows: sizes.append(rows.rows.height) or once(self, rows)
    )
    summary = track(*hours, "-o", f"{tmp_path}/shares/", *SAME, *options)
    assert len(sizes) > summary["buckets"] and all(size <= 250 or 690 < size <= 700 for size in sizes)
    for path in sorted((tmp_path / "whole").glob("bucket=*/part.parquet")):
        other = pl.read_parquet(tmp_path / "shares" / path.parent.name / path.name)
        assert_frame_equal(other, pl.read_parquet(path), check_exact=True)


def test_two_processes_write_the_same_bytes_as_one(tmp_path):
    hours = in_files(tmp_path, flights())
    track(*hours, "-o", f"{tmp_path}/one/", *SAME)
    track(*hours, "-o", f"{tmp_path}/two/", "--threads", 2)
    assert hashes(tmp_path / "one") == hashes(tmp_path / "two")


def test_pieces_of_which_one_is_on_the_ground(tmp_path, monkeypatch):
    table = flights().with_columns(on_ground=pl.int_range(pl.len()) > pl.len() - 40)
    monkeypatch.setattr(run, "LEAST_PIECE", 250)
    monkeypatch.setattr(run, "PER_ROW", 10**9)
    summary = track(*in_files(tmp_path, table, 1), "-o", f"{tmp_path}/tracks/", *SAME)
    assert summary["accepted"] > 2000
    assert all_rows(tmp_path / "tracks")["on_ground"].any()
