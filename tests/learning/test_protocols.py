"""Training and test rows of both protocols, and folds inside the training rows."""

import numpy as np
import pytest
from tables import linear_law

from abradem.learning.baselines.linear import fit_linear
from abradem.learning.baselines.pca import fit_pca
from abradem.learning.baselines.penalised import fit_penalised
from abradem.learning.baselines.trees import fit_trees
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE, folds, published_split
from abradem.learning.rows import learning_table
from abradem.quantities import FEATURE_NAMES


@pytest.mark.parametrize("rows", [12, 99, 198])
@pytest.mark.parametrize("share", [0.2, 0.3])
def test_the_published_split_is_that_of_the_library(rows, share):
    from sklearn.model_selection import train_test_split

    train, test = train_test_split(np.arange(rows), test_size=share, random_state=42)
    ours = published_split(rows, share)
    np.testing.assert_array_equal(ours[0], train)
    np.testing.assert_array_equal(ours[1], test)


@pytest.mark.parametrize(("rows", "count"), [(20, 5), (7, 5), (4, 5)])
def test_folds_validate_every_row_once_and_never_train_on_it(rows, count):
    found = folds(np.arange(rows), count, seed=1)
    assert sorted(np.concatenate([check for _, check in found])) == list(range(rows))
    assert all(not set(train) & set(check) and len(check) >= 2 for train, check in found)


def test_too_few_rows_cannot_be_cross_validated():
    with pytest.raises(ValueError, match="3 rows are too few"):
        folds(np.arange(3), 5, seed=1)


def predicted(frame, protocol):
    """Test rows of the first split: case number, and the predictions of the cheap models."""
    quick = {"repeats": 1, "seed": 1, "fold_count": 3}
    table = learning_table(frame)
    parts = [
        fit_linear(frame, repeats=1, seed=1).predictions,
        fit_penalised(table, path_points=5, **quick).results.predictions,
        fit_pca(table, **quick).results.predictions,
        fit_trees(table, forest_trees=5, max_depth=3, **quick).results.predictions,
    ]
    rows = [part[part["protocol"] == protocol] for part in parts]
    return {
        model: group.set_index("case_id")["predicted"]
        for part in rows
        for model, group in part.groupby("model")
    }


def test_leakage_free_models_learn_nothing_from_test_rows_and_published_ones_do():
    frame = linear_law(60, noise=0.3)
    changed = {}
    for protocol in (LEAKAGE_FREE, AS_PUBLISHED):
        first = predicted(frame, protocol)
        (cases,) = {tuple(sorted(rows.index)) for rows in first.values()}
        # Another target for all test rows, and other features for the first of them.
        other = frame.copy()
        other.loc[other["case_id"].isin(cases), "wear_total_mean"] += 50.0
        other.loc[other["case_id"] == cases[0], list(FEATURE_NAMES)] *= 1.5
        second = predicted(other, protocol)
        rest = list(cases[1:])
        changed[protocol] = {
            model for model in first if not first[model][rest].equals(second[model][rest])
        }
    assert changed[LEAKAGE_FREE] == set()
    # All models except the tree use the test rows through their scalers.
    assert {"lasso", "ridge", "pca"} <= changed[AS_PUBLISHED]
