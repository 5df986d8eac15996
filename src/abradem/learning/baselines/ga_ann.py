"""Networks with an architecture found by genetic search (GA-ANN), under both protocols.

``as_published``
    70/30 split with seed 42. The paper's 12 features are standardised over all rows; the wear is
    not scaled during the search. The fitness is R2 on the **test rows**. The network found is then
    trained several more times, longer and on standardised wear, and the best result on the test
    rows is the score. This reproduces how a score like the printed one arises. The scores of the
    other trainings are stored as well.
``leakage_free``
    The training rows of a split are divided into fitting and validation rows. Features are chosen
    and scalers fitted on the fitting rows only; the fitness is R2 on the validation rows. The
    network found is trained again on all training rows, and this single network is scored on the
    test rows. Further trainings of the same architecture from other initial weights show how much
    of a score is chance.

    Networks are scored on the repeated splits of all models. Each split chooses its features, fits
    its scalers and trains its weights on its own training rows. The first ``searches`` splits
    also have a search of their own and are nested. On the others the architecture is the one found
    in the first split, whose rows for fitting and validation may be test rows there.

The paper's own network, 449-24-500-385, is trained in the same way without a search.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, of_kind
from abradem.learning.baselines import genetic
from abradem.learning.baselines.genetic import Memory, Options, Search, SearchProblem
from abradem.learning.baselines.selection import select
from abradem.learning.evaluation import Results
from abradem.learning.model_files import about
from abradem.learning.network import Layers, Training, one_thread
from abradem.learning.protocols import (
    AS_PUBLISHED,
    LEAKAGE_FREE,
    PUBLISHED_NETWORK_SHARE,
    VALIDATION,
    divide,
    published_split,
    repeated_splits,
)
from abradem.learning.published import NETWORK, SELECTED
from abradem.learning.rows import HUGE, Scaler, Table, standard_scaler
from abradem.learning.scores import scores_of
from abradem.quantities import FEATURE_NAMES, quantity

MODEL = "ga_ann"
PAPER_NET = "paper_net"
UNSCALED = Scaler(np.float64(0.0), np.float64(1.0))
"""Scaler that leaves values as they are."""


class Split(NamedTuple):
    """Rows, features and scalers of one search and of the final training.

    Attributes
    ----------
    fit, look : ndarray of int
        Rows for training and for the fitness in the search.
    train, test : ndarray of int
        Rows for the final training and for the score.
    columns : ndarray of int
        Features used.
    search_scalers, final_scalers : pair of Scaler
        Scalers of features and target in the search and in the final training.
    """

    fit: np.ndarray
    look: np.ndarray
    train: np.ndarray
    test: np.ndarray
    columns: np.ndarray
    search_scalers: tuple[Scaler, Scaler]
    final_scalers: tuple[Scaler, Scaler]


@dataclass(frozen=True)
class NetworkResult:
    """Result of `fit_networks`.

    Attributes
    ----------
    history : pandas.DataFrame
        One row per individual of every search, see `abradem.learning.baselines.genetic.Search`.
    results : Results
        Scores and predictions.
    model : tuple
        Description and arrays of the network.
    summary : dict
    """

    history: pd.DataFrame
    results: Results
    model: tuple
    summary: dict


def settings(options: Mapping) -> dict:
    """Arguments of `fit_networks` from the section ``ga_ann`` of the configuration."""
    options = dict(options)
    rate = options.pop("learning_rate")
    return {
        "training": Training(options.pop("epochs"), options.pop("batch"), rate),
        "final": Training(options.pop("final_epochs"), options.pop("final_batch"), rate),
        "options": Options(**{name: options.pop(name) for name in Options._fields}),
        **options,
    }


def leakage_free_split(
    table: Table,
    train: np.ndarray,
    test: np.ndarray,
    validation_share: float,
    count: int,
    seed: list[int],
    lasso_alpha: float = 0.1,
    ridge_alpha: float = 1.0,
) -> Split:
    """Divide training rows into fitting and validation rows; choose features and fit scalers.

    Parameters
    ----------
    table : Table
    train, test : ndarray of int
        Rows of the split.
    validation_share : float
        Share of the training rows used for validation.
    count : int
        Number of features chosen.
    seed : list of int
    lasso_alpha, ridge_alpha : float
        Penalties for the choice of features, see `abradem.learning.baselines.selection`.
    """
    x, y = table.features, table.target
    kept, checked = divide(table.groups[train], validation_share, np.random.default_rng(seed))
    fit, look = train[kept], train[checked]
    columns, _ = select(x[fit], y[fit], count, lasso_alpha, ridge_alpha, names=table.names)
    return Split(
        fit,
        look,
        train,
        test,
        columns,
        (standard_scaler(x[np.ix_(fit, columns)]), standard_scaler(y[fit])),
        (standard_scaler(x[np.ix_(train, columns)]), standard_scaler(y[train])),
    )


def published_network_split(table: Table) -> Split:
    """Rows, features and scalers of the published protocol."""
    train, test = published_split(len(table.target), PUBLISHED_NETWORK_SHARE)
    columns = np.array([FEATURE_NAMES.index(name) for name in SELECTED])
    # Nothing can be learned from those held fixed; if all are, from the others.
    varied = columns[np.isin(columns, table.varied)]
    columns = varied if len(varied) else table.varied
    of_x = standard_scaler(table.features[:, columns])
    return Split(
        train,
        test,
        train,
        test,
        columns,
        (of_x, UNSCALED),
        (of_x, standard_scaler(table.target)),
    )


@one_thread()
def fit_networks(
    table: Table,
    protocol: str,
    options: Options = Options(),  # noqa: B008  (immutable)
    training: Training = Training(),  # noqa: B008  (immutable)
    final: Training = Training(epochs=60, batch=50),  # noqa: B008  (immutable)
    features: int = 12,
    lasso_alpha: float = 0.1,
    ridge_alpha: float = 1.0,
    validation_share: float = 0.25,
    retrainings: int = 10,
    searches: int = 1,
    repeats: int = 20,
    test_share: float = 0.2,
    confidence: float = 0.95,
    seed: int = 0,
    cores: int = 1,
    device: str = "cpu",
    folder: str | Path | None = None,
    code: str = "",
    progress: Callable[[str], None] | None = None,
) -> NetworkResult:
    """Search for an architecture, train the network found, and score it.

    Parameters
    ----------
    table : Table
    protocol : {"as_published", "leakage_free"}
    options, training : Options, Training
        Settings of the search and of the training in it.
    final : Training
        Settings of the final training.
    features : int
        Number of features chosen (leakage-free).
    lasso_alpha, ridge_alpha : float
        Penalties for this choice, see `abradem.learning.baselines.selection`.
    validation_share : float
        Share of the training rows used for the fitness (leakage-free).
    retrainings : int
        Number of final trainings from different initial weights.
    searches : int
        Number of searches (leakage-free), each inside another of the repeated splits; of more
        than ``repeats`` so many are made.
    repeats, test_share, confidence, seed
        Of the repeated splits.
    cores : int
        Networks trained at the same time; the result does not depend on it.
    device : {"cpu", "cuda"}
    folder : path, optional
        Keeps the fitness values, from which an interrupted search resumes; removed at the end.
    code : str
        Hash of the code; fitness values of another version of the code are not used.
    progress : callable, optional
        Called with one line of text after each generation.

    Returns
    -------
    NetworkResult
    """
    results = Results(table)
    if protocol == AS_PUBLISHED:
        splits, searches = [published_network_split(table)], 1
    else:
        choice = validation_share, features
        penalties = lasso_alpha, ridge_alpha
        splits = [
            leakage_free_split(table, *rows, *choice, [seed, repeat, VALIDATION], *penalties)
            for repeat, rows in enumerate(
                repeated_splits(table.keys, table.groups, test_share, repeats, seed)
            )
        ]
        searches = min(searches, len(splits))
    histories, found, counted = [], [], []
    for repeat, split in enumerate(splits[:searches]):
        problem = _problem(table, split)
        ours = _seed(seed, repeat)
        memory = Memory(
            folder and Path(folder) / f"search-{repeat}",
            genetic.fingerprint(problem, options.weights, training, device, ours, code),
        )
        search = genetic.search(
            problem, options, training, ours, cores, device, memory,
            progress and _numbered(progress, repeat, searches),
        )  # fmt: skip
        histories.append(search.history.assign(protocol=protocol, repeat=repeat))
        found.append((split, search))
        again = final, cores, device
        seeds = _seeds(search.best.seed, retrainings if repeat == 0 else 1)
        looks = _looks(table, split, search.best.layers, seeds, *again)
        counted.append(_score(results, MODEL, protocol, repeat, split, looks, search))
        if repeat == 0:
            looks = _looks(table, split, NETWORK, _seeds(ours, retrainings), *again)
            _score(results, PAPER_NET, protocol, 0, split, looks, None)
    fixed = [
        *((MODEL, repeat, found[0][1].best.layers) for repeat in range(searches, len(splits))),
        *((PAPER_NET, repeat, NETWORK) for repeat in range(1, len(splits))),
    ]
    _score_fixed(results, splits, fixed, seed, final, cores, device)
    if folder:
        shutil.rmtree(folder, ignore_errors=True)
    split, search = found[0]
    network, scalers = counted[0]
    scores = {
        name: scores_of(results.scores, name, protocol, confidence) for name in (MODEL, PAPER_NET)
    }
    summary = {
        "model": MODEL,
        "protocol": protocol,
        "fitness": _FITNESS[protocol],
        "features": [table.names[column] for column in split.columns],
        "symbols": [quantity(table.names[column]).symbol for column in split.columns],
        "held_fixed": of_kind(table.names, table.variation, HELD_FIXED),
        "architecture": list(search.best.layers),
        "best_fitness": _stated(search.fitness),
        "lineage": _lineage(search),
        "generations": _generations(search),
        "networks_trained": search.trained,
        "rows": {
            "fit": len(split.fit),
            "fitness": len(split.look),
            "train": len(split.train),
            "test": len(split.test),
        },
        "splits": len(splits),
        "searches": [
            {"architecture": list(one.best.layers), "best_fitness": _stated(one.fitness)}
            for _, one in found
        ],
        "confidence": confidence,
        "scores": scores,
    }
    description = about(
        table, MODEL, protocol, "network", scalers, split.train, split.columns, **{
            name: summary[name]
            for name in ("architecture", "best_fitness", "lineage", "confidence")
        },
        scores=scores[MODEL],
    )  # fmt: skip
    return NetworkResult(
        history=pd.concat(histories, ignore_index=True),
        results=results,
        model=(description, network.arrays()),
        summary=summary,
    )


_FITNESS = {
    AS_PUBLISHED: "R2 on the test rows (as published)",
    LEAKAGE_FREE: "R2 on validation rows inside the training rows",
}


def _problem(table: Table, split: Split) -> SearchProblem:
    of_x, of_y = split.search_scalers
    return SearchProblem(
        *(
            part
            for rows in (split.fit, split.look)
            for part in (
                of_x.forward(table.features[np.ix_(rows, split.columns)]),
                of_y.forward(table.target[rows]),
            )
        )
    )


def _seeds(first: int, count: int) -> list[int]:
    """Seeds of the trainings of one network: its own seed first, then derived ones."""
    others = np.random.default_rng([first, 2]).integers(2**31, size=count)
    return [first, *(int(seed) for seed in others[: count - 1])]


def _looks(table: Table, split: Split, layers: Layers, seeds, training, cores, device) -> list:
    """Train the network on the training rows once for each seed; returns (network, scalers)."""
    of_x, of_y = split.final_scalers
    x = of_x.forward(table.features[np.ix_(split.train, split.columns)])
    y = of_y.forward(table.target[split.train])
    networks = genetic.train_again(layers, seeds, x, y, training, cores, device)
    return [(network, split.final_scalers) for network in networks]


def _score_fixed(
    results: Results,
    splits: list[Split],
    networks: list[tuple[str, int, Layers]],
    seed: int,
    *training,
) -> None:
    """Train and score networks of a given architecture, (model, number of the split, layers)."""
    table, lessons = results.table, []
    for _, repeat, _ in networks:
        split = splits[repeat]
        (of_x, of_y) = split.final_scalers
        x = of_x.forward(table.features[np.ix_(split.train, split.columns)])
        y = of_y.forward(table.target[split.train])
        lessons.append(genetic.Lesson(_seed(seed, repeat), x, y))
    layers = [one for *_, one in networks]
    for (model, repeat, _), network in zip(
        networks, genetic.train_each(layers, lessons, *training), strict=True
    ):
        split = splits[repeat]
        looks = [(network, split.final_scalers)]
        _score(results, model, LEAKAGE_FREE, repeat, split, looks, None)


def _predict(table: Table, split: Split, look, rows: np.ndarray) -> np.ndarray:
    network, (of_x, of_y) = look
    return of_y.back(network.predict(of_x.forward(table.features[np.ix_(rows, split.columns)])))


def _score(results: Results, model: str, protocol: str, repeat: int, split: Split, looks, search):
    """Score the network that counts and all retrainings; returns the network that counts."""
    table = results.table
    counted = looks[0]
    if protocol == AS_PUBLISHED:
        # As published, the best network on the test rows counts, that of the search included.
        candidates = looks + ([(search.network, split.search_scalers)] if search else [])
        actual = table.target[split.test]
        away = [_predict(table, split, look, split.test) - actual for look in candidates]
        # Squares of huge errors overflow; the unit does not change the order.
        unit = max(1.0, np.abs(away).max() / HUGE)
        errors = [np.mean((error / unit) ** 2) for error in away]
        counted = candidates[int(np.argmin(errors))]
    floor = float(table.target[split.train].min())
    for name, rows in (("train", split.train), ("test", split.test)):
        predicted = _predict(table, split, counted, rows)
        results.add(model, protocol, name, repeat, rows, predicted, floor, name == "test")
    if search is not None:
        results.add_metrics(model, protocol, "search", repeat, {"R2": _stated(search.fitness)})
    if len(looks) > 1:
        for number, look in enumerate(looks):
            predicted = _predict(table, split, look, split.test)
            results.add(model, protocol, "retrained", number, split.test, predicted, floor, False)
    return counted


def _stated(fitness: float) -> float:
    """A fitness as reported: nan if it is undefined, as for rows without spread."""
    return float(fitness) if fitness > genetic.FAILED else np.nan


def _lineage(search: Search) -> list[dict]:
    rows = search.history.set_index(["generation", "individual"])
    columns = ["layers", "weights_seed", "origin", "fitness"]
    return [
        {"generation": generation, "individual": individual}
        | rows.loc[(generation, individual), columns].to_dict()
        | {"fitness": _stated(rows.loc[(generation, individual), "fitness"])}
        for generation, individual in search.lineage
    ]


def _generations(search: Search) -> list[dict]:
    """Summary of the fitness and size of the networks in each generation."""
    return [
        {
            "generation": generation,
            "best_fitness": _stated(rows["fitness"].max()),
            "median_fitness": _stated(rows["fitness"].median()),
            "fewest_parameters": rows["parameters"].min(),
            "median_parameters": rows["parameters"].median(),
            "most_parameters": rows["parameters"].max(),
        }
        for generation, rows in search.history.groupby("generation")
    ]


def _numbered(progress: Callable[[str], None], repeat: int, count: int) -> Callable[[str], None]:
    if count == 1:
        return progress
    return lambda line: progress(f"search {repeat + 1} of {count}, {line}")


def _seed(seed: int, repeat: int) -> int:
    return int(np.random.SeedSequence([seed, repeat]).generate_state(1)[0])
