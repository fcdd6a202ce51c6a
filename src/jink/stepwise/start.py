"""The start of tracks in the stepwise filters, as in the engine: one position, or two; or a given prior."""

from collections.abc import Sequence

import numpy as np

from .._engine import native
from .functions import Array
from .modes import Mode
from .sensors import Fix
from .states import Outcome, States

# a second position contradicts the first where it is so many sds of the speed away; so often in a row, it is believed
FARTHEST_SDS, CONTRADICTIONS = 5.0, 2


class Start:
    """Starts tracks of these modes. velocity_variance holds for a track started from one point."""

    def __init__(
        self, modes: Sequence[Mode], probability: Array, axes: int, start: native.Start, velocity_variance: float
    ) -> None:
        self.modes, self.probability = modes, probability
        self.one_point, self.bounded = start == native.Start.one_point, start == native.Start.bounded_two_point
        self.velocity_variance = velocity_variance
        self.places = [{kind: self._places(mode, kind, axes) for kind in "pva"} for mode in modes]

    @staticmethod
    def _places(mode: Mode, kind: str, axes: int) -> list[tuple[int, int]]:
        """(axis, place in the state) of the positions, velocities or accelerations that a mode has."""
        at = {name: k for k, name in enumerate(mode.components)}
        return [(a, at[f"{kind}{axis}"]) for a, axis in enumerate("xyz"[:axes]) if f"{kind}{axis}" in at]

    def from_prior(self, s: States, rows: Array, x: Array, P: Array, time: Array, components: Sequence[str]) -> None:
        """From means and covariances in the reported components; a NaN time is that of the next scan."""
        for j, mode in enumerate(self.modes):
            at = [components.index(name) for name in mode.components]
            s.x[j][rows], s.P[j][rows] = x[:, at], P[:, at][:, :, at]
        s.started[rows] = s.running[rows] = True
        s.time[rows] = s.last_accepted[rows] = time

    def begin(self, s: States, fix: Fix, out: Outcome) -> None:
        """Tracks without a state start from one position; the second completes a two-point start."""
        fresh = fix.position & (~s.started | out.restarted)
        second = fix.position & s.started & ~s.running & ~out.restarted
        given_up = self._contradicted(s, fix, second) if self.bounded else np.zeros_like(second)
        tries = s.rejections + 1.0
        fresh, second = fresh | given_up, second & ~given_up
        if second.any():
            self._complete(s, fix, np.flatnonzero(second & (s.time > s.first_time)))
        if fresh.any():
            rows = np.flatnonzero(fresh)
            self._start(s, fix.take(rows), rows)
            s.running[rows] = self.one_point | fix.velocity[rows] | out.restarted[rows]
        out.initialised = fresh | (second & s.running)
        out.restarted = out.restarted & fresh
        out.log_likelihood = np.where(out.scored | out.restarted, out.log_likelihood, 0.0)
        out.scored = out.scored & ~fresh
        s.started = s.started | fresh
        s.rejections = np.where(given_up, tries, np.where(fresh | (second & s.running), 0.0, s.rejections))
        s.surprise, s.surprise_dof = np.where(fresh, 0.0, s.surprise), np.where(fresh, 0.0, s.surprise_dof)
        s.last_accepted = np.where(fresh | second, s.time, s.last_accepted)

    def _start(self, s: States, fix: Fix, rows: Array) -> None:
        """From one position: no velocity unless it was measured, each further component from its prior."""
        spread = self.velocity_variance * np.eye(fix.P.shape[-1])
        V = np.where(fix.velocity[:, None, None], fix.V, spread)
        v = np.where(fix.velocity[:, None], fix.v, 0.0)
        for j, (mode, places) in enumerate(zip(self.modes, self.places, strict=True)):
            x, P = (
                np.zeros((len(rows), len(mode.components))),
                np.tile(np.diag(mode.prior), (len(rows), 1, 1)),
            )
            for mean, C, of in ((fix.p, fix.P, places["p"]), (v, V, places["v"])):
                for a, r in of:
                    x[:, r] = mean[:, a]
                    for b, q in of:
                        P[:, r, q] = C[:, a, b]
            s.x[j][rows], s.P[j][rows] = x, P
        s.probability[rows] = self.probability
        s.first[rows], s.first_P[rows], s.first_time[rows] = fix.p, fix.P, s.time[rows]

    def _contradicted(self, s: States, fix: Fix, second: Array) -> Array:
        """Where a target of this speed cannot have come from the first position to the second."""
        step = s.time - s.first_time
        spread = np.einsum("baa->ba", fix.P + s.first_P) + (self.velocity_variance * step**2)[:, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            far = ((fix.p - s.first) ** 2 / spread).sum(axis=1) > FARTHEST_SDS**2
        return second & (step > 0) & far & (s.rejections < CONTRADICTIONS)

    def _slow_down(self, x: Array, P: Array, places: list[tuple[int, int]], which: Array) -> None:
        """Conditions velocities on N(0, velocity_variance), in place."""
        for _, v in places:
            column = P[:, :, v] * which[:, None]
            over = 1.0 / (P[:, v, v] + self.velocity_variance)
            kept = np.where(which, self.velocity_variance * over, 1.0)
            others = np.arange(P.shape[1]) != v
            x -= others * column * (over * x[:, v])[:, None]
            P -= others[:, None] * others * column[:, :, None] * column[:, None, :] * over[:, None, None]
            x[:, v] *= kept
            # by what remains of it, without cancellation
            P[:, v, :] *= np.where(others, kept[:, None], 1.0)
            P[:, :, v] *= kept[:, None]

    def _complete(self, s: States, fix: Fix, rows: Array) -> None:
        """Two-point differencing: v = (z₂ − z₁)/T, with acceleration of prior variance over the step."""
        if not len(rows):
            return
        fix = fix.take(rows)
        first, first_P, first_time = s.first[rows], s.first_P[rows], s.first_time[rows]
        step = s.time[rows] - first_time
        over = 1.0 / step
        self._start(s, fix, rows)
        s.first_time[rows] = first_time
        for j, (mode, places) in enumerate(zip(self.modes, self.places, strict=True)):
            x, P = s.x[j][rows], s.P[j][rows]
            accelerations = dict(places["a"])
            for a, v in places["v"]:
                x[:, v] = (fix.p[:, a] - first[:, a]) * over
                for b, p in places["p"]:
                    P[:, v, p] = P[:, p, v] = fix.P[:, a, b] * over
                for b, w in places["v"]:
                    P[:, v, w] = (fix.P[:, a, b] + first_P[:, a, b]) * over * over
                if a in accelerations:
                    c = accelerations[a]
                    P[:, v, v] += 0.25 * step * step * mode.prior[c]
                    P[:, c, v] = P[:, v, c] = 0.5 * step * mode.prior[c]
            if self.bounded:
                self._slow_down(x, P, places["v"], s.rejections[rows] < CONTRADICTIONS)
            s.x[j][rows], s.P[j][rows] = x, P
        s.running[rows] = True


def check_priors(modes: Sequence[Mode], starts: bool) -> None:
    """Every component that cannot come from elsewhere has a prior variance. Errors: ValueError naming it."""
    for mode in modes:
        for name, variance in zip(mode.components, mode.prior, strict=True):
            measured = name[0] in "pv" and name[1:] in ("x", "y", "z")
            lacking = [m.owner for m in modes if name not in m.components]
            if np.isnan(variance) and (lacking or (starts and not measured)):
                why = f"{lacking[0]} does not have it" if lacking else "no measurement gives it at the start of a track"
                raise ValueError(f"{mode.owner}.prior_variance: expected a variance for {name!r}, because {why}")
