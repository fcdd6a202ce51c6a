"""`jink track` on the plots of an antenna that turns: sector by sector where azimuths go with times."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from shell import run

PERIOD, SD = 4.0, 50.0
# across the cut of a turn clockwise, across it anticlockwise, and far from it
PLACE = np.array([[-6e3, 20e3], [6e3, 30e3], [-15e3, -20e3]])
VELOCITY = np.array([[200.0, 0.0], [-220.0, 10.0], [150.0, 100.0]])


@pytest.fixture(scope="module")
def turning(tmp_path_factory):
    """60 turns, one target in ten missed, three false plots a turn."""
    rng = np.random.default_rng(4)
    rows = []
    fine = np.linspace(0.0, 60.0, 60 * 400 + 1)
    for target, (place, velocity) in enumerate(zip(PLACE, VELOCITY, strict=True)):
        there = place + velocity * (PERIOD * fine)[:, None]
        turn = fine - np.unwrap(np.arctan2(there[:, 0], there[:, 1]) % (2 * np.pi)) / (2 * np.pi)
        for k in np.flatnonzero(np.floor(turn[1:]) > np.floor(turn[:-1])) + 1:
            if rng.random() < 0.9:
                rows.append((PERIOD * fine[k], *(there[k] + SD * rng.standard_normal(2)), target))
    for k in range(60 * 3):
        x, y = rng.uniform(-4e4, 4e4, 2)
        rows.append((PERIOD * (k // 3 + np.arctan2(x, y) / (2 * np.pi) % 1), x, y, -1))
    table = pl.DataFrame(rows, schema=["time", "x", "y", "truth"], orient="row").sort("time")
    path = tmp_path_factory.mktemp("turning") / "plots.parquet"
    table.drop("truth").write_parquet(path)
    return path, table


def tracks_of(path, folder, *options):
    status, said, _ = run("track", path, "-o", folder / "t.parquet", "--sensor-sd", SD, "--json", *options)
    assert status == 0
    return json.loads(said), pl.read_parquet(folder / "t.parquet")


@pytest.mark.parametrize("options", [["--period", 4], ["--sectors", 12], ["--period", 4, "--smooth"]])
def test_an_antenna_that_turns_is_found_said_and_followed_by_sectors(turning, tmp_path, options):
    path, table = turning
    summary, tracks = tracks_of(path, tmp_path, "--anonymous", *options)
    count = options[1] if options[0] == "--sectors" else 16
    assert summary["association"]["sectors"] == count
    assert summary["association"]["period"] == pytest.approx(PERIOD, rel=1e-3)
    assert any("the antenna turns clockwise in 4" in note for note in summary["notes"])
    assert summary["targets"] == 3
    # each track has one target's plots alone, and one row a turn
    truth = table.with_row_index("row").select(pl.col("row").cast(pl.Int64), "truth")
    used = tracks.drop_nulls("row").with_columns(pl.col("row").cast(pl.Int64)).join(truth, on="row")
    mine = used.filter(pl.col("truth") >= 0)
    assert mine.height > 0.95 * (table["truth"] >= 0).sum() - 6 and used["row"].n_unique() == used.height
    assert mine.group_by("target").agg(pl.col("truth").n_unique())["truth"].to_list() == [1, 1, 1]
    steps = tracks.sort("target", "time").with_columns(step=pl.col("time").diff().over("target")).drop_nulls("step")
    assert steps["step"].is_between(3.4, 4.6).all()
    assert len(used) + pl.read_parquet(tmp_path / "t.rejected.parquet").height == table.height


def test_turns_are_taken_whole_where_it_is_asked_for(turning, tmp_path):
    summary, _ = tracks_of(turning[0], tmp_path, "--period", 4, "--sectors", 1)
    assert "sectors" not in summary["association"] and summary["targets"] >= 3


def test_an_error_tells_the_time_of_a_turn(turning):
    status, _, said = run("track", turning[0], "--anonymous")
    assert status == 2 and "--period SECONDS" in said and "as with one that takes 4 s" in " ".join(said.split())


@pytest.mark.parametrize(
    "options, says",
    [
        (["--period", 4, "--sectors", 16], "azimuths of the plots do not go with their times"),
        (["--period", 4, "--sectors", 2], "sectors is 2; expected 3 to 3600 of a turn, or 1 for whole turns"),
    ],
)
def test_sectors_need_an_antenna_that_turns(options, says):
    source = Path(__file__).parents[2] / "examples" / "radar.csv"
    status, _, said = run("track", source, "--anonymous", *options)
    assert status == 2 and says in " ".join(said.split())
