"""The command line: what it writes, what it says, and how it fails."""

import gzip
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import shell

from jink.io.files import open_table

FLIGHTS = Path(__file__).parents[2] / "examples" / "flights.parquet"
TEXT_ENVIRONMENT = os.environ | {"COLUMNS": "200", "NO_COLOR": "1"}


def run(*arguments: object) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `jink track` with these arguments."""
    return shell.run("track", *arguments)


def piped(*arguments: str, stdin: bytes) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "jink", *arguments], input=stdin, capture_output=True, env=TEXT_ENVIRONMENT
    )


@pytest.fixture
def flight(tmp_path) -> Path:
    """One example flight as CSV, with a row that cannot be used."""
    table = pl.read_parquet(FLIGHTS).filter(pl.col("icao24") == "4d02c1").drop("callsign").slice(100, 500)
    path = tmp_path / "flight.csv"
    path.write_text(table.write_csv() + "4d02c1,2021-10-07T23:00:00Z,123.0,2.0,,,\n")
    return path


def test_tracks_rejected_rows_and_a_summary_come_out(flight, tmp_path):
    output = tmp_path / "tracks.parquet"
    status, said, _ = run(flight, "-o", output, "--smooth")
    assert status == 0
    tracks, rejected = pl.read_parquet(output), pl.read_parquet(tmp_path / "tracks.rejected.parquet")
    assert tracks.height + rejected.height == 501
    assert rejected.filter(pl.col("row") == 500)["reason"].to_list() == ["latitude beyond ±90°"]
    assert rejected.columns == ["file", "row", "target", "reason", "value"]
    for piece in (
        "501 read",
        "1 in 1 part",
        "altitude = altitude_ft",
        "(estimated)",
        "smoothed",
        "tracks.parquet",
    ):
        assert piece in said, piece


def test_a_lag_lies_between_filtering_and_smoothing(flight, tmp_path):
    out = {}
    runs = {"filter": (), "lag": ("--lag", "2"), "seconds": ("--lag", "1000000s"), "all": ("--smooth",)}
    for name, options in runs.items():
        status, said, _ = run(flight, "-o", tmp_path / f"{name}.parquet", *options)
        assert status == 0 and ("with a lag of 2 scans" in said) == (name == "lag")
        out[name] = pl.read_parquet(tmp_path / f"{name}.parquet")
    # the window of a manoeuvre lies around smoothed rows and before lagged ones, whose future is not there when live
    told = ["manoeuvring", "manoeuvring_vertical", "segment"]
    assert out["seconds"].drop(told).equals(out["all"].drop(told))
    spread = {name: table["speed_sd"].mean() for name, table in out.items()}
    assert spread["all"] < spread["lag"] < spread["filter"]


@pytest.mark.parametrize("options", [("--lag", "1.5"), ("--lag", "-1"), ("--lag", "x"), ("--lag", "2", "--smooth")])
def test_a_wrong_lag_is_refused(flight, tmp_path, options):
    status, _, said = run(flight, "-o", tmp_path / "t.parquet", *options)
    assert status == 2 and "lag is" in said and not (tmp_path / "t.parquet").exists()


@pytest.mark.parametrize("name", ["t.csv", "t.csv.gz", "t.jsonl", "t.geojson", "t.arrow"])
def test_every_format_is_written(flight, tmp_path, name):
    assert run(flight, "-o", tmp_path / name, "-q")[0] == 0
    content = (tmp_path / name).read_bytes()
    if name.endswith(".gz"):
        content = gzip.decompress(content)
    assert len(content) > 10_000
    if name == "t.geojson":
        assert json.loads(content)["type"] == "FeatureCollection"


def test_quiet_is_silent_and_json_is_for_machines(flight, tmp_path):
    assert run(flight, "-o", tmp_path / "t.parquet", "--quiet") == (0, "", "")
    status, said, errors = run(flight, "--json")
    summary = json.loads(said)
    assert status == 0 and errors == ""
    assert summary["rows"] == 501 == summary["accepted"] + sum(summary["rejected"].values())
    assert summary["noise"][0]["position_sd_from"] == "estimated" and summary["written"] == []


def test_timings_of_every_stage_are_said(flight, tmp_path):
    """As a table on standard error, or as a part of the summary in JSON."""
    output = tmp_path / "tracks.parquet"
    status, said, errors = run(flight, "-o", output, "--quiet", "--timings")
    assert status == 0 and said == ""
    lines = {line.split()[0]: line.split()[1:] for line in errors.splitlines()}
    stages = ("read", "recognise", "clean", "place", "noise", "filter", "table", "check", "write", "rest")
    assert list(lines) == ["stage", *stages, "together"]
    assert sum(float(lines[name][1]) for name in stages) == pytest.approx(float(lines["together"][1]), abs=0.05)
    status, said, errors = run(flight, "-o", output, "--json", "--timings")
    figures = json.loads(said)["timings"]
    assert status == 0 and errors == "" and tuple(figures) == stages
    assert all(figures[name]["wall"] > 0 for name in stages)
    assert "timings" not in json.loads(run(flight, "-o", output, "--json")[1])


def test_a_report_is_written_beside_the_tracks(flight, tmp_path):
    page = tmp_path / "page.html"
    assert run(flight, "--report", page, "-q")[0] == 0
    assert "<html" in page.read_text(encoding="utf-8")[:500].lower()


def test_many_files_and_patterns_are_one_table(tmp_path):
    table = pl.read_parquet(FLIGHTS).filter(pl.col("icao24").is_in(["4d02c1", "394c04"]))
    for number, part in enumerate(table.iter_slices(1200)):
        part.write_parquet(tmp_path / f"part{number}.parquet")
    status, said, _ = run(tmp_path / "part*.parquet", "--json")
    summary = json.loads(said)
    assert status == 0 and summary["rows"] == table.height and summary["targets"] == 2


def test_cleaning_steps_can_be_left_out(flight, tmp_path):
    careful, trusting = (
        json.loads(run(flight, "--json", *options)[1])
        for options in (
            [],
            [
                "--keep-stale",
                "--keep-duplicates",
                "--no-sort",
                "--no-check",
                "--gap",
                "0",
                "--min-points",
                "1",
            ],
        )
    )
    assert careful["cleaning"]["stale_positions"] > 0 == trusting["cleaning"]["stale_positions"]
    assert trusting["accepted"] == 501


def test_a_clean_run_leaves_no_old_rejected_rows_behind(tmp_path):
    good = pl.DataFrame({"t": range(10), "x": [10.0 * i + 0.1 * (i % 3) for i in range(10)], "y": [0.0] * 10})
    good.write_csv(tmp_path / "good.csv")
    (tmp_path / "t.rejected.parquet").write_bytes(b"from last time")
    assert run(tmp_path / "good.csv", "-o", tmp_path / "t.csv", "-q")[0] == 0
    assert pl.read_parquet(tmp_path / "t.rejected.parquet").height == 0


HOPELESS = {
    "empty": b"",
    "blank": b"\n\n   \n",
    "binary": bytes(range(256)) * 20,
    "no header": b"1,2,3\n4,5,6\n",
    "header only": b"t,lat,lon\n",
    "wrong columns": b"when,where\n1,2\n",
    "words": b"t,lat,lon\nnever,no,no\n",
    "nan everywhere": b"t,lat,lon\n" + b"NaN,NaN,NaN\n" * 50,
    "positions all nan": b"id,t,x,y\n" + b"".join(b"a,%d,NaN,NaN\n" % i for i in range(50)),
    "one row": b"t,lat,lon\n1,2,3\n",
    "same row again": b"t,x,y\n" + b"1,2,3\n" * 100,
    "one row each": b"id,t,x,y\n" + b"".join(b"%d,1,2,3\n" % i for i in range(100_000)),
    "infinite": b"t,x,y\n" + b"1,inf,2\n" * 20,
    "truncated gzip": gzip.compress(FLIGHTS.read_bytes())[:5000],
    "truncated parquet": FLIGHTS.read_bytes()[:5000],
    "json numbers": b"[1, 2, 3]",
    "json half": b'[{"t": 1, "x"',
    "json columns": b'{"t": {"0": 1}, "x": {"0": 1}}',
    "non utf-8 header": b"\xff\xfet\xff,\xfa\n1,2\n",
    "only quotes": b'"""""""\n' * 5,
}


@pytest.mark.parametrize("content", HOPELESS.values(), ids=HOPELESS)
def test_hopeless_input_is_said_in_one_message_with_exit_2_and_nothing_written(tmp_path, content):
    path = tmp_path / "given.dat"
    path.write_bytes(content)
    status, said, errors = run(path, "-o", tmp_path / "t.parquet", "--report", tmp_path / "t.html")
    assert status == 2 and said == "" and errors.startswith("jink: ")
    assert "Traceback" not in errors and len(errors) < 1500
    assert [p.name for p in tmp_path.iterdir()] == ["given.dat"]


def test_damaged_but_usable_input_is_used_and_the_damage_counted(flight, tmp_path):
    lines = flight.read_bytes().splitlines()
    lines[10] = b"4d02c1,garbage"
    lines[20] = b"\xff\xfe\xfd" + lines[20]
    lines[30] = lines[30].replace(b"48.", b"4x8.")
    flight.write_bytes(b"\n".join(lines)[:-7])
    status, said, _ = run(flight, "--json")
    summary = json.loads(said)
    assert status == 0 and summary["rows"] == 501
    assert summary["accepted"] + sum(summary["rejected"].values()) == 501
    assert summary["rejected"]["line with a wrong number of fields"] == 2
    assert summary["rejected"]["latitude is not a number"] == 1


def test_random_damage_never_ends_in_a_traceback_or_half_an_output(flight, tmp_path):
    rng = np.random.default_rng(11)
    original = bytearray(flight.read_bytes())
    output = tmp_path / "t.parquet"
    for _ in range(25):
        content = bytearray(original[: rng.integers(1, len(original))])
        for place in rng.integers(0, len(content), rng.integers(1, 30)):
            content[place] = rng.integers(0, 256)
        flight.write_bytes(content)
        status, _, errors = run(flight, "-o", output, "-q")
        assert status in (0, 2) and "Traceback" not in errors
        assert output.exists() == (status == 0)
        assert not [path for path in tmp_path.iterdir() if path.suffix == ".part"]
        output.unlink(missing_ok=True)
        (tmp_path / "t.rejected.parquet").unlink(missing_ok=True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no.csv", "-o", "t.csv"], "no such file: no.csv"),
        (["F", "-q"], "nothing to write"),
        (["F", "-o", "t.xlsx"], "unknown extension"),
        (["F", "-o", "missing/t.csv"], "there is no directory"),
        (["F", "-o", "F"], "is an input"),
        (["F", "--json", "--columns", "speling"], "not ROLE=COLUMN"),
        (["F", "--json", "--columns", "target=icao42"], "did you mean 'icao24'"),
        (["F", "--json", "--sensor-sd", "many"], "expected a positive number"),
        (["F", "--json", "--site", "95,0"], "--site"),
        (["F", "--json", "--filter", "magic"], "unknown filter 'magic'"),
        (["F", "--json", "--gap", "-1"], "gap"),
        (["F", "--json", "--min-points", "0"], "min_points"),
        (["F", "--json", "--threads", "0"], "threads"),
        (["-", "-o", "t.csv"], "--output needs the whole track"),
        (["-", "--min-points", "9"], "--min-points needs the whole track"),
        (["-", "F"], "stands alone"),
    ],
)
def test_wrong_requests_are_answered_with_what_is_expected(flight, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    status, _, errors = run(*[str(flight) if argument == "F" else argument for argument in arguments])
    assert status == 2 and message in errors.replace("\n", " ")


def test_with_json_errors_are_json_too(tmp_path):
    status, said, _ = run(tmp_path / "no.csv", "--json")
    assert status == 2 and "no such file" in json.loads(said)["error"]


def test_geojson_without_a_map_is_refused_before_anything_is_computed(tmp_path):
    path = tmp_path / "xy.csv"
    pl.DataFrame({"t": range(30), "x": range(30), "y": range(30)}).write_csv(path)
    status, _, errors = run(path, "-o", tmp_path / "t.geojson")
    assert status == 2 and "--site" in errors
    assert run(path, "-o", tmp_path / "t.geojson", "--site", "48,11", "-q")[0] == 0


def test_a_saved_filter_is_used(flight, tmp_path):
    import jink

    own = jink.Kalman(jink.ConstantVelocity(acceleration_sd=3.0), jink.Position(sd=15.0, axes=2))
    own.save(tmp_path / "own.json")
    status, said, _ = run(flight, "--json", "--filter", tmp_path / "own.json")
    assert status == 0 and "constant_velocity" in str(json.loads(said)["filter"])
    (tmp_path / "broken.json").write_text("{}")
    assert run(flight, "--json", "--filter", tmp_path / "broken.json")[0] == 2


def test_a_failure_while_writing_leaves_neither_output_nor_temporary_files(flight, tmp_path, monkeypatch):
    import jink.report

    def fails(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(jink.report, "write_report", fails)
    status, _, errors = run(flight, "-o", tmp_path / "t.parquet", "--report", tmp_path / "t.html")
    assert status == 1 and "No space left" in errors
    assert [path.name for path in tmp_path.iterdir()] == ["flight.csv"]


def _stream(count: int) -> list[dict]:
    return [
        {"id": "ab"[i % 2], "t": 1.7e9 + i, "lat": 48 + 0.002 * i, "lon": 11.0, "altitude_ft": 10_000}
        for i in range(count)
    ]


def test_a_stream_of_json_lines_is_answered_line_by_line():
    lines = [json.dumps(row) for row in _stream(60)]
    lines[30] = "{broken"
    lines[40] = json.dumps({"id": "a", "t": 1.6e9, "lat": 48.0, "lon": 11.0})
    done = piped("track", "-", "--sensor-sd", "20", stdin="\n".join(lines).encode())
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    refused = [json.loads(line) for line in done.stderr.splitlines() if line.startswith(b"{")]
    assert done.returncode == 0 and len(rows) == 58 and [row["row"] for row in refused] == [30, 40]
    assert refused[1]["reason"] == "time runs backwards" and rows[0]["row"] == 0
    assert rows[-1]["speed"] == pytest.approx(222.4, rel=0.02) and rows[-1]["altitude"] == pytest.approx(3048, rel=0.01)
    assert rows[-1]["latitude"] == pytest.approx(48 + 0.002 * 59, abs=3e-4)


def test_a_stream_agrees_with_the_same_rows_from_a_file(tmp_path):
    rows = _stream(80)
    (tmp_path / "s.jsonl").write_text("\n".join(json.dumps(row) for row in rows))
    given = ("--sensor-sd", "position=20,altitude=10")
    done = piped("track", "-", *given, stdin=(tmp_path / "s.jsonl").read_bytes())
    live = pl.DataFrame([json.loads(line) for line in done.stdout.splitlines()]).sort("target", "row")
    assert run(tmp_path / "s.jsonl", "-o", tmp_path / "t.parquet", "-q", *given)[0] == 0
    whole = pl.read_parquet(tmp_path / "t.parquet")
    for name in ("latitude", "speed", "course", "altitude", "x_sd", "manoeuvring"):
        np.testing.assert_allclose(
            live[name].to_numpy().astype(float)[6:],
            whole[name].to_numpy()[6:],
            rtol=1e-6,
            atol=1e-9,
            err_msg=name,
        )


def test_estimates_come_while_the_stream_is_still_open():
    process = subprocess.Popen(
        [sys.executable, "-m", "jink", "track", "-", "-q"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=TEXT_ENVIRONMENT,
    )
    assert process.stdin and process.stdout
    for row in _stream(4):
        process.stdin.write(json.dumps(row).encode() + b"\n")
        process.stdin.flush()
        answer = json.loads(process.stdout.readline())
        assert answer["target"] == row["id"]
    process.stdin.close()
    assert process.wait(timeout=20) == 0
    process.stdout.close()


@pytest.mark.parametrize("content", [b"", b"{}\n", b"garbage\n\xff\xfe\n", b'{"t": 1, "range": 5, "azimuth": 1}\n'])
def test_a_hopeless_stream_ends_with_exit_2(content):
    done = piped("track", "-", stdin=content)
    assert done.returncode == 2 and done.stdout == b"" and b"Traceback" not in done.stderr


def test_help_shows_every_option_without_heavy_imports():
    shown = piped("track", "--help", stdin=b"").stdout.decode()
    for option in ("--smooth", "--report", "--columns", "--sensor-sd", "--gap", "--json", "--kind"):
        assert option in shown
    heavy = "import sys, jink.cli.main; print([m for m in ('polars', 'pyproj', 'pandas', 'scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", heavy], capture_output=True, check=True, text=True)
    assert done.stdout.strip() == "[]"


def test_level_flight_is_tracked(tmp_path):
    """An altitude that never changes says nothing of its error: what is usual is taken."""
    rows = [f"a,{k},{48 + k * 1e-3 + 1e-5 * (k % 3)},{2 + 1e-5 * (k % 4)},1000" for k in range(60)]
    table = tmp_path / "level.csv"
    table.write_text("id,time,latitude,longitude,altitude\n" + "\n".join(rows) + "\n")
    done = piped("track", str(table), "-o", str(tmp_path / "level.parquet"), "--quiet", stdin=b"")
    assert done.returncode == 0, done.stderr


def test_without_an_output_the_summary_and_the_first_tracks_are_shown(flight, tmp_path):
    status, said, _ = run(flight)
    assert status == 0 and "Targets" in said and "median speed" in said and "4d02c1" in said
    assert [path.name for path in tmp_path.iterdir()] == ["flight.csv"]


def test_tracks_on_standard_output_are_lines_of_json(flight, tmp_path):
    done = piped("track", str(flight), "-o", "-", stdin=b"")
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0 and len(rows) == 500 and rows[0]["target"] == "4d02c1"
    assert b"1 rows are in no track: 1 latitude beyond" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["flight.csv"]


@pytest.mark.parametrize("name", ["t.gpx", "t.kml", "t.kml.gz"])
def test_tracks_for_maps_are_read_back_as_the_same_places(flight, tmp_path, name):
    assert run(flight, "-o", tmp_path / name, "-q")[0] == 0
    assert run(flight, "-o", tmp_path / "t.parquet", "-q")[0] == 0
    wanted, found = pl.read_parquet(tmp_path / "t.parquet"), open_table(tmp_path / name)
    frame = found.read(["latitude", "longitude", "time"])[0].cast({"latitude": pl.Float64, "longitude": pl.Float64})
    # seven decimals are a centimetre
    np.testing.assert_allclose(frame["latitude"], wanted["latitude"], atol=6e-8, rtol=0)
    np.testing.assert_allclose(frame["longitude"], wanted["longitude"], atol=6e-8, rtol=0)
    assert frame["time"].str.to_datetime(time_zone="UTC", time_unit="us").equals(wanted["time"])
