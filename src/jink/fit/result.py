"""What came of a fit: parameters with intervals, the race on held-out data, and what has to be said about both."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from ..checks import Array
from ..compare.entrants import Entrant
from ..compare.result import Race
from ..filters.bank import Bank
from ..filters.own import OwnFilter
from ..models.tracks import Tracks
from .data import Training
from .gradient import differentiable
from .objectives import NotFinite, Objective
from .optimise import FARTHEST, Found
from .parameters import Parameters
from .regimes import PartShare, shares
from .uncertainty import standard_errors

FITTED, START = "fitted", "before"
RIVALS = (START, "imm", "imm-corrected", "kalman-cv", "kalman-ca")
VAGUE = 1.0  # sd of u: a factor of e either way
FEW_ROWS, FEW_OWNERS = 50, 10  # per parameter; targets or runs
TOLD = 200  # rows of a part from which its NIS says something
BAND = (0.90, 0.98)  # the share of NIS inside its 95% band that passes for consistent


class Row(TypedDict):
    """One parameter: before and after, and its 95% interval (None: unknown)."""

    parameter: str
    before: float
    after: float
    low: float | None
    high: float | None


# what a fit is judged by, the first of these that the race has; the rest is said as well
JUDGED = {
    "tracking": ("position_rmse", "velocity_rmse"),
    "normalised": ("normalised_position", "normalised_velocity"),
    "likelihood": ("prediction_score",),
    "prediction": ("prediction_rmse", "position_rmse"),
}


@dataclass(kw_only=True)
class Fit:
    """filter: the fitted one; start: where it began, under its name; u, sd (P,) of the parameters' scales; figures of
    the objective on the training data before and after; race on data held out; parts: NIS by part of held-out tracks,
    before and after; warnings; partial: cut short, interrupted: by Ctrl-C."""

    filter: Bank | OwnFilter
    start: Bank | OwnFilter
    name: str
    parameters: Parameters
    u: Array
    sd: Array
    objective: str
    before: float
    after: float
    race: Race
    training: str
    held_out: Tracks
    record: Mapping[str, object]
    evaluations: int
    seconds: float
    partial: bool
    interrupted: bool = False
    parts: dict[str, list[PartShare]] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    @classmethod
    def made(
        cls,
        training: Training,
        name: str,
        start: Bank | OwnFilter,
        parameters: Parameters,
        objective: Objective,
        tracks: Tracks,
        found: Found,
        *,
        seed: int,
    ) -> Fit:
        """Check a search's result on the data held out."""
        filter = parameters.filter(found.u)
        sd = np.full(len(parameters), np.nan)
        if differentiable(filter):
            try:
                sd = standard_errors(parameters, objective, found.u, tracks, seed=seed).sd
            except NotFinite:
                sd = np.full(len(parameters), np.inf)
        fitted = Entrant(name=FITTED, words=f"{name}, fitted", filter=filter, fitted=training.words)
        before = Entrant(name=START, words=f"{name} as it was", filter=start)
        race = training.check([fitted, before] if name != "imm" else [fitted])
        if name == "imm":
            race.entrants[START], race.tallies[START] = race.entrants["imm"], race.tallies["imm"]
            del race.entrants["imm"], race.tallies["imm"]
        fit = cls(
            filter=filter,
            start=start,
            name=name,
            parameters=parameters,
            u=found.u,
            sd=sd,
            objective=objective.name,
            before=objective.value(start, tracks),
            after=found.value,
            race=race,
            training=training.words,
            held_out=training.held_out,
            record={
                "scenario": training.name,
                "kind": training.purpose.kind,
                "seed": seed,
                "runs": training.runs,
                "apart": training.apart,
                "noise": "the sensor's" if tracks.covariance is None else "of each row",
            },
            evaluations=found.evaluations,
            seconds=found.seconds,
            partial=found.partial,
            interrupted=found.interrupted,
            parts={START: shares(start, training.held_out), FITTED: shares(filter, training.held_out)},
        )
        fit.warnings = warnings_of(fit, training, tracks) + stumbles(found, filter)
        return fit

    def table(self) -> list[Row]:
        """Each parameter: name, before, after, and the 95% interval in its own units (None: unknown)."""
        before, after = (self.parameters.values(u) for u in (self.parameters.start, self.u))
        low, high = (self.parameters.values(_within(self.u, sign * 1.96 * self.sd)) for sign in (-1, 1))
        return [
            {
                "parameter": name,
                "before": before[name],
                "after": after[name],
                "low": min(low[name], high[name]) if math.isfinite(self.sd[k]) else None,
                "high": max(low[name], high[name]) if math.isfinite(self.sd[k]) else None,
            }
            for k, name in enumerate(self.parameters.names)
        ]

    def verdicts(self) -> list[str]:
        """The fitted filter against each rival, in every metric compared, with the paired 95% interval."""
        lines = []
        for other in RIVALS:
            if other not in self.race.tallies:
                continue
            said = []
            for metric in dict.fromkeys([*self.judged, *self.race.compared]):
                c = self.race.compare(FITTED, other, metric)
                if math.isfinite(c.difference):
                    word = {"better": "better", "worse": "worse", "undecided": "no gain"}[c.verdict]
                    said.append(f"{WORDS[metric]} {word} ({c.low:+.3g} … {c.high:+.3g}{UNITS[metric]})")
            if said:
                lines.append(f"against {other}: {'; '.join(said)}")
        return lines

    @property
    def judged(self) -> list[str]:
        """The metrics that the objective is about."""
        found = [m for m in JUDGED[self.objective] if m in self.race.metrics]
        found = found or [m for m in JUDGED["tracking"] if m in self.race.metrics]  # of a file with truth
        return found[:1] if self.objective == "prediction" else found

    @property
    def gain(self) -> bool:
        """Do the paired intervals say that the fitted filter is better than it was, in what it was fitted for, and not
        worse?
        """
        found = [self.race.compare(FITTED, START, metric).verdict for metric in self.judged]
        return "better" in found and "worse" not in found

    def save(self, path: str | Path) -> None:
        """Write the fitted filter, with what it was fitted on, for ``jink.load``, ``jink track --filter``, ``jink
        compare``.
        """
        self.filter.save(path, fitted={**self.record, "objective": self.objective, "parameters": self.table()})

    def as_dict(self) -> dict[str, object]:
        """Plain numbers, as ``--json`` writes them."""
        return {
            "training": self.training,
            "filter": self.name,
            "objective": self.objective,
            "before": self.before,
            "after": self.after,
            "parameters": self.table(),
            "gain": self.gain,
            "verdicts": self.verdicts(),
            "warnings": self.warnings,
            "partial": self.partial,
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "held_out": self.race.as_dict(),
            "nis_by_part": {name: [s.as_dict() for s in found] for name, found in self.parts.items()},
        }


WORDS = {
    "normalised_position": "normalised position",
    "normalised_velocity": "normalised velocity",
    "position_rmse": "position",
    "velocity_rmse": "velocity",
    "log_score": "log score",
    "prediction_rmse": "prediction",
    "prediction_score": "log-likelihood per plot",
}
UNITS = {
    "normalised_position": "",
    "normalised_velocity": "",
    "position_rmse": " m",
    "velocity_rmse": " m/s",
    "log_score": "",
    "prediction_rmse": " m",
    "prediction_score": "",
}


def _within(u: Array, step: Array) -> Array:
    return u + np.clip(np.nan_to_num(step, nan=0.0, posinf=FARTHEST, neginf=-FARTHEST), -FARTHEST, FARTHEST)


def stumbles(found: Found, filter: Any) -> list[str]:
    """What went less well than usual in the search."""
    said = []
    if not differentiable(filter):
        said.append("this filter has no gradient, so CMA-ES fitted it; its parameters have no intervals")
    first, count = found.stumbled
    if count:
        said.append(
            f"{count} of {found.evaluations} parameter sets that the search tried gave no finite value; "
            f"the first: {first}"
        )
    return said


def warnings_of(fit: Fit, training: Training, tracks: Tracks) -> list[str]:
    """What a reader must know before using the fitted filter."""
    said = []
    if fit.race.scenario != training.name:
        said.append(f"the check used {fit.race.scenario} alone; jink compare shows the other scenarios")
    P = len(fit.parameters)
    owners = len(tracks) if tracks.owner is None else len(np.unique(tracks.owner))
    if tracks.rows < FEW_ROWS * P or owners < FEW_OWNERS:
        said.append(f"little data: {tracks.rows:,} rows of {owners} targets or runs for {P} parameters")
    vague = [n for n, sd in zip(fit.parameters.names, fit.sd, strict=True) if not np.isnan(sd) and sd > VAGUE]
    if vague:
        said.append(f"the data do not determine {', '.join(vague)}: the standard error is above a factor of e")
    far = np.abs(fit.u - fit.parameters.start) > FARTHEST - 0.1
    if far.any():
        said.append(
            f"the fit stopped at the end of the allowed range for {', '.join(np.array(fit.parameters.names)[far])}"
        )
    if fit.partial:
        said.append("the fit was cut short; these are the best parameters so far")
    said += _consistency(fit)
    if "imm" in fit.race.tallies and any(fit.race.compare(FITTED, "imm", m).verdict == "worse" for m in fit.judged[:1]):
        said.append("the default IMM, not fitted, is better on held-out data; fit that one (--filter imm)")
    if "imm-corrected" in fit.race.tallies:
        metrics = dict.fromkeys([*fit.judged, *fit.race.compared])
        lost = [WORDS[m] for m in metrics if fit.race.compare(FITTED, "imm-corrected", m).verdict == "worse"]
        if lost:
            what = " and ".join(lost)
            said.append(f"jink track without --filter runs imm-corrected, which is better on held-out data in {what}")
    if not fit.gain:
        worse = any(fit.race.compare(FITTED, START, m).verdict == "worse" for m in fit.judged)
        said.append(
            "the fitted filter is worse than before on held-out data"
            if worse
            else "the fitted filter gains nothing on held-out data"
        )
    return said


def _consistency(fit: Fit) -> list[str]:
    told = [s for s in fit.parts.get(FITTED, ()) if s.rows >= TOLD]
    if not told:
        inside, mean = (fit.race.figure(FITTED, name).value for name in ("nis_inside", "nis"))
        return _believes("", inside, inside > BAND[1] or mean < 1.0)
    return [
        line
        for s in told
        for line in _believes(f" of {s.part} parts", s.inside.value, s.inside.value > BAND[1] or s.below > s.above)
    ]


def _believes(where: str, inside: float, too_little: bool) -> list[str]:
    """A warning where the share of NIS inside its band is not what it should be."""
    if not math.isfinite(inside) or BAND[0] <= inside <= BAND[1]:
        return []
    words = f"{100 * inside:.1f}% of the held-out NIS{where} lie inside their 95% band"
    if too_little:
        return [f"under-confident: {words}; most others lie below, so errors are smaller than the filter believes"]
    return [f"over-confident: {words}; most others lie above, so errors are larger than the filter believes"]
