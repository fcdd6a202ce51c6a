"""Filters read back from the files that ``save`` writes."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .adaptive_imm import AdaptiveIMM
from .aided import Aided
from .files import ARGUMENTS, KINDS, VERSION
from .imm import IMM
from .input_estimation import InputEstimation
from .kalman import Kalman
from .neural_vsmm import NeuralModes
from .pseudo_bayesian import GPB1, GPB2, StaticMM
from .variable_dimension import VariableDimension
from .variable_structure import ActiveDigraph, AdaptiveGrid, DigraphSwitching

BUILDERS: dict[str, Callable[..., Any]] = {
    c.__name__: c
    for c in (
        IMM,
        AdaptiveIMM,
        GPB1,
        GPB2,
        StaticMM,
        DigraphSwitching,
        ActiveDigraph,
        AdaptiveGrid,
        NeuralModes,
    )
}
SINGLE: dict[str, Callable[..., Any]] = {c.__name__: c for c in (Kalman, InputEstimation, VariableDimension)}


def load(path: str | os.PathLike[str]) -> Any:
    """Read a filter written by ``save``. Errors: ValueError naming the file and what is wrong with it."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: is no JSON filter file ({error})") from None
    return read(text, str(path))


def read(text: str, path: str) -> Any:
    """The same from the file's text; path is for messages."""
    try:
        body = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: is no JSON filter file ({error})") from None
    if not isinstance(body, dict) or body.get("jink") != "filter":
        raise ValueError(f'{path}: is no jink filter file; expected an object with "jink": "filter"')
    if body.get("version") != VERSION:
        raise ValueError(f"{path}: is of version {body.get('version')!r}; this jink reads version {VERSION}")
    if body.get("units") != "SI":
        raise ValueError(f"{path}: units {body.get('units')!r}; expected SI")
    try:
        filter = built(body)
        filter.fitted = body.get("fitted") or {}
        return filter
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from None


def built(body: dict[str, Any]) -> Any:
    """The filter of a description. Errors: ValueError, TypeError or KeyError for what is wrong with it."""
    kind = body.get("filter")
    if kind not in ARGUMENTS:
        raise ValueError(f"filter {kind!r} is none of {', '.join(ARGUMENTS)}")
    named = {name: declared(body[name]) for name in ARGUMENTS[kind] if name in body}
    if kind == "Aided":
        return Aided(built(body["of"]), **named)
    motions, sensors = [declared(m) for m in body["motions"]], [declared(s) for s in body["sensors"]]
    if kind in SINGLE:
        return SINGLE[kind](*motions, sensors, **named)
    return BUILDERS[kind](motions, sensors, **named)


def declared(value: Any) -> Any:
    """What :func:`jink.filters.files.plain` made JSON of. Errors: ValueError for an unknown kind."""
    if isinstance(value, list):
        return [declared(v) for v in value]
    if isinstance(value, dict):
        kind = value.get("kind")
        if kind not in KINDS:
            raise ValueError(f"kind {kind!r} is none of {', '.join(KINDS)}")
        return KINDS[kind](**{name: declared(v) for name, v in value.items() if name != "kind"})
    return value
