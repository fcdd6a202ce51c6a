"""Sparse assignment, marginals and clusters against dense textbook versions."""

import numpy as np
import pytest
from oracle.association import enumerated, propagated
from scipy.optimize import linear_sum_assignment

from jink._engine import native


def sparse(weights):
    """CSR arrays of the entries that are not zero."""
    begin = np.concatenate([[0], np.cumsum((weights != 0).sum(axis=1))]).astype(np.int64)
    return begin, np.nonzero(weights)[1].astype(np.int64), np.ascontiguousarray(weights[weights != 0]), weights.shape[1]


def drawn(rng, rows, columns, share=0.6):
    psi = np.exp(rng.normal(0, 2.5, (rows, columns)))
    return np.where(rng.random(psi.shape) < share, psi, 0.0)


def test_beliefs_are_the_textbook_s():
    rng = np.random.default_rng(1)
    for _ in range(60):
        psi = drawn(rng, *rng.integers(1, 7, 2))
        hit, miss, lone, _ = native.marginals(*sparse(psi), tolerance=0.0, sweeps=150)
        want = propagated(psi, 0.0, 150)
        assert np.allclose(hit, want[0][psi != 0], rtol=1e-9, atol=1e-12)
        assert np.allclose(miss, want[1], rtol=1e-9) and np.allclose(lone, want[2], rtol=1e-9)


def test_the_sum_over_all_assignments_is_exact_where_plots_are_shared_along_a_tree():
    """A row with every plot, and rows with one plot each that no other of these has: a tree."""
    rng = np.random.default_rng(8)
    psi = np.zeros((4, 3))
    psi[0] = rng.lognormal(0, 3, 3)
    psi[[1, 2, 3], [0, 1, 2]] = rng.lognormal(0, 3, 3)
    # one row alone, and a weight that outweighs all others
    for each in (psi, psi[:1], np.array([[1e30]])):
        want = np.log(total(each))
        assert native.log_total(*sparse(each)) == pytest.approx(want, rel=1e-9)


def total(psi):
    """Σ over assignments of Π psi, row by row over the plots that are left."""

    def rest(i, left):
        if i == len(psi):
            return 1.0
        return rest(i + 1, left) + sum(psi[i, j] * rest(i + 1, left - {j}) for j in left if psi[i, j])

    return rest(0, frozenset(range(psi.shape[1])))


def test_the_sum_over_all_assignments_is_near_where_plots_are_shared_in_circles():
    """Bethe's sum is at most the true one (Gurvits 2011), and at least 2^(−n/2) of it (Anari & Rezaei 2019)."""
    rng = np.random.default_rng(9)
    for _ in range(20):
        psi = rng.lognormal(0, 2, (2, 2))
        off = native.log_total(*sparse(psi)) - np.log(total(psi))
        assert -np.log(2) <= off <= 1e-3


def test_exact_marginals_are_those_of_all_assignments():
    rng = np.random.default_rng(2)
    for _ in range(60):
        psi = drawn(rng, *rng.integers(1, 6, 2))
        hit, miss, lone, sweeps = native.marginals(*sparse(psi), exactly=True)
        want = enumerated(psi)
        assert sweeps == 0
        assert np.allclose(hit, want[0][psi != 0], rtol=1e-9, atol=1e-12)
        assert np.allclose(miss, want[1], rtol=1e-9, atol=1e-12) and np.allclose(lone, want[2], rtol=1e-9, atol=1e-12)


def test_beliefs_are_exact_where_plots_are_shared_along_a_tree():
    psi = np.array([[3.0, 0.5, 0.0], [0.0, 2.0, 40.0]])
    hit, miss, lone, _ = native.marginals(*sparse(psi), tolerance=1e-14)
    want = enumerated(psi)
    assert np.allclose(hit, want[0][psi != 0], rtol=1e-9) and np.allclose(miss, want[1], rtol=1e-9)
    assert np.allclose(lone, want[2], rtol=1e-9)


def test_a_weight_that_outweighs_all_others_does_no_harm():
    psi = np.array([[1e17, 2.0], [1e17, 3.0]])
    hit, miss, _, _ = native.marginals(*sparse(psi), tolerance=1e-12, sweeps=2000)
    want = propagated(psi, 1e-12, 2000)
    assert np.allclose(hit, want[0].ravel(), rtol=1e-9) and np.all(np.asarray(miss) > 0)


@pytest.mark.parametrize("share", [0.15, 0.5, 1.0])
def test_the_assignment_is_optimal(share):
    rng = np.random.default_rng(3)
    for _ in range(80):
        n, m = rng.integers(1, 15, 2)
        cost = rng.normal(-0.3, 1.0, (n, m))
        cost[rng.random(cost.shape) > share] = 0.0
        found = np.asarray(native.assign(*sparse(cost)))
        taken = found[found >= 0]
        assert len(set(taken)) == len(taken)
        total = sum(cost[i, j] for i, j in enumerate(found) if j >= 0)
        wide = np.hstack([np.minimum(cost, 0.0), np.zeros((n, n))])
        rows, columns = linear_sum_assignment(wide)
        assert total == pytest.approx(wide[rows, columns].sum(), rel=1e-9, abs=1e-12)


def test_ties_and_rounding_do_not_lead_the_assignment_in_circles():
    rng = np.random.default_rng(4)
    # distances to a grid, in which many are equal up to rounding
    points = rng.integers(0, 12, (300, 2)) * 0.1
    d = ((points[:, None] - points[None] - 0.05) ** 2).sum(axis=2) - 0.3
    cost = np.where(d < 0, d, 0.0)
    found = np.asarray(native.assign(*sparse(cost)))
    total = sum(cost[i, j] for i, j in enumerate(found) if j >= 0)
    rows, columns = linear_sum_assignment(cost)
    assert total == pytest.approx(cost[rows, columns].sum(), rel=1e-9)


def test_clusters_are_the_connected_parts():
    from scipy.sparse.csgraph import connected_components

    rng = np.random.default_rng(5)
    weights = (rng.random((60, 70)) < 0.012).astype(float)
    begin, plot, _, m = sparse(weights)
    found = np.asarray(native.cluster(begin, plot, m))
    whole = np.block([[np.zeros((60, 60)), weights], [weights.T, np.zeros((70, 70))]])
    _, part = connected_components(whole, directed=False)
    used = weights.any(axis=1)
    assert (found[~used] == -1).all() and (found[used] >= 0).all()
    same = found[used][:, None] == found[used][None]
    assert np.array_equal(same, part[:60][used][:, None] == part[:60][used][None])
    assert len(set(found[used])) > 3
