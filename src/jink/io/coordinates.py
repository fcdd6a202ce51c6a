"""Latitude and longitude however they are written: with letters, in one column, as degrees and minutes, scaled."""

from __future__ import annotations

import numpy as np
import polars as pl

from .values import numbers

NUMBER = r"[-+]?\d+(?:[.,]\d+)?"
DEGREES = (
    r"^(?P<a>[NSEWnsew])? ?(?P<sign>[-+])?(?P<d>\d+(?:[.,]\d+)?) ?(?:°|º|deg|d| |:|-)? ?"
    r"(?:(?P<m>\d+(?:[.,]\d+)?) ?(?:'|′|’|m| |:)? ?(?:(?P<s>\d+(?:[.,]\d+)?) ?(?:\"|″|”|''|s)?)?)? ?(?P<b>[NSEWnsew])?$"
)
PAIR = rf"^\s*[\[(]?\s*({NUMBER})\s*[,; ]\s*({NUMBER})\s*[\])]?\s*$"
POINT = rf"(?i)^\s*(?:SRID=\d+;)?POINT\s*Z?\s*\(\s*({NUMBER})\s+({NUMBER})"
# each of two values with its letter, behind it or before it
LETTERED = (
    r"(?i)^\s*[\[(]?(?P<n>\d[^NSEW]*[NS])[\s,;/]*(?P<e>\d[^NSEW]*[EW])[\])]?\s*$",
    r"(?i)^\s*[\[(]?(?P<n>[NS][^NSEW,;]*)[\s,;/]+(?P<e>[EW][^NSEW]*)$",
)
SCALES = ((1e-7, "1e-7 degrees"), (1e-6, "1e-6 degrees"), (1e-5, "1e-5 degrees"), (1 / 600_000, "1/10000 minutes"))


def pair(series: pl.Series, name: str) -> tuple[pl.Series, pl.Series, str] | None:
    """Latitude and longitude as text from one column of both, and how they are ordered; None if it holds no pairs."""
    text = series.cast(pl.String).str.strip_chars()
    for pattern, order in ((POINT, "longitude first"), (PAIR, "latitude first")):
        first, second = (text.str.extract(pattern, group).str.replace(",", ".") for group in (1, 2))
        if first.count() and first.count() >= 0.5 * text.count():
            if order == "latitude first" and _longitude_first(first, name):
                order = "longitude first"
            return (second, first, order) if order == "longitude first" else (first, second, order)
    for pattern in LETTERED:
        found = text.str.extract_groups(pattern).struct.unnest()
        north, east = (found[name].str.strip_chars(" ,;/") for name in ("n", "e"))
        if north.count() and north.count() >= 0.5 * text.count():
            return north, east, "by letters"
    return None


def _longitude_first(first: pl.Series, name: str) -> bool:
    """By the column's name, or because no latitude is so large."""
    beyond = (first.cast(pl.Float64, strict=False).abs() > 90.0).any()
    return name.startswith(("lon", "lng")) or bool(beyond)


def angles(series: pl.Series) -> np.ndarray | None:
    """Degrees from text such as 53.38N, W 6.77, 51°30'15"N or 51 30.25 N; None if less than half of it is so."""
    if series.dtype != pl.String:
        return None
    text = series.str.replace_all(r"\s+", " ").str.strip_chars()
    groups = text.to_frame("t").select(pl.col("t").str.extract_groups(DEGREES)).unnest("t")
    if groups["d"].count() < 0.5 * max(text.count(), 1):
        return None

    def part(name: str) -> np.ndarray:
        value = groups[name].str.replace(",", ".").cast(pl.Float64, strict=False)
        return value.fill_null(float("nan")).to_numpy()

    minutes, seconds = np.nan_to_num(part("m")), np.nan_to_num(part("s"))
    value = part("d") + minutes / 60.0 + seconds / 3600.0
    # rounding writes 59.9999 seconds as 60
    value = np.where((minutes <= 60.0) & (seconds <= 60.0), value, np.nan)
    letter = groups["a"].fill_null("") + groups["b"].fill_null("") + groups["sign"].fill_null("")
    return value * np.where(letter.str.contains(r"[SWsw-]").to_numpy(), -1.0, 1.0)


def signs(series: pl.Series, letters: str) -> np.ndarray | None:
    """+1 and −1 by the letters of half a globe (`NS` or `EW`), NaN where there is none; None for other content."""
    text = series.cast(pl.String).str.strip_chars().str.to_uppercase().str.slice(0, 1)
    known = text.is_not_null() & (text != "")
    if not known.any() or not text.filter(known).is_in(list(letters)).all():
        return None
    return np.where(known.to_numpy(), np.where((text == letters[1]).fill_null(False).to_numpy(), -1.0, 1.0), np.nan)


def scale(north: np.ndarray, east: np.ndarray) -> tuple[str, list[tuple[float, str]]]:
    """What numbers beyond 90 and 180 degrees can be: `minutes` (ddmm.mmmm), `scaled` with its factors, or nothing.

    north, east: those that are known, without a sign.
    """
    # placeholders such as 91 and 181 among good values are not a scale: most values have to be beyond
    if not north.size or np.mean((north > 90.0) | (east > 180.0)) < 0.5:
        return "", []
    if north.max() <= 9100.0 and east.max() <= 18100.0:
        whole = np.mean((north % 100.0 < 60.0) & (east % 100.0 < 60.0)) > 0.99
        # one kilometre of track already has several whole minutes or fractions; a fraction must be there at all
        return ("minutes", []) if whole and (north % 1.0 > 0).any() else ("", [])
    fits = [(f, words) for f, words in SCALES if north.max() * f <= 91.0 and east.max() * f <= 181.0]
    return ("scaled", fits) if fits and north.max() > 1e4 else ("", [])


def from_minutes(value: np.ndarray) -> np.ndarray:
    """ddmm.mmmm to degrees."""
    size = np.abs(value)
    return np.sign(value) * (np.floor(size / 100.0) + size % 100.0 / 60.0)


def as_numbers(series: pl.Series) -> np.ndarray:
    """The column as floats."""
    return numbers(series)[0]
