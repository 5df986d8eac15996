"""Lasso, ridge, PCA, feature selection and trees on data with a known law."""

import numpy as np
import pytest
from tables import PLANTED, linear_law, product_law

from abradem.figures.pca import draw_correlations
from abradem.learning.baselines import linear
from abradem.learning.baselines.pca import fit_pca, principal_components, regress
from abradem.learning.baselines.penalised import choose_alpha, fit_penalised, weights
from abradem.learning.baselines.selection import fit_selection, select
from abradem.learning.baselines.trees import choose_penalty, fit_trees, grow
from abradem.learning.model_files import Model, predict_trees, tree_arrays
from abradem.learning.protocols import published_split
from abradem.learning.rows import learning_table, standard_scaler
from abradem.quantities import FEATURE_NAMES

REPEATS = {"repeats": 4, "seed": 1}


@pytest.fixture(scope="module")
def table():
    return learning_table(linear_law(160, noise=0.3))


@pytest.fixture(scope="module")
def penalised(table):
    return fit_penalised(table, **REPEATS)


@pytest.fixture(scope="module")
def principal(table):
    return fit_pca(table, **REPEATS)


@pytest.fixture(scope="module")
def trees():
    return fit_trees(learning_table(product_law(160)), forest_trees=30, **REPEATS)


def r2(results, model, protocol, split="test"):
    rows = results.scores.query(
        "model == @model and protocol == @protocol and split == @split and metric == 'R2'"
    )
    return rows["value"].to_numpy()


# The target


@pytest.mark.parametrize("target", ["wear_friction_p99", "wear_sliding_mean"])
def test_correlations_name_the_target_that_was_learned(target):
    rows = linear_law(60).rename(columns={"wear_total_mean": target})
    found = fit_pca(learning_table(rows, target), repeats=1).correlations
    mine = found[(found["feature"] == target) & (found["other"] == "archard_constant")].iloc[0]
    assert mine["symbol"] == "X21"
    expected = np.corrcoef(rows[target], rows["archard_constant"])[0, 1]
    assert mine["correlation"] == pytest.approx(expected)
    figure = draw_correlations(found, {"training_rows": 60})
    ticks = [tick.get_text() for panel in figure.axes for tick in panel.get_yticklabels()]
    assert any(tick.startswith("X21") and r"\dot h" in tick for tick in ticks)


# Lasso and ridge


def test_ridge_weights_are_those_of_the_normal_equations(table):
    z = standard_scaler(table.features).forward(table.features)
    v = standard_scaler(table.target).forward(table.target)
    (found,) = weights("ridge", z, v, np.array([3.0]))
    expected = np.linalg.solve(z.T @ z + 3.0 * np.eye(20), z.T @ v)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-10)


def test_lasso_of_orthogonal_features_is_soft_thresholding():
    rng = np.random.default_rng(0)
    q, _ = np.linalg.qr(rng.standard_normal((50, 4)) - 0.0)
    q -= q.mean(axis=0)
    q, _ = np.linalg.qr(q)
    x = q * np.sqrt(50)
    y = x @ np.array([1.0, -0.5, 0.05, 0.0])
    (found,) = weights("lasso", x, y, np.array([0.2]))
    # The shared intercept makes columns of zero mean; weights shrink by alpha.
    np.testing.assert_allclose(found, [0.8, -0.3, 0.0, 0.0], atol=1e-3)


def test_lasso_finds_the_planted_features_and_drops_the_others(penalised):
    rows = penalised.weights.query("model == 'lasso'").set_index(["protocol", "feature"])
    for protocol in ("as_published", "leakage_free"):
        kept = rows.loc[protocol]
        assert (kept.loc[list(PLANTED), "survives"] == 1.0).all()
        others = kept.drop(list(PLANTED))
        assert others["weight"].abs().max() < 0.08
        assert np.sign(kept.loc[list(PLANTED), "weight"]).tolist() == [1.0, 1.0, -1.0]
    assert (rows.loc["as_published"].drop(list(PLANTED))["survives"] == 0.0).mean() > 0.8


def test_ridge_keeps_every_feature(penalised):
    rows = penalised.weights.query("model == 'ridge'")
    assert (rows["survives"] == 1.0).all()


def test_paths_begin_with_everything_shrunk_away(penalised):
    for _, rows in penalised.paths.groupby("model"):
        sizes = rows.groupby("alpha")["weight"].apply(lambda w: w.abs().sum())
        assert sizes.iloc[-1] < 0.05 * sizes.iloc[0]


def test_the_penalty_is_chosen_without_the_test_rows(table):
    train, test = published_split(len(table.target), 0.2)
    target = table.target.copy()
    target[test] += 100.0
    first = choose_alpha("lasso", table.features[train], table.target[train], train, 10, 5, 1)
    second = choose_alpha("lasso", table.features[train], target[train], train, 10, 5, 1)
    assert first.alpha == second.alpha


def test_leakage_free_scores_are_close_to_the_law(penalised):
    # With noise of .3 and a law of variance .7 the largest R2 is .89.
    for model in ("lasso", "ridge"):
        assert np.median(r2(penalised.results, model, "leakage_free")) > 0.8


# Components


def test_components_group_the_stiffnesses(principal):
    for words in principal.summary["stiffness"].values():
        assert "X1, X2, X17, X18" in words and "X5, X6" in words


def test_loadings_are_orthonormal_and_variances_add_up(table):
    z = standard_scaler(table.features).forward(table.features)
    parts = principal_components(z)
    np.testing.assert_allclose(parts.axes @ parts.axes.T, np.eye(20), atol=1e-9)
    assert parts.variances.sum() == pytest.approx(z.var(axis=0, ddof=1).sum())


def test_all_components_together_are_least_squares(table):
    fit = linear.least_squares(table.features, table.target)
    np.testing.assert_allclose(
        regress(table.features, table.target, 20)(table.features),
        linear.predict_linear(fit, table.features),
        rtol=1e-6,
    )


def test_the_wrong_target_cannot_be_explained_and_the_right_one_can(principal):
    curve = principal.curve.query("protocol == 'as_published'").set_index("explained")
    assert curve.loc["last component", "r2"].max() < 0.1
    assert curve.loc["wear", "r2"].iloc[-1] > 0.8
    last = curve.loc["last component"].set_index("components")["r2"]
    told = principal.summary["wrong_target"]
    assert {one["components"]: one["r2"] for one in told["r2"]} == {12: last[12], 13: last[13]}
    assert told["all_components"] == {"components": last.index[-1], "r2": last.iloc[-1]}
    assert told["printed"] == -0.21
    assert "leakage_free" not in set(
        principal.results.scores.query("model == 'pca_wrong_target'")["protocol"]
    )


def test_correlations_are_those_of_the_columns(table, principal):
    rows = principal.correlations.set_index(["feature", "other"])["correlation"]
    names = ("particle_youngs_modulus", "particle_shear_modulus")
    columns = [table.features[:, FEATURE_NAMES.index(name)] for name in names]
    assert rows[names] == pytest.approx(np.corrcoef(*columns)[0, 1])
    assert len(rows) == 21 * 21


# Selection


def test_the_planted_features_are_selected_by_weight(table):
    columns, chosen = select(table.features, table.target, 12)
    assert len(columns) == 12
    by_weight = set(chosen.query("chosen_by == 'weight'")["feature"])
    assert set(PLANTED) <= by_weight and len(by_weight) == 6
    stiff = {"particle_youngs_modulus", "particle_shear_modulus"}
    assert stiff <= set(np.array(FEATURE_NAMES)[columns])


def test_selection_states_its_agreement_with_the_paper(table):
    selection, summary = fit_selection(table, **REPEATS)
    for protocol in ("as_published", "leakage_free"):
        found = summary[protocol]
        assert found["shared_with_paper"] + len(found["not_in_paper"]) == 12
        assert found["shared_with_paper"] + len(found["missing_from_paper"]) == 12
    assert selection.groupby("protocol")["survives"].sum().tolist() == pytest.approx([12, 12])


# Trees


def test_the_unscaled_tree_never_splits_on_the_wear_constant(trees):
    assert trees.summary["published_splits_on_wear_constant"] == 0
    leakage_free = trees.importance.query("model == 'tree' and feature == 'archard_constant'")
    assert leakage_free["importance"].iloc[0] > 0.1


def test_deep_trees_fit_their_training_rows_alone(trees):
    deepest = trees.curve.query("depth == 49 and protocol == 'leakage_free'").set_index("split")[
        "r2"
    ]
    assert deepest["train"] > 0.999 and deepest["test"] < 0.9
    assert len(trees.curve.query("protocol == 'as_published'")) == 2 * 49


def test_the_forest_is_a_remedy(trees):
    tree, forest = (np.median(r2(trees.results, m, "leakage_free")) for m in ("tree", "forest"))
    assert forest > tree + 0.05


def test_pruning_removes_what_noise_had_grown():
    rng = np.random.default_rng(2)
    x = rng.uniform(-1.0, 1.0, (120, 3))
    y = np.where(x[:, 0] > 0.0, 1.0, -1.0) + 0.3 * rng.standard_normal(120)
    penalty = choose_penalty(x, y, np.arange(len(y)), 5, 0)
    assert grow(x, y, None, penalty).get_n_leaves() == 2 < grow(x, y).get_n_leaves()


def test_a_large_tree_is_kept_where_it_predicts_best_and_the_root_alone_where_nothing_does():
    rng = np.random.default_rng(1)
    x = rng.uniform(-1.0, 1.0, (800, 3))
    smooth = np.sin(4.0 * x[:, 0]) + x[:, 1] ** 2 * x[:, 0]
    leaves = grow(x, smooth, None, choose_penalty(x, smooth, np.arange(800), 5, 0)).get_n_leaves()
    assert 100 < leaves < grow(x, smooth).get_n_leaves()
    noise = rng.standard_normal(800)
    assert grow(x, noise, None, choose_penalty(x, noise, np.arange(800), 5, 0)).get_n_leaves() == 1


def test_stored_trees_predict_as_the_library_does():
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((60, 4)), rng.standard_normal(60)
    trees = [grow(x, y, depth) for depth in (1, 3, None)]
    rows = rng.standard_normal((30, 4))
    expected = np.mean([tree.predict(rows) for tree in trees], axis=0)
    np.testing.assert_allclose(predict_trees(tree_arrays(trees), rows), expected, rtol=1e-12)


def test_the_drawn_tree_is_the_stored_one(trees):
    nodes = trees.nodes.set_index("node")
    inner = nodes[nodes["left"] >= 0]
    assert nodes.loc[0, "rows"] == 160 and nodes.loc[0, "parent"] == -1
    for node, row in inner.iterrows():
        children = nodes.loc[[row["left"], row["right"]]]
        assert (children["parent"] == node).all() and children["rows"].sum() == row["rows"]
    model = Model(*trees.models["tree"])
    table = product_law(160)
    root = nodes.loc[0]
    leaves = nodes.loc[nodes["left"] < 0, "predicted"].to_numpy()
    predicted = model.predict(table)
    assert all(np.isclose(value, leaves).any() for value in predicted)
    assert np.ptp(table[root["feature"]]) > 0.0


def test_a_fold_of_equal_targets_leaves_a_gap_in_nothing():
    table = linear_law(20)
    # All but a few rows are equal, so that some folds have no R2.
    table["wear_total_mean"] = np.where(np.arange(20) < 16, 1.0, 1.0 + np.arange(20) / 10.0)
    found = fit_penalised(learning_table(table), path_points=5, repeats=1)
    assert np.isfinite(found.validation["mean"]).all()


def test_a_quantity_that_never_varied_does_not_carry_predictions_away():
    rows = linear_law(60, noise=0.3).assign(equipment_density=7000.3)
    elsewhere = rows.assign(equipment_density=20000.0)
    table = learning_table(rows)
    found = fit_pca(table, repeats=1).model, *fit_penalised(table, repeats=1).models.values()
    for description, arrays in found:
        model = Model(description, arrays)
        with pytest.warns(UserWarning, match="equipment_density: 60 of 60 values lie outside"):
            predicted = model.predict(elsewhere)
        np.testing.assert_allclose(predicted, model.predict(rows), rtol=1e-9)
    # A network keeps the initial weights of such a feature.
    column = standard_scaler(np.full((5, 1), 37e9)).forward(np.array([[80e9]]))
    assert np.abs(column).max() < 2.0


def test_intervals_have_the_level_asked_for(table):
    quick = {"repeats": 6, "seed": 1, "fold_count": 2, "confidence": 0.5}
    found = fit_penalised(table, path_points=3, **quick)
    models = [*found.models.values(), fit_pca(table, **quick).model]
    models += fit_trees(table, forest_trees=2, max_depth=2, **quick).models.values()
    for description, _ in models:
        assert description["confidence"] == 0.5
    values = r2(found.results, "ridge", "leakage_free")
    stated = found.models["ridge"][0]["scores"]["test"]["R2"]
    assert [stated["lower"], stated["upper"]] == pytest.approx(np.percentile(values, [25, 75]))


def test_models_of_all_kinds_predict_their_rows(penalised, principal):
    rows = linear_law(160, noise=0.3)
    for description, arrays in (*penalised.models.values(), principal.model):
        predicted = Model(description, arrays).predict(rows)
        error = rows["wear_total_mean"] - predicted
        assert 1.0 - error.var() / rows["wear_total_mean"].var() > 0.85
        assert description["scores"]["test"]["R2"]["median"] > 0.8
        assert len(description["dataset_hash"]) == 64
