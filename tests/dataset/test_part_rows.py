"""Rows with the wear of a named part of a geometry."""

import numpy as np
import pandas as pd
import pytest

from abradem.dataset.part_rows import part_rows
from abradem.quantities import STDERR_COLUMNS, WEAR_COLUMNS
from abradem.store.files import TableError


def tables():
    """A data set of four cases, in which case 2 has no wear, and the rates of two parts."""
    cases = np.array([3, 0, 1])
    dataset = pd.DataFrame({"case_id": cases, "plate_angle": 10.0 * cases})
    dataset = dataset.assign(
        **dict.fromkeys(WEAR_COLUMNS, 1.0), **dict.fromkeys(STDERR_COLUMNS, 0.1)
    )
    parts = pd.DataFrame(
        [(case, part) for case in range(4) for part in ("upper", "lower")],
        columns=["case_id", "part_name"],
    )
    rate = parts["case_id"] + 100.0 * (parts["part_name"] == "lower")
    return dataset.assign(quality="ok"), parts.assign(**dict.fromkeys(WEAR_COLUMNS, rate), area=0.1)


def test_the_rates_are_those_of_the_part_of_each_case():
    dataset, parts = tables()
    rows = part_rows(dataset, parts, "lower")
    assert list(rows["case_id"]) == [0, 1, 3]
    for name in WEAR_COLUMNS:
        np.testing.assert_array_equal(rows[name], [100.0, 101.0, 103.0])
    np.testing.assert_array_equal(rows["plate_angle"], [0.0, 10.0, 30.0])
    # A part has no standard error, and that of the whole is not its own.
    assert list(rows) == [name for name in dataset if name not in STDERR_COLUMNS]


def test_an_unknown_part_is_one_line():
    with pytest.raises(TableError) as error:
        part_rows(*tables(), "middle")
    assert str(error.value) == ("learning.part: there is no part 'middle' (allowed upper, lower)")
