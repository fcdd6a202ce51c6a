"""The learned filters of the papers: as they come with the package, or trained again."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from ..catalogue.purpose import Named, Purpose, Unfit
from ..catalogue.shipped import shipped
from ..filters.aided import unaided
from .training.shipped import SEEDS, train

Models = Callable[[str, int | None], Any]  # a model's name and the seed of its training → the filter
__all__ = ["Models", "alone", "each_seed", "learned", "retrained", "shipped"]


def retrained(quick: bool) -> Models:
    """Models that are trained when they are asked for, once each."""

    @cache
    def made(name: str, seed: int | None) -> Any:
        return train(name, seed or 0, quick)

    return made


def learned(
    models: Models, name: str, words: str, *, fitted: str = "", seed: int | None = None
) -> Callable[[Purpose], Named]:
    """A learned filter as a paper's; words say what it is, fitted on which runs of the scenario, "" for none.

    A model that does not come with the package cannot take part, and the table says so.
    """

    def make(purpose: Purpose) -> Named:
        try:
            return Named(filter=models(name, seed), words=words, fitted=fitted)
        except ValueError as reason:
            if not str(reason).startswith("unknown model"):
                raise
            raise Unfit("its trained model does not come with the package") from None

    return make


def alone(models: Models, name: str, words: str, *, fitted: str = "") -> Callable[[Purpose], Named]:
    """The filter under a model's aid, without the aid."""
    return lambda purpose: Named(filter=unaided(models(name, None)), words=words, fitted=fitted)


def each_seed(models: Models, name: str, words: str) -> list[Callable[[Purpose], Named]]:
    """The same training from several seeds: one alone would be a lottery."""
    return [learned(models, name, f"{words}, seed {seed}", seed=seed) for seed in SEEDS]
