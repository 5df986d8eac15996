"""Which rows train and test, as published and inside the training rows."""

import numpy as np
import pytest

from abradem.learning.protocols import folds, published_split


@pytest.mark.parametrize("rows", [12, 99, 198])
@pytest.mark.parametrize("share", [0.2, 0.3])
def test_the_published_split_is_that_of_the_library(rows, share):
    from sklearn.model_selection import train_test_split

    train, test = train_test_split(np.arange(rows), test_size=share, random_state=42)
    ours = published_split(rows, share)
    np.testing.assert_array_equal(ours[0], train)
    np.testing.assert_array_equal(ours[1], test)


@pytest.mark.parametrize(("rows", "count"), [(20, 5), (7, 5), (4, 5)])
def test_folds_validate_every_row_once_and_never_train_on_it(rows, count):
    found = folds(rows, count, seed=1)
    assert sorted(np.concatenate([check for _, check in found])) == list(range(rows))
    assert all(not set(train) & set(check) and len(check) >= 2 for train, check in found)


def test_too_few_rows_cannot_be_cross_validated():
    with pytest.raises(ValueError, match="3 rows are too few"):
        folds(3, 5, seed=1)
