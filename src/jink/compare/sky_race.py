"""Filters and associations on a whole sky: every entrant sees the same plots, and is told what is true of the sky."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..association.rules import ASSOCIATIONS
from ..association.tracker import Tracker
from ..catalogue.choose import choose_filter, load_filter
from ..catalogue.targets import kind_of
from ..checks import unknown
from ..frozen import frozen
from ..io.errors import InputError
from ..metrics.air_picture import Siap, siap
from ..metrics.clear_mot import ClearMot, clear_mot
from ..metrics.skies import Picture, SkyFigures, sky_figures
from ..models.radar import Radar
from ..scenarios.skies import Sky, SkyRun, sky_called
from .sky_example import SkyExample, example_of


@frozen
class SkyEntrant:
    """A filter and an association, what they came to, and milliseconds of CPU per scan."""

    filter: str
    association: str
    figures: SkyFigures
    siap: Siap
    clear_mot: ClearMot
    milliseconds: float


@frozen
class SkyRace:
    """The sky, how often it was run, and the entrants in the order they were named."""

    sky: Sky
    runs: int
    seed: int
    entrants: list[SkyEntrant]
    example: SkyExample | None = None

    def as_dict(self) -> dict[str, Any]:
        """Everything, for JSON; a figure is [value, standard error], null where there is none."""

        def plain(value: Any) -> Any:
            if isinstance(value, tuple):
                return [plain(v) for v in value]
            return None if value is None or not np.isfinite(value) else float(value)

        rows = [
            {"filter": e.filter, "association": e.association, "milliseconds_per_scan": e.milliseconds}
            | {name: plain(value) for name, value in e.figures._asdict().items()}
            | {"siap": {name: plain(value) for name, value in e.siap._asdict().items()}}
            | {"clear_mot": {name: plain(value) for name, value in e.clear_mot._asdict().items()}}
            for e in self.entrants
        ]
        sky = self.sky
        body = {"sky": sky.name, "summary": sky.summary, "cutoff": sky.cutoff, "runs": self.runs, "seed": self.seed}
        return body | {"entrants": rows}


def race_on_sky(
    name: str,
    filters: Sequence[str],
    associations: Sequence[str],
    runs: int,
    seed: int,
    *,
    kind: str = "aircraft",
    example: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> SkyRace:
    """Every filter with every association. example: keep the first run's tracks, for a page.

    Errors: ValueError for unknown names and filters that cannot do it.
    """
    sky = sky_called(name)
    for association in associations:
        if association not in ASSOCIATIONS:
            raise InputError(unknown("association", association, ASSOCIATIONS))
    pairs = [(f, a) for f in filters for a in associations]
    made = {f: _filter(f, sky, kind) for f in filters}
    for f, a in pairs:
        _tracker(made[f], sky, a, kind)
    truth: list[Any] = []
    times: list[Any] = []
    found: list[list[Any]] = [[] for _ in pairs]
    seconds = np.zeros(len(pairs))
    scans = 0
    for number in range(runs):
        run = sky.run(number, seed)
        truth.append(run.truth)
        times.append([scan.time for scan in run.scans])
        scans += len(run.scans)
        for k, (f, a) in enumerate(pairs):
            begin = time.process_time()
            found[k].append(_tracked(_tracker(made[f], sky, a, kind), sky, run))
            seconds[k] += time.process_time() - begin
        if progress:
            progress(number + 1, runs)
    c = sky.cutoff
    entrants = [
        SkyEntrant(
            f,
            a,
            sky_figures(truth, found[k], c),
            siap(truth, found[k], c, times),
            clear_mot(truth, found[k], c),
            1e3 * seconds[k] / scans,
        )
        for k, (f, a) in enumerate(pairs)
    ]
    shown = None
    if example:
        trackers = {_label(f, a, filters): _begun(_tracker(made[f], sky, a, kind), sky) for f, a in pairs}
        shown = example_of(sky.run(0, seed), trackers, kind)
    return SkyRace(sky, runs, seed, entrants, shown)


def _label(filter: str, association: str, filters: Sequence[str]) -> str:
    return association if len(filters) == 1 else f"{filter}, {association}"


def _filter(name: str, sky: Sky, kind: str) -> Any:
    return choose_filter(("x", "y"), {"position": sky.sd}, kind, load_filter(name), interval=sky.interval)


def _tracker(filter: Any, sky: Sky, association: str, kind: str) -> Tracker:
    """Told what is true of the sky."""
    radar = Radar(
        detection=sky.detection,
        clutter_per_scan=sky.false_per_scan,
        area=sky.area,
        learn_clutter=not sky.around,
    )
    try:
        return Tracker(
            filter,
            radar,
            targets=0.0 if sky.known else sky.targets,
            new_per_hour=sky.arrivals / sky.interval * 3600,
            stay=sky.life,
            speed_sd=min(sky.speed_sd, kind_of(kind).speed),
            association=association,
        )
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from None


def _tracked(tracker: Tracker, sky: Sky, run: SkyRun) -> list[Picture]:
    """The confirmed tracks of each scan."""
    _begun(tracker, sky)
    pictures = []
    for scan in run.scans:
        picture = tracker.scan(scan.time, scan.z)
        sure = picture.confirmed
        pictures.append(Picture(picture.ids[sure], picture.positions[sure]))
    return pictures


def _begun(tracker: Tracker, sky: Sky) -> Tracker:
    """With the targets whose start is known."""
    if sky.known:
        names = ("px", "vx", "py", "vy")
        components = tracker.filter.components
        for known, variance in zip(*sky.known, strict=True):
            x, P = np.zeros(len(components)), np.eye(len(components))
            at = [components.index(name) for name in names]
            x[at], P[at, at] = known, variance
            tracker.add(0.0, x, P)
    return tracker
