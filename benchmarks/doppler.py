"""jink against the Optimized Kalman Filter (OKF) on its own simulated Doppler radar: errors, training, time.

    python -m benchmarks.doppler [--quick] [--only SETTING ...] [--seed S] [--json FILE]

All get the same plots: range, azimuth, elevation and range rate once a second, whose noises are known. KF and OKF are
linear filters of constant velocity on the plots' positions; the line of sight of a range rate is that of the plot. KF
takes Q and R from the truth of the training targets, the classical way; OKF trains them on that truth. Training and
check are 1500 and about 1000 targets in its repository; jink is fitted on the first 300 of them.
Its filters as they come do not know how fast these targets are; the fitted ones found it out.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jink.catalogue.choose import purpose_of
from jink.catalogue.registry import FILTERS
from jink.filters.loading import built
from jink.fit.objectives import Likelihood, Objective, Tracking
from jink.fit.optimise import Search
from jink.fit.parameters import Parameters
from jink.models.tracks import Tracks
from jink.tracking.range_rate import rate_variance

from . import peers
from .doppler_kalman import estimated_noise, kalman
from .doppler_targets import (
    AZIMUTH_SD,
    ELEVATION_SD,
    RANGE_SD,
    RATE_SD,
    SETTINGS,
    STEP,
    Flights,
    Setting,
    simulate,
)
from .table import markdown

TRAINING, CHECK = 1500, 1000  # targets
FAST = 300.0  # m/s, where the fit of a start's speed begins
FITTED = 300  # targets that jink is fitted on, the first ones
FIRST = 2  # scans before are the start of a track by two points
KF, OKF = "KF, noise from the truth", "OKF"
SD = {"range": RANGE_SD, "azimuth": AZIMUTH_SD, "elevation": ELEVATION_SD, "range_rate": RATE_SD}
STATES = tuple(kind + axis for kind in "pv" for axis in "xyz")
OBJECTIVES: dict[str, Objective] = {"likelihood": Likelihood(), "truth": Tracking()}


@dataclass(frozen=True)
class Entrant:
    """states (N, 6) on the check targets; s of processor time that training took; s of one update."""

    states: np.ndarray
    training: float = 0.0
    update: float | None = None


def race(setting: Setting, training: int, check: int, seed: int, peer: Any) -> dict[str, dict[str, float]]:
    """Figures of all entrants on one setting; peer: `benchmarks.peers.okf`, None where it is not installed."""
    learned, seen = simulate(setting, training, 2 * seed), simulate(setting, check, 2 * seed + 1)
    entrants = {**linear(learned, seen, seed, peer), **ours(setting, learned, seen)}
    base = errors(entrants[OKF if OKF in entrants else KF].states, seen)
    out: dict[str, dict[str, float]] = {
        "plots": figures(np.c_[seen.positions, np.full((len(seen.time), 3), np.nan)], seen)
    }
    for name, entrant in entrants.items():
        out[name] = figures(entrant.states, seen) | compared(errors(entrant.states, seen), base, seen)
        out[name] |= {"training": entrant.training}
        out[name] |= {} if entrant.update is None else {"update": entrant.update}
    return out


def linear(learned: Flights, seen: Flights, seed: int, peer: Any) -> dict[str, Entrant]:
    """KF and, where it is installed, OKF, which begins its training from KF's noise."""
    begin = time.process_time()
    Q, R = estimated_noise(learned)
    out = {KF: Entrant(kalman(seen, Q, R), time.process_time() - begin)}
    if peer is not None:
        z = np.column_stack([learned.positions, learned.z[:, 3]])
        parts = [slice(a, b) for a, b in zip(learned.offsets[:-1], learned.offsets[1:], strict=True)]
        found = peer.train([learned.truth[part] for part in parts], [z[part] for part in parts], Q, R, seed)
        out[OKF] = Entrant(kalman(seen, found.Q, found.R), found.seconds, found.update)
    return out


def ours(setting: Setting, learned: Flights, seen: Flights) -> dict[str, Entrant]:
    """jink's filters as they come for the kind of target, and fitted with their start (`--free 'start.*'`)."""
    out = {}
    some = tracks(learned).some(np.arange(min(FITTED, len(learned))))
    kind = "fighter" if setting.acceleration else "aircraft"
    purpose = purpose_of(tuple(SD), SD, kind, 0.0, STEP)
    for name in ("kalman-cv", "imm"):
        start = FILTERS[name](purpose).filter
        out[f"jink {name}, {kind}"] = entrant(start, seen)
        for word, objective in OBJECTIVES.items():
            parameters, begin = Parameters(bounded(start), free=("start.*",)), time.process_time()
            found = Search(parameters, objective, some, starts=1).run()
            took = time.process_time() - begin
            out[f"jink {name}, fitted by {word}"] = entrant(parameters.filter(found.u), seen, took)
    return out


def bounded(filter: Any) -> Any:
    """The filter with a start that a speed bounds, which the fit then finds: the training targets tell how fast they
    are. KF and OKF begin with a velocity of 32 m/s sd, the default of the package.
    """
    body = filter.described()
    return built(body | {"initial": body["initial"] | {"velocity_sd": FAST, "bounded": True}}, own=True)


def entrant(filter: Any, seen: Flights, training: float = 0.0) -> Entrant:
    """A filter of jink's at work; the time is the median of three runs in one thread."""
    data, costs = tracks(seen).keywords(), []
    for _ in range(3):
        begin = time.process_time()
        found = filter.filter(**data, outputs=("x",), threads=1)
        costs.append((time.process_time() - begin) / len(seen.time))
    columns = [found.components.index(name) for name in STATES]
    return Entrant(found.x[:, columns], training, statistics.median(costs))


def tracks(flights: Flights) -> Tracks:
    """As `jink track` would filter these plots: a range rate counts little until the velocity is known."""
    angle = np.full(len(flights.time), np.hypot(AZIMUTH_SD, ELEVATION_SD))
    variance = np.tile([SD[name] ** 2 for name in SD], (len(flights.time), 1))
    variance[:, 3] = rate_variance(flights.z[:, 0], flights.time, flights.offsets, angle, RATE_SD, STEP)
    return Tracks(
        flights.time,
        flights.z,
        flights.offsets,
        variance,
        truth=flights.truth,
        components=STATES,
        counts=scored(flights),
        owner=np.arange(len(flights)),
    )


def scored(flights: Flights) -> np.ndarray:
    """Rows from the third of each target on."""
    return flights.time >= FIRST * STEP


def errors(states: np.ndarray, seen: Flights) -> np.ndarray:
    """Squared errors (N, 2) of position, m², and of velocity, m²/s²."""
    square = (states - seen.truth) ** 2
    return np.stack([square[:, :3].sum(axis=1), square[:, 3:].sum(axis=1)], axis=1)


def figures(states: np.ndarray, seen: Flights) -> dict[str, float]:
    """Mean squared errors from the third scan on, and of the position over all scans."""
    square, rows = errors(states, seen), scored(seen)
    position, velocity = (float(square[rows, k].mean()) for k in (0, 1))
    return {"position": position, "velocity": velocity, "all": float(square[:, 0].mean())}


def compared(square: np.ndarray, base: np.ndarray, seen: Flights) -> dict[str, float]:
    """Mean squared errors over those of the base, less one, and the standard errors of that, paired by target."""
    rows, out = scored(seen), {}
    for k, name in enumerate(("position", "velocity")):
        sums = [np.add.reduceat(np.where(rows, each[:, k], 0.0), seen.offsets[:-1]) for each in (square, base)]
        ratio = sums[0].sum() / sums[1].sum()
        spread = float(np.sqrt(((sums[0] - ratio * sums[1]) ** 2).sum()))
        out |= {f"{name} gain": float(ratio - 1.0), f"{name} se": spread / float(sums[1].sum())}
    return out


def measure(
    chosen: list[str], seed: int, share: float = 1.0, show: Callable[[str, Any], None] | None = None
) -> dict[str, Any]:
    """All chosen settings, each shown when it is done; share: of the targets."""
    peer, version = peers.load("okf")
    out: dict[str, Any] = {"okf": version, "targets": [max(8, round(share * n)) for n in (TRAINING, CHECK)]}
    out["settings"] = {}
    for name in chosen:
        found = out["settings"][name] = race(SETTINGS[name], *out["targets"], seed, peer)
        if show:
            show(name, found)
    return out


def table_of(found: dict[str, Any]) -> list[str]:
    """A Markdown table, a row for each setting and entrant, and what was raced against; or why there is none."""
    if "error" in found:
        return [f"not measured: {found['error']}"]
    cells = []
    for setting, entrants in found["settings"].items():
        for name, f in entrants.items():
            cells.append((setting, name, *_cells(f)))
            setting = ""
    raced = any(OKF in entrants for entrants in found["settings"].values())
    base = "OKF" if raced else "KF"
    head = (
        "setting",
        "filter",
        "position m²",
        f"against {base}",
        "velocity m²/s²",
        f"against {base}",
        "position m², all scans",
    )
    training, check = found["targets"]
    said = f"{training} training targets (jink: {min(FITTED, training)}), {check} others checked on; "
    said += f"Optimized-Kalman-Filter {found['okf']}" if raced else f"OKF takes no part: {found['okf']}"
    return [*markdown((*head, "training s of CPU", "µs per update"), cells), "", said]


def _cells(f: dict[str, float]) -> tuple[str, ...]:
    """One entrant's figures as words; against itself there is nothing to say."""
    out = []
    for name in ("position", "velocity"):
        out.append("" if np.isnan(f[name]) else f"{f[name]:,.0f}")
        itself = f.get(f"{name} se", 0.0) == 0.0
        out.append("" if itself else f"{100 * f[f'{name} gain']:+.1f} ± {100 * f[f'{name} se']:.1f} %")
    out.append(f"{f['all']:,.0f}")
    out.append(f"{f['training']:.1f}" if f.get("training") else "")
    out.append(f"{1e6 * f['update']:.3g}" if "update" in f else "")
    return tuple(out)


def main(arguments: list[str] | None = None) -> int:
    """Race, show each setting when it is done, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a tenth of the targets")
    parser.add_argument("--only", nargs="+", choices=list(SETTINGS), default=list(SETTINGS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, help="write the figures here too")
    given = parser.parse_args(arguments)

    def show(name: str, _: Any) -> None:
        print(f"{name} done", file=sys.stderr, flush=True)

    found = measure(given.only, given.seed, 0.1 if given.quick else 1.0, show)
    print("\n".join(table_of(found)))
    if given.json:
        given.json.write_text(json.dumps(found), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
