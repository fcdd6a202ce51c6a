"""Many targets from plots without identity, as the textbook has it: dense arrays, one track after the other.

Marginals: Williams & Lau 2014 by loops over a dense matrix, and exactly by listing every assignment. The life cycle:
Williams 2015 (TOMB/P) with an IMM in each track, ownership and splitting as docs/many-targets.md has them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from scipy.optimize import linear_sum_assignment

ROUNDS = 200


def propagated(psi, tolerance=1e-4, rounds=ROUNDS):
    """p (n, m), p of no plot (n,), p of no track (m,) by belief propagation; 0 in psi is no edge."""
    n, m = psi.shape
    mu, nu = np.zeros((n, m)), np.ones((n, m))
    for _ in range(rounds):
        before = mu
        mu = np.zeros((n, m))
        for i in range(n):
            for j in np.flatnonzero(psi[i]):
                others = [k for k in range(m) if k != j]
                mu[i, j] = psi[i, j] / (1 + sum(psi[i, k] * nu[i, k] for k in others))
        if psi.any(axis=1).sum() == 1:
            break
        for j in range(m):
            for i in range(n):
                nu[i, j] = 1 / (1 + sum(mu[k, j] for k in range(n) if k != i))
        if (np.abs(mu - before) / (mu + 1e-3)).max() <= tolerance:
            break
    total = 1 + (psi * nu).sum(axis=1)
    return psi * nu / total[:, None], 1 / total, 1 / (1 + mu.sum(axis=0))


def enumerated(psi):
    """The same exactly: every assignment, one by one."""
    n, m = psi.shape
    p, none, weight = np.zeros((n, m)), np.zeros(n), 0.0
    lone = np.zeros(m)
    for choice in product(range(-1, m), repeat=n):
        used = [j for j in choice if j >= 0]
        if len(set(used)) < len(used):
            continue
        w = np.prod([psi[i, j] for i, j in enumerate(choice) if j >= 0])
        weight += w
        for i, j in enumerate(choice):
            if j >= 0:
                p[i, j] += w
            else:
                none[i] += w
        for j in set(range(m)) - set(used):
            lone[j] += w
    return p / weight, none / weight, lone / weight


@dataclass
class Bernoulli:
    """A track: modes' x (M, n), P (M, n, n), probabilities, existence and what its life needs."""

    id: int
    x: np.ndarray
    P: np.ndarray
    mu: np.ndarray
    r: float
    birth: float
    age: int = -1
    plots: int = 1
    share: float = 1.0
    near: int = 0
    confirmed: bool = False
    edges: dict = field(default_factory=dict)
    outside: bool = False  # of the sensor's field of view
    unseen: float = 0.0  # probability of no plot, if it exists
    score: float = 0.0  # log of what speaks for it, against its plots being false
    parent: int = -1  # id of the confirmed track whose next plot its first one could have been
    parting: float = 0.0  # the parent's score before that plot

    @property
    def mean(self):
        return self.mu @ self.x

    @property
    def covariance(self):
        d = self.x - self.mean
        return np.einsum("m,mij->ij", self.mu, self.P + np.einsum("mi,mj->mij", d, d))


@dataclass
class Textbook:
    """F, Q (M, n, n) over one scan, transition (M, M), H, R; densities per m² and scan."""

    F: np.ndarray
    Q: np.ndarray
    transition: np.ndarray
    start: np.ndarray
    H: np.ndarray
    R: np.ndarray
    speed_variance: float
    detection: float
    clutter: float
    undetected: float
    arrivals: float  # per m² and scan
    survival: float
    box: tuple
    leaving: float  # survival over a scan outside the box
    ownership: bool = True
    left: float = 0.0  # share of a marginal that stays where another track owns the plot
    abreast: float = np.inf  # squared distance of velocities from which tracks do not own plots against each other
    learning: bool = True  # of the clutter
    inherit: float = 2.0  # a branch takes its parent's id if its score is higher by so much
    handed: int = 0  # how often that has happened
    tracks: list = field(default_factory=list)
    following: int = 0
    scans: int = 0

    def scan(self, z):
        """One scan of plots (m, 2), in the engine's order."""
        if self.scans:
            self.undetected = self.survival * self.undetected + self.arrivals
        for t in self.tracks:
            self._predict(t)
            t.edges = self._edges(t, z)
            t.near = len(t.edges)
            t.unseen = 1 - self.detection if self._inside(t.x[0]) else 1.0
        hit, none, lone = self._marginals(z)
        parents = [self._parent(j) for j in range(len(z))]
        ended, twins = [], []
        for i, t in enumerate(list(self.tracks)):
            absent = t.r * t.unseen / (1 - t.r + t.r * t.unseen) * none[i]
            if t.plots == 1:
                ended += [t] * self._split(t, hit[i], absent, none[i], z, twins)
            else:
                t.score += _evidence(t, none[i], t.unseen, hit[i].sum())
                self._take_in(t, [(j, p) for j, p in enumerate(hit[i]) if p > 0], absent, z)
                t.share = hit[i].sum()
        self.tracks = [t for t in self.tracks if not any(t is e for e in ended)] + twins
        self._bear(z, lone, parents)
        self._judge()
        share = self.clutter / (self.clutter + self.detection * self.undetected)
        rate = max(0.05, 1 / (2 + self.scans))
        seen = min(lone.sum() * share, 4 * self.clutter * self.area + 10)
        if self.learning:
            self.clutter = max((1 - rate) * self.clutter + rate * seen / self.area, 1e-3 / self.area)
        self.undetected *= 1 - self.detection
        self.scans += 1

    @property
    def area(self):
        return (self.box[1] - self.box[0]) * (self.box[3] - self.box[2])

    def _inside(self, x):
        return self.box[0] <= x[0] <= self.box[1] and self.box[2] <= x[2] <= self.box[3]

    def _predict(self, t):
        prior = t.mu @ self.transition
        x, P = np.zeros_like(t.x), np.zeros_like(t.P)
        for j in range(len(prior)):
            w = self.transition[:, j] * t.mu / prior[j]
            mixed = w @ t.x
            spread = np.einsum("m,mij->ij", w, t.P + np.einsum("mi,mj->mij", t.x - mixed, t.x - mixed))
            x[j], P[j] = self.F[j] @ mixed, self.F[j] @ spread @ self.F[j].T + self.Q[j]
        t.x, t.P, t.mu = x, P, prior
        t.r *= self.survival * (self.leaving if t.outside else 1.0)

    def _edges(self, t, z):
        """Of each plot in some mode's gate, or likelier than a false one: likelihood of each mode, least d²."""
        found = {}
        ground = self.clutter + self.detection * self.undetected
        for j, plot in enumerate(z):
            d2, likelihood = np.zeros(len(t.mu)), np.zeros(len(t.mu))
            for m in range(len(t.mu)):
                S = self.H @ t.P[m] @ self.H.T + self.R
                e = plot - self.H @ t.x[m]
                d2[m] = e @ np.linalg.solve(S, e)
                likelihood[m] = np.exp(-0.5 * d2[m]) / np.sqrt(np.linalg.det(2 * np.pi * S))
            likely = self.detection * (t.mu @ likelihood) > (1 - self.detection) * ground
            if d2.min() < 16 or (t.r > 0.5 and likely):
                found[j] = (likelihood, d2.min())
        return found

    def _marginals(self, z):
        psi = np.zeros((len(self.tracks), len(z)))
        ground = self.clutter + self.detection * self.undetected
        for i, t in enumerate(self.tracks):
            for j, (likelihood, _) in t.edges.items():
                psi[i, j] = t.r * self.detection * (t.mu @ likelihood) / (1 - t.r + t.r * t.unseen) / ground
        hit, none, lone = np.zeros_like(psi), np.ones(len(psi)), np.ones(len(z))
        felt = psi.max(axis=1, initial=0) >= 1e-2
        for rows in _clusters(psi * felt[:, None]):
            p, nothing, free = propagated(psi[rows])
            hit[rows], none[rows] = p, nothing
            columns = psi[rows].any(axis=0)
            lone[columns] = free[columns]
        for i in np.flatnonzero(~felt):
            total = 1 + psi[i] @ lone
            hit[i], none[i] = psi[i] * lone / total, 1 / total
        if self.ownership:
            self._own(psi, hit, none)
        return hit, none, lone

    def _own(self, psi, hit, none):
        old = [i for i, t in enumerate(self.tracks) if t.r > 0.5]
        if len(old) < 2:
            return
        cost = np.where(psi[old] > 1, -np.log(np.maximum(psi[old], 1e-300)), 0.0)
        rows, columns = linear_sum_assignment(np.hstack([cost, np.zeros((len(old), len(old)))]))
        owner = {j: old[k] for k, j in zip(rows, columns, strict=True) if j < psi.shape[1] and cost[k, j] < 0}
        for i in old:
            for j, of in owner.items():
                if of != i and self._apart(self.tracks[i], self.tracks[of]) < self.abreast:
                    hit[i, j] *= self.left
            total = none[i] + hit[i].sum()
            hit[i], none[i] = hit[i] / total, none[i] / total

    def _apart(self, a, b):
        """Squared distance of two predicted velocities, by the means of the modes' covariances."""
        speed = np.ix_([1, 3], [1, 3])
        off = a.mean[[1, 3]] - b.mean[[1, 3]]
        P = sum(np.einsum("m,mij->ij", t.mu, t.P) for t in (a, b))[speed]
        return off @ np.linalg.solve(P, off)

    def _take_in(self, t, plots, absent, z):
        total = absent + sum(p for _, p in plots)
        branches = [(t.mu * absent / total, t.x, t.P)]
        for j, p in plots:
            likelihood, _ = t.edges[j]
            x, P = t.x.copy(), t.P.copy()
            for m in range(len(t.mu)):
                S = self.H @ t.P[m] @ self.H.T + self.R
                K = t.P[m] @ self.H.T @ np.linalg.inv(S)
                x[m] = t.x[m] + K @ (z[j] - self.H @ t.x[m])
                joseph = np.eye(len(K)) - K @ self.H
                P[m] = joseph @ t.P[m] @ joseph.T + K @ self.R @ K.T
            branches.append((p / total * t.mu * likelihood / (t.mu @ likelihood), x, P))
        weight = sum(w for w, _, _ in branches)
        mean = sum(w[:, None] * x for w, x, _ in branches) / weight[:, None]
        spread = (
            sum(w[:, None, None] * (P + np.einsum("mi,mj->mij", x - mean, x - mean)) for w, x, P in branches)
            / weight[:, None, None]
        )
        t.x, t.P, t.mu, t.r = mean, spread, weight, total

    def _split(self, t, hit, absent, nothing, z, twins):
        """True if the track ends here."""
        floor = 0.1 * self._birth()
        near = [j for j, (_, d2) in t.edges.items() if d2 < 6 and hit[j] > floor]
        near.sort(key=lambda j: -hit[j])
        waits = absent >= 0.1 or t.unseen == 1
        if not near:
            self._take_in(t, [], absent, z)
            t.share = 0.0
            return not waits
        branches = [*near, *([None] if waits else [])]
        if waits and absent > hit[near[0]]:
            branches = [None, *near]
        source = replace(t)
        for k, j in enumerate(branches):
            one = t if k == 0 else replace(source, id=self._next())
            seen = (source.unseen, 0.0) if j is None else (0.0, hit[j])
            one.score = source.score + _evidence(source, nothing, *seen)
            self._take_in(one, [] if j is None else [(j, 1.0)], absent if j is None else 0.0, z)
            one.r = absent if j is None else hit[j]
            one.share = 0.0 if j is None else 1.0
            if k:
                twins.append(one)
        return False

    def _birth(self):
        return self.detection * self.undetected / (self.clutter + self.detection * self.undetected)

    def _next(self):
        self.following += 1
        return self.following - 1

    def _parent(self, j):
        """Of a plot: the confirmed track that it speaks for most, its score, and what the plot would add to it."""
        best, most = (-1, 0.0, 0.0), -np.inf
        ground = self.clutter + self.detection * self.undetected
        for t in self.tracks:
            if t.confirmed and j in t.edges:
                gain = np.log(self.detection * (t.mu @ t.edges[j][0]) / ground)
                if gain > most:
                    best, most = (t.id, t.score, gain), gain
        return best

    def _bear(self, z, lone, parents):
        for plot, free, (parent, parting, gain) in zip(z, lone, parents, strict=True):
            r = free * self._birth()
            if not (r > 0.1 * self._birth()) or free <= 0.02:
                continue
            n, M = self.F.shape[1], len(self.F)
            x, P = np.zeros(n), np.zeros((n, n))
            x[[0, 2]] = plot
            P[np.ix_([0, 2], [0, 2])] = self.R
            P[1, 1] = P[3, 3] = self.speed_variance
            modes = np.tile(x, (M, 1)), np.tile(P, (M, 1, 1)), self.start.copy()
            of = {"score": parting + gain, "parent": parent, "parting": parting}
            self.tracks.append(Bernoulli(self._next(), *modes, r, r, **of))

    def _judge(self):
        kept = []
        for t in self.tracks:
            if t.age < 0:
                t.age = 0
            else:
                t.age += 1
                t.plots += t.share > 0.5
                crowded = t.r < 0.5 and t.age > 2 and t.near > 8
                if t.r < 0.1 * t.birth or crowded:
                    continue
            t.outside = not self._inside(t.mean)
            t.confirmed = not t.outside and t.r > (0.4 if t.confirmed else 0.8)
            kept.append(t)
        self.tracks = kept
        for heir in [t for t in kept if t.confirmed and t.parent >= 0]:
            elder = next((t for t in kept if t.id == heir.parent), None)
            heir.parent = -1
            if elder is not None and heir.score > elder.score + self.inherit:
                self._hand(elder, heir)

    def _hand(self, elder, heir):
        """The heir takes the elder's id; the elder is what it would be had it begun where they parted."""
        elder.id, heir.id = heir.id, elder.id
        elder.age, heir.age = heir.age, elder.age
        odds = heir.birth / (1 - heir.birth) * np.exp(elder.score - heir.parting)
        elder.r = min(elder.r, odds / (1 + odds))
        elder.confirmed = elder.confirmed and elder.r > 0.8
        self.handed += 1


def _evidence(t, none, unseen, hit):
    """log P(scan | the track is there) / P(scan | it is not)."""
    return np.log(unseen + hit * (1 - t.r + t.r * t.unseen) / (t.r * none))


def _clusters(psi):
    """Rows that share plots."""
    waiting = {i for i in range(len(psi)) if psi[i].any()}
    while waiting:
        found, front = set(), {min(waiting)}
        while front:
            found |= front
            columns = psi[sorted(front)].any(axis=0)
            front = {i for i in waiting - found if (psi[i] * columns).any()}
        waiting -= found
        yield sorted(found)
