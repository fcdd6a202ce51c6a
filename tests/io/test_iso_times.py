"""Times read from a column's bytes are those that reading text by text finds, and doubtful columns are left to that."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl
import pytest

from jink.io import clocks, iso_times

ROWS = iso_times.FEWEST
ZONES = ("", "Z", "z", " Z", "UTC", " UTC", "+00:00", "+0530", "-08:00", "+01")
SLOW_ZONES = (" +01:00", "CET", "+1")


def moments(seed=0):
    rng = np.random.default_rng(seed)
    edges = ["0001-01-01", "1969-12-31T23:59:59.999999", "2000-02-29", "2024-02-29T12:00:00.5", "9999-12-31T23:59:59"]
    instants = [datetime(1600, 1, 1) + timedelta(seconds=float(s)) for s in rng.uniform(0, 2e10, ROWS - len(edges))]
    return [datetime.fromisoformat(e) for e in edges] + instants


def text(moment, sign, digits, zone):
    fraction = f".{moment.microsecond:06d}"[: digits + 1] if digits else ""
    return moment.strftime(f"{moment.year:04d}-%m-%d{sign}%H:%M:%S") + fraction + zone


def one_by_one(monkeypatch, series):
    with monkeypatch.context() as m:
        m.setattr(clocks, "uniform", lambda text: None)
        return clocks._iso(series)


@pytest.mark.parametrize("zone", ZONES)
@pytest.mark.parametrize("sign", ["T", " "])
@pytest.mark.parametrize("digits", [0, 1, 3, 6])
def test_same_as_text_by_text(monkeypatch, zone, sign, digits):
    series = pl.Series([text(m, sign, digits, zone) for m in moments()])
    found = iso_times.uniform(series)
    assert found is not None
    want, naive = one_by_one(monkeypatch, series)
    assert found[0].dtype == want.dtype
    np.testing.assert_array_equal(found[0].to_physical().to_numpy(), want.to_physical().to_numpy())
    np.testing.assert_array_equal(found[1], naive)


def test_zeros_cut_off_fractions(monkeypatch):
    """As datetime.isoformat writes them: without a fraction where there is none."""
    whole = [m.replace(microsecond=0) if k % 3 else m for k, m in enumerate(moments(1))]
    series = pl.Series([m.replace(tzinfo=UTC).isoformat() for m in whole])
    found = iso_times.uniform(series)
    assert found is not None and series.str.len_bytes().n_unique() == 2
    want, naive = one_by_one(monkeypatch, series)
    np.testing.assert_array_equal(found[0].to_physical().to_numpy(), want.to_physical().to_numpy())
    np.testing.assert_array_equal(found[1], naive)


@pytest.mark.parametrize(
    "odd",
    [
        "2023-02-29T00:00:00Z",
        "2024-13-01T00:00:00Z",
        "2024-01-01T24:00:00Z",
        "2024-01-01T23:59:60Z",
        "2024-00-10T00:00:00Z",
        "2024-01-01t00:00:00Z",
        "2024-01-01T00:00:0١",
        "2024-1-01T000:00:00Z",
        "never",
        "",
        None,
        "2024-01-01T00:00:00+",
    ],
)
def test_other_columns_are_left_alone(odd):
    """A day or an hour that there is not, another form, or nothing at all."""
    usual = [text(m, "T", 0, "Z") for m in moments(2)]
    assert iso_times.uniform(pl.Series(usual)) is not None
    assert iso_times.uniform(pl.Series([*usual[:-1], odd])) is None
    assert iso_times.uniform(pl.Series([odd, *usual])) is None


@pytest.mark.parametrize("zone", SLOW_ZONES)
def test_unknown_zones_are_left_alone(zone):
    assert iso_times.uniform(pl.Series([text(m, "T", 0, zone) for m in moments(3)])) is None


def test_zones_that_change_are_left_alone():
    usual = [text(m, "T", 0, "+01:00" if k % 2 else "+02:00") for k, m in enumerate(moments(4))]
    assert iso_times.uniform(pl.Series(usual)) is None


@pytest.mark.parametrize("zone", ["", "+05:30"])
def test_blocks_give_what_text_by_text_gives(monkeypatch, zone):
    series = pl.Series([text(m, "T", k, zone) for m in moments(5) for k in (0, 6)])
    monkeypatch.setattr(iso_times, "BLOCK", 300)
    found = iso_times.uniform(series)
    assert found is not None
    want, naive = one_by_one(monkeypatch, series)
    np.testing.assert_array_equal(found[0].to_physical().to_numpy(), want.to_physical().to_numpy())
    np.testing.assert_array_equal(found[1], naive)
    for odd in ("2023-02-29T00:00:00" + zone, "0000-01-01T00:00:00" + zone):
        assert iso_times.uniform(pl.concat([series, pl.Series([odd])])) is None


def test_a_column_is_read_alike_with_blanks_around_its_texts_and_without():
    usual = [text(m, "T", 0, "") for m in moments(6)]
    how = clocks.Conventions(time_zone="Europe/Paris")
    bare, padded = (
        clocks.read_times("here", pl.Series(texts), None, None, how) for texts in (usual, [f' "{t}" ' for t in usual])
    )
    assert bare.absolute and bare.notes == padded.notes == ["times without a zone are in Europe/Paris"]
    np.testing.assert_array_equal(bare.seconds, padded.seconds)


def test_a_format_that_is_told_goes_before_the_usual_one():
    usual = [text(m, "T", 0, "") for m in moments(7)]
    swapped = clocks.read_times(
        "here", pl.Series(usual), None, None, clocks.Conventions(time_format="%Y-%d-%mT%H:%M:%S")
    )
    days = [m.day <= 12 for m in moments(7)]
    assert np.isfinite(swapped.seconds).tolist() == days and swapped.notes == ["times are read as %Y-%d-%mT%H:%M:%S"]
