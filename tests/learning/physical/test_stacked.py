"""Stacked models: the weight is that of least squares, and serves rows that were not seen."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from abradem.learning.physical.ensembles import Boosting
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.stacked import Stacked, best_share


def rows(n, step, seed=0):
    """A smooth law, with or without a step that a smooth model blurs."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, (n, 3))
    target = np.sin(2.0 * x[:, 0]) + 0.5 * x[:, 1] + step * (x[:, 2] > 0.13)
    return x, target, np.full(n, 0.01)


def test_the_share_minimises_the_squared_error():
    rng = np.random.default_rng(0)
    first, second = rng.uniform(-1.0, 1.0, (2, 80)) + 0.2
    found = minimize_scalar(
        lambda w: np.sum((first + w * (second - first)) ** 2), bounds=(0.0, 1.0), method="bounded"
    )
    assert best_share(first, second) == pytest.approx(found.x, abs=1e-4)
    assert best_share(first, first) == 0.0
    assert best_share(first, 3.0 * first) == 0.0 and best_share(3.0 * first, first) == 1.0


def test_a_wild_row_does_not_choose_the_share():
    rng = np.random.default_rng(1)
    first, second = 0.1 * rng.standard_normal(60), rng.standard_normal(60)
    quiet = best_share(first, second)
    # Both miss it; alone it would choose the second model.
    first[3], second[3] = 40.0, 30.0
    assert best_share(first, second) == pytest.approx(quiet, abs=0.05)


@pytest.mark.parametrize("step", [0.0, 1.0])
def test_a_stack_is_about_as_good_as_the_better_model(step):
    x, target, error = rows(120, step)
    new, true, _ = rows(300, step, seed=1)
    makers = GaussianProcess, lambda: Boosting(trees=150, depth=3)
    stack = Stacked(*makers).fit(x, target, error)
    errors = [
        np.mean((model.predict(new) - true) ** 2)
        for model in (stack, *(make().fit(x, target, error) for make in makers))
    ]
    assert errors[0] < 1.1 * min(errors[1:]) + 1e-4
    assert (stack.share < 0.15) if step == 0.0 else (stack.share > 0.2)


def test_few_rows_or_repeats_alone_leave_the_first_model():
    x, target, error = rows(9, 0.0)
    stack = Stacked(GaussianProcess, Boosting).fit(x, target, error)
    assert stack.share == 0.0
    np.testing.assert_array_equal(
        stack.predict(x), GaussianProcess().fit(x, target, error).predict(x)
    )
