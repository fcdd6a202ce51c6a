"""A track that has lost its target hands its id to the new track that has found it."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from association.test_tracker import as_the_textbook_has_them, imm, pictures, same
from oracle.association import Textbook

import jink
from jink.scenarios.skies import sky_called

AREA = (-50e3, 50e3, -50e3, 50e3)
P = np.diag([50.0**2, 5.0**2] * 2)
TURN = 3  # the scan in which the target turns away, and a false plot lies where it would have been
LAST = 16


def tracker(detection=0.6, **options):
    # misses say so little that a track without plots stays confirmed for long
    radar = jink.Radar(detection=detection, clutter_per_scan=300, area=AREA, learn_clutter=False)
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=10.0), jink.Position(sd=50.0))
    return jink.Tracker(filter, radar, targets=0, new_per_hour=400, report=0.0, **options)


def true_place(scan):
    """East at 200 m/s, from the turn on to the north too: first within the gate of straight flight, then beyond it."""
    return [800.0 * scan, 240.0 + 700.0 * (scan - TURN) if scan >= TURN else 0.0]


def plots(scan):
    return [true_place(scan), *([[800.0 * scan, 0.0]] if scan == TURN else [])]


def flown(made, code=None):
    """Pictures of all scans of a target that turns away from its track."""
    made.add(0.0, [0.0, 200.0, 0.0, 0.0], P)
    found = []
    for k in range(1, LAST):
        own = None if code is None else [code(k), *[-1] * (len(plots(k)) - 1)]
        found.append(made.scan(4.0 * k, plots(k), code=own))
    return found


def holder(picture, scan):
    """Row of the confirmed track at the target, or None."""
    near = np.hypot(*(picture.positions - true_place(scan)).T) < 150
    rows = np.flatnonzero(near & picture.confirmed)
    return int(rows[0]) if len(rows) else None


def test_the_new_track_of_a_target_goes_on_under_the_old_id():
    found = flown(tracker())
    handed = [picture.report["handed"] for picture in found]
    (when,) = [k for k, each in enumerate(handed) if each]
    (a, b), (c, d) = handed[when]
    assert a == d == 0 and b == c > 0
    before, after = found[when - 1], found[when]
    # until then the old track flies straight on, confirmed; the new one is not
    lost = before.ids.tolist().index(0)
    assert before.confirmed[lost] and before.positions[lost, 1] < 100
    assert holder(before, when) is None
    row = holder(after, when + 1)
    assert after.ids[row] == 0
    # so is its age
    assert after.age[row] == before.age[lost] + 1
    other = after.ids.tolist().index(b)
    assert after.positions[other, 1] < 100 and not after.confirmed[other]
    assert after.report["confirmed"] == after.confirmed.sum() == 1
    assert found[-1].ids[holder(found[-1], LAST - 1)] == 0


def test_without_the_rule_it_keeps_its_own():
    made = tracker()
    made.rules.inherit = np.inf
    made.reset()
    found = flown(made)
    assert not any(picture.report["handed"] for picture in found)
    assert found[-1].ids[holder(found[-1], LAST - 1)] != 0


@pytest.mark.parametrize("same_code", [True, False])
def test_plots_that_tell_another_code_are_another_target_s(same_code):
    found = flown(tracker(), code=lambda k: 7 if k < TURN or same_code else 8)
    assert any(picture.report["handed"] for picture in found) == same_code
    assert (found[-1].ids[holder(found[-1], LAST - 1)] == 0) == same_code


def test_a_target_that_goes_on_keeps_its_id_beside_a_new_one():
    """The new track's first plot lay in the old one's gate, but the old one has its plots too."""
    made = tracker()
    made.add(0.0, [0.0, 200.0, 0.0, 0.0], P)
    for k in range(1, LAST):
        here = [[800.0 * k, 0.0], *([[800.0 * k, 150.0 + 60.0 * (k - TURN) ** 2]] if k >= TURN else [])]
        picture = made.scan(4.0 * k, here)
        assert not picture.report["handed"]
    assert picture.confirmed.sum() == 2
    straight = int(np.argmin(np.abs(picture.positions[:, 1])))
    assert picture.ids[straight] == 0


def test_what_speaks_for_branches_is_saved():
    whole, first, second = tracker(), tracker(), tracker()
    a = flown(whole)
    first.add(0.0, [0.0, 200.0, 0.0, 0.0], P)
    for k in range(1, TURN + 2):
        first.scan(4.0 * k, plots(k))
    second.load(first.save())
    rest = [second.scan(4.0 * k, plots(k)) for k in range(TURN + 2, LAST)]
    assert same(a[TURN + 1 :], rest)
    assert any(picture.report["handed"] for picture in rest)


def test_the_lagged_estimate_follows_the_target_under_its_id():
    found = flown(tracker(lag=3))
    when = next(k for k, picture in enumerate(found) if picture.report["handed"])
    row = holder(found[when], when + 1)
    lagged = found[when].lagged
    # scans count from 1
    assert np.allclose([lagged["px"][row], lagged["py"][row]], true_place(when + 1 - 3), atol=100)


def test_a_smoothed_track_begins_anew_where_its_id_was_handed_on():
    rows = [(4.0 * k, *each) for k in range(-6, LAST) for each in (plots(k) if k > 0 else [[800.0 * k, 0.0]])]
    table = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")
    made = tracker()
    plain, smooth = made.run(table), None
    made.reset()
    smooth = made.run(table, smooth=True)
    assert plain["id"].equals(smooth["id"])
    scan = (smooth["time"] / 4.0).round().cast(int).to_numpy()
    held = np.flatnonzero((smooth["id"] == smooth["id"].min()).to_numpy() & (scan > TURN))
    places = smooth.select("px", "py").to_numpy()
    apart = np.array([np.hypot(*(places[k] - true_place(scan[k]))) for k in held])
    gone = apart > 200
    # it flew on, then was at the target, and nowhere in between
    assert gone.any() and not gone[-1] and (apart[~gone] < 100).all() and (np.diff(gone.astype(int)) <= 0).all()


@pytest.mark.parametrize("threads, shuffle", [(2, False), (1, True)])
def test_neither_threads_nor_the_order_of_plots_matter_to_a_bit(threads, shuffle):
    sky = sky_called("sky-regional-1000-12s")
    run = sky.run(2, 5)
    options = {"targets": sky.targets, "new_per_hour": sky.arrivals / sky.interval * 3600, "stay": sky.life}
    radar = jink.Radar(clutter_per_scan=sky.clutter, area=sky.area)
    one, other = (jink.Tracker(imm(sky.sd), radar, threads=n, **options) for n in (1, threads))
    run = type(run)(run.scans[:18], run.truth[:18], run.velocity[:18])
    order = (lambda k, n: np.random.default_rng(k).permutation(n)) if shuffle else None
    a, b = pictures(one, run), pictures(other, run, order)
    assert same(a, b)
    assert [p.report["handed"] for p in a] == [p.report["handed"] for p in b]
    assert sum(len(p.report["handed"]) for p in a) > 4


def textbook():
    """What ``tracker`` declares, for scans of 4 s."""
    one = np.array([[1.0, 4.0], [0.0, 1.0]])
    noise = 10.0 * np.array([[64 / 3, 8.0], [8.0, 4.0]])
    H = np.zeros((2, 4))
    H[0, 0] = H[1, 2] = 1
    area = (AREA[1] - AREA[0]) * (AREA[3] - AREA[2])
    return Textbook(
        F=np.kron(np.eye(2), one)[None],
        Q=np.kron(np.eye(2), noise)[None],
        transition=np.eye(1),
        start=np.ones(1),
        H=H,
        R=50.0**2 * np.eye(2),
        speed_variance=150.0**2,
        detection=0.6,
        clutter=300 / area,
        undetected=0.0,
        arrivals=400 * 4 / 3600 / area,
        survival=np.exp(-4 / 3600),
        box=AREA,
        leaving=np.exp(-4 / 60),
        learning=False,
    )


def test_existence_and_ids_are_the_textbook_s():
    ours, theirs = tracker(), textbook()
    rng = np.random.default_rng(4)
    same_as: dict[int, int] = {}
    for k in range(-8, LAST):
        here = plots(k) if k > 0 else [[800.0 * k, 0.0]]
        false = np.array([800.0 * k, 400.0]) + rng.uniform(-1500, 1500, (rng.poisson(2), 2))
        z = np.vstack([here, false])
        picture = ours.scan(4.0 * k, z)
        theirs.scan(z)
        order, want = as_the_textbook_has_them(picture, theirs)
        for id_, track in zip(picture.ids[order].tolist(), want, strict=True):
            assert same_as.setdefault(id_, track.id) == track.id
    assert theirs.handed == 1
