"""Numbers that are times: units since 1970 by their size, dates in digits, days, and units by the speed implied."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl

from .conventions import Conventions, Times, in_zone
from .dates import readings
from .errors import InputError
from .evidence import FASTEST, SLOWEST, Motion

# a number this large (median of the absolute values) counts these units since 1970; below 1e8: plain seconds
SIZES = ((1e17, "ns", 1e-9), (1e14, "us", 1e-6), (1e11, "ms", 1e-3), (1e8, "s", 1.0))
LATEST = 2.5e11  # s since 1970: the year 9892
EARLY = 631_152_000.0  # s since 1970: the year 1990, before which nobody logged positions
DAY = 86400.0
WORDS = {"ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
WILD = 1e100  # no unit makes this a time
# days since other beginnings: the least and the largest number from 1990 to 2040, and the number of 1970-01-01
DAYS = {
    "days since 1899-12-30 (as spreadsheets and Geolife count)": (32_874.0, 47_891.0, 25_569.0),
    "modified Julian days": (47_892.0, 66_154.0, 40_587.0),
    "MATLAB datenum": (726_834.0, 745_096.0, 719_529.0),
    "Julian days": (2_447_892.5, 2_466_154.5, 2_440_587.5),
}
# ticks since other beginnings: the least and the largest number from 1990 to 2040, seconds of one, and the number's
# second in 1970. As time since 1970 they would be of 1973 to 1990, or of centuries to come.
TICKS = (
    ("ticks of 100 ns since the year 1 (.NET)", 6.2766e17, 6.4345e17, 1e-7, 62_135_596_800.0),
    ("ticks of 100 ns since 1601 (Windows)", 1.22755e17, 1.38536e17, 1e-7, 11_644_473_600.0),
    ("microseconds since 1601 (WebKit)", 1.22755e16, 1.38536e16, 1e-6, 11_644_473_600.0),
)
MINUTES = 20  # so many, none of which has seconds from 60 on, are minutes
DIGITS = ((14, 1e13, 1e14), (12, 1e11, 1e12))  # yyyymmddHHMMSS and yyyymmddHHMM as numbers


def size_of(value: np.ndarray) -> float:
    """The median size of the numbers."""
    known = value[np.isfinite(value)]
    return float(np.quantile(np.abs(known), 0.5, method="lower")) if known.size else 0.0


def numeric_times(where: str, value: np.ndarray, how: Conventions, motion: Motion | None) -> Times:
    """Numbers without a unit: dates written in digits, days, mixed units, or one unit for all."""
    dates = _digits(value, how)
    if dates is not None:
        return dates
    ticks = _ticks(value)
    if ticks is not None:
        return ticks
    size = size_of(value)
    for least, name, factor in SIZES:
        if size >= least:
            mixed = _mixed(value)
            if mixed is not None:
                return mixed
            if name == "s" and size < EARLY and motion is not None:
                since_start = _since_start(where, value, motion)
                if since_start is not None:
                    return since_start
            value = np.where(np.abs(value * factor) < LATEST, value, np.nan)
            note = [] if name == "s" else [f"times are taken as {name} since 1970"]
            return Times(value * factor, True, note)
    return _small(where, value, motion)


def _ticks(value: np.ndarray) -> Times | None:
    """Ticks of Windows, if every value is one."""
    known = value[np.isfinite(value)]
    for words, least, most, tick, origin in TICKS:
        if known.size and known.min() >= least and known.max() <= most:
            return Times(value * tick - origin, True, [f"times are taken as {words}; --time-unit sets another"])
    return None


def _mixed(value: np.ndarray) -> Times | None:
    """Seconds and milliseconds (or finer) in one column, if all are then within ten years."""
    size = np.abs(value)
    if _unit(np.fmin.reduce(size)) == _unit(np.fmax.reduce(size)):
        return None
    size = np.nan_to_num(size)
    factor = np.select([size >= least for least, _, _ in SIZES], [f for _, _, f in SIZES], np.nan)
    units = [name for least, name, f in SIZES if (factor == f).any()]
    seconds = value * factor
    known = seconds[np.isfinite(seconds)]
    if len(units) < 2 or known.size < np.isfinite(value).sum() or np.ptp(known) > 10 * 365 * DAY:
        return None
    shares = ", ".join(f"{int((factor == f).sum())} in {name}" for _, name, f in SIZES if (factor == f).any())
    return Times(seconds, True, [f"times are in several units since 1970, each value in its own: {shares}"])


def _unit(size: float) -> str | None:
    """The name of the unit in which times since 1970 are of this size."""
    return next((name for least, name, _ in SIZES if size >= least), None)


def _digits(value: np.ndarray, how: Conventions) -> Times | None:
    """20240115143000 and 202401151430 are dates, if every value is one."""
    known = np.isfinite(value)
    some = value[known]
    for digits, least, most in DIGITS:
        if some.size and some.min() >= least and some.max() < most and (some % 1 == 0).all():
            text = pl.Series(np.where(known, value, 0).astype("int64")).cast(pl.String)
            best = readings(text)
            if best and best[0].count == known.sum():
                seconds = in_zone(best[0].seconds, best[0].naive, how)
                return Times(seconds, True, [f"times of {digits} digits are read as dates (year first)"])
    return None


def _since_start(where: str, value: np.ndarray, motion: Motion) -> Times | None:
    """Numbers that would be dates before 1990 as seconds: finer units since a start, if only one is possible."""
    distance, elapsed = motion.steps(value)
    if distance.size < 3 or np.median(distance / elapsed) >= SLOWEST:
        return None
    pace = float(np.median(distance / elapsed))
    reported = motion.reported_speed()
    possible = []
    for name, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        speed = pace / factor
        fits = 0.2 < speed / reported < 5.0 if np.isfinite(reported) else 2 * SLOWEST <= speed <= FASTEST
        if fits:
            possible.append((name, factor, speed))
    if len(possible) == 1:
        name, factor, speed = possible[0]
        words = f"times are taken as {name} since a start (median speed {speed:.3g} m/s; as s {pace:.2g} m/s)"
        return Times(value * factor, False, [f"{words}; --time-unit sets it"])
    some = value[np.isfinite(value)]
    first = float(some[0] if some[0] >= SIZES[-1][0] else some[-1])
    date = (datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=first)).date()
    slow = f"{date} as seconds since 1970" if first >= SIZES[-1][0] else f"{first:.6g} s since a start"
    name, factor, speed = possible[0] if possible else ("us", 1e-6, pace * 1e6)
    raise InputError(
        f"{where}: the time {first:.0f} can be {slow}, where nothing moves ({pace:.2g} m/s), or "
        f"{first * factor:.6g} s as {WORDS[name]} since a start ({speed:.3g} m/s); "
        f"give --time-unit {name} (or s, ms, us, ns)"
    )


def _small(where: str, value: np.ndarray, motion: Motion | None) -> Times:
    """Numbers below 1e8: plain seconds, unless they are times of day in digits, or the speed that they imply says days
    or finer units.
    """
    digits = _day_in_digits(value)
    if digits is not None:
        return digits
    if motion is None:
        return Times(value, False, [])
    distance, elapsed = motion.steps(value)
    if distance.size < 3:
        return Times(value, False, [])
    pace, reported = float(np.median(distance / elapsed)), motion.reported_speed()
    known = value[np.isfinite(value)]
    for words, (least, most, origin) in DAYS.items():
        if known.min() >= least and known.max() <= most:
            as_days = pace / DAY
            if np.isfinite(reported) and not 0.2 < as_days / reported < 5.0:
                continue
            if pace > FASTEST and as_days <= FASTEST:
                # a millisecond is the finest that a double holds of a day number; whole microseconds would be noise
                seconds = np.round((value - origin) * DAY, 3)
                said = f"times are taken as {words}: median speed {as_days:.3g} m/s, as plain seconds {pace:.3g} m/s"
                return Times(seconds, True, [said])
    if np.isfinite(reported):
        for name, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
            # the reported speed may be in any unit of speed, so a factor of four either way is the same speed
            if 0.24 < pace / factor / reported < 4.2 and pace < 0.05 * reported:
                words = f"times are taken as {name}: positions then move as fast as the reported speed says"
                return Times(value * factor, False, [f"{words}; --time-unit sets it"])
    elif motion.position == "geographic" and (known % 1 == 0).all() and _leads_on(motion, value):
        finer = _since_start(where, value, motion)
        if finer is not None:
            return finer
    return Times(value, False, [])


def _leads_on(motion: Motion, value: np.ndarray) -> bool:
    """Whether whole numbers, 20 and more apart, belong to positions that go on and on as slowly as nothing does."""
    distance, elapsed = motion.steps(value)
    if np.median(elapsed) < 20 or np.median(distance / elapsed) >= SLOWEST:
        return False
    return motion.gets_somewhere(value)


def _day_in_digits(value: np.ndarray) -> Times | None:
    """HHMMSS and HHMMSS.ss: over several minutes no number of seconds or minutes is 60 or more."""
    known = value[np.isfinite(value)]
    if known.size < 20 or known.min() < 0 or known.max() >= 240_000 or np.ptp(known // 100) < 2:
        return None
    second, minute = np.floor(known % 100), known // 100 % 100
    # plain seconds would fall on 60 to 99 in two of five cases: of 20 that never do one in 27,000 is left; but steps
    # such as 5,000 never do either, so several seconds (or minutes, over an hour) have to occur
    several = np.unique(second).size >= 5 or (np.unique(minute).size >= 5 and np.ptp(known // 10_000) >= 1)
    if (second >= 60).any() or (minute >= 60).any() or np.unique(known).size < 20 or not several:
        return None
    seconds = value // 10_000 * 3600 + value // 100 % 100 * 60 + value % 100
    if not _goes_on(np.unique(known), np.unique(seconds[np.isfinite(value)])):
        return None
    return Times(seconds, False, ["times are read as hours, minutes and seconds of the day (HHMMSS)"], True)


def _goes_on(digits: np.ndarray, seconds: np.ndarray) -> bool:
    """Whether times go on from one minute to the next as they do within it; both sorted.

    Plain seconds of a few short recordings may all end on 0 to 59. Then the time between two of them is no usual one.
    """
    elapsed, crossing = np.diff(seconds), np.diff(digits // 100) > 0
    if np.count_nonzero(crossing) >= MINUTES or crossing.all():
        return True
    return bool(np.median(elapsed[crossing]) <= 5.0 * np.median(elapsed[~crossing]))
