"""Identifiers of digits keep the zeros in front of them, whichever way a CSV file is read."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

import jink
from jink.cli.main import app_of


def written(path: Path, names: list[str], column: str = "mmsi", rows: int = 60) -> Path:
    rng, time = np.random.default_rng(4), np.arange(float(rows))
    pl.concat(
        pl.DataFrame(
            {
                column: name,
                "time": time,
                "x": 200 * time + rng.normal(0, 5, rows),
                "y": 9e3 * k + rng.normal(0, 5, rows),
            }
        ).with_columns(squawk=pl.lit("0123"))
        for k, name in enumerate(names)
    ).write_csv(path)
    return path


@pytest.mark.parametrize("column, given", [("mmsi", None), ("whose", {"target": "whose"})])
def test_two_targets_that_differ_in_zeros_alone_stay_two(tmp_path, column, given):
    path = written(tmp_path / "a.csv", ["007", "07", "12"], column)
    tracks = jink.track(path, columns=given, keep=["squawk"])
    assert tracks["target"].unique().sort().to_list() == ["007", "07", "12"]
    assert tracks["squawk"].unique().to_list() == ["0123"]


def test_a_target_has_one_name_in_files_of_digits_and_of_letters(tmp_path):
    files = [written(tmp_path / "a.csv", ["004512"]), written(tmp_path / "b.csv", ["004512", "abc123"])]
    assert jink.track(files, details=True).tracks["target"].unique().sort().to_list() == ["004512", "abc123"]


def test_whole_numbers_are_as_they_were(tmp_path):
    assert set(jink.track(written(tmp_path / "a.csv", ["0", "10"]))["target"]) == {"0", "10"}


def test_a_table_larger_than_its_memory_has_the_same_names(tmp_path):
    path = written(tmp_path / "a.csv", ["007", "07"], rows=130_000)
    done = CliRunner().invoke(
        app_of("track", "report"),
        ["track", str(path), "-o", str(tmp_path / "t.parquet"), "--memory", "600MB", "--json"],
    )
    assert done.exit_code == 0 and "larger than --memory" in done.output
    assert set(pl.read_parquet(tmp_path / "t.parquet")["target"].unique()) == {"007", "07"}
