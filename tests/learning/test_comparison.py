"""Comparison of all models with each other and with the printed scores."""

import numpy as np
import pandas as pd
import pytest

from abradem.learning import published
from abradem.learning.comparison import beside_paper, bootstrap_r2, compare, join_tables
from abradem.learning.scores import SCORE_COLUMNS, score_rows
from abradem.quantities import FEATURE_NAMES


def scores_of(model, protocol, values, split="test"):
    keys = dict(model=model, protocol=protocol, table="t", split=split, target_unit="mm/s")
    rows = [row for i, v in enumerate(values) for row in score_rows({"R2": v}, **keys, repeat=i)]
    return pd.DataFrame(rows, columns=SCORE_COLUMNS)


def predictions_of(model, protocol, n=40, error=0.3):
    rng = np.random.default_rng(0)
    actual = rng.standard_normal(n)
    return pd.DataFrame(
        {"model": model, "protocol": protocol, "case_id": np.arange(n), "repeat": 0,
         "split": "test", "actual": actual, "predicted": actual + error * rng.standard_normal(n)}
    )  # fmt: skip


def test_the_bootstrap_interval_holds_the_score_of_many_rows():
    rng = np.random.default_rng(1)
    hits = 0
    for seed in range(60):
        actual = rng.standard_normal(60)
        predicted = actual + 0.5 * rng.standard_normal(60)
        low, high = bootstrap_r2(actual, predicted, 400, 0.95, seed)
        hits += low <= 0.75 <= high
    assert hits >= 51


def test_a_constant_target_has_no_bootstrap():
    assert np.isnan(bootstrap_r2(np.ones(5), np.ones(5), 100, 0.95, 0)).all()


@pytest.mark.parametrize("n", [2, 3])
def test_resamples_without_spread_leave_the_interval_undetermined(n):
    # One in n^(n-1) resamples repeats one row, more than the tails of the interval.
    actual = 0.1 + np.arange(n) * 1e-3
    assert np.isnan(bootstrap_r2(actual, actual + 1e-3, 2000, 0.95, 0)).all()


def test_float_noise_of_a_mean_is_no_spread():
    actual = np.array([0.1, 0.1, 0.1, 0.7, 0.2, 0.3])
    low, high = bootstrap_r2(actual, np.full(6, 0.25), 5000, 0.95, 0)
    assert -1e4 < low <= high < 1.0
    assert np.isnan(bootstrap_r2(0.1 + 1e-17 * np.arange(6), actual, 100, 0.95, 0)).all()


def test_repeated_splits_come_before_the_fixed_one():
    scores = join_tables(
        [
            scores_of("ridge", "leakage_free", [0.5, 0.6, 0.7]),
            scores_of("linear", "as_published", [0.6]),
            scores_of("ga_ann", "leakage_free", [0.9]),
            scores_of("ga_ann", "leakage_free", [0.7, 0.8, 0.9], "retrained"),
        ]
    )
    assert list(dict.fromkeys(scores["model"])) == ["linear", "ridge", "ga_ann"]
    predictions = join_tables(
        [predictions_of(*one) for one in
         (("ridge", "leakage_free"), ("linear", "as_published"), ("ga_ann", "leakage_free"))]
    )  # fmt: skip
    table = compare(scores, predictions, draws=200)
    assert table[["model", "basis"]].to_numpy().tolist() == [
        ["linear", "fixed split"], ["ridge", "repeated splits"], ["ridge", "fixed split"],
        ["ga_ann", "fixed split"], ["ga_ann", "trained again"],
    ]  # fmt: skip
    ridge = table.iloc[1]
    assert ridge["r2"] == 0.6 and ridge["repeats"] == 3
    assert (table["r2_lower"] <= table["r2"]).all() and (table["r2"] <= table["r2_upper"]).all()
    side = beside_paper(table).set_index("model")
    assert side.loc["linear", "printed_r2"] == 0.68 and side.loc["linear", "as_published_r2"] > 0.8
    assert side.loc["ridge", "leakage_free_r2"] == 0.6 and side.loc["ga_ann", "printed_r2"] == 0.91
    assert side.loc["ga_ann", "basis"] == "fixed split"


def test_misprints_are_told_on_the_papers_own_table_alone():
    refit = np.array(published.EQUATION)
    refit[[1, 8, 16]] = [-0.164, 0.210, 0.218]
    table, own = published.compare_equation(-0.019, refit)
    assert own and table.loc[0, ["feature", "verdict"]].tolist() == ["intercept", "agrees"]
    found = table[table["verdict"] != "agrees"].set_index("symbol")["verdict"]
    assert found.to_dict() == {
        "X2": "misprinted sign", "X9": "misprinted value", "X17": "misprinted sign",
    }  # fmt: skip
    table, own = published.compare_equation(0.0, np.random.default_rng(0).standard_normal(20))
    assert not own and set(table["verdict"]) == {"another table"}


def test_what_was_printed_is_complete():
    assert len(published.EQUATION) == 20 and len(published.SELECTED) == 12
    assert set(published.SELECTED) < set(FEATURE_NAMES)
    assert published.SCORES["linear"][0] == pytest.approx(0.68)
