"""Why targets change their tracks: every switch of identity on a sky by its cause.

python -m benchmarks.sky_switches [--sky NAME] [--runs N] [--seed S] [--no-inheriting]
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import jink
from jink.metrics.skies import Picture, _Run, sky_figures
from jink.scenarios.skies import Sky, SkyRun, sky_called

from .sky_measures import tracker_of
from .sky_rows import Row
from .table import markdown

CAUSES = {
    "exchanged": "both tracks were on targets, and one is on the other's",
    "taken over": "the old track has gone to another target, a new one has begun",
    "drifted": "the old track is confirmed and on no target, a new one has begun",
    "ended": "the old track has ended or is confirmed no more, a new one has begun",
    "joined": "the old track is on no target, one that was on another is here",
    "beside": "the old track is still here, but another is nearer or confirmed",
}
TURN = np.radians(15.0)  # change of course since the last match from which it counts as a manoeuvre


@dataclass
class Switch:
    """One switch: its cause, and what the target did."""

    cause: str
    turned: bool
    at_edge: bool
    young: bool
    missed: bool  # it had no plot in the scan in which it was lost


@dataclass
class History:
    """What was matched in the scans so far: of each target its track and the scan, of each track its targets."""

    track: dict[int, int] = field(default_factory=dict)
    when: dict[int, int] = field(default_factory=dict)
    targets: dict[int, int] = field(default_factory=dict)
    born: dict[int, int] = field(default_factory=dict)


def switches(sky: Sky, run: SkyRun, pictures: list[Picture]) -> list[Switch]:
    """Every switch of one run, as `jink.metrics.sky_figures` counts them."""
    h, found = History(), []
    for k, (truth, picture) in enumerate(zip(run.truth, pictures, strict=True)):
        for target in truth.ids.tolist():
            h.born.setdefault(target, k)
        now = matched(truth, picture, h.track, sky.cutoff)
        at = dict(zip(truth.ids.tolist(), truth.points, strict=True))
        on = {track: target for target, track in now.items()}
        for target, track in now.items():
            old = h.track.get(target, track)
            if old != track:
                cause = cause_of(old, track, target, picture, on, h, at[target], sky.cutoff)
                found.append(Switch(cause, *circumstances(sky, run, k, target, h, at[target])))
        for target, track in now.items():
            h.track[target], h.when[target], h.targets[track] = track, k, target
    return found


def matched(truth: Picture, picture: Picture, last: dict[int, int], c: float) -> dict[int, int]:
    """The track of each target in this scan: the last one while it is within c, else that of GOSPA's assignment."""
    one = _Run(c)
    one.last = dict(last)
    one.add(truth, picture)
    return {target: track for target, track in one.last.items() if target in one.had}


def cause_of(
    old: int,
    new: int,
    target: int,
    picture: Picture,
    on: dict[int, int],
    h: History,
    point: np.ndarray,
    c: float,
) -> str:
    """One of CAUSES."""
    where = np.flatnonzero(picture.ids == old)
    before = h.targets.get(new, target)
    if len(where) and np.hypot(*(picture.points[where[0]] - point)) < c:
        return "beside"
    if on.get(old, target) != target:
        return "exchanged" if before != target else "taken over"
    if before != target:
        return "joined"
    return "drifted" if len(where) else "ended"


def circumstances(sky: Sky, run: SkyRun, k: int, target: int, h: History, point: np.ndarray) -> tuple[bool, ...]:
    """Whether it turned since its last match, is at the edge, has just begun, and had no plot when it was lost."""
    last = h.when[target]
    courses = []
    for scan in (max(last - 1, h.born[target]), k):
        vx, vy = run.velocity[scan][run.truth[scan].ids == target][0]
        courses.append(np.arctan2(vy, vx))
    turned = abs(np.angle(np.exp(1j * (courses[1] - courses[0])))) > TURN
    x0, x1, y0, y1 = sky.area
    edge = min(point[0] - x0, x1 - point[0], point[1] - y0, y1 - point[1]) < 500.0 * sky.interval
    young = last - h.born[target] < 3
    return bool(turned), bool(edge), young, not bool((run.scans[last + 1].origin == target).any())


def scanned(tracker: jink.Tracker, run: SkyRun) -> Iterator[Any]:
    """What the tracker says after each scan."""
    return (tracker.scan(scan.time, scan.z) for scan in run.scans)


def main() -> None:
    """Track, classify, print one line per cause."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--sky", default="sky-regional-4000-12s")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--no-inheriting", action="store_true", help="a lost track keeps its id")
    given = parser.parse_args()
    sky = sky_called(given.sky)
    counts: dict[str, Counter[str]] = {cause: Counter() for cause in CAUSES}
    counted = 0.0
    for run in sky.runs(given.runs, given.seed):
        tracker = tracker_of(sky, Row(given.sky, given.sky, 1))
        if given.no_inheriting:
            tracker.rules.inherit = np.inf
            tracker.reset()
        pictures = [Picture(p.ids[p.confirmed], p.positions[p.confirmed]) for p in scanned(tracker, run)]
        counted += sky_figures([run.truth], [pictures], sky.cutoff).switches.value
        for each in switches(sky, run, pictures):
            counts[each.cause]["all"] += 1
            for name in ("turned", "at_edge", "young", "missed"):
                counts[each.cause][name] += getattr(each, name)
    names = ("all", "turned", "missed", "at_edge", "young")
    cells = [(c, CAUSES[c], *(f"{n[name] / given.runs:.4g}" for name in names)) for c, n in counts.items()]
    total = [f"{sum(n[name] for n in counts.values()) / given.runs:.4g}" for name in names]
    head = (
        "cause",
        "what happened",
        "switches a run",
        "in a turn",
        "unseen when lost",
        "at the edge",
        "began just before",
    )
    print("\n".join(markdown(head, [*cells, ("all", "", *total)])))
    print(f"\n{given.sky}: {counted / given.runs:.4g} switches a run by jink.metrics.sky_figures, {given.runs} runs")


if __name__ == "__main__":
    main()
