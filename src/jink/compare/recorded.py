"""A race on recorded positions without truth: who predicts the next measurement best?

Whole targets are set aside for fitting, or parts of their tracks if targets are few; with few of both it is the first
half of each part, and blocks of scans take the place of targets as the units that differences are paired over. A
position that repeats the one before exactly (a target at rest, reported again) is filtered, but neither fitted nor
scored: it is no new measurement, and a density can be as high as it likes where nothing changes.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..archive.folder import is_archive
from ..archive.reading import sample
from ..catalogue.purpose import Named, Purpose, Unfit
from ..checks import Array
from ..estimate import Status
from ..filters.axis_by_axis import on_axes
from ..frozen import frozen
from ..io.errors import InputError
from ..io.loading import Reading, load_files
from ..models.tracks import Tracks
from ..scenarios.observation import sensor_in_words
from ..tracking.anonymous_options import is_anonymous
from ..tracking.converted import in_metres
from ..tracking.noise_findings import NIS_MEAN
from ..tracking.prepare import Settings, prepare
from .entrants import SUFFIX, Entrant, enter
from .example import recorded_example
from .filter_files import from_file
from .result import INTERRUPTED, Race
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


@frozen
class Recording:
    """The tracks of a file, those in two axes or those in three, whichever has more rows.

    tracks, a part of a target's each: they count the rows for fitting; scored (N,) rows are others, unit (N,) what each
    is paired in; row (N,): its place in the file; left_out: rows in another number of axes; purpose of filters for
    them, fitted on rows that tracks count; units: what the units are; sampled: in words, of how many targets of an
    archive they are.
    """

    tracks: Tracks
    scored: np.ndarray
    unit: np.ndarray
    units: str
    row: np.ndarray
    left_out: int
    purpose: Purpose
    sampled: str = ""

    @property
    def sensor(self) -> Any:
        """With the typical noise of all rows."""
        return self.purpose.sensor

    @property
    def of_sample(self) -> str:
        """In words, where only some targets were read."""
        return f" ({self.sampled})" if self.sampled else ""

    @property
    def fitting(self) -> np.ndarray:
        """Which rows are for fitting (N,)."""
        assert self.tracks.counts is not None
        return self.tracks.counts


def race_on_file(
    path: str,
    names: list[str],
    *,
    kind: str = "aircraft",
    columns: Mapping[str, str] | None = None,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
    guests: Sequence[Entrant] = (),
    more: Mapping[str, Callable[[Purpose], Named]] | None = None,
    positions: bool = False,
) -> Race:
    """See :func:`jink.compare.compare`; more: filters beside ``FILTERS``, made as those are; guests take part beside
    the named ones; positions: a radar's plots are turned into positions.

    Errors: InputError where no row can be scored.
    """
    recording = read(path, kind, seed, columns, positions)
    return race_on(recording, path, names, seed=seed, progress=progress, guests=guests, more=more)


def race_on(
    recording: Recording,
    path: str,
    names: list[str],
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
    guests: Sequence[Entrant] = (),
    more: Mapping[str, Callable[[Purpose], Named]] | None = None,
) -> Race:
    """The race on what was read of a file; see :func:`race_on_file`."""
    entrants: dict[str, Entrant] = {guest.name: guest for guest in guests}
    skipped = (
        {"rows": f"{recording.left_out} rows are left out because they have another number of axes"}
        if recording.left_out
        else {}
    )
    own = more or {}
    for name in (*names, *own):
        try:
            if name in own:
                entrants[name] = Entrant(name=name, **vars(own[name](recording.purpose)))
            else:
                entrants[name] = _enter(name, recording.purpose, seed)
        except Unfit as reason:
            skipped[name] = str(reason)
    entrants = {n: replace(e, filter=on_axes(e.filter, recording.sensor)) for n, e in entrants.items()}
    answers: dict[str, dict[str, Any]] = {}
    try:
        for name, entrant in entrants.items():
            answers[name] = predicted(entrant.filter, recording)
            if progress:
                progress(len(answers), len(entrants))
    except KeyboardInterrupt:
        if not answers:
            raise
        skipped |= {name: INTERRUPTED for name in entrants if name not in answers}
    used = recording.scored.copy()
    for name, answer in answers.items():
        if name != "raw":
            used &= np.isfinite(answer["prediction_score"]) & np.isfinite(answer["prediction_rmse"])
    if not used.any():
        if (~recording.tracks.repeated[:, :2].all(axis=1)).sum() <= len(recording.tracks):  # the first of every part
            raise InputError(f"{path}: the positions never change; there is nothing to compare")
        raise InputError(
            f"{path}: no row is predicted by all of these filters: {', '.join(answers)}; compare fewer of them"
        )
    units = int(np.unique(recording.unit[used]).size)
    example = None
    try:
        example = recorded_example(recording, {name: entrants[name].filter for name in answers}, answers)
    except KeyboardInterrupt:
        skipped["example"] = INTERRUPTED
    tallies = {name: _tally(answer, recording, used) for name, answer in answers.items()}
    return Race(
        scenario=path,
        words=f"{recording.tracks.rows} recorded rows{recording.of_sample} without truth; "
        f"{int(used.sum())} held-out ones are scored",
        runs=units,
        asked=units + any(why == INTERRUPTED for why in skipped.values()),
        seed=seed,
        entrants={name: _judged(entrants[name], tallies[name]) for name in answers},
        tallies=tallies,
        skipped=skipped,
        seen=f"{sensor_in_words(recording.sensor)}: noise as estimated from the file",
        example=example,
        unit=recording.units,
        metrics=METRICS,
        compared=("prediction_rmse", "prediction_score"),
    )


def _judged(entrant: Entrant, tally: Tally) -> Entrant:
    """The default filter with a note where it cannot be right, by the limits of `jink track`."""
    nis = tally.figure("nis").value
    if entrant.name != "imm" or not np.isfinite(nis) or NIS_MEAN[0] <= nis <= NIS_MEAN[1]:
        return entrant
    said = (
        f"its innovations are {nis**0.5:.2g} times what it expects (mean NIS {nis:.2g} per dimension). Likely: a wrong "
        "unit of time or position, or another kind of target; jink track on this file says more"
    )
    return replace(entrant, note=f"{entrant.note}; {said}" if entrant.note else said)


class WithoutIdentity(InputError):
    """A table whose rows do not say whose they are."""


def read(
    path: str, kind: str, seed: int, columns: Mapping[str, str] | None = None, positions: bool = False
) -> Recording:
    """A file, prepared as for ``jink track``, with half of it set aside for fitting; positions: a radar's plots become
    positions in metres. Errors: InputError.
    """
    sampled = ""
    if is_archive(path):
        measurements, sampled = sample(path)
    else:
        measurements = load_files([path], Reading(columns)).measurements
        if is_anonymous(measurements):
            raise WithoutIdentity(
                f"{path}: plots have no identity (several rows of one time, far apart); jink track finds the targets, "
                "and jink fit what the sensor does"
            )
    prepared = prepare(measurements, Settings(kind=kind, velocity=False))
    if not prepared.groups:
        raise InputError(f"{path}: no row is left after cleaning; jink track on this file says why")
    group = max(prepared.groups, key=lambda each: len(each.placed.time))
    if positions:
        group = in_metres(group, kind)
    placed = group.placed
    owner = placed.rows["target"].to_numpy().astype(str)[placed.offsets[:-1]]
    covariance = None if group.covariance is None else np.asarray(group.covariance)
    tracks = Tracks(placed.time, placed.z, placed.offsets, covariance, owner=owner)
    fitting, scored, unit, units, fitted = _halves(tracks, seed)
    if sampled:
        fitted = fitted.replace("this file", sampled)
    tracks = replace(tracks, counts=fitting)
    purpose = replace(group.purpose, name=path, fitted=fitted, loss=lambda filter: _loss(filter, tracks), recorded=True)
    left_out = sum(len(each.placed.time) for each in prepared.groups) - tracks.rows
    return Recording(tracks, scored, unit, units, placed.rows["row"].to_numpy(), left_out, purpose, sampled)


def _halves(tracks: Tracks, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, str, str]:
    """Rows for fitting and rows that are scored; the unit of each row, what units are, and in words what is fitted
    on.
    """
    assert tracks.owner is not None
    of_part = tracks.of_row
    of_target = np.cumsum(np.r_[False, tracks.owner[1:] != tracks.owner[:-1]])[of_part]
    since = np.arange(tracks.rows) - tracks.first[of_part]
    ready = (since >= START) & np.isfinite(tracks.z[:, :2]).all(axis=1)
    ready &= ~tracks.repeated[:, :2].all(axis=1)
    for of, words in ((of_target, "targets"), (of_part, "parts")):
        count = int(of[-1]) + 1
        if count < FEW:
            continue
        chosen = np.isin(of, np.random.default_rng(seed).permutation(count)[: count // 2])
        return chosen & ready, ~chosen & ready, of, words, f"{count // 2} other {words} of this file"
    early = since < tracks.lengths[of_part] / 2
    scored = ~early & ready
    unit, units = np.cumsum(scored) // BLOCK, f"blocks of {BLOCK} scans"
    return early & ready, scored, unit, units, "the first half of this file's tracks"


def _loss(filter: Any, tracks: Tracks) -> float:
    """Minus the mean log density of the rows that tracks count; infinite where there is none."""
    estimate = filter.filter(**tracks.keywords(), outputs=("log_likelihood_scan", "status"))
    rows = tracks.counts & estimate.scored
    return -float(estimate.log_likelihood_scan[rows].mean()) if rows.any() else np.inf


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
    at no elapsed time nothing moves on to the second. Filters to which a row without a measurement is more than the
    time that passes (they count rows, or adapt to the last residual) predict live instead.
    """
    tracks = recording.tracks
    there = recording.sensor.positions(tracks.z)
    if filter is None:
        return {"prediction_rmse": ((_extrapolated(there, tracks) - there)[:, :2] ** 2).sum(axis=1)}
    began = clock.perf_counter()
    estimate = filter.filter(**tracks.keywords(), outputs=OUTPUTS)
    seconds = clock.perf_counter() - began
    position = predictions(filter, tracks)
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


def predictions(filter: Any, tracks: Tracks) -> Array:
    """Position (N, 2) along the first axes before each row's measurement, NaN before a track starts."""
    where = [filter.components.index(name) for name in ("px", "py")]
    if getattr(filter, "counts_rows", False):
        return _predicted_live(filter, tracks)[:, where]
    return filter.filter(**tracks.doubled().keywords(), outputs=("x",)).x[::2][:, where]


def _predicted_live(filter: Any, tracks: Tracks) -> Array:
    """Scan by scan, all parts at once; those that have ended wait at their last row without a measurement."""
    first, count = tracks.first, tracks.lengths
    live, x = (
        filter.start(len(count), outputs=("x",)),
        np.full((tracks.rows, len(filter.components)), np.nan),
    )
    for k in range(int(count.max(initial=0))):
        there = k < count
        row = first + np.minimum(k, count - 1)
        x[row[there]] = live.predict(tracks.time[row]).x[there]
        live.update(
            tracks.time[row],
            np.where(there[:, None], tracks.z[row], np.nan),
            covariance=None if tracks.covariance is None else tracks.covariance[row],
        )
    return x


def _extrapolated(there: Array, tracks: Tracks) -> Array:
    """Position of the two rows before, carried on in a straight line; NaN across parts."""
    out = np.full(there.shape, np.nan)
    t = tracks.time
    with np.errstate(invalid="ignore", divide="ignore"):
        ahead = ((t[2:] - t[1:-1]) / (t[1:-1] - t[:-2]))[:, None]
        out[2:] = there[1:-1] + ahead * (there[1:-1] - there[:-2])
    out[~np.isfinite(out)] = np.nan
    first = tracks.first
    out[np.r_[first, np.minimum(first + 1, len(t) - 1)]] = np.nan
    return out


def _tally(answer: dict[str, Any], recording: Recording, used: np.ndarray) -> Tally:
    tally = Tally()
    rows = np.flatnonzero(used)
    unit = recording.unit[rows]
    np.add.at(tally.runs, np.unique(unit) % tally.groups, 1.0)
    for name, values in answer.items():
        if name == "seconds":
            tally.costs.append((values, recording.tracks.rows))
        else:
            tally.add(unit, name, *part(values[rows, None]))
    return tally
