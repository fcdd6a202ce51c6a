"""What the notes of a run say of its files and of its filter."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

import jink
from jink.archive.run import How, track_archive
from jink.io.loading import Reading
from jink.tracking.prepare import Settings

RADAR = Path(__file__).parents[2] / "examples" / "radar.csv"


@pytest.mark.parametrize("how", [{"smooth": True}, {"lag": 2}])
def test_a_correction_that_smoothing_leaves_out_is_said(how):
    corrected = jink.track(RADAR, filter="imm-corrected", details=True, **how)
    plain = jink.track(RADAR, filter="imm", details=True, **how)
    assert corrected.tracks["x"].equals(plain.tracks["x"])
    assert sum("learned correction" in note for note in corrected.summary["notes"]) == 1
    assert not any("learned correction" in note for note in plain.summary["notes"])


def test_a_correction_that_counts_is_not_said_to_be_left_out():
    corrected = jink.track(RADAR, filter="imm-corrected", details=True)
    assert not corrected.tracks["x"].equals(jink.track(RADAR, filter="imm")["x"])
    assert not any("learned correction" in note for note in corrected.summary["notes"])


@pytest.fixture
def files(tmp_path) -> list[Path]:
    """Three files, of which the last two call their columns otherwise."""
    rng, time = np.random.default_rng(3), np.arange(40.0)
    paths = []
    for k, (name, course) in enumerate([("x", "y"), ("pos_x", "pos_y"), ("pos_x", "pos_y")]):
        table = pl.DataFrame(
            {
                "target": f"T{k}",
                "time": time,
                name: 200 * time + rng.normal(0, 5, 40),
                course: 9e3 * k + rng.normal(0, 5, 40),
            }
        )
        paths.append(tmp_path / f"{'abc'[k]}.csv")
        table.write_csv(paths[-1])
    return paths


def _said(notes: list[str]) -> list[str]:
    return [note for note in notes if "pos_x" in note]


def test_other_columns_of_other_files_are_said(files, tmp_path):
    summary = jink.track(files, details=True).summary
    (note,) = _said(summary["notes"])
    assert summary["columns"]["x"] == "x" and "a.csv" in note and "b.csv and 1 more" in note and "x = pos_x" in note
    assert not _said(jink.track(files[:1], details=True).summary["notes"])
    archive, _ = track_archive(
        files, f"{tmp_path}/out/", Reading(), Settings(), How(memory=2 * 10**9, processes=1), lambda event: None
    )
    assert _said(archive["notes"]) == [note]


def test_files_of_the_same_columns_are_not_said(files):
    summary = jink.track(files[1:], details=True).summary
    assert summary["columns"]["x"] == "pos_x" and not _said(summary["notes"])
