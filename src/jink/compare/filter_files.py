"""Filters from files: do they suit the sensor, and what were they fitted on?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.purpose import Purpose
from ..filters.loading import load
from ..io.errors import InputError
from .entrants import Entrant


def from_file(path: str, purpose: Purpose, seed: int, runs: int) -> Entrant:
    """A filter written by ``save``, if it suits the sensor.

    The file may say what it was fitted on: "fitted": {"scenario", "seed", "runs", "apart"}; apart: from which races its
    data are kept, "all" of them or those of the same "seed". Errors: InputError.
    """
    try:
        filter = load(path)
    except (ValueError, OSError) as error:
        raise InputError(f"filter file {error}" if str(path) in str(error) else f"{path}: {error}") from None
    note = suits(filter, purpose, path)
    fitted = json.loads(Path(path).read_text(encoding="utf-8")).get("fitted") or {}
    # several scenarios have commas between them
    on = str(fitted.get("scenario", "")) if isinstance(fitted, dict) else ""
    here = bool(on) and purpose.name in (on, *on.split(","))
    words = f"{type(filter).__name__} of {', '.join(filter.modes)}"
    return Entrant(
        name=path,
        words=words,
        filter=filter,
        fitted=_on_what(fitted) if here else "",
        in_sample=here and _in_sample(fitted, seed),
        note=note,
    )


def _on_what(fitted: dict[str, Any]) -> str:
    if fitted.get("apart") == "seed":
        return f"the other half of this file, as seed {fitted.get('seed', '?')} splits it"
    return f"{fitted.get('runs', 'some')} runs of seed {fitted.get('seed', '?')}"


def _in_sample(fitted: dict[str, Any], seed: int) -> bool:
    same, apart = fitted.get("seed") == seed, fitted.get("apart")
    return False if apart == "all" else not same if apart == "seed" else same


def suits(filter: Any, purpose: Purpose, path: str) -> str:
    """A note where the filter assumes another noise. Errors: InputError where it cannot take the measurements."""
    own, there = filter.sensors[0], purpose.sensor
    if not hasattr(own, "components"):
        return _own_sensor_suits(own, there, purpose, path)
    expected, given = tuple(getattr(own, "components", ())), tuple(there.components)
    along_axes = there.position_only and expected == ("x",)
    if expected != given and not along_axes:
        raise InputError(
            f"{path}: the filter's sensor measures {', '.join(expected)}; "
            f"expected {', '.join(given)} as in {purpose.name}"
        )
    for name in ("site", "reference"):
        if getattr(own, name, None) != getattr(there, name, None):
            raise InputError(
                f"{path}: the {name} of the filter's sensor is {getattr(own, name, None)}; "
                f"expected {getattr(there, name, None)}"
            )
    m = len(own.noise)
    same = np.array_equal(own.noise, there.noise[:m, :m])
    return "" if same else "the filter assumes a measurement noise that differs from the data's"


def _own_sensor_suits(own: Any, there: Any, purpose: Purpose, path: str) -> str:
    """A sensor of your own names no components: it must measure as many, and its noise is compared."""
    R = np.asarray(own.R, dtype=float)
    R = np.diag(R) if R.ndim == 1 else R
    if len(R) != len(there.components):
        raise InputError(
            f"{path}: the filter's sensor measures {len(R)} components; "
            f"expected {', '.join(there.components)} as in {purpose.name}"
        )
    return (
        "" if np.array_equal(R, there.noise) else "the filter assumes a measurement noise that differs from the data's"
    )
