"""Sampling of a geometry: further dimensions of the draw, and checks of each case."""

import numpy as np
import pytest

from abradem.dem.model import Setup
from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.sampling.checks import check_case
from abradem.sampling.draw import METHODS, block_cases

PAPER = {row.name: row.paper_range for row in SAMPLED}
MIDDLE = {name: (low + high) / 2.0 for name, (low, high) in PAPER.items()}
RANGES = {"plate_2_angle": (120.0, 165.0), "plate_2_length": (0.2, 0.5)}
GEOMETRY = {
    "kind": "plates",
    "plates": [
        {"length": 0.3, "width": 0.3, "angle": "plate_angle"},
        {"length": "plate_2_length", "width": 0.3, "angle": "plate_2_angle", "drop": 0.3},
    ],
}


@pytest.mark.parametrize("method", METHODS)
def test_quantities_of_a_geometry_cover_their_ranges(method):
    cases = block_cases(1, 0, 64, method, PAPER, geometry=RANGES)
    for name, (low, high) in RANGES.items():
        share = (cases[name].to_numpy() - low) / (high - low)
        assert 0.0 <= share.min() < 0.1 and 0.9 < share.max() <= 1.0
    assert np.abs(np.corrcoef(cases[["plate_angle", *RANGES]].T) - np.eye(3)).max() < 0.4


def test_a_latin_hypercube_has_one_case_in_each_stratum_of_a_geometry():
    cases = block_cases(3, 1, 40, "lhs", PAPER, geometry=RANGES)
    for name, (low, high) in RANGES.items():
        strata = np.floor((cases[name].to_numpy() - low) / (high - low) * 40)
        assert sorted(strata) == list(range(40))


def test_without_a_geometry_the_draw_is_what_it_was():
    plain = block_cases(1, 0, 8, "lhs", PAPER)
    assert plain.equals(block_cases(1, 0, 8, "lhs", PAPER, geometry={}))
    assert [name for name in plain if name in SAMPLED_NAMES] == list(SAMPLED_NAMES)


def test_an_unknown_quantity_of_a_geometry_is_named():
    with pytest.raises(ValueError, match=r"unknown \['cone_angle'\]"):
        block_cases(1, 0, 8, "lhs", PAPER, geometry={"cone_angle": (0.0, 1.0)})


def test_a_case_that_does_not_fit_its_geometry_is_rejected_with_the_reason():
    setup = Setup(geometry=GEOMETRY, patch_length=0.05, patch_width=0.05, facet_size=0.1)
    case = {**MIDDLE, "plate_2_angle": 150.0, "plate_2_length": 0.4, "particle_radius": 0.02}
    assert check_case(case, setup) == ""
    assert "is wider than the geometry" in check_case({**case, "plate_2_length": 400.0}, setup) or (
        "plates[1].length = 400" in check_case({**case, "plate_2_length": 400.0}, setup)
    )
    assert "the case has no quantity 'plate_2_angle'" in check_case(
        {name: value for name, value in case.items() if name != "plate_2_angle"}, setup
    )
    beside = Setup(geometry={"shape": GEOMETRY, "centre": [5.0, 1.0, 0.0]}, facet_size=0.1)
    assert "misses the geometry" in check_case(case, beside)
