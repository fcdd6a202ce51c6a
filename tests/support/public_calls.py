"""Every public function and class with arguments that it takes, from which a test makes others that it may not take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

import jink
from jink import association, compare, metrics, scenarios
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS
from jink.metrics.skies import Picture

Call = tuple[Callable[..., Any], dict[str, Any]]
TIME = np.arange(6.0)
Z = np.column_stack([3.0 * TIME, 2.0 * TIME])
CV, CA = jink.ConstantVelocity(acceleration_psd=1.0), jink.ConstantAcceleration(jerk_psd=1.0)
LEVELS = [jink.ConstantVelocity(acceleration_psd=q) for q in (1.0, 3.0, 9.0)]
LINE = [[0.8, 0.2, 0.0], [0.1, 0.8, 0.1], [0.0, 0.2, 0.8]]
SENSOR = jink.Position(sd=10.0)
KALMAN = jink.Kalman(CV, SENSOR)
PURPOSE = Purpose(sensor=SENSOR, sd=10.0)
CORRECTED = FILTERS["imm-corrected"](Purpose(sensor=SENSOR, sd=10.0, kind="fighter")).filter
RULES = jink.FuzzyRules([[0.0, 0.0]], [[10.0, 10.0]], [1.0])
RADAR = jink.Radar(sd=10.0, area=(0.0, 1000.0, 0.0, 1000.0), period=1.0, clutter_per_scan=1.0)
TABLE = pl.DataFrame({"target": ["a"] * 6, "time": TIME, "x": Z[:, 0], "y": Z[:, 1]})
ROW = {"target": "a", "time": 1.7e9, "latitude": 50.0, "longitude": 8.0}

# what takes minutes where it is accepted, with the tests that hold its errors; and what jink makes and nobody calls
EXEMPT = {
    "jink.compare.compare": "tests/compare",
    "jink.fit.fit": "tests/fit",
    "jink.papers.run": "tests/papers",
    "jink.report.write_report": "tests/report",
    "jink.OwnFilter": "tests/compare/test_own_filters.py",
    "jink.stepwise.Stepwise": "an engine: tests/stepwise",
    "jink.Status": "an enumeration",
}
RESULTS = (
    *("Picture", "RadarBias", "Race", "Reference", "Fit", "Tracked", "Paper", "Experiment", "Metric", "Outcome", "Row"),
    *("ClearMot", "Comparison", "Consistency", "Detection", "Figure", "Gospa", "Response", "Siap", "SkyFigures"),
    *("Scenario", "Simulation", "Estimate"),
)


def classes() -> dict[str, Call]:
    """Models, rules and filters."""
    two = {"motions": [CV, CA], "sensor": SENSOR}
    network, modes = FILTERS["nnvsmm"](PURPOSE).filter, FILTERS["nnvsmm-modes"](PURPOSE).filter
    sds = {"acceleration_sd": 1.0, "bias_sd": 1.0, "bias_prior_sd": 1.0}
    made: dict[str, dict[str, Any]] = {
        "GPB1": two | {"transition": 0.9},
        "GPB2": two | {"transition": 0.9},
        "IMM": two | {"transition": 0.9},
        "StaticMM": two,
        "Kalman": {"motion": CV, "sensor": SENSOR},
        "AccelerationLevel": {"motion": CV, "acceleration": 1.0},
        "ActiveDigraph": {"motions": LEVELS, "sensor": SENSOR, "transition": LINE, "alive": 2},
        "DigraphSwitching": {"motions": LEVELS, "sensor": SENSOR, "transition": LINE},
        "AdaptiveGrid": {
            "motions": [jink.KnownTurn(rate, acceleration_sd=0.5) for rate in (-0.1, 0.0, 0.1)],
            "sensor": SENSOR,
        },
        "AdaptiveIMM": {
            "motions": [jink.AccelerationLevel(CV, a, estimated=True) for a in (-1.0, 0.0, 1.0)],
            "sensor": SENSOR,
            "transition": 0.9,
            "estimator": jink.TwoStageAcceleration(**sds),
        },
        "Aided": {"filter": KALMAN, "corrector": FILTERS["nn-kf"](PURPOSE).filter.corrector},
        "PlaneCorrector": {f.name: getattr(CORRECTED.corrector, f.name) for f in fields(CORRECTED.corrector)},
        "Corrected": {"filter": CORRECTED.filter_, "corrector": CORRECTED.corrector},
        "Bearing": {"sd": 0.01},
        "Coasting": {"after": 1.0, "manoeuvre": 1.0, "climb": 1.0},
        "ConstantAcceleration": {"jerk_psd": 1.0},
        "ConstantVelocity": {"acceleration_sd": 1.0},
        "CoordinatedTurn": {"acceleration_sd": 1.0, "turn_rate_psd": 1e-4},
        "CurrentStatistical": {"acceleration_max": 10.0},
        "FuzzyLimits": {"threshold": 100.0, "operating": 90.0},
        "FuzzyNoise": {"motion": CV, "rules": RULES},
        "FuzzyRules": {"centres": [[0.0, 0.0]], "spreads": [[1.0, 1.0]], "variances": [1.0]},
        "KnownTurn": {"turn_rate": 0.1, "acceleration_sd": 1.0},
        "InputEstimation": {"motion": CV, "sensor": SENSOR, "window": 5},
        "VariableDimension": {"quiet": CV, "manoeuvring": CA, "sensor": SENSOR},
        "NetworkNoise": {"motion": CV, "network": network.motions[0].network},
        "NeuralModes": {"motions": modes.motions, "sensor": SENSOR, "network": modes.network},
        "OnePoint": {"velocity_sd": 1.0},
        "Page": {"html": "<p>"},
        "Polar": {"range_sd": 1.0, "azimuth_sd": 0.01},
        "Position": {"sd": 1.0},
        "PositionVelocity": {"sd": 1.0, "velocity_sd": 1.0},
        "Prior": {"x": np.zeros(4), "P": np.eye(4)},
        "Purpose": {"sensor": SENSOR},
        "Radar": {"sd": 10.0},
        "Singer": {"acceleration_sd": 1.0, "time_constant": 10.0},
        "Sojourn": {"seconds": [10.0, 20.0]},
        "TwoStageAcceleration": sds,
        "AugmentedAcceleration": sds,
        "AxisByAxis": {"filter": jink.Kalman(CV, jink.Position(sd=1.0, axes=1)), "axes": 2},
        "LimitWidening": {},
        "LiveTracker": {},
        "Outliers": {},
        "Tracker": {"filter": KALMAN, "sensors": RADAR},
        "TwoPoint": {},
        "Sectors": {"tracker": jink.Tracker(KALMAN, RADAR), "period": 4.0},
    }
    return {f"jink.{name}": (getattr(jink, name), given) for name, given in made.items()}


def functions(folder: Path) -> dict[str, Call]:
    """Functions of the package and of its rooms."""
    choice = {"components": ("x", "y"), "sd": {"position": 10.0}, "kind": "aircraft", "filter": "imm"}
    plots = {"time": TIME, "plots": Z, "code": np.arange(6) % 2}
    seen = {"z": Z[None], "time": TIME[None], "sensor": SENSOR, "acceleration_sd": 1.0}
    KALMAN.save(folder / "filter.json")
    return {
        "jink.choose_filter": (jink.choose_filter, choice),
        "jink.default_filter": (jink.default_filter, {"kind": "aircraft", "sensor": SENSOR}),
        "jink.load": (jink.load, {"path": folder / "filter.json"}),
        "jink.plot": (jink.plot, {"what": jink.track(TABLE)}),
        "jink.track": (jink.track, {"data": TABLE}),
        "jink.radar_bias": (jink.radar_bias, plots | {f"other_{name}": value for name, value in plots.items()}),
        "jink.scenarios.by_name": (scenarios.by_name, {"name": "random-turns"}),
        "jink.scenarios.Schedule": (scenarios.Schedule, {}),
        "jink.scenarios.Observation": (scenarios.Observation, {"sensor": SENSOR}),
        "jink.compare.clairvoyant": (compare.clairvoyant, seen),
        "jink.compare.near_optimal": (
            compare.near_optimal,
            {"z": np.repeat(Z[None], 2, axis=0), "prior": compare.RandomTurns(), "sd": 10.0, "hypotheses": 8},
        ),
        "jink.compare.near_optimal_turned": (
            compare.near_optimal_turned,
            {"z": np.repeat(Z[None], 2, axis=0), "prior": compare.RandomAccelerations(), "sd": 10.0, "angles": 2},
        ),
        "jink.compare.RandomTurns": (compare.RandomTurns, {}),
        "jink.compare.RandomAccelerations": (compare.RandomAccelerations, {}),
        **{f"jink.metrics.{name}": (getattr(metrics, name), given) for name, given in _metrics().items()},
    }


def _metrics() -> dict[str, dict[str, Any]]:
    error = np.random.default_rng(0).normal(size=(5, 20, 4))
    P = np.broadcast_to(np.eye(4), (5, 20, 4, 4)).copy()
    square, points, set_of = np.abs(error[..., 0]), np.zeros((3, 2)), {"c": 10.0}
    chain = {"F": np.eye(4), "Q": np.eye(4), "information": np.broadcast_to(np.eye(4), (20, 4, 4)), "P0": np.eye(4)}
    picture = Picture(np.arange(2), np.zeros((2, 2)))
    seen = {"truth": [[picture]], "estimate": [[picture]], "c": 1.0}
    return {
        "bound_rmse": {"C": P[0], "index": [0, 2]},
        "compare_means": {"a": square[:, 0], "b": square[:, 1]},
        "compare_rmse": {"a": error, "b": 2.0 * error},
        "consistency": {"squares": square, "dof": 4},
        "detection": {"probability": square / 9.0, "busy": square > 1.0},
        "efficiency": {"error": error, "reference_error": error},
        "events": {"busy": square > 1.0, "kind": "onset"},
        "gospa": {"truth": points, "estimate": points, **set_of},
        "ospa": {"truth": points, "estimate": points, **set_of},
        "ospa2": {"truth": [points, points], "estimate": [points, points], **set_of},
        "information": {"jacobians": np.ones((5, 20, 2, 4)), "R": np.eye(2)},
        "log_density": {"error": error, "P": P},
        "log_score": {"error": error, "P": P},
        "nees": {"error": error, "P": P},
        "lost": {"position_error": error[..., :2], "limit": 3.0},
        "manoeuvring": {"acceleration": error[..., :2], "threshold": 1.0},
        "mean_euclidean": {"error": error},
        "measured_velocity": {"z": Z[None], "time": TIME},
        "microseconds_per_update": {"work": lambda: 0, "updates": 1, "repetitions": 1},
        "normalised_error": {"error": error, "measurement_error": error},
        "paired": {"difference": 1.0, "influence": square[:, 0]},
        "posterior_bound": chain,
        "tichavsky_bound": chain | {"F": P, "Q": np.eye(4)},
        "prediction_score": {"log_likelihood_scan": square},
        "quantile": {"error": error, "q": 0.5},
        "response": {"error": error, "busy": square > 1.0, "kind": "onset"},
        "rmse": {"error": error},
        "rmse_over_time": {"error": error},
        "trimmed_rmse": {"error": error},
        "turn_displacement": {"velocity": error[..., :2], "turn_rate": square, "time": np.arange(20.0)},
        "clear_mot": seen,
        "siap": seen | {"times": [[0.0]]},
        "sky_figures": seen,
    }


def methods(folder: Path) -> dict[str, Call]:
    """What filters, live targets, estimates, rules and trackers are asked."""
    calls: dict[str, Call] = {}
    rows = {"time": np.tile(TIME, 2), "z": np.tile(Z, (2, 1)), "offsets": [0, 6, 12], "threads": 1}
    filters = {"kalman": KALMAN, "imm": FILTERS["imm"](PURPOSE).filter, "aimm3": FILTERS["aimm3"](PURPOSE).filter}
    for name, filter in filters.items():
        calls[f"{name}.filter"], calls[f"{name}.smooth"] = (filter.filter, rows), (filter.smooth, rows)
        calls[f"{name}.start"] = (filter.start, {})
        calls[f"{name}.save"] = (filter.save, {"path": folder / "saved.json"})
    one, many, slots, first = KALMAN.start(), KALMAN.start(3), KALMAN.slots(), {"x": np.zeros(4), "P": np.eye(4)}
    estimate, slot, tracker = KALMAN.filter(**rows), slots.take(), jink.Tracker(KALMAN, RADAR)
    live = jink.LiveTracker()
    return calls | {
        "one.update": (
            lambda t, z, covariance=None, input=None: one.update(t, z, 0, covariance, input),
            {"t": 1, "z": Z[0]},
        ),
        "one.predict": (lambda t: one.predict(t), {"t": 1e9}),
        "one.begin": (lambda x, P, time: one.begin(x, P, time), first | {"time": 0.0}),
        "one.restore": (lambda state: one.restore(state), {"state": one.save()}),
        "many.update": (many.update, {"t": 1.0, "z": Z[:3]}),
        "many.follow": (KALMAN.start(3).follow, {"t": [1.0, 2.0], "z": Z[:6]}),
        "many.predict": (many.predict, {"t": 1e9}),
        "many.begin": (many.begin, first | {"target": 1, "time": 0.0}),
        "many.reset": (many.reset, {"target": 1}),
        "many.restore": (many.restore, {"state": many.save()}),
        "slots.update": (slots.update, {"slots": [slot], "t": [1.0], "z": Z[:1]}),
        "estimate.at": (estimate.at, {"times": [1.5, 2.5]}),
        "estimate.resample": (estimate.resample, {"step": 1.0}),
        "estimate.to_frame": (estimate.to_frame, {"backend": "polars"}),
        "estimate.sd": (estimate.sd, {"component": "px"}),
        "rules.variance": (RULES.variance, {"residual": 1.0, "change": 1.0}),
        "rules.surface": (RULES.surface, {"reach": 1.0, "points": 5}),
        "rules.of": (jink.FuzzyRules.of, {"table": [[0.0, 1.0, 0.0, 1.0, 1.0]]}),
        "rules.constant": (jink.FuzzyRules.constant, {"acceleration_sd": 1.0, "spread": 1.0}),
        "from_speed_course": (
            jink.PositionVelocity.from_speed_course,
            {"position": Z, "speed": TIME, "course": TIME, "sd": 1.0, "speed_sd": 1.0, "course_sd": 0.1},
        ),
        "sojourn.generator": (jink.Sojourn([10.0, 20.0]).generator, {"modes": 2}),
        "purpose.staying": (PURPOSE.staying, {"stay": 0.9, "modes": 2}),
        "live.update": (live.update, ROW),
        "live.update_many": (live.update_many, {"rows": [ROW]}),
        "live.predict": (live.predict, {"time": 1.7e9}),
        "live.load": (jink.LiveTracker.load, {"state": live.save()}),
        "tracker.scan": (tracker.scan, {"time": 1.0, "plots": Z[:2]}),
        "tracker.add": (tracker.add, first | {"time": 0.0}),
        "tracker.load": (tracker.load, {"state": tracker.save()}),
        "tracker.components_of": (tracker.components_of, {"sensor": "radar"}),
        "scenario.simulate": (scenarios.by_name("random-turns").simulate, {"runs": 1, "seed": 0}),
    }


def public_names() -> set[str]:
    """Everything that can be called in ``jink.__all__`` and in those of its rooms."""
    from jink import filters, fit, papers, report, stepwise, tracking

    rooms = (association, compare, metrics, scenarios, filters, fit, papers, report, stepwise, tracking)
    return {name for room in (jink, *rooms) for name in room.__all__ if callable(getattr(room, name))}
