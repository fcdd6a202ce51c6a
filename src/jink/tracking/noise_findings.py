"""What cannot be true of the noise of measurements: findings of `plausibility` that are about it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import polars as pl

from .finding import Finding, named
from .seen import Seen, sds_of_independent

LEAST_SD, LARGEST_SD = 0.005, 20e3  # m, of a position's estimated noise
GIVEN = 5.0  # times the scatter of the data: a given noise is too large, if it is about their variance, or if
NIS_GIVEN = 0.15  # no mean NIS per dimension is above this, and
GIVEN_ANYHOW = 8.0  # it is so many times their scatter
NIS_MEAN = (0.05, 5.0)  # per dimension
NIS_ROWS = 100
CORRELATED = 0.5  # share of the targets whose errors are correlated


def estimated_noise(noise: Sequence[dict[str, Any]], targets: pl.DataFrame) -> Iterator[Finding]:
    """Estimated noise against what a sensor of positions can have."""
    for line in noise:
        sd = line.get("position_sd")
        if sd is None or line.get("position_sd_from") != "estimated" or LEAST_SD <= sd <= LARGEST_SD:
            continue
        small = sd < LEAST_SD
        yield Finding(
            "noise_tiny" if small else "noise_huge",
            f"the positions of {line['source']} scatter by {sd:.2g} m",
            **named(targets),
            likely="positions that were smoothed or computed before, or a wrong unit"
            if small
            else "several targets under one name, or a wrong unit",
            mend="--sensor-sd sets the noise; --columns names units and identifiers",
            fatal=not small,
        )


def given_noise(
    noise: Sequence[dict[str, Any]], targets: pl.DataFrame, consistency: dict[str, float]
) -> Iterator[Finding]:
    """Noise that was given against what the data show: a variance for an sd hides in no NIS, since targets turn.

    Errors that last scatter less than they are large, but not by their square.
    """
    small = consistency.get("mean_per_dimension", np.inf) < NIS_GIVEN and targets["error_sd"].null_count() > 0
    for line in noise:
        for name in ("position", "range", "altitude"):
            given, seen = line.get(f"{name}_sd"), line.get(f"{name}_sd_seen")
            if given is None or seen is None or given < GIVEN * seen:
                continue
            square = 0.5 < given / seen**2 < 2.0
            if not square and not (small and given > GIVEN_ANYHOW * seen):
                continue
            yield Finding(
                "noise_given",
                f"the given {name} noise is {_metres(given)} m, and {line['source']} scatters by {_metres(seen)} m",
                **named(targets),
                likely="a variance, where a standard deviation is expected"
                if square
                else "noise that is set too large",
                mend=f"--sensor-sd {name}={_metres(seen)} is what the data show; without it, jink estimates the noise",
            )


def _metres(value: float) -> str:
    return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"


def inconsistent(seen: Seen, noise: Sequence[dict[str, Any]], consistency: dict[str, float]) -> Iterator[Finding]:
    """The innovations of all rows against what the filter says of them; errors that last make them small."""
    mean = consistency.get("mean_per_dimension")
    if mean is None or NIS_MEAN[0] <= mean <= NIS_MEAN[1]:
        return
    if mean < NIS_MEAN[0] and any("lasting_sd" in line for line in noise):
        return
    if seen.scored < NIS_ROWS:
        return
    large = mean > NIS_MEAN[1]
    yield Finding(
        "inconsistent",
        f"innovations are {np.sqrt(mean):.2g} times what the filter expects (mean NIS {mean:.2g} per dimension)",
        **named(seen.targets),
        likely="noise that is set too small, or another kind of target" if large else "noise that is set too large",
        mend="--sensor-sd sets the noise, --kind the motion",
    )


def errors_that_last(targets: pl.DataFrame, noise: Sequence[dict[str, Any]]) -> Iterator[Finding]:
    """Errors that last: no filter takes them out, and where the noise does not count them, sds are too small."""
    some = targets.filter(pl.col("error_sd").is_not_null())
    counted = [line for line in noise if "lasting_sd" in line]
    if counted and some.height:
        sd, seconds = (float(np.median([line[name] for line in counted])) for name in ("lasting_sd", "lasting_seconds"))
        yield Finding(
            "correlated",
            f"errors of about {sd:.2g} m lasting about {seconds:.2g} s; they count as noise, and the sds of positions "
            "have them, but no filter takes them out",
            **named(some),
            likely="a satellite receiver, or positions that were smoothed before",
            mend=f"--sensor-sd {sd:.2g} takes them for independent errors",
        )
        return
    if not (estimated := sds_of_independent(noise)):
        return
    assumed = max(estimated)
    some = targets.filter(pl.col("error_sd") > 2.0 * assumed)
    if not some.height or some.height < CORRELATED * targets.height:
        return
    sd, seconds = np.median(some["error_sd"].to_numpy()), np.median(some["error_seconds"].to_numpy())
    yield Finding(
        "correlated",
        f"errors of about {sd:.2g} m lasting about {seconds:.2g} s; the track takes {assumed:.2g} m of them for noise "
        "and the rest for motion, so its sds are too small",
        **named(some),
        likely="a satellite receiver, or positions that were smoothed before",
        mend=f"--sensor-sd {sd:.2g} counts them as noise",
    )


def slant_ranges(targets: pl.DataFrame, noise: Sequence[dict[str, Any]]) -> Iterator[Finding]:
    """Ranges without heights of targets that fly high above the radar."""
    high = targets.filter(pl.col("slant").is_not_null())
    if high.height and any("range_sd" in line for line in noise):
        yield Finding(
            "slant_range",
            f"paths bend as those of targets {high['slant'].min():.0f} to {high['slant'].max():.0f} m above the radar "
            "do",
            **named(high),
            likely="slant ranges without heights, taken for ranges along the ground",
            mend="--columns elevation_deg=NAME or altitude=NAME gives the heights",
        )
