"""ISO 8601 times of a column that is written alike throughout, read from its bytes instead of text by text.

Where one text has another form than those of its length, or no such day or hour, the caller reads them one by one.
"""

from __future__ import annotations

import re

import numpy as np
import polars as pl

DIGITS = (0, 1, 2, 3, 5, 6, 8, 9, 11, 12, 14, 15, 17, 18)
FORM = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}:\d{2}(?:\.(\d{1,6}))?( ?(?:[zZ]|utc|UTC)|[+-]\d{2}(?::?\d{2})?)?")
# of century, year, month, day, hour, minute and second
LEAST, MOST = (0, 0, 1, 1, 0, 0, 0), (99, 99, 12, 31, 23, 59, 59)
FIRST = -1969 * 12  # January of the year 1, in months since 1970
FEWEST = 1000  # of fewer texts nothing is gained
BLOCK = 1 << 14  # texts that are read together: few enough for the cache
LENGTHS = 8  # forms that one column may have: fractions that end in zeros are often cut


def uniform(text: pl.Series) -> tuple[pl.Series, np.ndarray] | None:
    """Date-times (UTC) of every text and which have no zone; None where they are not all of the forms here."""
    if len(text) < FEWEST or text.null_count():
        return None
    lengths = text.str.len_bytes().to_numpy()
    found = np.unique(lengths)
    if found.size > LENGTHS:
        return None
    micros, naive = np.empty(lengths.size, np.int64), np.empty(lengths.size, bool)
    for length in found:
        of_it = lengths == length
        some = text if found.size == 1 else text.filter(pl.Series(of_it))
        read = _of_one_form(some, int(length))
        if read is None:
            return None
        micros[of_it], naive[of_it] = read
    return pl.Series(micros).cast(pl.Datetime("us")).dt.replace_time_zone("UTC"), naive


def _of_one_form(text: pl.Series, length: int) -> tuple[np.ndarray, bool] | None:
    """Microseconds since 1970 of texts that all have the first one's form, and whether it has no zone."""
    first = text[0]
    form = FORM.fullmatch(first)
    if form is None or len(first) != length:
        return None
    content = np.frombuffer(text.str.join("").cast(pl.Binary).item(), np.uint8).reshape(-1, length)
    micros = np.empty(len(text), np.int64)
    for begin in range(0, len(text), BLOCK):
        block = _micros(content[begin : begin + BLOCK].T, first, form)
        if block is None:
            return None
        micros[begin : begin + BLOCK] = block
    return micros - 1_000_000 * _offset(form[2] or ""), not form[2]


def _micros(content: np.ndarray, first: str, form: re.Match[str]) -> np.ndarray | None:
    """Microseconds by the clock since 1970 of texts like `first`: content (length, N) are their bytes."""
    digits = [*DIGITS, *range(*form.span(1))] if form[1] else list(DIGITS)
    value = np.ascontiguousarray(content[digits]) - np.uint8(ord("0"))
    same = [place for place in range(len(first)) if place not in digits]
    if value.max() > 9 or any((content[place] != ord(first[place])).any() for place in same):
        return None
    pairs = 10 * value[:14:2] + value[1:14:2]  # a byte holds two digits
    if (pairs.min(axis=1) < LEAST).any() or (pairs.max(axis=1) > MOST).any():
        return None
    century, year, month, day, hour, minute, second = pairs.astype(np.int32)
    month += 12 * (100 * century + year - 1970) - 1
    early, late = int(month.min()), int(month.max())
    if early < FIRST:
        return None
    begins = np.arange(early, late + 2).astype("datetime64[M]").astype("datetime64[D]").astype(np.int64)
    if (day > np.diff(begins)[month - early]).any():
        return None
    micro = np.zeros(day.size, np.int32)
    for place in value[14:]:
        micro = micro * 10 + place
    micro *= 10 ** (6 - len(form[1] or "")) if form[1] else 1
    return ((begins[month - early] + day - 1) * 86_400 + (hour * 60 + minute) * 60 + second) * 1_000_000 + micro


def _offset(zone: str) -> int:
    """Seconds that a zone's clocks are ahead of UTC."""
    if zone[:1] not in ("+", "-") or not zone:
        return 0
    plain = zone[1:].replace(":", "").ljust(4, "0")
    seconds = 3600 * int(plain[:2]) + 60 * int(plain[2:])
    return seconds if zone[0] == "+" else -seconds
