"""The page over a folder of tracks: its numbers are those of the whole table, and its links lead to tracks."""

from __future__ import annotations

import json
import re
import shutil
import zlib

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

from jink.archive.tracked import Tracks
from jink.cli.main import app
from jink.metrics.chi_square import quantile
from jink.report import survey as counting
from jink.report.picture import mask, shaded
from jink.report.survey import SPANS, survey


def ships(targets: int = 12, rows: int = 90) -> pl.DataFrame:
    """Straight courses at 8 m/s, one of them across the date line, one with jumps that are gated."""
    rng, frames = np.random.default_rng(5), []
    for k in range(targets):
        t = 10.0 * np.arange(rows)
        noise = rng.normal(scale=5.0 / 111_000, size=(2, rows))
        noise[0, 40] += 0.1 if k == 3 else 0.0
        longitude = 179.99 + 0.0003 * np.arange(rows) * (-1) ** k + noise[1]
        name = pl.repeat(f"ship {k}", rows, eager=True)
        places = {"latitude": -17.0 + 0.01 * k + 0.0006 * np.arange(rows) + noise[0]}
        turned = (longitude + 180.0) % 360.0 - 180.0
        frames.append(pl.DataFrame({"target": name, "time": 1.7e9 + t + 100.0 * k, **places, "longitude": turned}))
    return pl.concat(frames).sort("time")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of tracks in several buckets."""
    place = tmp_path_factory.mktemp("archive")
    ships().write_parquet(place / "ships.parquet")
    command = ["track", f"{place}/ships.parquet", "-o", f"{place}/tracks/", "--threads", "1", "--kind", "vessel"]
    done = CliRunner().invoke(app, [*command, "--quiet"])
    assert done.exit_code == 0, done.output
    return place / "tracks"


def everything(folder) -> pl.DataFrame:
    return pl.read_parquet(f"{folder}/*/part.parquet").with_columns(pl.col("status").cast(pl.String))


def test_every_number_is_that_of_the_whole_table(folder):
    rows, found = everything(folder), survey(Tracks(folder))
    seconds = pl.col("time").dt.epoch("us") / 1e6
    low, high = quantile(0.025, 2), quantile(0.975, 2)
    judged = (pl.col("status") == "updated") & pl.col("nis").is_finite() & (pl.col("nis_dof") == 2)
    by_hand = (
        rows.group_by("target")
        .agg(
            rows=pl.len(),
            begin=seconds.min(),
            end=seconds.max(),
            gated=(pl.col("status") == "gated").sum(),
            compared=judged.sum(),
            inside=(judged & pl.col("nis").is_between(low, high)).sum(),
        )
        .sort("target")
    )
    assert found.targets.rows() == by_hand.rows()
    assert found.targets["gated"].sum() > 0
    assert found.density.sum() + found.outside == rows.height
    assert int(found.check.inside[0]) == by_hand["inside"].sum()
    width = (found.end - found.begin) / SPANS
    for span in (0, 100, SPANS - 1):
        at = (seconds - found.begin) / width
        inside = rows.filter((at >= span) & ((at < span + 1) | (span == SPANS - 1)))
        assert found.active[span] == inside["target"].n_unique()


def test_the_date_line_does_not_part_the_map(folder):
    extent = survey(Tracks(folder)).extent
    assert extent.east[1] - extent.east[0] < 20_000.0


def test_groups_of_rows_may_part_a_target(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "tracks")
    for part in (tmp_path / "tracks").glob("bucket=*/part.parquet"):
        pl.read_parquet(part).write_parquet(part, row_group_size=37)
    whole, parted = survey(Tracks(folder)), survey(Tracks(tmp_path / "tracks"))
    assert parted.targets.rows() == whole.targets.rows()
    assert (parted.active == whole.active).all() and (parted.density == whole.density).all()
    assert parted.check.mean_ratio == pytest.approx(whole.check.mean_ratio, rel=1e-12)


def test_a_sample_decides_what_the_map_shows(folder, monkeypatch):
    """Of a sample of one bucket, rows of other buckets may be outside; none is lost."""
    monkeypatch.setattr(counting, "_SAMPLE", 1)
    found = survey(Tracks(folder))
    assert found.outside > 0 and found.density.sum() + found.outside == everything(folder).height


def test_links_lead_to_the_tracks_of_single_targets(folder, tmp_path):
    page = tmp_path / "overview.html"
    done = CliRunner().invoke(app, ["report", str(folder), "-o", str(page)])
    assert done.exit_code == 0, done.output
    text, beside = page.read_text(), (tmp_path / "overview.targets.html").read_text()
    links = re.findall(r'href="overview\.targets\.html#target=([^"]+)"', text)
    assert "ship%203" in links and len(set(links)) == 12
    names = json.loads(re.search(r'<script[^>]*id="meta"[^>]*>(.*?)</script>', beside, re.S)[1])["targets"]["name"]
    assert {link.replace("%20", " ") for link in links} == set(names)


def test_the_tracks_of_named_targets(folder, tmp_path):
    page = tmp_path / "two.html"
    done = CliRunner().invoke(app, ["report", f"{folder}/", "--target", "ship 3,ship 7", "-o", str(page), "-q"])
    assert done.exit_code == 0 and not done.output
    assert "2 targets" in page.read_text()


def test_a_file_of_tracks(folder, tmp_path):
    everything(folder).write_parquet(tmp_path / "tracks.parquet")
    done = CliRunner().invoke(app, ["report", f"{tmp_path}/tracks.parquet", "--target", "ship 1"])
    assert done.exit_code == 0, done.output
    assert "ship 1" in (tmp_path / "tracks.parquet.html").read_text()


def test_what_cannot_be_reported_is_said(folder, tmp_path):
    (tmp_path / "x.csv").write_text("a\n1\n")
    (tmp_path / "x.parquet").write_text("no parquet")
    pl.DataFrame({"a": [1]}).write_parquet(tmp_path / "y.parquet")
    half = tmp_path / "half"
    shutil.copytree(folder, half)
    (half / ".jink/manifest.json").unlink()
    for given, said in {
        f"{tmp_path}/x.csv": "expected a folder that jink track wrote",
        f"{tmp_path}/x.parquet": "cannot be read",
        f"{tmp_path}/y.parquet": "expected a column 'target'",
        f"{tmp_path}/none.parquet": "there is no file",
        f"{tmp_path}": "expected a folder that jink track wrote",
        f"{half}": "is not complete",
    }.items():
        done = CliRunner().invoke(app, ["report", given, "-o", f"{tmp_path}/page.html"])
        assert done.exit_code == 2 and said in done.stderr, (given, done.output)
    done = CliRunner().invoke(app, ["report", str(folder), "--target", "ship 3,nobody", "-o", f"{tmp_path}/page.html"])
    assert done.exit_code == 2 and "no track of nobody" in done.stderr
    assert not (tmp_path / "page.html").exists()


def test_cells_are_shaded_by_rank():
    opacity = shaded(np.array([[0, 1, 1], [5, 1000, 0]]))
    assert opacity[0, 0] == opacity[1, 2] == 0 and opacity[1, 1] == 255
    assert 0 < opacity[0, 1] == opacity[0, 2] < opacity[1, 0] < 255


def test_a_picture_has_its_rows_from_the_top():
    import base64

    opacity = np.array([[0, 10, 20], [30, 40, 50]], dtype=np.uint8)
    body = base64.b64decode(mask(opacity).partition(",")[2])
    size = int.from_bytes(body[33:37], "big")
    lines = np.frombuffer(zlib.decompress(body[41 : 41 + size]), dtype=np.uint8).reshape(2, 7)
    assert (lines[:, 2::2] == opacity).all() and (lines[:, 0] == 0).all()
