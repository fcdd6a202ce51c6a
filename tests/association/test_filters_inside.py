"""Every named filter inside a tracker: alone in a clear sky it is the filter; or it is refused with the reason."""

import copy

import numpy as np
import pytest

import jink
from jink.catalogue.purpose import Purpose
from jink.models.outliers import Outliers

REFUSED = {
    "aimm3": "beside its modes",
    "aimm5": "beside its modes",
    "gpb2": "pair of modes",
    "vsmm-ds": "set of modes",
    "vsmm-ad": "set of modes",
    "vsmm-ag": "set of modes",
    "input-estimation": "onset of manoeuvres",
    "variable-dimension": "set of modes",
    "anfis-kf": "learned aid",
    "nn-kf": "learned aid",
    "imm-corrected": "learned aid",
    "nnvsmm-modes": "network weighs",
}


def made(name):
    sensor = jink.Position(sd=50.0)
    purpose = Purpose(
        sensor=sensor,
        kind="fighter" if name == "imm-corrected" else "aircraft",
        sd=50.0,
        outliers=Outliers(),
        gap=60.0,
        interval=4.0,
    )
    return jink.FILTERS[name](purpose).filter


def flight():
    """Straight, a turn of 3°/s, straight; a plot is missed now and then."""
    rng = np.random.default_rng(5)
    time = 4.0 * np.arange(50)
    heading = np.radians(3.0) * np.clip(time - 80, 0, 40)
    step = 150 * 4.0 * np.column_stack([np.cos(heading), np.sin(heading)])
    z = 1e4 + np.cumsum(step, axis=0) + rng.normal(0, 50, (50, 2))
    z[[9, 23, 24, 31]] = np.nan
    return time, z


@pytest.mark.parametrize("name", jink.FILTERS)
def test_alone_in_a_clear_sky_a_track_is_the_filter(name):
    filter = made(name)
    radar = jink.Radar(detection=0.9, clutter_per_scan=1e-9, area=(-1e9, 1e9, -1e9, 1e9), learn_clutter=False)
    try:
        tracker = jink.Tracker(filter, radar, targets=1, new_per_hour=1e-9, stay=1e12, report=0.0)
    except ValueError as error:
        assert name in REFUSED and REFUSED[name] in str(error)
        return
    assert name not in REFUSED
    # after missed scans in a turn some filters are outside of the usual gate
    tracker.rules.gate = 1e4
    tracker.reset()
    alone = copy.copy(filter)
    alone.engine = tracker._engine
    time, z = flight()
    want = alone.filter(time, z)
    for k in range(50):
        plots = z[k : k + 1] if np.isfinite(z[k]).all() else np.zeros((0, 2))
        picture = tracker.scan(time[k], plots)
        at = int(np.argmax(picture.existence))
        # that a plot is nobody's remains possible, of a millionth at most in such a large and empty sky
        assert np.allclose(picture.estimate.x[at], want.x[k], rtol=1e-5, atol=1e-3), k
        sd = np.sqrt(np.diag(want.P[k]))
        assert np.allclose(picture.estimate.P[at] / np.outer(sd, sd), want.P[k] / np.outer(sd, sd), atol=1e-5), k
        assert np.allclose(picture.estimate.mode_probability[at], want.mode_probability[k], atol=1e-5), k
