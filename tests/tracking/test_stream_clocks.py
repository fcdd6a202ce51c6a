"""A stream goes on when a clock is set, a recording begins again, or one stamp is wrong; late rows stay rejected."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta

from straight import Journey

from jink.io.loading import Reading
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings

SHIP = Journey(count=100, step=10.0, speed=7.0)
EPOCH = [time.timestamp() for time in SHIP.times]


def answers(times: list[float], at_once: int = 1) -> tuple[list[dict], list[dict], list[str]]:
    """Estimates, rejected rows and notes of the ship's rows under these times."""
    live = LiveTracks(Reading(), Settings(kind="vessel"))
    rows = [
        json.dumps({"id": "a", "t": time, "lat": place[0], "lon": place[1]}).encode()
        for time, place in zip(times, SHIP.places, strict=True)
    ]
    said, refused = "", ""
    for start in range(0, len(rows), at_once):
        estimates, lost = live.take(rows[start : start + at_once])
        said, refused = said + estimates, refused + lost
    refused += live.finish()
    return [json.loads(line) for line in said.splitlines()], [json.loads(x) for x in refused.splitlines()], live.notes


def test_one_stamp_far_ahead_costs_itself_alone():
    for ahead in (timedelta(days=30), timedelta(days=36525)):
        for at_once in (1, 7, 100):
            times = list(EPOCH)
            times[40] += ahead.total_seconds()
            found, refused, notes = answers(times, at_once)
            rows = [row["row"] for row in found]
            # a stamp after tomorrow is refused; one in the past is a part of its own until the next row tells
            future = datetime.fromtimestamp(times[40], UTC) > datetime.now(UTC) + timedelta(days=1)
            assert rows == [row for row in range(100) if row != 40 or not future]
            assert [row["row"] for row in refused] == ([40] if future else [])
            assert future or any("s ahead" in note for note in notes)
            assert {row["part"] for row in found if row["row"] != 40} == {0}
            assert abs(found[-1]["speed"] - 7.0) < 0.5


def test_a_clock_that_is_set_back_begins_a_new_part_and_loses_nothing():
    for back, at_once in ((300.0, 1), (86_400.0, 3), (495.0, 100)):
        times = [time - back * (row >= 50) for row, time in enumerate(EPOCH)]
        found, refused, notes = answers(times, at_once)
        assert [row["row"] for row in found] == list(range(100)) and not refused
        assert [row["part"] for row in found] == [0] * 50 + [1] * 50
        assert any("time goes back" in note for note in notes)
        assert abs(found[-1]["speed"] - 7.0) < 0.5


def test_rows_that_come_late_are_rejected_as_before():
    times = [*EPOCH[:50], EPOCH[20] + 1.0, EPOCH[21] + 1.0, *EPOCH[50:98]]
    found, refused, _ = answers(times)
    assert [row["row"] for row in refused] == [50, 51] and len(found) == 98
    assert {row["reason"] for row in refused} == {"time runs backwards"} and {row["part"] for row in found} == {0}


def test_rows_that_wait_when_the_stream_ends_are_counted():
    times = [*EPOCH[:98], EPOCH[10] + 1.0, EPOCH[11] + 1.0]
    found, refused, _ = answers(times, 100)
    assert [row["row"] for row in refused] == [98, 99] and len(found) == 98
