"""What is believed of plots without identity: their noise, how surely a target is seen, how many there are."""

from __future__ import annotations

import numpy as np

from ..association.batch import Found
from ..catalogue.targets import kind_of
from ..frozen import frozen
from .noise_level import USUAL_ALTITUDE_SD, USUAL_POLAR_SD, noise_levels
from .placing import Placed
from .prepare import Settings

FIRST_DETECTION = 0.9
LONG = 5  # plots from which a track counts as a target that was there
FIRST = 5  # scans at whose start a target is there from the start


@frozen
class Given:
    """What the user said, which is not estimated."""

    settings: Settings
    detection: bool
    new_per_hour: bool


@frozen
class Beliefs:
    """sd of each component, detection probability; targets at the start and new ones per hour, None: unknown yet."""

    sd: dict[str, float]
    detection: float
    new_per_hour: float | None
    targets: float | None = None

    def corrected(self, found: Found, tracks: Placed, scan_time: np.ndarray, given: Given) -> Beliefs:
        """As the tracks of a pass show it."""
        starts = np.flatnonzero(np.r_[True, np.diff(found.id) != 0])
        plots = np.add.reduceat((found.plot >= 0).astype(int), starts)
        long = plots >= LONG
        early = found.scan[starts] < FIRST
        hours = max(float(scan_time[-1] - scan_time[0]), 1e-9) / 3600.0
        # half a target more than were seen, so that there may be others
        late = ((long & ~early).sum() + 0.5) / hours
        return Beliefs(
            _noise(tracks, self.sd, given.settings),
            self.detection if given.detection else _detection(found),
            self.new_per_hour if given.new_per_hour else float(late),
            float((long & early).sum()) + 0.5,
        )

    def like(self, other: Beliefs) -> bool:
        """Within 5 %; the numbers of targets within a quarter."""
        sharp = all(abs(value / other.sd[name] - 1) < 0.05 for name, value in self.sd.items())
        counts = ((self.new_per_hour, other.new_per_hour), (self.targets, other.targets))
        return (
            sharp
            and abs(self.detection / other.detection - 1) < 0.05
            and all(a == b or (a is not None and b and abs(a / b - 1) < 0.25) for a, b in counts)
        )


def assumed(plots: Placed, settings: Settings, detection: float | None, new_per_hour: float | None) -> Beliefs:
    """What was given, and what is usual for the rest."""
    polar = plots.components[0] == "range"
    usual = USUAL_POLAR_SD if polar else {"position": kind_of(settings.kind).position_sd, "altitude": USUAL_ALTITUDE_SD}
    names = plots.components if polar else ("position", *(("altitude",) * (plots.axes - 2)))
    given = dict(settings.sensor_sd)
    if "z" in given:
        given.setdefault("altitude", given["z"])
    return Beliefs({n: given.get(n, usual[n]) for n in names}, detection or FIRST_DETECTION, new_per_hour)


def _noise(tracks: Placed, sd: dict[str, float], settings: Settings) -> dict[str, float]:
    """Of each component, as tracks show it."""
    if np.isfinite(tracks.z[:, 0]).sum() < 30:
        return sd
    typical = noise_levels(tracks, settings.sensor_sd, settings.kind).typical
    return {name: float(typical.get(name, value)) for name, value in sd.items()}


def _detection(found: Found) -> float:
    """Share of scans with a plot, from each track's confirmation to its last plot."""
    hits = scans = 0
    for rows in np.split(np.arange(len(found.id)), np.flatnonzero(np.diff(found.id)) + 1):
        sure, seen = found.confirmed[rows], found.plot[rows] >= 0
        if sure.any() and seen.any():
            inner = rows[np.argmax(sure) + 1 : len(rows) - np.argmax(seen[::-1]) - 1]
            hits += int((found.plot[inner] >= 0).sum())
            scans += len(inner)
    # one success and one failure more than were seen, so that it is neither 0 nor 1
    return float(np.clip((hits + 1) / (scans + 2), 0.3, 0.99)) if scans else FIRST_DETECTION
