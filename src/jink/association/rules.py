"""What a tracker is told, checked and put into the engine's words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .._engine import native
from ..checks import unknown
from ..filters.axis_by_axis import AxisByAxis
from ..filters.bank import Bank
from ..models.radar import Radar

ASSOCIATIONS: dict[str, native.Association] = {
    "marginal": native.Association.marginal,
    "gnn": native.Association.gnn,
    "nearest": native.Association.nearest,
    "pda": native.Association.pda,
    "jpda": native.Association.jpda,
}


def association_called(name: str) -> native.Association:
    """The association of this name. Errors: ValueError that lists all names."""
    if not isinstance(name, str) or name not in ASSOCIATIONS:
        raise ValueError(unknown("association", name, ASSOCIATIONS))
    return ASSOCIATIONS[name]


def named_radars(sensors: Any) -> dict[str, Radar]:
    """The radars by name, from one radar, a list or a dictionary."""
    if isinstance(sensors, Radar):
        return {sensors.name: sensors}
    if isinstance(sensors, Mapping):
        found = dict(sensors)
    elif isinstance(sensors, Sequence) and not isinstance(sensors, str):
        found = {each.name if isinstance(each, Radar) else str(k): each for k, each in enumerate(sensors)}
        if len(found) != len(sensors):
            raise ValueError("sensors: two have the same name; expected a name= for each")
    else:
        raise TypeError(f"sensors: expected a jink.Radar, several, or several by name, got {type(sensors).__name__}")
    for name, each in found.items():
        if not isinstance(each, Radar):
            raise TypeError(f"sensors: {name} is a {type(each).__name__}; expected a jink.Radar")
    if not found:
        raise ValueError("sensors: expected at least one jink.Radar")
    return found


def check_filter(filter: Any) -> None:
    """Can tracks of this filter be given plots by weight? Errors: TypeError or ValueError saying which and why."""
    name = type(filter).__name__
    if isinstance(filter, AxisByAxis):
        raise ValueError(
            f"filter: {name} cannot track plots without identity: each axis is a track of its own, with modes of its "
            "own, so that a plot has no likelihood for both at once; expected a filter of all axes, such as jink.IMM"
        )
    if not isinstance(filter, Bank):
        raise TypeError(f"filter: expected one of jink's filters, got {name}")
    d = filter.declaration
    if d is None:
        raise ValueError(
            f"filter: {name} has models of your own; a tracker runs on jink's own motion and sensor models"
        )
    reasons = (
        (d.interaction == native.Interaction.gpb2, "it keeps every pair of modes apart (GPB2)"),
        (d.proposal.kind != native.Propose.all, "it changes its set of modes from scan to scan"),
        (bool(d.side), "an acceleration is estimated beside its modes"),
        (d.scores.kind != native.Adapt.none, "a network weighs its modes"),
        (d.detection.window > 0, "it watches for the onset of manoeuvres scan by scan"),
        (d.aid.kind != native.AidInputs.none, "a learned aid corrects its estimate from single plots"),
    )
    for true, why in reasons:
        if true:
            raise ValueError(
                f"filter: {name} cannot track plots without identity: {why}; "
                "expected a filter such as jink.IMM, jink.GPB1, jink.StaticMM, jink.Kalman or jink.CurrentStatistical"
            )
