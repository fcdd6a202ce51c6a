"""jink: tracking of targets that manoeuvre."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .association import Sectors, Tracker, radar_bias
    from .catalogue.choose import choose_filter, default_filter
    from .catalogue.purpose import Purpose
    from .catalogue.registry import FILTERS
    from .catalogue.targets import KINDS
    from .estimate import STATUS, Estimate, Status
    from .filters.adaptive_imm import (
        AccelerationLevel,
        AdaptiveIMM,
        AugmentedAcceleration,
        TwoStageAcceleration,
    )
    from .filters.aided import Aided
    from .filters.axis_by_axis import AxisByAxis
    from .filters.corrected import Corrected
    from .filters.current_statistical import CurrentStatistical, FuzzyLimits, LimitWidening
    from .filters.fuzzy_imm import FuzzyNoise
    from .filters.imm import IMM
    from .filters.input_estimation import InputEstimation
    from .filters.kalman import Kalman
    from .filters.loading import load
    from .filters.neural_vsmm import NetworkNoise, NeuralModes
    from .filters.own import OwnFilter
    from .filters.pseudo_bayesian import GPB1, GPB2, StaticMM
    from .filters.variable_dimension import VariableDimension
    from .filters.variable_structure import ActiveDigraph, AdaptiveGrid, DigraphSwitching
    from .models.coasting import Coasting
    from .models.fuzzy import FuzzyRules
    from .models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, KnownTurn, Singer
    from .models.outliers import Outliers
    from .models.plane_corrector import PlaneCorrector
    from .models.provenance import VERSION as __version__
    from .models.radar import Radar
    from .models.sensor import Bearing, Polar, Position, PositionVelocity
    from .models.start import OnePoint, Prior, TwoPoint
    from .models.switching import Sojourn
    from .report.plot import Page, plot
    from .tracking.batch import track
    from .tracking.live_tracker import LiveTracker

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
    "AxisByAxis",
    "Bearing",
    "Coasting",
    "ConstantAcceleration",
    "ConstantVelocity",
    "CoordinatedTurn",
    "Corrected",
    "CurrentStatistical",
    "DigraphSwitching",
    "Estimate",
    "FuzzyLimits",
    "FuzzyNoise",
    "FuzzyRules",
    "InputEstimation",
    "Kalman",
    "KnownTurn",
    "LimitWidening",
    "LiveTracker",
    "NetworkNoise",
    "NeuralModes",
    "OnePoint",
    "Outliers",
    "OwnFilter",
    "Page",
    "PlaneCorrector",
    "Polar",
    "Position",
    "PositionVelocity",
    "Prior",
    "Purpose",
    "Radar",
    "Sectors",
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
    "plot",
    "radar_bias",
    "track",
]

# Where each public name comes from. It is imported when it is first asked for, so that `import jink` takes no time.
_HOME = {
    "AccelerationLevel": "filters.adaptive_imm",
    "ActiveDigraph": "filters.variable_structure",
    "AdaptiveGrid": "filters.variable_structure",
    "AdaptiveIMM": "filters.adaptive_imm",
    "Aided": "filters.aided",
    "AugmentedAcceleration": "filters.adaptive_imm",
    "AxisByAxis": "filters.axis_by_axis",
    "Bearing": "models.sensor",
    "ConstantAcceleration": "models.motion",
    "ConstantVelocity": "models.motion",
    "CoordinatedTurn": "models.motion",
    "Corrected": "filters.corrected",
    "CurrentStatistical": "filters.current_statistical",
    "DigraphSwitching": "filters.variable_structure",
    "Estimate": "estimate",
    "FILTERS": "catalogue.registry",
    "FuzzyLimits": "filters.current_statistical",
    "FuzzyNoise": "filters.fuzzy_imm",
    "FuzzyRules": "models.fuzzy",
    "GPB1": "filters.pseudo_bayesian",
    "GPB2": "filters.pseudo_bayesian",
    "IMM": "filters.imm",
    "InputEstimation": "filters.input_estimation",
    "KINDS": "catalogue.targets",
    "Kalman": "filters.kalman",
    "KnownTurn": "models.motion",
    "LimitWidening": "filters.current_statistical",
    "LiveTracker": "tracking.live_tracker",
    "NetworkNoise": "filters.neural_vsmm",
    "NeuralModes": "filters.neural_vsmm",
    "OnePoint": "models.start",
    "Coasting": "models.coasting",
    "Outliers": "models.outliers",
    "OwnFilter": "filters.own",
    "Page": "report.plot",
    "PlaneCorrector": "models.plane_corrector",
    "Polar": "models.sensor",
    "Position": "models.sensor",
    "PositionVelocity": "models.sensor",
    "Prior": "models.start",
    "Purpose": "catalogue.purpose",
    "Radar": "models.radar",
    "Sectors": "association",
    "STATUS": "estimate",
    "Singer": "models.motion",
    "Sojourn": "models.switching",
    "StaticMM": "filters.pseudo_bayesian",
    "Status": "estimate",
    "Tracker": "association",
    "TwoPoint": "models.start",
    "TwoStageAcceleration": "filters.adaptive_imm",
    "VariableDimension": "filters.variable_dimension",
    "choose_filter": "catalogue.choose",
    "default_filter": "catalogue.choose",
    "load": "filters.loading",
    "plot": "report.plot",
    "radar_bias": "association",
    "track": "tracking",
}


# Packages that `import jink` alone makes reachable.
_ROOMS = ("compare", "fit", "interop", "learn", "metrics", "scenarios")


def __getattr__(name: str) -> Any:
    if name == "__version__":
        found = importlib.import_module(".models.provenance", __name__).VERSION
    elif name in _ROOMS:
        found = importlib.import_module(f".{name}", __name__)
    elif name in _HOME:
        found = getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)
    else:
        raise AttributeError(f"module 'jink' has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
