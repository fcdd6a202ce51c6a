"""Filters as small JSON files: parameters in SI units, readable and diffable."""

import json
import os
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..anfis import Anfis
from ..corrector import Corrector
from ..fuzzy import FuzzyRules
from ..motion import MOTIONS
from ..network import Network
from ..noise import OnePoint, Outliers, Prior, Sojourn, TwoPoint
from ..noise_network import ModeNetwork, NoiseNetwork
from ..sensor import SENSORS
from ..trained import Trained
from .adaptive_imm import AccelerationLevel, AugmentedAcceleration, TwoStageAcceleration
from .current_statistical import CurrentStatistical, FuzzyLimits
from .fuzzy_imm import FuzzyNoise
from .neural_vsmm import NetworkNoise

if TYPE_CHECKING:
    from .bank import Bank

VERSION = 1
SETTINGS: dict[str, type] = {c.__name__: c for c in (Outliers, TwoPoint, OnePoint, Prior, Sojourn)}
ADAPTIVE: dict[str, type] = {
    c.__name__: c
    for c in (
        CurrentStatistical, FuzzyLimits, AccelerationLevel, AugmentedAcceleration, TwoStageAcceleration, FuzzyNoise, FuzzyRules,
        NetworkNoise, NoiseNetwork, ModeNetwork, Network, Anfis, Corrector, Trained,
    )
}  # fmt: skip
KINDS: dict[str, type] = {**MOTIONS, **SENSORS, **SETTINGS, **ADAPTIVE}

COMMON = ("outliers", "initial", "coast")
LINEARISED = ("linearisation", *COMMON)
MODES = ("transition", "transition_step", "mode_probability", "mixing", *LINEARISED)
ARGUMENTS: dict[str, tuple[str, ...]] = {
    "Kalman": LINEARISED,
    "IMM": MODES,
    "AdaptiveIMM": ("estimator", *MODES),
    "GPB1": MODES,
    "GPB2": MODES,
    "StaticMM": ("mode_probability", *LINEARISED),
    "DigraphSwitching": ("transition", "graph", "first_mode", *COMMON),
    "ActiveDigraph": ("transition", "alive", "graph", "first_mode", *COMMON),
    "AdaptiveGrid": ("transition", "least_step", "unlikely", "likely", *COMMON),
    "InputEstimation": ("window", "shortest", "false_alarm", *COMMON),
    "VariableDimension": ("window", "false_alarm", "missed_end", *COMMON),
    "NeuralModes": ("network", *COMMON),
    "Aided": ("corrector",),
}


def save(bank: "Bank", path: str | os.PathLike[str], **more: Any) -> None:
    """Write a filter, with more entries to keep with it, if any. Errors: TypeError for a model of your own, which is code."""
    write({"jink": "filter", "version": VERSION, "units": "SI", **described(bank), **more}, path)


def write(body: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """One JSON file, whole or not at all."""
    target = Path(path)
    temporary = target.with_name(f"{target.name}.{os.getpid()}.part")
    temporary.write_text(json.dumps(body, indent=2) + "\n", encoding="utf-8")
    temporary.replace(target)


def described(bank: "Bank") -> dict[str, Any]:
    """A filter as JSON can hold it: its kind, its parts, and its arguments that are not None."""
    kind = type(bank).__name__
    body: dict[str, Any] = {"filter": kind}
    inner = getattr(bank, "filter_", None)
    if inner is not None:
        body["of"] = described(inner)
    else:
        body["motions"] = [plain(m) for m in bank.motions]
        body["sensors"] = [plain(s) for s in bank.sensors]
    for name in ARGUMENTS[kind]:
        value = plain(getattr(bank, name))
        if value is not None:
            body[name] = value
    return body


def plain(value: Any) -> Any:
    """A declaration as JSON holds it. Errors: TypeError for code, which JSON does not hold."""
    if is_dataclass(value) and not isinstance(value, type):
        if type(value).__name__ not in KINDS:
            raise TypeError(
                f"{type(value).__name__}: a model of your own is code and cannot be saved to a file"
            )
        given = {f.name: plain(getattr(value, f.name)) for f in fields(value)}
        return {"kind": type(value).__name__, **{k: v for k, v in given.items() if v is not None}}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [plain(v) for v in value]
    if value is None or isinstance(value, str | int | float | bool):
        return value
    raise TypeError(f"{type(value).__name__}: a model of your own is code and cannot be saved to a file")
