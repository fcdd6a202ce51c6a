"""GOSPA, OSPA and OSPA⁽²⁾ against all assignments tried one by one."""

from itertools import permutations

import numpy as np
import pytest

from jink.metrics.sets import gospa, ospa, ospa2
from jink.metrics.skies import Picture, sky_figures


def all_pairings(n, m):
    """Every partial assignment of n rows to m columns, as lists of pairs."""
    places = list(range(m)) + [None] * n
    return {tuple(sorted((i, j) for i, j in enumerate(p) if j is not None)) for p in permutations(places, n)}


def gospa_by_hand(x, y, c, p, alpha):
    """The definition: the smaller set is paired whole at min(d, c); the rest costs cᵖ/α each."""
    if len(x) > len(y):
        x, y = y, x
    d = np.minimum(np.linalg.norm(x[:, None] - y[None], axis=2), c) if len(x) else np.zeros((0, len(y)))
    least = min(sum(d[i, j] ** p for i, j in enumerate(q)) for q in permutations(range(len(y)), len(x)))
    return (least + c**p / alpha * (len(y) - len(x))) ** (1 / p)


@pytest.mark.parametrize("p, alpha", [(2, 2), (1, 2), (2, 1)])
def test_gospa_is_its_definition(p, alpha):
    rng = np.random.default_rng(3)
    for _ in range(60):
        n, m = rng.integers(0, 5, 2)
        x, y = rng.uniform(0, 10, (n, 2)), rng.uniform(0, 10, (m, 2))
        found = gospa(x, y, 4.0, p, alpha)
        assert found.value == pytest.approx(gospa_by_hand(x, y, 4.0, p, alpha), rel=1e-9, abs=1e-12)
        if alpha == 2:
            parts = found.localisation + found.missed + found.false
            assert found.value**p == pytest.approx(parts, rel=1e-9, abs=1e-12)


def test_ospa_is_its_definition():
    rng = np.random.default_rng(4)
    for _ in range(60):
        n, m = rng.integers(0, 5, 2)
        x, y = rng.uniform(0, 10, (n, 2)), rng.uniform(0, 10, (m, 2))
        most = max(n, m)
        # OSPA^p is GOSPA^p with alpha 1, divided by the larger size
        want = gospa_by_hand(x, y, 4.0, 2, 1) / np.sqrt(most) if most else 0.0
        assert ospa(x, y, 4.0, 2) == pytest.approx(want, rel=1e-9, abs=1e-12)


def test_ospa2_counts_an_exchange_of_identities():
    steps = np.arange(10.0)
    a, b = np.column_stack([steps, 0 * steps]), np.column_stack([steps, 0 * steps + 1])
    exchanged = [np.vstack([a[:5], b[5:]]), np.vstack([b[:5], a[5:]])]
    assert ospa2([a, b], [a, b], 5.0) == 0.0
    assert ospa2([a, b], exchanged, 5.0) == pytest.approx(0.5, rel=1e-12)
    half = a.copy()
    half[5:] = np.nan
    assert ospa2([a], [half], 5.0, q=2.0) == pytest.approx(np.sqrt(12.5), rel=1e-12)
    assert ospa2([a, b], [a], 5.0, p=1.0) == pytest.approx(2.5, rel=1e-12)


def test_many_points_agree_with_a_dense_solver():
    from scipy.optimize import linear_sum_assignment

    rng = np.random.default_rng(5)
    x, y = rng.uniform(0, 100, (120, 2)), rng.uniform(0, 100, (140, 2))
    d = np.minimum(np.linalg.norm(x[:, None] - y[None], axis=2), 20.0) ** 2
    i, j = linear_sum_assignment(d)
    want = np.sqrt(d[i, j].sum() + 200.0 * 20)
    assert gospa(x, y, 20.0).value == pytest.approx(want, rel=1e-9)


def test_an_exchange_is_two_switches_and_a_gap_is_none():
    def pictures(order, there=(0, 1)):
        points = np.array([[0.0, 0.0], [10.0, 0.0]])
        return Picture(np.array(order)[list(there)], points[list(there)])

    truth = [[pictures([0, 1])] * 4]
    exchanged = [[pictures([7, 8]), pictures([7, 8]), pictures([8, 7]), pictures([8, 7])]]
    figures = sky_figures(truth, exchanged, 3.0)
    assert figures.switches.value == 2 and figures.identities == 2 and figures.completeness == 1
    gap = [[pictures([7, 8]), pictures([7, 8], (0,)), pictures([7, 8]), pictures([7, 8])]]
    figures = sky_figures(truth, gap, 3.0)
    assert figures.switches.value == 0 and figures.completeness == 7 / 8 and figures.spurious == 0
    assert figures.gospa.value == pytest.approx(np.sqrt(4.5 / 4)) and figures.missed == figures.gospa.value


@pytest.mark.parametrize(
    "call, says",
    [
        (lambda: gospa([[0, 0]], [[0, 0]], -1.0), "c: expected"),
        (lambda: gospa([[0, 0]], [[0, 0]], 1.0, 0.5), "p: expected a number from 1"),
        (lambda: gospa([[0, 0]], [[0, 0]], 1.0, 2, 3), "alpha: expected"),
        (lambda: gospa([[0, np.nan]], [[0, 0]], 1.0), "truth: expected finite points"),
        (lambda: gospa([[0, 0]], [[0, 0, 0]], 1.0), "expected 2 axes"),
        (lambda: sky_figures([], [], 1.0), "at least one run"),
    ],
)
def test_what_makes_no_sense_is_refused(call, says):
    with pytest.raises(ValueError, match=says):
        call()
