"""How long an estimate may wait for later measurements: a lag in scans or in seconds."""

from __future__ import annotations

import math
import re
from typing import Any

from ..frozen import frozen
from ..io.errors import InputError

EXPECTED = "expected scans (2) or seconds (8s)"


MOST = 1e9  # scans or seconds


@frozen
class Lag:
    """So many scans, or so many seconds."""

    scans: int | None = None
    seconds: float | None = None

    @classmethod
    def of(cls, given: int | str | Lag | None) -> Lag | None:
        """From ``2`` or ``"2"`` (scans) or ``"8s"`` (seconds). Errors: InputError."""
        if given is None or isinstance(given, Lag):
            return given
        match = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(s?)\s*", str(given)) if not isinstance(given, bool) else None
        value = float(match[1]) if match else math.nan
        if not match or not value <= MOST or (not match[2] and value != int(value)):
            raise InputError(f"lag is {given!r}; {EXPECTED}")
        return cls(seconds=value) if match[2] else cls(scans=int(value))

    def __str__(self) -> str:
        if self.scans is not None:
            return f"{self.scans} scan{'' if self.scans == 1 else 's'}"
        return f"{self.seconds:g} s"

    def options(self) -> dict[str, Any]:
        """The arguments of a filter's ``smooth``."""
        return {"lag": self.scans, "lag_seconds": self.seconds}
