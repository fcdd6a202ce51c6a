"""What learned rules add: how many there are, and their error over that of constants within the same bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..catalogue.purpose import Named, Purpose
from ..compare.result import Race
from ..compare.scores import NAN
from ..filters.imm import IMM
from ..learn.constants import best_constant
from ..learn.genetic import Settings, training_runs
from ..metrics import Figure
from ..models.motion import ConstantVelocity
from .paper import POSITION, Maker, Metric, named, over

INPUTS = (1.0, 10.0, 100.0)  # m/s²: the sub-models of lee-2003


def over_constants(rivals: Mapping[str, str], words: str) -> Metric:
    """Position RMSE over that of the constants that a filter of rules is measured against, paired run by run."""

    def measure(race: Race, filter: str) -> Figure:
        return over(rivals[filter], POSITION, words).measure(race, filter) if filter in rivals else NAN

    return Metric("position_rmse_over_constants", words, measure)


def with_rule_counts(maker: Maker) -> Maker:
    """The same filter; its note says how many rules each mode has."""

    def make(purpose: Purpose) -> Named:
        made = maker(purpose)
        counts = [len(motion.rules) for motion in made.filter.motions]
        said = f"rules per mode: {', '.join(map(str, counts))}"
        note = f"{said}, which are constants" if set(counts) == {1} else said
        return Named(filter=made.filter, words=f"{made.words}; {note}", fitted=made.fitted, note=note)

    return make


def best_constants(seed: int) -> Callable[[Purpose], Named]:
    """Of each sub-model the best constant within eq. 15's interval, found on the targets that the GA saw."""

    def make(purpose: Purpose) -> Named:
        sds = [best_constant(u, training_runs(u, seed=seed), Settings(), 1.0) for u in INPUTS]
        filter = IMM(
            [ConstantVelocity(acceleration_sd=sd) for sd in sds],
            purpose.seen,
            transition=0.97,
            mode_probability=[0.6, 0.2, 0.2],
        )
        return named(
            f"IMM of the best constants within equation 15, sd {', '.join(f'{s:g}' for s in sds)} m/s²", filter
        )

    return make
