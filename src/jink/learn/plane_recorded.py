"""A correction in the plane learned on recorded tracks beside random families: their smoothed positions are the truth,
and radars that are drawn at random see them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..catalogue.choose import default_filter
from ..checks import Array
from ..compare.entrants import Entrant
from ..compare.recorded import Recording, race_on, read
from ..compare.result import Race
from ..filters.corrected import Corrected
from ..fit.truth import score_truth
from ..models.provenance import VERSION, Trained
from ..models.sensor import Position
from ..models.tracks import Tracks
from .how import How
from .plane import drawn, fit_plane, left_over
from .plane_families import SPREADS
from .plane_inputs import Pairs, pairs_of
from .recorded import Flown, Radar, flown, seen
from .recorded import drawn as drawn_radar

RADARS, CHECK, UNSEEN = 24, 4, 6  # to learn from, to choose the epoch by, and for the figures
COUNT = 6.0  # what a square of a recorded track counts, over one of a random family
FAMILIES, HIDDEN, EPOCHS = 1200, 40, 30
SETTLED = 10  # scans of a track before it is scored
FEWEST = 4  # targets of each half


def corrector(path: str, how: How, columns: Mapping[str, str] | None = None) -> tuple[Corrected, Recording]:
    """The kind's default filter with a correction, and the recording: it learned on the rows for fitting.

    Errors: ValueError where too few targets have a smooth truth.
    """
    recording = read(path, how.kind, how.seed, columns, positions=True)
    learning, unseen = halves(recording)
    if recording.units != "targets" or min(len(learning), len(unseen)) < FEWEST:
        raise ValueError(f"{path}: expected at least {2 * FEWEST} targets with dense positions")
    rng, axes = np.random.default_rng([how.seed, 7]), recording.tracks.z.shape[1]
    parts = [_pairs(learning, how, rng, k, axes, "radars") for k in range(RADARS + CHECK)]
    families, epochs = how.families or FAMILIES, how.epochs or EPOCHS
    found = fit_plane(
        how.kind,
        families=families,
        hidden=HIDDEN,
        epochs=epochs,
        seed=how.seed,
        more=(parts[CHECK:], parts[:CHECK]),
        progress=how.progress,
    )
    names = ("families", "recorded tracks")
    figures = []
    others = (
        drawn(how.kind, max(2, families // 10), how.seed + 1),
        [_pairs(unseen, how, rng, k, axes) for k in range(UNSEEN)],
    )
    for name, some in zip(names, others, strict=True):
        for what, value in zip(("position", "velocity"), left_over(found, Pairs.joined(list(some))), strict=True):
            figures.append((f"{what} error ÷ default's, unseen {name}", value))
    targets = f"{len({each.target for each in learning})} recorded targets seen by {RADARS} radars"
    said = Trained(
        data=f"{families} random families of the kind {how.kind}, and {targets}",
        method=f"network of {HIDDEN} units that remember, {epochs} epochs of Adam",
        seeds=(how.seed,),
        figures=figures,
        version=VERSION,
    )
    filter = default_filter(how.kind, Position(sd=50.0, axes=axes))
    return Corrected(filter, replace(found, trained=said)), recording


def halves(recording: Recording) -> tuple[list[Flown], list[Flown]]:
    """What the targets did that are for learning, and the others."""
    tracks = recording.tracks
    rows = tracks.of_row
    fitting = np.bincount(rows, recording.fitting, len(tracks)) > 0
    scored = np.bincount(rows, recording.scored, len(tracks)) > 0
    one, other = flown(tracks.some(np.flatnonzero(fitting))), flown(tracks.some(np.flatnonzero(scored)))
    return one, other


def _pairs(some: Sequence[Flown], how: How, rng: np.random.Generator, number: int, axes: int, words: str = "") -> Pairs:
    """Rows of all tracks as one radar sees them; every second one without heights."""
    radar = drawn_radar(rng, axes if number % 2 else 2)
    tracks = seen(some, radar, rng)
    filter = default_filter(how.kind, Position(sd=radar.sd, axes=radar.axes))
    found = pairs_of(filter, *padded(tracks), weighing=SPREADS[how.kind].weighing)
    if how.progress and words:
        how.progress(f"simulating {words}", number + 1, RADARS + CHECK)
    return replace(found, weight=(COUNT * found.weight).astype(np.float32))


def padded(tracks: Tracks) -> tuple[Array, ...]:
    """Time (B, S), z, covariance, true position, velocity and acceleration of tracks as long as the longest; NaN where
    there is no more.
    """
    assert tracks.covariance is not None and tracks.truth is not None
    lengths, rows = tracks.lengths, np.arange(int(tracks.lengths.max()))
    at = tracks.first[:, None] + np.minimum(rows, lengths[:, None] - 1)
    over = rows >= lengths[:, None]
    z, truth = tracks.z[at], tracks.truth[at]
    z[over], truth[over] = np.nan, np.nan
    return tracks.time[at], z, tracks.covariance[at], truth[..., 0:2], truth[..., 2:4], truth[..., 4:6]


def race(recording: Recording, path: str, how: How, entrants: Sequence[Entrant]) -> Race:
    """The learned filter against others, on the held-out targets as one more radar sees them."""
    rng = np.random.default_rng([how.seed, 8])
    radar = Radar(period=4.0, sd=50.0, azimuth_sd=np.radians(0.06), gross=0.01, axes=recording.tracks.z.shape[1])
    tracks = seen(halves(recording)[1], radar, rng)
    settled = np.arange(tracks.rows) - tracks.first[tracks.of_row] >= SETTLED
    assert tracks.owner is not None and tracks.truth is not None
    unit = np.unique(tracks.owner, return_inverse=True)[1][tracks.of_row]
    sensor = Position(sd=radar.sd, axes=radar.axes)
    purpose = replace(recording.purpose, sensor=sensor, sd=radar.sd, interval=radar.period, loss=None, fitted="")
    as_seen = replace(
        recording,
        tracks=replace(tracks, counts=np.zeros(tracks.rows, bool)),
        scored=settled,
        unit=unit,
        units="targets",
        row=np.arange(tracks.rows),
        left_out=0,
        purpose=purpose,
    )
    found = race_on(as_seen, path, ["raw", "imm"], seed=how.seed, guests=entrants)
    score_truth(found, as_seen, tracks.truth[:, :4], tracks.components[:4])
    found.seen = "every 4 s by radars of 50 m and .06 degrees, 1 % outliers: " + found.seen
    return found
