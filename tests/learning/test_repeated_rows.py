"""Rows that repeat one another are on one side of every split and of every fold."""

import numpy as np
import pandas as pd
import pytest
from scipy.cluster.hierarchy import linkage
from tables import drawn, no_law, product_law

from abradem.learning.baselines.ga_ann import leakage_free_split
from abradem.learning.baselines.trees import fit_trees
from abradem.learning.physical.intervals import hold_out_in_turn
from abradem.learning.physical.models import BOOSTING, evaluate, fit_physical, makers
from abradem.learning.physical.problem import problem
from abradem.learning.protocols import divide, folds, repeated_splits
from abradem.learning.repeated_rows import edges, groups_of_rows, repeats_among
from abradem.learning.rows import learning_table
from abradem.quantities import FEATURE_NAMES
from abradem.surrogate.groups import Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


def features(n, seed=0):
    return drawn(n, seed)[list(FEATURE_NAMES)].to_numpy(float)


def written_twice(frame, shift=0.0):
    """A table with every row repeated, its features changed by a relative normal deviate."""
    again = frame.assign(case_id=frame["case_id"] + len(frame))
    away = np.random.default_rng(7).standard_normal((len(frame), len(FEATURE_NAMES)))
    again[list(FEATURE_NAMES)] *= 1.0 + shift * away
    return pd.concat([frame, again], ignore_index=True)


# Groups


def test_distances_between_neighbours_are_the_merges_of_single_linkage():
    columns = np.random.default_rng(1).standard_normal((3, 60))
    merges = linkage(columns.T, "single", metric="chebyshev")[:, 2]
    np.testing.assert_allclose(np.sort(edges(columns)), merges)


@pytest.mark.parametrize("shift", [0.0, 1e-5, 1e-4, 1e-3])
def test_every_row_is_found_with_its_repeat(shift):
    rng = np.random.default_rng(3)
    x = features(200)
    both = np.vstack([x, x * (1.0 + shift * rng.standard_normal(x.shape))])
    groups = groups_of_rows(both)
    np.testing.assert_array_equal(groups[:200], np.arange(200))
    np.testing.assert_array_equal(groups[200:], np.arange(200))


def test_rows_drawn_at_random_do_not_repeat_one_another():
    for n in (8, 200, 1500):
        np.testing.assert_array_equal(groups_of_rows(features(n)), np.arange(n))


def test_a_design_of_few_levels_and_a_dense_series_are_no_repeats():
    levels = np.array(np.meshgrid(np.linspace(0.0, 70.0, 500), [1.0, 2.0], [3.0, 4.0]))
    assert len(set(groups_of_rows(levels.reshape(3, -1).T))) == 2000
    # Neighbours of a random series are near by chance; a large group would leave nothing to hold
    # out.
    series = np.random.default_rng(2).uniform(0.0, 70.0, (500, 1))
    assert np.bincount(groups_of_rows(series)).max() <= 5
    assert len(set(groups_of_rows(series))) > 440


def test_small_values_that_differ_by_a_factor_are_different():
    x = features(60)
    x[0] = x[1]
    constant = FEATURE_NAMES.index("archard_constant")
    x[:2, constant] = 1e-12, 2e-12
    assert groups_of_rows(x)[0] != groups_of_rows(x)[1]
    x[:2, constant] = 1e-12
    assert groups_of_rows(x)[0] == groups_of_rows(x)[1]


def test_many_repeats_of_few_settings_are_few_groups():
    angles = np.repeat(np.linspace(0.0, 70.0, 5), 40)[:, None]
    np.testing.assert_array_equal(groups_of_rows(angles), np.repeat(np.arange(5), 40))
    assert (groups_of_rows(np.full((4, 2), 3.0)) == 0).all()


def test_repeats_are_counted_and_named():
    found = repeats_among(np.array([0, 1, 0, 2, 1, 0]), np.array([10, 11, 12, 13, 14, 15]))
    assert found == {"rows": 5, "groups": 2, "cases": [[10, 12, 15], [11, 14]]}
    assert repeats_among(np.arange(3), np.arange(3)) == {"rows": 0, "groups": 0, "cases": []}


# Splits and folds

SIZES = np.repeat(np.arange(40), np.random.default_rng(5).integers(1, 9, 40))


def divided(groups, parts):
    return set(groups[parts[0]]) & set(groups[parts[1]])


def test_no_split_and_no_fold_divides_a_group():
    groups = np.random.default_rng(6).permutation(SIZES)
    parts = [
        *((0.2, part) for part in repeated_splits(np.arange(len(groups)), groups, 0.2, 20, 1)),
        *((0.2, part) for part in folds(groups, 5, 1)),
        (0.3, divide(groups, 0.3, np.random.default_rng(2))),
    ]
    for share, (train, test) in parts:
        assert not divided(groups, (train, test))
        assert sorted([*train, *test]) == list(range(len(groups)))
        # Whole groups come as near to the share as the largest group has rows.
        assert len(test) / len(groups) == pytest.approx(share, abs=8 / len(groups))


def test_a_group_too_large_to_hold_out_is_trained_on():
    groups = np.array([0] * 90 + [1] * 10)
    for train, test in repeated_splits(np.arange(100), groups, 0.2, 5, 1):
        assert len(train) == 90 and len(test) == 10
    with pytest.raises(ValueError, match="all rows repeat one another"):
        next(repeated_splits(np.arange(9), np.zeros(9), 0.2, 5, 1))
    with pytest.raises(ValueError, match="all rows repeat one another"):
        folds(np.zeros(9), 5, 1)


def test_folds_and_the_first_split_are_drawn_independently():
    same = 0
    for seed in range(40):
        _, test = next(repeated_splits(np.arange(100), np.arange(100), 0.2, 1, seed))
        same += sum(set(test) == set(check) for _, check in folds(np.arange(100), 5, seed))
    assert same == 0


def test_folds_do_not_deal_out_the_rows_of_the_first_split():
    """One stream for both would deal the rows held out first evenly over the folds."""
    even = 0
    for seed in range(40):
        _, test = next(repeated_splits(np.arange(100), np.arange(100), 0.2, 1, seed))
        shares = [len(np.intersect1d(test, check)) for _, check in folds(np.arange(100), 5, seed)]
        even += shares == [4] * 5
    # By chance, in 5 of 1000 seeds.
    assert even <= 3


def test_rows_for_validation_of_a_search_repeat_none_of_those_for_fitting():
    table = learning_table(written_twice(no_law(40), 1e-4))
    train, test = next(repeated_splits(table.keys, table.groups, 0.2, 1, 1))
    split = leakage_free_split(table, train, test, 0.25, 12, [1, 0, 1])
    assert not divided(table.groups, (split.fit, split.look))
    assert sorted([*split.fit, *split.look]) == list(train)


# Scores


def score_of(results, model, metric="R2"):
    return results.scores.query(
        "model == @model and protocol == 'leakage_free' and split == 'test' and metric == @metric"
    )["value"].median()


@pytest.mark.parametrize("shift", [0.0, 1e-3])
def test_wear_without_a_law_is_not_learned_by_heart_from_a_table_written_twice(shift):
    table = learning_table(written_twice(no_law(80), shift))
    apart = table._replace(groups=np.arange(160))
    quick = {"max_depth": 2, "forest_trees": 20, "repeats": 5, "seed": 1}
    assert score_of(fit_trees(table, **quick).results, "forest") < 0.0
    # The same rows without groups: known by heart.
    assert score_of(fit_trees(apart, **quick).results, "forest") > 0.4


def test_physical_models_and_their_intervals_keep_repeats_together():
    # Noise as large as the law, so that half of the variance cannot be predicted.
    given = problem(written_twice(product_law(60, noise=1.0)), JET)
    apart = given._replace(table=given.table._replace(groups=np.arange(120)))
    models = {BOOSTING: makers(1, {"trees": 200})[BOOSTING]}
    known, unknown = (
        score_of(evaluate(one, models, repeats=3, seed=1), BOOSTING, "R2_log")
        for one in (apart, given)
    )
    assert unknown < 0.7 < 0.95 < known
    # The errors of rows known by heart are far smaller than those of new ones.
    rows = np.arange(120)
    scores = [np.median(hold_out_in_turn(one, rows, 3, 1).score) for one in (given, apart)]
    assert scores[0] > 20.0 * scores[1]
    _, _, summary, _ = fit_physical(given, makers(1, {"trees": 5}, {"members": 1, "steps": 20}),
                                    repeats=1)  # fmt: skip
    assert summary["rows"] == 120
    assert (summary["repeated"]["rows"], summary["repeated"]["groups"]) == (120, 60)
    assert summary["repeated"]["cases"][1] == [1, 61]
