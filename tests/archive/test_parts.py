"""A bucket is tracked in parts of whole targets: nothing is lost, and how large the parts are changes no row."""

import sys

import polars as pl
from hypothesis import given
from hypothesis import strategies as st
from test_archive import SAME, flights, in_files, track

from jink.archive import reducing
from jink.archive.reducing import whole_targets


@given(st.lists(st.sampled_from("abcdefgh"), min_size=1, max_size=60), st.integers(1, 20))
def test_parts_have_whole_targets_in_order(targets, most):
    rows = pl.DataFrame({"target": targets}).with_row_index("row")
    parts = list(whole_targets(rows.clone(), most))
    assert pl.concat(parts).equals(rows.sort("target", maintain_order=True))
    for part in parts:
        assert part.height <= most or part["target"].n_unique() == 1
    held = [set(part["target"]) for part in parts]
    assert sum(map(len, held)) == len(set(targets))


def test_a_part_is_held_by_its_taker_alone():
    """Otherwise a busy target's rows would stay in memory while they are tracked."""
    parts = whole_targets(pl.DataFrame({"target": ["a", "a", "b"]}), 2)
    for part in parts:
        # the name here and the argument of the function
        assert sys.getrefcount(part) == 2


def test_the_size_of_the_parts_changes_no_row(tmp_path, monkeypatch):
    files = in_files(tmp_path, flights())
    track(*files, "-o", f"{tmp_path}/whole/", *SAME)
    monkeypatch.setattr(reducing, "PART", 200)
    track(*files, "-o", f"{tmp_path}/parts/", *SAME)
    whole, parts = (pl.read_parquet(f"{tmp_path}/{name}/*/*.parquet") for name in ("whole", "parts"))
    assert whole.height > 1000 and parts.equals(whole)
