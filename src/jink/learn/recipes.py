"""The filters that `jink learn` can make, each by its recipe: from training and validation runs to a filter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..checks import Array
from ..filters.aided import Aided
from ..filters.kalman import Kalman
from ..filters.neural_vsmm import NetworkNoise, NeuralModes
from ..models.corrector import CORRECTS
from ..models.motion import ConstantVelocity
from ..models.provenance import VERSION, Trained
from ..models.sensor import Position
from .data import Runs
from .how import RANGE, How
from .rule_recipes import SEARCHED, fuzzy_mode, fuzzy_modes

HISTORY = 8  # innovations an aid looks back on
# five innovations divide the rules, three older ones take part in their consequents alone
ANFIS = {"functions": (2, 2, 2, 2, 2, 1, 1, 1), "kind": "gaussian", "epochs": 25, "rate": 0.05}
NETWORK = {"hidden": (32,), "epochs": 60, "batch": 1024}


Recipe = Callable[[Runs, Runs, How], Any]


def aided(model: str) -> Recipe:
    """A filter with a corrector on its last innovations."""

    def make(training: Runs, validation: Runs, how: How) -> Aided:
        from .aid import fit_corrector, tuned_acceleration

        base = how.base if how.base is not None else tuned_acceleration(training)
        settings: dict[str, Any] = {**(NETWORK if model == "network" else ANFIS)}
        epochs = settings["epochs"] = how.epochs or settings["epochs"]
        corrector = fit_corrector(
            base,
            training,
            validation,
            model=model,
            inputs="innovations",
            count=HISTORY,
            corrects=_corrected(base, training),
            seed=how.seed,
            progress=how.counting(f"{model}, epoch", epochs),
            **settings,
        )
        said = _trained(training, f"{model} on the last {HISTORY} innovations, {epochs} epochs", how)
        return Aided(base, replace(corrector, trained=said))

    return make


def noise_network(training: Runs, validation: Runs, how: How) -> Kalman:
    """A network that chooses the noise, trained on the tracking error itself or on which noise was best."""
    from .end_to_end import train_end_to_end
    from .supervised import train_supervised

    _plane(training)
    if how.labels:
        network = train_supervised(training, validation, labels="expected", seed=how.seed, **how.given(epochs="epochs"))
        method = "labels of the best constant noise"
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
    """A network that scores constant-velocity modes of five noises, on labels or on the tracking error itself."""
    from .modes import train_scores, untrained
    from .modes_end_to_end import train_scores_end_to_end

    _plane(training)
    sds = how.inputs or tuple(np.geomspace(*RANGE, 5) * how.acceleration)
    motions: list[Any] = [ConstantVelocity(acceleration_sd=float(sd)) for sd in sds]
    if how.labels:
        epochs = how.epochs or 100
        network = train_scores(motions, training, validation, best=min(3, len(sds)), epochs=epochs, seed=how.seed)
        method = "labels of the best mode"
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


RECIPES: dict[str, Recipe] = {
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
    return ("position", "velocity") if name in SEARCHED else ("position",)


def missing_truth(name: str, runs: Runs) -> str:
    """The first of these that the runs do not have; "" for none."""
    return next((part for part in truth_needed(name) if not _known(getattr(runs, part))), "")


def _known(values: Array) -> bool:
    return bool(np.isfinite(values).any())
