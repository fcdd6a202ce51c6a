"""`jink simulate`: what it writes, that it is the same whatever the pieces, and how it fails."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import shell

from jink.scenarios import SCENARIOS
from jink.scenarios.table import simulation_table


def run(*arguments: object) -> tuple[int, str, str]:
    return shell.run("simulate", *arguments)


def test_measurements_and_truth_in_one_table(tmp_path):
    output = tmp_path / "s.parquet"
    status, said, _ = run("lee-2003", "-o", output, "--runs", 7, "--seed", 3)
    assert status == 0 and "1,260 rows" in said
    table, made = pl.read_parquet(output), SCENARIOS["lee-2003"].simulate(7, 3)
    assert table.height == 7 * 180
    for columns, values in [
        (["x", "y"], made.z),
        (["true_x", "true_y"], made.truth.position),
        (["true_velocity_x", "true_velocity_y"], made.truth.velocity),
        (["true_acceleration_x", "true_acceleration_y"], made.truth.acceleration),
        (["input_x", "input_y"], made.input),
    ]:
        np.testing.assert_array_equal(table.select(columns).to_numpy(), values.reshape(-1, 2))
    assert table.filter(pl.col("run") == 4)["target"].unique().to_list() == ["4"]


@pytest.mark.parametrize("name", ["s.parquet", "s.csv", "s.jsonl", "s.arrow", "s.csv.gz"])
def test_pieces_make_the_same_file_content(tmp_path, monkeypatch, name):
    whole = simulation_table(SCENARIOS["drone"].simulate(5, 1))
    monkeypatch.setattr("jink.scenarios.scenario.CHUNK_ROWS", 800)
    status, _, _ = run("drone", "-o", tmp_path / name, "--runs", 5, "--seed", 1)
    assert status == 0
    readers = {"parquet": pl.read_parquet, "arrow": pl.read_ipc, "jsonl": pl.read_ndjson}
    table = readers.get(name.rpartition(".")[2], pl.read_csv)(tmp_path / name)
    for column in whole.columns[3:]:
        np.testing.assert_allclose(table[column].to_numpy(), whole[column].to_numpy(), rtol=1e-12)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_threads_change_nothing():
    chosen = SCENARIOS["random-turns"]
    with ThreadPoolExecutor(4) as pool:
        pieces = list(pool.map(lambda run: chosen.simulate([run], 9).z[0], range(12)))
    np.testing.assert_array_equal(np.stack(pieces), chosen.simulate(12, 9).z)


def test_other_sensors(tmp_path):
    output = tmp_path / "s.csv"
    status, said, _ = run(
        "benchmark-2",
        "-o",
        output,
        "--runs",
        3,
        "--sensor",
        "radar-4s",
        "--detection",
        0.7,
        "--outliers",
        0.1,
        "--bias",
        "100,0,0",
        "--json",
    )
    summary = json.loads(said)
    assert status == 0 and summary["rows"] == 3 * 47
    for piece in ("polar", "detection 0.7", "10.0% outliers", "bias (100.0, 0.0, 0.0)"):
        assert piece in summary["sensor"]
    table = pl.read_csv(output)
    assert {"range", "azimuth_deg", "altitude_m"} < set(table.columns)
    assert 0.1 < table["range"].is_null().mean() < 0.5
    status, _, _ = run("weave", "-o", output, "--runs", 2, "--sensor", 75, "--interval", 2, "--jitter", 0.1, "-q")
    assert status == 0 and pl.read_csv(output).height == 2 * 90


def test_jink_track_reads_it(tmp_path):
    import jink

    run("terminal-area", "-o", tmp_path / "s.parquet", "--runs", 4, "--detection", 0.9)
    table = pl.read_parquet(tmp_path / "s.parquet")
    tracks = jink.track(table, smooth=True, details=True).tracks
    joined = tracks.join(table.with_row_index("row").cast({"row": tracks["row"].dtype}), on="row", suffix="_read")
    ground = (joined["velocity_x"] - joined["true_velocity_x"]) ** 2 + (
        joined["velocity_y"] - joined["true_velocity_y"]
    ) ** 2
    assert joined.height > 0.9 * table.height
    assert np.sqrt(ground.drop_nulls().drop_nans().mean()) < 25.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["lee-203"], "did you mean lee-2003?"),
        (["nothing-like-it"], "Known: lee-2003"),
        (["lee-2003", "--runs", 0], "--runs is 0"),
        (["lee-2003", "--runs", -4], "--runs is -4"),
        (["lee-2003", "--seed", -1], "--seed is -1"),
        (["lee-2003", "--seed", "x"], "--seed"),
        (["lee-2003", "--sensor", "radar-3s"], "did you mean radar-4s"),
        (["lee-2003", "--sensor", "-3"], "--sensor is -3"),
        (["lee-2003", "--interval", 0], "interval: expected"),
        (["lee-2003", "--jitter", 0.7], "jitter: expected"),
        (["lee-2003", "--detection", 1.5], "detection: expected"),
        (["lee-2003", "--outliers", -0.1], "outlier_share: expected"),
        (["lee-2003", "--bias", "1"], "bias: expected one number for each of x, y"),
        (["lee-2003", "--bias", "a,b"], "--bias is 'a,b'"),
        (["not/there.parquet"], "there is no file not/there.parquet"),
    ],
)
def test_bad_requests(tmp_path, arguments, said):
    status, _, error = run(*arguments, "-o", tmp_path / "s.parquet")
    assert status == 2
    assert said in error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "said"),
    [("s.xyz", "unknown extension"), ("s.geojson", "cannot be GeoJSON"), ("no/s.csv", "there is no directory")],
)
def test_bad_outputs(tmp_path, name, said):
    status, _, error = run("lee-2003", "-o", tmp_path / name)
    assert status == 2 and said in error


def test_errors_as_json(tmp_path):
    status, out, _ = run("lee-203", "-o", tmp_path / "s.csv", "--json")
    assert status == 2 and json.loads(out)["status"] == 2


def test_a_recorded_file_becomes_a_scenario(tmp_path):
    flights = Path(__file__).parents[2] / "examples" / "flights.parquet"
    status, said, _ = run(flights, "-o", tmp_path / "s.parquet", "--runs", 3)
    assert status == 0 and "recorded tracks, smoothed" in said
    assert pl.read_parquet(tmp_path / "s.parquet").height == 3 * 75
    copy = tmp_path / "copy.parquet"
    copy.write_bytes(b"")
    status, _, error = run(copy, "-o", copy)
    assert status == 2 and "the output needs another name" in error
