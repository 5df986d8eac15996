"""The linear model: known coefficients are recovered; too few rows are reported."""

import json

import numpy as np
import pandas as pd
import pytest

from abradem.dataset.features import derive
from abradem.learning.baselines import linear
from abradem.learning.model_files import write_stage
from abradem.learning.protocols import published_split
from abradem.learning.published import EQUATION
from abradem.learning.rows import standard_scaler
from abradem.learning.scores import SCORE_COLUMNS
from abradem.quantities import FEATURE_NAMES, SAMPLED, SAMPLED_NAMES, TARGET
from abradem.store.files import read_json
from abradem.store.tables import read_table, read_units


def sampled(n, seed=0, **fixed):
    """A table of ``n`` random cases within the paper's ranges, with features, without target."""
    rng = np.random.default_rng(seed)
    cases = pd.DataFrame({row.name: rng.uniform(*row.paper_range, n) for row in SAMPLED}).assign(
        **fixed
    )
    return derive(cases).assign(case_id=np.arange(n))


def with_target(table, noise=0.0, seed=1):
    """Wear linear in X12, X13 and X16 (in standard deviations .5, .3, -.6), plus noise."""
    y = 2.0 + sum(
        share * (table[name] - table[name].mean()) / table[name].std(ddof=0)
        for name, share in PLANTED.items()
    )
    return table.assign(
        **{TARGET.name: y + noise * np.random.default_rng(seed).standard_normal(len(y))}
    )


def leakage_free(result):
    """Held-out predictions of the leakage-free protocol."""
    return result.predictions.query("protocol == 'leakage_free'")


PLANTED = {"archard_constant": 0.5, "plate_angle": 0.3, "particle_velocity_y": -0.6}


def test_planted_coefficients_are_recovered_without_noise():
    table = with_target(sampled(120))
    result = linear.fit_linear(table, repeats=5)
    rows = result.coefficients.set_index("feature")
    scale = table[TARGET.name].std(ddof=0)
    for name in FEATURE_NAMES:
        assert rows.loc[name, "coefficient"] == pytest.approx(
            PLANTED.get(name, 0.0) / scale, abs=1e-9
        )
    test = result.scores.query("split == 'test' and metric == 'R2' and protocol == 'leakage_free'")[
        "value"
    ]
    assert len(test) == 5 and (test > 1.0 - 1e-9).all()


def test_intervals_cover_planted_coefficients_as_often_as_they_claim():
    table = sampled(100)
    covered = []
    for seed in range(60):
        y = with_target(table, 0.5, seed)[TARGET.name].to_numpy()
        fit = linear.least_squares(table[list(FEATURE_NAMES)].to_numpy(), y)
        truth = np.array([PLANTED.get(name, 0.0) for name in FEATURE_NAMES]) / fit.of_target.scale
        reach = 1.9905 * fit.standard_error  # t quantile of 95 % with 79 degrees of freedom
        covered.append(np.abs(fit.coefficients - truth) <= reach)
        assert fit.degrees_of_freedom == 79
    assert 0.93 < np.mean(covered) < 0.985


def test_intervals_hold_when_scatter_grows_with_a_feature():
    rng = np.random.default_rng(5)
    hits, naive = 0, 0
    for _ in range(300):
        x = rng.standard_normal((80, 2))
        y = x[:, 0] + rng.standard_normal(80) * x[:, 0] ** 2
        fit = linear.least_squares(x, y)
        slope = fit.coefficients[0] * fit.of_target.scale / fit.of_features.scale[0]
        error = fit.standard_error[0] * fit.of_target.scale / fit.of_features.scale[0]
        hits += abs(slope - 1.0) <= 1.99 * error
        centred = x - x.mean(axis=0)
        residual = y - linear.predict_linear(fit, x)
        textbook = np.sqrt(residual @ residual / 77 * np.linalg.inv(centred.T @ centred)[0, 0])
        naive += abs(slope - 1.0) <= 1.99 * textbook
    assert hits / 300 > 0.89
    assert naive / 300 < 0.80


def test_the_fit_equals_ordinary_least_squares():
    table = with_target(sampled(60), noise=0.3)
    x, y = table[list(FEATURE_NAMES)].to_numpy(), table[TARGET.name].to_numpy()
    fit = linear.least_squares(x, y)
    z = (x - x.mean(axis=0)) / x.std(axis=0)
    design = np.column_stack([np.ones(60), z])
    expected = design @ np.linalg.lstsq(design, y, rcond=None)[0]
    np.testing.assert_allclose(linear.predict_linear(fit, x), expected, rtol=1e-9)
    assert fit.rank == 20 and fit.condition_number > 20


def test_a_dozen_cases_give_a_minimal_norm_fit_that_says_what_is_missing():
    result = linear.fit_linear(with_target(sampled(12), 0.2))
    assert np.isfinite(result.coefficients["coefficient"]).all()
    assert result.coefficients[["standard_error", "lower", "upper"]].isna().all(axis=None)
    assert not result.coefficients["identified"].any()
    assert result.summary["rank"] == 11
    notes = " ".join(result.summary["notes"])
    assert "least norm" in notes and "no intervals" in notes and "9 training rows" in notes
    assert result.summary["splits"] == {
        "rows": 12, "train": 9, "test": 3, "repeats": 50, "test_share": 0.2, "seed": 0,
    }  # fmt: skip


@pytest.mark.parametrize("n", [3, 4, 5, 21, 22, 23])
def test_any_number_of_cases_from_three_is_fitted(n):
    result = linear.fit_linear(with_target(sampled(n), 0.2), repeats=3)
    assert np.isfinite(result.predictions["predicted"]).all()


def test_a_fixed_quantity_has_no_effect_and_no_interval_and_spares_the_others():
    result = linear.fit_linear(
        with_target(sampled(100, particle_poisson_ratio=0.3), 0.2), repeats=3
    )
    rows = result.coefficients.set_index("feature")
    fixed = rows.loc["particle_poisson_ratio"]
    assert np.isnan(fixed["coefficient"]) and fixed["variation"] == "held fixed"
    # With a fixed Poisson's ratio E is a multiple of G: neither coefficient is determined.
    lost = {"particle_poisson_ratio", "particle_youngs_modulus", "particle_shear_modulus"}
    assert set(rows.index[~rows["identified"]]) == lost
    assert set(rows.index[rows["lower"].isna()]) == lost
    assert any("X3" in note for note in result.summary["notes"])
    assert result.summary["rank"] == 18


def test_held_out_rows_do_not_touch_the_fit_that_predicts_them():
    table = with_target(sampled(60), 0.3)
    first = leakage_free(linear.fit_linear(table, repeats=4))
    held = set(first.loc[first["repeat"] == 0, "case_id"])
    changed = table.copy()
    changed.loc[changed["case_id"].isin(held), TARGET.name] += 50.0
    second = leakage_free(linear.fit_linear(changed, repeats=4))
    np.testing.assert_array_equal(
        first.loc[first["repeat"] == 0, "predicted"], second.loc[second["repeat"] == 0, "predicted"]
    )


def test_the_order_of_rows_does_not_matter_and_the_seed_does():
    table = with_target(sampled(40), 0.3)
    one = linear.fit_linear(table, repeats=3, seed=1)
    same = linear.fit_linear(table.sample(frac=1.0, random_state=3), repeats=3, seed=1)
    other = linear.fit_linear(table, repeats=3, seed=2)
    pd.testing.assert_frame_equal(one.predictions, same.predictions)
    pd.testing.assert_frame_equal(one.scores, same.scores)
    assert one.summary["dataset_hash"] == same.summary["dataset_hash"]
    assert not one.predictions["case_id"].equals(other.predictions["case_id"])


def test_the_equation_names_all_symbols_with_their_signs():
    result = linear.fit_linear(with_target(sampled(100)), repeats=2)
    assert result.equation.startswith("X21 = 0.000 ")
    rows = result.coefficients.set_index("symbol")["coefficient"]
    for symbol in ("X12", "X16"):
        sign = "-" if rows[symbol] < 0 else "+"
        assert f"{sign} {abs(rows[symbol]):.3f} {symbol}" in result.equation
    assert sum(f" X{i}" in result.equation for i in range(1, 21)) == 20


TABLES = ("coefficients", "residuals", "published", "scores", "predictions")


def test_artefacts_are_plain_complete_and_the_same_every_time(tmp_path):
    for folder in ("a", "b"):
        table = with_target(sampled(12), 0.2)
        names = {
            "summary": "linear.json", "summary_arrays": "linear.safetensors",
            **{name: f"{name}.parquet" for name in TABLES},
        }  # fmt: skip
        paths = {key: tmp_path / folder / names[key] for key in names}
        write_stage(paths, **linear.train(table, "wear_total_mean", "dataset", repeats=3))
    for name in names.values():
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    model = read_json(tmp_path / "a" / "linear.json")
    assert json.dumps(model)
    assert [feature["symbol"] for feature in model["features"]] == [f"X{i}" for i in range(1, 21)]
    assert model["target"]["name"] == "wear_total_mean" and model["target"]["unit"] == "mm/s"
    assert list(read_table(tmp_path / "a" / "scores.parquet")) == SCORE_COLUMNS
    assert read_units(tmp_path / "a" / "predictions.parquet")["predicted"] == "mm/s"


def test_the_stored_model_predicts_as_the_fit_does():
    table = with_target(sampled(80), 0.3)
    model = linear.fit_linear(table, repeats=2).summary
    x = table[list(FEATURE_NAMES)].to_numpy()
    z = sum(
        f["coefficient"] * (x[:, i] - f["mean"]) / f["scale"]
        for i, f in enumerate(model["features"])
    )
    fit = linear.least_squares(x, table[TARGET.name].to_numpy())
    np.testing.assert_allclose(
        model["target"]["mean"] + model["target"]["scale"] * z,
        linear.predict_linear(fit, x),
        rtol=1e-10,
    )


def test_bad_input_is_named():
    table = with_target(sampled(10))
    with pytest.raises(ValueError, match="lacks the target wear_other"):
        linear.fit_linear(table, target="wear_other")
    with pytest.raises(ValueError, match="must be finite"):
        linear.fit_linear(table.assign(plate_angle=np.nan))
    with pytest.raises(ValueError, match="confidence"):
        linear.fit_linear(table, confidence=1.0)
    with pytest.raises(ValueError, match="too few"):
        linear.fit_linear(table.iloc[:2])


def test_all_sampled_features_are_features():
    assert set(SAMPLED_NAMES) < set(FEATURE_NAMES)


def test_variance_inflation_is_that_of_a_regression_on_the_others():
    rng = np.random.default_rng(0)
    x = rng.standard_normal((400, 3))
    x[:, 2] = x[:, 0] + 0.5 * rng.standard_normal(400)
    r = np.corrcoef(x, rowvar=False)
    np.testing.assert_allclose(linear.variance_inflation(x), np.diag(np.linalg.inv(r)), rtol=1e-9)
    x[:, 2] = x[:, 0] - 2.0 * x[:, 1]
    assert np.isinf(linear.variance_inflation(x)).all()
    x[:, 2] = 7.0
    assert np.isnan(linear.variance_inflation(x)[2])
    assert linear.variance_inflation(x)[0] == pytest.approx(1.0, abs=0.05)


def test_studentised_residuals_have_unit_spread_and_follow_the_normal_quantiles():
    rows = linear.fit_linear(with_target(sampled(400), 0.4), repeats=1).residuals
    assert rows["studentised"].std() == pytest.approx(1.0, abs=0.02)
    assert np.corrcoef(rows["studentised"], rows["normal_quantile"])[0, 1] > 0.99
    assert (rows["studentised"].rank() == rows["normal_quantile"].rank()).all()
    # Without a degree of freedom the residual variance cannot be estimated.
    few = linear.fit_linear(with_target(sampled(12), 0.2), repeats=1).residuals
    assert few[["studentised", "normal_quantile"]].isna().all(axis=None)


def test_the_leverages_add_up_to_the_number_of_coefficients():
    rows = linear.fit_linear(with_target(sampled(60), 0.2), repeats=1).residuals
    assert rows["leverage"].sum() == pytest.approx(21.0)


def test_the_test_of_even_scatter_rejects_as_often_as_it_claims():
    rng = np.random.default_rng(0)
    even, uneven = 0, 0
    for _ in range(200):
        x = rng.standard_normal((150, 3))
        noise = rng.standard_normal(150)
        even += linear.breusch_pagan(x, noise)["p_value"] < 0.05
        uneven += linear.breusch_pagan(x, noise * np.exp(0.5 * x[:, 0]))["p_value"] < 0.05
    assert 2 <= even <= 20 and uneven > 150


def test_the_statistic_of_even_scatter_is_rows_times_r2_of_squared_residuals():
    rng = np.random.default_rng(3)
    x, residual = rng.standard_normal((50, 2)), rng.standard_normal(50)
    design = np.column_stack([np.ones(50), x])
    squared = residual**2
    rest = squared - design @ np.linalg.lstsq(design, squared, rcond=None)[0]
    found = linear.breusch_pagan(x, residual)
    assert found["statistic"] == pytest.approx(50 * (1 - rest.var() / squared.var()))
    assert found["degrees_of_freedom"] == 2


def test_as_published_scales_over_all_rows_and_says_so():
    result = linear.fit_linear(with_target(sampled(60), 0.3), repeats=2)
    rows = result.scores.query("protocol == 'as_published' and split == 'test'")
    assert len(rows.query("metric == 'R2'")) == 1
    assert set(result.predictions["protocol"]) == {"leakage_free", "as_published"}
    assert set(result.published["verdict"]) == {"another table"}
    assert result.summary["misprints"] is None


def test_the_misprints_of_the_printed_equation_are_found_where_the_refit_is_its_own():
    """A table of the paper's size whose refit is the printed equation except for four numbers."""
    table = sampled(198)
    z = standard_scaler(table[list(FEATURE_NAMES)].to_numpy()).forward(
        table[list(FEATURE_NAMES)].to_numpy()
    )
    slopes = np.array(EQUATION)
    slopes[[1, 4, 8, 16]] = [-0.164, 1.650, 0.210, 0.218]
    train, test = published_split(198, 0.2)
    wear = z @ slopes
    # Noise orthogonal to the fit of the training rows, a shift of the test rows that gives the
    # intercept, and a standard deviation of 1 for both together.
    design = np.column_stack([np.ones(len(train)), z[train]])
    scatter = np.random.default_rng(0).standard_normal(len(train))
    scatter -= design @ np.linalg.lstsq(design, scatter, rcond=None)[0]
    wear[test] += 0.019 * 198 / len(test)
    size = (198 * (1.0 + 0.019**2) - np.sum(wear**2)) / np.sum(scatter**2)
    wear[train] += np.sqrt(size) * scatter
    summary = linear.fit_linear(table.assign(**{TARGET.name: 20.0 + wear}), repeats=1).summary
    assert summary["misprints"] == [
        "X2: printed +0.164, refitted -0.164 (misprinted sign)",
        "X5: printed +1.640, refitted +1.650 (misprinted value)",
        "X9: printed +0.290, refitted +0.210 (misprinted value)",
        "X17: printed -0.218, refitted +0.218 (misprinted sign)",
    ]
