"""Whole skies: what they say of themselves is what they are."""

import numpy as np
import pytest

from jink.scenarios.skies import SKIES, sky_called
from jink.scenarios.sky_paths import turned

SMALL = [name for name in SKIES if "000" not in name]


@pytest.mark.parametrize("name", SMALL)
def test_a_run_is_the_same_in_whatever_company(name):
    sky = sky_called(name)
    alone, among = sky.run(2, 5), list(sky.runs(3, 5))[2]
    for a, b in zip(alone.scans, among.scans, strict=True):
        assert np.array_equal(a.z, b.z) and np.array_equal(a.origin, b.origin)
    assert not np.array_equal(alone.scans[0].z[:1], sky.run(1, 5).scans[0].z[:1])


@pytest.mark.parametrize("name", SMALL)
def test_detection_noise_and_clutter_are_as_declared(name):
    sky = sky_called(name)
    seen = targets = false = scans = 0
    error = []
    for run in sky.runs(1 if sky.targets > 10 else 25, 7):
        for scan, truth in zip(run.scans, run.truth, strict=True):
            place = {i: p for i, p in zip(truth.ids, truth.points, strict=True)}
            mine = scan.origin >= 0
            error += [z - place[i] for z, i in zip(scan.z[mine], scan.origin[mine], strict=True)]
            seen, targets = seen + mine.sum(), targets + len(truth.ids)
            false, scans = false + (~mine).sum(), scans + 1
    # four standard errors
    assert abs(seen / targets - sky.detection) < 4 * np.sqrt(sky.detection * (1 - sky.detection) / targets)
    assert np.std(error) == pytest.approx(sky.sd, rel=4 / np.sqrt(4 * len(error)))
    expected, spread = (sky.clutter * sky.targets, 2.87**2 * 2) if sky.around else (sky.clutter, sky.clutter)
    assert abs(false / scans - expected) < 4 * np.sqrt(spread / scans)


def test_turns_keep_speed_and_meet_after_a_circle():
    x = np.array([[0.0, 100, 50, 20], [5, -3, 8, 200]])
    rate = np.radians([3.0, -2.0])
    around = turned(x, rate, 1.0)
    assert np.allclose(np.hypot(around[:, 1], around[:, 3]), np.hypot(x[:, 1], x[:, 3]), rtol=1e-12)
    for row in range(2):
        whole = turned(x[row : row + 1], rate[row], 2 * np.pi / abs(rate[row]))
        assert np.allclose(whole, x[row], atol=1e-8)
    assert np.allclose(turned(x, 0.0, 2.0)[:, [0, 2]], x[:, [0, 2]] + 2 * x[:, [1, 3]])


def test_aircraft_side_by_side_come_as_near_as_the_name_says():
    for name, distance in (("sky-parallel-50", 50), ("sky-parallel", 100), ("sky-parallel-200", 200)):
        run = sky_called(name).run(0)
        apart = np.array([np.linalg.norm(t.points[0] - t.points[1]) for t in run.truth])
        assert apart.min() == pytest.approx(distance) and (apart < distance + 0.01).sum() >= 25
        assert (np.diff(np.array([t.points[0, 0] for t in run.truth])) > 0).all()


def test_an_unknown_sky_is_refused_with_the_nearest():
    with pytest.raises(ValueError, match="sky-dense"):
        sky_called("sky-dence")
