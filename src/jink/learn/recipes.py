"""The filters that `jink learn` can make, each by its recipe: from training and validation runs to a filter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import prod
from typing import Any

import numpy as np

from ..catalogue.choose import default_filter
from ..checks import Array
from ..filters.aided import Aided
from ..filters.corrected import Corrected
from ..filters.kalman import Kalman
from ..filters.neural_vsmm import NetworkNoise, NeuralModes
from ..models.corrector import CORRECTS
from ..models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Motion
from ..models.provenance import VERSION, Trained
from ..models.sensor import Position
from .data import Runs
from .how import RANGE, How
from .rule_recipes import SEARCHED, fuzzy_mode, fuzzy_modes

COUNTS = {"titi-guney": 2, "innovations": 8, "sums": 4}  # inputs of an aid; both others look back on 8 innovations
ANFIS: dict[str, dict[str, Any]] = {
    "sums": {"functions": (3, 3, 3, 3), "kind": "gaussian", "epochs": 10, "rate": 0.05},
    # five innovations divide the rules, three older ones take part in their consequents alone
    "innovations": {"functions": (2, 2, 2, 2, 2, 1, 1, 1), "kind": "gaussian", "epochs": 25, "rate": 0.05},
    "titi-guney": {"functions": (4, 4), "kind": "triangular", "epochs": 25, "rate": 0.05},
}
SEEN = {
    "titi-guney": "the residual and the step",
    "innovations": f"the last {COUNTS['innovations']} innovations",
    "sums": "sums of the last 1, 2, 4 and 8 innovations",
}
MOST_RULES = 256  # of an ANFIS
# modes of each kind for targets that pull so much (m/s²); acceleration and turn as in imm-cv-ca and imm-cv-ct
BANK: dict[str, Callable[[float], list[Motion]]] = {
    "cv": lambda a: [ConstantVelocity(acceleration_sd=share * a) for share in (RANGE[0], 0.1, 1.0)],
    "ca": lambda a: [ConstantAcceleration(jerk_psd=(a / 40) ** 2, acceleration_prior_sd=a)],
    "ct": lambda a: [CoordinatedTurn(acceleration_psd=(a / 20) ** 2, turn_rate_psd=2.5e-7, turn_rate_prior_sd=0.06)],
}
NETWORK = {"hidden": (32,), "epochs": 60, "batch": 1024}


Recipe = Callable[[Runs, Runs, How], Any]


def aided(model: str) -> Recipe:
    """A filter with a corrector on its last innovations."""

    def make(training: Runs, validation: Runs, how: How) -> Aided:
        from .aid import fit_corrector, tuned_acceleration, weakened

        base = how.base if how.base is not None else tuned_acceleration(training)
        inputs = how.aid_inputs
        settings = dict(NETWORK) if model == "network" else _anfis(inputs, how)
        epochs = settings["epochs"] = how.epochs or settings["epochs"]
        corrector = fit_corrector(
            base,
            training,
            validation,
            model=model,
            inputs=inputs,
            count=COUNTS[inputs],
            corrects=("position",) if inputs == "titi-guney" else _corrected(base, training),
            seed=how.seed,
            progress=how.counting(f"{model}, epoch", epochs),
            **settings,
        )
        trained_by = f" of {settings['method']}" if "method" in settings else ""
        corrector, gains = weakened(base, validation, corrector)
        said = _trained(
            training, f"{model} on {SEEN[inputs]}, {epochs} epochs{trained_by}, gain {_percent(gains)}", how
        )
        return Aided(base, replace(corrector, trained=said))

    return make


def _percent(gains: tuple[float, ...]) -> str:
    return " and ".join(f"{100 * gain:.0f} %" for gain in gains)


def _anfis(inputs: str, how: How) -> dict[str, Any]:
    """Settings of an ANFIS: the recipe's own, and what was asked for. Errors: ValueError for too many rules."""
    settings = dict(ANFIS[inputs])
    if how.functions is not None:
        of_inputs = tuple(how.functions if n > 1 else n for n in settings["functions"])
        if prod(of_inputs) > MOST_RULES:
            raise ValueError(
                f"functions: {how.functions} make {prod(of_inputs)} rules; expected at most {MOST_RULES} rules"
            )
        settings["functions"] = of_inputs
    return settings | how.given(kind="membership", method="method")


def noise_network(training: Runs, validation: Runs, how: How) -> Kalman:
    """A network that chooses the noise, trained on the tracking error itself or on which noise was best."""
    from .end_to_end import train_end_to_end
    from .supervised import LEVELS, sensor_levels, train_supervised

    _plane(training)
    if how.labels:
        least, most = ((share * how.acceleration) ** 2 for share in RANGE)
        levels = sensor_levels(training) if how.labels == "argmin" else np.geomspace(least, most, len(LEVELS))
        network = train_supervised(
            training,
            validation,
            labels="published" if how.labels == "argmin" else "expected",
            levels=levels,
            seed=how.seed,
            **how.given(epochs="epochs"),
        )
        method = "labels of the best filter of the bank, as published" if how.labels == "argmin" else "expected labels"
    else:
        steps = how.epochs or 600
        least, most = (float((share * how.acceleration) ** 2) for share in RANGE)
        network = train_end_to_end(
            training,
            validation,
            least=least,
            most=most,
            steps=steps,
            seed=how.seed,
            start=float(np.sqrt(least * most)),
            velocity_share=0.2 if _known(training.velocity) else 0.0,
            progress=how.counting("step", steps),
        )
        method = f"end to end on the tracking error, {steps} steps"
    network = replace(network, trained=_trained(training, method, how))
    motion: Any = NetworkNoise(ConstantVelocity(acceleration_sd=how.acceleration), network)
    return Kalman(motion, _sensor(training))


def mode_network(training: Runs, validation: Runs, how: How) -> NeuralModes:
    """A network that scores constant-velocity modes of five noises, on labels or on the tracking error itself; or the
    modes of a bank, on labels.
    """
    from .modes import train_scores, untrained
    from .modes_end_to_end import train_scores_end_to_end

    _plane(training)
    sds = how.inputs or tuple(np.geomspace(*RANGE, 5) * how.acceleration)
    motions: list[Any] = _bank(how) or [ConstantVelocity(acceleration_sd=float(sd)) for sd in sds]
    if how.labels or how.bank:
        epochs = how.epochs or 100
        network = train_scores(motions, training, validation, best=min(3, len(motions)), epochs=epochs, seed=how.seed)
        method = f"labels of the best of {len(motions)} modes"
    else:
        steps = how.epochs or 120
        network = train_scores_end_to_end(
            [float(sd) ** 2 for sd in sds],
            training,
            validation,
            start=untrained(len(sds), seed=how.seed),
            steps=steps,
            seed=how.seed,
            progress=how.counting("step", steps),
        )
        method = f"end to end on the tracking error, {steps} steps"
    network = replace(network, trained=_trained(training, method, how))
    return NeuralModes(motions, _sensor(training), network)


def _bank(how: How) -> list[Motion]:
    """The motions of the bank that was asked for. Errors: ValueError for other kinds, a kind twice, or one mode."""
    wrong = [kind for kind in how.bank if kind not in BANK] or [k for k in how.bank if how.bank.count(k) > 1]
    if wrong:
        raise ValueError(f"bank: expected some of {', '.join(BANK)}, each once, got {','.join(how.bank)}")
    motions = [motion for kind in how.bank for motion in BANK[kind](how.acceleration)]
    if len(motions) == 1:
        raise ValueError(f"bank: {how.bank[0]} is one mode; expected at least two, for example cv,{how.bank[0]}")
    return motions


def corrected(training: Runs, validation: Runs, how: How) -> Corrected:
    """The kind's default filter with a correction in the plane, learned on random families and on the runs."""
    from .plane import EPOCHS, FAMILIES, fit_plane
    from .plane_inputs import pairs_of

    if training.axes < 2:
        raise ValueError("its correction is in the plane; the data have one axis")
    filter = default_filter(how.kind, _sensor(training), training.axes)
    R = training.sd**2 * np.eye(2)
    more = [
        [pairs_of(filter, runs.time, runs.z, R, runs.position[..., :2], runs.velocity[..., :2])]
        for runs in (training, validation)
    ]
    families, epochs = how.families or FAMILIES, how.epochs or EPOCHS
    found = fit_plane(
        how.kind,
        families=families,
        epochs=epochs,
        seed=how.seed,
        more=(more[0], more[1]),
        progress=how.progress,
    )
    method = f"network of {found.hidden} units on {families} random families of the kind {how.kind}, {epochs} epochs"
    return Corrected(filter, replace(found, trained=_trained(training, method, how)))


RECIPES: dict[str, Recipe] = {
    "corrector": corrected,
    "fuzzy-imm": fuzzy_modes,
    "fuzzy-kalman": fuzzy_mode,
    "anfis-kf": aided("anfis"),
    "nn-kf": aided("network"),
    "nnvsmm": noise_network,
    "nnvsmm-modes": mode_network,
}


def _sensor(runs: Runs) -> Position:
    return Position(sd=runs.sd, axes=runs.axes)


def _corrected(base: Any, training: Runs) -> tuple[str, ...]:
    """Position, and velocity where base and truth have it."""
    known = np.isfinite(training.velocity).any() and "vx" in base.components
    return CORRECTS[: 2 if known else 1]


def _trained(training: Runs, method: str, how: How) -> Trained:

    return Trained(data=str(training), method=method, seeds=(how.seed,), version=VERSION)


def _plane(runs: Runs) -> None:
    if runs.axes != 2:
        raise ValueError(f"its network looks at two axes; the data have {runs.axes}")


def truth_needed(name: str) -> tuple[str, ...]:
    """Which parts of the truth a recipe cannot do without."""
    return ("position", "velocity") if name in (*SEARCHED, "corrector") else ("position",)


def missing_truth(name: str, runs: Runs) -> str:
    """The first of these that the runs do not have; "" for none."""
    return next((part for part in truth_needed(name) if not _known(getattr(runs, part))), "")


def _known(values: Array) -> bool:
    return bool(np.isfinite(values).any())
