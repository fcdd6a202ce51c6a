"""The filters that `jink learn` can make, each by its recipe: from training and validation runs to a filter."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..checks import Array
from ..filters.aided import Aided
from ..filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..filters.neural_vsmm import NetworkNoise, NeuralModes
from ..models.corrector import CORRECTS
from ..models.fuzzy import FuzzyRules
from ..models.motion import ConstantVelocity
from ..models.provenance import VERSION, Trained
from ..models.sensor import Position
from . import evolution
from .data import Runs

OPTIMISERS = (*evolution.OPTIMISERS, "together")
SHARES = (0.01, 0.1, 1.0)  # of the kind's acceleration: inputs of the sub-models, as in the paper
STAY = 0.97  # per scan
RANGE = (1e-3, 3.0)  # of the kind's acceleration: sds of noise that networks choose from
HISTORY = 8  # innovations an aid looks back on
# five innovations divide the rules, three older ones take part in their consequents alone
ANFIS = {"functions": (2, 2, 2, 2, 2, 1, 1, 1), "kind": "gaussian", "epochs": 25, "rate": 0.05}
NETWORK = {"hidden": (32,), "epochs": 60, "batch": 1024}


@dataclass(frozen=True, kw_only=True)
class How:
    """What `jink learn` was asked for; None where the recipe has a default of its own.

    acceleration (m/s²): what the targets pull; inputs: those of the sub-models; base: the filter to be aided; labels:
    networks learn which mode was right instead of the tracking error; progress(words, done, of) is called as it goes
    on; checkpoint: of searches by populations.
    """

    acceleration: float
    seed: int = 0
    optimiser: str = "ga"
    generations: int | None = None
    population: int | None = None
    rules: int | None = None
    weight: float = 0.95
    inputs: tuple[float, ...] = ()
    base: Any = None
    epochs: int | None = None
    labels: bool = False
    checkpoint: str | os.PathLike[str] | None = None
    progress: Callable[[str, int, int], None] | None = None

    def given(self, **names: str) -> dict[str, Any]:
        """Keywords of those attributes that were asked for: keyword=attribute."""
        return {key: getattr(self, name) for key, name in names.items() if getattr(self, name) is not None}

    def counting(self, words: str, of: int) -> Callable[[int, float], None] | None:
        """A progress for loops that tell their step and the least loss."""
        tell = self.progress
        return None if tell is None else lambda step, loss: tell(f"{words}: least loss {loss:.4g}", step + 1, of)


Recipe = Callable[[Runs, Runs, How], Any]


def fuzzy_modes(training: Runs, validation: Runs, how: How) -> IMM:
    """One set of rules per input, each by its own search; or all and the transition matrix together."""
    if how.optimiser == "together":
        found = _together(training, how, 3)
        motions = [_fuzzy(rules) for rules in found.modes]
        return IMM(motions, _sensor(training), found.transition, mode_probability=np.full(3, 1 / 3))
    inputs = how.inputs or tuple(share * how.acceleration for share in SHARES)
    if len(inputs) == 1:
        raise ValueError("inputs: an IMM has at least two modes; fuzzy-kalman has one")
    rules = [_identified(each, training, how, k) for k, each in enumerate(inputs)]
    return fuzzy_imm(_sensor(training), rules, STAY)


def fuzzy_mode(training: Runs, validation: Runs, how: How) -> Kalman:
    """One set of rules for the whole range of what the targets do."""
    if len(how.inputs) > 1:
        raise ValueError("inputs: fuzzy-kalman has one mode; fuzzy-imm has one for each")
    if how.optimiser == "together":
        return Kalman(_fuzzy(_together(training, how, 1).modes[0]), _sensor(training))
    most, spread = (how.inputs or (how.acceleration,))[0], (2 * SHARES[0]) ** -0.5
    rules = _identified(most / spread, training, how, 0, widen=spread)  # noise from a hundredth of that up to it
    return Kalman(_fuzzy(rules), _sensor(training))


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
SEARCHED = ("fuzzy-imm", "fuzzy-kalman")  # by populations: these have optimisers, rules and checkpoints


def _sensor(runs: Runs) -> Position:
    return Position(sd=runs.sd, axes=runs.axes)


def _fuzzy(rules: FuzzyRules) -> Any:
    return FuzzyNoise(ConstantVelocity(acceleration_sd=float(np.sqrt(np.mean(rules.variances)))), rules)


def _identified(acceleration: float, training: Runs, how: How, place: int, widen: float = 1.0) -> FuzzyRules:
    from .genetic import Settings, identify

    # the paper's kilometres are two sds of its measurement, its runs sixty scans: so errors weigh against rules as
    # there
    unit = 2 * training.sd * training.time.shape[1] / 60
    settings = Settings(
        weight=how.weight,
        optimiser=how.optimiser,
        widen=widen,
        unit=unit,
        **how.given(generations="generations", population="population", most_rules="rules"),
    )

    def tell(generation: int, fitness: float, rules: int) -> None:
        if how.progress:
            words = f"{acceleration:g} m/s², generation: best fitness {fitness:.4g} with {rules} rules"
            how.progress(words, generation + 1, settings.generations)

    checkpoint = None if how.checkpoint is None else f"{os.fspath(how.checkpoint)}.{place}.npz"
    return identify(
        acceleration,
        training,
        settings=settings,
        process_sd=SHARES[0] * acceleration,
        seed=how.seed,
        checkpoint=checkpoint,
        progress=tell,
    )


def _together(training: Runs, how: How, modes: int) -> Any:
    from .interacting import identify_modes

    generations = how.generations or 250
    return identify_modes(
        training,
        modes=modes,
        interval=(RANGE[0] * how.acceleration, 2 * how.acceleration),
        seed=how.seed,
        rules=how.rules or (2 if modes > 1 else 6),
        generations=generations,
        checkpoint=None if how.checkpoint is None else f"{os.fspath(how.checkpoint)}.0.npz",
        progress=how.counting("generation", generations),
        **how.given(population="population"),
    )


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
