"""Ordinary least squares on the 20 features, the model whose equation the paper prints.

Features and target are standardised with the mean and standard deviation of the fitted rows. The
coefficients are therefore comparable: change of the wear in standard deviations per standard
deviation of a feature, with the other features fixed. Only 14 of the 20 features vary
independently (E, E*, G*, xi and eta are functions of others). Therefore

* the fit is the minimum-norm least-squares solution by singular value decomposition; rank and
  condition number are reported, and coefficients not determined by the rows are marked;
* the intervals are t-intervals with HC3 standard errors (MacKinnon and White 1985,
  J. Econometrics 29:305), because the variance of the residuals grows with the wear, and the
  textbook formula assumes that it is constant. With A = pinv(X), residuals r and leverages h, the
  covariance of the coefficients is A diag(r^2 / (1 - h)^2) A'. Intervals of nearly dependent
  features are wide.

The equation is fitted to all rows and is descriptive. The predictive performance is measured on
the held-out rows of repeated splits, where scaler and fit see training rows only. The published
fit (one split, scaler of all rows) is repeated as well, and its coefficients are compared with
the printed ones.

Two diagnostics are reported. The variance inflation factor of feature j is 1 / (1 - R_j^2), where
R_j^2 is that of a regression of the feature on the others; it measures how much dependence widens
the interval. The Breusch-Pagan test in the form of Koenker (1981, J. Econometrics 17:107) compares
n R^2 of a regression of the squared residuals on the features with the chi-squared distribution,
and tests whether the variance of the residuals depends on the features.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from abradem.dataset.variation import HELD_FIXED, NOT_IDENTIFIED, VARIED, held_fixed, of_kind
from abradem.learning.evaluation import (
    Predict,
    Results,
    evaluate_as_published,
    evaluate_leakage_free,
    scalers_of_all_rows,
    with_scalers,
)
from abradem.learning.model_files import about
from abradem.learning.protocols import (
    AS_PUBLISHED,
    LEAKAGE_FREE,
    PUBLISHED_SHARE,
    held_out,
    published_split,
)
from abradem.learning.published import compare_equation
from abradem.learning.rows import Scaler, Table, learning_table, standard_scaler
from abradem.learning.scores import r2, scores_of
from abradem.quantities import FEATURE_NAMES, TARGET, quantity

MODEL = "linear"

SINGULAR_CUTOFF = 1e-10
"""Singular values below this share of the largest count as zero."""


class LeastSquares(NamedTuple):
    """Least-squares fit in standardised variables.

    Attributes
    ----------
    of_features, of_target : Scaler
    coefficients, standard_error : ndarray, shape (p,)
        The coefficient of a constant feature is 0.
    identified : ndarray of bool, shape (p,)
        Whether the rows determine the coefficient; False for constant features.
    leverage : ndarray, shape (n,)
        Of the fitted rows.
    rank : int
    condition_number : float
    degrees_of_freedom : int
    """

    of_features: Scaler
    of_target: Scaler
    coefficients: np.ndarray
    standard_error: np.ndarray
    identified: np.ndarray
    leverage: np.ndarray
    rank: int
    condition_number: float
    degrees_of_freedom: int


@dataclass(frozen=True)
class LinearResult:
    """Result of `fit_linear`.

    Attributes
    ----------
    coefficients : pandas.DataFrame
        protocol, symbol, feature, coefficient, standard_error, lower, upper, identified,
        variation (``varied``, ``held fixed`` or ``not identified``), variance_inflation; one row
        per feature, dimensionless. The coefficient of a feature that was held fixed is nan; one
        that is not identified belongs to the fit of least norm.
    equation : str
        The fitted equation in standardised variables.
    residuals : pandas.DataFrame
        protocol, case_id, fitted, residual (both in standard deviations of the target), leverage,
        studentised (residual divided by its standard error), normal_quantile (quantile of the
        normal distribution for the rank of the studentised residual); all rows.
    published : pandas.DataFrame
        Printed and refitted coefficients, see `abradem.learning.published.compare_equation`.
    predictions : pandas.DataFrame
        model, protocol, case_id, repeat, split, actual, predicted (mm/s) of held-out rows.
    scores : pandas.DataFrame
        Tidy scores: splits ``test`` and ``train`` of every repeat, ``fit`` on all rows.
    summary : dict
        Everything needed to use the model: names, units, scalers, coefficients, training ranges,
        rank, held-out scores; and ``notes`` on what could not be computed.
    """

    coefficients: pd.DataFrame
    equation: str
    residuals: pd.DataFrame
    published: pd.DataFrame
    predictions: pd.DataFrame
    scores: pd.DataFrame
    summary: dict


def least_squares(features: np.ndarray, target: np.ndarray) -> LeastSquares:
    """Minimum-norm least squares in standardised variables, with HC3 standard errors.

    Parameters
    ----------
    features : ndarray, shape (n, p)
    target : ndarray, shape (n,)

    Returns
    -------
    LeastSquares
        ``standard_error`` is nan for coefficients that are not identified, and for all if no
        residual degree of freedom is left or a row has leverage 1.
    """
    n = len(target)
    of_features, of_target = standard_scaler(features), standard_scaler(target)
    x, y = of_features.forward(features), of_target.forward(target)

    u, singular, vt = np.linalg.svd(x, full_matrices=False)
    kept = singular > SINGULAR_CUTOFF * singular.max(initial=0.0)
    u, singular, vt = u[:, kept], singular[kept], vt[kept]
    rank = len(singular)
    pseudo_inverse = (vt.T / singular) @ u.T
    coefficients = np.where(held_fixed(features), 0.0, pseudo_inverse @ y)
    identified = np.sum(vt**2, axis=0) > 1.0 - 1e-8

    leverage = 1.0 / n + np.sum(u**2, axis=1)
    freedom = n - rank - 1
    if freedom >= 1 and leverage.max() < 1.0 - 1e-9:
        weighted = (y - x @ coefficients) / (1.0 - leverage)
        error = np.sqrt(np.sum((pseudo_inverse * weighted) ** 2, axis=1))
        error = np.where(identified, error, np.nan)
    else:
        error = np.full(features.shape[1], np.nan)
    return LeastSquares(
        of_features,
        of_target,
        coefficients,
        error,
        identified,
        leverage,
        rank,
        float(singular.max() / singular.min()) if rank else np.nan,
        max(freedom, 0),
    )


def predict_linear(fit: LeastSquares, features: np.ndarray) -> np.ndarray:
    """Predicted target (n,), in its own unit, for features (n, p)."""
    return fit.of_target.back(fit.of_features.forward(features) @ fit.coefficients)


def ordinary(x: np.ndarray, y: np.ndarray, _: np.ndarray) -> Predict:
    """Ordinary least squares as a model for `abradem.learning.evaluation`."""
    fit = least_squares(x, y)
    return lambda rows: predict_linear(fit, rows)


def variance_inflation(features: np.ndarray) -> np.ndarray:
    """Variance inflation factors of features (n, p), shape (p,).

    A factor is inf if the other features determine the feature, and nan for a constant feature.
    All are nan if there are too few rows.
    """
    varies = np.flatnonzero(~held_fixed(features))
    found = np.full(features.shape[1], np.nan)
    if len(features) <= len(varies) + 1:
        return found
    z = standard_scaler(features).forward(features)[:, varies]
    for place, column in enumerate(varies):
        others = np.delete(z, place, axis=1)
        weights = np.linalg.lstsq(others, z[:, place], rcond=None)[0]
        rest = float(np.mean((z[:, place] - others @ weights) ** 2))
        found[column] = 1.0 / rest if rest > SINGULAR_CUTOFF else np.inf
    return found


def breusch_pagan(features: np.ndarray, residuals: np.ndarray) -> dict:
    """Breusch-Pagan test in the form of Koenker: do squared residuals depend on the features?

    Parameters
    ----------
    features : ndarray, shape (n, p)
    residuals : ndarray, shape (n,)

    Returns
    -------
    dict
        ``statistic`` (n R^2), ``degrees_of_freedom``, ``p_value``; nan if there are too few rows.
    """
    squared = residuals**2
    fit = least_squares(features, squared)
    if len(squared) <= fit.rank + 1 or np.ptp(squared) == 0.0:
        return {"statistic": np.nan, "degrees_of_freedom": fit.rank, "p_value": np.nan}
    statistic = len(squared) * r2(squared, predict_linear(fit, features))
    return {
        "statistic": statistic,
        "degrees_of_freedom": fit.rank,
        "p_value": float(stats.chi2.sf(statistic, fit.rank)),
    }


def fit_linear(
    dataset: pd.DataFrame,
    target: str = TARGET.name,
    test_share: float = 0.2,
    repeats: int = 50,
    confidence: float = 0.95,
    seed: int = 0,
    table: str = "dataset",
) -> LinearResult:
    """Fit the linear equation and score it on held-out rows under both protocols.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features and ``target``, all finite.
    target : str
        A wear-rate column, mm/s.
    test_share : float
        Share of rows held out in each split (leakage-free).
    repeats : int
        Number of random splits (leakage-free).
    confidence : float
        Level of the intervals of the coefficients, and central share of the splits that the
        intervals of the scores contain.
    seed : int
        Seed of the splits.
    table : str
        Name of the data set in the scores.

    Returns
    -------
    LinearResult
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence!r} must lie between 0 and 1")
    rows = learning_table(dataset, target, table)
    x, y = rows.features, rows.target
    results = Results(rows)
    evaluate_leakage_free(results, MODEL, ordinary, test_share, repeats, seed)
    of_all = scalers_of_all_rows(rows)
    evaluate_as_published(results, MODEL, with_scalers(ordinary, of_all))

    fit = least_squares(x, y)
    fitted = predict_linear(fit, x)
    everything = np.arange(len(y))
    results.add(MODEL, LEAKAGE_FREE, "fit", -1, everything, fitted, float(y.min()), keep=False)
    residuals = _residuals(rows, fit, fitted)
    published, own = compare_equation(*_published_equation(rows))
    fixed = held_fixed(x)
    coefficients = _coefficients(fit, rows.names, fixed, confidence).assign(
        variance_inflation=variance_inflation(x)
    )
    scores = results.scores
    tested = held_out(len(y), test_share)
    train = len(y) - tested
    description = about(
        rows, MODEL, LEAKAGE_FREE, "linear", of_all, confidence=confidence,
        scores=scores_of(scores, MODEL, LEAKAGE_FREE, confidence),
    )  # fmt: skip
    for feature, coefficient in zip(description["features"], fit.coefficients, strict=True):
        feature["coefficient"] = coefficient
    return LinearResult(
        coefficients=coefficients,
        equation=_equation(coefficients),
        residuals=residuals,
        published=published,
        predictions=results.predictions,
        scores=scores,
        summary={
            **description,
            "equation": _equation(coefficients),
            "scores_as_published": scores_of(scores, MODEL, AS_PUBLISHED, confidence),
            "breusch_pagan": breusch_pagan(x, residuals["residual"].to_numpy()),
            "misprints": _misprints(published) if own else None,
            "rank": fit.rank,
            "condition_number": fit.condition_number,
            "degrees_of_freedom": fit.degrees_of_freedom,
            "intervals": f"{100 * confidence:g} % t-intervals, HC3 standard errors",
            "splits": {
                "rows": len(y), "train": train, "test": tested, "repeats": repeats,
                "test_share": test_share, "seed": seed,
            },
            "held_fixed": of_kind(rows.names, coefficients["variation"], HELD_FIXED),
            "not_identified": of_kind(rows.names, coefficients["variation"], NOT_IDENTIFIED),
            "notes": _notes(fit, rows.names, fixed, len(y), train, tested, scores),
        },
    )  # fmt: skip


def _published_equation(table: Table) -> tuple[float, np.ndarray]:
    """Intercept and coefficients of the published fit, in variables scaled over all rows."""
    of_x, of_y = scalers_of_all_rows(table)
    train, _ = published_split(len(table.target), PUBLISHED_SHARE)
    fit = least_squares(of_x.forward(table.features[train]), of_y.forward(table.target[train]))
    slopes = fit.coefficients * fit.of_target.scale / fit.of_features.scale
    intercept = float(fit.of_target.mean - fit.of_features.mean @ slopes)
    # Those of a geometry are not in the published equation.
    return intercept, slopes[: len(FEATURE_NAMES)]


def _misprints(published: pd.DataFrame) -> list[str]:
    rows = published[published["verdict"] != "agrees"]
    return [
        f"{row.symbol or row.feature}: printed {row.printed:+.3f}, refitted {row.refitted:+.3f} "
        f"({row.verdict})"
        for row in rows.itertuples(index=False)
    ]


def _residuals(table: Table, fit: LeastSquares, fitted: np.ndarray) -> pd.DataFrame:
    residual = (table.target - fitted) / fit.of_target.scale
    studentised = np.full(len(residual), np.nan)
    if fit.degrees_of_freedom and fit.leverage.max() < 1.0 - 1e-9:
        spread = np.sqrt(np.sum(residual**2) / fit.degrees_of_freedom) or np.nan
        studentised = residual / (spread * np.sqrt(1.0 - fit.leverage))
    return pd.DataFrame(
        {
            "protocol": LEAKAGE_FREE,
            "case_id": table.keys,
            "fitted": fit.of_target.forward(fitted),
            "residual": residual,
            "leverage": fit.leverage,
            "studentised": studentised,
            "normal_quantile": stats.norm.ppf(
                (stats.rankdata(studentised, "ordinal") - 0.5) / len(residual)
            ),
        }
    )


def _coefficients(
    fit: LeastSquares, names: Sequence[str], fixed: np.ndarray, confidence: float
) -> pd.DataFrame:
    freedom = fit.degrees_of_freedom
    quantile = stats.t.ppf(0.5 + 0.5 * confidence, freedom) if freedom else np.nan
    variation = np.where(fixed, HELD_FIXED, np.where(fit.identified, VARIED, NOT_IDENTIFIED))
    return pd.DataFrame(
        {
            "protocol": LEAKAGE_FREE,
            "symbol": [quantity(name).symbol for name in names],
            "feature": list(names),
            "coefficient": np.where(fixed, np.nan, fit.coefficients),
            "standard_error": fit.standard_error,
            "lower": fit.coefficients - quantile * fit.standard_error,
            "upper": fit.coefficients + quantile * fit.standard_error,
            "identified": fit.identified,
            "variation": variation.astype(object),
        }
    )


def _equation(coefficients: pd.DataFrame) -> str:
    """The equation in standardised variables; its intercept is 0 on the fitted rows."""
    varied = coefficients[coefficients["variation"] != HELD_FIXED]
    terms = [
        f"{'-' if value < 0 else '+'} {abs(value):.3f} {symbol}"
        for symbol, value in zip(varied["symbol"], varied["coefficient"], strict=True)
    ]
    said = f"{TARGET.symbol} = 0.000 " + " ".join(terms)
    for kind, words in ((HELD_FIXED, HELD_FIXED), (NOT_IDENTIFIED, f"{NOT_IDENTIFIED} singly")):
        found = of_kind(coefficients["symbol"], coefficients["variation"], kind)
        said += f"; {words}: {', '.join(found)}" if found else ""
    return said


def _notes(
    fit: LeastSquares,
    names: Sequence[str],
    fixed: np.ndarray,
    rows: int,
    train: int,
    test: int,
    scores: pd.DataFrame,
) -> list[str]:
    """Notes on what the rows do not allow, one line each."""
    notes = []
    size = len(names)
    if fixed.any():
        symbols = [quantity(name).symbol for name in np.array(names)[fixed]]
        notes.append(f"held fixed, hence without a coefficient: {', '.join(symbols)}")
    free = size - int(fixed.sum())
    if fit.rank < free:
        notes.append(
            f"{rows} rows of rank {fit.rank} do not determine {free} coefficients: the fit of "
            "least norm is given"
        )
    if np.isnan(fit.standard_error).all():
        notes.append(f"{rows} rows leave no scatter to judge: no intervals of the coefficients")
    elif np.isnan(fit.standard_error[~fixed]).any():
        notes.append("coefficients that the rows do not determine have no interval")
    if train <= free:
        notes.append(
            f"{train} training rows for {free} coefficients: the fits interpolate their training "
            "rows and the held-out scores say little"
        )
    if test < 2:
        notes.append(f"{test} test row: no held-out R2")
    logarithmic = scores[(scores["split"] == "test") & (scores["metric"] == "R2_log")]
    if not np.isfinite(logarithmic["value"]).any() and test >= 2:
        notes.append("targets that are not positive: no scores on their logarithm")
    return notes


def train(dataset: pd.DataFrame, target: str, name: str, **options) -> dict:
    """Outputs of the workflow rule by name; ``options`` are arguments of `fit_linear`."""
    found = fit_linear(dataset, target, table=name, **options)
    return {
        "summary": (
            found.summary,
            {"coefficients": found.coefficients["coefficient"].fillna(0.0).to_numpy()},
        ),
        "coefficients": found.coefficients,
        "residuals": found.residuals,
        "published": found.published,
        "scores": found.scores,
        "predictions": found.predictions,
    }
