"""Does the learned correction help where it was trained, and hurt nowhere else?

    python -m benchmarks.corrector [--kind fighter|aircraft] [--runs 2000] [--seed 11] [--efficiency] [--flights FILE]
        [--corrector FILE]

Ratios of the RMSE of position and velocity of `imm-corrected` to that of the default filter on the same runs, for every
scenario with two axes, tracked as the kind, and for some of them seen by other sensors; NEES of position and
velocity in the plane over 4, without and with it; the time of an update. With `--efficiency` also the efficiencies of
fighters as in `benchmarks.efficiency`, with FILE flights of the quickstart collection seen by radars, which a corrector
of fighters has not learned from; for aircraft there is `benchmarks.corrector_flights`. --corrector: a file of
`jink learn corrector` instead of what is shipped.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.efficiency import FAMILIES, paired, planes, reference_of, squares
from jink import Position, default_filter, load
from jink.catalogue.corrected import CORRECTED, correction
from jink.compare.recorded import read
from jink.filters.corrected import Corrected
from jink.learn.plane_recorded import halves
from jink.learn.recorded import Flown
from jink.models.plane_corrector import PlaneCorrector
from jink.scenarios import SCENARIOS
from jink.scenarios.scenario import Scenario, Simulation

HURTS = 1.01
SEEN = ("random-turns", "random-accelerations-turned", "weave", "terminal-area")
SENSORS = ((0.2, 20.0), (4.0, 50.0), (12.0, 70.0), (12.0, 300.0), (1.0, 3.0), (30.0, 500.0))  # s, m
RADARS = {"12 s": (12.0, 120.0), "4 s": (4.0, 60.0), "1 s": (1.0, 25.0)}
SETTLED, TURNING = 10, 1.5  # scans; m/s²
CHUNK, FIRST = 500, 5


@dataclass(frozen=True)
class Gain:
    """Mean squared errors of each run (runs, 2) without and with the correction; NEES over 4 likewise."""

    without: np.ndarray
    corrected: np.ndarray
    nees: tuple[float, float]
    reference: np.ndarray | None = None

    def line(self, name: str) -> str:
        """Ratios, NEES, and whether one is above what is allowed by more than chance."""
        ratios = [paired(self.corrected[:, k], self.without[:, k]) for k in range(2)]
        said = "   ".join(f"{value:.3f} ± {se:.3f}" for value, se in ratios)
        bad = any(value - 2 * se > HURTS for value, se in ratios)
        return f"{name:<44}{said}   {self.nees[0]:>6.2f} → {self.nees[1]:.2f}{'   HURTS' if bad else ''}"


def corrector_of(kind: str, file: Path | None = None) -> PlaneCorrector:
    """What is shipped for a kind, or what is in a file."""
    return correction(kind) if file is None else load(file).corrector


def not_learned(path: Path, corrector: PlaneCorrector) -> list[Flown]:
    """Flights of the collection that it learned on, which its seed set aside."""
    return halves(read(str(path), "aircraft", corrector.trained.seeds[0], positions=True))[1]


def pair_of(kind: str, sensor: Any, corrector: PlaneCorrector) -> tuple[Any, Any]:
    """The default filter and the corrected one."""
    base = default_filter(kind, sensor)
    return base, Corrected(base, corrector)


def measured(scenario: Scenario, kind: str, corrector: Any, runs: int, seed: int, family: Any = None) -> Gain:
    """On the same runs."""
    found: list[Gain] = []
    for first in range(0, runs, CHUNK):
        made = scenario.simulate(range(first, min(first + CHUNK, runs)), seed)
        sides = [_errors(f, made) for f in pair_of(kind, made.scenario.observation.sensor, corrector)]
        best = None
        if family is not None:
            tree = reference_of(family, made.z, float(made.scenario.observation.sensor.sd))
            best = squares(made, tree.position, tree.velocity)
        found.append(Gain(sides[0][0], sides[1][0], (sides[0][1], sides[1][1]), best))
    joined = [np.concatenate([getattr(g, name) for g in found]) for name in ("without", "corrected")]
    nees = (float(np.mean([g.nees[0] for g in found])), float(np.mean([g.nees[1] for g in found])))
    best = None if family is None else np.concatenate([g.reference for g in found])  # type: ignore[misc]
    return Gain(*joined, nees, best)


def _errors(filter: Any, made: Simulation) -> tuple[np.ndarray, float]:
    found = filter.filter(**made.batch(), threads=1, outputs=("x", "P"))
    p, v = planes(made, found)
    truth = np.concatenate([made.truth.position[..., :2], made.truth.velocity[..., :2]], axis=-1)
    off = (np.concatenate([p, v], axis=-1) - truth)[:, FIRST:]
    at = [found.components.index(name) for name in ("px", "py", "vx", "vy")]
    P = found.P[:, at][:, :, at].reshape(*made.z.shape[:2], 4, 4)[:, FIRST:]
    square = np.stack([(off[..., k : k + 2] ** 2).sum(axis=-1).mean(axis=1) for k in (0, 2)], axis=1)
    nees = np.einsum("...i,...i->...", off, np.linalg.solve(P, off[..., None])[..., 0]).mean() / 4
    return square, float(nees)


def plane_scenarios() -> list[Scenario]:
    """Those whose truth and sensor have two axes at least."""
    return [s for s in SCENARIOS.values() if s.axes >= 2 and (s.observation.sensor.axes or 2) >= 2]


def never_hurts(kind: str, corrector: Any, runs: int, seed: int) -> None:
    """Print the ratios on all scenarios and on some of them seen otherwise."""
    print(f"{kind}: corrected over default, position, velocity; NEES/4 without → with")
    for scenario in plane_scenarios():
        print(measured(scenario, kind, corrector, min(runs, 500), seed).line(f"  {scenario.name}"), flush=True)
    for name in SEEN:
        for interval, sd in SENSORS:
            scenario = SCENARIOS[name].seen_by(Position(sd=sd, axes=SCENARIOS[name].axes), interval=interval)
            gain = measured(scenario, kind, corrector, min(runs, 100), seed)
            print(gain.line(f"  {name}, {interval:g} s, {sd:g} m"), flush=True)


def efficiencies(corrector: Any, runs: int, seed: int) -> None:
    """Print the default's and the corrected filter's errors over the reference's, on the same runs."""
    print(f"efficiencies of fighters, {runs} runs: default, corrected; position, velocity")
    for family in FAMILIES:
        gain = measured(SCENARIOS[family.scenario], "fighter", corrector, runs, seed, family)
        cells = []
        for errors in (gain.without, gain.corrected):
            cells += ["{:.3f} ± {:.3f}".format(*paired(errors[:, k], gain.reference[:, k])) for k in range(2)]
        print(f"  {family.scenario:<30}{'   '.join(cells)}", flush=True)


def real(path: Path, corrector: Any, seed: int) -> None:
    """Print the ratios on held-out flights tracked as fighters: R99, velocity in turns, velocity."""
    from benchmarks.flights import flights, held_out, sampled

    some = [f for f in flights(path) if held_out(f)]
    print(f"fighter: {len(some)} flights of the collection; R99, velocity in turns, velocity")
    for name, (interval, sd) in RADARS.items():
        runs = [(f, run) for f in some for run in sampled(f, interval, 3 * SETTLED)]
        p, v, a = (
            np.concatenate([getattr(f, what)[run, :2] for f, run in runs])
            for what in ("truth", "velocity", "acceleration")
        )
        when = np.concatenate([f.time[run] for f, run in runs])
        z = p + sd * np.random.default_rng(seed).standard_normal(p.shape)
        lengths = [len(run) for _, run in runs]
        age = np.concatenate([np.arange(n) for n in lengths])
        figures = []
        for filter in pair_of("fighter", Position(sd=sd), corrector):
            x = filter.filter(when, z, offsets=np.r_[0, np.cumsum(lengths)], threads=1, outputs=("x",))
            off_p = ((np.column_stack([x["px"], x["py"]]) - p) ** 2).sum(axis=1)
            off_v = ((np.column_stack([x["vx"], x["vy"]]) - v) ** 2).sum(axis=1)
            rows = age >= SETTLED
            turning = rows & (np.hypot(*a.T) > TURNING)
            worst = np.sort(off_p[rows])[: int(0.99 * rows.sum())]
            figures.append(np.sqrt([worst.mean(), off_v[turning].mean(), off_v[rows].mean()]))
        print(f"  {name:<8}" + "   ".join(f"{r:.3f}" for r in figures[1] / figures[0]), flush=True)


def cost(kind: str, corrector: Any, rounds: int = 15) -> None:
    """Print the CPU time of an update without and with the correction, by turns."""
    made = SCENARIOS["random-turns" if kind == "fighter" else "terminal-area"].simulate(1000, 1)
    pair, rows = pair_of(kind, made.scenario.observation.sensor, corrector), made.batch()
    for outputs in (("x",), ("x", "P")):
        kept = [f.filter(**rows, threads=1, outputs=outputs) for f in pair]
        seconds = np.empty((rounds, 2))
        for k in range(rounds):
            for j, filter in enumerate(pair):
                began = time.process_time()
                filter.filter(**rows, threads=1, outputs=outputs, out=kept[j])
                seconds[k, j] = time.process_time() - began
        ns = np.median(seconds, axis=0) / len(rows["time"]) * 1e9
        more = np.median(seconds[:, 1] - seconds[:, 0]) / len(rows["time"]) * 1e9
        print(f"{kind}, {', '.join(outputs)}: {ns[0]:.0f} ns an update, {more:+.0f} with the correction", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kind", choices=CORRECTED, default="fighter")
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--efficiency", action="store_true")
    parser.add_argument("--flights", type=Path)
    parser.add_argument("--corrector", type=Path)
    given = parser.parse_args()
    if given.kind != "fighter" and (given.efficiency or given.flights):
        parser.error("--efficiency and --flights are about fighters; benchmarks.corrector_flights has aircraft")
    corrector = corrector_of(given.kind, given.corrector)
    cost(given.kind, corrector)
    if given.efficiency:
        efficiencies(corrector, given.runs, given.seed)
    if given.flights:
        real(given.flights, corrector, given.seed)
    never_hurts(given.kind, corrector, given.runs, given.seed)


if __name__ == "__main__":
    main()
