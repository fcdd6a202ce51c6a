"""Files out: every format gives the rows back, and a failure leaves nothing behind."""

import gzip
import json
from datetime import UTC, datetime
from pathlib import Path

import polars as pl
import pytest

from jink.io.errors import InputError
from jink.io.writing import atomically, check_writable, compress, format_of, write_tracks

TRACKS = pl.DataFrame(
    {
        "target": ["a", "a", "b", "b"],
        "part": [0, 0, 0, 0],
        "time": [datetime(2024, 1, 1, 0, 0, second, tzinfo=UTC) for second in (0, 1, 0, 1)],
        "latitude": [10.0, 11.0, 50.0, None],
        "longitude": [179.0, -179.0, 5.0, None],
        "speed": [1.5, None, 2.5, 3.5],
        "status": pl.Series(
            ["updated", "predicted", "updated", "gated"], dtype=pl.Enum(["updated", "predicted", "gated"])
        ),
    }
)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("t.parquet", "parquet"),
        ("t.csv.gz", "csv"),
        ("t.JSONL", "jsonl"),
        ("t.geojson", "geojson"),
        ("t.feather", "arrow"),
    ],
)
def test_the_extension_says_the_format(name, kind):
    assert format_of(Path(name)) == kind


@pytest.mark.parametrize("name", ["t", "t.xlsx", "t.parquet.gz"])
def test_an_unknown_extension_is_refused_with_those_that_are_known(name):
    with pytest.raises(InputError, match=r"tracks\.parquet"):
        format_of(Path(name))


@pytest.mark.parametrize(
    ("kind", "read"),
    [("parquet", pl.read_parquet), ("arrow", pl.read_ipc), ("csv", pl.read_csv), ("jsonl", pl.read_ndjson)],
)
def test_rows_come_back(tmp_path, kind, read):
    path = tmp_path / "t"
    write_tracks(TRACKS, path, kind)
    back = read(path)
    assert back["speed"].to_list() == [1.5, None, 2.5, 3.5] and back["target"].to_list() == [
        "a",
        "a",
        "b",
        "b",
    ]
    assert str(back["time"][1]).startswith("2024-01-01") and back["status"].cast(pl.String)[3] == "gated"
    if kind in ("csv", "jsonl"):
        assert back["time"][1] == "2024-01-01T00:00:01.000000Z"


def test_geojson_has_every_row_and_splits_lines_at_the_antimeridian(tmp_path):
    path = tmp_path / "t"
    write_tracks(TRACKS, path, "geojson")
    features = json.loads(path.read_text())["features"]
    lines = [f for f in features if f["geometry"] and f["geometry"]["type"] != "Point"]
    points = [f for f in features if f not in lines]
    assert len(points) == 4 and points[3]["geometry"] is None and points[0]["properties"]["speed"] == 1.5
    assert points[1]["properties"]["time"] == "2024-01-01T00:00:01.000000Z"
    crossing = lines[0]["geometry"]
    assert crossing["type"] == "MultiLineString"
    assert crossing["coordinates"] == [[[179.0, 10.0], [180.0, 10.5]], [[-180.0, 10.5], [-179.0, 11.0]]]


def test_text_can_be_packed(tmp_path):
    path = tmp_path / "t"
    write_tracks(TRACKS, path, "csv")
    plain = path.read_bytes()
    compress(path)
    assert gzip.decompress(path.read_bytes()) == plain


def test_a_failure_leaves_the_old_file_and_no_other(tmp_path):
    old, new = tmp_path / "old.csv", tmp_path / "new.csv"
    old.write_text("before")
    with pytest.raises(RuntimeError), atomically(old, new) as names:
        names[0].write_text("half")
        raise RuntimeError
    assert old.read_text() == "before" and [path.name for path in tmp_path.iterdir()] == ["old.csv"]
    with atomically(old, new) as names:
        for name in names:
            name.write_text("after")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.csv", "old.csv"] and old.read_text() == "after"


def test_an_output_that_cannot_be_written_is_said_beforehand(tmp_path):
    for path, message in ((tmp_path, "is a directory"), (tmp_path / "no" / "t.csv", "no directory")):
        with pytest.raises(InputError, match=message):
            check_writable(path)
