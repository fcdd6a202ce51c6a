"""A filter learned from your own targets: parameters from recorded measurements, with or without truth, checked on
others.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..archive.folder import check_named, is_archive
from ..catalogue.purpose import Unfit
from ..catalogue.registry import FILTERS, canonical
from ..checks import unknown
from ..compare.filter_files import from_file as filter_from_file
from ..compare.own_filters import Own, made
from ..io.errors import InputError
from ..io.own_code import is_code, loaded
from ..scenarios import SCENARIOS, Scenario
from .checkpoint import Checkpoint
from .data import Training, along_axes, from_file, from_scenarios, parse_truth
from .gradient import differentiable
from .objectives import Likelihood, NotFinite, Objective, Prediction, Tracking, believed
from .optimise import Search
from .parameters import Parameters
from .result import Fit

__all__ = ["OBJECTIVES", "Fit", "fit"]

OBJECTIVES = ("likelihood", "prediction", "tracking", "normalised")
Progress = Callable[[str, int, int], None]


def fit(
    data: str | Scenario | Sequence[str | Scenario],
    filter: str | Own = "imm",
    *,
    objective: str | None = None,
    truth: str | Mapping[str, str] | None = None,
    ahead: int = 1,
    free: Sequence[str] = (),
    fixed: Sequence[str] = (),
    runs: int = 200,
    check_runs: int = 500,
    seed: int = 0,
    starts: int = 3,
    minutes: float | None = None,
    kind: str = "aircraft",
    columns: Mapping[str, str] | None = None,
    checkpoint: str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Fit a filter's parameters to a scenario, several ("a,b"), or a file of recorded positions, and check it on
    held-out data.

    filter: where the fit starts, a name of ``jink.FILTERS``, a file written by ``save``, a filter, what makes
    one (as for :func:`jink.compare.compare`), or "file.py:name". Of models and filters of your own those numbers are
    fitted whose names end in _sd or _psd. objective:
    "likelihood" of the measurements (needs no truth), "prediction" error ``ahead`` scans on, "tracking" error against
    the truth (the default where there is truth), or "normalised": that of each scan over the measurements', then its
    mean. truth of a file: "true" (columns as jink simulate writes them) or component to column.
    free, fixed: patterns of parameter names, for example "*.acceleration_psd". runs to train on and
    check_runs to check on, of a scenario; a file is split by its tracks, or by time if there are few. minutes: budget.
    checkpoint: file in which the search is kept, taken up again with resume. Ctrl-C keeps the best so far, ``partial``
    being true. Errors: InputError (a ValueError).
    """
    training = training_data(data, runs=runs, check_runs=check_runs, seed=seed, kind=kind, columns=columns, truth=truth)
    name, start = starting_filter(filter, training, seed)
    return fit_filter(
        along_axes(training, start),
        name,
        start,
        objective=chosen_objective(objective, training, ahead),
        free=free,
        fixed=fixed,
        seed=seed,
        starts=starts,
        minutes=minutes,
        checkpoint=checkpoint,
        resume=resume,
        progress=progress,
    )


def fit_filter(
    training: Training,
    name: str,
    start: Any,
    *,
    objective: Objective,
    free: Sequence[str] = (),
    fixed: Sequence[str] = (),
    seed: int = 0,
    starts: int = 3,
    minutes: float | None = None,
    checkpoint: str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Fit one filter to training data and race it on the data held out."""
    deadline = clock.monotonic() + 60.0 * minutes if minutes is not None else float("inf")
    parameters = _parameters(start, free, fixed, training)
    tracks = training.tracks
    if objective.name == "prediction":
        tracks = believed(start, tracks)
    kept = Checkpoint.of(checkpoint, parameters, objective, tracks, seed, starts)
    search = Search(
        parameters,
        objective,
        tracks,
        starts=starts,
        seed=seed,
        deadline=deadline,
        keep=kept.write if kept else None,
        report=progress,
    )
    if resume:
        if kept is None:
            raise InputError("resume: expected checkpoint, the file in which the earlier fit kept its state")
        search.state = kept.read()
    try:
        found = search.run()
    except NotFinite as error:
        raise InputError(f"the fit cannot begin at {name}: {error}") from None
    if progress:
        progress("standard errors and the check on held-out data", 0, 0)
    return Fit.made(training, name, start, parameters, objective, tracks, found, seed=seed)


def training_data(
    data: str | Scenario | Sequence[str | Scenario],
    *,
    runs: int,
    check_runs: int,
    seed: int,
    kind: str,
    columns: Mapping[str, str] | None,
    truth: str | Mapping[str, str] | None,
    positions: bool = False,
) -> Training:
    """What was asked to be fitted on; positions: a radar's plots in a file become positions. Errors: InputError."""
    for name, number in (("runs", runs), ("check_runs", check_runs)):
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            raise InputError(f"{name} is {number!r}; expected a whole number of at least 1")
    if isinstance(data, Path) or (isinstance(data, str) and (Path(data).is_file() or is_archive(data))):
        wanted = parse_truth(truth, str(data)) if isinstance(truth, str) else truth
        return from_file(str(data), kind, seed, columns, wanted, positions)
    if isinstance(data, str):
        data = [name.strip() for name in data.split(",") if name.strip()]
    names = [data] if isinstance(data, Scenario) else list(data)
    if not names:
        raise InputError("data: expected a scenario's name, several names with commas, or a file")
    for name in names:
        if isinstance(name, str) and name not in SCENARIOS:
            check_named(name)
    if truth is not None:
        raise InputError("truth: expected only with a file, whose columns it names; a scenario brings its own truth")
    return from_scenarios(names, runs, seed, check_runs)


def starting_filter(filter: Any, training: Training, seed: int) -> tuple[str, Any]:
    """Name and filter that the fit starts from. Errors: InputError."""
    if not isinstance(filter, str) or is_code(filter):
        name = filter if isinstance(filter, str) else getattr(filter, "__name__", type(filter).__name__)
        given = loaded(filter) if isinstance(filter, str) else filter
        if isinstance(given, Mapping):
            raise InputError(f"filter {name}: is a mapping of filters; expected one filter, or what makes one")
        try:
            return name, made(name, given, training.purpose).filter
        except Unfit as error:
            raise InputError(f"filter {name}: {error}") from None
    if filter.endswith(".json"):
        if not Path(filter).is_file():
            raise InputError(f"there is no filter file {filter}")
        return filter, filter_from_file(filter, training.purpose, seed, 0).filter
    try:
        name = canonical(filter)
        return name, FILTERS[name](training.purpose).filter
    except Unfit as error:
        raise InputError(f"filter {filter}: {error}") from None
    except ValueError as error:
        raise InputError(f"{error}, or a file written by save() (*.json)") from None


def chosen_objective(name: str | None, training: Training, ahead: int) -> Objective:
    """The objective asked for; without one, tracking where there is truth, else likelihood. Errors: InputError."""
    name = name or ("likelihood" if training.tracks.truth is None else "tracking")
    if name not in OBJECTIVES:
        raise InputError(unknown("objective", name, OBJECTIVES))
    if ahead != 1 and name != "prediction":
        raise InputError(f"ahead is {ahead}; only the prediction objective looks ahead")
    if name in ("tracking", "normalised"):
        if training.tracks.truth is None:
            raise InputError(f"objective {name} needs the truth; name the file's truth columns with truth (--truth)")
        return Tracking(name)
    return Likelihood() if name == "likelihood" else Prediction(ahead=ahead)


def _parameters(start: Any, free: Sequence[str], fixed: Sequence[str], training: Training) -> Parameters:
    try:
        parameters = Parameters(start, free=free, fixed=fixed)
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(str(error)) from None
    rows = training.tracks.rows
    if rows < 10 * len(parameters):
        raise InputError(
            f"{training.name}: {rows} rows are too few to fit {len(parameters)} parameters; expected at least "
            f"{10 * len(parameters)}, ten for each. Give more data, or fix parameters"
        )
    missing = [c for c in training.tracks.components if c not in start.components]
    if training.tracks.truth is not None and missing:
        raise InputError(f"the truth names {missing[0]}, which the filter does not estimate; leave it out of the truth")
    if not differentiable(start) and len(parameters) > 40:
        raise InputError(
            f"{len(parameters)} parameters are too many for this filter, which has no gradient; expected at most 40. "
            "Fix some of them"
        )
    return parameters
