"""What a folder of tracks refuses, what it goes on with, and what it does with bad files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import polars as pl
import pytest
from polars.testing import assert_frame_equal
from test_archive import SAME, all_rows, flights, hashes, in_files, refused, track
from typer.testing import CliRunner

from jink.archive import reading, run, settling
from jink.cli.main import app
from jink.tracking import prepare


@pytest.fixture
def hours(tmp_path):
    return in_files(tmp_path, flights())


def test_a_complete_folder_is_not_made_again(tmp_path, hours, monkeypatch):
    first = track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    monkeypatch.setattr(run, "settle", None)
    second = track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert second == first


@pytest.mark.parametrize("seconds", [0.9, 1.4, 1.9, 2.4])
def test_killed_and_run_again_it_has_the_same_bytes(tmp_path, hours, seconds):
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    command = [sys.executable, "-m", "jink", "track", *map(str, hours), "-o", f"{tmp_path}/tracks/", "--threads", "2"]
    process = subprocess.Popen([*command, "--quiet"], start_new_session=True)
    time.sleep(seconds)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    time.sleep(0.5)
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert hashes(tmp_path / "tracks") == hashes(tmp_path / "whole")
    assert names_of(tmp_path / "tracks") == names_of(tmp_path / "whole")


def names_of(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_what_is_finished_is_skipped(tmp_path, hours, monkeypatch):
    """The second run maps no file again, and tracks the buckets that the first one did not."""
    once = run.reduce_bucket
    seen = []

    def reduce_bucket(*arguments):
        if len(seen) == 3:
            raise KeyboardInterrupt
        seen.append(arguments[2])
        return once(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(run, "reduce_bucket", reduce_bucket)
        stopped = CliRunner().invoke(app, ["track", *map(str, hours), "-o", f"{tmp_path}/tracks/", *SAME, "--quiet"])
        assert stopped.exit_code != 0
    assert not (tmp_path / "tracks/.jink/manifest.json").exists()
    rest = []
    monkeypatch.setattr(run, "map_file", None)
    monkeypatch.setattr(run, "reduce_bucket", lambda *given: rest.append(given[2]) or once(*given))
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert sorted([*seen, *rest]) == list(range(8)) and len(seen) == 3
    monkeypatch.undo()
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    assert hashes(tmp_path / "tracks") == hashes(tmp_path / "whole")


def test_other_settings_are_refused_by_name(tmp_path, hours):
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    before = hashes(tmp_path / "tracks")
    said = refused(*hours, "-o", f"{tmp_path}/tracks/", *SAME, "--kind", "vessel")
    assert "was made with kind 'aircraft', now it is 'vessel'" in said
    assert "smooth False" in refused(*hours, "-o", f"{tmp_path}/tracks/", *SAME, "--smooth")
    assert hashes(tmp_path / "tracks") == before


def test_other_inputs_are_refused_by_name(tmp_path, hours):
    track(*hours[:3], "-o", f"{tmp_path}/tracks/", *SAME)
    assert "hour3.parquet is not in" in refused(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert "was made from" in refused(*hours[:2], "-o", f"{tmp_path}/tracks/", *SAME)
    flights(rows=9).write_parquet(hours[0])
    assert "hour0.parquet has changed since" in refused(*hours[:3], "-o", f"{tmp_path}/tracks/", *SAME)


def test_a_folder_with_other_files_is_refused(tmp_path, hours):
    (tmp_path / "tracks").mkdir()
    (tmp_path / "tracks/letter.txt").write_text("dear")
    assert "has other files in it (letter.txt)" in refused(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert names_of(tmp_path / "tracks") == ["letter.txt"]


@pytest.mark.parametrize("options", [(), ("--sensor-sd", "20", "--filter", "kalman-cv", "--no-velocity")])
def test_appended_files_give_the_tracks_of_all(tmp_path, hours, options):
    """What the first files settled holds: so the whole run that is compared is told to let them decide."""
    track(*hours[:3], "-o", f"{tmp_path}/days/", *SAME, *options)
    track(hours[3], "-o", f"{tmp_path}/days/", "--append", *SAME, *options)
    made = run._new_plan
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "_new_plan", lambda *given: _decided_by(made(*given), 3))
        track(*hours, "-o", f"{tmp_path}/whole/", *SAME, *options)
    assert hashes(tmp_path / "days") == hashes(tmp_path / "whole")
    assert all_rows(tmp_path / "days").height > 2000


def _decided_by(plan, first):
    plan.first = first
    return plan


def test_only_touched_buckets_are_tracked_again(tmp_path, hours, monkeypatch):
    monkeypatch.setattr(prepare, "EVIDENCE", 900)
    monkeypatch.setattr(settling, "EVIDENCE", 900)
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    before = hashes(tmp_path / "tracks")
    pl.read_parquet(hours[3]).filter(icao24="eef").with_columns(pl.col("time") + 9e4).write_parquet(
        tmp_path / "x.parquet"
    )
    once, again = run.reduce_bucket, []
    monkeypatch.setattr(run, "reduce_bucket", lambda *given: again.append(given[2]) or once(*given))
    track(tmp_path / "x.parquet", "-o", f"{tmp_path}/tracks/", "--append", *SAME)
    after = hashes(tmp_path / "tracks")
    assert len(again) == 1
    assert [name for name in after if after[name] != before[name]] == [f"bucket={again[0]:03d}/part.parquet"]


def test_a_bad_file_is_left_out_by_name_and_strict_stops(tmp_path, hours):
    bad = tmp_path / "hour9.parquet"
    bad.write_bytes(b"PAR1 and then nothing")
    summary = track(*hours, bad, "-o", f"{tmp_path}/tracks/", *SAME)
    rejected = pl.read_parquet(tmp_path / "tracks.rejected.parquet").filter(reason="the file cannot be read")
    assert rejected["file"].to_list() == [str(bad)]
    assert any("hour9.parquet" in note for note in summary["notes"])
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    assert hashes(tmp_path / "tracks") == hashes(tmp_path / "whole")
    assert "hour9.parquet is not a readable" in refused(*hours, bad, "-o", f"{tmp_path}/strict/", "--strict", *SAME)


def test_files_that_do_not_go_together_are_refused_with_both(tmp_path, hours):
    without = tmp_path / "without.parquet"
    pl.read_parquet(hours[0]).drop("icao24", "callsign").write_parquet(without)
    said = refused(*hours, without, "-o", f"{tmp_path}/a/", *SAME)
    assert "has a column of targets and" in said and "without.parquet has none" in said
    assert "target = icao24" in said and "latitude = latitude" in said
    plane = tmp_path / "plane.parquet"
    pl.read_parquet(hours[0]).rename({"latitude": "x", "longitude": "y"}).drop("altitude").write_parquet(plane)
    assert "geographic positions and" in refused(*hours, plane, "-o", f"{tmp_path}/b/", *SAME)


def test_dates_and_plain_seconds_are_refused_with_the_columns_of_both(tmp_path, hours):
    seconds = tmp_path / "seconds.parquet"
    table = pl.read_parquet(hours[0]).drop("callsign")
    table.with_columns(pl.col("time") - 1.7e9).rename({"time": "t"}).write_parquet(seconds)
    said = refused(*hours, seconds, "-o", f"{tmp_path}/a/", *SAME)
    assert "hour0.parquet has dates and" in said and "seconds.parquet has plain seconds" in said
    lines = said.splitlines()
    assert any("hour0.parquet: " in line and "time = time" in line for line in lines)
    assert any("seconds.parquet: " in line and "time = t" in line for line in lines)
    assert names_of(tmp_path / "a/bucket=000") == []


def test_files_of_other_units_names_and_types_are_unified(tmp_path, hours):
    """Feet and metres, another name of the same column, text and numbers, written dates and seconds since 1970."""
    table = pl.read_parquet(hours[1])
    table = table.with_columns(altitude=pl.col("altitude") / 0.3048).rename({"altitude": "altitude_ft"})
    table.write_parquet(hours[1])
    pl.read_parquet(hours[2]).rename({"latitude": "lat", "longitude": "lon"}).cast({"lat": pl.String}).write_parquet(
        hours[2]
    )
    date = pl.from_epoch(pl.col("time").cast(pl.Int64)).dt.strftime("%Y-%m-%dT%H:%M:%SZ")
    pl.read_parquet(hours[3]).with_columns(time=date).write_parquet(hours[3])
    track(*hours, "-o", tmp_path / "whole.parquet")
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    expected = pl.read_parquet(tmp_path / "whole.parquet").sort("target", "time", maintain_order=True)
    assert_frame_equal(all_rows(tmp_path / "tracks"), expected, check_exact=True)


def test_files_of_different_columns_are_unified(tmp_path, hours):
    pl.read_parquet(hours[1]).drop("callsign").write_parquet(hours[1])
    pl.read_parquet(hours[2]).with_columns(callsign=pl.lit(7)).write_parquet(hours[2])
    track(*hours, "-o", tmp_path / "whole.parquet")
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    expected = pl.read_parquet(tmp_path / "whole.parquet").sort("target", "time", maintain_order=True)
    assert_frame_equal(all_rows(tmp_path / "tracks"), expected, check_exact=True)


def test_events_say_rows_speed_and_time_left(tmp_path, hours):
    arguments = ["track", *map(str, hours), "-o", f"{tmp_path}/tracks/", *SAME, "--json"]
    done = CliRunner().invoke(app, arguments)
    events = [json.loads(line) for line in done.stderr.splitlines()]
    last = {event["event"]: event for event in events}
    rows = json.loads(done.stdout)["rows"]
    assert last["map"]["done"] == 4 and last["map"]["rows"] == rows and last["map"]["seconds_left"] == 0
    assert last["reduce"]["done"] == last["reduce"]["of"] == 8
    assert all(event["rows_per_second"] >= 0 for event in events if event["event"] != "settle")


def test_another_version_is_refused(tmp_path, hours, monkeypatch):
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    plan = json.loads((tmp_path / "tracks/.jink/plan.json").read_text())
    plan["versions"]["jink"] = "0.0.1"
    (tmp_path / "tracks/.jink/plan.json").write_text(json.dumps(plan))
    assert "was made with jink 0.0.1" in refused(*hours, "-o", f"{tmp_path}/tracks/", *SAME)


def test_fit_and_compare_read_a_sample_of_a_folder_and_say_so(tmp_path, hours):
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    arguments = ["compare", f"{tmp_path}/tracks/", "--filters", "kalman-cv,imm"]
    done = CliRunner(env={"COLUMNS": "400"}).invoke(app, arguments)
    assert done.exit_code == 0, done.output
    assert "a sample of 30 of 30 targets of" in done.stdout
    some, words = reading.sample(tmp_path / "tracks", 700)
    assert 0 < some.rows.height <= 700 and "of 30 targets" in words
    of_all = reading.sample(tmp_path / "tracks")[0].rows.group_by("target").len()
    assert (
        some.rows.group_by("target").len().join(of_all, on=["target", "len"]).height == some.rows["target"].n_unique()
    )


def test_a_folder_that_is_not_complete_is_not_read(tmp_path, hours):
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    (tmp_path / "tracks/.jink/manifest.json").unlink()
    done = CliRunner().invoke(app, ["compare", f"{tmp_path}/tracks/", "--filters", "kalman-cv,imm"])
    assert done.exit_code == 2 and "is not complete" in done.output


def test_run_again_a_complete_folder_keeps_every_file_and_folder(tmp_path, hours):
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    first = sorted((tmp_path / "tracks").rglob("*"))
    assert not any(path.name == "spare" for path in first)
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    assert sorted((tmp_path / "tracks").rglob("*")) == first


def test_a_page_of_a_folder_with_a_torn_file_names_it(tmp_path, hours):
    track(*hours, "-o", f"{tmp_path}/tracks/")
    torn = sorted((tmp_path / "tracks").glob("bucket=*/part.parquet"))[0]
    torn.write_bytes(torn.read_bytes()[:-50])
    done = CliRunner(env={"COLUMNS": "300"}).invoke(app, ["report", f"{tmp_path}/tracks/"])
    assert done.exit_code == 2 and f"{torn.parent.name}/{torn.name} is damaged" in done.stderr


def test_notes_in_a_zip_are_left_out_and_its_tables_are_not(tmp_path, hours):
    with zipfile.ZipFile(tmp_path / "day.zip", "w") as archive:
        archive.writestr("README.txt", "These rows were recorded in 2024.\nSee the notes, please.\n")
        for path in hours:
            archive.write(path, path.name)
    summary = track(tmp_path / "day.zip", "-o", f"{tmp_path}/tracks/", *SAME)
    assert summary["rows"] == flights().height
    assert any("README.txt: a pair latitude and longitude" in note for note in summary["notes"])
