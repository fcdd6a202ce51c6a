"""A stream goes on for ever: slots are freed, lines are bounded, and what cannot be used is counted and reported."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from jink.io.loading import Reading
from jink.tracking.lag import Lag
from jink.tracking.live import LiveTracks
from jink.tracking.live_lines import LONGEST, TooLong
from jink.tracking.prepare import Settings
from jink.tracking.stream import arriving

GIVEN = {"position": 20.0}


def line(name: str, time: float, x: float, y: float = 0.0, **more) -> bytes:
    return json.dumps({"id": name, "time": time, "x": x, "y": y, **more}).encode()


def stream(**settings) -> LiveTracks:
    return LiveTracks(Reading(), Settings(sensor_sd=GIVEN, **settings))


def in_use(live: LiveTracks) -> int:
    return sum(pool.slots.in_use if pool.slots else len(pool.singles) for pool in live.pools.values())


def objects(text: str) -> list[dict]:
    return [json.loads(each) for each in text.splitlines()]


@pytest.mark.parametrize("filter", [None, "vsmm-ag", "kalman-cv"])
def test_slots_are_freed_after_the_gap(filter):
    """Every 100 s ten targets come, are seen for 40 s, and go; the gap of an aircraft is 300 s."""
    live = stream(filter=filter)
    most, rows = 0, 0
    for wave in range(20):
        for k in range(10):
            t = 100.0 * wave + 4.0 * k
            lines = [line(f"{wave}-{n}", t + 0.1 * n, 200.0 * t, 1e4 * n) for n in range(10)]
            rows += len(objects(live.take(lines)[0]))
            most = max(most, in_use(live))
    assert rows == 2000 and len(live.followed) == 200
    # those of five waves at most, and of the first rows of the stream, when the step was not known
    assert 40 <= most <= 70


def test_a_target_that_comes_back_begins_a_new_part():
    live = stream()
    answers = []
    for t in range(0, 2000, 4):
        lines = [line("always", t, 200.0 * t)]
        if t < 40 or t >= 1600:
            lines.append(line("back", t, 150.0 * t, 5e3))
        answers += objects(live.take(lines)[0])
    back = [row for row in answers if row["target"] == "back"]
    assert [row["part"] for row in back] == [0] * 10 + [1] * 100
    assert {row["part"] for row in answers if row["target"] == "always"} == {0}
    assert in_use(live) == 2 and abs(back[-1]["speed"] - 150.0) < 5


@pytest.mark.parametrize("first", [0, 1, 2, 7])
@pytest.mark.parametrize("at_once", [1, 40])
@pytest.mark.parametrize("lag", [None, "2"])
def test_a_target_gets_heights_from_the_first_one_on(first, at_once, lag):
    """Rows without a height come first; another target has heights all the time."""
    live = stream(lag=Lag.of(lag))
    lines = []
    for k in range(40):
        z = {"z": 1000.0 + 10.0 * k} if k >= first else {}
        lines += [line("late", 4.0 * k, 600.0 * k, **z), line("always", 4.0 * k, 600.0 * k, 9e3, z=3000.0)]
    rows = []
    for start in range(0, len(lines), at_once):
        rows += objects(live.take(lines[start : start + at_once])[0])
    late = [row for row in rows if row["target"] == "late"]
    assert len(late) == 40 and {row["part"] for row in late} == {0}
    assert [row.get("z") is None for row in late] == [k < first for k in range(40)]
    assert abs(late[-1]["z"] - 1390.0) < 20 and abs(late[-1]["climb_rate"] - 2.5) < 1.0
    assert abs(late[-1]["speed"] - 150.0) < 5 and in_use(live) == 2
    assert lag is None or (late[-1]["lagged_z"] is not None and late[-1]["lagged_row"] == late[-3]["row"])


def test_targets_whose_clock_is_late_are_not_forgotten():
    """One in four has a clock an hour behind; all are seen all the time."""
    live = stream()
    parts = set()
    for t in range(0, 4000, 5):
        lines = [line(f"{k}", t - 3600.0 * (k == 0), 200.0 * t, 1e4 * k) for k in range(4)]
        parts |= {row["part"] for row in objects(live.take(lines)[0])}
    assert parts == {0} and in_use(live) == 4


def test_one_line_of_another_kind_of_position_is_counted_and_reported():
    for at_once in (1, 3, 50):
        live = stream()
        lines = [line("a", float(k), 100.0 * k) for k in range(20)]
        lines[9:9] = [json.dumps({"id": "b", "time": 8.5, "lat": 50.0, "lon": 8.0}).encode()]
        lines[15:15] = [json.dumps({"id": "b", "time": "2024-05-06T07:08:09Z", "x": 1.0, "y": 1.0}).encode()]
        estimates, refused = "", ""
        for start in range(0, len(lines), at_once):
            more = live.take(lines[start : start + at_once])
            estimates, refused = estimates + more[0], refused + more[1]
        found, lost = objects(estimates), objects(refused)
        assert [row["row"] for row in found] == [k for k in range(22) if k not in (9, 15)]
        assert [row["row"] for row in lost] == [9, 15] and live.rejected == 2
        assert "those of the stream are cartesian" in lost[0]["reason"]
        assert {row["part"] for row in found} == {0}


def test_a_position_that_repeats_is_known_within_a_block():
    """A stale position in the middle of many lines is treated as if the lines had come one by one."""
    lines = [line("a", 4.0 * k, 800.0 * (k - (k % 5 == 4)), 3.0 * (k - (k % 5 == 4))) for k in range(60)]
    one, many = stream(), stream()
    single = [row for each in lines for row in objects(one.take([each])[0])]
    together = objects(many.take(lines)[0])
    assert [row["status"] for row in together] == [row["status"] for row in single]
    assert [row["status"] for row in single].count("predicted") == 12
    np.testing.assert_array_equal([row["x"] for row in together], [row["x"] for row in single])


@pytest.mark.parametrize("times", [2, 3, 5])
@pytest.mark.parametrize("geographic", [False, True])
def test_positions_that_are_said_several_times_do_not_stop_a_target(times, geographic):
    """A filter that begins with one position twice takes the target for one at rest."""
    live, rows = LiveTracks(Reading(), Settings(sensor_sd={"position": 2.0})), []
    for k in range(60):
        x = 800.0 * (k // times * times)
        said = {"lat": 0.0, "lon": x / 111_319.49} if geographic else {"x": x, "y": 0.0}
        rows += objects(live.take([json.dumps({"id": "a", "time": 4.0 * k, **said}).encode()])[0])
    assert all(abs(row["speed"] - 200.0) < 5 for row in rows[5 * times :])


def test_a_future_stamp_at_the_first_sight_of_a_target_costs_itself():
    live = stream()
    first = 1.7e9
    rows = []
    for k in range(30):
        t = first + 4.0 * k
        lines = [line("a", t, 800.0 * k)]
        if k >= 10:
            lines.append(line("b", t + (1e9 if k == 10 else 0.0), 800.0 * k, 9e3))
        rows += objects(live.take(lines)[0])
    assert [row["part"] for row in rows if row["target"] == "b"] == [0] * 19


@pytest.mark.parametrize("ahead", [20.0, 100.0, 250.0, 400.0, 5_000.0, 80_000.0])
def test_no_stamp_silences_a_target(ahead):
    live = stream()
    rows = []
    for k in range(40):
        rows += objects(live.take([line("a", 1.7e9 + 10.0 * k + ahead * (k == 20), 2_000.0 * k)])[0])
    seen = [row["row"] for row in rows]
    assert len(seen) >= 39 - 10 and seen[-10:] == list(range(30, 40))


def test_long_lines_are_cut_and_named(tmp_path):
    pipe = tmp_path / "lines"
    long = b'{"id": "' + b"a" * (5 * LONGEST) + b'"}'
    pipe.write_bytes(line("a", 0, 0) + b"\n" + long + b"\n" + line("a", 1, 1) + b"\n" + long)
    handle = os.open(pipe, os.O_RDONLY)
    lines = [each for block in arriving(handle) for each in block]
    os.close(handle)
    assert [isinstance(each, TooLong) for each in lines] == [False, True, False, True]
    assert max(map(len, lines)) == LONGEST
    refused = objects(stream().take(lines)[1])
    assert [row["row"] for row in refused] == [1, 3] and "longer than 1,048,576 bytes" in refused[0]["reason"]


def test_many_names_are_no_columns():
    live = stream()
    for k in range(300):
        live.take([line("a", float(k), 100.0 * k, **{f"n{k}-{n}": 1 for n in range(40)})])
    assert live.rejected == 0 and len(live.lines.names) < 5_000


def test_standard_error_that_nobody_reads_stops_nothing():
    process = subprocess.Popen(
        [sys.executable, "-m", "jink", "track", "-", "--sensor-sd", "20"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdin and process.stdout and process.stderr

    def feed() -> None:
        for k in range(3_000):
            process.stdin.write(line("a", float(k), 100.0 * k) + b"\n{this is no JSON, and is said to be none}\n")
        process.stdin.close()

    threading.Thread(target=feed, daemon=True).start()
    answers = process.stdout.read().splitlines()
    assert len(answers) == 3_000
    assert process.wait(timeout=30) == 0
    process.stdout.close()
    process.stderr.close()
