"""Genetic search for the architecture of a network.

A chromosome is the list of hidden layers (their number and their neurons) and the seed of the
initial weights, or the trained weights of a parent instead. Its fitness is R2 on rows that the
caller chooses: validation rows or, as published, the test rows.

The best individuals survive to the next generation (elitism). The other places are filled with
children of pairs of parents. Parents are chosen by roulette (probability proportional to the
fitness above the worst; R2 below -1 counts as -1, as a single very bad network would otherwise
make all others equally likely) or by tournament (best of a few drawn at random). Children come
from two-point crossover between lists of different lengths and from mutation of the number of
neurons in one layer. All random choices of a generation come from a random number generator
seeded with (seed, generation), so a search can be replayed: an interrupted search reads the
fitness values found so far from a file, and resumes by repeating its choices without training.

The networks of a generation are trained one per core, in one thread each, the largest first. A
network that was trained before is not trained again. All networks are trained to the end: early
stopping of weak ones would make a score depend on the other networks and on the order of training.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import multiprocessing
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.learning.network import (
    Layers,
    Network,
    Training,
    network_of,
    one_thread,
    parameters_of,
    start,
    train,
)
from abradem.learning.scores import r2
from abradem.store.checksums import sha256_of
from abradem.store.files import read_arrays, write_arrays, write_text
from abradem.store.workers import end_with_parent

SELECTIONS = ("tournament", "roulette")
FAILED = -1e9
"""Fitness of a network whose training diverged."""
WEIGHTS = ("seed", "inherited")


class Options(NamedTuple):
    """Options of the search; the defaults are those of the paper where it gives them."""

    population: int = 10
    generations: int = 25
    min_layers: int = 2
    max_layers: int = 6
    min_neurons: int = 10
    max_neurons: int = 500
    selection: str = "tournament"
    tournament_size: int = 3
    crossover: float = 0.9
    mutation: float = 0.2
    mutation_size: float = 0.2
    elites: int = 1
    weights: str = "seed"


class SearchProblem(NamedTuple):
    """Scaled training rows and scaled rows for the fitness.

    Attributes
    ----------
    x, fitness_x : ndarray, shape (n, p)
        Features.
    y, fitness_y : ndarray, shape (n,)
        Target.
    """

    x: np.ndarray
    y: np.ndarray
    fitness_x: np.ndarray
    fitness_y: np.ndarray


class Chromosome(NamedTuple):
    """Hidden layers, seed of the initial weights, key of the parent that passes on its weights."""

    layers: Layers
    seed: int
    heritage: str = ""

    @property
    def key(self) -> str:
        """Hash of this chromosome; equal chromosomes have equal fitness."""
        text = json.dumps([list(self.layers), self.seed, self.heritage])
        return hashlib.sha256(text.encode()).hexdigest()[:24]


class Individual(NamedTuple):
    """A chromosome with the numbers of its parents in the previous generation (-1: none)."""

    chromosome: Chromosome
    parents: tuple[int, int] = (-1, -1)
    origin: str = "random"


class Search(NamedTuple):
    """Result of a search.

    Attributes
    ----------
    best : Chromosome
    fitness : float
        Fitness of the best chromosome.
    network : Network
        The best network as trained in the search.
    history : pandas.DataFrame
        One row per individual: generation, individual, layers, parameters, weights_seed,
        parent_a, parent_b, origin, fitness.
    lineage : list of tuple of int
        Generation and number of the best individual, then those of its first parents back to the
        first generation.
    trained : int
        Number of different networks.
    """

    best: Chromosome
    fitness: float
    network: Network
    history: pd.DataFrame
    lineage: list[tuple[int, int]]
    trained: int


class Memory:
    """Fitness values found so far, stored in a folder from which a search can resume.

    Parameters
    ----------
    folder : path, optional
        Without a folder nothing is stored on disk.
    fingerprint : str
        Hash of everything that a fitness depends on; values with another hash are discarded.
    """

    def __init__(self, folder: str | Path | None = None, fingerprint: str = ""):
        self.fitness: dict[str, float] = {}
        self._networks: dict[str, Network] = {}
        self.folder = None if folder is None else Path(folder)
        if self.folder is None:
            return
        self._file = self.folder / "fitness.jsonl"
        self.fitness = self._read(fingerprint)
        if not self.fitness:
            shutil.rmtree(self.folder, ignore_errors=True)
        # Rewritten, as the last line may be incomplete.
        head = json.dumps({"fingerprint": fingerprint}) + "\n"
        write_text(head + "".join(map(self._line, self.fitness)), self._file)

    def _read(self, fingerprint: str) -> dict[str, float]:
        """Fitness values of an interrupted search with the same fingerprint."""
        found: dict[str, float] = {}
        with contextlib.suppress(FileNotFoundError, ValueError, TypeError, KeyError):
            with open(self._file, encoding="utf-8", errors="replace") as file:
                if json.loads(file.readline())["fingerprint"] == fingerprint:
                    for line in file:
                        # What is damaged is trained again.
                        with contextlib.suppress(OSError, ValueError, TypeError, RecursionError):
                            *entry, seal = json.loads(line)
                            key, value, network = entry
                            whole = network == "" or network == self._sha256(key)
                            if whole and seal == _seal(entry):
                                found[key] = value
        return found

    def _sha256(self, key: str) -> str:
        """Checksum of the stored network of a key."""
        return sha256_of(self._network_file(key))

    def _network_file(self, key: str) -> Path:
        return Path(self.folder or "", f"{key}.safetensors")

    def add(self, key: str, fitness: float, network: Network | None) -> None:
        """Store a fitness and, if children may inherit them, the weights."""
        if network is not None:
            self._networks[key] = network
            if self.folder is not None:
                write_arrays(network.arrays(), self._network_file(key))
        self.fitness[key] = fitness
        if self.folder is not None:
            with open(self._file, "a", encoding="utf-8") as file:
                file.write(self._line(key))

    def network(self, key: str) -> Network | None:
        """Stored network of a key; None for the empty key."""
        if not key:
            return None
        if key not in self._networks and self.folder is not None:
            self._networks[key] = network_of(read_arrays(self._network_file(key)))
        return self._networks[key]

    def _line(self, key: str) -> str:
        """Line of a key: fitness, checksum of the stored network ("": none), and a seal."""
        stored = self._network_file(key).is_file()
        entry = [key, self.fitness[key], self._sha256(key) if stored else ""]
        return json.dumps([*entry, _seal(entry)]) + "\n"


def _seal(entry: list) -> str:
    """Checksum of the other entries of a line."""
    return hashlib.sha256(json.dumps(entry).encode()).hexdigest()[:16]


def search(
    problem: SearchProblem,
    options: Options = Options(),  # noqa: B008  (immutable)
    training: Training = Training(),  # noqa: B008  (immutable)
    seed: int = 0,
    cores: int = 1,
    device: str = "cpu",
    memory: Memory | None = None,
    progress: Callable[[str], None] | None = None,
) -> Search:
    """Search for the chromosome with the best fitness.

    Parameters
    ----------
    problem : SearchProblem
    options : Options
    training : Training
    seed : int
    cores : int
        Networks trained at the same time; the result does not depend on it.
    device : {"cpu", "cuda"}
        On a GPU, networks of equal depth are trained as one batch.
    memory : Memory, optional
        Fitness values of an interrupted search.
    progress : callable, optional
        Called with one line of text after each generation.

    Returns
    -------
    Search
    """
    check_options(options)
    memory = memory or Memory()
    began = time.monotonic()
    rows: list[dict] = []
    generations: list[list[Individual]] = []
    best_fitness, place = -np.inf, (0, 0)
    with _trainer(problem, training, min(cores, options.population), device) as trainer:
        population = _first(options, _generator(seed, 0))
        for generation in range(options.generations):
            _evaluate(population, problem, options, memory, trainer)
            fitness = np.array([memory.fitness[one.chromosome.key] for one in population])
            rows += _rows(generation, population, fitness, problem.x.shape[1])
            generations.append(population)
            top = int(np.argmax(fitness))
            if fitness[top] > best_fitness:
                best_fitness, place = float(fitness[top]), (generation, top)
            best = generations[place[0]][place[1]].chromosome
            if generation == 0:
                began = time.monotonic()
            if progress:
                progress(_line(generation, options.generations, best_fitness, best, began))
            if generation + 1 < options.generations:
                rng = _generator(seed, generation + 1)
                population = _next(population, fitness, options, rng)
        heritage = memory.network(best.heritage)
        (network,) = trainer.networks([best], [heritage])
    return Search(
        best,
        best_fitness,
        network,
        pd.DataFrame(rows),
        _lineage(generations, place),
        len({one.chromosome.key for population in generations for one in population}),
    )


def train_again(
    layers: Layers,
    seeds: Sequence[int],
    x: np.ndarray,
    y: np.ndarray,
    training: Training,
    cores: int = 1,
    device: str = "cpu",
) -> list[Network]:
    """Train one architecture from several initial weights, in the same way as `search`.

    Parameters
    ----------
    layers : tuple of int
    seeds : sequence of int
    x : ndarray, shape (n, f)
    y : ndarray, shape (n,)
    training, cores, device
        As for `search`.

    Returns
    -------
    list of Network
        In the order of the seeds.
    """
    chromosomes = [Chromosome(tuple(layers), seed) for seed in seeds]
    with _trainer(SearchProblem(x, y, x, y), training, min(cores, len(seeds)), device) as trainer:
        nothing = [None] * len(chromosomes)
        return [network for _, network in trainer.fitnesses(chromosomes, nothing, True)]


class Lesson(NamedTuple):
    """Seed and rows of one training, see `train_each`: features (n, f) and target (n,)."""

    seed: int
    x: np.ndarray
    y: np.ndarray


def train_each(
    layers: Sequence[Layers],
    lessons: Sequence[Lesson],
    training: Training,
    cores: int = 1,
    device: str = "cpu",
) -> list[Network]:
    """Train networks on rows of their own, such as those of different splits.

    Parameters
    ----------
    layers : sequence of tuple of int
        Architecture of each network.
    lessons : sequence of Lesson
        Seed and rows of each network.
    training, cores, device
        As for `search`.

    Returns
    -------
    list of Network
        In the order of the lessons.
    """
    if not lessons:
        return []
    jobs = [
        (Chromosome(tuple(one), lesson.seed), lesson, training, device)
        for one, lesson in zip(layers, lessons, strict=True)
    ]
    first = SearchProblem(lessons[0].x, lessons[0].y, lessons[0].x, lessons[0].y)
    with _trainer(first, training, min(cores, len(jobs)), device) as trainer:
        each = trainer.pool.map if isinstance(trainer, _Pool) else map
        return list(each(_train_lesson, jobs))


def check_options(options: Options) -> None:
    """Raise ValueError, naming the option, if an option is invalid."""
    for name, known in (("selection", SELECTIONS), ("weights", WEIGHTS)):
        value = getattr(options, name)
        if value not in known:
            raise ValueError(f"{name} = {value!r} is unknown; allowed: {', '.join(known)}")
    for low, high in (("min_layers", "max_layers"), ("min_neurons", "max_neurons")):
        if not 1 <= getattr(options, low) <= getattr(options, high):
            raise ValueError(f"{low} = {getattr(options, low)} must lie between 1 and {high}")
    if not 0 <= options.elites < options.population:
        raise ValueError(f"elites = {options.elites} must be fewer than the population")


_TRIES = 100


def crossover(
    first: Layers, second: Layers, options: Options, rng: np.random.Generator
) -> tuple[Layers, Layers]:
    """Two-point crossover: exchange the layers between two cuts of each parent.

    The two segments may differ in length, so the depth is inherited too. Cuts that would make a
    child too shallow or too deep are drawn again; after many such draws the parents are returned.
    """
    for _ in range(_TRIES):
        a, b = np.sort(rng.integers(0, len(first) + 1, 2))
        c, d = np.sort(rng.integers(0, len(second) + 1, 2))
        children = (first[:a] + second[c:d] + first[b:], second[:c] + first[a:b] + second[d:])
        if all(options.min_layers <= len(child) <= options.max_layers for child in children):
            return children
    return first, second


def mutate(layers: Layers, options: Options, rng: np.random.Generator) -> Layers:
    """Change the neurons of one layer by a random factor up to ``mutation_size``, within limits.

    The number of layers stays. The caller also draws a new seed of the weights.
    """
    place = int(rng.integers(len(layers)))
    factor = 1.0 + rng.uniform(-options.mutation_size, options.mutation_size)
    neurons = int(np.clip(round(layers[place] * factor), options.min_neurons, options.max_neurons))
    return (*layers[:place], neurons, *layers[place + 1 :])


def pick(fitness: np.ndarray, options: Options, rng: np.random.Generator) -> int:
    """Choose the number of a parent by tournament or roulette."""
    if options.selection == "tournament":
        size = min(options.tournament_size, len(fitness))
        drawn = rng.choice(len(fitness), size, replace=False)
        return int(drawn[np.argmax(fitness[drawn])])
    above = np.maximum(fitness, -1.0)
    above -= above.min()
    if above.sum() <= 0.0:
        return int(rng.integers(len(fitness)))
    return int(rng.choice(len(fitness), p=above / above.sum()))


def _first(options: Options, rng: np.random.Generator) -> list[Individual]:
    return [
        Individual(
            Chromosome(
                tuple(
                    int(neurons)
                    for neurons in rng.integers(
                        options.min_neurons,
                        options.max_neurons + 1,
                        rng.integers(options.min_layers, options.max_layers + 1),
                    )
                ),
                _draw_seed(rng),
            )
        )
        for _ in range(options.population)
    ]


def _next(
    population: list[Individual], fitness: np.ndarray, options: Options, rng: np.random.Generator
) -> list[Individual]:
    order = np.argsort(-fitness, kind="stable")
    children = [
        Individual(population[i].chromosome, (int(i), -1), "elite") for i in order[: options.elites]
    ]
    while len(children) < options.population:
        a, b = (pick(fitness, options, rng) for _ in range(2))
        parents = [population[i].chromosome for i in (a, b)]
        layers = [parent.layers for parent in parents]
        crossed = rng.random() < options.crossover
        if crossed:
            layers = list(crossover(layers[0], layers[1], options, rng))
        for parent, of_child, own, other in zip(parents, layers, (a, b), (b, a), strict=True):
            origin = ["crossover"] if crossed else []
            seed, heritage = parent.seed, parent.heritage
            if rng.random() < options.mutation:
                of_child = mutate(of_child, options, rng)
                seed = _draw_seed(rng)
                origin.append("mutation")
            if options.weights == "inherited":
                heritage = parent.key
            child = Chromosome(of_child, seed, heritage)
            children.append(
                Individual(child, (own, other if crossed else -1), "+".join(origin) or "copy")
            )
    return children[: options.population]


def _evaluate(
    population: list[Individual],
    problem: SearchProblem,
    options: Options,
    memory: Memory,
    trainer: _Trainer,
) -> None:
    """Train the networks that were not trained before."""
    inherit = options.weights == "inherited"
    new = {
        one.chromosome.key: one.chromosome
        for one in population
        if one.chromosome.key not in memory.fitness
    }
    # Largest networks first, so that the cores finish at about the same time.
    chromosomes = sorted(
        new.values(), key=lambda c: (-parameters_of(problem.x.shape[1], c.layers), c.key)
    )
    heritages = [memory.network(chromosome.heritage) for chromosome in chromosomes]
    for chromosome, (fitness, network) in zip(
        chromosomes, trainer.fitnesses(chromosomes, heritages, inherit), strict=True
    ):
        memory.add(chromosome.key, fitness, network)


class _Trainer:
    """Trains networks in this process."""

    def __init__(self, problem: SearchProblem, training: Training, device: str):
        self.problem, self.training, self.device = problem, training, device

    def networks(self, chromosomes, heritages) -> list[Network]:
        """Train networks; on a GPU those of equal depth as one batch."""
        inputs = self.problem.x.shape[1]
        starts = [
            start(inputs, one.layers, one.seed, heritage)
            for one, heritage in zip(chromosomes, heritages, strict=True)
        ]
        groups: dict = {}
        for i, one in enumerate(chromosomes):
            groups.setdefault(len(one.layers) if self.device == "cuda" else i, []).append(i)
        found: list = [None] * len(chromosomes)
        for group in groups.values():
            trained = train(
                [starts[i] for i in group],
                [chromosomes[i].seed for i in group],
                self.problem.x,
                self.problem.y,
                self.training,
                self.device,
            )
            for i, network in zip(group, trained, strict=True):
                found[i] = network
        return found

    def fitness(self, network: Network) -> float:
        value = r2(self.problem.fitness_y, network.predict(self.problem.fitness_x))
        return float(value) if np.isfinite(value) else FAILED

    def fitnesses(self, chromosomes, heritages, weights: bool) -> Iterator:
        if self.device == "cuda":
            for network in self.networks(chromosomes, heritages):
                yield self.fitness(network), network if weights else None
            return
        for one, heritage in zip(chromosomes, heritages, strict=True):
            (network,) = self.networks([one], [heritage])
            yield self.fitness(network), network if weights else None


class _Pool(_Trainer):
    """Trains networks one per core, in forked processes that share the rows."""

    def __init__(self, problem: SearchProblem, training: Training, pool: ProcessPoolExecutor):
        super().__init__(problem, training, "cpu")
        self.pool = pool

    def fitnesses(self, chromosomes, heritages, weights: bool) -> Iterator:
        jobs = [(*pair, weights) for pair in zip(chromosomes, heritages, strict=True)]
        return self.pool.map(_train_one, jobs)


_HERE: dict[str, _Trainer] = {}


def _begin(trainer: _Trainer) -> None:
    end_with_parent()
    _HERE["trainer"] = trainer


def _train_one(job):
    chromosome, heritage, weights = job
    return next(_HERE["trainer"].fitnesses([chromosome], [heritage], weights))


def _train_lesson(job) -> Network:
    chromosome, (_, x, y), training, device = job
    trainer = _Trainer(SearchProblem(x, y, x, y), training, device)
    (network,) = trainer.networks([chromosome], [None])
    return network


@contextlib.contextmanager
def _trainer(
    problem: SearchProblem, training: Training, cores: int, device: str
) -> Iterator[_Trainer]:
    import torch

    if device == "cuda" and not torch.cuda.is_available():
        raise ValueError("device: cuda: torch finds no graphics card; use cpu")
    here = _Trainer(problem, training, device)
    with one_thread():
        # Forked processes share the rows and start quickly; without fork there is one process.
        if device == "cpu" and cores > 1 and "fork" in multiprocessing.get_all_start_methods():
            context = multiprocessing.get_context("fork")
            with ProcessPoolExecutor(cores, context, _begin, (here,)) as pool:
                yield _Pool(problem, training, pool)
        else:
            yield here


def _rows(generation, population, fitness, inputs) -> list[dict]:
    rows = []
    for i, one in enumerate(population):
        layers = one.chromosome.layers
        rows.append(
            {
                "generation": generation,
                "individual": i,
                "layers": "-".join(map(str, layers)),
                "parameters": parameters_of(inputs, layers),
                "weights_seed": one.chromosome.seed,
                "parent_a": one.parents[0],
                "parent_b": one.parents[1],
                "origin": one.origin,
                "fitness": fitness[i],
            }
        )
    return rows


def _lineage(generations: list[list[Individual]], place: tuple[int, int]) -> list[tuple[int, int]]:
    found = [place]
    while place[0] > 0:
        place = (place[0] - 1, generations[place[0]][place[1]].parents[0])
        found.append(place)
    return found


def _line(generation, generations, fitness, best, began) -> str:
    """Line of progress; the time left excludes the first generation, which loads libraries."""
    done = generation + 1
    line = f"generation {done} of {generations}, best R2 {fitness:.3f} "
    line += f"({'-'.join(map(str, best.layers))})"
    if 1 < done < generations:
        left = (time.monotonic() - began) / (done - 1) * (generations - done)
        line += f", about {left:.0f} s left"
    return line


def _generator(seed: int, generation: int) -> np.random.Generator:
    return np.random.default_rng([seed, generation])


def _draw_seed(rng: np.random.Generator) -> int:
    return int(rng.integers(2**31))


def fingerprint(problem: SearchProblem, *settings) -> str:
    """Hash of the rows and of all settings on which a fitness depends."""
    digest = hashlib.sha256(repr(settings).encode())
    for array in problem:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def terminal_progress(words: str, interval: float = 5.0) -> Callable[[str], None]:
    """Progress function that writes every line to the log, and some to the terminal.

    Standard error of a job is redirected to its log; the original stream is the terminal.

    Parameters
    ----------
    words : str
        Text before each line.
    interval : float
        Smallest time between lines on the terminal, s.
    """
    last = [-np.inf]

    def say(line: str) -> None:
        print(f"{words}: {line}", file=sys.stderr, flush=True)
        if sys.stderr is not sys.__stderr__ and time.monotonic() - last[0] > interval:
            last[0] = time.monotonic()
            print(f"{words}: {line}", file=sys.__stderr__, flush=True)

    return say


def usable_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
