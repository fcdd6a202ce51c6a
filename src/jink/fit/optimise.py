"""The search for the parameters: L-BFGS-B with exact gradients, from several starts, on ever more of the tracks."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..catalogue.tuning import lowest
from ..checks import Array
from ..frozen import frozen
from ..models.tracks import Tracks
from .gradient import differentiable
from .objectives import NotFinite, Objective
from .parameters import Parameters

WEAK = 3.0  # sd of the prior on every u: they stay within a factor of some hundreds of where they started
FARTHEST = 12.0  # and never leave this
SMALLEST, GROWTH = 6_000, 4  # rows of the first batch of tracks, and how it grows
SHORT, LONG = 20, 200  # steps of a descent from each start, and from the best of them
SCATTER = 1.0  # sd of the other starts, in u
LOOSE, CLOSE = 0.05, 0.002  # of the total log-likelihood: a step that gains less ends a descent, the last one


@dataclass
class State:
    """Where a search stands: what a checkpoint keeps.

    stage: batches done; begin: where the stage under way began; told: what this stage's evaluations gave, value and
    slope each. A search that is taken up goes the same way again from ``begin``, without evaluating what was told, and
    on from there.
    """

    stage: int = 0
    begin: list[float] = field(default_factory=list)
    told: list[list[float]] = field(default_factory=list)
    u: list[float] = field(default_factory=list)
    value: float = np.inf  # the least of this stage, the prior in it
    evaluations: int = 0
    seconds: float = 0.0


@frozen
class Found:
    """u (P,); the figure there on all training tracks, prior left out; was the search cut short, and by Ctrl-C?

    stumbled: where the figure or a derivative was no number on the way, the first of them in words and how many.
    """

    u: Array
    value: float
    evaluations: int
    partial: bool
    seconds: float
    interrupted: bool = False
    stumbled: tuple[str, int] = ("", 0)


class OutOfTime(Exception):
    """The budget is used up."""


@dataclass
class Search:
    """One fit. keep(state) is called now and then, report(words, done, total) more often."""

    parameters: Parameters
    objective: Objective
    tracks: Tracks
    starts: int = 3
    seed: int = 0
    deadline: float = np.inf
    state: State = field(default_factory=State)
    keep: Callable[[State], None] | None = None
    report: Callable[[str, int, int], None] | None = None
    stumbled: tuple[str, int] = ("", 0)
    _place: int = 0  # of the next evaluation among those of this stage

    def run(self) -> Found:
        """Search until it is done, the deadline has passed or Ctrl-C; the best so far is kept.

        Errors: NotFinite if the figure is no number where the search begins.
        """
        began, before = clock.perf_counter(), self.state.seconds
        batches = list(self.batches())
        partial = interrupted = False
        try:
            for stage in range(self.state.stage, len(batches)):
                self._stage(batches[stage], stage, len(batches))
                self.state.stage, self.state.begin, self.state.told = stage + 1, list(self.state.u), []
                self.state.seconds = before + clock.perf_counter() - began
                self._kept(force=True)
        except OutOfTime:
            partial = True
        except KeyboardInterrupt:
            partial = interrupted = True
        u = np.array(self.state.u if self.state.u else self.parameters.start)
        value = self.objective.value(self.parameters.filter(u), self.tracks)
        seconds = before + clock.perf_counter() - began
        return Found(u, value, self.state.evaluations, partial, seconds, interrupted, self.stumbled)

    def batches(self) -> Any:
        """Ever more owners' tracks, in one random order; the last batch is all."""
        owner = np.arange(len(self.tracks)) if self.tracks.owner is None else self.tracks.owner
        names = np.random.default_rng(self.seed).permutation(np.unique(owner))
        rank = np.empty(len(names), int)
        rank[np.searchsorted(np.unique(owner), names)] = np.arange(len(names))
        order = rank[np.searchsorted(np.unique(owner), owner)]
        length, size = np.diff(self.tracks.offsets), SMALLEST
        rows = np.cumsum(np.bincount(order, weights=length))
        while size < self.tracks.rows / 2:
            yield self.tracks.some(np.flatnonzero(order <= np.searchsorted(rows, size)))
            size *= GROWTH
        yield self.tracks

    def _stage(self, tracks: Tracks, stage: int, stages: int) -> None:
        words = f"{tracks.rows:,} rows"
        begin = np.array(self.state.begin) if self.state.begin else self.parameters.start
        self.state.value, self._place = np.inf, 0
        if stage > 0 or not differentiable(self.parameters.filter(self.parameters.start)):
            self._descend(begin, tracks, words, LONG, stage, stages)
            return
        rng = np.random.default_rng(self.seed)
        self._descend(begin, tracks, words, SHORT, stage, stages)
        for _ in range(self.starts - 1):
            other = self.parameters.start + SCATTER * rng.standard_normal(len(begin))
            self._descend(other, tracks, words, SHORT, stage, stages)
        self._descend(np.array(self.state.u), tracks, words, LONG, stage, stages)

    def _descend(self, begin: Array, tracks: Tracks, words: str, steps: int, stage: int, stages: int) -> None:
        if not differentiable(self.parameters.filter(begin)):
            self._evolve(begin, tracks, words, stage, stages)
            return
        from scipy.optimize import minimize

        start = self.parameters.start
        last = stage + 1 == stages and steps == LONG
        rows = max(float(np.isfinite(tracks.z).any(axis=1).sum()), 1.0)
        close = (CLOSE if last else LOOSE) / rows
        first: list[float] = []  # the figure where it begins: what is minimised starts from 0, so that ftol is absolute

        def figure(u: Array) -> tuple[float, Array]:
            value, slope = self._evaluated(u, tracks, words, stage, stages)
            first.append(value)
            return value - first[0], slope

        minimize(
            figure,
            begin,
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(start - FARTHEST, start + FARTHEST, strict=True)),
            options={"maxiter": steps, "ftol": close, "gtol": 1e-6, "maxls": 20},
        )

    def _evolve(self, begin: Array, tracks: Tracks, words: str, stage: int, stages: int) -> None:
        """CMA-ES, for figures without a gradient; of one parameter golden section.

        Source: Hansen, The CMA Evolution Strategy: A Tutorial, 2016.
        """

        def figure(u: Any) -> float:
            return self._plain(np.asarray(u), tracks, words, stage, stages)

        if len(begin) == 1:
            lowest(lambda u: figure([u]), begin[0] - WEAK, begin[0] + WEAK)
            return
        import cma

        options = {"seed": self.seed + 1, "verbose": -9, "tolx": 1e-3, "maxfevals": 100 * len(begin)}
        strategy = cma.CMAEvolutionStrategy(begin, 0.5, options)
        while not strategy.stop():
            asked = strategy.ask()
            strategy.tell(asked, [figure(u) for u in asked])

    def _evaluated(self, u: Array, tracks: Tracks, words: str, stage: int, stages: int) -> tuple[float, Array]:
        def anew() -> list[float]:
            found = self.objective.evaluate(self.parameters, u, tracks)
            away = u - self.parameters.start
            value = found.value + 0.5 * float(away @ away) / (WEAK**2 * found.count)
            return [value, *(found.slope + away / (WEAK**2 * found.count))]

        value, *slope = self._told(u, anew, words, stage, stages)
        return (value, np.array(slope)) if slope else (self.state.value + 1e3, np.zeros(len(u)))

    def _plain(self, u: Array, tracks: Tracks, words: str, stage: int, stages: int) -> float:
        def anew() -> list[float]:
            away = u - self.parameters.start
            if np.abs(away).max() > FARTHEST:
                return [np.inf]
            value = self.objective.value(self.parameters.filter(u), tracks)
            return [value + 0.5 * float(away @ away) / (WEAK**2 * max(tracks.rows, 1))]

        value = self._told(u, anew, words, stage, stages)[0]
        return value if np.isfinite(value) else self.state.value + 1e3

    def _told(self, u: Array, anew: Callable[[], list[float]], words: str, stage: int, stages: int) -> list[float]:
        """What the figure is at u, as a search that was taken up was told before, or anew; [inf] where it is no
        number.
        """
        state, fresh = self.state, self._place >= len(self.state.told)
        if fresh:
            try:
                state.told.append(anew())
            except (NotFinite, ValueError) as error:
                if not np.isfinite(state.value):
                    raise
                self.stumbled = (self.stumbled[0] or str(error), self.stumbled[1] + 1)
                state.told.append([np.inf])
            state.evaluations += 1
        told = state.told[self._place]
        self._place += 1
        if told[0] < state.value:
            state.value, state.u = told[0], [float(x) for x in u]
        if fresh:
            self._heard(words, stage, stages)
        return told

    def _heard(self, words: str, stage: int, stages: int) -> None:
        self._kept()
        if self.report:
            self.report(f"{words}, step {self.state.evaluations}", stage, stages)
        if clock.monotonic() > self.deadline:
            raise OutOfTime

    _last_kept: float = 0.0

    def _kept(self, force: bool = False) -> None:
        if self.keep and (force or clock.monotonic() - self._last_kept > 2.0):
            self._last_kept = clock.monotonic()
            self.keep(self.state)
