"""Training of a small network on pairs of inputs and answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..checks import Array
from ..models.network import Network
from .descent import Adam, Kept

Parameters = list[Array]  # W1, b1, W2, b2, …


def fit_network(
    u: Array,
    y: Array,
    *,
    validation: tuple[Array, Array] | None = None,
    weight: Array | None = None,
    hidden: Sequence[int] = (16,),
    epochs: int = 200,
    batch: int = 512,
    rate: float = 0.005,
    decay: float = 1e-5,
    scores: bool = False,
    seed: int = 0,
    progress: Callable[[int, float], None] | None = None,
) -> Network:
    """A network that maps u (N, inputs) to y (N, outputs), both scaled to about one.

    Least squares, weight (N,) per row; with ``scores`` cross-entropy, y being shares that the softmax of the answers is
    to meet. Plus decay · ‖W‖²; Adam over shuffled batches at a rate that falls to zero on a half cosine. The epoch that
    does best on the validation pair is kept (without one, on the training pair).
    """
    rng = np.random.default_rng(seed)
    values = initial([u.shape[1], *hidden, y.shape[1]], rng)
    checked = validation if validation is not None else (u, y)
    share = np.ones(len(u)) if weight is None else weight / weight.mean()
    kept: Kept[Parameters] = Kept()
    adam = Adam(rate)
    for epoch in range(epochs):
        now = 0.5 * rate * (1 + np.cos(np.pi * epoch / epochs))
        order = rng.permutation(len(u))
        for rows in np.array_split(order, max(1, len(u) // batch)):
            answer, layers = forward(values, u[rows])
            slope = share[rows, None] * _slope(answer, y[rows], scores) / len(rows)
            gradients, _ = backward(values, layers, slope)
            gradients = [g + 2 * decay * v if v.ndim == 2 else g for g, v in zip(gradients, values, strict=True)]
            values = adam.step(values, gradients, now)
        kept.offer(_loss(forward(values, checked[0])[0], checked[1], scores), values)
        if progress:
            progress(epoch, kept.loss)
    return as_network(kept.value)


def softmax(scores: Array) -> Array:
    """Shares that sum to one, (N, outputs)."""
    powers = np.exp(scores - scores.max(axis=-1, keepdims=True))
    return powers / powers.sum(axis=-1, keepdims=True)


def _slope(answer: Array, y: Array, scores: bool) -> Array:
    return softmax(answer) - y if scores else 2 * (answer - y)


def _loss(answer: Array, y: Array, scores: bool) -> float:
    if scores:
        return float(-(y * np.log(softmax(answer) + 1e-300)).sum(axis=1).mean())
    return float(((answer - y) ** 2).mean())


def initial(sizes: Sequence[int], rng: np.random.Generator) -> Parameters:
    """Weights of variance 1/inputs, biases zero (Glorot & Bengio 2010 for tanh)."""
    values: Parameters = []
    for before, after in pairwise(sizes):
        values += [rng.normal(0, 1 / np.sqrt(before), (after, before)), np.zeros(after)]
    return values


def forward(values: Parameters, u: Array) -> tuple[Array, list[Array]]:
    """The answers (N, outputs), and what every layer was given, for :func:`backward`."""
    layers = [u]
    for k in range(0, len(values) - 2, 2):
        layers.append(np.tanh(layers[-1] @ values[k].T + values[k + 1]))
    return layers[-1] @ values[-2].T + values[-1], layers


def backward(values: Parameters, layers: list[Array], slope: Array) -> tuple[Parameters, Array]:
    """Gradients in the parameters and in the inputs, from the slope (N, outputs) of the loss in the answers."""
    gradients: Parameters = []
    for k in range(len(values) - 2, -1, -2):
        given = layers[k // 2]
        gradients[:0] = [slope.T @ given, slope.sum(axis=0)]
        slope = slope @ values[k]
        if k:
            slope = slope * (1 - given * given)
    return gradients, slope


def slope_of_inputs(values: Parameters, layers: list[Array], slope: Array) -> Array:
    """The second of :func:`backward` alone."""
    for k in range(len(values) - 2, -1, -2):
        slope = slope @ values[k]
        if k:
            slope = slope * (1 - layers[k // 2] ** 2)
    return slope


def as_network(values: Parameters) -> Network:
    """The parameters as a :class:`jink.models.network.Network`."""
    return Network([w.tolist() for w in values[::2]], [b.tolist() for b in values[1::2]])


def parameters_of(network: Network) -> Parameters:
    """The other way round."""
    pairs = zip(network.weights, network.biases, strict=True)
    return [np.asarray(each, dtype=float) for pair in pairs for each in pair]
