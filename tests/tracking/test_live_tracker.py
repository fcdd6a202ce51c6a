"""LiveTracker gives what `jink track -` gives for the same rows, predicts, is saved, and forgets."""

from __future__ import annotations

import copy
import json
import os
import threading
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from numpy.testing import assert_allclose

import jink
from jink.cli.track import TrackRequest, run_track

START = datetime(2026, 5, 1, 12, tzinfo=UTC)


def ships(seed=0, scans=40):
    """Three ships in geographic coordinates whose rows come mixed, some twice, one out of order."""
    rng = np.random.default_rng(seed)
    rows = []
    for k in range(scans):
        for n in range(3):
            t = START + timedelta(seconds=10.0 * k + n)
            east, north = (7.0 + n) * 10.0 * k + rng.normal(0, 5), 3.0 * 10.0 * k + rng.normal(0, 5)
            lat, lon = 54.0 + north / 111_000.0, 8.0 + n * 0.1 + east / 65_000.0
            rows.append({"target": f"ship {n}", "time": t.isoformat(), "lat": lat, "lon": lon})
    rows.insert(30, dict(rows[29]))
    rows[60], rows[63] = rows[63], rows[60]
    return rows


def piped(rows, monkeypatch, capsys, **request):
    """The rows through `jink track -`."""
    read, write = os.pipe()
    text = "".join(json.dumps(row) + "\n" for row in rows).encode()

    def feed():
        os.write(write, text)
        os.close(write)

    thread = threading.Thread(target=feed)
    thread.start()
    with os.fdopen(read) as source:
        monkeypatch.setattr("sys.stdin", source)
        assert run_track(TrackRequest(inputs=["-"], quiet=True, **request)) == 0
    thread.join()
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def assert_same(got, want):
    assert len(got) == len(want) > 100
    for ours, theirs in zip(got, want, strict=True):
        assert ours.keys() - {"row"} == theirs.keys() - {"row"}
        for name, value in theirs.items():
            if isinstance(value, float):
                assert_allclose(ours[name], value, rtol=1e-9, atol=1e-9, err_msg=name)
            elif name != "row":
                assert ours[name] == value, name


@pytest.mark.parametrize(("kind", "filter"), [("vessel", None), ("vessel", "kalman-cv"), ("vessel", "vsmm-ag")])
def test_it_is_jink_track_of_the_same_rows(kind, filter, monkeypatch, capsys):
    rows = ships()
    want = piped(rows, monkeypatch, capsys, kind=kind, filter=filter)
    tracker = jink.LiveTracker(kind, filter=filter)
    got = []
    for row in rows:
        got += tracker.update_many([row])
    assert_same(got, want)
    assert_same(jink.LiveTracker(kind, filter=filter).update_many(rows), want)
    assert [row["reason"] for row in tracker.rejected] == ["time occurs twice", "time runs backwards"]


def test_update_takes_dates_and_columns_by_name():
    tracker = jink.LiveTracker("vessel", sensor_sd=10.0)
    for row in ships():
        now = tracker.update(row["target"], datetime.fromisoformat(row["time"]), lat=row["lat"], lon=row["lon"])
    assert now is not None and now["status"] == "updated" and now["target"] == "ship 2"
    assert abs(now["latitude"] - 54.0105) < 1e-3
    assert tracker.targets == ["ship 0", "ship 1", "ship 2"]
    assert tracker.update("ship 2", now["time"], lat=54.0, lon=8.0) is None
    assert tracker.rejected[-1]["reason"] == "time occurs twice"
    numbers = jink.LiveTracker("vessel", sensor_sd=10.0)
    assert numbers.update(7, np.float64(0.0), x=np.float32(1.0), y=2.0)["target"] == "7"
    assert numbers.update(7, 1.0, x=float("nan"), y=None)["status"] == "predicted"


def test_a_prediction_is_the_row_without_a_measurement():
    rows = ships()
    tracker = jink.LiveTracker("vessel", filter="kalman-cv", sensor_sd=10.0)
    tracker.update_many(rows)
    before = tracker.save()
    later = START + timedelta(seconds=420.0)
    ahead = tracker.predict(later)
    assert tracker.save() == before and [row["target"] for row in ahead] == tracker.targets
    missing = tracker.update("ship 1", later, lat=None, lon=None)
    assert missing is not None and missing["status"] == ahead[1]["status"] == "predicted"
    for name, value in ahead[1].items():
        if isinstance(value, float) and name in missing:
            assert_allclose(value, missing[name], rtol=1e-9, err_msg=name)
    assert ahead[1]["x_sd"] > 10.0 and tracker.predict(START) == []
    assert tracker.predict(later.isoformat())[0] == ahead[0]
    with pytest.raises(ValueError, match="expected seconds or a date"):
        tracker.predict("noon")


@pytest.mark.parametrize("how", ["save", "file", "copy"])
def test_it_goes_on_from_where_it_was_saved(how, tmp_path):
    rows = ships()
    whole, first = jink.LiveTracker("vessel"), jink.LiveTracker("vessel")
    want = whole.update_many(rows[:70])
    want = whole.update_many(rows[70:])
    first.update_many(rows[:70])
    if how == "save":
        again = jink.LiveTracker.load(first.save())
    elif how == "file":
        first.save(tmp_path / "state.bin")
        again = jink.LiveTracker.load(tmp_path / "state.bin")
    else:
        again = copy.deepcopy(first)
    first.update_many(rows[70:90])  # which the copy does not feel
    assert again.update_many(rows[70:]) == want


def test_targets_expire_after_the_gap():
    tracker = jink.LiveTracker("vessel", gap=60.0)
    tracker.update("gone", 0.0, x=0.0, y=0.0)
    for t in range(0, 400, 10):
        tracker.update("here", float(t), x=5.0 * t, y=0.0)
    assert tracker.targets == ["here"]
    assert [row["target"] for row in tracker.predict(400.0)] == ["here"]
    assert tracker.update("gone", 401.0, x=0.0, y=0.0)["part"] == 1


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: jink.LiveTracker("aeroplane"), "aeroplane"),
        (lambda: jink.LiveTracker(gap=-1.0), "gap is -1.0"),
        (lambda: jink.LiveTracker().update("a", 0.0, speed=3.0), "position"),
        (lambda: jink.LiveTracker.load(b"else"), "is no state of a LiveTracker"),
        (lambda: jink.LiveTracker.load(b"jink live tracker 1\n0.0.0\n"), "is of jink 0.0.0"),
    ],
)
def test_what_is_wrong_is_said(call, said):
    with pytest.raises(ValueError, match=said):
        call()
