"""Scores and splits compared with their definitions."""

import numpy as np
import pandas as pd
import pytest

from abradem.learning.protocols import held_out, repeated_splits
from abradem.learning.scores import (
    METRICS,
    SCORE_COLUMNS,
    central,
    central_columns,
    middle_of,
    r2,
    score,
    score_intervals,
    score_rows,
)


def test_scores_match_values_worked_out_by_hand():
    actual, predicted = np.array([1.0, 2.0, 4.0]), np.array([1.0, 3.0, 2.0])
    # Mean 7/3, spread 42/9; errors 0, 1, -2.
    scores = score(actual, predicted, 1.0)
    assert scores["R2"] == pytest.approx(1 - 5 / (42 / 9))
    assert scores["RMSE"] == pytest.approx(np.sqrt(5 / 3))
    assert scores["MAE"] == pytest.approx(1.0)
    assert scores["MAPE"] == pytest.approx((0.5 + 0.5) / 3)
    log = np.log(actual)
    assert scores["R2_log"] == pytest.approx(
        1 - (np.log(1.5) ** 2 + np.log(2.0) ** 2) / np.sum((log - log.mean()) ** 2)
    )
    assert tuple(scores) == METRICS


def test_the_mean_scores_zero_and_the_truth_one():
    y = np.array([1.0, 2.0, 6.0])
    assert r2(y, y) == 1.0
    assert r2(y, np.full(3, 3.0)) == pytest.approx(0.0)
    assert np.isnan(r2(y[:1], y[:1]))
    assert np.isnan(r2(np.ones(3), y))


def test_a_target_without_spread_has_no_r2_and_huge_ones_do_not_overflow():
    assert np.isnan(r2(np.full(3, 0.1) + 1e-17 * np.arange(3), np.ones(3)))
    assert np.isnan(r2(np.array([0.1, 0.1 * (1.0 + 1e-9)]), np.ones(2)))
    y = np.array([1.0, 2.0, 6.0])
    assert r2(1e300 * y, 1e300 * (y + 1.0)) == pytest.approx(r2(y, y + 1.0))
    assert r2(y, 1e200 * y) == -1e9
    scores = score(y, 1e200 * y, 1.0)
    assert all(np.isfinite(value) for value in scores.values())


def test_undefined_scores_do_not_count():
    count, *found = central([0.5, np.nan, 0.7, 0.9], 0.9)
    assert count == 3 and found[0] == 0.7
    assert central([np.nan], 0.9)[0] == 0 and np.isnan(central([np.nan], 0.9)[1])
    assert np.isnan(middle_of([]))
    middle, lower, upper = central_columns(np.array([[0.1, np.nan], [0.3, np.nan]]), 1.0)
    assert (middle[0], lower[0], upper[0]) == pytest.approx((0.2, 0.1, 0.3))
    assert np.isnan([middle[1], lower[1], upper[1]]).all()


def test_predictions_below_the_floor_are_raised_for_the_logarithm_alone():
    actual, predicted = np.array([1.0, 2.0, 4.0]), np.array([-5.0, 2.0, 4.0])
    scores = score(actual, predicted, 1.0)
    assert scores["R2_log"] == pytest.approx(1.0)
    assert scores["floored_share"] == pytest.approx(1 / 3)
    assert scores["R2"] < 0.0


def test_targets_of_zero_have_no_relative_scores():
    scores = score(np.array([0.0, 1.0]), np.array([0.5, 0.5]), 0.1)
    assert np.isnan(scores["MAPE"]) and np.isnan(scores["R2_log"])
    assert np.isfinite(scores["RMSE"])


def test_only_errors_carry_the_unit_of_the_target():
    keys = dict(model="m", protocol="p", table="t", split="test", repeat=0, target_unit="mm/s")
    rows = pd.DataFrame(score_rows(dict.fromkeys(METRICS, 1.0), **keys))
    assert list(rows) == SCORE_COLUMNS
    assert set(rows.loc[rows["unit"] == "mm/s", "metric"]) == {"RMSE", "MAE"}


def test_the_interval_over_repeats_holds_the_central_share():
    keys = dict(model="m", protocol="p", table="t", split="test", target_unit="mm/s")
    rows = [row for k in range(101) for row in score_rows({"R2": k / 100}, **keys, repeat=k)]
    (line,) = score_intervals(pd.DataFrame(rows), 0.9).to_dict("records")
    assert (line["lower"], line["median"], line["upper"]) == pytest.approx((0.05, 0.5, 0.95))
    assert line["repeats"] == 101 and line["mean"] == pytest.approx(0.5)


def test_splits_part_all_rows_and_follow_the_keys_not_the_rows():
    keys = np.array([30, 10, 20, 50, 40, 60, 70])
    order = np.argsort(keys)
    pairs = zip(
        repeated_splits(keys, np.arange(len(keys)), 0.2, 4, seed=3),
        repeated_splits(keys[order], order, 0.2, 4, seed=3),
        strict=True,
    )
    for (train, test), (other_train, other_test) in pairs:
        assert sorted([*train, *test]) == list(range(7))
        assert len(test) == 2
        assert list(keys[test]) == list(keys[order][other_test])
        assert list(keys[train]) == list(keys[order][other_train])


def test_splits_differ_and_the_first_ones_stay_when_more_are_asked_for():
    few = [tuple(test) for _, test in repeated_splits(np.arange(50), np.arange(50), 0.2, 3, seed=1)]
    more = [
        tuple(test) for _, test in repeated_splits(np.arange(50), np.arange(50), 0.2, 9, seed=1)
    ]
    assert more[:3] == few and len(set(more)) == 9


def test_impossible_splits_are_refused():
    assert held_out(10, 0.2) == 2 and held_out(12, 0.2) == 3
    with pytest.raises(ValueError, match="cannot be split"):
        held_out(1, 0.2)
    with pytest.raises(ValueError, match="between 0 and 1"):
        held_out(10, 1.2)
