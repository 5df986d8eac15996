"""Wear maps of cases: Archard's law by element, in the order of the data set."""

import numpy as np
import pandas as pd
import pytest

from abradem.dem.model import Setup
from abradem.wear.element_maps import element_maps

SETUP = Setup(plate_length=0.4, plate_width=0.2, facet_size=0.1)


def tables(key, work, window=2.0):
    """Tables of a batch of one case with the work ``work`` (nx, nz) of its facets, J."""
    x, z = (index.ravel() for index in np.indices(work.shape))
    maps = pd.DataFrame({"case_id": key, "facet_x": x, "facet_z": z})
    maps = maps.assign(wear_total=work.ravel(), wear_sliding=0.0, wear_friction=2.0 * work.ravel())
    runs = pd.DataFrame([{"case_id": key, "window_start": 1.0, "window_end": 1.0 + window}])
    return maps[maps["wear_total"] > 0.0], runs


def dataset(*keys, constant=1e-9):
    return pd.DataFrame(
        {"case_id": keys, "archard_constant": constant * np.arange(1, 1 + len(keys))}
    )


def test_the_depth_rate_is_that_of_archard():
    work = np.arange(8.0).reshape(4, 2)
    rates = element_maps([tables(3, work)], dataset(3), SETUP, "total")
    # W J / (A t), in mm/s, for facets of 0.01 m2 in 2 s.
    np.testing.assert_allclose(rates[0], 1e3 * 1e-9 * work / (0.01 * 2.0))


def test_an_element_has_the_mean_rate_of_its_facets():
    work = np.arange(8.0).reshape(4, 2)
    fine = element_maps([tables(3, work)], dataset(3), SETUP, "friction")[0]
    coarse = element_maps([tables(3, work)], dataset(3), SETUP, "friction", 0.2)[0]
    assert coarse.shape == (2, 1)
    np.testing.assert_allclose(coarse[:, 0], fine.reshape(2, 2, 2).mean(axis=(1, 2)))


def test_cases_are_in_the_order_of_the_data_set_and_others_left_out():
    batches = [tables(key, np.full((4, 2), float(key))) for key in (5, 6, 7)]
    rates = element_maps(batches, dataset(7, 5), SETUP, "total")
    np.testing.assert_allclose(rates[:, 0, 0] / rates[0, 0, 0], [1.0, 2.0 * 5.0 / 7.0])


def test_a_case_without_a_window_has_no_map():
    batches = [tables(1, np.ones((4, 2))), tables(2, np.ones((4, 2)), window=0.0)]
    rates = element_maps(batches, dataset(1, 2), SETUP, "total")
    assert np.isfinite(rates[0]).all() and np.isnan(rates[1]).all()


def test_a_case_in_no_batch_is_named():
    with pytest.raises(ValueError, match="case 9 of the data set is in no batch"):
        element_maps([tables(1, np.ones((4, 2)))], dataset(1, 9), SETUP, "total")
