"""What a sensor does, from plots without identity: detection, false plots, new targets and noise, by likelihood.

Given the earlier scans, the plots of a scan are those of Bernoulli tracks and of a Poisson process, of false plots and
of targets not seen before (docs/many-targets.md). The search needs no derivative: tracks begin and end by thresholds,
so that the likelihood has small steps.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from ..association.tracker import Tracker
from ..catalogue.choose import load_filter
from ..catalogue.targets import kind_of
from ..checks import Array
from ..frozen import frozen
from ..io.errors import InputError
from ..io.loading import Reading, load_files
from ..models.radar import Radar
from ..tracking.anonymous import beliefs_of
from ..tracking.anonymous_options import Anonymous
from ..tracking.anonymous_rows import placed_plots, scans_of
from ..tracking.placing import Placed
from ..tracking.prepare import Pace, Settings, choose
from .parameters import Parameters

FITTED = 2 / 3  # of the scans; the rest is held out
FEWEST = 20  # scans that tell anything
FIRST_STEP = 0.3  # of the simplex, on the scale of the search (logarithms, logits)
CLOSE = 0.02  # nats: the simplex is small enough
STEP = 0.15  # of the differences that the curvature is made of
MOST = 500  # evaluations

Progress = Callable[[str, int, int], None]


class _Stop(Exception):
    """The time is over."""


@frozen
class SkyFit:
    """parameters: of each its name, value before and after, and 95 % interval (None: unknown), in its own units.

    filter: with the fitted noise. before, after: log-likelihood per scan, of the scans fitted on and of those held out.
    """

    name: str
    training: str
    filter: Any
    parameters: list[dict[str, Any]]
    before: tuple[float, float]
    after: tuple[float, float]
    evaluations: int
    seconds: float
    partial: bool
    interrupted: bool
    kind: str

    @property
    def values(self) -> dict[str, float]:
        """The fitted values by name."""
        return {row["parameter"]: row["after"] for row in self.parameters}

    @property
    def gain(self) -> bool:
        """Are the scans held out likelier than before?"""
        return self.after[1] > self.before[1]

    def options(self) -> str:
        """What `jink track` is told to use it."""
        v = self.values
        sds = ",".join(f"{name[:-3]}={value:.5g}" for name, value in v.items() if name in self.noises)
        words = f"--sensor-sd {sds} --detection {v['detection']:.3g} --clutter {v['clutter']:.4g}"
        return f"{words} --new-per-hour {v['new_per_hour']:.4g}"

    @property
    def noises(self) -> list[str]:
        """Names of the sensor's standard deviations."""
        return [row["parameter"] for row in self.parameters if row["parameter"].endswith("_sd") and row["sensor"]]

    def save(self, path: str | Path) -> None:
        """Write the filter, with what was fitted, for ``jink track --filter``."""
        fitted = {"objective": "likelihood of plots without identity", "parameters": self.parameters}
        self.filter.save(path, fitted={"scenario": self.training, "kind": self.kind, **fitted})

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, as ``--json`` writes them."""
        names = ("training", "filter", "parameters", "gain", "partial", "evaluations", "seconds")
        body = {name: getattr(self, name) for name in names} | {"filter": self.name}
        for name in ("before", "after"):
            body[name] = dict(zip(("fitted", "held_out"), getattr(self, name), strict=True))
        return body | {"objective": "likelihood", "options": self.options()}


@frozen
class _Sky:
    """The plots in scans, and what makes a tracker of parameters."""

    plots: Placed
    begin: np.ndarray
    time: np.ndarray
    own: np.ndarray | None
    area: tuple[float, float, float, float]
    settings: Settings
    how: Anonymous
    targets: float
    interval: float
    free: tuple[str, ...]

    def parameters(self, values: Mapping[str, float]) -> Parameters | None:
        """The filter's own numbers that are fitted too, at this noise."""
        if not self.free:
            return None
        return Parameters(self.filter(values, None), free=self.free, fixed=("*",))

    def filter(self, values: Mapping[str, float], own: Array | None) -> Any:
        """The filter at these values."""
        sd = {name[:-3]: value for name, value in values.items() if name.endswith("_sd")}
        pace = Pace.of(self.interval, self.settings)
        _, filter = choose(self.plots.components, sd, pace, self.settings, corrected=False)
        if own is None:
            return filter
        return Parameters(filter, free=self.free, fixed=("*",)).filter(own)

    def log_likelihoods(self, values: Mapping[str, float], own: Array | None, scans: int) -> Array:
        """Of each of the first scans."""
        radar = Radar(
            detection=values["detection"],
            clutter_per_scan=values["clutter"],
            area=self.area,
            learn_clutter=False,
            learn_detection=False,
        )
        tracker = Tracker(
            self.filter(values, own),
            radar,
            new_per_hour=values["new_per_hour"],
            targets=self.targets,
            drop_after=self.how.drop_after,
            speed_sd=kind_of(self.settings.kind).speed / 2,
            report=1 - 1e-9,
        )
        unpruned(tracker.rules)
        tracker.reset()
        own_times = self.own
        out = np.zeros(scans)
        for k in range(scans):
            rows = slice(int(self.begin[k]), int(self.begin[k + 1]))
            times = None if own_times is None else own_times[rows]
            picture = tracker.scan(float(self.time[k]), self.plots.z[rows], times=times)
            out[k] = picture.report["log_likelihood"]
        return out


def unpruned(rules: Any) -> None:
    """Rules that report the likelihood, and drop next to no track: each that is dropped takes some of it away."""
    rules.likelihood = True
    rules.drop, rules.patience, rules.unclaimed, rules.crowd = 1e-3, 1e-3, 1e-6, 1000


def fit_sky(
    data: str,
    filter: Any = "imm",
    *,
    free: Sequence[str] = (),
    fixed: Sequence[str] = (),
    period: float | None = None,
    kind: str = "aircraft",
    columns: Mapping[str, str] | None = None,
    minutes: float | None = None,
    progress: Progress | None = None,
) -> SkyFit:
    """Detection probability, false plots per scan, new targets per hour and noise of a file of plots without identity.

    fixed: patterns of these names that stay at what the tracks say; free: patterns of the filter's own numbers that are
    fitted too. period (s) of a scan, where every plot has its own time. The first two thirds of the scans are fitted
    on, the rest is held out. Ctrl-C and minutes keep the best so far. Errors: InputError (a ValueError).
    """
    began = clock.perf_counter()
    chosen = load_filter(filter) if isinstance(filter, str) else filter
    settings = Settings(kind=kind, filter=chosen, threads=1)
    how = Anonymous(period=period, sectors=1)
    plots = placed_plots(load_files([data], Reading(columns)).measurements, None)
    # whole turns: sectors have no likelihood of their own
    scans = scans_of(plots, period, 1)
    begin, time = scans.begin, scans.time
    if len(time) < FEWEST:
        raise InputError(f"{data}: {len(time)} scans are too few to fit; expected at least {FEWEST}")
    interval = float(np.median(np.diff(time)))
    believed, clutter = beliefs_of(plots, scans, settings, how)
    low, high = plots.plane.min(axis=0), plots.plane.max(axis=0)
    box = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
    sky = _Sky(plots, begin, time, scans.own, box, settings, how, believed.targets or 0.5, interval, tuple(free))
    values = {
        "detection": min(max(believed.detection, 0.05), 0.99),
        "clutter": max(clutter, 0.05),
        "new_per_hour": max(believed.new_per_hour or 1.0, 0.1),
        **{f"{name}_sd": value for name, value in believed.sd.items()},
    }
    search = _Search(sky, values, fixed, minutes, progress)
    search.run()
    return search.result(data, filter if isinstance(filter, str) else type(filter).__name__, began)


class _Search:
    """Nelder and Mead's simplex over logarithms and the logit of the detection probability."""

    def __init__(
        self,
        sky: _Sky,
        values: dict[str, float],
        fixed: Sequence[str],
        minutes: float | None,
        progress: Progress | None,
    ) -> None:
        self.sky, self.start, self.progress = sky, values, progress
        self.own = sky.parameters(values)
        known = [*values, *(self.own.names if self.own else ())]
        for pattern in fixed:
            if not any(fnmatchcase(name, pattern) for name in known):
                raise InputError(f"fix: no parameter {pattern!r}; expected some of {', '.join(known)}")
        self.names = [n for n in values if not any(fnmatchcase(n, pattern) for pattern in fixed)]
        own = self.own.start if self.own else np.zeros(0)
        self.u0 = np.r_[[_scaled(n, values[n]) for n in self.names], own]
        if not len(self.u0):
            raise InputError("fix: no parameter is left to fit")
        self.scans = round(FITTED * len(sky.time))
        self.deadline = math.inf if minutes is None else clock.monotonic() + 60.0 * minutes
        self.evaluations, self.partial, self.interrupted = 0, False, False
        self.best, self.least = self.u0, math.inf

    def at(self, u: Array) -> tuple[dict[str, float], Array | None]:
        """The values at u, and the filter's own numbers."""
        n = len(self.names)
        values = self.start | {name: _plain(name, value) for name, value in zip(self.names, u[:n], strict=True)}
        return values, (u[n:] if self.own else None)

    def value(self, u: Array) -> float:
        """Minus the log-likelihood of the scans fitted on."""
        if clock.monotonic() > self.deadline:
            raise _Stop
        self.evaluations += 1
        values, own = self.at(u)
        found = -float(self.sky.log_likelihoods(values, own, self.scans).sum()) - self._prior(values)
        found = found if math.isfinite(found) else 1e300
        if found < self.least:
            self.best, self.least = u.copy(), found
        if self.progress:
            self.progress(f"log-likelihood {-self.least:,.1f} after {self.evaluations} evaluations", 0, 0)
        return found

    def _prior(self, values: Mapping[str, float]) -> float:
        """Half a target and half a false plot more than were seen, so that neither is ever impossible."""
        hours = float(self.sky.time[self.scans - 1] - self.sky.time[0]) / 3600.0
        return 0.5 * math.log(values["new_per_hour"] * hours) + 0.5 * math.log(values["clutter"] * self.scans)

    def run(self) -> None:
        """Twice, the second time from a new simplex around the best."""
        from scipy.optimize import minimize

        try:
            for width in (FIRST_STEP, FIRST_STEP / 3):
                simplex = np.vstack([self.best, self.best + width * np.eye(len(self.u0))])
                options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": CLOSE, "maxfev": MOST}
                minimize(self.value, self.best, method="Nelder-Mead", options=options)
        except _Stop:
            self.partial = True
        except KeyboardInterrupt:
            self.partial = self.interrupted = True
        if not math.isfinite(self.least):
            raise InputError("minutes: the time was over before there was anything to keep")

    def sd(self) -> Array:
        """Of u, from the curvature of the log-likelihood; NaN where it has none."""
        n, h = len(self.u0), STEP
        if self.partial:
            return np.full(n, np.nan)
        centre, eye = self.best.copy(), h * np.eye(n)
        middle = self.value(centre)
        curved = np.zeros((n, n))
        for a in range(n):
            for b in range(a):
                signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
                curved[a, b] = curved[b, a] = sum(
                    s * t * self.value(centre + s * eye[a] + t * eye[b]) for s, t in signs
                ) / (4 * h * h)
            curved[a, a] = (self.value(centre + eye[a]) + self.value(centre - eye[a]) - 2 * middle) / (h * h)
        try:
            np.linalg.cholesky(curved)
        except np.linalg.LinAlgError:
            one = np.diagonal(curved)
            return np.where(one > 0, 1 / np.sqrt(np.maximum(one, 1e-300)), np.nan)
        return np.sqrt(np.diagonal(np.linalg.inv(curved)))

    def result(self, data: str, name: str, began: float) -> SkyFit:
        """Checked on the scans held out."""
        sd = self.sd()
        whole = len(self.sky.time)
        before, after = (self.sky.log_likelihoods(*self.at(u), whole) for u in (self.u0, self.best))
        shares = [tuple(float(part.mean()) for part in np.split(each, [self.scans])) for each in (before, after)]
        values, own = self.at(self.best)
        count = f"{whole:,} scans, {self.sky.plots.rows.height:,} plots of {data}"
        return SkyFit(
            name=name,
            training=count,
            filter=self.sky.filter(values, own),
            parameters=self._table(sd),
            before=(shares[0][0], shares[0][1]),
            after=(shares[1][0], shares[1][1]),
            evaluations=self.evaluations,
            seconds=clock.perf_counter() - began,
            partial=self.partial,
            interrupted=self.interrupted,
            kind=self.sky.settings.kind,
        )

    def _table(self, sd: Array) -> list[dict[str, Any]]:
        ends = [
            self._every(u)
            for u in (self.u0, self.best, self.best - 1.96 * np.nan_to_num(sd), self.best + 1.96 * np.nan_to_num(sd))
        ]
        fitted = [*self.names, *(self.own.names if self.own else ())]
        known = dict(zip(fitted, np.isfinite(sd), strict=True))
        rows = []
        for name in ends[0]:
            before, after, low, high = (end[name] for end in ends)
            interval = {"low": low, "high": high} if known.get(name) else {"low": None, "high": None}
            sensor = name in self.start
            rows.append({"parameter": name, "before": before, "after": after, **interval, "sensor": sensor})
        return rows

    def _every(self, u: Array) -> dict[str, float]:
        values, own = self.at(u)
        if own is None:
            return values
        return values | Parameters(self.sky.filter(values, None), free=self.sky.free, fixed=("*",)).values(own)


def _scaled(name: str, value: float) -> float:
    return math.log(value / (1 - value)) if name == "detection" else math.log(value)


def _plain(name: str, u: float) -> float:
    if name == "detection":
        return min(max(1 / (1 + math.exp(-min(max(u, -30.0), 30.0))), 1e-3), 1 - 1e-3)
    return math.exp(min(max(u, -60.0), 60.0))
