"""A race on recorded positions without truth: who predicts the next measurement best?

Whole targets are set aside for fitting, or parts of their tracks if targets are few; with few of both it is the first
half of each part, and blocks of scans take the place of targets as the units that differences are paired over. A position
that repeats the one before exactly (a target at rest, reported again) is filtered, but neither fitted nor scored: it is
no new measurement, and a density can be as high as it likes where nothing changes.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..catalogue.choose import sensor_of
from ..catalogue.purpose import Purpose, Unfit
from ..catalogue.targets import kind_of
from ..checks import Array
from ..estimate import Status
from ..io.errors import InputError
from ..io.loading import Reading, load_files
from ..models.outliers import Outliers
from ..scenarios.observation import sensor_in_words
from ..tracking.batch import usual_step
from ..tracking.cleaning import Cleaning, changes, clean
from ..tracking.noise_level import noise_levels
from ..tracking.placing import Placed, begin_with_height, place
from .entrants import SUFFIX, Entrant, enter
from .estimates import measured_position
from .example import recorded_example
from .filter_files import from_file
from .result import Race
from .scores import Tally, part
from .scores import inside as inside_band

OUTPUTS = ("nis", "nis_dof", "log_likelihood_scan", "status")
METRICS = (
    "prediction_rmse",
    "prediction_score",
    "nis",
    "nis_inside",
    "gated",
    "us_per_update",
)
FEW = 8  # targets, or parts, below which time is split instead
START = 3  # rows of a part before anything is scored
BLOCK = 25  # scored rows that make a unit where parts are few
TRUTHFUL = "needs the truth"


@dataclass(frozen=True)
class Recording:
    """Rows of all parts, which of them are for fitting (and lead up to them), which are scored, in which unit."""

    time: Array
    z: Array
    offsets: np.ndarray
    covariance: Array | None
    sensor: Any
    fitting: np.ndarray
    scored: np.ndarray
    unit: np.ndarray
    fitted: str
    units: str

    def keywords(self) -> dict[str, Any]:
        """For ``filter(**recording.keywords())``."""
        return {"time": self.time, "z": self.z, "offsets": self.offsets, "covariance": self.covariance}


def race_on_file(
    path: str,
    names: list[str],
    *,
    kind: str = "aircraft",
    columns: Mapping[str, str] | None = None,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
    guests: Sequence[Entrant] = (),
) -> Race:
    """See :func:`jink.compare.compare`; guests take part beside the named ones. Errors: InputError where no row can be scored."""
    kind_of(kind)
    recording, rows, skipped_rows = read(path, kind, seed, columns)
    purpose = purpose_of(path, recording, kind)
    entrants: dict[str, Entrant] = {guest.name: guest for guest in guests}
    skipped = {"rows": f"{skipped_rows} rows in another number of axes"} if skipped_rows else {}
    for name in names:
        try:
            entrants[name] = _enter(name, purpose, seed)
        except Unfit as reason:
            skipped[name] = str(reason)
    answers: dict[str, dict[str, Any]] = {}
    try:
        for name, entrant in entrants.items():
            answers[name] = predicted(entrant.filter, recording)
            if progress:
                progress(len(answers), len(entrants))
    except KeyboardInterrupt:
        if not answers:
            raise
        skipped |= {name: "interrupted" for name in entrants if name not in answers}
    used = recording.scored.copy()
    for name, answer in answers.items():
        if name != "raw":
            used &= np.isfinite(answer["prediction_score"]) & np.isfinite(answer["prediction_rmse"])
    if not used.any():
        raise InputError(f"{path}: no row is predicted by all filters: {', '.join(answers)}")
    units = int(np.unique(recording.unit[used]).size)
    return Race(
        scenario=path,
        words=f"{rows} recorded rows without truth; {int(used.sum())} held-out ones are scored",
        runs=units,
        asked=units + any(why == "interrupted" for why in skipped.values()),
        seed=seed,
        entrants={name: entrants[name] for name in answers},
        tallies={name: _tally(answer, recording, used) for name, answer in answers.items()},
        skipped=skipped,
        seen=f"{sensor_in_words(recording.sensor)}: noise as estimated from the file",
        example=recorded_example(recording, {name: entrants[name].filter for name in answers}, answers),
        unit=recording.units,
        metrics=METRICS,
        compared=("prediction_rmse", "prediction_score"),
    )


def read(
    path: str, kind: str, seed: int, columns: Mapping[str, str] | None = None
) -> tuple[Recording, int, int]:
    """A file's recording, rows of it, rows left out. Errors: InputError."""
    group, sensor, covariance, left_out = prepared(path, kind, columns)
    return split(group, sensor, covariance, seed), len(group.time), left_out


def prepared(
    path: str, kind: str, columns: Mapping[str, str] | None = None
) -> tuple[Placed, Any, Array | None, int]:
    """Clean and place a file as ``jink track`` does: the larger group of rows, their sensor and (if it differs) the noise of
    each, and how many rows are in another number of axes. Errors: InputError."""
    measurements = load_files([path], Reading(columns)).measurements
    how = Cleaning(kind_of(kind).gap(usual_step(measurements.rows)), 4, True, True, True)
    cleaned = clean(measurements.rows, measurements.position, how)
    if not cleaned.rows.height:
        raise InputError(f"{path}: no row is left after cleaning; jink track says why")
    groups = place(cleaned.rows, measurements.position, None, None, False)
    group = max(groups, key=lambda each: len(each.time))
    level = noise_levels(group, {}, kind)
    begin_with_height(group, level.covariance)
    sensor = sensor_of(group.components, level.typical)
    covariance = None if level.uniform else level.covariance
    return group, sensor, covariance, sum(len(g.time) for g in groups) - len(group.time)


def split(group: Placed, sensor: Any, covariance: Array | None, seed: int) -> Recording:
    """Which rows are for fitting and which are scored."""
    offsets, n = group.offsets, len(group.time)
    of_part = np.cumsum(group.new) - 1
    of_target = np.cumsum(changes(group.rows["target"])) - 1
    since = np.arange(n) - offsets[of_part]
    ready = (since >= START) & np.isfinite(group.z[:, :2]).all(axis=1)
    ready &= ~repeated(group.z, offsets)[:, :2].all(axis=1)
    for of, words in ((of_target, "targets"), (of_part, "parts")):
        count = int(of[-1]) + 1
        if count < FEW:
            continue
        chosen = np.isin(of, np.random.default_rng(seed).permutation(count)[: count // 2])
        return Recording(
            group.time, group.z, offsets, covariance, sensor, chosen & ready, ~chosen & ready, of,
            f"{count // 2} other {words} of this file", words,
        )  # fmt: skip
    early = since < np.diff(offsets)[of_part] / 2
    scored = ~early & ready
    return Recording(
        group.time, group.z, offsets, covariance, sensor, early & ready, scored, np.cumsum(scored) // BLOCK,
        "the first half of this file's tracks", f"blocks of {BLOCK} scans",
    )  # fmt: skip


def repeated(z: Array, offsets: np.ndarray) -> np.ndarray:
    """Which components (N, m) of measurements equal, to the last bit, the one measured before them in their part."""
    rows = np.arange(len(z))
    first = np.repeat(offsets[:-1], np.diff(offsets))
    out = np.zeros(z.shape, bool)
    for k in range(z.shape[1]):
        there = np.isfinite(z[:, k])
        latest = np.maximum.accumulate(np.where(there, rows, -1))
        before = np.r_[-1, latest[:-1]]
        out[:, k] = there & (before >= first) & (z[:, k] == z[np.maximum(before, 0), k])
    return out


def purpose_of(path: str, recording: Recording, kind: str) -> Purpose:
    def loss(filter: Any) -> float:
        estimate = filter.filter(**recording.keywords(), outputs=("log_likelihood_scan", "status"))
        rows = recording.fitting & estimate.scored
        return -float(estimate.log_likelihood_scan[rows].mean()) if rows.any() else np.inf

    steps = np.diff(recording.time)
    steps = steps[steps > 0]
    noise = recording.sensor.native()[9]
    return Purpose(
        name=path,
        kind=kind,
        sensor=recording.sensor,
        sd=float(np.sqrt(noise[0])),
        interval=float(np.median(steps)) if steps.size else 1.0,
        loss=loss,
        fitted=recording.fitted,
        outliers=Outliers(),
        recorded=True,
    )


def _enter(name: str, purpose: Purpose, seed: int) -> Entrant:
    if name.endswith(SUFFIX):
        return from_file(name, purpose, seed, 0)
    if name in ("clairvoyant", "near-optimal"):
        raise Unfit(TRUTHFUL)
    if name == "raw":
        return Entrant(name="raw", words="the last two measurements, extrapolated")
    return enter(name, purpose)


def predicted(filter: Any, recording: Recording) -> dict[str, Any]:
    """Squared error (m²) of the prediction of each row, log density of its measurement, NIS, seconds spent.

    Every row is given twice, first without its measurement: that estimate is the prediction for its time, and
    at no elapsed time nothing moves on to the second. Filters to which a row without a measurement is more than the time
    that passes (they count rows, or adapt to the last residual) predict live instead.
    """
    there = measured_position(recording.sensor, recording.z)
    if filter is None:
        return {"prediction_rmse": ((_extrapolated(there, recording) - there)[:, :2] ** 2).sum(axis=1)}
    began = clock.perf_counter()
    estimate = filter.filter(**recording.keywords(), outputs=OUTPUTS)
    seconds = clock.perf_counter() - began
    position = _predictions(filter, recording)
    counted = estimate.scored
    dof = np.where(counted, estimate.nis_dof, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        nis = np.where(dof > 0, estimate.nis / dof, np.nan)
    return {
        "prediction_rmse": ((position - there[:, :2]) ** 2).sum(axis=1),
        "prediction_score": np.where(counted, estimate.log_likelihood_scan, np.nan),
        "nis": nis,
        "nis_inside": inside_band(estimate.nis, dof),
        "gated": np.where(counted, estimate.status == Status.gated, np.nan),
        "seconds": seconds,
    }


def _predictions(filter: Any, recording: Recording) -> Array:
    """Position (N, 2) along the first axes before each row's measurement, NaN before a track starts."""
    where = [filter.components.index(name) for name in ("px", "py")]
    if getattr(filter, "counts_rows", False):
        return _predicted_live(filter, recording)[:, where]
    z = np.full((2 * len(recording.z), recording.z.shape[1]), np.nan)
    z[1::2] = recording.z
    covariance = None if recording.covariance is None else np.repeat(recording.covariance, 2, axis=0)
    estimate = filter.filter(
        np.repeat(recording.time, 2), z, offsets=2 * recording.offsets, covariance=covariance, outputs=("x",)
    )
    return estimate.x[::2][:, where]


def _predicted_live(filter: Any, recording: Recording) -> Array:
    """Scan by scan, all parts at once; those that have ended wait at their last row without a measurement."""
    first, count = recording.offsets[:-1], np.diff(recording.offsets)
    live, x = (
        filter.start(len(count), outputs=("x",)),
        np.full((len(recording.time), len(filter.components)), np.nan),
    )
    for k in range(int(count.max(initial=0))):
        there = k < count
        row = first + np.minimum(k, count - 1)
        x[row[there]] = live.predict(recording.time[row]).x[there]
        live.update(
            recording.time[row],
            np.where(there[:, None], recording.z[row], np.nan),
            covariance=None if recording.covariance is None else recording.covariance[row],
        )
    return x


def _extrapolated(there: Array, recording: Recording) -> Array:
    """Position of the two rows before, carried on in a straight line; NaN across parts."""
    out = np.full(there.shape, np.nan)
    t = recording.time
    with np.errstate(invalid="ignore", divide="ignore"):
        ahead = ((t[2:] - t[1:-1]) / (t[1:-1] - t[:-2]))[:, None]
        out[2:] = there[1:-1] + ahead * (there[1:-1] - there[:-2])
    out[~np.isfinite(out)] = np.nan
    first = recording.offsets[:-1]
    out[np.r_[first, np.minimum(first + 1, len(t) - 1)]] = np.nan
    return out


def _tally(answer: dict[str, Any], recording: Recording, used: np.ndarray) -> Tally:
    tally = Tally()
    rows = np.flatnonzero(used)
    unit = recording.unit[rows]
    np.add.at(tally.runs, np.unique(unit) % tally.groups, 1.0)
    for name, values in answer.items():
        if name == "seconds":
            tally.costs.append((values, len(recording.time)))
        else:
            tally.add(unit, name, *part(values[rows, None]))
    return tally
