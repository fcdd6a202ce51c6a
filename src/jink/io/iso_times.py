"""ISO 8601 times of a column that is written alike throughout, read from its bytes instead of text by text.

Where one text has another form than those of its length, or no such day or hour, the caller reads them one by one.
"""

from __future__ import annotations

import re

import numpy as np
import polars as pl

DIGITS = (0, 1, 2, 3, 5, 6, 8, 9, 11, 12, 14, 15, 17, 18)
FORM = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}:\d{2}(?:\.(\d{1,6}))?( ?(?:[zZ]|utc|UTC)|[+-]\d{2}(?::?\d{2})?)?")
FEWEST = 1000  # of fewer texts nothing is gained
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
    content = np.frombuffer(text.str.join("").item().encode(), np.uint8).reshape(-1, length).T
    fraction = form.span(1)
    digits = [*DIGITS, *range(*fraction)] if form[1] else list(DIGITS)
    value = np.ascontiguousarray(content[digits]) - np.uint8(ord("0"))
    same = [place for place in range(length) if place not in digits]
    if (value > 9).any() or any((content[place] != ord(first[place])).any() for place in same):
        return None
    number = value.astype(np.int64)
    year = ((number[0] * 10 + number[1]) * 10 + number[2]) * 10 + number[3]
    month, day, hour, minute, second = (10 * number[k] + number[k + 1] for k in range(4, 14, 2))
    if not (_within(month, 1, 12) and _within(day, 1, 31) and _within(hour, 0, 23) and _within(minute, 0, 59)):
        return None
    if not (_within(second, 0, 59) and _within(year, 1, 9999)):
        return None
    months = ((year - 1970) * 12 + month - 1).astype("datetime64[M]")
    begins, ends = (m.astype("datetime64[D]").astype(np.int64) for m in (months, months + 1))
    if (day > ends - begins).any():
        return None
    micro = np.zeros_like(year)
    for place in number[14:]:
        micro = micro * 10 + place
    micro *= 10 ** (6 - len(form[1] or "")) if form[1] else 1
    total = ((((begins + day - 1) * 24 + hour) * 60 + minute) * 60 + second) * 1_000_000 + micro
    return total - 1_000_000 * _offset(form[2] or ""), not form[2]


def _within(value: np.ndarray, least: int, most: int) -> bool:
    return bool((value >= least).all() and (value <= most).all())


def _offset(zone: str) -> int:
    """Seconds that a zone's clocks are ahead of UTC."""
    if zone[:1] not in ("+", "-") or not zone:
        return 0
    plain = zone[1:].replace(":", "").ljust(4, "0")
    seconds = 3600 * int(plain[:2]) + 60 * int(plain[2:])
    return seconds if zone[0] == "+" else -seconds
