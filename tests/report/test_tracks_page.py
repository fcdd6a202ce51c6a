import json
import re

import numpy as np
import polars as pl
import pytest

from jink.estimate import Status
from jink.report import write_report
from jink.report.consistency import consistency
from jink.report.rows import read_rows
from jink.report.targets import target_table
from jink.report.tracks_page import _coasting


def written(tmp_path, tracks, summary=None, **options):
    path = tmp_path / "page.html"
    write_report(tracks, path, summary=summary or {}, **options)
    return path.read_text(encoding="utf-8")


def meta_of(text):
    found = re.search(r'<script type="application/json" id="meta">(.*?)</script>', text, re.S)
    assert found
    return json.loads(found[1])


def test_one_file_that_refers_to_nothing_else(tmp_path, tracks, summary):
    text = written(tmp_path, tracks(), summary, title="Morning")
    assert "<title>Morning</title>" in text
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:,")""", text)
    assert not re.search(r"https?://", text.split('id="block"')[0])
    assert "default-src 'none'" in text
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]


def test_names_that_look_like_html_are_only_text(tmp_path, tracks):
    nasty = "</script><b>"
    frame = tracks(1, 30).with_columns(target=pl.lit(nasty))
    text = written(tmp_path, frame, {nasty: {nasty: nasty}, "plain <i>": nasty, "list": [{nasty: nasty}]}, title=nasty)
    assert nasty not in text
    assert meta_of(text)["targets"]["name"] == [nasty]
    assert text.count("</script>") == 3


def test_many_rows_stay_small_and_quick(tmp_path, tracks, summary):
    frame = tracks(200, 1500)
    text = written(tmp_path, frame, summary)
    assert len(text) < 8e6
    meta = meta_of(text)
    assert sum(meta["targets"]["rows"]) == 300_000
    drawn = meta["arrays"]["time"]["length"]
    assert 50_000 < drawn < 200_000
    assert "Every number is computed from all rows" in text


def test_missing_columns_are_named(tmp_path):
    with pytest.raises(ValueError, match="expected a column 'target'; found time, x"):
        write_report(pl.DataFrame({"time": [0.0], "x": [1.0]}), tmp_path / "a.html", summary={})
    with pytest.raises(ValueError, match="latitude and longitude, or x and y; found target, time, x"):
        write_report(pl.DataFrame({"target": ["a"], "time": [0.0], "x": [1.0]}), tmp_path / "a.html", summary={})
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_leaves_nothing(tmp_path, tracks):
    with pytest.raises(OSError):
        write_report(tracks(1, 5), tmp_path / "nowhere" / "a.html", summary={})


def test_the_barest_table(tmp_path):
    frame = pl.DataFrame({"target": ["a", "a", "b"], "time": [0, 1, 0], "x": [0.0, None, 3.0], "y": [0.0, np.nan, 4.0]})
    meta = meta_of(written(tmp_path, frame))
    assert meta["targets"]["rows"] == [2, 1] and meta["panels"] == [] and meta["nis_band"] is None
    assert meta["targets"]["max_speed"] == [None, None]


def test_no_rows_at_all(tmp_path, tracks):
    text = written(tmp_path, tracks(1, 5).clear())
    assert "no tracks" in text and meta_of(text)["targets"]["name"] == []


def test_everything_missing_but_the_keys(tmp_path, tracks):
    frame = tracks(2, 20)
    blank = [c for c in frame.columns if frame[c].dtype.is_float()]
    text = written(tmp_path, frame.with_columns(pl.lit(None, dtype=pl.Float64).alias(c) for c in blank))
    assert meta_of(text)["targets"]["rows"] == [20, 20]


def test_more_targets_than_a_page_lists(tmp_path):
    n = 6_000
    frame = pl.DataFrame(
        {
            "target": np.arange(n + 1) % n,
            "time": np.arange(n + 1) * 1.0,
            "x": np.zeros(n + 1),
            "y": np.ones(n + 1),
        }
    )
    text = written(tmp_path, frame)
    meta = meta_of(text)
    assert len(meta["targets"]["name"]) == 5_000 and "0" in meta["targets"]["name"]
    assert "Of 6\u202f000 targets the 5\u202f000 with most rows are shown" in text


def test_summary_is_rendered_whatever_it_holds(tmp_path, tracks):
    summary = {
        "input": {
            "rows": 1234567,
            "note": None,
            "yes": True,
            "by source": {"radar": 0.123456, "ads-b": float("nan")},
        },
        "files": [{"name": "a.csv", "rows": 3}, {"name": "b.csv", "bad": 1}],
        "steps": ["sorted", "cleaned"],
        "nothing": {},
        "filter": "IMM",
    }
    text = written(tmp_path, tracks(1, 5), summary)
    for piece in (
        "1\u202f234\u202f567",
        ">yes</td>",
        "0.1235",
        "a.csv",
        "b.csv",
        "cleaned",
        "<h3>Run</h3>",
        "<p>none</p>",
    ):
        assert piece in text


def test_table_of_targets_counts_every_row(tracks):
    frame = tracks(4, 400)
    rows = read_rows(frame)
    accepted = rows.status == Status.updated
    check = consistency(rows.target, len(rows.names), rows.column("nis"), rows.column("nis_dof"), accepted)
    table = target_table(rows, check)
    for k, name in enumerate(rows.names):
        one = frame.filter(pl.col("target") == name)
        assert table["rows"][k] == one.height
        assert table["manoeuvring"][k] == pytest.approx((one["manoeuvring"] > 0.5).mean())
        assert table["gated"][k] == pytest.approx((one["status"] == "gated").mean())
        assert table["duration"][k] == pytest.approx((one["time"].max() - one["time"].min()).total_seconds())
        limit = 2 * one.filter(pl.col("status") == "updated")["speed_sd"].quantile(0.9, "linear")
        settled = one.filter(pl.col("speed_sd") <= limit)
        assert table["max_speed"][k] == pytest.approx(settled["speed"].abs().max())
    assert table["nis_inside"] == pytest.approx(check.inside / check.compared)


def test_only_longer_runs_of_predictions_count_as_coasting():
    status = ["updated"] + ["predicted"] * 3 + ["updated"] + ["predicted"] * 4 + ["predicted"] * 6
    part = [0] * 9 + [1] * 6
    n = len(status)
    table = {"target": ["a"] * n, "time": np.arange(n), "x": np.zeros(n), "y": np.zeros(n)}
    rows = read_rows(pl.DataFrame({**table, "status": status, "part": part}))
    assert _coasting(rows, rows.part).tolist() == [False] * 9 + [True] * 6


def test_order_of_the_rows_does_not_matter(tmp_path, tracks):
    frame = tracks(3, 50)
    meta = meta_of(written(tmp_path, frame))
    assert meta_of(written(tmp_path, frame.sample(fraction=1.0, shuffle=True, seed=0)))["targets"] == meta["targets"]
