"""Small fully connected networks, trained fast and reproducibly.

Hidden layers are rectified linear units, the output is one number, and the loss is the mean
squared error of a mini-batch. For networks of this size the training time is dominated by
overhead and by the memory traffic of the optimiser. All weights of a network are therefore stored
in one flat vector, and the gradient is coded by hand. With the activations a_0 = x,
a_i = max(0, a_(i-1) W_i + b_i) and the error d = dL/d(a_(i-1) W_i + b_i), from the last layer to
the first::

    dL/dW_i = a_(i-1)' d      dL/db_i = sum d      d <- (d W_i') [a_(i-1) > 0]

Networks of equal depth can be trained in one batched computation, each layer padded with zeros to
the widest network: the gradient of a padded weight is zero, so padding stays zero. Batching is
used on a GPU; on a CPU it brings nothing, and networks are trained one by one.

Initial weights (uniform within sqrt(6 / (in + out)), Glorot and Bengio 2010) and the order of the
rows come from the network's own seed, and each network is trained in one thread (`one_thread`).
Its score therefore depends neither on the networks trained beside it nor on the number of cores.
On a GPU the order of summation depends on the batch, so the last digits do depend on the other
networks in it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from abradem.learning.model_files import predict_network


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """Limit torch and the BLAS library behind numpy to one thread.

    More threads would change the order of summation and so the last digits. Without this limit
    both would use as many threads as the workflow rule has cores.
    """
    import torch
    from threadpoolctl import threadpool_limits

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        torch.set_num_threads(threads)


Layers = tuple[int, ...]
"""Number of neurons in each hidden layer."""


class Training(NamedTuple):
    """Settings of the Adam optimiser; the defaults are those of the paper's searches."""

    epochs: int = 20
    batch: int = 32
    learning_rate: float = 1e-3


class Network(NamedTuple):
    """Weights (in, out) and biases (out,) of every layer, in single precision."""

    weights: list[np.ndarray]
    biases: list[np.ndarray]

    def predict(self, rows: np.ndarray) -> np.ndarray:
        """Output for scaled rows (n, p), shape (n,)."""
        return predict_network(self.arrays(), rows)

    def arrays(self) -> dict[str, np.ndarray]:
        """Weights and biases by name, as they are stored in a file."""
        named = {}
        for layer, (weights, biases) in enumerate(zip(self.weights, self.biases, strict=True)):
            named[f"weights_{layer}"], named[f"biases_{layer}"] = weights, biases
        return named


def network_of(arrays: dict[str, np.ndarray]) -> Network:
    """Network from arrays named as by `Network.arrays`."""
    count = sum(name.startswith("weights_") for name in arrays)
    return Network(*([arrays[f"{kind}_{i}"] for i in range(count)] for kind in _KINDS))


_KINDS = ("weights", "biases")


def parameters_of(inputs: int, hidden: Layers) -> int:
    """Number of weights and biases of a network with ``inputs`` features and one output."""
    sizes = (inputs, *hidden, 1)
    return sum((a + 1) * b for a, b in pairwise(sizes))


def start(inputs: int, hidden: Layers, seed: int, heritage: Network | None = None) -> Network:
    """Initial weights of a network.

    Parameters
    ----------
    inputs : int
        Number of features.
    hidden : tuple of int
        Neurons of the hidden layers.
    seed : int
    heritage : Network, optional
        Its weights replace the random ones where the layers overlap. Hidden layers are matched
        from the input on, the output layer with the output layer.
    """
    rng = np.random.default_rng([seed, 0])
    sizes = (inputs, *hidden, 1)
    weights, biases = [], []
    for a, b in pairwise(sizes):
        reach = np.sqrt(6.0 / (a + b))
        weights.append(rng.uniform(-reach, reach, (a, b)).astype(np.float32))
        biases.append(np.zeros(b, dtype=np.float32))
    if heritage is not None:
        last, theirs = len(weights) - 1, len(heritage.weights) - 1
        for mine, other in [*((i, i) for i in range(min(last, theirs))), (last, theirs)]:
            old, bias = heritage.weights[other], heritage.biases[other]
            a, b = (min(p, q) for p, q in zip(weights[mine].shape, old.shape, strict=True))
            weights[mine][:a, :b] = old[:a, :b]
            biases[mine][:b] = bias[:b]
    return Network(weights, biases)


LARGEST_TARGET = 1e15
"""Magnitude to which targets are cut, as squares of larger ones overflow in single precision."""


def train(
    starts: Sequence[Network],
    seeds: Sequence[int],
    x: np.ndarray,
    y: np.ndarray,
    training: Training = Training(),  # noqa: B008  (immutable)
    device: str = "cpu",
) -> list[Network]:
    """Train networks of equal depth together.

    Parameters
    ----------
    starts : sequence of Network
        Initial weights.
    seeds : sequence of int
        Seeds of the order of the rows, one for each network.
    x : ndarray, shape (n, p)
        Scaled features.
    y : ndarray, shape (n,)
        Scaled target.
    training : Training
    device : {"cpu", "cuda"}

    Returns
    -------
    list of Network
        The trained networks, in the order of ``starts``.
    """
    import torch

    count, depth = len(starts), len(starts[0].weights)
    shapes = [
        tuple(max(side) for side in zip(*(net.weights[i].shape for net in starts), strict=True))
        for i in range(depth)
    ]
    total = sum((a + 1) * b for a, b in shapes)
    flat = np.zeros((count, total), dtype=np.float32)
    for row, net in zip(flat, starts, strict=True):
        for (weights, bias), w, b in zip(_views(row[None], shapes), *net, strict=True):
            weights[0, : w.shape[0], : w.shape[1]] = w
            bias[0, 0, : len(b)] = b
    parameters = torch.from_numpy(flat).to(device).requires_grad_()
    parameters.grad = torch.zeros_like(parameters)
    adam = torch.optim.Adam([parameters], lr=training.learning_rate, fused=True)
    rows = torch.from_numpy(x.astype(np.float32)).to(device)
    wanted = np.clip(y, -LARGEST_TARGET, LARGEST_TARGET).astype(np.float32)
    target = torch.from_numpy(wanted).to(device)[:, None]
    rngs = [np.random.default_rng([seed, 1]) for seed in seeds]
    with torch.no_grad():
        layers = list(_views(parameters, shapes))
        gradients = list(_views(parameters.grad, shapes))
        if count == 1:
            # Plain matrix products are faster than a batch of one.
            layers, gradients = ([(w[0], b[0]) for w, b in part] for part in (layers, gradients))
        for _ in range(training.epochs):
            drawn = np.stack([rng.permutation(len(y)) for rng in rngs])
            order = torch.from_numpy(drawn[0] if count == 1 else drawn).to(device)
            shuffled, wanted = rows[order], target[order]
            for first in range(0, len(y), training.batch):
                part = slice(first, first + training.batch)
                _backward(torch, layers, gradients, shuffled[..., part, :], wanted[..., part, :])
                adam.step()
    flat = parameters.detach().cpu().numpy()
    trained = []
    for row, net in zip(flat, starts, strict=True):
        parts = list(zip(_views(row[None], shapes), *net, strict=True))
        trained.append(
            Network(
                [w[0, : own.shape[0], : own.shape[1]].copy() for (w, _), own, _ in parts],
                [b[0, 0, : len(own)].copy() for (_, b), _, own in parts],
            )
        )
    return trained


def _views(flat, shapes):
    """Yield views of the weights (count, in, out) and biases (count, 1, out) of each layer."""
    place = 0
    for a, b in shapes:
        weights = flat[:, place : place + a * b].reshape(len(flat), a, b)
        place += a * b
        yield weights, flat[:, place : place + b].reshape(len(flat), 1, b)
        place += b


def _backward(torch, layers, gradients, rows, wanted) -> None:
    """Write the gradient of the mean squared error of a mini-batch to ``gradients``."""
    activations = [rows]
    for layer, (weights, bias) in enumerate(layers):
        value = torch.matmul(activations[-1], weights).add_(bias)
        activations.append(value if layer == len(layers) - 1 else value.relu_())
    error = (activations[-1] - wanted).mul_(2.0 / wanted.shape[-2])
    for layer in reversed(range(len(layers))):
        weights = layers[layer][0]
        of_weights, of_bias = gradients[layer]
        torch.matmul(activations[layer].mT, error, out=of_weights)
        torch.sum(error, dim=-2, keepdim=True, out=of_bias)
        if layer:
            error = torch.matmul(error, weights.mT).mul_(activations[layer] > 0)
