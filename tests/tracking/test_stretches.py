"""A long part in overlapping stretches has the estimates of the whole part, to 1e-9 of their standard deviations."""

from __future__ import annotations

from functools import partial

import numpy as np
import polars as pl
import pytest

import jink
from jink.estimate import covariance_pair
from jink.filters.axis_by_axis import AxisByAxis
from jink.filters.row_noise import RowNoise
from jink.io.loading import Reading, load_frame
from jink.tracking import batch, stretches
from jink.tracking.prepare import Settings, prepare
from jink.tracking.stretches import OUTPUTS, Stretched, pieces

ROWS = 9_000


def table(rows: int = ROWS, seed: int = 0) -> pl.DataFrame:
    """One target that turns now and then, with some positions missing and some wrong."""
    rng = np.random.default_rng(seed)
    turning = np.repeat(rng.choice([0.0, 0.03, -0.02], rows // 60 + 1, p=[0.6, 0.2, 0.2]), 60)[:rows]
    course = np.cumsum(turning)
    x, y = np.cumsum(200.0 * np.sin(course)), np.cumsum(200.0 * np.cos(course))
    x, y = x + rng.normal(0, 20.0, rows), y + rng.normal(0, 20.0, rows)
    x[rng.random(rows) < 0.01] += 5_000.0
    x[rng.random(rows) < 0.05] = np.nan
    return pl.DataFrame({"target": "a", "time": np.arange(rows) * 1.0, "x": x, "y": np.where(np.isnan(x), np.nan, y)})


def group(filter: str, **settings):
    loaded = load_frame(table(), Reading())
    (found,) = prepare(loaded.measurements, Settings(filter=filter, **settings)).groups
    return found


def both(filter: str, most: int, **settings):
    """Estimates in pieces, and of the whole part."""
    one = group(filter, **settings)
    smoothing = Settings(filter=filter, **settings).smoothing
    run = Stretched(one.filter, one.placed, one.covariance, smoothing, 1)
    found = [run.run(piece) for piece in pieces(one.placed.offsets, most)]
    verb = one.filter.filter if smoothing is None else one.filter.smooth
    whole = verb(one.placed.time, one.placed.z, covariance=one.covariance, outputs=(*OUTPUTS, "P"))
    return together(found), whole, run, len(found)


def together(found: list[jink.Estimate]) -> dict[str, np.ndarray]:
    return {name: np.concatenate([each.results[name] for each in found]) for name in found[0].results}


def covariances(estimate: jink.Estimate, names) -> dict[str, np.ndarray]:
    """Those of P among the names."""
    pairs = {name: covariance_pair(name, estimate.components) for name in names}
    return {name: estimate.P[:, pair[0], pair[1]] for name, pair in pairs.items() if pair}


def sds(estimate: jink.Estimate) -> np.ndarray:
    return np.stack([estimate.sd(name) for name in estimate.components], axis=1)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("filter", ["imm", "kalman-cv", "singer", "aimm3", "imm-cv-ct"])
def test_stretches_have_the_estimates_of_the_whole_part(filter, smooth):
    if smooth and getattr(group(filter).filter, "not_smoothed", ""):
        return
    found, whole, _, count = both(filter, 2_000, smooth=smooth)
    assert count == 5
    assert np.nanmax(np.abs(found["x"] - whole.x) / sds(whole)) < 1e-9
    wanted = covariances(whole, found)
    assert len(wanted) > len(whole.components)
    for name, value in wanted.items():
        spread = np.multiply(*(whole.sd(each) for each in name[2:-1].split(",")))
        assert np.nanmax(np.abs(found[name] - value) / spread) < 1e-9
    assert np.nanmax(np.abs(found["mode_probability"] - whole.mode_probability)) < 1e-9
    np.testing.assert_array_equal(found["status"], whole.status)


def test_an_overlap_that_is_too_short_grows(monkeypatch):
    monkeypatch.setattr(stretches, "OVERLAP", 4)
    found, whole, run, _ = both("imm", 2_000)
    assert run.overlap > 4
    assert np.nanmax(np.abs(found["x"] - whole.x) / sds(whole)) < 1e-9


def too_short(monkeypatch):
    """No overlap is long enough."""
    monkeypatch.setattr(stretches, "MOST", 8)
    monkeypatch.setattr(stretches, "OVERLAP", 4)


def test_a_smoother_that_remembers_too_long_runs_over_the_whole_part(monkeypatch):
    too_short(monkeypatch)
    found, whole, run, _ = both("imm", 2_000, smooth=True)
    assert run.overlap > 8
    np.testing.assert_array_equal(found["x"], whole.x)


@pytest.mark.parametrize("filter", ["imm", "kalman-cv", "singer", "aimm3", "imm-cv-ct"])
def test_a_filter_that_remembers_too_long_carries_its_state(monkeypatch, filter):
    """Every row is run once, whatever the number of pieces."""
    too_short(monkeypatch)
    rows, once = [], stretches.Carried.run
    monkeypatch.setattr(stretches.Carried, "run", lambda self, of, some: rows.append(some) or once(self, of, some))
    found, whole, _, count = both(filter, 2_000)
    assert count == 5 and np.concatenate([np.arange(ROWS)[some] for some in rows]).tolist() == list(range(ROWS))
    for name, value in {**{name: whole.results[name] for name in OUTPUTS}, **covariances(whole, found)}.items():
        np.testing.assert_array_equal(found[name], value)


def test_a_filter_of_ones_own_carries_its_state_row_by_row(monkeypatch):
    too_short(monkeypatch)
    one = group("imm", sensor_sd={"position": 20.0})
    sensor = jink.Position(sd=20.0, axes=1)
    along = jink.IMM([jink.ConstantVelocity(acceleration_psd=q) for q in (0.1, 30.0)], sensor=sensor, transition=0.95)
    filter, covariance = AxisByAxis(along, 2), np.full((ROWS, 2), 400.0)
    run = Stretched(filter, one.placed, RowNoise.of_variances(covariance.T), None, 1)
    found = [run.run(piece) for piece in pieces(one.placed.offsets, 2_000)]
    whole = filter.filter(one.placed.time, one.placed.z, covariance=covariance, outputs=(*OUTPUTS, "P"))
    joined = together(found)
    for name, value in {"x": whole.x, "status": whole.status, **covariances(whole, joined)}.items():
        np.testing.assert_array_equal(joined[name], value)


def test_a_state_is_carried_from_a_piece_in_the_middle(monkeypatch):
    """The first pieces agreed; then one does not."""
    found, _, run, _ = both("imm", 2_000)
    one = group("imm")
    cut = list(pieces(one.placed.offsets, 2_000))
    too_short(monkeypatch)
    monkeypatch.setattr(stretches, "CHUNK", 1_500)
    run.overlap = 16
    last = run.run(cut[-1])
    assert np.nanmax(np.abs(found["x"][cut[-1].rows] - last.x) / sds(last)) < 1e-9


def test_far_away_stretches_agree_as_far_as_digits_go(monkeypatch):
    """At 3·10⁵ sds from the origin, ten rows a second: the filter remembers as many seconds as near by."""
    step = 0.1
    rows = table(60_000).with_columns(pl.col("time") * step, x=6e6 + pl.col("x") * step, y=6e6 + pl.col("y") * step)
    (one,) = prepare(
        load_frame(rows, Reading()).measurements, Settings(filter="imm", sensor_sd={"position": 20.0})
    ).groups
    run = Stretched(one.filter, one.placed, one.covariance, None, 1)
    for piece in pieces(one.placed.offsets, 4_000):
        run.run(piece)
    assert run.overlap <= stretches.MOST


def test_pieces_cover_all_rows_once():
    offsets = np.array([0, 5, 9, 40, 42, 43, 50])
    cut = list(pieces(offsets, 10))
    rows = np.concatenate([np.arange(50)[piece.rows] for piece in cut])
    np.testing.assert_array_equal(rows, np.arange(50))
    assert [piece.part for piece in cut if piece.part is not None] == [slice(9, 40)] * 4


@pytest.mark.parametrize("smooth", [False, True])
def test_manoeuvres_go_on_from_piece_to_piece(monkeypatch, smooth):
    short = pl.concat([table(), table(300, 1).with_columns(target=pl.lit("b"))])
    whole = jink.track(short, sensor_sd=20.0, smooth=smooth)
    monkeypatch.setattr(batch, "pieces", partial(pieces, most=2_000))
    found = jink.track(short, sensor_sd=20.0, smooth=smooth)
    np.testing.assert_allclose(found["manoeuvring"], whole["manoeuvring"], atol=1e-7)
    assert whole["segment"].to_numpy().max() > 20
    assert found["segment"].to_list() == whole["segment"].to_list()
