"""Speed of the genetic search compared with a plain loop over the layers of torch.

    python benchmarks/ga.py [--cores N] [--generations N] [--rows N]

The networks are in the ranges of the study (2 to 6 hidden layers of 10 to 500 neurons), with its
training settings (12 features, 20 epochs, batches of 32, Adam). The plain loop trains one network
after the other with one thread, the fastest setting of torch for such small networks. Both train
the same networks. Then a complete search is timed.

Optimisations that were tried: flat weight vectors with hand-written gradients and the fused
optimiser (kept); one network per core with one thread (kept, with processes, because threads share
the lock of the interpreter); the largest network first (kept); results of repeated chromosomes from
memory (kept); padding to one batch (no gain on a CPU, kept for GPUs); grouping by depth (only
useful for batches); early stopping of poor networks (not used: relative to other networks, the
score of a network would depend on them; relative to a fixed threshold, few networks are below it,
see docs/learning.md).
"""

from __future__ import annotations

import argparse
import time
from itertools import pairwise

import numpy as np
import torch

from abradem.learning.baselines.genetic import (
    Options,
    SearchProblem,
    search,
    train_again,
    usable_cores,
)
from abradem.learning.network import Training

LIMIT = 100.0
"""Largest time of 25 generations of 10 networks on two cores, s."""
GAIN = 1.5
"""Smallest gain over the plain loop."""


def plain(hidden: tuple[int, ...], seed: int, x: np.ndarray, y: np.ndarray, training: Training):
    """Return one network trained with the layers, gradients and optimiser of torch."""
    torch.manual_seed(seed)
    sizes, layers = (x.shape[1], *hidden, 1), []
    for a, b in pairwise(sizes):
        layers += [torch.nn.Linear(a, b), torch.nn.ReLU()]
    model = torch.nn.Sequential(*layers[:-1])
    adam = torch.optim.Adam(model.parameters(), lr=training.learning_rate)
    rows = torch.from_numpy(x.astype(np.float32))
    target = torch.from_numpy(y.astype(np.float32))[:, None]
    for _ in range(training.epochs):
        order = torch.randperm(len(y))
        for first in range(0, len(y), training.batch):
            part = order[first : first + training.batch]
            adam.zero_grad()
            torch.nn.functional.mse_loss(model(rows[part]), target[part]).backward()
            adam.step()
    return model


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--cores", type=int, default=min(2, usable_cores()))
    parser.add_argument("--generations", type=int, default=25)
    parser.add_argument("--rows", type=int, default=138)
    options = parser.parse_args()

    torch.set_num_threads(1)
    rng = np.random.default_rng(0)
    x = rng.standard_normal((options.rows + 60, 12))
    y = x[:, 0] * x[:, 1] + x[:, 2]
    problem = SearchProblem(
        x[: options.rows], y[: options.rows], x[options.rows :], y[options.rows :]
    )
    training = Training()
    nets = [tuple(int(n) for n in rng.integers(10, 501, rng.integers(2, 7))) for _ in range(20)]

    plain(nets[0], 0, problem.x, problem.y, training)
    train_again(nets[0], [0], problem.x, problem.y, training)
    # Alternating, so that other load on the machine affects both equally.
    loop = ours = 0.0
    for net in nets:
        began = time.perf_counter()
        plain(net, 0, problem.x, problem.y, training)
        middle = time.perf_counter()
        train_again(net, [0], problem.x, problem.y, training)
        loop += middle - began
        ours += time.perf_counter() - middle
    print(f"10 networks, plain loop, one core:  {loop / 2:6.2f} s")
    print(f"10 networks, this package, one core:{ours / 2:6.2f} s  ({loop / ours:.2f} x)")

    began = time.perf_counter()
    found = search(problem, Options(generations=options.generations), training, 0, options.cores)
    seconds = time.perf_counter() - began
    trained = found.history.drop_duplicates(["layers", "weights_seed"])
    total = (
        loop
        / sum(_work(net) for net in nets)
        * sum(_work(tuple(map(int, text.split("-")))) for text in found.history["layers"])
    )
    print(
        f"{options.generations} generations of 10, {options.cores} cores: {seconds:.1f} s "
        f"({len(trained)} networks trained; the plain loop would take about {total:.0f} s: "
        f"{total / seconds:.1f} x; aim: {LIMIT:g} s and {GAIN:g} x)"
    )


def _work(hidden: tuple[int, ...]) -> float:
    """Return the time of a network in arbitrary units: parameters plus a constant per layer."""
    sizes = (12, *hidden, 1)
    return sum(a * b + 20_000 for a, b in pairwise(sizes))


if __name__ == "__main__":
    main()
