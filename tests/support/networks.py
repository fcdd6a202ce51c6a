"""Networks and membership functions to test with."""

from __future__ import annotations

import itertools

import numpy as np

from jink.models.network import Network


def random_network(sizes, seed, gain=1.0):
    rng = np.random.default_rng(seed)
    weights = [gain * rng.normal(size=(o, i)) for i, o in itertools.pairwise(sizes)]
    return Network([w.tolist() for w in weights], [rng.normal(size=o).tolist() for o in sizes[1:]])


def membership_functions(kind, count, low, high):
    peaks = np.linspace(low, high, count)
    step = peaks[1] - peaks[0]
    if kind == "triangular":
        return [(p - step, p, p + 1.1 * step) for p in peaks]
    return [(p, 0.4 * step) if kind == "gaussian" else (p, 0.5 * step, 1.7) for p in peaks]
