"""Truth to test and train on: `SCENARIOS` by name; `by_name` finds one or says which there are."""

from ..checks import unknown
from .aircraft import flown
from .benchmark import benchmark
from .papers import choi, lee_and_wang
from .random import families
from .scenario import Scenario, Simulation
from .sensing import RADARS, Observation, Schedule
from .vehicles import vehicles

SCENARIOS: dict[str, Scenario] = {
    each.name: each
    for group in (lee_and_wang(), choi(), benchmark(), families(), flown(), vehicles())
    for each in group
}

__all__ = ["RADARS", "SCENARIOS", "Observation", "Scenario", "Schedule", "Simulation", "by_name"]


def by_name(name: str) -> Scenario:
    """The scenario of this name. Errors: ValueError naming the nearest and all."""
    if not isinstance(name, str) or name not in SCENARIOS:
        raise ValueError(unknown("scenario name", name, SCENARIOS))
    return SCENARIOS[name]
