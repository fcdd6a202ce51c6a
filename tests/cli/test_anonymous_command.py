"""`jink track` on plots without identity, from the files that `jink simulate` writes of whole skies."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from shell import run

from jink.scenarios.skies import sky_called


@pytest.fixture(scope="module")
def sky(tmp_path_factory):
    path = tmp_path_factory.mktemp("sky") / "plots.parquet"
    status, said, _ = run("simulate", "sky-parallel-200", "--runs", 1, "--seed", 4, "-o", path)
    assert status == 0 and "two aircraft side by side" in said
    return path


def test_a_simulated_sky_is_its_runs(sky):
    made = sky_called("sky-parallel-200").run(0, 4)
    plots, truth = pl.read_parquet(sky), pl.read_parquet(sky.with_name("plots.truth.parquet"))
    assert plots.columns == ["run", "time", "x", "y"]
    assert np.array_equal(plots.select("x", "y").to_numpy(), np.vstack([s.z for s in made.scans]))
    assert truth.height == 160 and truth["target"].n_unique() == 2


def test_a_table_without_identity_is_tracked_so_by_itself_and_says_it(sky, tmp_path):
    output = tmp_path / "tracks.parquet"
    status, said, _ = run("track", sky, "-o", output, "--report", tmp_path / "page.html")
    assert status == 0 and "plots have no identity" in said and "association marginal" in said
    assert (tmp_path / "page.html").stat().st_size > 10_000
    tracks, truth = pl.read_parquet(output), pl.read_parquet(sky.with_name("plots.truth.parquet"))
    assert {"existence", "confirmed", "age", "course", "manoeuvring"} <= set(tracks.columns)
    assert tracks["target"].n_unique() == 2
    assert tracks["existence"].is_between(0, 1).all() and tracks["status"].is_in(["predicted"]).any()
    # predicted rows have no plot, all others one of their own
    plotless = tracks["row"].is_null()
    assert (tracks.filter(plotless)["status"] == "predicted").all()
    used = tracks.filter(~plotless)["row"]
    assert used.n_unique() == len(used)
    assert len(used) + pl.read_parquet(tmp_path / "tracks.rejected.parquet").height == pl.read_parquet(sky).height
    # both are followed to the end, within the noise
    sure = tracks.filter("confirmed")
    joined = sure.join(truth, on="time").filter(
        ((pl.col("x") - pl.col("x_right")) ** 2 + (pl.col("y") - pl.col("y_right")) ** 2).sqrt() < 150
    )
    assert joined.select(pl.struct("time", "target_right").n_unique()).item() > 0.9 * 160


def test_what_is_not_given_is_estimated(sky):
    status, said, _ = run("track", sky, "--json")
    summary = json.loads(said)
    assert status == 0
    assert summary["noise"][0]["position_sd"] == pytest.approx(50, rel=0.25)
    assert summary["noise"][0]["position_sd_from"] == "estimated"
    assert summary["association"]["detection"] == pytest.approx(0.9, abs=0.08)
    assert summary["rows"] == summary["accepted"] + sum(summary["rejected"].values())


def test_given_figures_are_used_and_an_identity_is_not_believed_where_asked(sky, tmp_path):
    plots = pl.read_parquet(sky).with_columns(target=pl.lit("one"))
    plots.write_parquet(tmp_path / "named.parquet")
    options = ["--sensor-sd", 50, "--detection", 0.9, "--clutter", 21, "--association", "gnn", "--smooth"]
    status, said, _ = run("track", tmp_path / "named.parquet", "--anonymous", *options, "--json")
    summary = json.loads(said)
    assert status == 0 and summary["smoothed"] and summary["association"]["association"] == "gnn"
    assert summary["association"]["detection"] == 0.9 and summary["noise"][0]["position_sd"] == 50
    assert summary["targets"] in (2, 3)


def test_places_on_the_map_come_back_as_such(sky, tmp_path):
    plots = pl.read_parquet(sky)
    degree = 111_195.0
    plots.select("time", latitude=pl.col("y") / degree, longitude=10 + pl.col("x") / degree).write_parquet(
        tmp_path / "map.parquet"
    )
    status, _, _ = run("track", tmp_path / "map.parquet", "-o", tmp_path / "t.geojson", "--sensor-sd", 50)
    assert status == 0
    places = json.loads((tmp_path / "t.geojson").read_text())["features"]
    assert len(places) >= 2 and 10 < places[0]["geometry"]["coordinates"][0][0] < 10.7


def test_plots_with_times_of_their_own_need_the_period(sky, tmp_path):
    plots = pl.read_parquet(sky)
    rng = np.random.default_rng(0)
    # an antenna at the corner that turns once in 4 s
    turn = np.arctan2(plots["y"], plots["x"]) / (2 * np.pi) * 4.0
    plots = plots.with_columns(time=pl.col("time") + turn + 1e-6 * rng.random(len(plots))).sort("time")
    plots.write_parquet(tmp_path / "turning.parquet")
    status, _, said = run("track", tmp_path / "turning.parquet", "--anonymous", "--json")
    assert status == 2 and "--period" in said
    status, said, _ = run("track", tmp_path / "turning.parquet", "--period", 4, "--sensor-sd", 50, "--json")
    assert status == 0 and json.loads(said)["targets"] == 2


@pytest.mark.parametrize(
    "options, says",
    [
        (["--association", "best"], "unknown association 'best'"),
        (["--detection", 1.5], "detection is 1.5; expected a probability between 0 and 1"),
        (["--clutter", -2], "clutter is -2.0; expected a number from 0"),
        (["--new-per-hour", -2], "new-per-hour is -2.0"),
        (["--drop-after", 0], "drop-after is 0.0; expected seconds above 0"),
        (["--period", -1], "period is -1.0"),
        (["--filter", "gpb2"], "GPB2 cannot track plots without identity: it keeps every pair of modes apart"),
        (["--filter", "input-estimation"], "cannot track plots without identity"),
    ],
)
def test_what_makes_no_sense_is_refused_with_status_2(sky, options, says):
    status, _, said = run("track", sky, "--json", *options)
    assert status == 2 and says in said


def test_a_coarse_clock_does_not_make_several_targets_of_one(tmp_path):
    # five positions a second, stamped to the second
    k = np.arange(600)
    rng = np.random.default_rng(2)
    pl.DataFrame(
        {"time": (k // 5).astype(float), "x": 30.0 * k / 5 + rng.normal(0, 3, 600), "y": rng.normal(0, 3, 600)}
    ).write_parquet(tmp_path / "one.parquet")
    status, said, _ = run("track", tmp_path / "one.parquet", "--json")
    assert status == 0 and "association" not in json.loads(said)


def test_false_plots_alone_are_no_track(tmp_path):
    rng = np.random.default_rng(1)
    place = rng.uniform(0, 1e5, (200, 2))
    pl.DataFrame({"time": np.repeat(np.arange(20.0) * 4, 10), "x": place[:, 0], "y": place[:, 1]}).write_parquet(
        tmp_path / "false.parquet"
    )
    status, _, said = run("track", tmp_path / "false.parquet", "--sensor-sd", 50, "--detection", 0.9, "--json")
    assert status == 2 and "no track was confirmed in 20 scans of 200 plots" in said


def test_standard_input_has_no_scans(sky):
    status, _, said = run("track", "-", "--anonymous")
    assert status == 2 and "jink.Tracker.scan" in said


def test_a_sky_has_its_own_sensor_and_a_wrong_name_is_refused(tmp_path):
    status, _, said = run("simulate", "sky-dense", "--sensor", "radar-4s", "-o", tmp_path / "s.parquet")
    assert status == 2 and "seen by its own sensor" in said
    status, _, said = run("simulate", "sky-dens", "-o", tmp_path / "s.parquet")
    assert status == 2 and "sky-dense" in said


def test_filters_and_associations_race_on_a_sky(tmp_path):
    options = ["--filters", "imm,kalman-cv", "--association", "marginal,pda", "--runs", 2, "--seed", 5]
    status, said, _ = run("compare", "sky-parallel", *options, "--json", tmp_path / "race.json")
    assert status == 0 and "GOSPA" in said and "cut-off 300 m" in said
    race = json.loads((tmp_path / "race.json").read_text())
    entrants = {(e["filter"], e["association"]): e for e in race["entrants"]}
    assert len(entrants) == 4 and race["runs"] == 2
    # two tracks on one plot are false ones
    assert entrants["imm", "pda"]["spurious"] > entrants["imm", "marginal"]["spurious"] + 0.2
    assert entrants["imm", "marginal"]["gospa"][0] < entrants["imm", "pda"]["gospa"][0]


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["sky-parallel", "--association", "best"], "unknown association 'best'"),
        (["sky-parallel", "--filters", "gpb2"], "cannot track plots without identity"),
        (["sky-paralel"], "sky-parallel"),
        (["sky-parallel", "--sensor", "radar-4s"], "sensor options do not apply"),
        (["lee-2003", "--association", "gnn"], "--association needs a whole sky"),
    ],
)
def test_a_race_that_makes_no_sense_is_refused(arguments, says):
    status, _, said = run("compare", *arguments, "--runs", 1)
    assert status == 2 and says in said


def test_the_same_in_python(sky):
    import jink

    table = pl.read_parquet(sky)
    found = jink.track(table, anonymous={"detection": 0.9, "association": "marginal"}, sensor_sd=50, details=True)
    status, said, _ = run("track", sky, "--detection", 0.9, "--sensor-sd", 50, "--json")
    assert status == 0 and json.loads(said)["accepted"] == found.summary["accepted"]
    assert found.tracks["target"].n_unique() == 2 and found.rejected.height + found.summary["accepted"] == table.height
    with pytest.raises(ValueError, match="unknown option 'detektion'; did you mean detection"):
        jink.track(table, anonymous={"detektion": 0.9})


def test_one_aircraft_in_dense_clutter_is_found_without_any_hint(tmp_path):
    status, _, _ = run("simulate", "sky-dense", "--runs", 1, "--seed", 5, "-o", tmp_path / "s.parquet")
    assert status == 0
    status, said, _ = run("track", tmp_path / "s.parquet", "--json")
    summary = json.loads(said)
    assert status == 0 and summary["targets"] == 1 and summary["rows"] > 5000
    assert summary["noise"][0]["position_sd"] == pytest.approx(50, rel=0.25)
    assert any("new targets an hour (estimated)" in note for note in summary["notes"])


@pytest.mark.parametrize("options", [[], ["--smooth"]])
def test_the_example_s_four_aircraft_are_four_without_their_names(tmp_path, options):
    """One of them turns at 2 g, harder than the kind believes, and a turn's plots are seconds apart."""
    source = Path(__file__).parents[2] / "examples" / "radar.csv"
    asked = ["--anonymous", "--period", 4, *options]
    status, said, _ = run("track", source, *asked, "-o", tmp_path / "t.parquet", "--json")
    assert status == 0 and json.loads(said)["targets"] == 4
    named = pl.read_csv(source).with_row_index("row").select(pl.col("row").cast(pl.Int64), name="target")
    rows = pl.read_parquet(tmp_path / "t.parquet").drop_nulls("row").with_columns(pl.col("row").cast(pl.Int64))
    pairs = rows.join(named, on="row").group_by("target", "name").len()
    # each track has the plots of one target alone, all but its first or so
    assert sorted(pairs["name"]) == ["T1", "T2", "T3", "T4"] and rows.height >= 368 - 8
