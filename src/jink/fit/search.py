"""Which filter fits these targets best? Candidates fitted in parallel within a budget, ranked on held-out data, the
best explained.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..catalogue.purpose import Unfit
from ..checks import unknown
from ..compare.entrants import Entrant
from ..compare.result import Race
from ..frozen import frozen
from ..io.errors import InputError
from ..io.own_code import is_code
from ..metrics import Comparison
from .candidates import CANDIDATES, WORDS, Candidate, own_candidates
from .data import Training
from .objectives import Objective
from .optimise import Found
from .parallel import Job, Outcome, run_jobs
from .parameters import Parameters
from .result import JUDGED, Fit

MARK = " fitted"  # after a candidate's name in the race, where the filters of that name as they are run as well
KEPT = 0.3  # of the budget is for the race and the best one's standard errors
Progress = Callable[[str, int, int], None]


@frozen(kw_only=True)
class Ranked:
    """One candidate: score on held-out data (smaller is better), how far behind the best in what was fitted for,
    parameters.

    partial: its fit was cut short.
    """

    name: str
    parameters: int
    training: float
    score: float
    figures: dict[str, float]
    behind: dict[str, Comparison]
    partial: bool

    @property
    def worse(self) -> bool:
        """Does a paired interval say that it is worse than the best, and none that it is better?"""
        verdicts = [c.verdict for c in self.behind.values()]
        return "worse" in verdicts and "better" not in verdicts


@dataclass(kw_only=True)
class Search:
    """ranked, the best first; fit: the best one's, as :func:`jink.fit.fit` returns it; left: who was not tried and
    why.
    """

    ranked: list[Ranked]
    fit: Fit
    race: Race
    left: dict[str, str]
    seconds: float
    partial: bool
    interrupted: bool = False
    explanation: list[str] = field(default_factory=list)

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, as ``--json`` writes them."""
        return {
            "best": self.ranked[0].name,
            "explanation": self.explanation,
            "partial": self.partial,
            "seconds": self.seconds,
            "search": [
                {
                    "filter": r.name,
                    "parameters": r.parameters,
                    "training": r.training,
                    **r.figures,
                    "cut_short": r.partial,
                    "behind": {m: {"low": c.low, "high": c.high, "verdict": c.verdict} for m, c in r.behind.items()},
                }
                for r in self.ranked
            ],
            "not_tried": self.left,
            **{"fit": self.fit.as_dict()},
        }


def search(
    training: Training,
    objective: Objective,
    *,
    names: Sequence[str] = (),
    minutes: float | None = None,
    workers: int = 1,
    seed: int = 0,
    free: Sequence[str] = (),
    fixed: Sequence[str] = (),
    progress: Progress | None = None,
) -> Search:
    """Fit the candidates (all, or those of ``names``), race them on the data held out, and explain the best.

    minutes: budget of it all; each candidate gets an equal share of what is left, and those cut short say so. workers:
    processes at once; 1 runs in this one. Ctrl-C ranks what is done. Errors: InputError for unknown names,
    KeyboardInterrupt before anything is done.
    """
    began = clock.monotonic()
    end = began + 60.0 * minutes if minutes is not None else math.inf
    candidates = chosen(names)
    jobs, starts, left = _jobs(candidates, training, free, fixed)
    budget = end - KEPT * (end - began) if minutes is not None else math.inf
    outcomes, interrupted = run_jobs(
        jobs, training.tracks, objective, seed=seed, deadline=budget, workers=workers, progress=progress
    )
    done = {name: outcome for name, outcome in outcomes.items() if outcome.found is not None}
    left |= {name: outcome.failed for name, outcome in outcomes.items() if outcome.found is None}
    why = "interrupted" if interrupted else "no time was left"
    left |= {job.name: why for job in jobs if job.name not in outcomes}
    if not done:
        if interrupted:
            raise KeyboardInterrupt
        raise InputError("no candidate could be fitted: " + "; ".join(f"{n}: {why}" for n, why in left.items()))
    entrants = [_entrant(name, starts[name][1], outcome) for name, outcome in done.items()]
    race = training.check(entrants)
    ranked = ranking(race, {name: (outcome.found, starts[name][1]) for name, outcome in done.items()}, objective.name)
    best = ranked[0].name
    start, parameters = starts[best]
    found = done[best].found
    assert found is not None
    fit = Fit.made(training, best, start, parameters, objective, training.tracks, found, seed=seed)
    made = Search(
        ranked=ranked,
        fit=fit,
        race=race,
        left=left,
        seconds=clock.monotonic() - began,
        partial=interrupted or any(r.partial for r in ranked) or why in left.values(),
        interrupted=interrupted,
    )
    made.explanation = explained(made, objective.name, {each.name: each.parts for each in candidates})
    return made


def chosen(names: Sequence[str]) -> list[Candidate]:
    """The candidates of these names and of files of your own, or all. Errors: InputError."""
    found: dict[str, Candidate] = {}
    for name in names or CANDIDATES:
        if is_code(name):
            found |= {each.name: each for each in own_candidates(name)}
        elif name in CANDIDATES:
            found[name] = CANDIDATES[name]
        else:
            raise InputError(unknown("candidate", name, CANDIDATES) + ", or my.py:name")
    return list(found.values())


def _jobs(
    candidates: Sequence[Candidate], training: Training, free: Sequence[str], fixed: Sequence[str]
) -> tuple[list[Job], dict[str, tuple[Any, Parameters]], dict[str, str]]:
    """What is to be fitted, in the order of the number of parameters, and what cannot be."""
    starts: dict[str, tuple[Any, Parameters]] = {}
    left: dict[str, str] = {}
    named: set[str] = set()
    for candidate in candidates:
        try:
            start = candidate.made(training.purpose)
            known = Parameters(start).known
            own = [[p for p in patterns if known(p)] for patterns in (free, fixed)]
            named |= {pattern for patterns in own for pattern in patterns}
            parameters = Parameters(start, free=own[0], fixed=own[1])
        except (Unfit, ValueError, TypeError) as why:
            left[candidate.name] = str(why)
            continue
        if start.axes != training.tracks.z.shape[1]:
            left[candidate.name] = "it needs two axes together; here each axis is filtered by itself"
            continue
        if training.tracks.rows < 10 * len(parameters):
            left[candidate.name] = (
                f"{training.tracks.rows} rows are too few for its {len(parameters)} parameters; it needs ten for each"
            )
            continue
        starts[candidate.name] = (start, parameters)
    nothing = [pattern for pattern in (*free, *fixed) if pattern not in named]
    if nothing:
        raise InputError(f"no candidate has a parameter {nothing[0]!r}; expected a name such as *.acceleration_psd")
    order = sorted(starts, key=lambda name: len(starts[name][1]))
    code = {candidate.name: candidate.code for candidate in candidates}
    jobs = [Job(name, starts[name][0].described(), starts[name][1].names, code[name]) for name in order]
    return jobs, starts, left


def _entrant(name: str, parameters: Parameters, outcome: Outcome) -> Entrant:
    assert outcome.found is not None
    return Entrant(
        name=name + MARK,
        words=f"{name}, fitted",
        filter=parameters.filter(outcome.found.u),
        fitted="training data",
    )


def score_of(race: Race, name: str, objective: str) -> tuple[float, dict[str, float]]:
    """Smaller is better: the mean log of errors, or minus the log-likelihood per plot; and the figures themselves."""
    metrics = judged(race, objective)
    figures = {metric: race.figure(name + MARK, metric).value for metric in metrics}
    values = [-v if metric == "prediction_score" else math.log(v) for metric, v in figures.items()]
    return float(np.mean(values)), figures


def judged(race: Race, objective: str) -> list[str]:
    """The metrics of a race that the objective is about."""
    found = [metric for metric in JUDGED[objective] if metric in race.metrics]
    return found[:1] if objective == "prediction" else found


def ranking(race: Race, done: dict[str, tuple[Found | None, Parameters]], objective: str) -> list[Ranked]:
    """The candidates from the best on held-out data to the worst; those without a figure there come last."""
    scores = {name: score_of(race, name, objective) for name in done}
    order = sorted(done, key=lambda name: scores[name][0] if math.isfinite(scores[name][0]) else math.inf)
    out = []
    for name in order:
        found, parameters = done[name]
        assert found is not None
        behind = (
            {m: race.compare(name + MARK, order[0] + MARK, m) for m in judged(race, objective)}
            if name != order[0]
            else {}
        )
        out.append(
            Ranked(
                name=name,
                parameters=len(parameters),
                training=found.value,
                score=scores[name][0],
                figures=scores[name][1],
                behind=behind,
                partial=found.partial,
            )
        )
    return out


def explained(made: Search, objective: str, parts_of: Mapping[str, Sequence[str]]) -> list[str]:
    """Why the best one, in plain words: what each of its parts gains, and who does as well with less."""
    best, others = made.ranked[0], made.ranked[1:]
    parts = parts_of[best.name]
    lines = [f"{best.name} is the best of {len(made.ranked)} on held-out data: {_listed([WORDS[p] for p in parts])}."]
    for part in parts:
        without = next((r for r in others if part not in parts_of[r.name]), None)
        if without is not None and len(parts) > 1:
            word = "worse" if without.worse else "not told apart"
            lines.append(f"Without {WORDS[part]} the best is {without.name}, {word}: {differences(without)}.")
    simpler = [r for r in others if not r.worse and r.parameters < best.parameters]
    if simpler:
        least = min(simpler, key=lambda r: r.parameters)
        lines.append(
            f"{least.name} is not told apart from it, with {least.parameters} parameters instead of "
            f"{best.parameters}: the simpler choice."
        )
    if others and not others[0].worse and others[0] not in simpler:
        lines.append(f"{others[0].name} is not told apart from it either: {differences(others[0])}.")
    lines.append(
        f"The best of {len(made.ranked)} on the same data looks a little better than it is; its parameters were "
        "fitted on other data."
    )
    return lines


def differences(ranked: Ranked) -> str:
    """Its paired 95% intervals against the best, in words."""
    from .result import UNITS
    from .result import WORDS as METRIC_WORDS

    said = [f"{METRIC_WORDS[m]} {c.low:+.3g} … {c.high:+.3g}{UNITS[m]}" for m, c in ranked.behind.items()]
    return ", ".join(said)


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
