"""Ensembles: rows count as the weights say, members are averaged as the text says."""

import numpy as np
import pytest
from sklearn.ensemble import GradientBoostingRegressor

from abradem.learning.physical.ensembles import ERROR_FLOOR, Boosting, Networks


@pytest.fixture(scope="module")
def rows():
    """Two laws on the same inputs; the rows of the wrong one have large standard errors."""
    rng = np.random.default_rng(0)
    x = np.repeat(rng.uniform(-1.0, 1.0, (60, 2)), 2, axis=0)
    wrong = np.arange(120) % 2 == 1
    target = x[:, 0] + np.where(wrong, 2.0, 0.0)
    return x, target, np.where(wrong, 0.5, 0.01)


def test_boosting_weights_rows_by_their_errors_above_a_floor(rows):
    x, target, error = rows
    found = Boosting(trees=40, depth=2, seed=3).fit(x, target, error).predict(x)
    weight = 1.0 / (ERROR_FLOOR**2 + error**2)
    library = GradientBoostingRegressor(
        n_estimators=40, max_depth=2, learning_rate=0.05, subsample=0.5, min_samples_leaf=2,
        random_state=3,
    ).fit(x, target, weight / weight.mean())  # fmt: skip
    np.testing.assert_array_equal(found, library.predict(x))
    # (0.02^2 + 0.01^2) / (0.02^2 + 0.5^2) = 0.002: the wrong law has no say.
    usual = Boosting(trees=200, depth=2).fit(x, target, error).predict(x)
    assert np.mean(usual - x[:, 0]) < 0.1
    equal = Boosting(trees=200, depth=2).fit(x, target, np.full(120, 0.01)).predict(x)
    assert np.mean(equal - x[:, 0]) == pytest.approx(1.0, abs=0.1)


def test_networks_are_averaged_with_equal_weights_and_use_no_errors(rows):
    x, target, error = rows
    few = {"hidden": (8,), "steps": 40}
    ensemble = Networks(members=3, seed=5, **few).fit(x, target, error)
    alone = [Networks(members=1, seed=5 + member, **few).fit(x, target, error).predict(x)
             for member in range(3)]  # fmt: skip
    np.testing.assert_allclose(ensemble.predict(x), np.mean(alone, axis=0), rtol=1e-12)
    assert np.ptp(alone, axis=0).max() > 1e-3
    other = Networks(members=3, seed=5, **few).fit(x, target, np.full(120, 0.3))
    np.testing.assert_array_equal(ensemble.predict(x), other.predict(x))
