"""Reading: the same rows whatever the format, and a bad row costs only itself."""

import gzip
import io
import json
from pathlib import Path

import polars as pl
import pytest

from jink.io import ahead
from jink.io.errors import InputError
from jink.io.files import expand, open_table

FRAME = pl.DataFrame({"id": ["a", "a", "b"], "t": [1, 2, 3], "lat": [45.0, 45.5, None], "lon": [5.0, 5.25, 5.5]})


def _bytes(frame: pl.DataFrame, how: str) -> bytes:
    buffer = io.BytesIO()
    if how == "parquet":
        frame.write_parquet(buffer)
    elif how == "arrow":
        frame.write_ipc(buffer)
    elif how == "arrow stream":
        frame.write_ipc_stream(buffer)
    elif how == "csv":
        frame.write_csv(buffer)
    elif how == "semicolons":
        frame.write_csv(buffer, separator=";")
    elif how == "json lines":
        frame.write_ndjson(buffer)
    elif how == "json":
        buffer.write(json.dumps(frame.to_dicts()).encode())
    elif how == "indented json":
        buffer.write(json.dumps(frame.to_dicts(), indent=2).encode())
    elif how == "utf-16 csv":
        buffer.write(frame.write_csv().encode("utf-16"))
    return buffer.getvalue()


FORMATS = [
    "parquet",
    "arrow",
    "arrow stream",
    "csv",
    "semicolons",
    "json lines",
    "json",
    "indented json",
    "utf-16 csv",
]


def _write(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def _read(path: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    table = open_table(path)
    return table.read(table.names)


@pytest.mark.parametrize("how", FORMATS)
@pytest.mark.parametrize("packed", [False, True])
def test_every_format_gives_the_same_rows_whatever_the_file_is_called(tmp_path, how, packed):
    content = _bytes(FRAME, how)
    path = _write(tmp_path / "data", gzip.compress(content) if packed else content)
    rows, unreadable = _read(path)
    assert rows.drop("row").cast({"t": pl.Int64}).equals(FRAME)
    assert rows["row"].to_list() == [0, 1, 2]
    assert unreadable.height == 0


@pytest.mark.parametrize("how", ["csv", "json", "json lines"])
def test_zstd_is_unpacked_without_another_package(tmp_path, how):
    pyarrow = pytest.importorskip("pyarrow")
    content = _bytes(FRAME, how)
    path = _write(tmp_path / "data.zst", pyarrow.compress(content, codec="zstd", asbytes=True))
    assert _read(path)[0]["lon"].to_list() == [5.0, 5.25, 5.5]


def test_only_the_wanted_columns_are_parsed_in_any_order(tmp_path):
    for how in FORMATS:
        table = open_table(_write(tmp_path / "data", _bytes(FRAME, how)))
        assert table.names == FRAME.columns, how
        assert table.read(["lon", "id"])[0].columns == ["row", "lon", "id"], how


def test_a_truncated_json_array_loses_only_its_last_record(tmp_path):
    content = json.dumps(FRAME.to_dicts()).encode()
    rows, unreadable = _read(_write(tmp_path / "cut.json", content[:-20]))
    assert rows["row"].to_list() == [0, 1]
    assert unreadable["row"].to_list() == [2] and unreadable["reason"].to_list() == ["not valid JSON"]


def test_a_broken_line_of_json_lines_is_set_aside_with_its_text(tmp_path):
    rows, unreadable = _read(
        _write(tmp_path / "x.jsonl", b'{"t": 1, "x": 2.5}\n{"t": 2, "x"\n[1]\n{"t": NaN, "x": "7"}\n')
    )
    assert rows["row"].to_list() == [0, 3] and rows["x"].cast(pl.Float64).to_list() == [2.5, 7.0]
    assert unreadable["row"].to_list() == [1, 2]
    assert unreadable["reason"].to_list() == ["not valid JSON", "not a JSON object"]
    assert unreadable["value"][0] == '{"t": 2, "x"'


@pytest.mark.parametrize("end", [b"", b"\n", b"\r\n", b"\n\n  \t\n", b"  "])
@pytest.mark.parametrize("last", [b'{"t": 3, "x": 4.5}', b'{"t": 3, "x"'])
def test_blanks_at_the_end_of_json_lines_are_no_rows(tmp_path, end, last):
    content = b'{"t": 1, "x": 2.5}\n\n{"t": 2, "x": 3}\n'
    rows, unreadable = _read(_write(tmp_path / "x.jsonl", content + last + end))
    good = last.endswith(b"}")
    assert rows["x"].cast(pl.Float64).to_list() == [2.5, 3.0, *[4.5] * good]
    assert unreadable["row"].to_list() == [2] * (not good)


def test_nested_objects_and_braces_in_text_do_not_confuse_the_array_rewriting(tmp_path):
    values = [
        {"t": 1, "x": 2, "name": "a},{b"},
        {"t": 2, "x": 3, "extra": [{"q": 1}, {"q": 2}]},
        {"t": 3, "x": 4, "name": "{"},
    ]
    rows, unreadable = _read(_write(tmp_path / "x.json", json.dumps(values).encode()))
    assert rows["x"].cast(pl.Float64).to_list() == [2.0, 3.0, 4.0] and unreadable.height == 0
    compact = json.dumps(values[:1] * 3, separators=(",", ":")).encode()
    assert _read(_write(tmp_path / "y.json", compact))[0].height == 3


def test_halves_of_characters_in_json_are_replaced(tmp_path):
    content = b'[{"id": "\\ud83d", "t": 1, "x": 2}, {"id": "a", "t": {"\\ud83d": 2}, "\\udc00": 3}]'
    rows, unreadable = _read(_write(tmp_path / "x.json", content))
    assert rows["id"].to_list() == ["?", "a"] and unreadable.height == 0


def test_json_keys_and_types_that_appear_late_are_found(tmp_path):
    values = [{"t": i, "x": 1} for i in range(5000)]
    values[4990]["x"] = 1.5
    for value in values[3000:]:
        value["late"] = 7.0
    table = open_table(_write(tmp_path / "x.json", json.dumps(values).encode()))
    assert table.names == ["t", "x", "late"]
    rows, _ = table.read(["x", "late"])
    assert float(rows["x"][4990]) == 1.5 and rows["late"].count() == 2000


def test_csv_lines_with_too_few_or_too_many_fields_are_set_aside(tmp_path):
    rows, unreadable = _read(_write(tmp_path / "x.csv", b"id,t,lat,lon\na,1,45,5\na,2,45\nb,3,45,5,9\n\nb,4,46,6\nb,5"))
    assert rows["row"].to_list() == [0, 3] and rows["id"].to_list() == ["a", "b"]
    assert unreadable["row"].to_list() == [1, 2, 4]
    assert unreadable["reason"][0] == "line 3 has 3 fields, the header has 4"


def test_csv_with_quotes_line_ends_and_foreign_bytes(tmp_path):
    content = b'id,t,name\r\n"a, b",1,"x"\r\nb,2,"two\nlines"\r\nc,3,"\xff"\r\n'
    rows, unreadable = _read(_write(tmp_path / "x.csv", content))
    assert rows["id"].to_list() == ["a, b", "b", "c"] and rows["name"][1] == "two\nlines" and unreadable.height == 0


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"  \n \n", "is empty"),
        (b"1,2,3\n4,5,6\n", "has no header"),
        (b"t,x,t\n1,2,3\n", "has the same column twice: t"),
        (b"PAR1 and then nothing of the kind", "not a readable parquet file"),
        (b"ARROW1\x00\x00 no", "not a readable arrow file"),
        (b"PK\x03\x04 zipped", "ZIP archive"),
        (b"\x00\x01\x02\x03" * 50, "binary file of an unknown format"),
        (b"[1, 2, 3]", "no JSON objects"),
        (b'{"time": {"0": 1}, "x": {"0": 2}}', "single JSON object"),
        (b'{"time": {"0": 1}, "x": {"0": 2}}\r\n', "single JSON object"),
        (gzip.compress(b"t,x\n1,2\n" * 1000, mtime=0)[:-30], "cannot be unpacked"),
        (b"\x28\xb5\x2f\xfd broken", "cannot be unpacked"),
    ],
)
def test_what_cannot_be_read_is_said_with_the_file_name(tmp_path, content, message):
    path = _write(tmp_path / "given.dat", content)
    with pytest.raises(InputError, match=message) as caught:
        open_table(path)
    assert "given.dat" in str(caught.value)


def test_patterns_and_paths_become_files_each_once(tmp_path):
    for name in ("b.csv", "a.csv", "c.txt"):
        (tmp_path / name).write_text("t\n1\n")
    found = expand([tmp_path / "c.txt", str(tmp_path / "*.csv"), tmp_path / "a.csv"])
    assert [path.name for path in found] == ["c.txt", "a.csv", "b.csv"]
    # a folder stands for its files, hidden ones and jink's own apart
    (tmp_path / "tracks.rejected.parquet").write_bytes(b"")
    (tmp_path / ".hidden").write_text("")
    (tmp_path / "empty").mkdir()
    assert [path.name for path in expand([tmp_path])] == ["a.csv", "b.csv", "c.txt"]
    for given, message in (
        (tmp_path / "empty", "is a directory without files"),
        (tmp_path / "no.csv", "no such file"),
        (tmp_path / "*.nc", "no file matches"),
    ):
        with pytest.raises(InputError, match=message):
            expand([given])


def test_a_file_unpacked_ahead_is_the_same_table(tmp_path):
    text = b"t,x,y\n" + b"".join(b"%d,%d,0\n" % (k, 3 * k) for k in range(500))
    whole, damaged = tmp_path / "a.csv.gz", tmp_path / "b.csv.gz"
    whole.write_bytes(gzip.compress(text))
    damaged.write_bytes(gzip.compress(text)[:-40])
    ahead.begin([str(whole)])
    assert ahead.unpacked(whole) == text and ahead.unpacked(whole) is None
    ahead.begin([str(whole)])
    assert open_table(whole).names == ["t", "x", "y"]
    # what cannot be unpacked is said by whoever reads it
    ahead.begin([str(damaged)])
    with pytest.raises(InputError, match="cannot be unpacked"):
        open_table(damaged)
    ahead.begin([str(tmp_path / "none.csv.gz")])
    assert ahead.unpacked(tmp_path / "none.csv.gz") is None


def test_an_array_that_was_cut_off_between_objects_is_noted(tmp_path):
    objects = ",".join(f'{{"id": "a", "t": {k}, "x": {k}, "y": 0}}' for k in range(9))
    for end, notes in (("]", ()), ("", ("the array does not end with ]: the file may have been cut off",))):
        (tmp_path / "x.json").write_text("[" + objects + end)
        table = open_table(tmp_path / "x.json")
        assert table.notes == notes and table.read(["t"])[0].height == 9
