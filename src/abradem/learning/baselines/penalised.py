"""Lasso and ridge regression in standardised variables.

With n rows::

    lasso: min 1/(2n) |y - X w|^2 + alpha |w|_1       (sets weights to zero: selects features)
    ridge: min        |y - X w|^2 + alpha |w|_2^2     (shares a weight among similar features)

``as_published`` uses the penalties alpha of the paper, 0.1 and 1. ``leakage_free`` chooses alpha
by cross-validation inside the training rows, with the scalers fitted inside each fold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED
from abradem.learning.evaluation import (
    Fit,
    Results,
    evaluate_as_published,
    evaluate_leakage_free,
    scalers_of_all_rows,
    with_scalers,
)
from abradem.learning.model_files import about
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE, folds
from abradem.learning.rows import FEWEST_ROWS, Table, learning_table, standard_scaler
from abradem.learning.scores import mean_columns, r2, scores_of
from abradem.quantities import quantity

MODELS = ("lasso", "ridge")
ALPHAS = {"lasso": (1.0, 3e-3), "ridge": (1e4, 1e-2)}
"""Ends of the paths: all weights near or at zero, and almost least squares."""


class Penalty(NamedTuple):
    """A penalty chosen by cross-validation.

    ``scores`` (folds, k) are R2 on the validation rows for each of the ``alphas`` (k,).
    """

    alpha: float
    alphas: np.ndarray
    scores: np.ndarray


@dataclass(frozen=True)
class PenalisedResult:
    """Result of `fit_penalised`.

    Attributes
    ----------
    weights : pandas.DataFrame
        model, protocol, symbol, feature, weight (mean over the fits of the protocol), survives
        (share of these fits with a weight other than zero), variation. Features that were held
        fixed have neither; those that are not identified share a weight with others.
    paths : pandas.DataFrame
        model, protocol, alpha, symbol, feature, weight; fitted to all rows. Without the features
        that were held fixed.
    validation : pandas.DataFrame
        model, protocol, alpha, mean and stderr_of_mean of R2 over the folds of a cross-validation
        of all rows, chosen.
    results : Results
    models : dict
        Description and arrays of both models by name.
    summary : dict
    """

    weights: pd.DataFrame
    paths: pd.DataFrame
    validation: pd.DataFrame
    results: Results
    models: dict
    summary: dict


def weights(model: str, x: np.ndarray, y: np.ndarray, alphas: np.ndarray) -> np.ndarray:
    """Weights for each penalty, in standardised variables.

    Parameters
    ----------
    model : {"lasso", "ridge"}
    x : ndarray, shape (n, p)
    y : ndarray, shape (n,)
    alphas : ndarray, shape (k,)
        Descending, as each solution of the lasso starts from the previous one.

    Returns
    -------
    ndarray, shape (k, p)
    """
    centred = x - x.mean(axis=0)
    target = y - y.mean()
    if model == "ridge":
        u, singular, vt = np.linalg.svd(centred, full_matrices=False)
        shrunk = singular / (singular**2 + np.asarray(alphas)[:, None])
        return (shrunk * (u.T @ target)) @ vt
    from sklearn.linear_model import lasso_path

    # Nearly dependent features slow the convergence of the last digits, which are not needed.
    _, found, _ = lasso_path(
        centred, target, alphas=np.asarray(alphas, dtype=float), max_iter=100_000, tol=1e-4
    )
    return found.T


def penalised(model: str, alpha: float, found: list) -> Fit:
    """Model with a given penalty in standardised variables; appends its weights to ``found``."""

    def fit(x: np.ndarray, y: np.ndarray, _: np.ndarray):
        (slopes,) = weights(model, x, y, np.array([alpha]))
        found.append(slopes)
        centre, middle = x.mean(axis=0), y.mean()
        return lambda rows: middle + (rows - centre) @ slopes

    return fit


def choose_alpha(
    model: str,
    x: np.ndarray,
    y: np.ndarray,
    groups: np.ndarray,
    points: int,
    fold_count: int,
    seed: int,
) -> Penalty:
    """Choose the penalty with the best mean R2 over the folds of a cross-validation.

    Parameters
    ----------
    model : {"lasso", "ridge"}
    x : ndarray, shape (n, p)
        Raw features.
    y : ndarray, shape (n,)
        Raw target.
    groups : ndarray of int, shape (n,)
        Groups of rows that no fold divides.
    points : int
        Number of penalties tried.
    fold_count : int
    seed : int
    """
    alphas = np.geomspace(*ALPHAS[model], points)
    scores = []
    for train, check in folds(groups, fold_count, seed):
        of_x, of_y = standard_scaler(x[train]), standard_scaler(y[train])
        found = weights(model, of_x.forward(x[train]), of_y.forward(y[train]), alphas)
        predicted = of_y.back(of_x.forward(x[check]) @ found.T)
        scores.append([r2(y[check], column) for column in predicted.T])
    # R2 is nan for a fold with a constant target; if all are nan, the largest penalty is chosen.
    means = np.nan_to_num(mean_columns(np.array(scores)), nan=-np.inf)
    return Penalty(float(alphas[int(np.argmax(means))]), alphas, np.array(scores))


def fit_penalised(
    table: Table,
    lasso_alpha: float = 0.1,
    ridge_alpha: float = 1.0,
    path_points: int = 40,
    fold_count: int = 5,
    test_share: float = 0.2,
    repeats: int = 20,
    confidence: float = 0.95,
    seed: int = 0,
) -> PenalisedResult:
    """Fit lasso and ridge under both protocols.

    Parameters
    ----------
    table : Table
    lasso_alpha, ridge_alpha : float
        Penalties as published.
    path_points : int
        Number of penalties on each path.
    fold_count : int
        Folds of the cross-validations.
    test_share, repeats, confidence, seed
        Of the leakage-free splits.

    Returns
    -------
    PenalisedResult
    """
    published = {"lasso": lasso_alpha, "ridge": ridge_alpha}
    x, y = table.features, table.target
    of_all = scalers_of_all_rows(table)
    z, v = of_all[0].forward(x), of_all[1].forward(y)
    results = Results(table)
    rows, paths, validation, models, summary = [], [], [], {}, {}

    for model in MODELS:
        as_published: list[np.ndarray] = []
        leakage_free: list[np.ndarray] = []
        chosen: list[float] = []
        fit = penalised(model, published[model], as_published)
        evaluate_as_published(results, model, with_scalers(fit, of_all))

        def fit_leakage_free(
            features, target, groups, model=model, chosen=chosen, leakage_free=leakage_free
        ):
            penalty = choose_alpha(model, features, target, groups, path_points, fold_count, seed)
            chosen.append(penalty.alpha)
            return with_scalers(penalised(model, penalty.alpha, leakage_free))(
                features, target, groups
            )

        evaluate_leakage_free(results, model, fit_leakage_free, test_share, repeats, seed)
        rows += _weight_rows(model, AS_PUBLISHED, np.array(as_published), table)
        rows += _weight_rows(model, LEAKAGE_FREE, np.array(leakage_free), table)

        penalty = choose_alpha(model, x, y, table.groups, path_points, fold_count, seed)
        path = weights(model, z, v, penalty.alphas)
        paths.append(_path_rows(model, penalty.alphas, path, table))
        validation.append(_validation_rows(model, penalty))
        (final,) = weights(model, z, v, np.array([penalty.alpha]))
        summary[model] = {
            "alpha": {AS_PUBLISHED: published[model], LEAKAGE_FREE: penalty.alpha},
            "alphas_of_the_splits": chosen,
            "survivors": {
                AS_PUBLISHED: _names(table, as_published[0]),
                LEAKAGE_FREE: _names(table, final),
            },
        }
        models[model] = (
            about(
                table,
                model,
                LEAKAGE_FREE,
                "linear",
                of_all,
                alpha=penalty.alpha,
                confidence=confidence,
                scores=scores_of(results.scores, model, LEAKAGE_FREE, confidence),
            ),
            {"coefficients": final},
        )
    return PenalisedResult(
        weights=pd.DataFrame(rows),
        paths=pd.concat(paths, ignore_index=True),
        validation=pd.concat(validation, ignore_index=True),
        results=results,
        models=models,
        summary=summary,
    )


def _names(table: Table, found: np.ndarray) -> list[str]:
    return [name for name, weight in zip(table.names, found, strict=True) if weight != 0.0]


def _weight_rows(model: str, protocol: str, found: np.ndarray, table: Table) -> list[dict]:
    return [
        {
            "model": model,
            "protocol": protocol,
            "symbol": quantity(name).symbol,
            "feature": name,
            "weight": np.nan if says == HELD_FIXED else float(column.mean()),
            "survives": np.nan if says == HELD_FIXED else float(np.mean(column != 0.0)),
            "variation": says,
        }
        for name, column, says in zip(table.names, found.T, table.variation, strict=True)
    ]


def _path_rows(model: str, alphas: np.ndarray, path: np.ndarray, table: Table) -> pd.DataFrame:
    names = [table.names[column] for column in table.varied]
    return pd.DataFrame(
        {
            "model": model,
            "protocol": LEAKAGE_FREE,
            "alpha": np.repeat(alphas, len(names)),
            "symbol": [quantity(name).symbol for name in names] * len(alphas),
            "feature": names * len(alphas),
            "weight": path[:, table.varied].ravel(),
        }
    )


def _validation_rows(model: str, penalty: Penalty) -> pd.DataFrame:
    count = np.isfinite(penalty.scores).sum(axis=0)
    mean = mean_columns(penalty.scores)
    away = np.where(np.isfinite(penalty.scores), penalty.scores - mean, 0.0)
    # The standard error of a single fold is not determined.
    spread = np.sqrt(np.sum(away**2, axis=0) / np.where(count > 1, count - 1, np.nan))
    return pd.DataFrame(
        {
            "model": model,
            "protocol": LEAKAGE_FREE,
            "alpha": penalty.alphas,
            "mean": mean,
            "stderr_of_mean": spread / np.sqrt(np.maximum(count, 1)),
            "chosen": penalty.alphas == penalty.alpha,
        }
    )


def train(dataset: pd.DataFrame, target: str, name: str, **options) -> dict:
    """Outputs of the workflow rule by name; ``options`` are arguments of `fit_penalised`."""
    found = fit_penalised(learning_table(dataset, target, name, FEWEST_ROWS), **options)
    return {
        "weights": found.weights,
        "paths": found.paths,
        "validation": found.validation,
        "scores": found.results.scores,
        "predictions": found.results.predictions,
        "summary": found.summary,
        **found.models,
    }
