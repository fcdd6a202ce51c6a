"""Search by populations over chromosomes in the unit cube: pymoo's genetic algorithm or CMA-ES; seeded, stops and
resumes.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..io.temporary import atomically

OPTIMISERS = ("ga", "cma")
Progress = Callable[[int, float, Array], None]  # generation, least loss so far, its chromosome


@frozen(kw_only=True)
class Chromosome:
    """``genes`` numbers in [0, 1]; the last ``bits`` are a binary string, in which one half or more is 1.

    ``group`` genes are handed on together: the parameters of a rule.
    """

    genes: int
    bits: int = 0
    group: int = 1


class Search(Protocol):
    """An optimiser: ``ask`` gives chromosomes (I, genes), ``tell`` takes their losses (I,)."""

    def ask(self) -> Array: ...
    def tell(self, x: Array, loss: Array) -> None: ...


def search(
    loss: Callable[[Array], Array],
    start: Search,
    generations: int,
    *,
    checkpoint: str | os.PathLike[str] | None = None,
    about: str = "",
    every: int = 10,
    progress: Progress | None = None,
) -> tuple[Array, float]:
    """The chromosome with the least loss, and that.

    checkpoint: a file with the losses told so far, written every so many generations, on Ctrl-C and at the end. Where
    there is one, the search goes the same way again as far as it went, without evaluating anything, and on from there:
    the result is that of a search that was never interrupted. about: what is searched for, to tell searches apart.
    Errors: ValueError for a checkpoint of another search.
    """
    told = _read(checkpoint, about)
    best, least = np.empty(0), np.inf
    try:
        for generation in range(generations):
            x = start.ask()
            if generation == len(told):
                told.append(loss(x))
                if checkpoint and (generation + 1) % every == 0:
                    _write(checkpoint, told, about)
            values = told[generation]
            if values.shape != (len(x),):
                raise ValueError(
                    f"checkpoint: {checkpoint} was written by another search, with {values.size} candidates; "
                    f"expected {len(x)}"
                )
            start.tell(x, values)
            place = int(np.argmin(values))
            if values[place] < least:
                best, least = x[place].copy(), float(values[place])
            if progress:
                progress(generation, least, best)
    except KeyboardInterrupt:
        if checkpoint and told:
            _write(checkpoint, told, about)
        raise
    if checkpoint:
        _write(checkpoint, told, about)
    return best, least


def _read(checkpoint: str | os.PathLike[str] | None, about: str) -> list[Array]:
    if checkpoint is None or not Path(checkpoint).exists():
        return []
    with np.load(checkpoint, allow_pickle=False) as stored:
        if str(stored["about"]) != about:
            raise ValueError(
                f"checkpoint: {checkpoint} was written by another search: {stored['about']}; expected {about}"
            )
        ends = np.cumsum(stored["sizes"])[:-1]
        return np.split(stored["losses"], ends)


def _write(checkpoint: str | os.PathLike[str], told: list[Array], about: str) -> None:
    with atomically(Path(checkpoint)) as (temporary,), temporary.open("wb") as file:
        np.savez(file, losses=np.concatenate(told), sizes=[len(values) for values in told], about=np.array(about))


def genetic(
    chromosome: Chromosome,
    *,
    population: int = 500,
    crossover: float = 0.9,
    mutation: float = 0.01,
    seed: int = 0,
) -> Search:
    """A genetic algorithm: binary tournament, crossover, mutation; the better half of parents and offspring lives on.

    Of a pair that is crossed, each group of parameters (a rule) is blended, a + t (b − a) and b + t (a − b) with t
    uniform in [−¼, 1¼] and kept within the range, and the binary string is cut at one point; each parameter is drawn
    anew, and each bit flipped, with the probability ``mutation``. The loop and the selection are pymoo's.
    """
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.crossover import Crossover
    from pymoo.core.mutation import Mutation
    from pymoo.core.problem import Problem
    from pymoo.core.sampling import Sampling
    from pymoo.operators.selection.tournament import TournamentSelection
    from pymoo.termination import get_termination

    real = chromosome.genes - chromosome.bits

    class Draw(Sampling):
        def _do(self, problem: Any, n_samples: int, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
            x = random_state.random((n_samples, chromosome.genes))
            x[:, real:] = np.round(x[:, real:])
            return x

    class Cross(Crossover):
        def __init__(self) -> None:
            super().__init__(2, 2, prob=crossover)

        def _do(self, problem: Any, X: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
            a, b = X
            groups = -(-real // chromosome.group)
            t = np.repeat(random_state.uniform(-0.25, 1.25, (len(a), groups)), chromosome.group, axis=1)
            u, w, t = a[:, :real], b[:, :real], t[:, :real]
            children = np.concatenate([X[:, :, :real], X[:, :, real:]], axis=2)
            children[0, :, :real] = np.clip(u + t * (w - u), 0, 1)
            children[1, :, :real] = np.clip(w + t * (u - w), 0, 1)
            cut = random_state.integers(0, chromosome.bits + 1, (len(a), 1))
            after = np.arange(chromosome.bits) >= cut
            children[0, :, real:] = np.where(after, b[:, real:], a[:, real:])
            children[1, :, real:] = np.where(after, a[:, real:], b[:, real:])
            return children

    class Mutate(Mutation):
        def _do(self, problem: Any, X: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
            hit = random_state.random(X.shape) < mutation
            anew = random_state.random(X.shape)
            anew[:, real:] = 1 - X[:, real:]
            return np.where(hit, anew, X)

    def better(pop: Any, pairs: np.ndarray, **kwargs: Any) -> np.ndarray:
        losses = pop.get("F")[:, 0][pairs]
        return np.take_along_axis(pairs, losses.argmin(axis=1)[:, None], axis=1)

    class Genetic:
        def __init__(self) -> None:
            self.algorithm = GA(
                pop_size=population,
                sampling=Draw(),  # pyright: ignore[reportArgumentType]
                crossover=Cross(),  # pyright: ignore[reportArgumentType]
                mutation=Mutate(),  # pyright: ignore[reportArgumentType]
                selection=TournamentSelection(func_comp=better),
                eliminate_duplicates=False,
            )
            problem = Problem(n_var=chromosome.genes, n_obj=1, xl=0.0, xu=1.0)
            self.algorithm.setup(problem, termination=get_termination("n_gen", 10**9), seed=seed)

        def ask(self) -> Array:
            self.asked: Any = self.algorithm.ask()
            return self.asked.get("X")

        def tell(self, x: Array, loss: Array) -> None:
            self.asked.set("F", loss[:, None])
            for individual in self.asked:
                individual.evaluated.add("F")
            self.algorithm.tell(infills=self.asked)

    return Genetic()


def cma_es(
    chromosome: Chromosome, *, population: int = 32, spread: float = 0.25, start: Array | None = None, seed: int = 0
) -> Search:
    """CMA-ES on the same chromosomes, within the unit cube; from the middle of it unless ``start`` says otherwise.

    Source: Hansen, The CMA Evolution Strategy: A Tutorial, 2016; the implementation is pycma.
    """
    import cma

    middle = np.full(chromosome.genes, 0.5) if start is None else start
    options = {
        "bounds": [0, 1],
        "seed": seed + 1,
        "popsize": population,
        "verbose": -9,
        "CMA_diagonal": chromosome.genes > 150,
    }

    class Cma:
        def __init__(self) -> None:
            self.strategy = cma.CMAEvolutionStrategy(middle, spread, options)

        def ask(self) -> Array:
            return np.clip(np.asarray(self.strategy.ask()), 0, 1)

        def tell(self, x: Array, loss: Array) -> None:
            self.strategy.tell(list(x), loss.tolist())

    return Cma()
