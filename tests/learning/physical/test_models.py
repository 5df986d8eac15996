"""Models on dimensionless groups: no leakage, calibration, noise floor, findings."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from tables import product_law

from abradem.config import read_config, setup_dict
from abradem.learning.comparison import compare, join_tables, number_scores, with_scale
from abradem.learning.physical import noise_floor as noise
from abradem.learning.physical.intervals import calibrate
from abradem.learning.physical.models import (
    BOOSTING,
    NETWORKS,
    POWER_LAW,
    PROCESS,
    all_targets,
    evaluate,
    fit_physical,
    fitted,
    makers,
)
from abradem.learning.physical.problem import problem
from abradem.learning.physical.reach import extrapolate, learning_curve, sizes
from abradem.learning.physical.sensitivity import (
    PAPER,
    partial_dependence,
    permutation,
    sobol,
    verdict,
)
from abradem.learning.protocols import folds, repeated_splits
from abradem.learning.regions import error_by_region
from abradem.learning.scores import r2
from abradem.quantities import STDERR_COLUMNS, WEAR_COLUMNS
from abradem.report import findings as findings_module
from abradem.report.findings import findings, to_html
from abradem.surrogate.groups import Jet, jet_of
from abradem.wear.replicates import choose_cases, replicate

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
QUICK = {"boosting": {"trees": 60, "depth": 3}, "networks": {"members": 2, "steps": 600}}
HASTY = {"boosting": {"trees": 5}, "networks": {"members": 1, "hidden": (8,), "steps": 20}}
AUTHORS_TABLE = "ABRADEM_AUTHORS_TABLE"


def law(n=150, scatter=0.05, seed=0):
    """Wear of a smooth law with noise, and the standard error of the noise."""
    table = product_law(n, scatter, seed)
    return table.assign(wear_total_mean_stderr=scatter * table["wear_total_mean"])


@pytest.fixture(scope="module")
def given():
    return problem(law(), JET)


@pytest.fixture(scope="module")
def few():
    """A smaller table, for what does not depend on how well the models learn."""
    return problem(law(60), JET)


@pytest.fixture(scope="module")
def process(given):
    everything = np.arange(len(given.log_number))
    return makers(1)[PROCESS]().fit(given.groups[everything], given.log_number, given.error)


def median_r2(results, model, split="test"):
    rows = results.scores.query("model == @model and split == @split and metric == 'R2'")
    return rows["value"].median()


# Evaluation


def test_every_model_learns_a_smooth_law(given):
    models = makers(1, **QUICK)
    results = evaluate(given, models, repeats=2, seed=1)
    least = {POWER_LAW: 0.9, PROCESS: 0.97, BOOSTING: 0.85, NETWORKS: 0.8}
    for name, bound in least.items():
        assert median_r2(results, name) > bound
        assert median_r2(results, name) < 1.0


def test_no_model_sees_the_test_rows(given):
    # If a test row were used, changing its target would change its prediction.
    _, test = next(repeated_splits(given.table.keys, given.table.groups, 0.2, 1, 1))
    spoiled = given.log_number.copy()
    spoiled[test] += 5.0
    models = makers(1, **HASTY)
    before = evaluate(given, models, repeats=1, seed=1).predictions
    after = evaluate(given._replace(log_number=spoiled), models, repeats=1, seed=1).predictions
    np.testing.assert_array_equal(before["predicted"], after["predicted"])


def test_the_wear_constant_is_an_exact_factor(given, process):
    doubled = law().assign(archard_constant=lambda t: 2.0 * t["archard_constant"])
    doubled["wear_total_mean"] *= 2.0
    doubled["wear_total_mean_stderr"] *= 2.0
    other = problem(doubled, JET)
    np.testing.assert_allclose(other.log_number, given.log_number, atol=1e-12)
    np.testing.assert_array_equal(other.groups, given.groups)
    rows = np.arange(5)
    np.testing.assert_allclose(
        other.wear(rows, process.predict(other.groups[rows])),
        2.0 * given.wear(rows, process.predict(given.groups[rows])),
    )


def test_targets_that_are_not_positive_are_raised_and_counted():
    table = law(30)
    table["wear_total_p99"] = table["wear_total_mean"]
    table.loc[[3, 7], "wear_total_p99"] = 0.0
    found = problem(table, JET, "wear_total_p99")
    assert found.raised == 2 and np.isfinite(found.log_number).all()
    with pytest.raises(ValueError, match="nowhere positive"):
        problem(table.assign(wear_total_p99=0.0), JET, "wear_total_p99")
    scores = all_targets(table, JET, {POWER_LAW: makers(1)[POWER_LAW]}, repeats=2)
    assert set(scores["target"]) == {"wear_total_mean", "wear_total_p99"}
    assert scores.set_index("target")["raised"]["wear_total_p99"] == 2


# Intervals


def test_intervals_hold_what_they_promise(given):
    calibration, _, scores, summary = calibrate(given, 10, 1)
    assert summary["in_band"]
    assert scores["case_id"].tolist() == given.table.keys.tolist() and (scores["score"] > 0).all()
    conformal = calibration[calibration["method"] == "conformal"]
    assert (np.diff(conformal["coverage"]) >= 0.0).all()
    assert (np.diff(conformal["width"]) > 0.0).all()
    # The noise is 5 %: half of the new rows are within about .67 times that.
    half = conformal[conformal["level"] == 0.5]["width"].iloc[0]
    assert 0.02 < half < 0.08


# Noise


def test_the_noise_floor_is_what_a_perfect_model_scores():
    rng = np.random.default_rng(0)
    true = np.exp(rng.standard_normal(4000))
    noisy = true * (1.0 + 0.1 * rng.standard_normal(4000))
    dataset = pd.DataFrame(
        {"case_id": np.arange(4000), "wear_total_mean": noisy,
         "wear_total_mean_stderr": 0.2 * noisy}
    )  # fmt: skip
    # The standard errors are twice too large, which the replicates reveal.
    chosen = np.repeat(np.arange(40), 10)
    repeated = true[chosen] * (1.0 + 0.1 * rng.standard_normal(400))
    replicates = pd.DataFrame(
        {"case_id": chosen, "wear_total_mean": repeated, "wear_total_mean_stderr": 0.2 * repeated}
    )
    per_case, summary = noise.noise_floor(replicates, dataset)
    assert summary["degrees_of_freedom"] == 400 and len(per_case) == 40
    assert summary["ratio"] == pytest.approx(0.25, rel=0.2)
    low, high = summary["r2_floor_band"]
    assert low < summary["r2_floor"] < high
    assert low < r2(noisy, true) < high
    assert summary["r2_floor_of_stated_errors"] < low


@pytest.mark.parametrize("spread", [0.0, 0.8])
def test_the_band_of_the_ratio_holds_its_mean_whether_it_varies_or_not(spread):
    # Ten cases of nine simulations; the true ratios are log-normal with mean 1.
    rng = np.random.default_rng(2)
    hits = {"scatter": 0, "same ratio": 0}
    for _ in range(1000):
        true = np.exp(spread * rng.standard_normal(10) - 0.5 * spread**2)
        found = true * rng.chisquare(8, 10) / 8
        mean, (low, high) = noise.mean_ratio(found, np.full(10, 8), 0.95)
        assert low < mean < high
        hits["scatter"] += low <= 1.0 <= high
        hits["same ratio"] += (
            80 / stats.chi2.ppf(0.975, 80) <= 1.0 / mean <= 80 / stats.chi2.ppf(0.025, 80)
        )
    assert hits["scatter"] >= (920 if spread == 0.0 else 850)
    # A band for the same ratio in all cases does not hold one that varies.
    assert (hits["same ratio"] > 900) == (spread == 0.0)


def test_a_single_case_has_no_band():
    mean, band = noise.mean_ratio(np.array([1.5]), np.array([8]), 0.95)
    assert mean == 1.5 and np.isnan(band).all()


def test_the_noise_floor_is_that_of_the_target():
    # The worst element has ten times the noise of the mean, which both errors state.
    rng = np.random.default_rng(1)
    true = np.exp(rng.standard_normal(3000))
    keys = np.arange(3000)
    chosen = np.repeat(np.arange(40), 10)

    def simulated(keys):
        found = {"case_id": keys}
        for name, scatter in (("wear_total_mean", 0.02), ("wear_total_max", 0.2)):
            found[name] = true[keys] * (1.0 + scatter * rng.standard_normal(keys.size))
            found[f"{name}_stderr"] = scatter * true[keys]
        return pd.DataFrame(found)

    dataset, replicates = simulated(keys), simulated(chosen)
    for target, scatter in (("wear_total_mean", 0.02), ("wear_total_max", 0.2)):
        _, summary = noise.noise_floor(replicates, dataset, target)
        assert summary["target"] == target
        assert summary["ratio"] == pytest.approx(1.0, abs=0.25)
        assert summary["median_relative_stderr"] == pytest.approx(scatter, rel=0.05)
        low, high = summary["r2_floor_band"]
        assert low < r2(dataset[target].to_numpy(), true) < high
    # Elements that were not hit have neither a relative error nor a logarithm.
    dataset.loc[0, "wear_total_max"] = 0.0
    _, summary = noise.noise_floor(replicates, dataset, "wear_total_max")
    assert np.isnan(summary["r2_log_floor"]) and np.isfinite(summary["median_relative_stderr"])
    assert np.isfinite(summary["r2_floor"])


def test_each_target_is_weighted_by_its_own_error():
    table = product_law(60)
    for place, name in enumerate(("wear_total_mean", "wear_total_max", "wear_friction_p99")):
        table[name] = table["wear_total_mean"]
        table[f"{name}_stderr"] = (0.02 + 0.01 * place) * table[name]
        np.testing.assert_allclose(problem(table, JET, name).error, 0.02 + 0.01 * place)
    # What is 0, or has no error, gets the largest one.
    table["wear_total_max_stderr"] *= np.linspace(1.0, 2.0, 60)
    table.loc[3, ["wear_total_max", "wear_total_max_stderr"]] = 0.0, 0.5
    table.loc[5, "wear_total_max_stderr"] = np.nan
    error = problem(table, JET, "wear_total_max").error
    assert error[3] == error[5] == error[59] == pytest.approx(0.06)
    # Without the column, as in a table from elsewhere, rows count alike.
    without = table.drop(columns="wear_total_max_stderr")
    assert not problem(without, JET, "wear_total_max").error.any()


def test_replicates_are_of_cases_with_large_particles_and_differ_by_seed_alone():
    from abradem.config import Config, sampled_ranges, setup_dict
    from abradem.sampling.draw import block_cases

    config = Config(study="a")
    ranges = {**sampled_ranges(config), "particle_radius": (0.03, 0.04)}
    cases = block_cases(1, 0, 10, "lhs", ranges)
    cases.loc[0, "rejected"] = "no"
    chosen = choose_cases(cases, 2)
    assert len(chosen) == 2 and 0 not in set(chosen["case_id"])
    assert chosen["particle_radius"].min() >= cases["particle_radius"].iloc[1:].median()
    setup = {**setup_dict(config), "window": 1.0, "max_time": 2.0, "facet_size": 0.03}
    found = replicate(chosen.iloc[:1], 2, setup)
    assert found["seed"].nunique() == 2 and found["wear_total_mean"].nunique() == 2
    # Every wear rate and its error can be the target.
    rates = [*WEAR_COLUMNS, *STDERR_COLUMNS]
    assert list(found) == ["case_id", "replicate", "seed", *rates]
    assert np.isfinite(found[rates]).all(axis=None)
    coarse = replicate(chosen.iloc[:1], 2, setup, {"element_size": 0.06})
    assert (coarse["wear_total_max"] < found["wear_total_max"]).all()
    assert (coarse["wear_total_mean"] == found["wear_total_mean"]).all()
    assert list(replicate(chosen.iloc[:0], 2, setup)) == list(found)
    again = replicate(chosen.iloc[:1], 2, setup)
    pd.testing.assert_frame_equal(found, again)


# Sensitivity


def test_the_quantities_of_a_planted_law_are_found(given, process):
    indices = sobol(process, given, points=512, draws=8, seed=1)
    falls = permutation(given, repeats=1, seed=1)
    wear = indices[indices["explained"] == "wear"].set_index("feature")
    planted = {"archard_constant", "particle_velocity_y", "plate_angle"}
    assert set(wear["total"].nlargest(3).index) == planted
    assert set(falls.set_index("feature")["fall"].nlargest(3).index) == planted
    others = wear.drop(index=list(planted))
    assert (others["total"] < 0.03).all()
    assert (wear["total"] >= wear["first"] - 0.05).all()
    # The logarithm of the law is a sum, so the first-order indices add up to 1.
    assert indices.query("explained == 'log wear'")["first"].sum() == pytest.approx(1.0, abs=0.06)
    found = verdict(indices)
    assert planted <= set(found["dominant"])
    assert found["agrees"] == (set(found["dominant"]) == set(PAPER))
    assert set(found["shared"]) == set(found["dominant"]) & set(PAPER)


def test_sobol_intervals_follow_from_the_seed_alone(given, process):
    options = {"points": 64, "draws": 10, "seed": 1}
    first = sobol(process, given, **options)
    pd.testing.assert_frame_equal(first, sobol(process, given, **options))


def test_sobol_intervals_are_wider_where_the_model_is_less_sure(given, process):
    # The same law from a sixth of the rows.
    widths = []
    for model in (fitted(makers(1)[PROCESS], given, np.arange(25)), process):
        found = sobol(model, given, points=256, draws=12, seed=1).query("explained == 'log wear'")
        assert (found["total_lower"] <= found["total"]).all()
        assert (found["total"] <= found["total_upper"]).all()
        widths.append((found["total_upper"] - found["total_lower"]).sum())
    assert widths[0] > 1.5 * widths[1]


def test_partial_dependence_follows_the_law(given, process):
    found = partial_dependence(process, given)
    rows = found[found["feature"] == "archard_constant"]
    np.testing.assert_allclose(
        rows["predicted"] / rows["setting"], (rows["predicted"] / rows["setting"]).iloc[0]
    )
    rows = found[found["feature"] == "particle_velocity_y"]
    expected = rows["setting"] ** 2 + 5.0
    ratio = (rows["predicted"] / expected).to_numpy()
    assert ratio.max() / ratio.min() < 1.3


# Reach


def test_more_rows_do_not_harm():
    assert sizes(160) == [25, 50, 100, 160] and sizes(20) == [20]
    given = problem(law(120), JET)
    curve = learning_curve(given, {PROCESS: makers(1)[PROCESS]}, repeats=3, seed=1)
    assert list(curve["trained"]) == [25, 50, 96]
    assert curve["r2"].iloc[-1] > curve["r2"].iloc[0]


def test_rows_beyond_a_bound_are_not_trained_on(given):
    models = {POWER_LAW: makers(1)[POWER_LAW], PROCESS: makers(1)[PROCESS]}
    found = extrapolate(given, models, seed=1)
    assert set(found["test"]) == {"fast", "steep", "large"}
    velocity = given.inputs[:, -1]
    fast = found[found["test"] == "fast"].iloc[0]
    assert fast["tested"] == (velocity < -8.0).sum() and fast["trained"] == (velocity >= -8.0).sum()
    assert found.query("model == 'gaussian_process'")["coverage"].between(0.0, 1.0).all()
    assert found.query("model == 'power_law'")["coverage"].isna().all()
    few = extrapolate(problem(law(12), JET), {POWER_LAW: models[POWER_LAW]})
    assert list(few.columns) == list(found.columns)


# Findings


FRESH = {
    "cases": 200,
    "rates": [
        {"target": "wear_total_max", "in_band": 23, "shares": 24, "expected": 22.58, "in_joint": 21,
         "scores": {"R2": 0.9876, "R2_number": 0.9}},
        {"target": "wear_total_mean", "in_band": 22, "shares": 24, "in_joint": 24},
    ],
}  # fmt: skip


def test_the_findings_repeat_the_numbers(few):
    models = makers(1, **HASTY)
    results, exponents, summary, (description, arrays) = fit_physical(few, models, repeats=2)
    predictions = with_scale(results.predictions, law(60), JET)
    scores = join_tables([results.scores, number_scores(predictions, "t")])
    comparison = compare(scores, predictions, draws=100)
    assert description["kind"] == "gaussian_process" and "rows" in arrays
    assert {"quantity", "group"} == set(exponents["kind"])
    intervals = calibrate(few, 3).summary
    curve = learning_curve(few, {POWER_LAW: models[POWER_LAW]}, repeats=2)
    floor = {"r2_floor": 0.999, "r2_floor_band": [0.998, 0.9995], "replicates": 8, "cases": 2,
             "r2_floor_of_stated_errors": 0.9985, "ratio": 1.5}  # fmt: skip
    speed = {"simulated_seconds": {"mean": 2.0, "median": 0.1}, "cases": [1], "radii": [0.02],
             "batch": 10, "predicted_seconds": 1e-4, "predictions_per_second": 1e6, "speed_up": 2e4,
             "speed_up_of_a_batch": 2e6}  # fmt: skip
    process = fitted(models[PROCESS], few, np.arange(len(few.log_number)))
    indices = sobol(process, few, points=64, draws=5, seed=1)
    falls = permutation(few, repeats=1, seed=1)
    text = dict(
        findings(
            summary, intervals, {"scores": summary["scores"][PROCESS]}, verdict(indices),
            curve, extrapolate(few, models), indices, falls, comparison,
            error_by_region(predictions, law(60)), FRESH, floor,
            speed,
        )
    )  # fmt: skip
    best = summary["scores"][PROCESS]["test"]["R2"]["median"]
    assert f"Gaussian process {best:.4f}" in text["Comparison"]
    assert f"is {0.999 - best:.4f} below this limit" in text["Comparison"]
    low = {**floor, "r2_floor": 0.2, "r2_floor_band": [0.1, 0.3]}
    assert findings_module._beside_limit(0.25, low).endswith(
        "0.0500 above the estimate and within its band."
    )
    assert findings_module._beside_limit(0.35, low).endswith(
        "0.1500 above the estimate and above its band."
    )
    number = comparison.set_index("model").loc[PROCESS].iloc[0]["r2_number"]
    assert "the part that they learn: power law" in text["Comparison"]
    assert f"Gaussian process {number:.4f} (" in text["Comparison"]
    assert "20 thousand times faster" in text["Speed"]
    regions = intervals["regions"]
    assert (
        f"{regions['in_band']} of 24 shares are in their binomial bands (of intervals that hold "
        f"exactly, {regions['expected']:.1f} are on average), and {regions['in_joint']} of 24 in "
        "the joint bands"
    ) in text["Intervals"]
    assert (
        "23 of 24 shares are in their binomial bands (of intervals that hold exactly, 22.6 are on "
        "average), and 21 of 24 in the joint bands"
    ) in text["Intervals"]
    assert "at once in 95 of 100 studies; R2 of the wear is there 0.9876" in text["Intervals"]
    assert text["Intervals"].endswith(
        "places of the plate: mean over the plate 22 of 24 one by one, 24 jointly."
    )
    assert summary["equation"] in text["Power law"]
    assert "Archard wear constant (" in text["Sensitivity"]
    assert f"causes the largest fall of R2 ({falls['fall'].max():.2f})" in text["Sensitivity"]
    page = to_html("<t>", list(text.items()))
    assert "&lt;t&gt;" in page and "script" not in page


def test_tables_too_small_for_anything_still_give_results():
    small = problem(law(12), JET)
    models = makers(1, **HASTY)
    results, *_ = fit_physical(small, models, repeats=2)
    assert results.scores["model"].nunique() == 5
    calibrate(small, 3)


@pytest.mark.skipif(AUTHORS_TABLE not in os.environ, reason=f"{AUTHORS_TABLE} names no file")
def test_half_of_the_published_table_is_predicted_in_cross_validation():
    """As docs/notes/learning.md says, with the plate of the default study."""
    from abradem.dataset.external import read_external

    jet = jet_of(setup_dict(read_config(Path(__file__).parents[3] / "config.yaml")))
    given = problem(read_external(os.environ[AUTHORS_TABLE]), jet)
    found = []
    for seed in range(4):
        predicted = np.empty(len(given.log_number))
        for train, test in folds(given.table.groups, 5, seed):
            predicted[test] = fitted(makers(1)[PROCESS], given, train).predict(given.groups[test])
        found.append(r2(given.table.target, given.wear(np.arange(len(predicted)), predicted)))
    assert np.mean(found) == pytest.approx(0.975, abs=0.002)
