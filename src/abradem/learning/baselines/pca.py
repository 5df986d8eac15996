"""Principal component analysis of the 20 features, and regression on the components.

``as_published`` scales the features to 0...1 over all rows, and regresses two targets on an
increasing number of components: the wear, and the wrong target of the paper, the last component,
which was in the column where the notebook expected the wear. ``leakage_free`` standardises the
features, and chooses the number of components by cross-validation inside the training rows.

The analysis itself does not use the target. Its loadings, variances and groups are computed from
all rows and are descriptive. Features that were held fixed have no part in any component: they are
left out and named. Directions without variance, which features that depend on each other leave,
are no components: their axes would be arbitrary.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, held_fixed, of_kind
from abradem.learning.evaluation import Predict, Results, evaluate_leakage_free
from abradem.learning.model_files import about
from abradem.learning.protocols import (
    AS_PUBLISHED,
    LEAKAGE_FREE,
    PUBLISHED_SHARE,
    folds,
    published_split,
    repeated_splits,
)
from abradem.learning.published import SCORES, WRONG_TARGET_COMPONENTS
from abradem.learning.rows import (
    FEWEST_ROWS,
    Scaler,
    Table,
    learning_table,
    minmax_scaler,
    standard_scaler,
)
from abradem.learning.scores import central_columns, mean_columns, r2, scores_of
from abradem.quantities import quantity

MODEL = "pca"
WRONG = "pca_wrong_target"
WEAR, LAST = "wear", "last component"

STIFFNESS = (
    "particle_youngs_modulus", "particle_shear_modulus", "equipment_youngs_modulus",
    "equipment_shear_modulus", "effective_youngs_modulus", "effective_shear_modulus",
)  # fmt: skip
NO_SPREAD = 1e-9
"""Standard deviation along a direction, as a share of the largest, that counts as none."""
GROUPED = 0.6
"""A feature is grouped with the component that it correlates with most, if the absolute
correlation is at least this large."""


class Components(NamedTuple):
    """Principal components.

    Attributes
    ----------
    axes : ndarray, shape (k, p)
        Orthonormal.
    variances : ndarray, shape (k,)
        In descending order, without those that are 0.
    centre : ndarray, shape (p,)
        Mean of the rows.
    """

    axes: np.ndarray
    variances: np.ndarray
    centre: np.ndarray


@dataclass(frozen=True)
class PcaResult:
    """Result of `fit_pca`.

    Attributes
    ----------
    loadings : pandas.DataFrame
        protocol, component, symbol, feature, loading, correlation (of feature and component), of
        the features that varied.
    scree : pandas.DataFrame
        protocol, component, variance, share, cumulative.
    correlations : pandas.DataFrame
        symbol, feature, other, correlation of all pairs of the 20 features and the target.
    curve : pandas.DataFrame
        protocol, explained, components, r2, r2_lower, r2_upper on held-out rows. As published: one
        split. Leakage-free: median over the repeated splits and their central share.
    results : Results
    model : tuple
        Description and arrays of the regression.
    summary : dict
        Groups of features by component, the groups of the stiffnesses as text, and
        ``held_fixed``, the features left out; ``wrong_target``, R2 of the last component with the
        numbers of components that give the printed value, and with all.
    """

    loadings: pd.DataFrame
    scree: pd.DataFrame
    correlations: pd.DataFrame
    curve: pd.DataFrame
    results: Results
    model: tuple
    summary: dict


def principal_components(z: np.ndarray) -> Components:
    """Principal components of scaled rows (n, p); the largest loading of each axis is positive."""
    centre = z.mean(axis=0)
    _, singular, vt = np.linalg.svd(z - centre, full_matrices=False)
    kept = singular > NO_SPREAD * singular.max(initial=0.0)
    singular, vt = singular[kept], vt[kept]
    sign = np.sign(vt[np.arange(len(vt)), np.argmax(np.abs(vt), axis=1)])
    return Components(vt * sign[:, None], singular**2 / max(len(z) - 1, 1), centre)


def _ordinary(scores: np.ndarray, y: np.ndarray, count: int) -> tuple[np.ndarray, float]:
    """Ordinary least squares of ``y`` on the first ``count`` columns, with intercept."""
    design = np.column_stack([scores[:, :count], np.ones(len(y))])
    found = np.linalg.lstsq(design, y, rcond=None)[0]
    return found[:-1], float(found[-1])


def regress(x: np.ndarray, y: np.ndarray, count: int) -> Predict:
    """Regression of ``y`` (n,) on the first ``count`` components of standardised rows ``x`` (n, p).

    Returns
    -------
    callable
        Predicts the target of raw rows.
    """
    of_x = standard_scaler(x)
    parts = principal_components(of_x.forward(x))
    slopes, intercept = _ordinary((of_x.forward(x) - parts.centre) @ parts.axes.T, y, count)
    weights = parts.axes[:count].T @ slopes
    return lambda rows: intercept + (of_x.forward(rows) - parts.centre) @ weights


def curve_of(x: np.ndarray, y: np.ndarray, rows: np.ndarray, actual: np.ndarray) -> np.ndarray:
    """R2 on ``rows`` for regressions on 1, 2, ... components fitted to ``x`` and ``y``."""
    of_x = standard_scaler(x)
    most = min(len(principal_components(of_x.forward(x)).axes), len(y) - 1)
    return np.array([r2(actual, regress(x, y, count)(rows)) for count in range(1, most + 1)])


def choose_components(
    x: np.ndarray, y: np.ndarray, groups: np.ndarray, fold_count: int, seed: int
) -> int:
    """Number of components with the best mean R2 over the folds."""
    curves = [
        curve_of(x[train], y[train], x[check], y[check])
        for train, check in folds(groups, fold_count, seed)
    ]
    shortest = max(1, min(map(len, curves)))
    if not all(map(len, curves)):
        # No feature varies in the training rows of a fold.
        return 1
    means = mean_columns(np.array([curve[:shortest] for curve in curves]))
    return 1 + int(np.argmax(np.nan_to_num(means, nan=-np.inf)))


def fit_pca(
    table: Table,
    fold_count: int = 5,
    test_share: float = 0.2,
    repeats: int = 20,
    confidence: float = 0.95,
    seed: int = 0,
) -> PcaResult:
    """Principal components and the regression on them under both protocols.

    Parameters
    ----------
    table : Table
    fold_count : int
        Folds inside the training rows, to choose the number of components.
    test_share, repeats, confidence, seed
        Of the leakage-free splits.

    Returns
    -------
    PcaResult
    """
    x, y = table.features, table.target
    results = Results(table)
    names = [table.names[column] for column in table.varied]
    scaled = [scaler(x).forward(x)[:, table.varied] for scaler in (minmax_scaler, standard_scaler)]
    published, standard = map(principal_components, scaled)
    curve = [*_published_curves(results, published), _leakage_free_curve(
        table, test_share, repeats, confidence, seed
    )]  # fmt: skip

    counts = []

    def fit_leakage_free(features, target, groups):
        counts.append(choose_components(features, target, groups, fold_count, seed))
        return regress(features, target, counts[-1])

    evaluate_leakage_free(results, MODEL, fit_leakage_free, test_share, repeats, seed)
    count = choose_components(x, y, table.groups, fold_count, seed)
    loadings = pd.concat(
        [
            _loadings(AS_PUBLISHED, published, scaled[0], names),
            _loadings(LEAKAGE_FREE, standard, scaled[1], names),
        ],
        ignore_index=True,
    )
    groups = {
        protocol: groups_of(loadings[loadings["protocol"] == protocol])
        for protocol in (AS_PUBLISHED, LEAKAGE_FREE)
    }
    return PcaResult(
        loadings=loadings,
        scree=pd.concat([_scree(AS_PUBLISHED, published), _scree(LEAKAGE_FREE, standard)]),
        correlations=_correlations(table),
        curve=pd.concat(curve, ignore_index=True),
        results=results,
        model=_model(table, standard, count, results, confidence),
        summary={
            "groups": groups,
            "stiffness": {name: stiffness_words(found) for name, found in groups.items()},
            "held_fixed": of_kind(table.names, table.variation, HELD_FIXED),
            "components": count,
            "components_of_the_splits": counts,
            "wrong_target": _wrong_target(curve[1]),
        },
    )


def _wrong_target(curve: pd.DataFrame) -> dict:
    """R2 of the wrong target where the paper's value belongs and with most components."""
    known = curve.set_index("components")["r2"]
    wanted = [count for count in WRONG_TARGET_COMPONENTS if count in known.index]
    return {
        "printed": SCORES[WRONG][0],
        "r2": [{"components": count, "r2": known[count]} for count in wanted],
        "all_components": {"components": len(known), "r2": known.iloc[-1] if len(known) else None},
    }


def groups_of(loadings: pd.DataFrame) -> dict[str, list[str]]:
    """Features grouped by the component that they correlate with most, see `GROUPED`."""
    found: dict[str, list[str]] = {}
    for feature, rows in loadings.groupby("feature", sort=False):
        best = rows.loc[rows["correlation"].abs().idxmax()]
        if abs(best["correlation"]) >= GROUPED:
            found.setdefault(f"PC{int(best['component'])}", []).append(str(feature))
    return dict(sorted(found.items(), key=lambda item: int(item[0][2:])))


def stiffness_words(groups: dict[str, list[str]]) -> str:
    """The components that group two or more stiffnesses, as one line of text."""
    parts = []
    for component, features in groups.items():
        stiff = [quantity(name).symbol for name in features if name in STIFFNESS]
        if len(stiff) > 1:
            parts.append(f"{component} groups {', '.join(stiff)}")
    return "; ".join(parts) or "no component groups stiffnesses"


def _published_curves(results: Results, parts: Components) -> list[pd.DataFrame]:
    """R2 against the number of components on the published split, for wear and last component.

    As in the notebook: min-max scaling, components of all rows, then components standardised over
    all rows.
    """
    table = results.table
    x, y = table.features, table.target
    train, test = published_split(len(y), PUBLISHED_SHARE)
    scores = (minmax_scaler(x).forward(x)[:, table.varied] - parts.centre) @ parts.axes.T
    z = standard_scaler(scores).forward(scores)
    curves = []
    for model, name, target, most in (
        (MODEL, WEAR, y, z.shape[1]),
        (WRONG, LAST, z[:, -1], z.shape[1] - 1),
    ):
        most = min(most, len(train) - 1)
        if not most:
            # A single component leaves nothing to explain it.
            curves.append(_curve_rows(AS_PUBLISHED, name, np.empty(0)))
            results.add_metrics(model, AS_PUBLISHED, "test", 0, {"R2": np.nan})
            continue
        found = []
        for count in range(1, most + 1):
            slopes, intercept = _ordinary(z[train], target[train], count)
            found.append(r2(target[test], intercept + z[test, :count] @ slopes))
        curves.append(_curve_rows(AS_PUBLISHED, name, np.array(found)))
        if model == MODEL:
            predicted = intercept + z[:, :count] @ slopes
            floor = float(y[train].min())
            results.add(model, AS_PUBLISHED, "train", 0, train, predicted[train], floor, False)
            results.add(model, AS_PUBLISHED, "test", 0, test, predicted[test], floor)
        else:
            results.add_metrics(model, AS_PUBLISHED, "test", 0, {"R2": found[-1]})
    return curves


def _leakage_free_curve(
    table: Table, test_share: float, repeats: int, confidence: float, seed: int
) -> pd.DataFrame:
    x, y = table.features, table.target
    curves = [
        curve_of(x[train], y[train], x[test], y[test])
        for train, test in repeated_splits(table.keys, table.groups, test_share, repeats, seed)
    ]
    # The rows of a split may leave fewer components than those of another.
    shortest = min(map(len, curves))
    found = np.array([curve[:shortest] for curve in curves])
    return _curve_rows(LEAKAGE_FREE, WEAR, *central_columns(found, confidence))


def _curve_rows(protocol, target, found, lower=np.nan, upper=np.nan) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "protocol": protocol,
            "explained": target,
            "components": np.arange(1, len(found) + 1),
            "r2": found,
            "r2_lower": lower,
            "r2_upper": upper,
        }
    )


def _loadings(protocol: str, parts: Components, z: np.ndarray, names: list[str]) -> pd.DataFrame:
    spread = z.std(axis=0, ddof=1) if len(z) > 1 else np.ones(z.shape[1])
    # Correlation of feature j and component i: axis_ij sqrt(variance_i) / spread_j.
    correlation = parts.axes * np.sqrt(parts.variances)[:, None]
    correlation = np.divide(correlation, spread, out=np.zeros_like(correlation), where=spread > 0)
    return pd.DataFrame(
        {
            "protocol": protocol,
            "component": np.repeat(np.arange(1, len(parts.axes) + 1), len(names)),
            "symbol": [quantity(name).symbol for name in names] * len(parts.axes),
            "feature": names * len(parts.axes),
            "loading": parts.axes.ravel(),
            "correlation": correlation.ravel(),
        }
    )


def _scree(protocol: str, parts: Components) -> pd.DataFrame:
    share = parts.variances / parts.variances.sum()
    return pd.DataFrame(
        {
            "protocol": protocol,
            "component": np.arange(1, len(share) + 1),
            "variance": parts.variances,
            "share": share,
            "cumulative": np.cumsum(share),
        }
    )


def _correlations(table: Table) -> pd.DataFrame:
    """Pearson correlations of X1 to X21; nan for constant columns."""
    values = np.column_stack([table.features, table.target])
    of_values = standard_scaler(values)
    z = of_values.forward(values)
    z[:, held_fixed(values)] = np.nan
    found = z.T @ z / len(z)
    names = [*table.names, table.target_name]
    return pd.DataFrame(
        {
            "symbol": np.repeat([quantity(name).symbol for name in names], len(names)),
            "feature": np.repeat(names, len(names)),
            "other": names * len(names),
            "correlation": found.ravel(),
        }
    )


def _model(
    table: Table, parts: Components, count: int, results: Results, confidence: float
) -> tuple:
    x, y = table.features, table.target
    of_x = standard_scaler(x)
    count = min(count, len(parts.axes))
    z = of_x.forward(x)[:, table.varied] - parts.centre
    slopes, intercept = _ordinary(z @ parts.axes.T, y, count)
    coefficients = np.zeros(x.shape[1])
    coefficients[table.varied] = parts.axes[:count].T @ slopes
    axes = np.zeros((len(parts.axes), x.shape[1]))
    axes[:, table.varied] = parts.axes
    description = about(
        table,
        MODEL,
        LEAKAGE_FREE,
        "linear",
        (of_x, Scaler(np.float64(intercept), np.float64(1.0))),
        components=count,
        confidence=confidence,
        scores=scores_of(results.scores, MODEL, LEAKAGE_FREE, confidence),
    )
    arrays = {
        "coefficients": coefficients,
        "axes": axes,
        "variances": parts.variances,
    }
    return description, arrays


def train(dataset: pd.DataFrame, target: str, name: str, **options) -> dict:
    """Outputs of the workflow rule by name; ``options`` are arguments of `fit_pca`."""
    found = fit_pca(learning_table(dataset, target, name, FEWEST_ROWS), **options)
    return {
        "loadings": found.loadings,
        "scree": found.scree,
        "correlations": found.correlations,
        "curve": found.curve,
        "scores": found.results.scores,
        "predictions": found.results.predictions,
        "summary": found.summary,
        "model": found.model,
    }
