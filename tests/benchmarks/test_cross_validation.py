"""Cross-validation of a study's data set against a plain loop, with a model that shows its rows."""

import cross_validation
import numpy as np
import pytest
from tables import product_law

from abradem.learning.physical.problem import problem
from abradem.learning.scores import r2
from abradem.surrogate.groups import Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


@pytest.fixture(scope="module")
def given():
    return problem(product_law(60), JET)


class Memory:
    """Predicts the target of a row that it has seen, and the mean of them for any other."""

    def fit(self, x, target, error):
        self.rows, self.target = x, target
        return self

    def predict(self, x):
        same = (x[:, None, :] == self.rows[None, :, :]).all(axis=2)
        known = same.any(axis=1)
        return np.where(known, self.target[same.argmax(axis=1)], self.target.mean())


def test_no_row_is_predicted_by_a_model_that_saw_it(given):
    wear, number = cross_validation.cross_validated(given, Memory, 0)
    # A model that saw the rows would score 1; means of the others score a little less than 0.
    assert -0.3 < number < 0.0 and wear < 0.9


def test_all_rows_are_scored_at_once(given):
    class Known(Memory):
        """Knows the law but for a known error of each row."""

        def predict(self, x):
            place = (x[:, None, :] == given.groups[None, :, :]).all(axis=2).argmax(axis=1)
            return given.log_number[place] + error[place]

    error = 0.1 * np.random.default_rng(0).standard_normal(60)
    for shuffle in range(3):
        wear, number = cross_validation.cross_validated(given, Known, shuffle)
        assert number == pytest.approx(r2(given.log_number, given.log_number + error))
        y = given.table.target
        assert wear == pytest.approx(r2(y, y * np.exp(error)))
