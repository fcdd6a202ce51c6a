"""How far a filter's results move when its numbers change in the tenth digit: what rounding may be made into.

A far outlier or a network that weighs the modes makes some filters amplify every change, scan after scan. GPB2 moves
its covariance by 1e-4 there. Two ways to compute the same result then agree no better than this, however exact each is.
"""

from __future__ import annotations

import numpy as np
from adaptive_families import FAMILIES, Draw
from hypothesis import assume

CHANGE = 2.0**-34
DRAWS = 8


def largest(difference, scale):
    """What is known exactly, of sd 0 at 0, must not differ at all."""
    return np.max(np.abs(difference) / np.maximum(scale, 1e-150))


def differences(a, b, x=lambda x: x, P=lambda P: P, modes=None):
    """Of b from what x, P and modes make of a: largest of x over |x| + sd, of P over sd sd', of probabilities."""
    there = b.status > 0
    if not there.any():
        return np.zeros(3)
    sd = np.sqrt(np.einsum("kii->ki", b.P[there]))
    probability = a.mode_probability if modes is None else a.mode_probability[:, modes]
    return np.array(
        [
            largest(x(a.x)[there] - b.x[there], np.abs(b.x[there]) + sd),
            largest(P(a.P)[there] - b.P[there], sd[:, :, None] * sd[:, None, :]),
            largest((probability - b.mode_probability)[there], 1.0),
        ]
    )


def moved(family, draw, unit, t, z, smooth=False):
    """What a change of all measurements, variances, times and ratios in the tenth digit makes of the differences.

    Ten times the largest of eight draws, which do not meet the worst direction. An example where a decision changes
    tells nothing and is given up.
    """

    def run(draw, t, z, R):
        f = FAMILIES[family](draw, unit)
        return (f.smooth if smooth else f.filter)(t, z, covariance=R)

    R = np.tile(unit**2 * np.eye(2), (len(t), 1, 1))
    base, far = run(draw, t, z, R), np.zeros(3)
    for k in range(DRAWS):
        rng = np.random.default_rng(k)

        def changed(a, rng=rng):
            return np.asarray(a) * (1 + CHANGE * rng.choice([-1.0, 1.0], np.shape(a)))

        other = Draw(list(changed(draw.ratios)), draw.seed, draw.outliers, draw.two_points)
        est = run(other, t * (1 + CHANGE), changed(z), changed(R))
        assume(np.array_equal(est.status, base.status))
        far = np.maximum(far, differences(base, est))
    return 10 * far
