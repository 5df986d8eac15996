"""Lasso and ridge: least squares with a penalty on the weights, in standardised variables.

With n rows::

    lasso: min 1/(2n) |y - X w|^2 + alpha |w|_1       (sets weights to zero, hence selects)
    ridge: min        |y - X w|^2 + alpha |w|_2^2     (shares a weight among like features)

``as_published`` takes the study's alphas, 0.1 and 1. ``leakage_free`` chooses alpha by
cross-validation inside the training rows, the scaler inside each fold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

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
from abradem.learning.scores import r2, scores_of
from abradem.quantities import FEATURE_NAMES, quantity

MODELS = ("lasso", "ridge")
ALPHAS = {"lasso": (1.0, 3e-3), "ridge": (1e4, 1e-2)}
"""Ends of the paths: everything shrunk away, and all but least squares."""


class Penalty(NamedTuple):
    """A penalty chosen by cross-validation.

    ``scores`` (folds, k) are R2 on the validation rows for each of the ``alphas`` (k,).
    """

    alpha: float
    alphas: np.ndarray
    scores: np.ndarray


@dataclass(frozen=True)
class PenalisedResult:
    """What `fit_penalised` gives.

    Attributes
    ----------
    weights : pandas.DataFrame
        model, protocol, symbol, feature, weight, survives: the share of the fits of a protocol
        in which the weight is not zero.
    paths : pandas.DataFrame
        model, protocol, alpha, symbol, feature, weight on all rows.
    validation : pandas.DataFrame
        model, protocol, alpha, mean and standard error of R2 over the folds of a
        cross-validation of all rows.
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
    """Weights for each penalty, shape (k, p), of standardised rows ``x`` and ``y``.

    ``alphas`` descend, as each solution of the lasso starts from the one before.
    """
    centred = x - x.mean(axis=0)
    target = y - y.mean()
    if model == "ridge":
        u, singular, vt = np.linalg.svd(centred, full_matrices=False)
        shrunk = singular / (singular**2 + np.asarray(alphas)[:, None])
        return (shrunk * (u.T @ target)) @ vt
    from sklearn.linear_model import lasso_path

    # Nearly dependent features make the last digits slow; they do not matter here.
    _, found, _ = lasso_path(
        centred, target, alphas=np.asarray(alphas, dtype=float), max_iter=100_000, tol=1e-4
    )
    return found.T


def penalised(model: str, alpha: float, found: list) -> Fit:
    """A model of given penalty, in standardised variables; its weights are added to ``found``."""

    def fit(x: np.ndarray, y: np.ndarray):
        (slopes,) = weights(model, x, y, np.array([alpha]))
        found.append(slopes)
        centre, middle = x.mean(axis=0), y.mean()
        return lambda rows: middle + (rows - centre) @ slopes

    return fit


def choose_alpha(
    model: str, x: np.ndarray, y: np.ndarray, points: int, fold_count: int, seed: int
) -> Penalty:
    """The penalty with the best mean R2 over the folds of ``x`` and ``y`` (raw)."""
    alphas = np.geomspace(*ALPHAS[model], points)
    scores = []
    for train, check in folds(len(y), fold_count, seed):
        of_x, of_y = standard_scaler(x[train]), standard_scaler(y[train])
        found = weights(model, of_x.forward(x[train]), of_y.forward(y[train]), alphas)
        predicted = of_y.back(of_x.forward(x[check]) @ found.T)
        scores.append([r2(y[check], column) for column in predicted.T])
    # A fold of equal targets has no R2; the largest penalty wins where none has one.
    means = np.nan_to_num(np.nanmean(np.array(scores), axis=0), nan=-np.inf)
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
        Penalties on each path.
    fold_count : int
        Folds of the cross-validations.
    test_share, repeats, confidence, seed
        Of the leakage-free splits.
    """
    published = {"lasso": lasso_alpha, "ridge": ridge_alpha}
    x, y = table.features, table.target
    of_all = scalers_of_all_rows(table)
    z, v = of_all[0].forward(x), of_all[1].forward(y)
    results = Results(table)
    rows, paths, validation, models, summary = [], [], [], {}, {}

    for model in MODELS:
        as_published, leakage_free, chosen = [], [], []
        fit = penalised(model, published[model], as_published)
        evaluate_as_published(results, model, with_scalers(fit, of_all))

        def fit_leakage_free(
            features, target, model=model, chosen=chosen, leakage_free=leakage_free
        ):
            penalty = choose_alpha(model, features, target, path_points, fold_count, seed)
            chosen.append(penalty.alpha)
            return with_scalers(penalised(model, penalty.alpha, leakage_free))(features, target)

        evaluate_leakage_free(results, model, fit_leakage_free, test_share, repeats, seed)
        rows += _weight_rows(model, AS_PUBLISHED, np.array(as_published))
        rows += _weight_rows(model, LEAKAGE_FREE, np.array(leakage_free))

        penalty = choose_alpha(model, x, y, path_points, fold_count, seed)
        path = weights(model, z, v, penalty.alphas)
        paths.append(_path_rows(model, penalty.alphas, path))
        validation.append(_validation_rows(model, penalty))
        (final,) = weights(model, z, v, np.array([penalty.alpha]))
        summary[model] = {
            "alpha": {AS_PUBLISHED: published[model], LEAKAGE_FREE: penalty.alpha},
            "alphas_of_the_splits": chosen,
            "survivors": {
                AS_PUBLISHED: _names(as_published[0]),
                LEAKAGE_FREE: _names(final),
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


def _names(found: np.ndarray) -> list[str]:
    return [name for name, weight in zip(FEATURE_NAMES, found, strict=True) if weight != 0.0]


def _weight_rows(model: str, protocol: str, found: np.ndarray) -> list[dict]:
    return [
        {
            "model": model,
            "protocol": protocol,
            "symbol": quantity(name).symbol,
            "feature": name,
            "weight": float(column.mean()),
            "survives": float(np.mean(column != 0.0)),
        }
        for name, column in zip(FEATURE_NAMES, found.T, strict=True)
    ]


def _path_rows(model: str, alphas: np.ndarray, path: np.ndarray) -> pd.DataFrame:
    size = len(FEATURE_NAMES)
    return pd.DataFrame(
        {
            "model": model,
            "protocol": LEAKAGE_FREE,
            "alpha": np.repeat(alphas, size),
            "symbol": [quantity(name).symbol for name in FEATURE_NAMES] * len(alphas),
            "feature": list(FEATURE_NAMES) * len(alphas),
            "weight": path.ravel(),
        }
    )


def _validation_rows(model: str, penalty: Penalty) -> pd.DataFrame:
    count = np.isfinite(penalty.scores).sum(axis=0)
    return pd.DataFrame(
        {
            "model": model,
            "protocol": LEAKAGE_FREE,
            "alpha": penalty.alphas,
            "mean": np.nanmean(penalty.scores, axis=0),
            "stderr_of_mean": np.nanstd(penalty.scores, axis=0, ddof=1) / np.sqrt(count),
            "chosen": penalty.alphas == penalty.alpha,
        }
    )


def train(dataset: pd.DataFrame, target: str, name: str, **options) -> dict:
    """Outputs of the rule by name; arguments of `abradem.learning.rows.learning_table` and `fit_penalised`."""
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
