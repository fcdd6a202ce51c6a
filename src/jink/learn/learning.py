"""Rules and networks learned from targets whose truth is known, checked on data held out."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.purpose import Unfit
from ..catalogue.registry import FILTERS, canonical
from ..catalogue.targets import kind_of
from ..checks import unknown
from ..compare.entrants import SUFFIX, Entrant
from ..compare.filter_files import from_file as filter_from_file
from ..compare.result import Race
from ..filters.axis_by_axis import of_one_axis
from ..fit.data import SIMULATED_TRUTH, Training
from ..fit.fitting import starting_filter, training_data
from ..io.errors import InputError
from ..io.files import open_table
from ..io.own_code import is_code
from ..scenarios import Scenario
from .data import Runs, from_tracks
from .how import How
from .recipes import RECIPES, missing_truth
from .rule_recipes import constant_modes

LEARNED, BASE, NAMED, CONSTANTS = "learned", "unaided", "as shipped", "constants"
OWN_INPUTS = "simulated targets, one input for each mode"
METRICS = ("position_rmse", "velocity_rmse")
FEWEST = 4  # tracks: at least one of them validates
VALIDATION = 0.25
WORSE = "the learned filter is worse than the measurements themselves on held-out data"
OFF = 2.0  # times the estimated noise: so far apart measurements and truth need a word
NEEDED = {"position": "px=COLUMN (py, pz)", "velocity": "vx=COLUMN (vy, vz)"}

__all__ = ["Learned", "learn"]


@dataclass(kw_only=True)
class Learned:
    """filter: what was learned, under its recipe's name; race on data held out; what it learned on, in words and for
    its file; seconds: how long that took, cpu_seconds: of all processor cores together.
    """

    filter: Any
    name: str
    race: Race
    training: str
    record: dict[str, Any]
    seconds: float
    cpu_seconds: float
    warnings: list[str] = field(default_factory=list)

    def verdicts(self) -> dict[str, str]:
        """The learned filter against each other one: position and velocity, with paired 95% intervals."""
        return {name: _against(self.race, name) for name in self.race.tallies if name not in (LEARNED, "clairvoyant")}

    @property
    def beaten_by(self) -> list[str]:
        """Filters that the learned one does not beat in position."""
        return [name for name in self.verdicts() if self.race.compare(LEARNED, name).verdict != "better"]

    def verdict(self) -> str:
        """One plain sentence."""
        if not self.beaten_by:
            return "On held-out data the learned filter is better than all of these."
        return f"On held-out data the learned filter does not beat {', '.join(self.beaten_by)} in position."

    def save(self, path: str | Path) -> None:
        """Write the filter with what it was learned on and its figures on held-out data, for ``jink track
        --filter``.
        """
        figures = {m: self.race.figure(LEARNED, m)._asdict() for m in METRICS}
        self.filter.save(path, fitted={**self.record, "held_out": figures})

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, as ``--json`` writes them."""
        return {
            "training": self.training,
            "filter": self.name,
            "verdict": self.verdict(),
            "verdicts": self.verdicts(),
            "warnings": self.warnings,
            "seconds": self.seconds,
            "cpu_seconds": self.cpu_seconds,
            "held_out": self.race.as_dict(),
        }


def learn(
    name: str,
    data: str | Scenario | Sequence[str | Scenario],
    *,
    truth: str | Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
    kind: str | None = None,
    runs: int = 200,
    check_runs: int = 500,
    seed: int = 0,
    base: Any = None,
    **how: Any,
) -> Learned:
    """Learn a filter of this kind, one of ``jink.learn.recipes.RECIPES``, on a scenario's training runs or a file with
    truth.

    A corrector also learns on a file without truth: its smoothed positions are the truth then, and random radars see
    them. truth, columns as for ``jink.fit.fit``; kind of a file's targets; base: the filter to be aided, a name of
    ``FILTERS``, a file or a filter; how: what :class:`jink.learn.how.How` takes. Of the data learned on, a quarter
    validates. Errors: InputError (a ValueError).
    """
    if name not in RECIPES:
        raise InputError(unknown("learned filter", name, RECIPES))
    if isinstance(data, str) and truth is None and Path(data).is_file():
        if name == "corrector" and SIMULATED_TRUTH["px"] not in open_table(Path(data)).names:
            return _from_recorded(data, columns, kind or "aircraft", seed, how)
        truth = _simulated_truth(data)
    training = training_data(
        data,
        runs=runs,
        check_runs=check_runs,
        seed=seed,
        kind=kind or "aircraft",
        columns=columns,
        truth=truth,
        positions=True,
    )
    if kind is not None:
        training = replace(training, purpose=replace(training.purpose, kind=kind, assumed=None))
    known = _runs(training)
    if missing := missing_truth(name, known):
        raise InputError(
            f"{training.name}: {name} also needs the true {missing}; name its columns with truth "
            f"(--truth {NEEDED[missing]})"
        )
    started = None if base is None else starting_filter(base, training, seed)[1]
    if of_one_axis(started):
        known = known.axes_apart()
    asked = How(
        **{"acceleration": training.purpose.largest, "kind": training.purpose.kind, **how}, seed=seed, base=started
    )
    learning, validation = _split(known, seed)
    began, cpu = clock.perf_counter(), clock.process_time()
    try:
        filter = RECIPES[name](learning, validation, asked)
        constant = constant_modes(name, learning, asked)
    except (ValueError, TypeError) as error:
        raise InputError(f"{name}: {error}") from None
    seconds, cpu = clock.perf_counter() - began, clock.process_time() - cpu
    words = OWN_INPUTS if asked.own_inputs else f"{training.words}, a quarter of them to validate"
    below = _fitted_base(name, base, training, seed)
    race = _checked(training, name, filter, constant, "" if asked.own_inputs else training.words, below)
    learned = Learned(
        filter=filter,
        name=name,
        race=race,
        training=words,
        seconds=seconds,
        cpu_seconds=cpu,
        record={
            "scenario": training.name,
            "seed": seed,
            "runs": training.runs,
            "apart": training.apart,
            "noise": "the sensor's",
            **({"learned_on": OWN_INPUTS} if asked.own_inputs else {}),
        },
    )
    learned.warnings = _warnings(learned, known, training)
    return learned


def _from_recorded(
    path: str, columns: Mapping[str, str] | None, kind: str, seed: int, how: Mapping[str, Any]
) -> Learned:
    """A corrector of recorded tracks. Errors: InputError."""
    from .plane_recorded import corrector, race

    asked = How(**{"acceleration": kind_of(kind).acceleration, "kind": kind, **how}, seed=seed)
    began, cpu = clock.perf_counter(), clock.process_time()
    try:
        filter, recording = corrector(path, asked, columns)
    except (ValueError, TypeError) as error:
        raise InputError(f"corrector: {error}") from None
    seconds, cpu = clock.perf_counter() - began, clock.process_time() - cpu
    said = filter.corrector.trained
    assert said is not None
    entrants = [
        Entrant(name=LEARNED, words="corrector, learned", filter=filter, fitted="other targets of this file"),
        Entrant(name=BASE, words="the same filter without the learned correction", filter=filter.filter_),
    ]
    found = race(recording, path, asked, entrants)
    learned = Learned(
        filter=filter,
        name="corrector",
        race=found,
        training=said.data,
        seconds=seconds,
        cpu_seconds=cpu,
        record={"scenario": path, "seed": seed, "runs": found.runs, "apart": "seed", "noise": "of radars"},
    )
    if found.worse_than_raw(LEARNED):
        learned.warnings.append(WORSE)
    return learned


def _simulated_truth(path: str) -> str:
    if SIMULATED_TRUTH["px"] not in open_table(Path(path)).names:
        raise InputError(
            f"{path} has no column {SIMULATED_TRUTH['px']!r} with the truth. Name its truth columns "
            "(--truth px=COLUMN,py=…), or use jink fit, which needs no truth"
        )
    return "true"


def _runs(training: Training) -> Runs:
    tracks = training.tracks
    try:
        sd = training.purpose.position_sd
    except Unfit as error:
        raise InputError(f"{training.name}: {error}; expected measured positions for a learned filter") from None
    if training.purpose.recorded and tracks.truth is not None:
        sd = _seen_sd(training)
    try:
        return from_tracks(tracks, sd, training.words)
    except ValueError as error:
        raise InputError(f"{training.name}: {error}") from None


def _seen_sd(training: Training) -> float:
    """What measurements and truth show, by the median, so that gross errors do not count."""
    tracks = training.tracks
    assert tracks.truth is not None
    places = [(k, "xyz".index(c[1])) for k, c in enumerate(tracks.components) if c[0] == "p"]
    off = np.stack([tracks.truth[:, k] - tracks.z[:, a] for k, a in places if a < tracks.z.shape[1]])
    return float(np.nanmedian(np.abs(off)) / 0.6745)


def _split(runs: Runs, seed: int) -> tuple[Runs, Runs]:
    if len(runs) < FEWEST:
        raise InputError(
            f"{runs.name}: {len(runs)} tracks with truth are too few to learn from; expected at least {FEWEST}"
        )
    order = np.random.default_rng(seed).permutation(len(runs))
    some = max(1, round(VALIDATION * len(runs)))
    return runs.take(np.sort(order[some:])), runs.take(np.sort(order[:some]))


def _checked(training: Training, name: str, filter: Any, constant: Any, fitted: str, below: str) -> Race:
    """The learned filter against others; fitted, below: what it and the filter under its correction were fitted on."""
    entrants = [Entrant(name=LEARNED, words=f"{name}, learned", filter=filter, fitted=fitted)]
    inner = getattr(filter, "filter_", None)
    if inner is not None:
        words = "the same filter without the learned correction"
        entrants.append(Entrant(name=BASE, words=words, filter=inner, fitted=below))
    if constant is not None:
        words = "the same modes with one constant noise each, searched on the same runs within the same bounds"
        entrants.append(Entrant(name=CONSTANTS, words=words, filter=constant, fitted=fitted))
    try:
        shipped = FILTERS[name](training.purpose)
        entrants.append(Entrant(name=NAMED, **vars(shipped)))
    except (Unfit, KeyError):
        pass
    return training.check(entrants)


def _fitted_base(name: str, base: Any, training: Training, seed: int) -> str:
    """On which data like the held-out ones the filter under a correction was fitted; "" for none."""
    if name == "corrector":
        base = "imm"
    if base is None:
        return training.words
    if not isinstance(base, str) or is_code(base):
        return ""
    if base.endswith(SUFFIX):
        return filter_from_file(base, training.purpose, seed, 0).fitted
    return FILTERS[canonical(base)](training.purpose).fitted


def _against(race: Race, other: str) -> str:
    said = []
    for metric in METRICS:
        c = race.compare(LEARNED, other, metric)
        if math.isfinite(c.difference):
            word = {"better": "better", "worse": "worse", "undecided": "no difference"}[c.verdict]
            unit = "m" if metric == "position_rmse" else "m/s"
            said.append(f"{metric.removesuffix('_rmse')} {word} ({c.low:+.3g} … {c.high:+.3g} {unit})")
    return "; ".join(said)


def _warnings(learned: Learned, runs: Runs, training: Training) -> list[str]:
    said = []
    estimated = training.purpose.position_sd
    if training.purpose.recorded and not estimated / OFF < runs.sd < estimated * OFF:
        said.append(
            f"the measurements lie {runs.sd:.3g} m from the truth, and their noise is estimated as {estimated:.3g} m: "
            "the truth may be of other times or coordinates, or the errors last"
        )
    rows = int(np.isfinite(runs.position[..., 0]).sum())
    if len(runs) < 20 or rows < 2000:
        said.append(f"little data: {len(runs)} tracks, {rows:,} scans with truth")
    if learned.race.worse_than_raw(LEARNED):
        said.append(WORSE)
    return said
