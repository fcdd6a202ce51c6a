"""The offset between two radars, from targets that both have told the code of."""

from __future__ import annotations

import numpy as np
import pytest

import jink

SD = 50.0


def seen(targets=40, scans=15, offset=(25.0, -40.0), seed=1, noise=SD):
    """Straight flights; one radar at 0, 4, … s, the other at 2, 6, … s with an offset."""
    rng = np.random.default_rng(seed)
    start, velocity = rng.uniform(0, 1e5, (targets, 2)), rng.normal(0, 150, (targets, 2))
    out = []
    for first, shift in ((0.0, np.zeros(2)), (2.0, np.array(offset))):
        time = np.repeat(first + 4.0 * np.arange(scans), targets)
        code = np.tile(np.arange(targets), scans)
        z = start[code] + velocity[code] * time[:, None] + shift + noise * rng.standard_normal((len(time), 2))
        keep = rng.random(len(time)) < 0.9
        out += [time[keep], z[keep], code[keep]]
    return out


def test_straight_flights_without_noise_tell_the_offset_exactly():
    found = jink.radar_bias(*seen(noise=0.0))
    np.testing.assert_allclose(found.offset, [25.0, -40.0], atol=1e-7)


def test_the_offset_is_found_within_its_standard_error():
    errors = np.array([(f := jink.radar_bias(*seen(seed=s))).offset - (25.0, -40.0) for s in range(40)])
    claimed = jink.radar_bias(*seen(seed=0)).se
    assert f.pairs > 300
    assert (np.abs(errors) < 0.1 * SD * 2).all()
    # the spread over 80 figures is known to 8 %; three of those
    assert np.sqrt((errors**2).mean()) == pytest.approx(float(claimed.mean()), rel=0.25)


def test_garbled_codes_and_silent_plots_do_not_count():
    time, z, code, t2, z2, c2 = seen()
    garbled = c2.copy()
    garbled[::25] = (garbled[::25] + 7) % 40
    clean = jink.radar_bias(time, z, code, t2, z2, np.where(garbled == c2, c2, -1))
    found = jink.radar_bias(time, z, code, t2, z2, garbled)
    np.testing.assert_allclose(found.offset, clean.offset, atol=2.0)


def test_the_order_of_plots_does_not_matter():
    time, z, code, t2, z2, c2 = seen()
    k = np.random.default_rng(0).permutation(len(t2))
    np.testing.assert_array_equal(
        jink.radar_bias(time, z, code, t2, z2, c2).offset, jink.radar_bias(time, z, code, t2[k], z2[k], c2[k]).offset
    )


def test_what_cannot_be_told_is_refused():
    time, z, code, t2, z2, c2 = seen()
    with pytest.raises(ValueError, match="at least two targets"):
        jink.radar_bias(time, z, code, t2, z2, c2 + 1000)
    with pytest.raises(ValueError, match="whole numbers"):
        jink.radar_bias(time, z, code * 1.0, t2, z2, c2)
