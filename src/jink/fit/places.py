"""Every number of a filter's description that can be fitted: of motion models and what adapts them, sensors, chains,
settings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..models.switching import transition_rule
from .scales import Limits, Number, Part, Path, Row, Stay, Together

POSITIVE = ("acceleration_max", "acceleration_min", "least_margin", "time_constant", "sd", "psd")
PROBABILITIES = ("share", "false_alarm", "missed_end")
PLAIN = {"turn_rate": 0.05, "acceleration": 10.0}  # of either sign, and the unit u has
MANY = 8  # modes beyond which levels and chain are fitted as wholes
RESIDUAL = 100.0  # m: unit of centres of fuzzy rules where the sensor has no sd in metres


def spelled_out(body: dict[str, Any], modes: int) -> dict[str, Any]:
    """The description with every transition probability in it: a stay probability becomes a matrix."""
    if "of" in body:
        return {**body, "of": spelled_out(body["of"], modes)}
    transition = body.get("transition")
    if modes < 2 or transition is None or body["filter"] == "AdaptiveGrid":
        return body
    if isinstance(transition, dict):
        if "to" not in transition and modes > 2:
            transition["to"] = ((np.ones((modes, modes)) - np.eye(modes)) / (modes - 1)).tolist()
    else:
        _, matrix = transition_rule(transition, None, modes)
        body["transition"] = matrix.tolist()
    return body


def each_part(body: dict[str, Any], modes: Sequence[str], path: Path = ()) -> Iterator[Part]:
    """Everything of a description that can be fitted."""
    if "of" in body:
        yield from each_part(body["of"], modes, (*path, "of"))
        return
    if "steps" in body:
        yield from _numbers(body["steps"], (*path, "steps"), "own")
        modes = ()
    if len(modes) > MANY:
        yield from _levels(body["motions"], path)
    for j, motion in enumerate(body["motions"] if len(modes) <= MANY else ()):
        yield from _motion(motion, (*path, "motions", j), modes[j], _residual(body))
    for k, sensor in enumerate(body["sensors"]):
        name = "sensor" if len(body["sensors"]) == 1 else f"sensor_{k + 1}"
        yield from _numbers(sensor, (*path, "sensors", k), name)
    for setting, name in (("outliers", "outliers"), ("initial", "start"), ("estimator", "estimator")):
        if setting in body:
            yield from _numbers(body[setting], (*path, setting), name)
    for setting in PROBABILITIES:
        if setting in body:
            yield Number(setting, ((*path, setting),), "logit")
    if len(modes) > 1 and "transition" in body:
        yield from _switching(body["transition"], modes, (*path, "transition"))
    if "mode_probability" in body and len(modes) > 1:
        yield from _row(body["mode_probability"], (*path, "mode_probability"), 0, "start", modes)


def _motion(motion: dict[str, Any], path: Path, owner: str, residual: float) -> Iterator[Part]:
    """A motion model's numbers, those of one that it wraps, and of what sets its noise."""
    if "motion" in motion and "network" not in motion:  # which takes the place of the model's own noise
        yield from _motion(motion["motion"], (*path, "motion"), owner, residual)
    yield from _numbers(motion, path, owner)
    for field in ("limits", "across"):
        if "threshold" in motion.get(field, ()):
            yield Limits((*path, field), f"{owner}.{field}", "threshold_down" in motion[field])
    if "widening" in motion:
        yield Number(f"{owner}.widening.nis", ((*path, "widening", "nis"),), "beyond one")
        yield Number(f"{owner}.widening.times", ((*path, "widening", "times"),), "log")
    for field, name in (("rules", owner), ("across", f"{owner}.across")):
        if "variances" in motion.get(field, ()):
            yield from _rules(motion[field], (*path, field), name, residual)
    if "network" in motion:
        yield from _network(motion["network"]["network"], (*path, "network", "network"), f"{owner}.network")


def _rules(rules: dict[str, Any], path: Path, owner: str, residual: float) -> Iterator[Number]:
    for i in range(len(rules["variances"])):
        name = f"{owner}.rule_{i + 1}"
        for k, what in enumerate(("residual", "change")):
            yield Number(f"{name}.centre.{what}", ((*path, "centres", i, k),), "plain", residual)
            yield Number(f"{name}.spread.{what}", ((*path, "spreads", i, k),), "log")
        yield Number(f"{name}.variance", ((*path, "variances", i),), "log")


def _network(network: dict[str, Any], path: Path, owner: str) -> Iterator[Number]:
    for layer, (weights, biases) in enumerate(zip(network["weights"], network["biases"], strict=True)):
        for r, row in enumerate(weights):
            for c in range(len(row)):
                name = f"{owner}.layer_{layer + 1}.weight_{r + 1}_{c + 1}"
                yield Number(name, ((*path, "weights", layer, r, c),), "plain")
        for r in range(len(biases)):
            yield Number(f"{owner}.layer_{layer + 1}.bias_{r + 1}", ((*path, "biases", layer, r),), "plain")


def _residual(body: dict[str, Any]) -> float:
    sensor = body["sensors"][0]
    sd = sensor.get("sd") if sensor["kind"] in ("Position", "PositionVelocity") else None
    return float(sd) if isinstance(sd, int | float) else RESIDUAL


def _levels(motions: Sequence[dict[str, Any]], path: Path) -> Iterator[Together]:
    """One number for all of many modes: the levels of a bank keep their proportions."""
    for field, value in motions[0].items():
        if _scale(field) == "log" and all(isinstance(m.get(field), int | float) for m in motions) and value > 0:
            yield Together(f"levels.{field}", tuple((*path, "motions", j, field) for j in range(len(motions))))


def _numbers(part: dict[str, Any], path: Path, owner: str) -> Iterator[Number]:
    """The numbers of one object; equal ones of the first two axes are one, and a level of zero stays zero."""
    for field, value in part.items():
        scale = _scale(field)
        if scale is None or isinstance(value, str | bool | dict):
            continue
        name, place = f"{owner}.{field}", (*path, field)
        if isinstance(value, int | float):
            groups = [(name, (place,), value)]
        elif all(isinstance(v, int | float) for v in value):
            groups = _axes(name, place, value)
        else:
            continue
        for label, paths, number in groups:
            if number > 0 or (scale == "plain" and (number != 0 or field == "turn_rate")):
                yield Number(label, paths, scale, 1.0 if part.get("in_sd") else PLAIN.get(field, 1.0))


def _axes(name: str, place: Path, values: Sequence[float]) -> list[tuple[str, tuple[Path, ...], float]]:
    if len(values) >= 2 and values[0] == values[1]:
        level = [(f"{name}.horizontal", ((*place, 0), (*place, 1)), values[0])]
        return level + [(f"{name}.vertical", ((*place, 2),), v) for v in values[2:]]
    named = enumerate(zip("xyz", values, strict=False))
    return [(f"{name}.{axis}", ((*place, a),), v) for a, (axis, v) in named]


def _scale(field: str) -> str | None:
    if field in PROBABILITIES:
        return "logit"
    if field in PLAIN:
        return "plain"
    return "log" if field in POSITIVE or field.endswith(("_sd", "_psd")) else None


def _switching(transition: Any, modes: Sequence[str], path: Path) -> Iterator[Part]:
    if isinstance(transition, int | float):
        yield Number("transition.stay", (path,), "logit")
        return
    if not isinstance(transition, dict):
        if len(modes) > MANY:
            yield Stay("transition.stay", path)
            return
        for i, row in enumerate(transition):
            yield from _row(row, (*path, i), i, f"transition.{modes[i]}", modes)
        return
    for i, name in enumerate(modes):
        yield Number(f"sojourn.{name}", ((*path, "seconds", i),), "log")
    for i, row in enumerate(transition.get("to", ())):
        others = [j for j, p in enumerate(row) if p > 0]
        if others:
            yield from _row(row, (*path, "to", i), others[0], f"next.{modes[i]}", modes)


def _row(row: Sequence[float], path: Path, reference: int, owner: str, modes: Sequence[str]) -> Iterator[Row]:
    places = tuple(j for j, p in enumerate(row) if p > 0)
    if len(places) > 1:
        reference = reference if reference in places else places[0]
        names = tuple(f"{owner}.{modes[j]}" for j in places if j != reference)
        yield Row(path, places, reference, names)
