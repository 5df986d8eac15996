"""The map surrogate on maps with a known law, and its scores on maps that are known."""

import numpy as np
import pytest
from sklearn.linear_model import Ridge
from tables import product_law

from abradem.learning.physical import wear_maps as module
from abradem.learning.physical.problem import problem
from abradem.learning.physical.wear_maps import PlateSides, fit_maps, map_scores, ridge, wear_maps
from abradem.learning.protocols import repeated_splits
from abradem.surrogate.groups import Jet
from abradem.surrogate.maps import MapSurrogate, second_order, wear_numbers

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
PLATE = PlateSides(0.3, 0.24)
NX, NZ = 10, 8
SPLITS = {"test_share": 0.2, "repeats": 3, "seed": 1}


def spots(given, noise=0.0, seed=0):
    """A spot of wear that moves down the slope with the plate angle, on a thinly worn plate."""
    x = (np.arange(NX) + 0.5) / NX - 0.5
    z = (np.arange(NZ) + 0.5) / NZ - 0.5
    along = 0.3 * given.groups[:, 8] - 0.15
    away = (x[:, None] - along[:, None, None]) ** 2 + z**2
    shape = np.exp(-away / 0.02) + 0.02
    drawn = np.exp(noise * np.random.default_rng(seed).standard_normal(shape.shape))
    maps = shape / shape.mean(axis=(1, 2), keepdims=True) * drawn
    return given.table.target[:, None, None] * maps


@pytest.fixture(scope="module")
def given():
    return problem(product_law(120), JET, "wear_total_mean")


def test_ridge_regression_is_that_of_scikit_learn_with_the_best_penalty():
    rng = np.random.default_rng(0)
    terms = np.column_stack([np.ones(30), rng.standard_normal((30, 4)) * [1.0, 2.0, 3.0, 0.1]])
    targets = terms @ rng.standard_normal((5, 2)) + [0.1, 3.0] * rng.standard_normal((30, 2))
    ours = ridge(terms, targets)
    x = terms[:, 1:] / terms[:, 1:].std(axis=0)
    for place, target in enumerate(targets.T):
        left_out = {}
        for penalty in module.PENALTIES:
            errors = []
            for row in range(30):
                kept = np.arange(30) != row
                model = Ridge(penalty).fit(x[kept], target[kept])
                errors.append(target[row] - model.predict(x[[row]])[0])
            left_out[penalty] = np.sum(np.square(errors))
        best = Ridge(min(left_out, key=left_out.get)).fit(x, target)
        np.testing.assert_allclose(terms @ ours[:, place], best.predict(x), rtol=1e-9)


def test_terms_of_second_order_are_all_products():
    terms = second_order(np.array([[2.0, 3.0]]))
    np.testing.assert_array_equal(terms, [[1.0, 2.0, 3.0, 4.0, 6.0, 9.0]])


def test_maps_of_a_known_law_are_found(given):
    model, scores = wear_maps(given, spots(given, 0.05), PLATE, "total", **SPLITS)
    median = scores.groupby(["model", "metric"])["value"].median()
    ours, typical = median["wear_maps"], median["mean_shape"]
    assert ours["shape_R2"] > 0.95 and typical["shape_R2"] < 0.8
    assert ours["maximum_R2_log"] > 0.95
    assert ours["maximum_ratio"] == pytest.approx(1.0, abs=0.1)
    assert ours["place_distance"] < typical["place_distance"]
    stated = model[0]["scores"]["wear_maps"]["test"]["shape_R2"]["median"]
    assert stated == pytest.approx(ours["shape_R2"])


def test_a_map_surrogate_is_symmetric_scaled_and_survives_its_files(given, tmp_path):
    from abradem.learning.model_files import write_model

    maps = spots(given, 0.1)
    (description, arrays), _ = wear_maps(given, maps, PLATE, "total", **SPLITS)
    write_model(description, arrays, tmp_path / "wear_maps.json")
    surrogate = MapSurrogate.load(tmp_path / "wear_maps.json")
    from abradem.quantities import SAMPLED_NAMES

    values = dict(zip(SAMPLED_NAMES, given.inputs.T, strict=True))
    found = surrogate.predict(values)
    np.testing.assert_allclose(found.rate, found.rate[:, :, ::-1], rtol=1e-12)
    # The mean over the plate is that of its own polynomial.
    means = found.rate.mean(axis=(1, 2)) / maps.mean(axis=(1, 2))
    assert np.abs(np.log(means)).max() < 0.3
    np.testing.assert_allclose(found.x[[0, -1]], [-135.0, 135.0])
    np.testing.assert_allclose(found.z[[0, -1]], [-105.0, 105.0])
    # Exactly proportional to the Archard constant.
    doubled = surrogate.predict({**values, "archard_constant": 2.0 * values["archard_constant"]})
    np.testing.assert_allclose(doubled.rate, 2.0 * found.rate, rtol=1e-12)


def test_groups_beyond_those_of_training_are_set_to_the_nearest(given):
    arrays = fit_maps(given.groups, spots(given) / given.scale[:, None, None])
    far = np.repeat(given.groups[:1], 2, axis=0)
    far[:, 8] = arrays["group_high"][8] + [0.0, 10.0]
    near, beyond = wear_numbers(arrays, far, module.FLOOR)
    np.testing.assert_array_equal(near, beyond)


def test_fits_see_no_test_case(given, monkeypatch):
    maps = spots(given)
    seen = []
    fit = module.fit_maps
    monkeypatch.setattr(module, "fit_maps", lambda *rows: seen.append(rows[0]) or fit(*rows))
    wear_maps(given, maps, PLATE, "total", **SPLITS)
    splits = repeated_splits(given.table.keys, given.table.groups, 0.2, 3, 1)
    for rows, (train, _) in zip(seen, splits, strict=False):
        np.testing.assert_array_equal(rows, given.groups[train])
    assert len(seen) == 4 and len(seen[3]) == len(given.groups)


def test_cases_without_a_map_are_left_out(given):
    maps = spots(given, 0.05)
    maps[:30] = np.nan
    maps[30] = 0.0
    model, scores = wear_maps(given, maps, PLATE, "total", **SPLITS)
    assert model[0]["training_rows"] == len(maps) - 31
    assert np.isfinite(scores["value"]).all()


def test_too_few_maps_are_refused(given):
    maps = np.full((len(given.scale), NX, NZ), np.nan)
    with pytest.raises(ValueError, match="0 cases have a wear map, at least 4 are needed"):
        wear_maps(given, maps, PLATE, "total", **SPLITS)


def test_the_possible_score_is_the_share_of_the_variance_that_is_no_scatter():
    rng = np.random.default_rng(0)
    signal = 0.5 * rng.standard_normal((400, 6, 1)) * np.ones((1, 1, 8))
    shape = 1.0 + signal + 0.25 * rng.standard_normal((400, 6, 8))
    expected = 0.5**2 / (0.5**2 + 0.25**2)
    assert module.possible_shape_r2(shape) == pytest.approx(expected, abs=0.03)
    assert np.isnan(module.possible_shape_r2(np.ones((3, 4, 1))))


def test_scores_of_known_maps():
    actual = np.full((2, 4, 4), 1.0)
    actual[0, 1, 1], actual[1, 2, 0] = 3.0, 5.0
    plate = PlateSides(0.4, 0.4)
    perfect = map_scores(actual, actual, np.ones(2), plate)
    assert [perfect[name] for name in ("map_R2", "shape_R2", "maximum_R2_log")] == [1.0] * 3
    assert perfect["maximum_ratio"] == 1.0 and perfect["place_distance"] == 0.0
    # Mirror images are as good; one element down the slope is 100 mm away.
    mirrored = map_scores(actual, actual[:, :, ::-1], np.ones(2), plate)
    assert mirrored["place_distance"] == 0.0
    moved = map_scores(actual, np.roll(actual, 1, axis=1), np.ones(2), plate)
    assert moved["place_distance"] == pytest.approx(100.0)
    halved = map_scores(actual, 0.5 * actual, np.ones(2), plate)
    assert halved["shape_R2"] == 1.0 and halved["maximum_ratio"] == 0.5
