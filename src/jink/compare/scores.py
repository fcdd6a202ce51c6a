"""What is kept of the runs: sums over scans, run by run, in bounded memory; and the figures they give.

Runs beyond GROUPS share a place (run modulo GROUPS): a group of runs is then what a run was, and the spread
over groups gives the standard error. Up to GROUPS runs the figures are those of :mod:`jink.metrics`, digit by digit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..checks import Array
from ..metrics import Comparison, Figure, paired
from ..metrics.chi_square import band
from ..metrics.errors import sum_of_squares
from ..metrics.figure import jackknife, ratio_influence, spread
from ..scenarios import Simulation
from .adding import Stores, add_at, undo
from .estimates import Answer
from .mahalanobis import mahalanobis

JACKKNIFE = 20  # groups of runs for the standard error of quantiles
GROUPS = 1000  # for sums over scans
SCAN_GROUPS = 100  # for sums scan by scan
ROOTS = (
    "position_rmse",
    "velocity_rmse",
    "acceleration_rmse",
    "position_rmse_where_measured",
    "prediction_rmse",
)
SHORTEST, WIDTH, BINS = 1e-3, 2e-3, 11_500  # of distances (m): bins of 0.2% up to 9,700 km
NAN = Figure(math.nan, math.nan)


def part(values: Array) -> tuple[Array, Array]:
    """Sum of what is there, and how much that is, over scans: (B, S) to (B,) each."""
    there = np.isfinite(values)
    return np.where(there, values, 0.0).sum(axis=1), there.sum(axis=1).astype(float)


def scored(answer: Answer, simulation: Simulation, raw: Answer | None, first: int) -> dict[str, Array]:
    """Every run's squared errors, log scores, … scan by scan, (B, S − first); NaN where there is none."""
    truth = simulation.truth
    axes = answer.position.shape[2]
    errors = {
        name: value - getattr(truth, name)[..., : value.shape[2]]
        for name in ("position", "velocity", "acceleration")
        if (value := getattr(answer, name)) is not None
    }
    out = {f"{name}_rmse": sum_of_squares(e) for name, e in errors.items()}
    out["mean_euclidean"] = np.sqrt(out["position_rmse"])
    if raw is not None:
        seen = np.isfinite(raw.position).all(axis=2)
        out["position_rmse_where_measured"] = np.where(seen, out["position_rmse"], np.nan)
    if answer.blocks:
        stacked = np.concatenate([errors["position"], errors["velocity"]], axis=2)
        parts = [mahalanobis(stacked[..., list(b.columns)], b.P, b.index) for b in answer.blocks]
        square, log_det = (np.sum(each, axis=0) for each in zip(*parts, strict=True))
        out["nees"] = square / (2 * axes)
        out["nees_inside"] = inside(square, np.full(square.shape, 2 * axes))
        out["log_score"] = -0.5 * (square + log_det + 2 * axes * math.log(2 * math.pi))
    if answer.nis is not None and answer.nis_dof is not None:
        dof = np.where(np.isfinite(answer.nis), answer.nis_dof, 0)
        with np.errstate(invalid="ignore", divide="ignore"):
            out["nis"] = np.where(dof > 0, answer.nis / dof, np.nan)
        out["nis_inside"] = inside(answer.nis, dof)
    if answer.log_likelihood is not None:
        out["prediction_score"] = answer.log_likelihood
    return {name: values[:, first:] for name, values in out.items()}


def inside(square: Array, dof: Array) -> Array:
    """1 where the square lies in its central 95% interval, 0 outside, NaN where there is none."""
    whole = np.rint(np.where(np.isfinite(dof), dof, 0)).astype(int)
    whole = np.where(np.isfinite(square), np.maximum(whole, 0), 0)
    there = np.flatnonzero(np.bincount(whole.ravel(), minlength=1)[1:]) + 1
    low, high = np.full((2, whole.max(initial=0) + 1), np.nan)
    for k in there:
        low[k], high[k] = band(int(k))
    held = (square >= low[whole]) & (square <= high[whole])
    return np.where(whole > 0, held, np.nan)


@dataclass
class Tally:
    """Sums of one filter: `totals` and `counts` (groups,) by metric; `curves` (groups, scans) for what is
    averaged scan by scan; `responses` (JACKKNIFE, scans around an event) after manoeuvre onsets and ends."""

    groups: int = GROUPS
    scan_groups: int = SCAN_GROUPS
    totals: dict[str, Array] = field(default_factory=dict)
    counts: dict[str, Array] = field(default_factory=dict)
    curves: dict[str, Array] = field(default_factory=dict)
    responses: dict[str, Array] = field(default_factory=dict)
    bins: Array = field(default_factory=lambda: np.zeros((JACKKNIFE, BINS)))
    costs: list[tuple[float, int]] = field(default_factory=list)
    runs: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        self.runs = np.zeros(self.groups)

    def add(self, runs: np.ndarray, name: str, total: Array, count: Array) -> None:
        """Sums (B,) of the runs with these numbers."""
        for store, values in ((self.totals, total), (self.counts, count)):
            add_at(_of(store, name, self.groups), runs, values)

    def add_curve(self, runs: np.ndarray, name: str, values: Array) -> None:
        """Values (B, S) of the runs with these numbers."""
        add_at(_of(self.curves, name, self.scan_groups, values.shape[1]), runs, values)

    def add_response(self, runs: np.ndarray, name: str, values: Array) -> None:
        """Values (n, …), each of the run with this number; a run may come several times or not at all."""
        add_at(_of(self.responses, name, JACKKNIFE, *values.shape[1:]), runs, values)

    def before(self, runs: np.ndarray) -> Callable[[], None]:
        """What takes back all that is added for these runs from now on."""
        stores: Stores = [self.totals, self.counts, self.curves, self.responses, {"": self.bins}, {"": self.runs}]
        return undo(stores, runs, self.costs)

    def add_distances(self, runs: np.ndarray, values: Array) -> None:
        """Position errors (B, S) in m, NaN where there is none, into their bins."""
        there = np.isfinite(values)
        group = np.broadcast_to((runs % JACKKNIFE)[:, None], values.shape)[there]
        steps = np.log(np.maximum(values[there], SHORTEST) / SHORTEST) / WIDTH
        place = np.minimum(steps.astype(int), BINS - 1)
        self.bins += np.bincount(group * BINS + place, minlength=self.bins.size).reshape(self.bins.shape)

    def quantile(self, q: float) -> Figure:
        """Quantile of the position error (m), as :func:`jink.metrics.quantile` to two parts in a thousand."""
        used = self.bins[self.bins.any(axis=1)]
        if not len(used):
            return NAN
        return jackknife(lambda bins: _quantile(bins.sum(axis=0), q), used, groups=JACKKNIFE)

    def over_time(self, quantity: str) -> tuple[Array, Array]:
        """RMSE of position, velocity or acceleration in every scan that counts, and its standard error; both
        (scans,).
        """
        square, count = (self.curves[f"{quantity}_{each}"] for each in ("square", "there"))
        kept = self.curves["runs"][:, 0] > 0
        columns = zip(square[kept].T, count[kept].T, strict=True)
        found = [ratio_influence(total, number) for total, number in columns]
        value = np.sqrt([each for each, _ in found])
        with np.errstate(invalid="ignore", divide="ignore"):
            return value, np.array([spread(influence) for _, influence in found]) / (2 * value)

    def normalised_over_time(self, quantity: str) -> Array:
        """RMS error of position or velocity over that of the measurements in every scan that counts, (scans,)."""
        error, noise = (self.curves[f"{quantity}_{each}"].sum(axis=0) for each in ("error", "noise"))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.sqrt(error / noise)

    def influence(self, name: str) -> tuple[float, Array]:
        """The figure and each group's influence on it, (groups that had a run,)."""
        if name.startswith("normalised_"):
            return self._normalised(name.removeprefix("normalised_"))
        if name not in self.totals:
            return math.nan, np.full(int((self.runs > 0).sum()), math.nan)
        used = self.runs > 0
        value, influence = ratio_influence(self.totals[name][used], self.counts[name][used])
        if name not in ROOTS:
            return value, influence
        root = math.sqrt(value) if value >= 0 else math.nan
        return root, influence / (2 * root) if root > 0 else np.zeros_like(influence)

    def figure(self, name: str) -> Figure:
        """A metric with its standard error."""
        value, influence = self.influence(name)
        if name == "lost" and not math.isnan(value):
            return Figure(value, math.sqrt(value * (1 - value) / self.runs.sum()))
        return Figure(value, spread(influence) if math.isfinite(value) else math.nan)

    def normalised(self, quantity: str) -> Figure:
        """lee-2003's ζ, as :func:`jink.metrics.normalised_error` from sums."""
        value, influence = self._normalised(quantity)
        return NAN if math.isnan(value) else Figure(value, spread(influence))

    def _normalised(self, quantity: str) -> tuple[float, Array]:
        if f"{quantity}_error" not in self.curves:
            return math.nan, np.full(1, math.nan)
        a, b = (self.curves[f"{quantity}_{each}"] for each in ("error", "noise"))
        kept = self.curves["runs"][:, 0] > 0
        a, b = a[kept], b[kept]
        used = b.sum(axis=0) > 0
        if not used.any():
            return math.nan, np.full(1, math.nan)
        a, b = a[:, used], b[:, used]
        mean_a, mean_b = a.mean(axis=0), b.mean(axis=0)
        scan = np.sqrt(mean_a / mean_b)
        with np.errstate(invalid="ignore", divide="ignore"):
            relative = np.where(mean_a > 0, (a - mean_a) / mean_a, 0.0) - (b - mean_b) / mean_b
        return float(scan.mean()), (scan / 2 * relative).mean(axis=1)

    def cost(self) -> Figure:
        """Wall-clock µs per update: median over chunks; standard error of a median."""
        if not self.costs:
            return NAN
        each = np.array([1e6 * seconds / updates for seconds, updates in self.costs])
        se = 1.253 * each.std(ddof=1) / math.sqrt(len(each)) if len(each) > 1 else math.nan
        return Figure(float(np.median(each)), float(se))


def _of(store: dict[str, Array], name: str, *shape: int) -> Array:
    """The array of this name, zeros where it is new."""
    if name not in store:
        store[name] = np.zeros(shape)
    return store[name]


def _quantile(bins: Array, q: float) -> float:
    """The distance (m) below which the share q lies, on the logarithm within its bin."""
    total = np.cumsum(bins)
    k = int(np.searchsorted(total, q * total[-1]))
    share = 1 - (total[k] - q * total[-1]) / bins[k]
    return SHORTEST * math.exp(WIDTH * (k + share))


def difference(a: Tally, b: Tally, name: str, other: str | None = None) -> Comparison:
    """Figure of a minus figure of b (under another name), paired over the runs they share."""
    (va, ia), (vb, ib) = a.influence(name), b.influence(other or name)
    lower = name not in ("log_score", "prediction_score")
    return paired(va - vb, ia - ib, lower_is_better=lower)


def efficiency(a: Tally, reference: Tally, name: str) -> Figure:
    """RMSE over that of the reference, paired."""
    (va, ia), (vb, ib) = a.influence(name), reference.influence(name)
    return Figure(va / vb, spread((ia - va / vb * ib) / vb)) if vb > 0 else NAN
