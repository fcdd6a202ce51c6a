"""How modes switch: a transition matrix per scan, or a chain in continuous time."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..checks import MOST, Array, numbers, positive, whole
from ..frozen import frozen


@frozen(eq=False)
class Sojourn:
    """Mode switching in continuous time: mean ``seconds`` spent in each mode, then ``to`` (rows sum to one, diagonal
    zero).

    Gᵢᵢ = −1/secondsᵢ, Gᵢⱼ = toᵢⱼ/secondsᵢ, transition over dt = exp(G dt). Without ``to`` the others are equally
    likely.
    """

    seconds: Sequence[float]
    to: ArrayLike | None = None

    def generator(self, modes: int) -> Array:
        """G (M, M), 1/s. Errors: ValueError for the wrong number of modes or rows that do not sum to one."""
        whole("modes", modes, 1)
        rates = [_rate("Sojourn.seconds", s) for s in numbers("Sojourn.seconds", self.seconds).ravel()]
        if len(rates) != modes:
            raise ValueError(f"Sojourn.seconds: expected one number for each of {modes} modes, got {len(rates)}")
        if self.to is None:
            to = (np.ones((modes, modes)) - np.eye(modes)) / max(modes - 1, 1)
        else:
            to = numbers("Sojourn.to", self.to)
            if to.shape != (modes, modes) or np.any(to < 0) or np.any(np.diag(to) != 0):
                raise ValueError(
                    f"Sojourn.to: expected a {modes} by {modes} matrix without negative entries, its diagonal zero"
                )
            if modes > 1 and not np.allclose(to.sum(axis=1), 1):
                raise ValueError(f"Sojourn.to: rows must sum to one, got {to.sum(axis=1)}")
        return np.asarray(rates)[:, None] * (to - np.eye(modes)) if modes > 1 else np.zeros((1, 1))


Transition = ArrayLike | Sojourn  # a stay probability, a matrix per scan, or a chain in continuous time


def transition_rule(transition: object, step: float | None, modes: int) -> tuple[bool, Array]:
    """(continuous, matrix): a row-stochastic matrix per scan, or the generator of a continuous-time chain.

    transition: a stay probability, a matrix, or a :class:`Sojourn`; with ``step`` (s) the matrix holds for that elapsed
    time.
    """
    if isinstance(transition, Sojourn):
        return True, transition.generator(modes)
    matrix = numbers("transition", transition, "a stay probability, a matrix or a jink.Sojourn")  # pyright: ignore[reportArgumentType]
    if matrix.ndim == 0:
        stay = float(matrix)
        if not 0 < stay <= 1:
            raise ValueError(f"transition: expected a stay probability above 0 and at most 1, got {stay:g}")
        others = (1 - stay) / max(modes - 1, 1)
        matrix = np.full((modes, modes), others) + (stay - others) * np.eye(modes) if modes > 1 else np.ones((1, 1))
    if matrix.shape != (modes, modes):
        raise ValueError(f"transition: expected a {modes} by {modes} matrix, got shape {matrix.shape}")
    if np.any(~np.isfinite(matrix)) or np.any(matrix < 0):
        raise ValueError("transition: has negative or non-finite entries")
    if not np.allclose(matrix.sum(axis=1), 1, atol=1e-9):
        raise ValueError(
            f"transition: transition[i, j] = p(j | i), so each row must sum to one; got {matrix.sum(axis=1)}"
        )
    if np.any(matrix.sum(axis=0) == 0):
        raise ValueError(f"transition: mode {int(np.argmin(matrix.sum(axis=0)))} cannot be reached")
    if step is None:
        return False, matrix
    return True, _matrix_log(matrix) * _rate("transition_step", step)


def _rate(name: str, seconds: float) -> float:
    """1/s of so many seconds, a number whose square is one too."""
    if 0 < positive(name, seconds) < 1 / MOST:
        raise ValueError(f"{name}: expected at least {1 / MOST:g}, got {seconds:g}")
    return 1.0 / seconds


def _matrix_log(matrix: Array) -> Array:
    values, vectors = np.linalg.eig(matrix)
    with np.errstate(all="ignore"):
        G = (vectors * np.log(values.astype(complex))) @ np.linalg.inv(vectors)
    off = G.real - np.diag(np.diag(G.real))
    if not np.all(np.isfinite(G)) or np.abs(G.imag).max() > 1e-9 or off.min() < -1e-9:
        raise ValueError(
            "transition: no continuous-time chain gives this matrix over transition_step; use a jink.Sojourn"
        )
    off = np.maximum(off, 0)
    return off - np.diag(off.sum(axis=1))


def stationary(continuous: bool, matrix: Array) -> Array:
    """The chain's stationary distribution; uniform if it has more than one."""
    modes = len(matrix)
    A = np.vstack([matrix.T - (0 if continuous else np.eye(modes)), np.ones(modes)])
    solution, _, rank, _ = np.linalg.lstsq(A, np.append(np.zeros(modes), 1.0), rcond=None)
    if rank < modes or np.any(solution < -1e-9):
        return np.full(modes, 1 / modes)
    return np.maximum(solution, 0) / np.maximum(solution, 0).sum()
