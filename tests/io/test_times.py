"""Times in: every usual way to write the same instant gives the same seconds."""

from datetime import UTC, datetime

import numpy as np
import polars as pl
import pytest

from jink.io.clocks import read_times
from jink.io.errors import InputError

INSTANT = datetime(2021, 10, 7, 12, 12, 53, 250_000, tzinfo=UTC)
SECONDS = INSTANT.timestamp()


@pytest.mark.parametrize(
    "value",
    [
        INSTANT,
        INSTANT.replace(tzinfo=None),
        SECONDS,
        SECONDS * 1e3,
        int(SECONDS * 1e6),
        int(SECONDS * 1e3) * 1_000_000,
        "2021-10-07T12:12:53.25Z",
        "2021-10-07 12:12:53.250",
        "2021-10-07T14:12:53.25+02:00",
        "2021-10-07 12:12:53.25 UTC",
        "2021-10-07T08:12:53.250000-0400",
        "2021-10-07T13:12:53.25+01",
        str(SECONDS),
        "13/10/2021 12:12:53.25",
    ],
)
def test_every_usual_form_is_read(value):
    times = read_times("f", pl.Series([value, None]), None, None)
    late = 6 * 86400 if str(value).startswith("13/") else 0
    assert times.absolute
    assert times.seconds[0] == pytest.approx(SECONDS + late, abs=2e-7)
    assert np.isnan(times.seconds[1])


def test_dates_alone_and_minutes_alone_are_read():
    times = read_times("f", pl.Series(["2021-10-07", "2021-10-07T12:12"]), None, None)
    assert times.seconds[1] - times.seconds[0] == 12 * 3600 + 12 * 60


def test_small_numbers_are_plain_seconds_and_units_of_the_name_count():
    assert not read_times("f", pl.Series([0.0, 0.5]), None, None).absolute
    named = read_times("f", pl.Series([0, 1500]), 1e-3, None)
    assert named.seconds.tolist() == [0.0, 1.5] and not named.absolute
    assert read_times("f", pl.Series([0, 1500]), None, "us").seconds[1] == pytest.approx(1.5e-3)


def test_day_first_or_month_first_is_decided_only_when_it_can_be():
    assert (
        read_times("f", pl.Series(["05/13/2021 00:00:00", "05/01/2021 00:00:00"]), None, None).seconds[0] % 86400 == 0
    )
    with pytest.raises(InputError, match="day first or month first"):
        read_times("f", pl.Series(["05/04/2021 00:00:00", "06/04/2021 00:00:00"]), None, None)


def test_unreadable_times_are_missing_one_by_one():
    seconds = read_times(
        "f", pl.Series(["2021-10-07T12:12:53Z", "yesterday", "2021-13-45T00:00:00Z", ""]), None, None
    ).seconds
    assert np.isfinite(seconds).tolist() == [True, False, False, False]
    assert np.isnan(read_times("f", pl.Series([float("inf"), float("nan")]), None, None).seconds).all()


def test_microseconds_survive_the_way_through_float_seconds():
    micros = np.arange(1_633_608_773_000_000, 1_633_608_773_000_000 + 5000, 7)
    seconds = read_times("f", pl.Series(micros).cast(pl.Datetime("us")), None, None).seconds
    assert (np.round(seconds * 1e6).astype(np.int64) == micros).all()
