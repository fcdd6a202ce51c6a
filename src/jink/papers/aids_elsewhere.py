"""Titi & Güney's aids where the paper does not take them: on an IMM, on a radar, with missed and false plots."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ..catalogue.interacting import imm
from ..catalogue.purpose import Named, Purpose
from ..filters.aided import Aided
from ..filters.kalman import Kalman
from ..models.sensor import Polar, Position
from ..scenarios import SCENARIOS, Observation, Scenario, Schedule
from .learned import Models, learned
from .paper import NEES, POSITION, Experiment, Maker, over

SD = 50.0  # m
OVER_KF, OVER_IMM = over("kf", POSITION, "÷ kf"), over("imm", POSITION, "÷ imm")
RADARS = {
    "x and y": Polar(range_sd=25.0, azimuth_sd=2e-3),
    "x, y and z": Polar(range_sd=25.0, azimuth_sd=2e-3, elevation_sd=2e-3),
}
ON_IMM = (
    "Aids on top of jink's default IMM of one axis, trained with it: the paper's on target 1, that fed by history on "
    "1, 3, 5 and a fighter that weaves"
)
CLUTTER = (
    "One plot in ten is missed, one in twenty is false (20 times the noise); aids of targets 1, 3 and 5; x of targets "
    "2, 4, 6, 1 Hz"
)


def on_the_imm(models: Models, target: Callable[[int, str], Scenario]) -> list[Experiment]:
    """The paper's two ways to train and an aid fed by history, each with the IMM as its filter; 1 Hz."""
    words = "default IMM of one axis, aided by an ANFIS"
    filters = {
        "imm + as published": learned(models, "titi-guney-imm-literal", f"{words}, ten epochs of backpropagation"),
        "imm + anfsakf": learned(models, "titi-guney-imm-anfis", f"{words}, hybrid training"),
        "imm + history": learned(models, "titi-guney-imm-history", f"{words} on sums of the last 8 innovations"),
    }
    return [
        Experiment(
            name=f"target {number}, IMM",
            group=ON_IMM,
            scenario=target(number, "1 Hz"),
            filters=filters,
            metrics=(POSITION, OVER_IMM, NEES),
            baselines=("imm",),
        )
        for number in (1, 2, 4, 6)
    ]


def by_radar(models: Models, rates: dict[str, Schedule]) -> list[Experiment]:
    """Target 1 in the plane and in space, seen in range and angles; the aids are those of positions along x."""
    return [
        Experiment(
            name=f"{speed}, {rate}, {axes} by radar",
            group="Aids trained on x, on a radar's filter: range sd 25 m, angles 2 mrad; target 1",
            scenario=_seen_by_radar(sensor, rates[rate], len(sensor.components)),
            filters=_radar_filters(models, speed, rate),
            metrics=(POSITION, OVER_KF, OVER_IMM),
            baselines=("raw", "imm"),
            share=0.1 if rate == "1 Hz" else 0.01,
        )
        for axes, sensor in RADARS.items()
        for rate in rates
        for speed in ("sluggish", "tuned")
    ]


def _seen_by_radar(sensor: Polar, schedule: Schedule, axes: int) -> Scenario:
    base = SCENARIOS["benchmark-1"]
    return replace(base, axes=axes, observation=Observation(sensor=sensor), schedule=schedule)


def _radar_filters(models: Models, speed: str, rate: str) -> dict[str, Maker]:
    name = f"titi-guney-{speed}" + ("" if rate == "1 Hz" else "-20hz")
    filters = {
        "kf": _rebuilt(models, f"{name}-anfis", None, "constant-acceleration Kalman filter on the radar"),
        "as published": _rebuilt(models, f"{name}-literal", f"{name}-literal", "the same; ANFIS, ten epochs"),
        "anfsakf": _rebuilt(models, f"{name}-anfis", f"{name}-anfis", "the same; ANFIS, hybrid training"),
    }
    if speed == "tuned":
        filters["history"] = _rebuilt(
            models, f"{name}-anfis", "anfis-kf", "the same; ANFIS on sums of the last 8 innovations"
        )
        filters["imm + history"] = _on_default(models, "jink's default IMM; ANFIS on sums of the last 8 innovations")
    return filters


def in_clutter(models: Models, target: Callable[[int, str], Scenario]) -> list[Experiment]:
    """Aids fed by the last innovations where plots are missed and false; every filter expects the false ones."""
    filters = {
        "kf": _rebuilt(models, "nn-kf", None, "Kalman filter tuned on targets 1, 3, 5"),
        "anfsakf": _rebuilt(models, "nn-kf", "anfis-kf", "the same; ANFIS on sums of the last 8 innovations"),
        "nnakf": _rebuilt(models, "nn-kf", "nn-kf", "the same; network on the last 8 innovations"),
        "imm + history": _on_default(models, "jink's default IMM; ANFIS on sums of the last 8 innovations"),
    }
    seen = Observation(sensor=Position(sd=SD, axes=1), detection=0.9, outlier_share=0.05)
    return [
        Experiment(
            name=f"target {number}, clutter",
            group=CLUTTER,
            scenario=replace(target(number, "1 Hz"), observation=seen),
            filters=filters,
            metrics=(POSITION, OVER_KF, OVER_IMM),
            baselines=("raw", "imm"),
            share=0.25,
        )
        for number in (2, 4, 6)
    ]


def _rebuilt(models: Models, of: str, aid: str | None, words: str) -> Maker:
    """The motion model of one learned filter on the purpose's sensor, with the aid of another, or none."""

    def make(purpose: Purpose) -> Named:
        filter = Kalman(models(of, None).motions[0], purpose.sensor, outliers=purpose.outliers)
        return Named(filter=filter if aid is None else Aided(filter, models(aid, None).corrector), words=words)

    return make


def _on_default(models: Models, words: str) -> Maker:
    """The default IMM for the purpose, with the aid that was trained on that of one axis."""

    def make(purpose: Purpose) -> Named:
        corrector = models("titi-guney-imm-history", None).corrector
        return Named(filter=Aided(imm(purpose).filter, corrector), words=words)

    return make
