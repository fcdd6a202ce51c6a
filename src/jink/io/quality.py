"""What a source says of its own measurements: how accurate they are, whether they hold, whether the target is on the
ground.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
import polars as pl

from .codes import are_codes
from .columns import normal
from .sheet import Problem, Sheet
from .values import numbers, order_of, texts

# metres: 95 % horizontal bound (estimated position uncertainty) of NACp, containment radius of NIC,
# 95 % vertical bound of GVA (RTCA DO-260B)
NACP = {
    11: 3.0,
    10: 10.0,
    9: 30.0,
    8: 92.6,
    7: 185.2,
    6: 555.6,
    5: 926.0,
    4: 1852.0,
    3: 3704.0,
    2: 7408.0,
    1: 18520.0,
}
NIC = {
    11: 7.5,
    10: 25.0,
    9: 75.0,
    8: 185.2,
    7: 370.4,
    6: 1111.2,
    5: 1852.0,
    4: 3704.0,
    3: 7408.0,
    2: 14816.0,
    1: 37040.0,
}
GVA = {2: 45.0, 1: 150.0}
NACV = {1: 10.0, 2: 3.0, 3: 1.0, 4: 0.3}  # m/s: 95 % bound of the horizontal velocity's error
RAYLEIGH_95 = math.sqrt(-2.0 * math.log(0.05))  # radius of the 95 % circle of a circular Gaussian of sd 1
RAYLEIGH_NIC = math.sqrt(-2.0 * math.log(1e-5))  # NIC's radius is left once in 1e5 (the weakest integrity level, SIL 2)
RAYLEIGH_68 = math.sqrt(-2.0 * math.log(1.0 - 0.68))  # phones and receivers state the radius of the 68 % circle
GROUND = r"(?i)^\s*(ground|gnd|on ground)\s*$"
GROUND_SD = 5.0  # m: heights come in steps of 25 feet, and the last in the air is from seconds before the ground
SINK = 4.0  # m/s: of an airliner on its approach
FAR_FROM_GROUND = 300.0  # m: heights beside one stay on the ground do not differ by more
FIXED = r"base station|aton|aids? to navigation"
NO = ["false", "0", "0.0", "f", "no", "n", "v", "invalid", "no fix", "nofix", "void"]
YES = ["true", "1", "1.0", "t", "yes", "y"]


def accuracies(sheet: Sheet) -> list[pl.Series]:
    """Sds (m) of position and altitude that each row states: ADS-B's categories, NACp before NIC, or an accuracy in
    metres; NaN where unknown.
    """

    horizontal = _looked_up(sheet, "nacp", NACP, RAYLEIGH_95)
    horizontal = np.where(np.isnan(horizontal), _looked_up(sheet, "nic", NIC, RAYLEIGH_NIC), horizontal)
    vertical = _looked_up(sheet, "gva", GVA, 1.96)
    horizontal = np.where(np.isnan(horizontal), _metres(sheet, "accuracy"), horizontal)
    horizontal = np.where(np.isnan(horizontal), _from_variance(sheet), horizontal)
    vertical = np.where(np.isnan(vertical), _metres(sheet, "vertical_accuracy"), vertical)
    return [pl.Series("position_sd", horizontal), pl.Series("altitude_sd", vertical)]


def _looked_up(sheet: Sheet, role: str, table: dict[int, float], divisor: float) -> np.ndarray:
    """The sds of a column of ADS-B's categories, NaN for those that say nothing."""
    if role not in sheet:
        return np.full(sheet.frame.height, np.nan)
    category = sheet.numbers(role)
    steps = np.full(16, np.nan)
    steps[list(table)] = np.array(list(table.values())) / divisor
    known = np.isfinite(category) & (category >= 0) & (category < 16)
    return np.where(known, steps[np.where(known, category, 0).astype(int)], np.nan)


def rate_accuracies(sheet: Sheet, rates: Collection[str]) -> list[pl.Series]:
    """Sds (m/s) of velocity and vertical rate that each row states, of those rates that the table has."""
    found: list[pl.Series] = []
    flat = _looked_up(sheet, "nacv", NACV, RAYLEIGH_95)
    for role, name, known, measured in (
        ("velocity_accuracy", "velocity_sd", flat, {"course", "velocity_x"}),
        ("vertical_rate_accuracy", "vertical_rate_sd", np.full(flat.size, np.nan), {"vertical_rate"}),
    ):
        if role in sheet:
            value = sheet.numbers(role) * (sheet.roles[role].unit or 1.0)
            known = np.where(np.isnan(known) & (value > 0.0), value, known)
        if measured & set(rates) and np.isfinite(known).any():
            found.append(pl.Series(name, known))
        else:
            sheet.drop(role, *(["nacv"] if name == "velocity_sd" else []))
    return found


def _metres(sheet: Sheet, role: str) -> np.ndarray:
    """The sd per axis of an accuracy column: the radius of a 68 % circle (in height ±1 sd), except where named sd."""
    if role not in sheet:
        return np.full(sheet.frame.height, np.nan)
    column = sheet.roles[role]
    value = sheet.numbers(role) * (column.unit or 1.0)
    known = np.isfinite(value) & (value > 0.0)
    circle = role == "accuracy" and not normal(column.name).endswith("sd")
    if known.any():
        words = "the radius of a circle that holds 68 %" if circle else "an sd"
        sheet.notes.append(f"the noise of each row is that of column {sheet.shown(role)!r} (in metres, {words})")
    else:
        sheet.drop(role)
    return np.where(known, value / (RAYLEIGH_68 if circle else 1.0), np.nan)


def _from_variance(sheet: Sheet) -> np.ndarray:
    """The sd of a column of variances (m²), of the first axis for both."""
    if "variance" not in sheet:
        return np.full(sheet.frame.height, np.nan)
    value = sheet.numbers("variance")
    known = np.isfinite(value) & (value > 0.0)
    if known.any():
        sheet.notes.append(f"the noise of each row is that of column {sheet.shown('variance')!r} (a variance in m²)")
    else:
        sheet.drop("variance")
    return np.sqrt(np.where(known, value, np.nan))


def dilution(sheet: Sheet) -> np.ndarray:
    """How much rougher each row is than the middle one, by its dilution of precision (HDOP); 1 where it is not known.

    HDOP has no unit: the noise that is estimated for the source is scaled by it.
    """
    if "hdop" not in sheet:
        return np.ones(sheet.frame.height)
    value = sheet.numbers("hdop")
    known = np.isfinite(value) & (value > 0.0)
    if not known.any() or np.ptp(value[known]) == 0.0:
        sheet.drop("hdop")
        return np.ones(value.size)
    sheet.notes.append(f"the noise of each row is scaled by its dilution of precision (column {sheet.shown('hdop')!r})")
    return np.where(known, value / np.median(value[known]), 1.0)


def refused(sheet: Sheet) -> list[Problem]:
    """Rows that the source itself marks as not valid, as outliers, or as what never moves."""
    found: list[Problem] = []
    if "station" in sheet:
        fixed = texts(sheet.series("station")).str.to_lowercase().str.contains(FIXED).fill_null(False).to_numpy()
        found.append(("a base station or an aid to navigation does not move", fixed, sheet.series("station")))
    if "target" in sheet and normal(sheet.roles["target"].name) == "mmsi":
        number = numbers(sheet.series("target"))[0]
        # 00MIDxxxx and 99MIDxxxx
        fixed = (number >= 1e6) & (number < 1e7) | (number >= 9.9e8) & (number < 1e9)
        if fixed.any():
            found.append(("its MMSI is of a base station or an aid to navigation", fixed, sheet.series("target")))
    for role, marks in (("valid", NO), ("outlier", YES)):
        if role not in sheet:
            continue
        name = sheet.roles[role].name
        bad = texts(sheet.series(role)).str.strip_chars().str.to_lowercase().is_in(marks).fill_null(False).to_numpy()
        if role == "valid" and normal(name) in ("fix_type", "fixtype", "gps_fix_type"):
            # 0 and 1 are no fix, 2 is one without height
            bad |= sheet.numbers(role) < 2
        if bad.any():
            found.append((f"marked as not valid in column {name!r}", bad, sheet.series(role)))
        else:
            sheet.drop(role)
    return found


def grounded(sheet: Sheet) -> np.ndarray:
    """Rows of targets on the ground, by the word "ground" for a height or by a mark of its own."""
    ground = np.zeros(sheet.frame.height, bool)
    if "altitude" in sheet and sheet.series("altitude").dtype == pl.String:
        ground |= sheet.series("altitude").str.contains(GROUND).fill_null(False).to_numpy()
    if "on_ground" in sheet:
        if sheet.series("on_ground").dtype == pl.Boolean:
            return ground | sheet.series("on_ground").fill_null(False).to_numpy()
        marks = texts(sheet.series("on_ground")).str.strip_chars().str.to_lowercase()
        # in a column of heights, 1 is a height
        yes = [] if normal(sheet.roles["on_ground"].name) == "alt_baro" else YES
        ground |= (marks.is_in(yes) | marks.str.contains(GROUND)).fill_null(False).to_numpy()
    return ground


def on_the_ground(
    altitude: np.ndarray, ground: np.ndarray, codes: np.ndarray, seconds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Heights with those on the ground filled in, and the sd of these (NaN elsewhere).

    The height of the ground is not reported, but it is near to where the target touched it: it leads evenly from the
    last height in the air to the next one, or stays at the only one. It is the less certain, the longer nothing was
    reported in between.
    """
    missing = ground & np.isnan(altitude) & np.isfinite(seconds)
    if not missing.any():
        return altitude, np.full(altitude.size, np.nan)
    order = order_of(codes, seconds)
    gaps = np.flatnonzero(missing[order])
    rows = order[gaps]
    last, next_ = _reported(~np.isnan(altitude[order]), codes[order], gaps)
    (before, left), (after, back) = (
        [np.where(there >= 0, values[order][there], np.nan) for values in (altitude, seconds)]
        for there in (last, next_)
    )
    time = seconds[rows]
    # the first and the last time on the ground between two heights
    begins = np.r_[True, (np.diff(last) != 0) | (np.diff(next_) != 0) | (np.diff(codes[rows]) != 0)]
    firsts = np.flatnonzero(begins)
    long = np.diff(np.r_[firsts, rows.size])
    landed, rolled = np.repeat(time[firsts], long), np.repeat(time[firsts + long - 1], long)
    # one of two heights that lie so far apart is wrong, and the ground is not above an aircraft: the lower one serves
    apart = np.abs(after - before) > FAR_FROM_GROUND
    lower = np.fmin(before, after)
    before, after = np.where(apart, lower, before), np.where(apart, lower, after)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.clip((time - left) / (back - left), 0.0, 1.0)
    share = np.where(np.isnan(left), 1.0, np.where(np.isnan(back), 0.0, np.nan_to_num(share)))
    height = np.where(share < 1.0, (1.0 - share) * np.nan_to_num(before), 0.0) + share * np.nan_to_num(after)
    silent = (1.0 - share) * np.nan_to_num(landed - left) + share * np.nan_to_num(back - rolled)
    found = ~(np.isnan(left) & np.isnan(back))
    filled, sd = altitude.copy(), np.full(altitude.size, np.nan)
    filled[rows[found]] = height[found]
    sd[rows[found]] = np.minimum(GROUND_SD + SINK * silent, FAR_FROM_GROUND)[found]
    return filled, sd


def _reported(known: np.ndarray, codes: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of some rows the last known one before and the next one after, of the same code; -1 where there is none."""
    place = np.arange(known.size)
    last = np.maximum.accumulate(np.where(known, place, -1))[rows]
    next_ = np.minimum.accumulate(np.where(known, place, known.size)[::-1])[::-1][rows]
    next_ = np.where(next_ < known.size, next_, -1)
    last, next_ = (np.where(codes[there] == codes[rows], there, -1) for there in (last, next_))
    return last, next_


def placeholders(latitude: np.ndarray, longitude: np.ndarray) -> np.ndarray:
    """AIS says 91 and 181 degrees where a position is not available."""
    return (np.abs(latitude - 91.0) < 1e-9) | (np.abs(longitude - 181.0) < 1e-9)


def speeds(sheet: Sheet) -> np.ndarray:
    """Reported speeds (m/s); NaN where missing, also AIS's 102.3 knots for "not available", and negative ones."""
    if "speed" not in sheet:
        return np.full(sheet.frame.height, np.nan)
    value = numbers(sheet.series("speed"))[0]
    value = np.where((value < 0.0) | are_codes(value), np.nan, value)
    if normal(sheet.roles["speed"].name) == "sog":
        value = np.where(np.abs(value - 102.3) < 1e-6, np.nan, value)
    return value * (sheet.roles["speed"].unit or 1.0)
