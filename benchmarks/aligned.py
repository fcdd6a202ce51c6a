"""Do modes that are aligned with the heading, or shorter legs, help on real flights seen by simulated radars?

    python -m benchmarks.aligned [FLIGHTS] [--draws 1] [--half held-out|fitted]

The default filter of aircraft beside four others, all in NumPy (`jink.stepwise`), without coasting and with outliers
decided at once. "across": acceleration enters with twice the variance across the track as along it. "along and
across": two acceleration modes instead of one, each with a fifth of its sd in the other direction. "turns": the
turn's noise is four times as large across the track as along it. "legs of 30 s": straight for 30 s in the mean, not
60. States stay Cartesian; the heading is that of the estimated velocity.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.commands import fetch_collection
from benchmarks.flights import flights, held_out
from benchmarks.parts import RADARS, Radar, build, lines, measure, seen
from jink import IMM, ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Sojourn
from jink.stepwise import Stepwise

NONE = 1e-9  # noise of a mode whose own is added with the heading


@dataclass(frozen=True)
class Aligned:
    """Of a mode, along and across the track: variance of an acceleration that enters, and psd of its noise."""

    entering: tuple[float, float] | None
    noise: tuple[float, float]


@dataclass(frozen=True)
class Bank:
    """Modes, mean seconds in each, which follows, and how they are aligned."""

    motions: tuple[Any, ...]
    seconds: tuple[float, ...]
    to: tuple[tuple[float, ...], ...]
    aligned: dict[int, Aligned] = field(default_factory=dict)


def acceleration(sd: float) -> ConstantAcceleration:
    """Vertically that of the default; its horizontal noise is added with the heading."""
    return ConstantAcceleration(jerk_psd=(NONE, NONE, 0.05), acceleration_prior_sd=(sd, sd, 0.35))


STRAIGHT = ConstantVelocity(acceleration_psd=(0.02, 0.02, 0.01))
TURN = {"turn_rate_psd": 3e-7, "turn_rate_prior_sd": 0.03}
TURNING = CoordinatedTurn(acceleration_psd=(4.0, 4.0, 0.1), **TURN)
TO = ((0.0, 0.9, 0.1), (0.8, 0.0, 0.2), (0.6, 0.4, 0.0))
THREE = {"seconds": (60.0, 12.0, 40.0), "to": TO}
BANKS = {
    "default": Bank((STRAIGHT, acceleration(1.0), TURNING), **THREE, aligned={1: Aligned((1.0, 1.0), (0.1, 0.1))}),
    "across": Bank((STRAIGHT, acceleration(1.0), TURNING), **THREE, aligned={1: Aligned((0.7, 1.4), (0.07, 0.14))}),
    "along and across": Bank(
        (STRAIGHT, acceleration(0.7), acceleration(1.5), TURNING),
        (60.0, 12.0, 12.0, 40.0),
        ((0.0, 0.4, 0.5, 0.1), (0.7, 0.0, 0.15, 0.15), (0.7, 0.15, 0.0, 0.15), (0.7, 0.15, 0.15, 0.0)),
        {1: Aligned((0.49, 0.02), (0.05, 0.002)), 2: Aligned((0.09, 2.25), (0.008, 0.2))},
    ),
    "legs of 30 s": Bank(
        (STRAIGHT, acceleration(1.0), TURNING), (30.0, 12.0, 40.0), TO, {1: Aligned((1.0, 1.0), (0.1, 0.1))}
    ),
    "turns": Bank(
        (STRAIGHT, acceleration(1.0), CoordinatedTurn(acceleration_psd=(NONE, NONE, 0.1), **TURN)),
        **THREE,
        aligned={1: Aligned((1.0, 1.0), (0.1, 0.1)), 2: Aligned(None, (2.0, 8.0))},
    ),
}


class AlignedScan(Stepwise):
    """A bank whose horizontal noise and entering accelerations have axes along and across the track."""

    aligned: dict[int, Aligned]
    heading: tuple[np.ndarray, np.ndarray]

    def propagate(self, s: Any, dt: np.ndarray, u: Any) -> Any:
        """With the heading of the estimate before the scan."""
        v = np.zeros((len(dt), 2))
        for j, mode in enumerate(self.modes):
            v += s.probability[:, j, None] * s.x[j][:, [mode.components.index(c) for c in ("vx", "vy")]]
        speed = np.maximum(np.hypot(v[:, 0], v[:, 1]), 1e-9)
        self.heading = v[:, 0] / speed, v[:, 1] / speed
        return super().propagate(s, dt, u)

    def turned(self, pair: tuple[float, float]) -> dict[str, np.ndarray]:
        """A diagonal covariance along and across the track, in x and y."""
        (along, across), (c, s) = pair, self.heading
        return {
            "xx": along * c * c + across * s * s,
            "yy": along * s * s + across * c * c,
            "xy": (along - across) * c * s,
            "yx": (along - across) * c * s,
        }

    def source(self, j: int, i: int, x: Any, P: Any) -> tuple[np.ndarray, np.ndarray]:
        """Mode i as mode j sees it; the acceleration that i lacks enters along and across the track."""
        mean, C = super().source(j, i, x, P)
        entering = self.aligned[j].entering if j in self.aligned else None
        if entering and "ax" not in self.modes[i].components:
            C = C.copy()
            for (a, b), value in self.turned(entering).items():
                at = [self.modes[j].components.index(f"a{axis}") for axis in (a, b)]
                C[:, at[0], at[1]] = value
        return mean, C

    def predict(self, j: int, dt: np.ndarray, x: Any, P: Any, u: Any) -> tuple[np.ndarray, np.ndarray]:
        """Adds the noise that is aligned."""
        ahead, P_ahead = super().predict(j, dt, x, P, u)
        if j not in self.aligned:
            return ahead, P_ahead
        components = self.modes[j].components
        powers = 3 if "ax" in components else 2  # integrated so often
        unit = np.empty((len(dt), powers, powers))
        fact = (1.0, 1.0, 2.0)
        for r in range(powers):
            for q in range(powers):
                a, b = powers - 1 - r, powers - 1 - q
                unit[:, r, q] = dt ** (a + b + 1) / ((a + b + 1) * fact[a] * fact[b])
        for (a, b), value in self.turned(self.aligned[j].noise).items():
            rows, columns = ([components.index(f"{kind}{axis}") for kind in "pva"[:powers]] for axis in (a, b))
            P_ahead[np.ix_(range(len(dt)), rows, columns)] += value[:, None, None] * unit
        return ahead, P_ahead


def filter_of(bank: Bank, radar: Radar) -> IMM:
    """An IMM of the bank whose engine is the aligned one."""
    default = build(radar, hindsight=False)
    taken = {name: getattr(default, name) for name in ("outliers", "initial", "coast")}
    made = IMM(bank.motions, default.sensors[0], Sojourn(bank.seconds, bank.to), **taken)
    engine = AlignedScan(made.motions, made.sensors, made.axes, made.outliers, False, made.declaration)
    engine.aligned = bank.aligned
    made.engine = engine
    return made


def main() -> None:
    """Print a table of every bank on both radars."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path, nargs="?")
    parser.add_argument("--draws", type=int, default=1)
    parser.add_argument("--half", choices=("held-out", "fitted"), default="held-out")
    given = parser.parse_args()
    known = flights(given.flights or fetch_collection())
    some = [f for f in known if held_out(f) == (given.half == "held-out")]
    for radar in RADARS:
        data = seen(some, radar, 0.0, 1.0, given.draws)
        for k, (name, bank) in enumerate(BANKS.items()):
            table = lines(measure(filter_of(bank, radar), data), data)
            if k == 0:
                print(f"{radar.name}; all rows, then turning ones\n  {'':<18}{table[0][2:]}")
            for row in (table[1], table[3]):
                print(f"  {name:<18}{row[2:]}", flush=True)


if __name__ == "__main__":
    main()
