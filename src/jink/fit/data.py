"""What a filter is fitted on: training runs of scenarios, or the fitting half of recorded tracks, with truth if there
is any.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.purpose import Purpose
from ..checks import Array
from ..compare.entrants import Entrant, with_default
from ..compare.recorded import race_on_file, read
from ..compare.result import Race
from ..compare.simulated import FIRST, prepare, race
from ..compare.source import drawn
from ..filters.axis_by_axis import of_one_axis
from ..frozen import frozen
from ..io.errors import InputError
from ..models.tracks import Tracks, joined
from ..scenarios import Scenario, by_name
from .truth import score_truth
from .truth_checks import check_truth

FITTING = 1 << 41  # numbers of the runs fitted on begin here: no race reaches them, nor its training runs
SHOWN = 40  # held-out runs that the report page shows
ALSO = ("raw", "kalman-cv", "kalman-ca", "imm")
SIMULATED_TRUTH = {
    **{f"p{a}": f"true_{a}" for a in "xyz"},
    **{f"v{a}": f"true_velocity_{a}" for a in "xyz"},
}
MEASURED_AS = {"p": "x", "v": "velocity_x"}  # roles whose units true positions and velocities may be in


@frozen(kw_only=True)
class Training:
    """tracks to fit on; the purpose that filters are made for; check(entrants): a race on data held out, some of whose
    tracks are held_out; apart: what keeps the two from meeting, as a filter's file says it; words for people; joint():
    the same with all axes in one track, where every axis is a track of its own."""

    name: str
    words: str
    tracks: Tracks
    purpose: Purpose
    check: Callable[[Sequence[Entrant]], Race]
    runs: int
    apart: str
    unit: str
    held_out: Tracks
    joint: Callable[[], Training] | None = None


def from_scenarios(
    names: Sequence[str | Scenario], runs: int, seed: int, check_runs: int, joint: bool = False
) -> Training:
    """Training draws of one scenario or several of the same axes; joint: all axes in one track. Errors: InputError."""
    try:
        scenarios = [each if isinstance(each, Scenario) else by_name(each) for each in names]
    except ValueError as error:
        raise InputError(str(error)) from None
    first = prepare(drawn(scenarios[0], 1, seed), FIRST)
    apart = first.purpose.per_axis and len(scenarios) == 1 and first.purpose.seen.position_only and not joint
    parts = [_simulated(s, runs, FITTING, seed, f, apart) for f, s in enumerate(scenarios)]
    axes = {part.z.shape[1] for part in parts}
    if len(axes) > 1:
        raise InputError(
            f"{', '.join(s.name for s in scenarios)}: these scenarios are measured in different numbers of components; "
            "expected the same number in all"
        )
    name = ",".join(s.name for s in scenarios)
    tracks = joined(parts)
    if len(parts) == 1:  # whose noise is the sensor's
        tracks = replace(tracks, covariance=None)

    def check(entrants: Sequence[Entrant]) -> Race:
        found = race(scenarios[0], list(ALSO), check_runs, seed, guests=entrants)
        if len(scenarios) > 1:
            others = ", ".join(s.name for s in scenarios[1:])
            found.words += f" (the first of {len(scenarios)} scenarios; jink compare checks the filter on {others})"
        return found

    return Training(
        name=name,
        words=f"{runs} training runs of {' and '.join(s.name for s in scenarios)}",
        tracks=tracks,
        purpose=first.purpose,
        check=check,
        runs=runs,
        apart="all",
        unit="runs",
        held_out=_simulated(scenarios[0], SHOWN, 0, seed, 0, apart),
        joint=partial(from_scenarios, names, runs, seed, check_runs, joint=True) if apart else None,
    )


def _simulated(scenario: Scenario, runs: int, first: int, seed: int, family: int, apart: bool) -> Tracks:
    made = scenario.simulate(np.arange(first, first + runs), seed)
    sensor = scenario.observation.sensor
    axes = 1 if apart else int(sensor.axes or 2)
    B, S = made.time.shape
    kinds = {"p": made.truth.position, "v": made.truth.velocity}
    copies = made.z.shape[2] if apart else 1
    counts = np.tile(np.arange(S) >= min(FIRST, S - 1), B * copies)
    common: dict[str, Any] = {"counts": counts, "family": np.full(B * copies, family)}
    owner = np.repeat(made.runs + (family << 44), copies)
    if apart:
        truth = np.stack([np.swapaxes(kinds[c], 1, 2).reshape(-1) for c in "pv"], axis=1)
        z = np.ascontiguousarray(np.swapaxes(made.z, 1, 2).reshape(-1, 1))
        time, components = np.repeat(made.time, copies, axis=0).reshape(-1), ("px", "vx")
    else:
        truth = np.concatenate([kinds[c][..., :axes].reshape(B * S, -1) for c in "pv"], axis=1)
        z, time = made.z.reshape(B * S, -1), made.time.reshape(-1)
        seen = "xyz"[: min(axes, kinds["p"].shape[2])]
        components = tuple(c + a for c in "pv" for a in seen)
    noise = None
    variance = np.diag(sensor.noise)
    if sensor.cartesian and not (sensor.noise - np.diag(variance)).any():
        noise = np.broadcast_to(variance[: z.shape[1]], z.shape)
    return Tracks(
        time,
        z,
        np.arange(B * copies + 1) * S,
        noise,
        truth=truth,
        components=components,
        owner=owner,
        **common,
    )


def from_file(
    path: str,
    kind: str,
    seed: int,
    columns: Mapping[str, str] | None,
    truth: Mapping[str, str] | None,
    positions: bool = False,
) -> Training:
    """The fitting half of a file's tracks, as ``jink compare`` splits them; positions: a radar's plots become
    positions. Errors: InputError.
    """
    recording = read(path, kind, seed, columns, positions)
    tracks = recording.tracks
    if truth is not None:
        true = true_values(path, recording.row, truth)
        check_truth(true, tuple(truth), recording)
        tracks = replace(tracks, truth=true, components=tuple(truth))
    still = tracks.repeated[:, :2].all(axis=1)
    tracks = replace(tracks, new=~still)
    measured = np.isfinite(tracks.z[:, :2]).all(axis=1)
    if measured.sum() - still.sum() <= len(tracks):  # the first of every part repeats nothing
        raise InputError(f"{path}: the positions never change; there is nothing to fit")
    fitting = _fitting(tracks)
    assert tracks.owner is not None
    targets = len(set(tracks.owner[tracks.of_row[recording.fitting]]))

    def check(entrants: Sequence[Entrant]) -> Race:
        found = race_on_file(
            path,
            with_default(list(ALSO), kind),
            kind=kind,
            columns=columns,
            seed=seed,
            guests=entrants,
            positions=positions,
        )
        if tracks.truth is not None:
            score_truth(found, recording, tracks.truth, tracks.components)
        return found

    return Training(
        name=path,
        words=f"{targets} targets, {int(recording.fitting.sum()):,} rows of {path}",
        tracks=fitting,
        purpose=recording.purpose,
        check=check,
        runs=len(fitting),
        apart="seed",
        unit=recording.units,
        held_out=_held_out(tracks, recording.scored),
    )


def _fitting(tracks: Tracks) -> Tracks:
    """Parts with rows to fit on; where time is split, without the rows after the last of these."""
    assert tracks.counts is not None
    rows = np.where(tracks.counts, np.arange(tracks.rows), -1)
    lengths = np.maximum.reduceat(rows, tracks.first) - tracks.first + 1
    kept = np.flatnonzero(lengths > 0)
    if not kept.size:
        raise InputError("no rows to fit on: every part of a track has fewer than 4 rows; expected longer tracks")
    return tracks.heads(kept, lengths[kept])


def _held_out(tracks: Tracks, scored: np.ndarray) -> Tracks:
    """All rows of the parts that are scored, those that are counting."""
    there = np.logical_or.reduceat(scored, tracks.first)
    return replace(tracks, counts=scored).some(np.flatnonzero(there))


def along_axes(training: Training, start: Any) -> Training:
    """The same data for a filter that starts from this one: every axis as a track of its own where it has one axis, all
    in one track where it has several."""
    if training.joint is not None and not of_one_axis(start):
        return training.joint()
    if not of_one_axis(start) or training.tracks.z.shape[1] < 2 or not training.purpose.sensor.position_only:
        return training
    apart, shown = training.tracks.axes_apart(), training.held_out.axes_apart()
    return replace(training, tracks=apart, held_out=shown, words=f"{training.words}, each axis by itself")


def parse_truth(given: str | None, path: str) -> dict[str, str] | None:
    """`px=true_x,vx=true_velocity_x` to component and column; `true`: the columns that jink simulate writes, as the
    file has them.
    """
    if given is None:
        return None
    if given == "true":
        from ..io.files import open_table

        names = open_table(Path(path)).names
        there = {name: column for name, column in SIMULATED_TRUTH.items() if column in names}
        return there or {"px": SIMULATED_TRUTH["px"]}
    pairs: dict[str, str] = {}
    for item in given.split(","):
        name, equals, column = (text.strip() for text in item.partition("="))
        if not equals or not column or name not in SIMULATED_TRUTH:
            raise InputError(
                f"--truth: expected COMPONENT=COLUMN, for example px=true_x,vx=true_velocity_x, got {item!r}. "
                "The word true alone stands for the columns that jink simulate writes"
            )
        pairs[name] = column
    return pairs


def true_values(path: str, row: np.ndarray, truth: Mapping[str, str]) -> Array:
    """Columns of a file (N, c) at its rows, in m and m/s: names with a unit say their own."""
    from ..io.columns import normal, unit_of
    from ..io.files import open_table

    table = open_table(Path(path))
    missing = [name for name in truth.values() if name not in table.names]
    if missing:
        raise InputError(f"--truth: {path} has no column {missing[0]!r}; it has {', '.join(table.names)}")
    frame, _ = table.read(sorted(set(truth.values())))
    at = np.full(int(row.max()) + 1, -1)
    numbers = frame["row"].to_numpy()
    used = numbers <= row.max()
    at[numbers[used]] = np.flatnonzero(used)
    found = []
    for component, name in truth.items():
        unit = unit_of(MEASURED_AS[component[0]], normal(name)) or 1.0
        found.append(unit * frame[name].cast(float).fill_null(np.nan).to_numpy()[at[row]])
    return np.stack(found, axis=1)
