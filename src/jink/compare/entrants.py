"""Who may race: the filters by name, what they are measured against, and filters from files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..catalogue.choose import PROVEN
from ..catalogue.purpose import Purpose
from ..catalogue.registry import FILTERS, SHORT
from ..checks import unknown
from ..frozen import frozen
from ..io.errors import InputError

ALWAYS = ("raw", "kalman-cv", "kalman-ca", "imm", "clairvoyant")
SUFFIX = ".json"


@frozen(kw_only=True)
class Entrant:
    """A filter in the race, or (filter None) a yardstick that :mod:`jink.compare.simulated` knows by name.

    words: what it is; fitted: on which data of this race's own scenario, "" for none; in_sample: on the very
    runs that are scored; note: what else a reader must know.
    """

    name: str
    words: str
    filter: Any = None
    fitted: str = ""
    in_sample: bool = False
    note: str = ""


def raw(purpose: Purpose) -> Entrant:
    """No filter."""
    return Entrant(name="raw", words="the measurements themselves, with velocity by differences")


def clairvoyant(purpose: Purpose) -> Entrant:
    """The Kalman filter that knows the commanded accelerations."""
    return Entrant(
        name="clairvoyant", words="Kalman filter that is given every manoeuvre: a lower bound, not a usable filter"
    )


def near_optimal(purpose: Purpose) -> Entrant:
    """The hypothesis tree that knows how the targets are drawn."""
    fixed = purpose.name == "lee-2003"
    words = "hypothesis tree that " + (
        "expects random accelerations: not a bound here" if fixed else "knows how the targets are drawn"
    )
    return Entrant(name="near-optimal", words=words)


YARDSTICKS: dict[str, Callable[[Purpose], Entrant]] = {
    "raw": raw,
    "clairvoyant": clairvoyant,
    "near-optimal": near_optimal,
}
ENTRANTS = ("raw", *FILTERS, "clairvoyant", "near-optimal")


def enter(name: str, purpose: Purpose) -> Entrant:
    """The entrant of this name, made for a purpose. Errors: Unfit where it cannot take part."""
    if name in YARDSTICKS:
        return YARDSTICKS[name](purpose)
    return Entrant(name=name, **vars(FILTERS[name](purpose)))


def check_names(names: list[str]) -> list[str]:
    """The names asked for, "all" and short ones spelled out, those that are always there first; no name twice.

    Errors: InputError for an unknown name (with the nearest and all), or a file that is not there.
    """
    wanted = [SHORT.get(n, n) for name in names for n in (ENTRANTS if name == "all" else [name])]
    for name in wanted:
        if name.endswith(SUFFIX):
            if not Path(name).is_file():
                raise InputError(f"there is no filter file {name}")
        elif name not in ENTRANTS:
            raise InputError(unknown("filter", name, ENTRANTS) + ", all, or a file written by save() (*.json)")
    return list(dict.fromkeys([*ALWAYS, *wanted]))


def with_default(names: list[str], kind: str) -> list[str]:
    """With what `jink track` runs for the kind of target where that is not `imm`."""
    if kind not in PROVEN or "imm-corrected" in names:
        return names
    at = names.index("imm") + 1 if "imm" in names else len(names)
    return [*names[:at], "imm-corrected", *names[at:]]
