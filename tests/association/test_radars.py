"""What sensors see: codes, own times, range and azimuth, heights, several radars, reports that come when they come."""

import numpy as np
import pytest

import jink
from jink.scenarios.skies import sky_called

SD, T = 50.0, 4.0
TURN = np.radians(2.5)


def imm(sd=SD, stay=0.95):
    models = [
        jink.ConstantVelocity(acceleration_psd=1.0),
        jink.KnownTurn(turn_rate=TURN, acceleration_psd=10.0),
        jink.KnownTurn(turn_rate=-TURN, acceleration_psd=10.0),
    ]
    return jink.IMM(models, jink.Position(sd=sd), stay)


def radar(sky, **changes):
    return jink.Radar(**({"clutter_per_scan": sky.clutter, "area": sky.area, "detection": sky.detection} | changes))


def tracker(sky, filter=None, **changes):
    options = {"targets": sky.targets, "new_per_hour": sky.arrivals / sky.interval * 3600, "stay": sky.life}
    return jink.Tracker(filter or imm(sky.sd), radar(sky), **(options | changes))


def test_a_code_keeps_two_targets_apart():
    sky = sky_called("sky-parallel-50")
    changed = {True: 0, False: 0}
    for number in range(12):
        run = sky.run(number, 8)
        for coded in (True, False):
            t = tracker(sky)
            named = {}
            for scan in run.scans:
                codes = np.where(scan.origin >= 0, scan.origin + 100, -1) if coded else None
                picture = t.scan(scan.time, scan.z, code=codes)
                for id, plot in zip(picture.ids[picture.confirmed], picture.plot[picture.confirmed], strict=True):
                    if plot >= 0 and scan.origin[plot] >= 0:
                        named.setdefault(int(id), []).append(int(scan.origin[plot]))
            changed[coded] += sum(int(np.count_nonzero(np.diff(each))) for each in named.values())
    assert changed[True] <= 2 < changed[False]


def test_a_known_target_is_there_at_once_and_out_of_sight_is_no_miss():
    t = jink.Tracker(imm(), jink.Radar(area=(0, 1000, 0, 1000), clutter_per_scan=1), targets=0, new_per_hour=0)
    P = np.diag([100.0, 25, 100, 25])
    inside, outside = t.add(0.0, [500, 0, 500, 0], P, 0.95), t.add(0.0, [5000, 0, 500, 0], P, 0.95)
    picture = t.scan(1.0, [])
    existence = dict(zip(picture.ids, picture.existence, strict=True))
    r = 0.95 * np.exp(-1 / 3600)
    assert existence[inside] == pytest.approx(r * 0.1 / (1 - r * 0.9), rel=1e-9)
    assert existence[outside] == pytest.approx(r, rel=1e-9)


def test_plots_of_a_turning_antenna_keep_their_own_times():
    rng = np.random.default_rng(3)
    n, period, sd = 30, 4.0, 50.0
    place, heading = rng.uniform(-6e4, 6e4, (n, 2)), rng.uniform(0, 2 * np.pi, n)
    velocity = 250 * np.column_stack([np.cos(heading), np.sin(heading)])
    area = (-1e5, 1e5, -1e5, 1e5)

    def seen_at(p, k):
        return period * k + period * (np.arctan2(p[:, 0], p[:, 1]) / (2 * np.pi) % 1)

    def error(own):
        draws = np.random.default_rng(4)
        t = jink.Tracker(imm(sd), jink.Radar(area=area, clutter_per_scan=40), targets=n, new_per_hour=10)
        apart = []
        for k in range(20):
            when = np.full(n, period * (k + 0.5))
            for _ in range(4):
                when = seen_at(place + velocity * when[:, None], k)
            plots = place + velocity * when[:, None] + sd * draws.normal(size=(n, 2))
            seen = draws.random(n) < 0.9
            false = draws.uniform(-1e5, 1e5, (40, 2))
            z, times = np.vstack([plots[seen], false]), np.r_[when[seen], seen_at(false, k)]
            picture = t.scan(period * (k + 0.5), z, times=times if own else None)
            sure = picture.confirmed
            truth = place + velocity * picture.times[sure][:, None, None]
            if k > 5:
                apart += list(np.linalg.norm(picture.positions[sure][:, None] - truth, axis=2).min(axis=1))
        return np.median(apart), len(apart) / (14 * n)

    (fine, held), (coarse, _) = error(True), error(False)
    # 50 m in two axes are 59 m in the median; half a scan's flight is up to 500 m
    assert fine < 60 < 150 < coarse and held > 0.95


@pytest.mark.parametrize("method", ["ekf", "converted"])
def test_a_radar_in_range_and_azimuth_finds_all_and_learns_its_clutter(method):
    rng = np.random.default_rng(0)
    n, reach, period = 6, 6e4, 4.0
    place, velocity = rng.uniform(-3.5e4, 3.5e4, (n, 2)), rng.normal(0, 120, (n, 2))
    sensor = jink.Polar(range_sd=50, azimuth_sd=1.5e-3, method=method)
    filter = jink.IMM([jink.ConstantVelocity(acceleration_psd=q) for q in (1.0, 20.0)], sensor, 0.95)
    t = jink.Tracker(filter, jink.Radar(reach=reach), targets=n, new_per_hour=10)
    held = 0
    for k in range(40):
        p = place + velocity * period * k
        z = np.column_stack([np.hypot(*p.T), np.arctan2(*p.T)]) + rng.normal(0, [50, 1.5e-3], (n, 2))
        z = z[(rng.random(n) < 0.9) & (z[:, 0] < reach)]
        m = rng.poisson(40)
        false = np.column_stack([reach * np.sqrt(rng.random(m)), rng.uniform(-np.pi, np.pi, m)])
        picture = t.scan(period * k, np.vstack([z, false]))
        inside = p[np.hypot(*p.T) < reach - 1000]
        apart = np.linalg.norm(picture.positions[picture.confirmed][:, None] - inside, axis=2)
        held += ((apart.min(axis=0, initial=np.inf) < 400).mean() if len(inside) else 1.0) * (k >= 10)
    assert held / 30 > 0.9 and picture.confirmed.sum() <= n
    assert t.clutter_per_scan["radar"] == pytest.approx(40, rel=0.15)


def test_heights_are_used_where_they_are_measured():
    rng = np.random.default_rng(1)
    filter = jink.IMM(
        [jink.ConstantVelocity(acceleration_psd=q) for q in (1.0, 20.0)], jink.Position(sd=[50, 50, 20], axes=3), 0.95
    )
    t = jink.Tracker(filter, jink.Radar(area=(0, 5e4, 0, 5e4), clutter_per_scan=30), targets=2, new_per_hour=10)
    for k in range(25):
        # one above the other
        at = np.array([[1e4 + 800.0 * k, 2e4, 3000.0], [1e4 + 800.0 * k, 2e4, 9000.0]])
        false = rng.uniform([0, 0, 0], [5e4, 5e4, 1.2e4], (30, 3))
        picture = t.scan(4.0 * k, np.vstack([at + rng.normal(0, [50, 50, 20], (2, 3)), false]))
    assert picture.confirmed.sum() == 2
    assert np.allclose(np.sort(picture.estimate["pz"][picture.confirmed]), [3000, 9000], atol=60)


def test_two_radars_with_a_bias_of_half_a_sigma_make_no_duplicates():
    north, south = (jink.Radar(area=(-6e4, 6e4, -6e4, 6e4), clutter_per_scan=20) for _ in range(2))
    extra = targets = 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        n = 20
        place, velocity = rng.uniform(-3e4, 3e4, (n, 2)), rng.normal(0, 80, (n, 2))
        models = [jink.ConstantVelocity(acceleration_psd=q) for q in (1.0, 20.0)]
        filter = jink.IMM(models, [jink.Position(sd=100.0)] * 2, jink.Sojourn([100.0, 40.0]))
        t = jink.Tracker(filter, {"north": north, "south": south}, targets=n, new_per_hour=20)
        for k in range(60):
            p = place + velocity * 2.0 * k
            plots = p + rng.normal(0, 100, (n, 2)) + (k % 2) * 50 / np.sqrt(2)
            z = np.vstack([plots[rng.random(n) < 0.9], rng.uniform(-6e4, 6e4, (rng.poisson(20), 2))])
            picture = t.scan(2.0 * k, z, ("north", "south")[k % 2])
            if k >= 15:
                extra, targets = extra + max(picture.confirmed.sum() - n, 0), targets + n
    assert extra / targets <= 0.03


def test_asynchronous_reports_make_no_track_miss():
    radars = {"radar": jink.Radar(clutter_per_scan=1, area=(0, 1e5, 0, 1e5)), "ads-b": jink.Radar(scanning=False)}
    filter = jink.IMM([jink.ConstantVelocity(acceleration_psd=1.0)] * 2, [jink.Position(sd=50.0)] * 2, 0.9)
    t = jink.Tracker(filter, radars, targets=2, new_per_hour=10)
    for k in range(10):
        t.scan(4.0 * k, [[1e4 + 400 * k, 2e4], [7e4, 2e4 + 400 * k]], "radar")
    before = t.scan(40.0, [[1.4e4, 2e4], [7e4, 2.4e4]], "radar")
    after = [t.scan(40.0 + 0.2 * k, [[1.4e4 + 20.0 * k, 2e4]], "ads-b") for k in range(1, 15)][-1]
    assert before.confirmed.sum() == after.confirmed.sum() == 2
    assert after.existence[after.confirmed].min() > 0.99


def test_a_late_scan_is_taken_as_if_it_had_come_in_time():
    sky = sky_called("sky-parallel")
    scans = sky.run(6, 3).scans[:40]
    plain, patient = tracker(sky), tracker(sky, history=4)
    for scan in scans:
        want = plain.scan(scan.time, scan.z)
    order = list(range(40))
    # some come one to four scans late
    for k in (3, 10, 11, 20, 30):
        order.insert(min(k + 1 + k % 4, 39), order.pop(k))
    assert order != sorted(order)
    for k in order:
        found = patient.scan(scans[k].time, scans[k].z)
    assert found.time == want.time and np.array_equal(found.ids, want.ids)
    assert np.array_equal(found.existence, want.existence) and np.array_equal(found.estimate.x, want.estimate.x)


def test_what_is_too_late_is_counted():
    sky = sky_called("sky-parallel")
    scans = sky.run(6, 3).scans[:20]
    t = tracker(sky, history=3)
    for scan in scans[1:]:
        before = t.scan(scan.time, scan.z)
    after = t.scan(scans[0].time, scans[0].z)
    assert after.report == {"late": len(scans[0].z)} and after.time == before.time
    assert np.array_equal(after.estimate.x, before.estimate.x)
    with pytest.raises(ValueError, match="history: expected a whole number"):
        tracker(sky, history=-1)
