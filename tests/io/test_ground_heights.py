"""Heights on the ground: they lie between those that were reported last and next of the same target."""

import numpy as np

from jink.io.quality import FAR_FROM_GROUND, GROUND_SD, SINK, on_the_ground


def _slowly(altitude, ground, codes, seconds):
    """The same row by row."""
    filled, sd = altitude.copy(), np.full(altitude.size, np.nan)
    order = sorted(range(altitude.size), key=lambda i: (codes[i], seconds[i], i))
    for at, row in enumerate(order):
        if not (ground[row] and np.isnan(altitude[row])):
            continue
        before = [i for i in order[:at] if codes[i] == codes[row] and not np.isnan(altitude[i])][-1:]
        after = [i for i in order[at:] if codes[i] == codes[row] and not np.isnan(altitude[i])][:1]
        if not before and not after:
            continue
        first, last = before or after, after or before
        span = order[order.index(before[0]) if before else 0 : order.index(after[0]) if after else len(order)]
        silent = [seconds[i] for i in span if codes[i] == codes[row] and ground[i] and np.isnan(altitude[i])]
        low, high = altitude[first[0]], altitude[last[0]]
        if abs(high - low) > FAR_FROM_GROUND:
            low = high = min(low, high)
        share = 1.0 if not before else 0.0 if not after else 0.5
        if before and after and seconds[after[0]] > seconds[before[0]]:
            share = (seconds[row] - seconds[before[0]]) / (seconds[after[0]] - seconds[before[0]])
        filled[row] = (1.0 - share) * low + share * high
        quiet = (1.0 - share) * (min(silent) - seconds[before[0]]) if before else 0.0
        quiet += share * (seconds[after[0]] - max(silent)) if after else 0.0
        sd[row] = min(GROUND_SD + SINK * quiet, FAR_FROM_GROUND)
    return filled, sd


def test_heights_on_the_ground_are_those_found_row_by_row():
    rng = np.random.default_rng(5)
    for _ in range(200):
        n = int(rng.integers(1, 40))
        codes, seconds = rng.integers(0, 3, n), rng.permutation(n) * 1.5
        altitude = np.where(rng.random(n) < rng.random(), np.nan, rng.uniform(0.0, 300.0, n))
        ground = rng.random(n) < rng.random()
        for one, other in zip(
            on_the_ground(altitude, ground, codes, seconds), _slowly(altitude, ground, codes, seconds), strict=True
        ):
            np.testing.assert_allclose(one, other, rtol=1e-12)
