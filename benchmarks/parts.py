"""The default filter of aircraft on real flights seen by simulated radars, part by part.

    python -m benchmarks.parts [FLIGHTS] [--share 0.01] [--scale 20] [--draws 4] [--half held-out|fitted]
        [--at-once | --cost] [--extent 30000]

Each flight is seen by a radar of its own place: 70 m and .068 degrees every 12 s, 50 m and .06 degrees every 4 s,
heights to 10 m. The radar stands 30 to 120 km from the middle of the flight in a random direction. Of the plots a
share has so many times the noise in range and azimuth. Truth is the local cubic of `benchmarks.flights`. Without
FLIGHTS the quickstart collection is fetched once. With --at-once outliers are decided without hindsight; --cost
prints what hindsight costs in CPU time, one thread. Standard errors are over flights, by the jackknife.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.stats import chi2

from benchmarks.commands import fetch_collection
from benchmarks.flights import SETTLED, Flight, flights, held_out, sampled
from jink import IMM, Position, default_filter
from jink.fit.regimes import PARTS, parts
from jink.models.tracks import Tracks

HEIGHT_SD = 10.0  # m
NEAREST, FARTHEST = 30e3, 120e3  # m, from the radar to the middle of a flight


@dataclass(frozen=True)
class Radar:
    """Period (s) and standard deviations (m, degrees)."""

    name: str
    period: float
    range_sd: float
    azimuth_sd: float


RADARS = (Radar("12 s, 70 m, .068 deg", 12.0, 70.0, 0.068), Radar("4 s, 50 m, .06 deg", 4.0, 50.0, 0.06))


@dataclass(frozen=True)
class Seen:
    """What a radar saw: tracks with their truth, which rows are gross outliers and which part each row is in."""

    tracks: Tracks
    gross: np.ndarray
    part: np.ndarray
    flight: np.ndarray
    settled: np.ndarray


def seen(some: list[Flight], radar: Radar, share: float, scale: float, draws: int, seed: int = 5) -> Seen:
    """Every flight, so many times from so many places."""
    rng = np.random.default_rng(seed)
    rows, owner = [], []
    for draw in range(draws):
        for k, flight in enumerate(some):
            for run in sampled(flight, radar.period, 2 * SETTLED):
                rows.append(_plots(flight, run, radar, share, scale, rng))
                owner.append(k)
        del draw
    time, z, covariance, truth, gross = (np.concatenate(column) for column in zip(*rows, strict=True))
    lengths = [len(row[0]) for row in rows]
    offsets = np.r_[0, np.cumsum(lengths)]
    names = tuple(f"{c}{axis}" for c in "pv" for axis in "xyz")
    tracks = Tracks(time, z, offsets, covariance, truth=truth, components=names, owner=np.array(owner))
    age = np.arange(len(time)) - np.repeat(offsets[:-1], lengths)
    part = parts(tracks, np.zeros(3))
    return Seen(tracks, gross, part, np.array(owner)[tracks.of_row], age >= SETTLED)


def _plots(
    flight: Flight, run: np.ndarray, radar: Radar, share: float, scale: float, rng: np.random.Generator
) -> tuple[np.ndarray, ...]:
    """Time, position, covariance, truth and whether a gross outlier, of each row."""
    truth = np.concatenate([flight.truth[run], flight.velocity[run]], axis=1)
    bearing, distance = rng.uniform(0, 2 * np.pi), rng.uniform(NEAREST, FARTHEST)
    site = truth[:, :2].mean(axis=0) + distance * np.array([np.sin(bearing), np.cos(bearing)])
    line = truth[:, :2] - site
    reach = np.hypot(line[:, 0], line[:, 1])
    along = line / reach[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    sd = np.stack([np.full(len(run), radar.range_sd), np.radians(radar.azimuth_sd) * reach], axis=1)
    gross = rng.random(len(run)) < share
    noise = rng.standard_normal((len(run), 2)) * sd * np.where(gross, scale, 1.0)[:, None]
    z = flight.truth[run].copy()
    z[:, :2] += noise[:, :1] * along + noise[:, 1:] * across
    z[:, 2] += HEIGHT_SD * rng.standard_normal(len(run))
    covariance = np.zeros((len(run), 3, 3))
    for k, axis in enumerate((along, across)):
        covariance[:, :2, :2] += sd[:, k, None, None] ** 2 * axis[:, :, None] * axis[:, None, :]
    covariance[:, 2, 2] = HEIGHT_SD**2
    return flight.time[run], z, covariance, truth, gross


def build(radar: Radar, hindsight: bool = True, extent: float | None = None) -> IMM:
    """The default filter for what such a radar sees; extent (m): of outliers in x and y, if not the kind's."""
    sensor = Position(sd=(radar.range_sd, radar.range_sd, HEIGHT_SD), axes=3)
    default = default_filter("aircraft", sensor, interval=radar.period)
    taken = {name: getattr(default, name) for name in ("initial", "coast", "coasting")}
    outliers = replace(default.outliers, hindsight=hindsight)
    if extent:
        outliers = replace(outliers, extent=(extent, extent, default.outliers.extent[2]))
    return IMM(default.motions, sensor, default.transition, outliers=outliers, **taken)


@dataclass(frozen=True)
class Measured:
    """Of every row: horizontal error of position and velocity, whether the NIS is inside its band, and the status."""

    position: np.ndarray
    velocity: np.ndarray
    inside: np.ndarray
    status: np.ndarray


def measure(filter: Any, data: Seen, verb: str = "filter") -> Measured:
    """Run the filter on all tracks."""
    tracks = data.tracks
    est = getattr(filter, verb)(**tracks.keywords(), outputs=("x", "nis", "nis_dof", "status"))
    off = [
        np.hypot(*(est[f"{c}{axis}"] - tracks.truth[:, 3 * (c == "v") + k] for k, axis in enumerate("xy")))
        for c in "pv"
    ]
    low, high = chi2.ppf([0.025, 0.975], np.maximum(est.nis_dof, 1)[:, None]).T
    inside = np.where(np.isfinite(est.nis), (est.nis >= low) & (est.nis <= high), np.nan)
    return Measured(off[0], off[1], inside, est.status)


def jackknife(group: np.ndarray, of: Callable[[np.ndarray], float], groups: int = 40) -> tuple[float, float]:
    """A statistic of rows and its standard error, flights left out in so many groups."""
    every = np.arange(len(group))
    fold = group % groups
    without = np.array([of(every[fold != g]) for g in np.unique(fold)])
    n = len(without)
    return of(every), float(np.sqrt((n - 1) / n * ((without - without.mean()) ** 2).sum()))


def lines(found: Measured, data: Seen) -> list[str]:
    """The table of one filter on one radar."""
    out = [f"  {'':<11}{'rows':>7}{'RMSE, m':>17}{'R99, m':>15}{'velocity, m/s':>17}{'NIS inside, %':>17}"]
    for name in ("all", *PARTS[:3]):
        rows = data.settled & (data.part >= 0 if name == "all" else data.part == PARTS.index(name))
        e, v, group = found.position[rows], found.velocity[rows], data.flight[rows]
        nis = found.inside[rows & ~data.gross & np.isfinite(found.inside)]
        of_nis = data.flight[rows & ~data.gross & np.isfinite(found.inside)]
        cells = (
            jackknife(group, lambda k, e=e: float(np.sqrt(np.mean(e[k] ** 2)))),
            jackknife(group, lambda k, e=e: float(np.quantile(e[k], 0.99))),
            jackknife(group, lambda k, v=v: float(np.sqrt(np.mean(v[k] ** 2)))),
            jackknife(of_nis, lambda k, nis=nis: 100.0 * float(nis[k].mean())),
        )
        digits = (1, 0, 2, 1)
        row = "".join(f"{a:>10.{d}f} ± {b:<4.{d}f}" for (a, b), d in zip(cells, digits, strict=True))
        out.append(f"  {name:<11}{rows.sum():>7}{row}")
    gross, accepted = data.gross & data.settled, np.isin(found.status, (1,))
    rejected = data.settled & ~data.gross & np.isin(found.status, (3, 4))
    if gross.any():
        square = found.position[data.settled] ** 2
        out.append(
            f"  gross outliers {gross.sum()}: accepted {100 * accepted[gross].mean():.1f} %; "
            f"{100 * gross.sum() / data.settled.sum():.2f} % of the rows make "
            f"{100 * square[data.gross[data.settled]].sum() / square.sum():.1f} % of the squared error"
        )
    restarts = int((found.status[data.settled] == 4).sum())
    out.append(
        f"  others rejected {100 * rejected.sum() / (data.settled & ~data.gross).sum():.3f} %; {restarts} restarts"
    )
    return out


def calm(radar: Radar, tracks: int = 800, rows: int = 200) -> Tracks:
    """Straight flights whose noise is cut at 1.8 sd: no plot is in doubt."""
    rng = np.random.default_rng(0)
    time = radar.period * np.arange(rows)
    z = rng.normal(0.0, 150.0, (tracks, 1, 3)) * time[:, None] * (1.0, 1.0, 0.0)
    z += np.clip(rng.standard_normal(z.shape), -1.8, 1.8) * (radar.range_sd, radar.range_sd, HEIGHT_SD)
    return Tracks(np.tile(time, tracks), z.reshape(-1, 3), np.arange(0, tracks * rows + 1, rows))


def jumpy(radar: Radar, tracks: int = 400, rows: int = 200) -> Tracks:
    """Level flights that change their turn rate every twenty scans or so: most packs have a row in doubt."""
    rng = np.random.default_rng(1)
    heading, speed = rng.uniform(0.0, 2 * np.pi, tracks), rng.uniform(80.0, 250.0, tracks)
    changes = rng.uniform(size=(rows, tracks)) < 0.05
    rates = np.where(rng.uniform(size=(rows, tracks)) < 0.5, 0.0, rng.normal(0.0, 0.06, (rows, tracks)))
    since = np.maximum.accumulate(np.where(changes, np.arange(rows)[:, None], 0), axis=0)
    turned = heading + radar.period * np.cumsum(np.take_along_axis(rates, since, axis=0), axis=0)
    velocity = speed[..., None] * np.stack([np.cos(turned), np.sin(turned), 0 * turned], axis=-1)
    z = radar.period * np.cumsum(velocity, axis=0).swapaxes(0, 1)
    z += rng.standard_normal(z.shape) * (radar.range_sd, radar.range_sd, HEIGHT_SD)
    time = np.tile(radar.period * np.arange(rows), tracks)
    return Tracks(time, z.reshape(-1, 3), np.arange(0, tracks * rows + 1, rows))


def cost(radar: Radar, tracks: Tracks, pairs: int = 9) -> str:
    """CPU time with hindsight over that without: median and quartiles of pairs of runs, side by side."""
    filters = build(radar, hindsight=False), build(radar)
    seconds = np.empty((pairs, 2))
    for k in range(pairs):
        for which in ((0, 1), (1, 0))[k % 2]:
            begin = process_time()
            filters[which].filter(**tracks.keywords(), outputs=("x", "P", "status"), threads=1)
            seconds[k, which] = process_time() - begin
    low, middle, high = np.quantile(seconds[:, 1] / seconds[:, 0], (0.25, 0.5, 0.75))
    return f"{middle:.3f} ({low:.3f} … {high:.3f}) of {1e9 * np.median(seconds[:, 0]) / tracks.rows:.0f} ns a row"


def main() -> None:
    """Print the tables of both radars, with outliers and without."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path, nargs="?")
    parser.add_argument("--share", type=float, default=0.01)
    parser.add_argument("--scale", type=float, default=20.0)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--half", choices=("held-out", "fitted"), default="held-out")
    parser.add_argument("--at-once", action="store_true")
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--extent", type=float, help="m, of outliers as the filter believes; not the kind's")
    given = parser.parse_args()
    known = flights(given.flights or fetch_collection())
    some = [f for f in known if held_out(f) == (given.half == "held-out")]
    print(f"{len(some)} flights, {given.half}; each seen from {given.draws} places")
    for radar in RADARS:
        if given.cost:
            print(f"{radar.name}; none in doubt: {cost(radar, calm(radar))}", flush=True)
            print(f"{radar.name}; targets that jump: {cost(radar, jumpy(radar))}", flush=True)
        for share in (given.share, 0.0) if given.share else (0.0,):
            data = seen(some, radar, share, given.scale, given.draws)
            title = f"{radar.name}; {100 * share:g} % outliers of {given.scale:g} times the noise"
            if given.cost:
                print(f"{title}: {cost(radar, data.tracks)}", flush=True)
                continue
            print(title)
            print("\n".join(lines(measure(build(radar, not given.at_once, given.extent), data), data)), flush=True)


if __name__ == "__main__":
    main()
