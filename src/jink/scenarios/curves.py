"""Truth as a smooth curve: course, speed and height change by ramps; turns begin and end as clothoids."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..checks import Array
from ..frozen import frozen
from .truth import Kinematics, find, rows_of

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
NODES, WEIGHTS = 0.5 * (NODES + 1.0), 0.5 * WEIGHTS
BLOCK = 16  # runs that are integrated at once


@frozen
class Ramps:
    """A quantity whose rate is a sum of ramps: each changes it linearly by `change` from `begin` to `end`.

    start (B,) the quantity at time 0; begin, end (s), change (B, R). The rate is 0 before the first ramp.
    """

    start: Array
    begin: Array
    end: Array
    change: Array

    def __call__(self, time: Array) -> tuple[Array, Array]:
        """The quantity and its rate at the times (B, ...): exact integrals of the ramps."""
        value, rate, _ = self._sums(time, integral=False)
        return value, rate

    def integral(self, time: Array) -> Array:
        """The quantity's integral from 0 to the times (B, ...)."""
        return self._sums(time, integral=True)[2]

    def _sums(self, time: Array, *, integral: bool) -> tuple[Array, Array, Array]:
        def own(values: Array) -> Array:
            return values.reshape(len(values), *(1,) * (time.ndim - 1))

        value = own(self.start) + np.zeros_like(time)
        rate, total = np.zeros_like(value), own(self.start) * time if integral else np.zeros(1)
        for ramp in range(self.begin.shape[1]):
            begin, end, change = (own(array[:, ramp]) for array in (self.begin, self.end, self.change))
            length = end - begin
            since = np.clip(time - begin, 0.0, length)
            slope = change / np.where(length > 0, length, 1.0)
            past = np.maximum(time - end, 0.0)
            rate += np.where(length > 0, slope * since, change * (time >= end))
            value += 0.5 * slope * since**2 + change * past
            if integral:
                total = total + slope * since**3 / 6 + 0.5 * change * past * (length + past)
        return value, rate, total


def pulses(start: Array, begin: Array, end: Array, onset: Array | float, exit: Array | float, change: Array) -> Ramps:
    """A quantity changes by `change` from begin to end: its rate rises over onset, stays, falls over exit.

    start (B,); the others (B, P) or what broadcasts to it, in s and the quantity's unit.
    """
    begin, end, onset, exit, change = np.broadcast_arrays(begin, end, onset, exit, change)
    rate = change / np.maximum(end - begin - 0.5 * (onset + exit), 1e-12)
    starts, ends = np.concatenate([begin, end - exit], axis=1), np.concatenate([begin + onset, end], axis=1)
    return Ramps(start, starts, ends, np.concatenate([rate, -rate], axis=1))


class Panels(NamedTuple):
    """A quantity on panels between joints: value, rate, slope of rate, integral at their begins (B, N)."""

    value: Array
    rate: Array
    slope: Array
    integral: Array

    def of(self, panel: np.ndarray) -> Panels:
        """The same for the panels (B, n) that some times lie in."""
        return Panels(*(rows_of(array, panel) for array in self))

    def after(self, time: Array) -> tuple[Array, Array]:
        """Value and rate at the times since the panel began: (B, n) or with quadrature points (B, n, q)."""
        v, r, s = (array.reshape(*array.shape, *(1,) * (time.ndim - 2)) for array in self[:3])
        return v + time * (r + 0.5 * s * time), r + s * time

    def summed(self, time: Array) -> Array:
        """Integral at the times (B, n) since the panel began."""
        return self.integral + time * (self.value + time * (0.5 * self.rate + time * self.slope / 6))


@frozen
class Curves:
    """v = (h sin ψ, h cos ψ, w): course ψ clockwise from north, climb rate w, ground speed h.

    course (rad), speed (m/s), climb (m/s, or None for two axes) are :class:`Ramps` that begin at time 0 or
    later; position (B, axes) at time 0; duration (s) up to where it is asked, panel (s) the longest stretch
    of one quadrature. With along_path, speed is that along the path, h² = speed² − w². a is the exact
    derivative; height the exact integral of w, the position in the plane that of v by Gauss–Legendre
    quadrature (6 points) between joints, to rounding.
    """

    position: Array
    course: Ramps
    speed: Ramps
    climb: Ramps | None
    duration: float
    panel: float = 1.0
    along_path: bool = False

    @property
    def runs(self) -> int:
        """B"""
        return len(self.position)

    def at(self, time: Array) -> Kinematics:
        """Kinematics at the times (B, n)."""
        begins, quantities, place = self._panels
        panel = find(begins, time)
        since = time - rows_of(begins, panel)
        own = [quantity.of(panel) for quantity in quantities]
        velocity, acceleration = self._motion(own, since)
        position = rows_of(place, panel) + self._advance(own, since)
        if self.climb is not None:
            height = self.position[:, 2:] + own[2].summed(since)
            position = np.concatenate([position, height[..., None]], axis=-1)
        return Kinematics(position, velocity, acceleration)

    def breaks(self) -> Array:
        """(B, K) begin and end of all ramps."""
        times = [times for ramps in self._ramps for times in (ramps.begin, ramps.end)]
        return np.concatenate([np.broadcast_to(each, (self.runs, each.shape[1])) for each in times], axis=1)

    @property
    def _ramps(self) -> list[Ramps]:
        return [ramps for ramps in (self.course, self.speed, self.climb) if ramps is not None]

    @cached_property
    def _panels(self) -> tuple[Array, list[Panels], Array]:
        """Begins of the panels (B, N), course, speed (and climb) there, and the place there (B, N, 2)."""
        grid = np.linspace(0.0, self.duration, int(np.ceil(self.duration / self.panel)) + 1)
        times = np.concatenate([self.breaks(), np.broadcast_to(grid, (self.runs, len(grid)))], axis=1)
        order = np.argsort(times, axis=1, kind="stable")
        begins = np.take_along_axis(times, order, axis=1)
        length = np.diff(begins, axis=1)
        quantities, first = [], 0
        for ramps in self._ramps:
            steps = np.zeros(times.shape)
            slope = ramps.change / (ramps.end - ramps.begin)
            count = slope.shape[1]
            steps[:, first : first + count], steps[:, first + count : first + 2 * count] = slope, -slope
            first += 2 * count
            slope = np.cumsum(np.take_along_axis(steps, order, axis=1), axis=1)
            s = slope[:, :-1]
            rate = _running(length * s, 0.0)
            r = rate[:, :-1]
            value = _running(length * (r + 0.5 * length * s), ramps.start)
            integral = _running(length * (value[:, :-1] + length * (0.5 * r + length * s / 6)), 0.0)
            quantities.append(Panels(value, rate, slope, integral))
        steps = self._advance([Panels(*(array[:, :-1] for array in each)) for each in quantities], length)
        place = np.cumsum(np.concatenate([self.position[:, None, :2], steps], axis=1), axis=1)
        return begins, quantities, place

    def _advance(self, own: list[Panels], length: Array) -> Array:
        """∫ v dt in the plane over the first `length` (B, n) of panels, (B, n, 2)."""
        moved = np.empty((*np.broadcast_shapes(length.shape, own[0].value.shape), 2))
        for first in range(0, len(moved), BLOCK):  # what is in work fits into a cache
            some = slice(first, first + BLOCK)
            part = [Panels(*(array if len(array) == 1 else array[some] for array in each)) for each in own]
            taken = length if len(length) == 1 else length[some]
            velocity, _ = self._motion(part, taken[..., None] * NODES, derivative=False)
            moved[some] = taken[..., None] * np.einsum("bnqa,q->bna", velocity[..., :2], WEIGHTS)
        return moved

    def _motion(self, own: list[Panels], time: Array, *, derivative: bool = True) -> tuple[Array, Array]:
        """Velocity and acceleration at the times since the panels began."""
        (course, turn), (h, h_rate) = own[0].after(time), own[1].after(time)
        w, w_rate = own[2].after(time) if self.climb is not None else (np.zeros(1), np.zeros(1))
        if self.along_path:
            ground = np.sqrt(h * h - w * w)
            h, h_rate = ground, (h * h_rate - w * w_rate) / ground
        s, c = np.sin(course), np.cos(course)
        vertical = ([w], [w_rate]) if self.climb is not None else ([], [])
        velocity = np.stack([h * s, h * c, *vertical[0]], axis=-1)
        if not derivative:
            return velocity, velocity
        across = h * turn
        return velocity, np.stack([h_rate * s + across * c, h_rate * c - across * s, *vertical[1]], axis=-1)


def _running(steps: Array, start: Array | float) -> Array:
    """(B, N) start (B,) and the sums of steps (B, N − 1) after it."""
    first = np.broadcast_to(np.reshape(start, (-1, 1)), (len(steps), 1))
    return np.cumsum(np.concatenate([first, steps], axis=1), axis=1)
