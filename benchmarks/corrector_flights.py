"""Does the learned correction of aircraft help on flights that it has not learned from, however they are seen?

    python -m benchmarks.corrector_flights [FLIGHTS] [--corrector FILE] [--unseen FILE ...] [--forms] [--seed 21]

FLIGHTS: the collection that it learned on (without: quickstart is fetched); measured on the flights that `jink learn
corrector` sets aside by its seed. With --unseen on all flights of other files. FILE: a file of `jink learn corrector`
instead of what is shipped. --forms: also `jink.track`, with the one that is shipped and without, on the same plots as
range and azimuth, x and y, latitude and longitude. "between": predictions in the middle between two plots.

Ratios of corrected to default: R99 (RMSE of position without the worst 1 %), RMSE, velocity in turns and at all; NEES
over 4 of position and velocity, the share of it inside its 95 % band and that of the NIS, without and with. Standard
errors are over targets, or over tracks where these are few, by the jackknife.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from benchmarks import forms
from benchmarks.commands import fetch_collection
from benchmarks.corrector import HURTS, corrector_of, not_learned, pair_of
from benchmarks.flights import flights
from jink import Position
from jink.compare.recorded import read
from jink.io.loading import Reading, load_files
from jink.learn.plane_inputs import TURNING
from jink.learn.plane_recorded import SETTLED
from jink.learn.recorded import Flown, Radar, flown, local_cubic, seen
from jink.models.tracks import Tracks
from jink.tracking.prepare import Settings, prepare

KIND, GROUPS = "aircraft", 30
# period (s), sd (m), azimuth (degrees; 0: alike in all directions), share of gross errors, axes
SENSORS = {
    "radar, 12 s, 70 m, .068 deg": (12.0, 70.0, 0.068, 0.01, 3),
    "radar, 4 s, 50 m, .06 deg": (4.0, 50.0, 0.06, 0.01, 3),
    "radar, 1 s, 15 m, .06 deg": (1.0, 15.0, 0.06, 0.01, 3),
    "no heights, 12 s, 70 m, .068 deg": (12.0, 70.0, 0.068, 0.01, 2),
    "no heights, 4 s, 50 m, .06 deg": (4.0, 50.0, 0.06, 0.01, 2),
    "x, y, 12 s, 120 m": (12.0, 120.0, 0.0, 0.0, 2),
    "x, y, 4 s, 60 m": (4.0, 60.0, 0.0, 0.0, 2),
    "x, y, 1 s, 25 m": (1.0, 25.0, 0.0, 0.0, 2),
    "ADS-B, 1 s, 3 m": (1.0, 3.0, 0.0, 0.0, 3),
    "ADS-B, 1 s, 8 m": (1.0, 8.0, 0.0, 0.0, 3),
    "ADS-B, 2 s, 10 m": (2.0, 10.0, 0.0, 0.0, 3),
    "ADS-B, 5 s, 20 m": (5.0, 20.0, 0.0, 0.0, 3),
    "ADS-B, 10 s, 30 m": (10.0, 30.0, 0.0, 0.0, 3),
    "multilateration, 1 s, 100 m": (1.0, 100.0, 0.0, 0.01, 3),
    "far radar, 20 s, 300 m": (20.0, 300.0, 0.0, 0.01, 2),
}
BETWEEN = ("radar, 12 s, 70 m, .068 deg", "radar, 4 s, 50 m, .06 deg", "x, y, 1 s, 25 m", "ADS-B, 5 s, 20 m")
RECEIVED = (1.0, 5.0, 10.0)  # s: the plots of the file themselves


@dataclass(frozen=True)
class Errors:
    """Of each row: squares of position and velocity, NEES over 4, whether the NIS is inside its band; NaN: none."""

    position: np.ndarray
    velocity: np.ndarray
    nees: np.ndarray
    nis: np.ndarray


def measured(filter: Any, tracks: Tracks) -> Errors:
    """Run it on all tracks."""
    said = filter.filter(**tracks.keywords(), outputs=("x", "P", "nis", "nis_dof"))
    at = [filter.components.index(name) for name in ("px", "py", "vx", "vy")]
    off = said.x[:, at] - tracks.truth[:, :4]
    rows = tracks.counts
    nees = np.full(tracks.rows, np.nan)
    P = said.P[rows][:, at][:, :, at]
    nees[rows] = np.einsum("ni,ni->n", off[rows], np.linalg.solve(P, off[rows][..., None])[..., 0]) / 4
    low, high = chi2.ppf([0.025, 0.975], np.maximum(said.nis_dof, 1)[:, None]).T
    nis = np.where(np.isfinite(said.nis), (said.nis >= low) & (said.nis <= high), np.nan)
    return Errors((off[:, :2] ** 2).sum(axis=1), (off[:, 2:] ** 2).sum(axis=1), nees, nis)


def r99(square: np.ndarray) -> float:
    """Root of the mean without the largest 1 %."""
    return float(np.sqrt(np.sort(square)[: int(0.99 * square.size)].mean()))


def rmse(square: np.ndarray) -> float:
    """Root of the mean."""
    return float(np.sqrt(square.mean()))


def line(name: str, tracks: Tracks, sides: list[Errors]) -> str:
    """Ratios with standard errors, and whether one is above what is allowed by more than chance."""
    owner = np.unique(tracks.owner, return_inverse=True)[1]
    flight = (owner if owner.max() >= GROUPS else np.arange(len(tracks)))[tracks.of_row]
    turning = tracks.counts & (np.hypot(*tracks.truth[:, 4:6].T) > TURNING)
    without, corrected = sides
    figures = (
        (r99, "position", tracks.counts),
        (rmse, "position", tracks.counts),
        (rmse, "velocity", turning),
        (rmse, "velocity", tracks.counts),
    )
    cells, bad = [], False
    for of, what, rows in figures:
        value, se = jackknifed(of, getattr(corrected, what), getattr(without, what), rows, flight)
        cells.append(f"{value:.3f} ± {se:.3f}")
        bad |= value - 2 * se > HURTS
    rows = tracks.counts
    band = chi2.ppf([0.025, 0.975], 4) / 4
    nees = [f"{e.nees[rows].mean():.2f}" for e in sides]
    inside = [f"{100 * ((e.nees[rows] >= band[0]) & (e.nees[rows] <= band[1])).mean():.0f}" for e in sides]
    nis = [f"{100 * np.nanmean(e.nis[rows]):.1f}" if np.isfinite(e.nis[rows]).any() else "-" for e in sides]
    shares = f"{' → '.join(nees):>12}  {' → '.join(inside):>8} %  {' → '.join(nis):>12} %"
    return f"  {name:<42}{'  '.join(cells)} {shares}{'   HURTS' if bad else ''}"


def jackknifed(
    of: Callable[[np.ndarray], float], one: np.ndarray, other: np.ndarray, rows: np.ndarray, flight: np.ndarray
) -> tuple[float, float]:
    """A figure of one over that of the other, and its standard error as flights are left out in groups."""
    used = rows & np.isfinite(one) & np.isfinite(other)
    a, b, group = one[used], other[used], flight[used] % GROUPS
    without = np.array([of(a[group != g]) / of(b[group != g]) for g in np.unique(group)])
    n = len(without)
    return of(a) / of(b), float(np.sqrt((n - 1) / n * ((without - without.mean()) ** 2).sum()))


def counted(tracks: Tracks) -> Tracks:
    """The same with the settled rows to be scored."""
    settled = np.arange(tracks.rows) - tracks.first[tracks.of_row] >= SETTLED
    known = np.isfinite(tracks.truth).all(axis=1)
    return Tracks(**{**vars(tracks), "counts": settled & known})


def as_received(path: Path, some: list[Flown], velocity: bool) -> tuple[Tracks, Any]:
    """The plots of the file itself with the noise that `jink track` estimates, and the sensor."""
    measurements = load_files([str(path)], Reading(None)).measurements
    prepared = prepare(measurements, Settings(kind=KIND, velocity=velocity))
    group = max(prepared.groups, key=lambda each: len(each.placed.time))
    placed, names = group.placed, {each.target for each in some}
    owner = placed.rows["target"].to_numpy().astype(str)[placed.offsets[:-1]]
    tracks = Tracks(placed.time, placed.z, placed.offsets, group.covariance, owner=owner)
    return tracks.some(np.array([k for k in range(len(tracks)) if owner[k] in names])), group.purpose.sensor


def thinned(tracks: Tracks, period: float) -> Tracks:
    """Plots so many seconds apart, with the truth that all plots show."""
    kept, lengths, truth = [], [], np.full((tracks.rows, 6), np.nan)
    for k in range(len(tracks)):
        rows = tracks.at(k)
        truth[rows] = np.concatenate([v[:, :2] for v in local_cubic(tracks.time[rows], tracks.z[rows, :3])], axis=1)
        last, before = -np.inf, len(kept)
        for row in rows.start + np.flatnonzero(np.isfinite(tracks.z[rows, :2]).all(axis=1)):
            if tracks.time[row] >= last + period - 1e-6:
                kept.append(row)
                last = tracks.time[row]
        lengths.append(len(kept) - before)
    at = np.array(kept)
    offsets = np.r_[0, np.cumsum(lengths)]
    return Tracks(tracks.time[at], tracks.z[at], offsets, tracks.covariance[at], truth=truth[at], owner=tracks.owner)


def of_sensor(name: str, some: list[Flown], corrector: Any, seed: int, halfway: bool = False) -> str:
    """The line of a sensor; halfway: of the predictions in the middle between two plots."""
    period, sd, degrees, gross, axes = SENSORS[name]
    azimuth = np.radians(degrees) if degrees else None
    radar = Radar(period=period / 2 if halfway else period, sd=sd, azimuth_sd=azimuth, gross=gross, axes=axes)
    tracks = counted(seen(some, radar, np.random.default_rng(seed)))
    if halfway:
        between = (np.arange(tracks.rows) - tracks.first[tracks.of_row]) % 2 == 1
        tracks.z[between] = np.nan
        tracks = replace(tracks, counts=tracks.counts & between)
    sides = pair_of(KIND, Position(sd=sd, axes=axes), corrector)
    return line(f"between: {name}" if halfway else name, tracks, [measured(f, tracks) for f in sides])


def table(some: list[Flown], path: Path | None, corrector: Any, seed: int) -> None:
    """Print a line per sensor."""
    print(f"  {'':<42}{'R99':<15}{'RMSE':<15}{'v in turns':<15}{'v':<15} NEES/4, in its band, NIS in its band")
    for name, halfway in [*((name, False) for name in SENSORS), *((name, True) for name in BETWEEN)]:
        print(of_sensor(name, some, corrector, seed, halfway), flush=True)
    for velocity in (False, True) if path else ():
        every, sensor = as_received(path, some, velocity)
        for period in RECEIVED:
            tracks, words = counted(thinned(every, period)), ", with velocity" if velocity else ""
            sides = [measured(f, tracks) for f in pair_of(KIND, sensor, corrector)]
            print(line(f"as received, {period:g} s{words}", tracks, sides), flush=True)


def in_forms(path: Path, names: set[str], seed: int) -> None:
    """Print the ratios that `jink.track` shows in every form of the same plots."""
    some = [f for f in flights(path) if f.target in names]
    for name, radar in forms.RADARS.items():
        plots = forms.seen(some, radar, seed)
        for form in (*forms.FORMS, forms.SLANT):
            try:
                sides = [forms.tracked(plots, form, **how) for how in ({"filter": "imm"}, {})]
            except ValueError as error:
                print(f"  {name:<6}{form:<30}not tracked: {error}", flush=True)
                continue
            cells = [
                "{:.3f} ± {:.3f}".format(*forms.ratio(sides[1], sides[0], plots, what))
                for what in ("r99", "turn_velocity")
            ]
            lost = [f"{100 * each.lost(plots):.1f}" for each in sides]
            print(f"  {name:<6}{form:<30}{'   '.join(cells)}   lost {' → '.join(lost)} %", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path, nargs="?")
    parser.add_argument("--corrector", type=Path)
    parser.add_argument("--unseen", type=Path, nargs="*", default=[])
    parser.add_argument("--forms", action="store_true")
    parser.add_argument("--seed", type=int, default=21)
    given = parser.parse_args()
    corrector = corrector_of(KIND, given.corrector)
    path = given.flights or fetch_collection()
    print(f"corrector: {corrector.trained.data}, {corrector.trained.method}, seed {corrector.trained.seeds[0]}")
    if not given.unseen:
        some = not_learned(path, corrector)
        names = {each.target for each in some}
        print(f"{path.name}: {len(names)} flights that it has not learned from")
        table(some, path, corrector, given.seed)
        if given.forms:
            in_forms(path, names, given.seed)
    if given.unseen:
        some = [each for file in given.unseen for each in flown(read(str(file), KIND, 0, positions=True).tracks)]
        print(f"{len(given.unseen)} other files, none learned from")
        table(some, None, corrector, given.seed)


if __name__ == "__main__":
    main()
