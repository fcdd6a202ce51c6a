"""The same plots of real flights in every form that a table can have, and against a tuned rival.

    python -m benchmarks.forms [FLIGHTS] [--flights 30] [--seed 7]     (without FLIGHTS the quickstart collection)

Flights that neither the default nor its correction was fitted on (truth: the local cubic of `benchmarks.flights`) are
seen by a radar of their own place, 30 to 120 km from their middle: 70 m and .068 degrees every 12 s, 50 m and .06
degrees every 4 s, 15 m and .06 degrees every second; heights to 10 m; 1 % of the plots with 20 times the noise in range
and azimuth. Each plot is written as range, azimuth and height, as x, y and z, and as latitude, longitude and height,
and tracked as `jink track` does without being told a noise. The rival is a CV + CT IMM that knows the true noise, with
eight numbers fitted by likelihood on other flights. R99: RMSE of the horizontal position without the worst 1 %. Turn
velocity: RMSE where the flight truly pulls .15 g. Lost: share of flights more than 1 km off, or without an estimate, in
five scans one after the other. Standard errors are over flights, by the jackknife. The last lines are of plots without
heights: with heights of the kind, as `jink track` takes slant ranges, and taken for ranges along the ground.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from scipy.optimize import minimize

import jink
from benchmarks.commands import fetch_collection
from benchmarks.corrector import corrector_of, not_learned
from benchmarks.flights import SETTLED, Flight, flights, held_out, sampled
from jink.io.geodesy import SiteFrame

GRAVITY, TURNING = 9.80665, 0.15
HEIGHT_SD, SHARE, SCALE, FAR, FIVE = 10.0, 0.01, 20.0, 1000.0, 5
NEAREST, FARTHEST = 30e3, 120e3
SITE = SiteFrame(48.0, 9.0)
RADARS = {"12 s": (12.0, 70.0, 0.068), "4 s": (4.0, 50.0, 0.06), "1 s": (1.0, 15.0, 0.06)}
FORMS = ("range, azimuth, height", "x, y, z", "latitude, longitude, height")
SLANT = "slant range, azimuth"
HEIGHTS: dict[str, dict[str, Any]] = {"heights of the kind": {}, "along the ground": {"target_height": "ground"}}
WAYS: dict[str, dict[str, Any]] = {"lag of one scan": {"lag": 1}, "smoothed": {"smooth": True}}


@dataclass(frozen=True)
class Plots:
    """Plots of one radar: target, time, measured and true quantities, row by row, and the number of each flight."""

    table: pl.DataFrame
    flight: np.ndarray
    scored: np.ndarray
    turning: np.ndarray

    def form(self, name: str) -> pl.DataFrame:
        """The table in one form."""
        columns = {
            FORMS[0]: ("range", "azimuth_deg", "altitude_m"),
            FORMS[1]: ("x", "y", "z"),
            FORMS[2]: ("latitude", "longitude", "altitude_m"),
            SLANT: ("slant_range", "azimuth_deg"),
        }
        table = self.table.with_columns(slant_range=pl.col("range"))
        return table.select("target", "time", *columns[name])


def plane_height(x: np.ndarray, y: np.ndarray, altitude: np.ndarray) -> np.ndarray:
    """Height above the radar's plane of a height above the sphere that touches it."""
    radius = SITE.earth_radius
    return np.sqrt((radius + altitude) ** 2 - x**2 - y**2) - radius


def seen(some: list[Flight], radar: tuple[float, float, float], seed: int) -> Plots:
    """Every flight once, by a radar at a random place."""
    rng, tables, number = np.random.default_rng(seed), [], []
    for k, flight in enumerate(some):
        for part, run in enumerate(sampled(flight, radar[0], 3 * SETTLED)):
            tables.append(_table(f"{k:03}.{part}", flight, run, radar, rng))
            number.append(np.full(len(run), k))
    table = pl.concat(tables)
    age = np.concatenate([np.arange(each.height) for each in tables])
    settled = age >= SETTLED
    return Plots(table, np.concatenate(number), settled, settled & (table["pull"].to_numpy() > TURNING))


def _table(
    name: str, flight: Flight, run: np.ndarray, radar: tuple[float, float, float], rng: np.random.Generator
) -> pl.DataFrame:
    _, range_sd, azimuth_sd = radar
    place, count = flight.truth[run], len(run)
    bearing, distance = rng.uniform(0, 2 * np.pi), rng.uniform(NEAREST, FARTHEST)
    x, y = (place[:, :2] - place[:, :2].mean(axis=0) + distance * np.array([np.sin(bearing), np.cos(bearing)])).T
    z = plane_height(x, y, place[:, 2])
    gross = np.where(rng.random(count) < SHARE, SCALE, 1.0)
    reach = np.sqrt(x**2 + y**2 + z**2) + range_sd * gross * rng.standard_normal(count)
    azimuth = np.arctan2(x, y) + np.radians(azimuth_sd) * gross * rng.standard_normal(count)
    altitude = place[:, 2] + HEIGHT_SD * rng.standard_normal(count)
    seen_x, seen_y, seen_z = _in_the_plane(reach, azimuth, altitude)
    latitude, longitude, _, _ = SITE.to_geographic(seen_x, seen_y, seen_z)
    true = SITE.to_geographic(x, y, z)
    columns = {"time": flight.time[run], "range": reach, "azimuth_deg": np.degrees(azimuth) % 360.0}
    columns |= {"altitude_m": altitude, "x": seen_x, "y": seen_y, "z": seen_z}
    columns |= {"latitude": latitude, "longitude": longitude, "true_x": x, "true_y": y}
    columns |= {"true_latitude": true[0], "true_longitude": true[1], "convergence": true[2]}
    columns |= {"true_vx": flight.velocity[run, 0], "true_vy": flight.velocity[run, 1]}
    columns["pull"] = np.hypot(*flight.acceleration[run, :2].T) / GRAVITY
    return pl.DataFrame({"target": [name] * count, **columns})


def _in_the_plane(reach: np.ndarray, azimuth: np.ndarray, altitude: np.ndarray) -> tuple[np.ndarray, ...]:
    """x, y and z of slant range, azimuth and height above the sphere."""
    z = altitude
    for _ in range(6):
        ground = np.sqrt(np.maximum(reach**2 - z**2, 0.0))
        x, y = ground * np.sin(azimuth), ground * np.cos(azimuth)
        z = plane_height(x, y, altitude)
    return x, y, z


@dataclass(frozen=True)
class Errors:
    """Of each plot, NaN without an estimate: horizontal error of position (m) and of velocity (m/s)."""

    position: np.ndarray
    velocity: np.ndarray

    def r99(self, rows: np.ndarray) -> float:
        """RMSE of positions without the worst 1 %."""
        square = np.sort(self.position[rows & np.isfinite(self.position)] ** 2)
        return float(np.sqrt(square[: int(0.99 * square.size)].mean()))

    def turn_velocity(self, rows: np.ndarray) -> float:
        """RMSE of velocities."""
        return float(np.sqrt(np.nanmean(self.velocity[rows] ** 2)))

    def lost(self, plots: Plots) -> float:
        """Share of flights that are far off, or have no estimate, for five scans."""
        far = ~(self.position < FAR) & plots.scored
        target = plots.table["target"].to_numpy()
        windows = np.lib.stride_tricks.sliding_window_view(far, FIVE).all(axis=1)
        gone = windows & (target[: 1 - FIVE] == target[FIVE - 1 :])
        return float(np.unique(plots.flight[: 1 - FIVE][gone]).size / np.unique(plots.flight).size)


def tracked(plots: Plots, form: str, **how: Any) -> Errors:
    """What `jink.track` makes of one form."""
    done = jink.track(plots.form(form), site=(SITE.latitude, SITE.longitude, 0.0), details=True, **how)
    found = (
        plots.table.with_row_index("row")
        .select("row")
        .join(done.tracks.with_columns(pl.col("row").cast(pl.UInt32)), on="row", how="left", maintain_order="left")
    )
    table = plots.table

    def of(frame: pl.DataFrame, name: str) -> np.ndarray:
        return frame[name].cast(pl.Float64).fill_null(np.nan).to_numpy()

    true_v = of(table, "true_vx"), of(table, "true_vy")
    if form != FORMS[2]:
        off = np.hypot(of(found, "x") - of(table, "true_x"), of(found, "y") - of(table, "true_y"))
        return Errors(off, np.hypot(of(found, "velocity_x") - true_v[0], of(found, "velocity_y") - true_v[1]))
    latitude = np.radians(of(table, "true_latitude"))
    north = np.radians(of(found, "latitude")) - latitude
    east = (np.radians(of(found, "longitude")) - np.radians(of(table, "true_longitude"))) * np.cos(latitude)
    # a degree is as long as on the sphere that fits the site, to a few thousandths of the error
    off = SITE.earth_radius * np.hypot(north, east)
    course = np.arctan2(*true_v) + of(table, "convergence")
    speed, found_course = np.hypot(*true_v), of(found, "course")
    across = of(found, "speed") * np.sin(found_course) - speed * np.sin(course)
    along = of(found, "speed") * np.cos(found_course) - speed * np.cos(course)
    return Errors(off, np.hypot(across, along))


class Rival:
    """A CV + CT IMM on range, azimuth and height of the true noise, fitted on other plots."""

    start = np.log10([0.02, 0.01, 1.0, 0.1, 1e-6, 0.02, 60.0, 30.0])

    def __init__(self, radar: tuple[float, float, float], plots: Plots) -> None:
        self.sensor = jink.Polar(
            range_sd=radar[1],
            azimuth_sd=np.radians(radar[2]),
            height_sd=HEIGHT_SD,
            earth_radius=SITE.earth_radius,
        )
        self.interval = radar[0]
        batch = self._batch(plots)
        options = {"maxfev": 240, "xatol": 0.02, "fatol": 1e-4}
        found = minimize(lambda p: self._loss(p, batch), self.start, method="Nelder-Mead", options=options)
        self.filter = self._made(found.x)

    def _made(self, p: np.ndarray) -> Any:
        q, up, turn_q, turn_up, rate, prior, straight, turning = 10.0 ** np.clip(p, -8, 4)
        motions = [
            jink.ConstantVelocity(acceleration_psd=(q, q, up)),
            jink.CoordinatedTurn(
                acceleration_psd=(turn_q, turn_q, turn_up), turn_rate_psd=rate, turn_rate_prior_sd=prior
            ),
        ]
        usual = jink.default_filter("aircraft", self.sensor, interval=self.interval)
        return jink.IMM(
            motions, self.sensor, jink.Sojourn([straight, turning]), outliers=usual.outliers, initial=usual.initial
        )

    def _batch(self, plots: Plots) -> dict[str, np.ndarray]:
        table = plots.table
        z = table.select("range", pl.col("azimuth_deg").radians(), "altitude_m").to_numpy()
        new = (table["target"] != table["target"].shift(1)).fill_null(True).to_numpy()
        time = table["time"].to_numpy()
        return {"time": time, "z": np.ascontiguousarray(z), "offsets": np.r_[np.flatnonzero(new), new.size]}

    def _loss(self, p: np.ndarray, batch: dict[str, np.ndarray]) -> float:
        try:
            found = self._made(p).filter(**batch, outputs=("log_likelihood_scan", "status"))
        except ValueError:
            return 1e9
        return -float(found.log_likelihood_scan[found.scored].mean())

    def errors(self, plots: Plots) -> Errors:
        """Of its filtered estimates."""
        found = self.filter.filter(**self._batch(plots), outputs=("x",))
        true = {name: plots.table[f"true_{name}"].to_numpy() for name in ("x", "y", "vx", "vy")}
        place = np.hypot(found["px"] - true["x"], found["py"] - true["y"])
        return Errors(place, np.hypot(found["vx"] - true["vx"], found["vy"] - true["vy"]))


def ratio(one: Errors, other: Errors, plots: Plots, figure: str) -> tuple[float, float]:
    """A figure of one over that of the other, on the rows that both have, and its standard error over flights."""
    rows = (plots.turning if figure == "turn_velocity" else plots.scored).copy()
    rows &= np.isfinite(one.position) & np.isfinite(other.position)

    def of(keep: np.ndarray) -> float:
        return getattr(one, figure)(rows & keep) / getattr(other, figure)(rows & keep)

    every = np.unique(plots.flight)
    without = np.array([of(plots.flight != k) for k in every])
    n = len(every)
    return of(np.ones(rows.size, bool)), float(np.sqrt((n - 1) / n * ((without - without.mean()) ** 2).sum()))


def measured(name: str, some: list[Flight], others: list[Flight], seed: int) -> list[str]:
    """The lines of one radar."""
    radar = RADARS[name]
    plots, training = seen(some, radar, seed), seen(others, radar, seed + 1)
    forms = {form: tracked(plots, form) for form in FORMS}
    first, rival = forms[FORMS[0]], Rival(radar, training).errors(plots)
    flown = len(np.unique(plots.flight))
    out = [f"{name}, {radar[1]:g} m, {radar[2]:g} degrees: {flown} flights, {plots.scored.sum()} plots"]
    out.append(f"  {'':<28}{'R99, m':>8}{'turn velocity, m/s':>20}{'lost, %':>9}")
    for words, each in (*forms.items(), ("tuned CV + CT", rival)):
        figures = each.r99(plots.scored), each.turn_velocity(plots.turning), 100 * each.lost(plots)
        wanted = "" if words.startswith("tuned") else _judged(figures[2] <= 0.0)
        out.append(f"  {words:<28}{figures[0]:>8.1f}{figures[1]:>20.2f}{figures[2]:>9.2f}  {wanted}")
    for form in FORMS[1:]:
        value, se = ratio(forms[form], first, plots, "r99")
        near = _judged(abs(value - 1.0) <= 0.02)
        out.append(f"  R99 of {form} over range's: {value:.3f} ± {se:.3f}, wanted .98 to 1.02: {near}")
    for figure, most in (("r99", 0.97), ("turn_velocity", 0.92)):
        value, se = ratio(first, rival, plots, figure)
        words = figure.replace("_", " ").replace("r99", "R99")
        out.append(
            f"  {words} over the rival's: {value:.3f} ± {se:.3f}, wanted {most:g} at most: {_judged(value <= most)}"
        )
    plain = tracked(plots, FORMS[0], filter="imm")
    for (words, how), most in zip(WAYS.items(), (0.72, 0.65), strict=True):
        value, se = ratio(tracked(plots, FORMS[0], **how), plain, plots, "r99")
        said = f"R99 {words} over filtered without a correction: {value:.3f} ± {se:.3f}"
        out.append(f"  {said}, wanted {most:g} at most: {_judged(value <= most)}")
    for words, how in HEIGHTS.items():
        each = tracked(plots, SLANT, **how)
        rows = plots.scored & np.isfinite(each.position)
        whole = float(np.sqrt(np.mean(each.position[rows] ** 2)))
        figures = (
            f"RMSE {whole:.0f} m, R99 {each.r99(plots.scored):.0f} m, median {np.median(each.position[rows]):.0f} m"
        )
        out.append(f"  no heights, {words}: {figures}, lost {100 * each.lost(plots):.1f} %")
    return out


def _judged(good: bool) -> str:
    return "reached" if good else "MISSED"


def main() -> None:
    """Print what every radar shows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path, nargs="?")
    parser.add_argument("--flights", dest="count", type=int, default=30, help="of each half, drawn by the seed")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    path, rng = given.flights or fetch_collection(), np.random.default_rng(given.seed)
    known, unseen = flights(path), {each.target for each in not_learned(path, corrector_of("aircraft"))}
    halves = []
    for wanted in (True, False):
        half = [f for f in known if held_out(f) == wanted and (f.target in unseen or not wanted)]
        halves.append([half[k] for k in sorted(rng.permutation(len(half))[: given.count])])
    for name in RADARS:
        print("\n".join(measured(name, *halves, given.seed)), flush=True)


if __name__ == "__main__":
    main()
