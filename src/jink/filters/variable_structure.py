"""Variable-structure IMM: each scan runs only the modes that the last scan makes likely."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from .._engine import native
from ..checks import Array, items, positive, whole, with_attributes
from ..models.motion import AnyMotion, ConstantVelocity
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import Sojourn, Transition, transition_rule
from .bank import Bank
from .parts import Parts, adapts, native_mode, uniform
from .plain import COMMON

LARGEST = 64  # modes alive at once


class _VariableStructure(Bank):
    """What the three have in common: the modes, the graph, and the arguments that every filter has."""

    not_smoothed = "its set of modes changes from scan to scan; smooth a jink.IMM of its modes"

    def _declare(
        self,
        motions: Sequence[AnyMotion],
        sensor: Any,
        outliers: Outliers | None,
        initial: TwoPoint | OnePoint | Prior | None,
        coast: float | None,
    ) -> None:
        super()._declare(motions, sensor, outliers, initial, coast)
        for motion in self.motions:
            with_attributes("motions", motion, ("native",), "jink's motion models")
        if len(self.motions) < 2:
            raise ValueError(f"motions: expected at least two modes, got {len(self.motions)}")

    @property
    def _alike(self) -> bool:
        """Do the modes differ in numbers only? Then a few slots take on the numbers of those that are alive."""
        natives = [native_mode(m, self.axes) for m in self.motions]
        plain = not any(adapts(m) for m in self.motions)
        return plain and all(natives[0].alike(n) for n in natives)

    def _slots(self, alive: int) -> int:
        slots = alive if self._alike else len(self.motions)
        if slots > LARGEST:
            raise ValueError(f"motions: expected at most {LARGEST} alive at once, got {slots}")
        return slots

    def _placed(self, members: Sequence[int], slots: int) -> list[float]:
        """Which mode each slot starts as."""
        at = [-1.0] * slots
        for k, member in enumerate(members):
            at[k if slots < len(self.motions) else member] = float(member)
        return at

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self.motions)} modes, {', '.join(map(repr, self.sensors))})"


class GraphOptions(TypedDict, total=False):
    """What a filter of modes on a graph can be told beside its modes, its sensor and its transition."""

    graph: Sequence[Sequence[int]] | None
    first_mode: int
    outliers: Outliers | None
    initial: TwoPoint | OnePoint | Prior | None
    coast: float | None


class _Digraph(_VariableStructure):
    """Modes on a graph; what a subclass says is how many of them are alive at most."""

    _kind: ClassVar[native.Propose]

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: Sensor | Sequence[Sensor],
        transition: Transition,
        *,
        graph: Sequence[Sequence[int]] | None = None,
        first_mode: int = 0,
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        self._declare(motions, sensor, outliers, initial, coast)
        self.transition, self.graph, self.first_mode = transition, graph, first_mode
        near = neighbours(len(self.motions), transition, graph)
        _reachable(near, first_mode)
        alive = self._most_alive(near)
        slots = self._slots(alive)
        others = [j for j in near[first_mode] if j != first_mode]
        first = self._placed(sorted([first_mode, *others[: alive - 1]]), slots)
        proposal = native.Proposal(kind=self._kind, slots=slots, start=first, neighbours=near, numbers=[float(alive)])
        parts = Parts(proposal=proposal, start=_begun(first, first_mode))
        self._prepare(transition=transition, coast=coast, parts=parts)

    def _most_alive(self, near: list[list[int]]) -> int:
        raise NotImplementedError


class DigraphSwitching(_Digraph):
    """Variable-structure IMM by digraph switching: the likeliest mode and its neighbours are alive.

    A(k+1) = {j: neighbour of argmaxᵢ μᵢ(k)};  cⱼ = Σ_{i ∈ A(k)} Π⁺ᵢⱼ μᵢ for j ∈ A(k+1), the IMM's recursion over these.
    Π⁺: a mode that stays alive stays with its own probability, the rest goes to the neighbours that are alive, in
    proportion.

    motions the whole set; transition as in :class:`jink.IMM` over all of them; graph, the neighbours of each mode
    (default: where transition is not zero); first_mode, the one a track begins with. Modes of one motion model and
    different numbers cost as much as the largest neighbourhood, others as much as those that any of a pack of tracks
    has alive. Errors: ValueError for modes that cannot be reached. Source: Li & Bar-Shalom, IEEE Trans. AC-41(4), 1996.
    """

    arguments = ("transition", "graph", "first_mode", *COMMON)

    _kind = native.Propose.digraph

    def _most_alive(self, near: list[list[int]]) -> int:
        return max(map(len, near))


class ActiveDigraph(_Digraph):
    """Variable-structure IMM by active digraph: the ``alive`` likeliest modes of the next scan are alive.

    A(k+1) = the modes of the largest cⱼ = Σ_{i ∈ A(k)} Πᵢⱼ μᵢ(k), over the whole graph; then as
    :class:`DigraphSwitching`, with the same arguments. Source: Li, Hybrid estimation techniques, Control and Dynamic
    Systems 76, 1996 ("active digraph"). It is neither the model-group switching of Li, Zwi & Zhang 1999, whose groups
    are fixed, nor the likely-model set of Li & Zhang 2000, which drops modes below thresholds.
    """

    arguments = ("transition", "alive", "graph", "first_mode", *COMMON)

    _kind = native.Propose.active

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: Sensor | Sequence[Sensor],
        transition: Transition,
        *,
        alive: int = 3,
        **options: Unpack[GraphOptions],
    ) -> None:
        self.alive = alive
        super().__init__(motions, sensor, transition, **options)

    def _most_alive(self, near: list[list[int]]) -> int:
        return whole("alive", self.alive, 2, len(near), " of modes")


class AdaptiveGrid(_VariableStructure):
    """Variable-structure IMM by adaptive grid: three points that move along an ordered set of modes of one motion
    model.

    Points l < c < r lie anywhere between the first mode (0) and the last (M − 1), with numbers in between. After a scan
    the centre goes to Σ μ · point; an outer point comes half as near where its probability is below ``unlikely``, goes
    out to twice the distance where it is above ``likely``, and is never nearer than ``least_step``. transition: of the
    three points (default: stay 0.9). mode_probability is shared out between the two modes a point lies between.
    Errors: ValueError for fewer than three modes, or different motion models. Source: Jilkov, Angelova & Semerdjiev,
    IEEE Trans. AES-35(1), 1999.
    """

    arguments = ("transition", "least_step", "unlikely", "likely", *COMMON)

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: Sensor | Sequence[Sensor],
        transition: Transition = 0.9,
        *,
        least_step: float = 1.0,
        unlikely: float = 0.05,
        likely: float = 0.85,
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        self._declare(motions, sensor, outliers, initial, coast)
        self.transition = transition
        self.least_step, self.unlikely, self.likely = least_step, unlikely, likely
        last = len(self.motions) - 1.0
        if not self._alike:
            raise ValueError("motions: expected modes of one motion model that differ only in their numbers")
        if len(self.motions) < 3:
            raise ValueError(f"motions: expected at least 3 modes for a grid of three points, got {len(self.motions)}")
        if not positive("least_step", least_step) <= last / 2:
            raise ValueError(f"least_step: expected at most half of {last:g} modes, got {least_step:g}")
        if not positive("unlikely", unlikely, zero=True) < positive("likely", likely) <= 1:
            raise ValueError(f"unlikely: expected 0 ≤ unlikely < likely ≤ 1, got {unlikely:g} and {likely:g}")
        numbers = [float(least_step), float(unlikely), float(likely)]
        proposal = native.Proposal(kind=native.Propose.grid, slots=3, start=[0.0, last / 2, last], numbers=numbers)
        self._prepare(transition=transition, coast=coast, parts=Parts(proposal=proposal, start=uniform(3, 3), chain=3))


def neighbours(modes: int, transition: Transition, graph: Sequence[Sequence[int]] | None) -> list[list[int]]:
    """The modes that each mode may change to, itself included: as given, or where transition is not zero."""
    _, matrix = transition_rule(transition, None, modes)
    near = [np.flatnonzero(row) for row in matrix] if graph is None else items("graph", graph, "neighbours of modes")
    if len(near) != modes:
        raise ValueError(f"graph: expected the neighbours of each of {modes} modes, got {len(near)} lists")
    out = []
    for i, row in enumerate(near):
        members = sorted({whole("graph", j, -(2**31)) for j in items("graph", row, "modes")} | {i})
        if members[0] < 0 or members[-1] >= modes:
            raise ValueError(f"graph: mode {i} has neighbours {list(row)}; modes are 0 to {modes - 1}")
        out.append(members)
    return out


def line_graph(modes: int, reach: int = 1) -> list[list[int]]:
    """The neighbours of each mode in an ordered set: those within ``reach`` places."""
    return [list(range(max(0, i - reach), min(modes, i + reach + 1))) for i in range(modes)]


def line_transition(modes: int, reach: int = 1, stay: float = 0.95) -> Array:
    """Transition (M, M): a mode stays with ``stay``; its neighbours in :func:`line_graph` share the rest equally."""
    matrix = np.zeros((modes, modes))
    for i, near in enumerate(line_graph(modes, reach)):
        for j in near:
            matrix[i, j] = stay if i == j else (1 - stay) / (len(near) - 1)
    return matrix


def noise_levels(variances: ArrayLike) -> list[ConstantVelocity]:
    """Constant velocities with acceleration noise of these variances ((m/s²)²); choi-2001's are 1, 6, …, 196."""
    return [ConstantVelocity(acceleration_sd=float(np.sqrt(v))) for v in np.asarray(variances, dtype=float)]


CHOI_2001 = tuple(range(1, 197, 5))  # (m/s²)²: forty levels, a step of 5 apart; Choi, Samal & Ahn 2001, §4


def _reachable(near: list[list[int]], start: int) -> None:
    whole("first_mode", start, 0, len(near) - 1)
    seen, edge = {start}, [start]
    while edge:
        edge = [j for i in edge for j in near[i] if j not in seen]
        seen.update(edge)
    lost = sorted(set(range(len(near))) - seen)
    if lost:
        raise ValueError(
            f"graph: mode {lost[0]} cannot be reached from mode {start}"
            + (f", nor can {len(lost) - 1} others" if len(lost) > 1 else "")
        )


def _begun(first: list[float], start: int) -> Array:
    """Initial probabilities of the slots: nearly all on the mode a track starts with."""
    alive = np.array(first) >= 0
    p = np.where(alive, 0.05 / max(alive.sum() - 1, 1), 0.0)
    p[first.index(float(start))] = 0.95 if alive.sum() > 1 else 1.0
    return p


__all__ = [
    "ActiveDigraph",
    "AdaptiveGrid",
    "DigraphSwitching",
    "Sojourn",
    "line_graph",
    "line_transition",
    "noise_levels",
]
