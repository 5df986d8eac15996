"""Comparison of all models with each other and with the printed scores."""

import numpy as np
import pandas as pd
import pytest
from tables import product_law

from abradem.learning import published
from abradem.learning.comparison import (
    METRIC_COLUMNS,
    beside_paper,
    bootstrap,
    bootstrap_r2,
    compare,
    join_tables,
    number_scores,
    with_scale,
)
from abradem.learning.scores import SCORE_COLUMNS, score, score_rows
from abradem.quantities import FEATURE_NAMES
from abradem.surrogate.groups import Jet


def scores_of(model, protocol, values, split="test"):
    keys = dict(model=model, protocol=protocol, table="t", split=split, target_unit="mm/s")
    rows = [row for i, v in enumerate(values) for row in score_rows({"R2": v}, **keys, repeat=i)]
    return pd.DataFrame(rows, columns=SCORE_COLUMNS)


def predictions_of(model, protocol, n=40, error=0.3):
    rng = np.random.default_rng(0)
    actual = rng.standard_normal(n)
    return pd.DataFrame(
        {"model": model, "protocol": protocol, "case_id": np.arange(n), "repeat": 0,
         "split": "test", "actual": actual, "predicted": actual + error * rng.standard_normal(n),
         "floor": -3.0, "scale": 1.0}
    )  # fmt: skip


def wear_of(n=40, seed=0, floor=0.3):
    """Predictions of a positive wear, some of them below the floor, and its scale."""
    rng = np.random.default_rng(seed)
    scale = np.exp(rng.standard_normal(n))
    actual = scale * np.exp(0.5 * rng.standard_normal(n))
    predicted = actual * np.exp(0.2 * rng.standard_normal(n)) - 0.1
    return pd.DataFrame(
        {"model": "ridge", "protocol": "leakage_free", "case_id": np.arange(n), "repeat": 0,
         "split": "test", "actual": actual, "predicted": predicted, "floor": floor, "scale": scale}
    )  # fmt: skip


def test_bootstrap_intervals_of_all_metrics_are_those_of_a_plain_loop():
    part = wear_of()
    found = bootstrap(part, 300, 0.9, 3)
    draws = np.random.default_rng(3).integers(0, len(part), (300, len(part)))
    plain = [
        score(*(part[name].to_numpy()[rows] for name in ("actual", "predicted")), 0.3)
        for rows in draws
    ]
    for metric in ("R2", "R2_log", "RMSE", "MAE", "MAPE"):
        ends = np.percentile([one[metric] for one in plain], [5.0, 95.0])
        assert found[metric] == pytest.approx(ends)


def test_the_score_of_the_wear_number_has_the_errors_of_ln_y_over_its_own_variance():
    part = wear_of()
    (row,) = number_scores(part, "t").to_dict("records")
    away = np.log(np.maximum(part["predicted"], 0.3)) - np.log(part["actual"])
    number = np.log(part["actual"] / part["scale"])
    expected = 1.0 - np.sum(away**2) / np.sum((number - number.mean()) ** 2)
    assert (row["metric"], row["split"], row["repeat"]) == ("R2_number", "test", 0)
    assert row["value"] == pytest.approx(expected)
    # A model that knows the scale alone scores well on the wear and nothing on the number.
    trivial = part.assign(predicted=part["scale"] * np.exp(number.mean()), floor=1e-9)
    assert number_scores(trivial, "t")["value"][0] == pytest.approx(0.0, abs=1e-12)
    assert score(trivial["actual"], trivial["predicted"], 1e-9)["R2_log"] > 0.6
    assert np.isnan(number_scores(part.assign(scale=0.0), "t")["value"][0])


def test_the_scale_of_a_row_is_that_of_its_case():
    frame = product_law(12).iloc[::-1]
    jet = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
    found = with_scale(wear_of(12).drop(columns="scale"), frame, jet).set_index("case_id")["scale"]
    squared = frame["particle_velocity_y"] ** 2 + 2.0 * 9.81 * 0.25
    scale = 1e3 * frame["archard_constant"] * 4.0 * squared / (2.0 * 0.09)
    np.testing.assert_allclose(found[frame["case_id"]], scale)


def test_every_metric_has_an_interval_over_the_splits_and_on_the_first():
    parts = [wear_of(seed=k).assign(repeat=k) for k in range(5)]
    predictions = pd.concat(parts, ignore_index=True)
    keys = dict(model="ridge", protocol="leakage_free", table="t", split="test", target_unit="mm/s")
    metrics = [score(part["actual"], part["predicted"], 0.3) for part in parts]
    scores = pd.DataFrame(
        [row for k, one in enumerate(metrics) for row in score_rows(one, **keys, repeat=k)]
    )
    over, first = compare(
        pd.concat([scores, number_scores(predictions, "t")]), predictions, 200, 0.8
    ).to_dict("records")
    assert (over["basis"], over["repeats"], first["basis"]) == ("repeated splits", 5, "fixed split")
    for metric, name in METRIC_COLUMNS.items():
        if metric != "R2_number":
            values = [one[metric] for one in metrics]
            expected = np.percentile(values, [10.0, 50.0, 90.0])
            found = [over[name + end] for end in ("_lower", "", "_upper")]
            assert found == pytest.approx(expected)
            assert first[name] == pytest.approx(values[0])
        for one in (over, first):
            assert one[f"{name}_lower"] < one[f"{name}_upper"]


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
