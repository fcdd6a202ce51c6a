"""jink: tracking of targets that manoeuvre."""

import importlib
from typing import TYPE_CHECKING, Any

from .estimate import STATUS, Estimate, Status
from .filters.imm import IMM
from .filters.kalman import Kalman
from .models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, KnownTurn, Singer
from .models.outliers import Outliers
from .models.provenance import VERSION as __version__
from .models.sensor import Bearing, Polar, Position, PositionVelocity
from .models.start import OnePoint, Prior, TwoPoint
from .models.switching import Sojourn

if TYPE_CHECKING:
    from .association import Tracker
    from .catalogue.choose import choose_filter, default_filter
    from .catalogue.registry import FILTERS
    from .catalogue.targets import KINDS
    from .filters.adaptive_imm import (
        AccelerationLevel,
        AdaptiveIMM,
        AugmentedAcceleration,
        TwoStageAcceleration,
    )
    from .filters.aided import Aided
    from .filters.current_statistical import CurrentStatistical, FuzzyLimits
    from .filters.fuzzy_imm import FuzzyNoise
    from .filters.input_estimation import InputEstimation
    from .filters.loading import load
    from .filters.neural_vsmm import NetworkNoise, NeuralModes
    from .filters.pseudo_bayesian import GPB1, GPB2, StaticMM
    from .filters.variable_dimension import VariableDimension
    from .filters.variable_structure import ActiveDigraph, AdaptiveGrid, DigraphSwitching
    from .models.fuzzy import FuzzyRules
    from .models.radar import Radar
    from .tracking.batch import track

__all__ = [
    "FILTERS",
    "GPB1",
    "GPB2",
    "IMM",
    "KINDS",
    "STATUS",
    "AccelerationLevel",
    "ActiveDigraph",
    "AdaptiveGrid",
    "AdaptiveIMM",
    "Aided",
    "AugmentedAcceleration",
    "Bearing",
    "ConstantAcceleration",
    "ConstantVelocity",
    "CoordinatedTurn",
    "CurrentStatistical",
    "DigraphSwitching",
    "Estimate",
    "FuzzyLimits",
    "FuzzyNoise",
    "FuzzyRules",
    "InputEstimation",
    "Kalman",
    "KnownTurn",
    "NetworkNoise",
    "NeuralModes",
    "OnePoint",
    "Outliers",
    "Polar",
    "Position",
    "PositionVelocity",
    "Prior",
    "Radar",
    "Singer",
    "Sojourn",
    "StaticMM",
    "Status",
    "Tracker",
    "TwoPoint",
    "TwoStageAcceleration",
    "VariableDimension",
    "__version__",
    "choose_filter",
    "default_filter",
    "load",
    "track",
]

# what is imported when it is first asked for, from where: `track` needs polars and pyproj, which the rest does not
_LATER = {
    "AccelerationLevel": "filters.adaptive_imm",
    "ActiveDigraph": "filters.variable_structure",
    "AdaptiveGrid": "filters.variable_structure",
    "AdaptiveIMM": "filters.adaptive_imm",
    "Aided": "filters.aided",
    "AugmentedAcceleration": "filters.adaptive_imm",
    "CurrentStatistical": "filters.current_statistical",
    "DigraphSwitching": "filters.variable_structure",
    "FILTERS": "catalogue.registry",
    "FuzzyLimits": "filters.current_statistical",
    "FuzzyNoise": "filters.fuzzy_imm",
    "FuzzyRules": "models.fuzzy",
    "GPB1": "filters.pseudo_bayesian",
    "GPB2": "filters.pseudo_bayesian",
    "InputEstimation": "filters.input_estimation",
    "KINDS": "catalogue.targets",
    "NetworkNoise": "filters.neural_vsmm",
    "NeuralModes": "filters.neural_vsmm",
    "Radar": "models.radar",
    "StaticMM": "filters.pseudo_bayesian",
    "Tracker": "association",
    "TwoStageAcceleration": "filters.adaptive_imm",
    "VariableDimension": "filters.variable_dimension",
    "choose_filter": "catalogue.choose",
    "default_filter": "catalogue.choose",
    "load": "filters.loading",
    "track": "tracking",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'jink' has no attribute {name!r}")
    found = getattr(importlib.import_module(f".{_LATER[name]}", __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
