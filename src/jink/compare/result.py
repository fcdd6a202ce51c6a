"""The outcome of a race: figures with standard errors, paired differences, what was fitted on what."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..metrics import Comparison, Figure
from . import manoeuvring, mode_jumps
from .entrants import ALWAYS, Entrant
from .example import Example
from .scores import Tally, difference, efficiency

if TYPE_CHECKING:
    import polars as pl

METRICS = (
    "position_rmse",
    "velocity_rmse",
    "acceleration_rmse",
    "normalised_position",
    "normalised_velocity",
    "mean_euclidean",
    "position_median",
    "position_95",
    "nees",
    "nees_inside",
    "nis",
    "nis_inside",
    "log_score",
    "prediction_score",
    "estimated",
    "lost",
    *manoeuvring.METRICS,
    mode_jumps.METRIC,
    "us_per_update",
)
RESPONSES = tuple(name for name in manoeuvring.METRICS if name.startswith(manoeuvring.EVENTS))
QUANTILES = {"position_median": 0.5, "position_95": 0.95}
COMPARED = ("position_rmse", "velocity_rmse", "log_score")
AGAINST = tuple(name for name in ALWAYS if name != "clairvoyant")


@dataclass(kw_only=True)
class Race:
    """Who took part and what came of it.

    scenario, its words and how it is seen, runs (finished), asked, seed; entrants and tallies by name; skipped: who
    could not take part, and why; bound: the RMSE (m, m/s) that the posterior Cramér–Rao bound allows a filter that
    knows the manoeuvres; example: one run to look at; partial: interrupted before all runs were done; skipped_scans:
    those at the start that do not count; phases: scans between changes of motion that all runs share.
    """

    scenario: str
    words: str
    runs: int
    asked: int
    seed: int
    entrants: dict[str, Entrant]
    tallies: dict[str, Tally]
    skipped: dict[str, str] = field(default_factory=dict)
    seen: str = ""
    bound: dict[str, float] = field(default_factory=dict)
    example: Example | None = None
    unit: str = "runs"
    skipped_scans: int = 0
    phases: mode_jumps.Phases = field(default_factory=list)
    metrics: tuple[str, ...] = METRICS
    compared: tuple[str, ...] = COMPARED

    @property
    def partial(self) -> bool:
        """Interrupted?"""
        return self.runs < self.asked

    def figure(self, name: str, metric: str) -> Figure:
        """A metric of a filter, NaN where it has none."""
        tally = self.tallies[name]
        if metric.startswith("normalised_"):
            return tally.normalised(metric.removeprefix("normalised_"))
        if metric in QUANTILES:
            return tally.quantile(QUANTILES[metric])
        if metric in RESPONSES:
            return manoeuvring.figure(tally, metric)
        if metric == mode_jumps.METRIC:
            return mode_jumps.mode_jump_delay(tally, self.phases)
        if metric == "us_per_update":
            return tally.cost()
        if metric.endswith("_efficiency"):
            reference = self.tallies["near-optimal"]
            return efficiency(tally, reference, metric.replace("efficiency", "rmse"))
        return tally.figure(metric)

    def figures(self, name: str) -> dict[str, Figure]:
        """All metrics that a filter has."""
        names = self.metrics
        if "near-optimal" in self.tallies:
            names = (*names, "position_efficiency", "velocity_efficiency")
        found = {metric: self.figure(name, metric) for metric in names}
        return {metric: figure for metric, figure in found.items() if not math.isnan(figure.value)}

    def compare(self, name: str, other: str, metric: str = "position_rmse") -> Comparison:
        """Figure of one minus figure of the other, with its paired 95% interval. Against raw, position counts
        where something was measured."""
        if "raw" in (name, other) and metric == "position_rmse" and self.unit == "runs":
            metric = "position_rmse_where_measured"
        return difference(self.tallies[name], self.tallies[other], metric)

    def worse_than_raw(self, name: str) -> bool:
        """Does the paired interval of the position RMSE lie above that of the raw measurements?"""
        if name == "raw" or "raw" not in self.tallies:
            return False
        return self.compare(name, "raw").verdict == "worse"

    def to_frame(self) -> pl.DataFrame:
        """A polars DataFrame: filter, metric, value, se, and the difference to imm with its paired 95% interval.

        Errors: ImportError without polars.
        """
        import polars as pl

        names = ("difference_to_imm", "low", "high", "verdict")
        rows: list[dict[str, str | float | None]] = []
        for filter in self.tallies:
            against = self._comparisons(filter).get("imm", {})
            for metric, figure in self.figures(filter).items():
                told = against.get(metric, {})
                compared = [told.get(name) for name in ("difference", "low", "high", "verdict")]
                row = {"filter": filter, "metric": metric, "value": figure.value, "se": figure.se}
                rows.append(row | dict(zip(names, compared, strict=True)))
        kinds = {name: pl.String if name == "verdict" else pl.Float64 for name in names}
        schema = {"filter": pl.String, "metric": pl.String, "value": pl.Float64, "se": pl.Float64, **kinds}
        return pl.DataFrame(rows, schema=schema).with_columns(pl.col("value", "se").fill_nan(None))

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page that ``jink compare --report`` writes. Errors: OSError where it cannot be written."""
        # pages stand above this room: the public face finds them
        from jink import plot

        plot(self).save(path)

    def as_dict(self) -> dict[str, object]:
        """What `--json` writes: plain numbers, null where there is none."""
        filters = {
            name: {metric: _numbers(figure._asdict()) for metric, figure in self.figures(name).items()}
            for name in self.tallies
        }
        return {
            "scenario": self.scenario,
            "runs": self.runs,
            "seed": self.seed,
            "seen": self.seen,
            "filters": filters,
            "bounds": {"posterior_cramer_rao_told_the_manoeuvres": self.bound} if self.bound else {},
            "partial": self.partial,
            "runs_asked": self.asked,
            "unit": self.unit,
            "about": {name: self._about(name) for name in self.tallies},
            "skipped": self.skipped,
            "comparisons": {name: self._comparisons(name) for name in self.tallies},
        }

    def _about(self, name: str) -> dict[str, Any]:
        entrant = self.entrants[name]
        return {
            "is": entrant.words,
            "fitted_on_this_scenario": entrant.fitted or None,
            "in_sample": entrant.in_sample,
            "worse_than_raw": self.worse_than_raw(name),
            "note": entrant.note or None,
        }

    def _comparisons(self, name: str) -> dict[str, Any]:
        """Against those that are always there; figures in and out of sample are not compared."""
        if self.entrants[name].in_sample:
            return {}
        return {
            other: {
                metric: _numbers(
                    {
                        "difference": c.difference,
                        "se": c.se,
                        "low": c.low,
                        "high": c.high,
                        "verdict": c.verdict,
                    }
                )
                for metric in self.compared
                if math.isfinite((c := self.compare(name, other, metric)).difference)
            }
            for other in AGAINST
            if other != name and other in self.tallies
        }


def _numbers(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in values.items()
    }
