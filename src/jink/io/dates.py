"""Text to dates: year first, day or month first, names of months, compact digits, AM and PM, zones, fractions.

Every form is one regular expression; its parts become numbers and these a count of microseconds since 1970. What
no form fits is NaN. Forms of two numbers and a year (`03/04/2024`) give two readings.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import polars as pl

from ..frozen import frozen

HOUR = r"(?P<H>\d{1,2}):(?P<M>\d{2})(?::(?P<S>\d{2})(?:[.,:](?P<f>\d{1,9})\d*)?)?(?: ?(?P<p>[AaPp])\.?[Mm]\.?)?"
# zones by name, hours east of Greenwich: those of RFC 2822, and those that no other zone shares a name with
ZONES = {
    **{"est": -5, "edt": -4, "cst": -6, "cdt": -5, "mst": -7, "mdt": -6, "pst": -8, "pdt": -7},
    **{"wet": 0, "west": 1, "cet": 1, "cest": 2, "mez": 1, "mesz": 2, "eet": 2, "eest": 3, "msk": 3},
    **{"jst": 9, "aest": 10, "aedt": 11, "nzst": 12, "nzdt": 13, "akst": -9, "akdt": -8, "hst": -10},
}
NAMED = "|".join(sorted({*ZONES, *map(str.upper, ZONES)}, key=len, reverse=True))
ZONE = rf"(?: ?(?P<z>[Zz]|UTC|GMT|utc|gmt|{NAMED}|[+-]\d{{2}}:?\d{{2}}|[+-]\d{{2}}))?(?: \(?(?:UTC|GMT)\)?)?"
CLOCK = rf"(?:(?:[T_,-]| )+{HOUR}{ZONE})?"
DAY_NAME = r"(?:[A-Za-z]{3,9}\.?,? +)?"
MONTH = r"(?P<n>[A-Za-zäéû]{3,10})"
FORMS = {
    "year first": rf"^(?P<y>\d{{4}})[-/.:](?P<m>\d{{1,2}})[-/.:](?P<d>\d{{1,2}}){CLOCK}$",
    "numbers": rf"^(?P<d>\d{{1,2}})[-/. ](?P<m>\d{{1,2}})[-/. ](?P<y>\d{{4}}|\d{{2}}){CLOCK}$",
    "day and name": rf"^{DAY_NAME}(?P<d>\d{{1,2}})[- /.]*{MONTH}[- /.,]+(?P<y>\d{{4}}|\d{{2}}){CLOCK}$",
    "name and day": rf"^{DAY_NAME}{MONTH}\.? +(?P<d>\d{{1,2}}),? (?P<y>\d{{4}}){CLOCK}$",
    "year last": rf"^[A-Za-z]{{3}} +(?P<n>[A-Za-z]{{3}}) +(?P<d>\d{{1,2}}) {HOUR}{ZONE}(?: [A-Z]{{3,4}})?"
    r" (?P<y>\d{4})$",
    "compact": r"^(?P<y>(?:19|20)\d{2})(?P<m>\d{2})(?P<d>\d{2})"
    rf"(?:[T _-]?(?P<H>\d{{2}})(?P<M>\d{{2}})(?P<S>\d{{2}})?(?:[.,](?P<f>\d{{1,9}}))?)?{ZONE}$",
}
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
# German, French, Spanish, Italian and Portuguese, where they begin otherwise
OTHER_MONTHS = {
    **{"ene": 1, "gen": 1, "fev": 2, "fév": 2, "mär": 3, "mrz": 3, "avr": 4, "abr": 4, "mai": 5, "mag": 5, "giu": 6},
    **{"lug": 7, "ago": 8, "aoû": 8, "set": 9, "okt": 10, "out": 10, "ott": 10, "dez": 12, "dic": 12, "déc": 12},
}
OF_DAY = rf"^{HOUR}{ZONE}$"


@frozen
class Reading:
    """One way to read a text column: seconds since 1970 (NaN: not so), which are without a zone, and its words."""

    seconds: np.ndarray
    naive: np.ndarray
    words: str

    @property
    def count(self) -> int:
        """How many values it reads."""
        return int(np.isfinite(self.seconds).sum())


def readings(text: pl.Series) -> list[Reading]:
    """All ways to read the column that read as many values as the best one does."""
    plain = text.str.replace_all(r"\s+", " ").str.strip_chars()
    found: list[Reading] = []
    for form, pattern in FORMS.items():
        if not plain.str.contains(pattern).any():
            continue
        parts = _parts(plain, pattern)
        if form == "numbers":
            found += [_reading(parts, "day first"), _reading(_swapped(parts), "month first")]
        else:
            found.append(_reading(parts, form))
    best = max((reading.count for reading in found), default=0)
    return [reading for reading in found if reading.count == best and best]


def times_of_day(text: pl.Series) -> np.ndarray:
    """Seconds since midnight of texts such as 14:30:00.5 or 2:30 PM; NaN for all others."""
    parts = _parts(text.str.strip_chars(), OF_DAY)
    return _day_seconds(parts)


def _parts(text: pl.Series, pattern: str) -> dict[str, np.ndarray]:
    """The named groups of a form as floats, NaN where missing; months by name as `m`, AM or PM and zones decoded."""
    groups = text.to_frame("t").select(pl.col("t").str.extract_groups(pattern)).unnest("t")
    parts = {name: _number(groups[name]) for name in groups.columns if name in "ymdHMS"}
    if "n" in groups.columns:
        number = dict(zip(MONTHS, range(1, 13), strict=True)) | OTHER_MONTHS
        names = groups["n"].str.to_lowercase().str.slice(0, 3)
        parts["m"] = _number(names.replace_strict(number, default=None, return_dtype=pl.Float64))
    if "f" in groups.columns:
        digits = groups["f"].fill_null("0")
        parts["f"] = _number(digits) / 10.0 ** digits.str.len_chars().to_numpy()
    if "p" in groups.columns:
        letter = groups["p"].str.to_lowercase()
        parts["p"] = np.select(
            [(letter == "a").fill_null(False), (letter == "p").fill_null(False)], [0.0, 12.0], np.nan
        )
    if "z" in groups.columns:
        parts["z"] = _offset(groups["z"])
    if "y" in parts:
        parts["y"] = np.where(
            parts["y"] < 70, parts["y"] + 2000, np.where(parts["y"] < 100, parts["y"] + 1900, parts["y"])
        )
    return parts


def _swapped(parts: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {**parts, "d": parts["m"], "m": parts["d"]}


def _reading(parts: Mapping[str, np.ndarray], words: str) -> Reading:
    year, month, day = parts["y"], parts["m"], parts["d"]
    good = (year >= 1900) & (year < 2200) & (month >= 1) & (month <= 12) & (day >= 1)
    months = np.where(good, (year - 1970) * 12 + month - 1, 0).astype("int64")
    first = months.astype("datetime64[M]").astype("datetime64[D]")
    length = (months + 1).astype("datetime64[M]").astype("datetime64[D]") - first
    good &= day <= length.astype("int64")
    days = first.astype("int64") + np.where(good, day - 1, 0)
    offset = parts.get("z", np.full(year.size, np.nan))
    midnight = days * 86400.0 - np.nan_to_num(offset)
    clock = _day_seconds(parts) if "H" in parts else np.zeros(year.size)
    clock = np.where(np.isnan(parts["H"]), 0.0, clock) if "H" in parts else clock
    micros = np.round(midnight * 1e6 + clock * 1e6)
    return Reading(np.where(good, micros * 1e-6, np.nan), good & np.isnan(offset), words)


def _day_seconds(parts: Mapping[str, np.ndarray]) -> np.ndarray:
    """Seconds since midnight; hours of 24 or with AM and PM."""
    hour, minute = parts["H"], parts["M"]
    second = np.nan_to_num(parts["S"])
    half = parts.get("p", np.full(hour.size, np.nan))
    with np.errstate(invalid="ignore"):
        good = (minute < 60) & (second < 61) & np.where(np.isnan(half), hour < 25, (hour >= 1) & (hour <= 12))
        hour = np.where(np.isnan(half), hour, hour % 12 + half)
    value = hour * 3600.0 + minute * 60.0 + second + np.nan_to_num(parts.get("f", np.zeros(hour.size)))
    return np.where(good, value, np.nan)


def _number(series: pl.Series) -> np.ndarray:
    return series.cast(pl.Float64, strict=False).fill_null(float("nan")).to_numpy()


def _offset(zone: pl.Series) -> np.ndarray:
    """Seconds east of Greenwich; NaN where no zone is given."""
    digits = zone.str.replace_all("[^0-9]", "")
    hours, minutes = _number(digits.str.slice(0, 2)), np.nan_to_num(_number(digits.str.slice(2, 2)))
    sign = np.where(zone.str.starts_with("-").fill_null(False).to_numpy(), -1.0, 1.0)
    named = zone.str.to_lowercase().replace_strict(ZONES, default=0, return_dtype=pl.Float64)
    value = np.where(np.isnan(hours), 3600.0 * _number(named), sign * (hours * 3600.0 + minutes * 60.0))
    return np.where(zone.is_null().to_numpy(), np.nan, value)
