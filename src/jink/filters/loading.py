"""Filters read back from the files that ``save`` writes."""

import json
import os
import re
from collections.abc import Callable
from inspect import Parameter, signature
from pathlib import Path
from typing import Any

from ..models.anfis import Anfis
from ..models.coasting import Coasting
from ..models.corrector import Corrector
from ..models.fuzzy import FuzzyRules
from ..models.motion import MOTIONS
from ..models.network import Network
from ..models.noise_network import ModeNetwork, NoiseNetwork
from ..models.outliers import Outliers
from ..models.plane_corrector import PlaneCorrector
from ..models.provenance import Trained
from ..models.sensor import SENSORS
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import Sojourn
from .adaptive_imm import AccelerationLevel, AdaptiveIMM, AugmentedAcceleration, TwoStageAcceleration
from .aided import Aided
from .axis_by_axis import AxisByAxis
from .bank import Bank
from .corrected import Corrected
from .current_statistical import CurrentStatistical, FuzzyLimits, LimitWidening
from .fuzzy_imm import FuzzyNoise
from .imm import IMM
from .input_estimation import InputEstimation
from .kalman import Kalman
from .neural_vsmm import NetworkNoise, NeuralModes
from .own import OwnFilter
from .own_models import ARRAY, read_back, rebuilt
from .own_models import KIND as OWN
from .own_models import NAMED as DICT
from .plain import VERSION
from .pseudo_bayesian import GPB1, GPB2, StaticMM
from .variable_dimension import VariableDimension
from .variable_structure import ActiveDigraph, AdaptiveGrid, DigraphSwitching

AnyFilter = Bank | AxisByAxis | OwnFilter
SEVERAL: tuple[type[Bank], ...] = (
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
# with what they call their motion models
SINGLE: dict[type[Bank], tuple[str, ...]] = {
    Kalman: ("motion",),
    InputEstimation: ("motion",),
    VariableDimension: ("quiet", "manoeuvring"),
}
FILTERS: dict[str, Any] = {c.__name__: c for c in (*SINGLE, *SEVERAL, Aided, Corrected, OwnFilter)}
ADAPTIVE = (
    CurrentStatistical,
    FuzzyLimits,
    LimitWidening,
    AccelerationLevel,
    AugmentedAcceleration,
    TwoStageAcceleration,
    FuzzyNoise,
    NetworkNoise,
)
LEARNED = (FuzzyRules, NoiseNetwork, ModeNetwork, Network, Anfis, Corrector, PlaneCorrector, Trained)
SETTINGS = (Coasting, Outliers, TwoPoint, OnePoint, Prior, Sojourn)
KINDS: dict[str, type] = {**MOTIONS, **SENSORS, **{c.__name__: c for c in (*SETTINGS, *ADAPTIVE, *LEARNED)}}
NAMED = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
RUN = ("motions", "quiet", "manoeuvring", "sensor", "transition")  # what a filter checks itself
WRONG = (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError)  # what bad parts end in


def load(path: str | os.PathLike[str], *, own: bool = False) -> Bank | OwnFilter:
    """Read a filter written by ``save``. Errors: ValueError naming the file and what is wrong with it.

    own: whether the file may import the modules of models of your own, which runs their code.
    """
    if not isinstance(path, str | os.PathLike) or "\0" in str(path):
        raise TypeError(f"path: expected the name of a file, got {path!r}")
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: is not a jink filter file: it is not valid JSON ({error})") from None
    return read(text, str(path), own)


def read(text: str, path: str, own: bool = False) -> Any:
    """Read a filter from the text of such a file; messages name the path."""
    try:
        body = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: is not a jink filter file: it is not valid JSON ({error})") from None
    except RecursionError:
        raise ValueError(f"{path}: is not a jink filter file: it nests too deeply") from None
    if not isinstance(body, dict) or body.get("jink") != "filter":
        raise ValueError(f'{path}: is not a jink filter file; expected an object with "jink": "filter"')
    if body.get("version") != VERSION:
        raise ValueError(f"{path}: has version {body.get('version')!r}; this jink reads version {VERSION}")
    if body.get("units") != "SI":
        raise ValueError(f"{path}: has units {body.get('units')!r}; expected SI")
    try:
        filter = built(body, own=own)
        filter.fitted = body.get("fitted") or {}
        return filter
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def built(body: Any, within: str = "", own: bool = False) -> Any:
    """The filter of a description. Errors: ValueError naming the place in it and what is wrong there."""
    kind = body.get("filter") if isinstance(body, dict) else None
    if not isinstance(kind, str) or kind not in FILTERS:
        raise ValueError(f"{within}filter: {kind!r} is not one of {', '.join(FILTERS)}")
    build = FILTERS[kind]
    named = {name: declared(body[name], within + name, own) for name in build.arguments if name in body}
    if build is Aided or build is Corrected:
        return made(build, within[:-1], {"filter": built(body.get("of"), f"{within}of.", own), **named})
    if build is OwnFilter:
        sensor = _several(body, "sensors", within, own)[0]
        return made(OwnFilter, within[:-1], {"sensor": sensor, **named})
    motions, sensors = (_several(body, name, within, own) for name in ("motions", "sensors"))
    if build not in SINGLE:
        return made(build, within[:-1], {"motions": motions, "sensor": sensors, **named})
    names = SINGLE[build]
    if len(motions) != len(names):
        raise ValueError(f"{within}motions: expected {len(names)} for {kind}, got {len(motions)}")
    return made(build, within[:-1], {**dict(zip(names, motions, strict=True)), "sensor": sensors, **named})


def _several(body: dict[str, Any], name: str, within: str, own: bool) -> list[Any]:
    found = body.get(name)
    if not isinstance(found, list) or not found:
        raise ValueError(f"{within}{name}: expected a list of at least one, got {found!r}")
    places = [f"{within}{name}[{i}]" for i in range(len(found))]
    return [_running(declared(each, at, own), at) for each, at in zip(found, places, strict=True)]


def _running(part: Any, at: str) -> Any:
    """A motion or sensor model. Errors: ValueError for anything else."""
    if not any(hasattr(part, verb) for verb in ("native", "f", "h")):
        raise ValueError(f"{at}: expected a motion or sensor model, got {part!r}")
    return part


def declared(value: Any, at: str, own: bool = False) -> Any:
    """The declaration that :func:`jink.filters.plain.plain` turned into JSON. Errors: ValueError naming the place."""
    if isinstance(value, list):
        return [declared(v, f"{at}[{i}]", own) for i, v in enumerate(value)]
    if not isinstance(value, dict):
        return value
    kind = value.get("kind")
    if kind in (ARRAY, DICT) and isinstance(value.get("values"), list) and len(value) == 2:
        return _values(value, at, own)
    if kind == OWN:
        return rebuilt({name: declared(v, f"{at}.{name}", own) for name, v in value.items()}, at, own)
    if not isinstance(kind, str) or kind not in KINDS:
        raise ValueError(f"{at}: kind {kind!r} is not one of {', '.join(KINDS)}")
    return made(
        KINDS[kind], at, {name: declared(v, f"{at}.{name}", own) for name, v in value.items() if name != "kind"}
    )


def _values(value: dict[str, Any], at: str, own: bool) -> Any:
    try:
        return read_back(value, lambda values: declared(values, at, own))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{at}: {error}") from None


def made(build: Callable[..., Any], at: str, given: dict[str, Any]) -> Any:
    """build(**given). Errors: ValueError for an argument that is unknown, missing or of another kind than declared."""
    where = f"{at}: " if at else ""
    own, arguments = build.__name__, signature(build).parameters
    open_ended = any(a.kind is Parameter.VAR_KEYWORD for a in arguments.values())
    for name, value in given.items():
        if name not in arguments and not open_ended:
            raise ValueError(f"{where}{own} has no argument {name}")
        if name == "motion":
            _running(value, f"{where}{own}.motion")
        elif name in arguments and name not in RUN:
            _of_its_kind(f"{where}{own}.{name}", value, arguments[name].annotation)
    for name, argument in arguments.items():
        if argument.default is Parameter.empty and argument.kind in NAMED and name not in given:
            raise ValueError(f"{where}{own} needs the argument {name}")
    try:
        return build(**given)
    except WRONG as error:
        raise ValueError(f"{where}{error}") from None


def _of_its_kind(name: str, value: Any, annotation: Any) -> None:
    kinds = set(re.findall(r"\w+", str(annotation))) & set(KINDS)
    if kinds and value is not None and type(value).__name__ not in kinds:
        raise ValueError(f"{name}: expected {' or '.join(sorted(kinds))}, got {value!r}")
