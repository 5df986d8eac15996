"""Ordinary least squares on the 20 features, the model whose equation the study prints.

Features and target are standardised (mean and standard deviation of the rows fitted), so the
coefficients compare: standard deviations of wear per standard deviation of a feature, the
others held. Only 14 of the 20 features vary independently (E, E*, G*, xi and eta are functions
of others), hence

* the fit is the minimal-norm least-squares solution by singular values; rank and condition
  number are reported, and a coefficient that the rows do not determine says so;
* the intervals are t-intervals with the HC3 sandwich (MacKinnon and White 1985, J. Econometrics
  29:305), because the scatter of wear grows with wear and the textbook formula, which assumes
  it constant, would be wrong. With A = pinv(X), residuals r and leverages h the covariance of
  the coefficients is A diag(r^2 / (1 - h)^2) A'. Nearly dependent features make them wide.

The equation is fitted on all rows and describes; how well such a model predicts is what the
held-out rows of repeated splits say, where scaler and fit see training rows only.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from abradem.dataset import COLUMNS, content_hash, write_json, write_table
from abradem.learning.protocols import repeated_splits
from abradem.learning.scores import SCORE_COLUMNS, score, score_rows, summarise
from abradem.parameters import FEATURE_NAMES, TARGET, quantity

MODEL = "linear"
PROTOCOL = "honest"

SINGULAR_CUTOFF = 1e-10
"""Singular values below this share of the largest count as zero."""


class Fit(NamedTuple):
    """Least squares in standardised variables; arrays run over the features.

    ``scale`` is 1 for a constant feature, whose coefficient is 0 and not ``identified``.
    """

    mean: np.ndarray
    scale: np.ndarray
    target_mean: float
    target_scale: float
    coefficients: np.ndarray
    standard_error: np.ndarray
    identified: np.ndarray
    rank: int
    condition_number: float
    degrees_of_freedom: int


@dataclass(frozen=True)
class LinearResult:
    """What `fit_linear` gives.

    Attributes
    ----------
    coefficients : pandas.DataFrame
        symbol, feature, coefficient, standard_error, lower, upper, identified; one row per
        feature, dimensionless.
    equation : str
        The fitted equation in standardised variables.
    predictions : pandas.DataFrame
        model, protocol, case_id, repeat, split, actual, predicted (mm/s) of held-out rows.
    scores : pandas.DataFrame
        Tidy scores: splits ``test`` and ``train`` of every repeat, ``fit`` of all rows.
    summary : dict
        Everything to store and to use the model: names, units, scaler, coefficients, training
        ranges, rank, held-out scores, and in words what could not be computed (``notes``).
    """

    coefficients: pd.DataFrame
    equation: str
    predictions: pd.DataFrame
    scores: pd.DataFrame
    summary: dict


def least_squares(features: np.ndarray, target: np.ndarray) -> Fit:
    """Minimal-norm least squares with intercept in standardised variables, HC3 errors.

    Parameters
    ----------
    features : ndarray, shape (n, p)
    target : ndarray, shape (n,)

    Returns
    -------
    Fit
        ``standard_error`` is nan where a coefficient is not identified, and everywhere if no
        residual degree of freedom is left or a row is fitted whatever its target.
    """
    n = len(target)
    mean, constant = features.mean(axis=0), _constant(features)
    scale = np.where(constant, 1.0, features.std(axis=0))
    target_mean, target_scale = float(target.mean()), float(target.std()) or 1.0
    x = np.where(constant, 0.0, (features - mean) / scale)
    y = (target - target_mean) / target_scale

    u, singular, vt = np.linalg.svd(x, full_matrices=False)
    kept = singular > SINGULAR_CUTOFF * singular.max(initial=0.0)
    u, singular, vt = u[:, kept], singular[kept], vt[kept]
    rank = len(singular)
    pseudo_inverse = (vt.T / singular) @ u.T
    coefficients = np.where(constant, 0.0, pseudo_inverse @ y)
    identified = np.sum(vt**2, axis=0) > 1.0 - 1e-8

    leverage = 1.0 / n + np.sum(u**2, axis=1)
    freedom = n - rank - 1
    if freedom >= 1 and leverage.max() < 1.0 - 1e-9:
        weighted = (y - x @ coefficients) / (1.0 - leverage)
        error = np.sqrt(np.sum((pseudo_inverse * weighted) ** 2, axis=1))
        error = np.where(identified, error, np.nan)
    else:
        error = np.full(features.shape[1], np.nan)
    return Fit(
        mean,
        scale,
        target_mean,
        target_scale,
        coefficients,
        error,
        identified,
        rank,
        float(singular.max() / singular.min()) if rank else np.nan,
        max(freedom, 0),
    )


def predict(fit: Fit, features: np.ndarray) -> np.ndarray:
    """Target of rows of features, in its own unit."""
    return fit.target_mean + fit.target_scale * (
        (features - fit.mean) / fit.scale @ fit.coefficients
    )


def fit_linear(
    dataset: pd.DataFrame,
    target: str = TARGET.name,
    test_share: float = 0.2,
    repeats: int = 50,
    confidence: float = 0.95,
    seed: int = 0,
    table: str = "dataset",
) -> LinearResult:
    """Fit the linear equation and score it on held-out rows of repeated splits.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features and ``target``, all finite.
    target : str
        A wear-rate column, mm/s.
    test_share : float
        Share of rows held out in each split.
    repeats : int
        Number of random splits.
    confidence : float
        Of the coefficients' intervals, and the central share of repeats that scores state.
    seed : int
        Of the splits.
    table : str
        Name of the table in the scores.

    Returns
    -------
    LinearResult
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence!r} must lie between 0 and 1")
    if target not in dataset:
        raise ValueError(f"dataset: lacks the target {target}")
    dataset = dataset.sort_values("case_id", ignore_index=True)
    keys = dataset["case_id"].to_numpy()
    x = dataset[list(FEATURE_NAMES)].to_numpy(dtype=float)
    y = dataset[target].to_numpy(dtype=float)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError("dataset: features and target must be finite")
    if len(y) < 3:
        raise ValueError(f"dataset: {len(y)} rows are too few for a linear model")
    names = {"model": MODEL, "protocol": PROTOCOL, "table": table}
    unit = COLUMNS[target].unit

    scores, predictions = [], []
    for repeat, (train, test) in enumerate(repeated_splits(keys, test_share, repeats, seed)):
        split_fit = least_squares(x[train], y[train])
        floor = float(y[train].min())
        for split, rows in (("test", test), ("train", train)):
            predicted = predict(split_fit, x[rows])
            metrics = score(y[rows], predicted, floor)
            scores += score_rows(metrics, **names, split=split, repeat=repeat, target_unit=unit)
            if split == "test":
                predictions.append(_predictions(keys[rows], repeat, y[rows], predicted))
    fit = least_squares(x, y)
    metrics = score(y, predict(fit, x), float(y.min()))
    scores += score_rows(metrics, **names, split="fit", repeat=-1, target_unit=unit)

    score_frame = pd.DataFrame(scores, columns=SCORE_COLUMNS)
    coefficients = _coefficients(fit, confidence)
    equation = _equation(coefficients)
    rows = {"rows": len(y), "train": len(train), "test": len(test)}
    return LinearResult(
        coefficients=coefficients,
        equation=equation,
        predictions=pd.concat(predictions, ignore_index=True),
        scores=score_frame,
        summary={
            **names,
            "target": {"name": target, "unit": unit},
            "features": [_feature(name, x[:, i], fit, i) for i, name in enumerate(FEATURE_NAMES)],
            "intercept": 0.0,
            "target_mean": fit.target_mean,
            "target_scale": fit.target_scale,
            "equation": equation,
            "rank": fit.rank,
            "condition_number": fit.condition_number,
            "degrees_of_freedom": fit.degrees_of_freedom,
            "intervals": f"{100 * confidence:g} % t-intervals, HC3 standard errors",
            "splits": {**rows, "repeats": repeats, "test_share": test_share, "seed": seed},
            "confidence": confidence,
            "scores": _held_out_scores(score_frame, confidence),
            "dataset_hash": content_hash(dataset[["case_id", *FEATURE_NAMES, target]]),
            "notes": _notes(fit, _constant(x), len(y), len(train), len(test), score_frame),
        },
    )


def write_linear(
    result: LinearResult,
    summary: str | Path,
    coefficients: str | Path,
    scores: str | Path,
    predictions: str | Path,
) -> None:
    """Write the model (JSON) and its tables (Parquet)."""
    write_table(result.coefficients, coefficients)
    write_table(result.scores, scores)
    write_table(result.predictions, predictions)
    write_json(result.summary, summary)


def _constant(features: np.ndarray) -> np.ndarray:
    """Which columns do not vary, shape (p,)."""
    return np.ptp(features, axis=0) <= 1e-12 * np.abs(features).max(axis=0)


def _feature(name: str, values: np.ndarray, fit: Fit, i: int) -> dict:
    row = quantity(name)
    return {
        "symbol": row.symbol,
        "name": name,
        "unit": row.unit,
        "mean": fit.mean[i],
        "scale": fit.scale[i],
        "coefficient": fit.coefficients[i],
        "training_range": [values.min(), values.max()],
    }


def _predictions(keys, repeat, actual, predicted) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "model": MODEL,
            "protocol": PROTOCOL,
            "case_id": keys,
            "repeat": repeat,
            "split": "test",
            "actual": actual,
            "predicted": predicted,
        }
    )


def _coefficients(fit: Fit, confidence: float) -> pd.DataFrame:
    freedom = fit.degrees_of_freedom
    quantile = stats.t.ppf(0.5 + 0.5 * confidence, freedom) if freedom else np.nan
    return pd.DataFrame(
        {
            "symbol": [quantity(name).symbol for name in FEATURE_NAMES],
            "feature": FEATURE_NAMES,
            "coefficient": fit.coefficients,
            "standard_error": fit.standard_error,
            "lower": fit.coefficients - quantile * fit.standard_error,
            "upper": fit.coefficients + quantile * fit.standard_error,
            "identified": fit.identified,
        }
    )


def _equation(coefficients: pd.DataFrame) -> str:
    """The equation in standardised variables, which has no intercept on the rows it fits."""
    terms = [
        f"{'-' if value < 0 else '+'} {abs(value):.3f} {symbol}"
        for symbol, value in zip(coefficients["symbol"], coefficients["coefficient"], strict=True)
    ]
    return f"{TARGET.symbol} = 0.000 " + " ".join(terms)


def _held_out_scores(scores: pd.DataFrame, confidence: float) -> dict:
    table = summarise(scores, confidence)
    return {
        split: {
            row.metric: {
                "mean": row.mean,
                "median": row.median,
                "lower": row.lower,
                "upper": row.upper,
                "unit": row.unit,
            }
            for row in rows.itertuples(index=False)
        }
        for split, rows in table.groupby("split", sort=False)
    }


def _notes(
    fit: Fit, constant: np.ndarray, rows: int, train: int, test: int, scores: pd.DataFrame
) -> list[str]:
    """What the rows do not allow, one line each."""
    notes = []
    size = len(FEATURE_NAMES)
    if constant.any():
        symbols = [quantity(name).symbol for name in np.array(FEATURE_NAMES)[constant]]
        notes.append(f"constant in this table, hence without effect: {', '.join(symbols)}")
    if fit.rank < size:
        notes.append(
            f"{rows} rows of rank {fit.rank} do not determine {size} coefficients: the fit of "
            "least norm is given"
        )
    if np.isnan(fit.standard_error).all():
        notes.append(f"{rows} rows leave no scatter to judge: no intervals of the coefficients")
    elif np.isnan(fit.standard_error).any():
        notes.append("coefficients that the rows do not determine have no interval")
    if train <= size:
        notes.append(
            f"{train} training rows for {size} coefficients: the fits interpolate their training "
            "rows and the held-out scores say little"
        )
    if test < 2:
        notes.append(f"{test} test row: no held-out R2")
    held_out = scores[(scores["split"] == "test") & (scores["metric"] == "R2_log")]
    if not np.isfinite(held_out["value"]).any() and test >= 2:
        notes.append("targets that are not positive: no scores on their logarithm")
    return notes
