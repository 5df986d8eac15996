"""What would fail at the end of a run is refused before its first job."""

import pytest
from tables import product_law

from abradem.config import load_config
from abradem.running.readiness import problems_at_start, problems_of_table, too_few_rows

SOFT = {"particle_shear_modulus_gpa": 0.001, "particle_velocity_y": -30}


def study(blocks=1, cases=12, ranges=None, **values):
    sampling = {"blocks": blocks, "cases_per_block": cases, "ranges": ranges or {}}
    given = {"study": "a", "sampling": sampling, "figures": {"series_cases": [0]}}
    return load_config({**given, **values})


@pytest.mark.parametrize("cases", [1, 2, 3, 4, 5, 7])
def test_too_few_cases_to_learn_from_are_one_line_if_something_learns(cases):
    config = study(cases=cases)
    assert problems_at_start(config, {"simulate", "linear", "trees", "ga_ann"}, True) == [
        f"sampling.blocks and cases_per_block: {cases} rows are too few to learn from "
        "(allowed from 8)"
    ]
    assert problems_at_start(config, {"simulate", "dataset"}, False) == []


def test_enough_cases_are_no_problem():
    config = study(blocks=2, cases=4)
    assert problems_at_start(config, {"simulate", "dataset", "scene", "angles"}, True) == []


@pytest.mark.parametrize(("rows", "share", "fits"), [
    (8, 0.5, True), (8, 0.6, False), (20, 0.8, True), (20, 0.9, False), (40, 0.9, True),
])  # fmt: skip
def test_a_test_share_leaves_rows_to_learn_from(rows, share, fits):
    config = study(learning={"test_share": share})
    found = too_few_rows(config, rows, "")
    assert len(found) == (not fits)
    assert all(line.startswith(f"learning.test_share: {share:g}: leaves fewer") for line in found)


def test_a_validation_share_leaves_rows_to_train_networks_on():
    config = study(learning={"test_share": 0.5, "ga_ann": {"validation_share": 0.8}})
    assert too_few_rows(config, 8, "") == [
        "learning.ga_ann.validation_share: 0.8: leaves none of 4 training rows to learn from "
        "(allowed up to 0.75)"
    ]
    assert too_few_rows(config, 20, "") == []


def test_cases_that_do_not_exist_are_one_line_each():
    assert problems_at_start(study(), set(), False, [0, 11, 12, 99, 99]) == [
        "case 12: there is no such case (allowed 0 ... 11)",
        "case 99: there is no such case (allowed 0 ... 11)",
    ]


def test_ranges_in_which_nothing_can_be_simulated_are_one_line():
    (line,) = problems_at_start(study(ranges=SOFT), {"simulate", "dataset"}, False)
    assert line.startswith("sampling.ranges: 12 of 12 cases are inconsistent, such as: an impact")
    assert line.endswith("(allowed 20%, simulation.max_failed_share)")
    # The reasons of each case are in the table of the cases.
    assert problems_at_start(study(ranges=SOFT), {"sample"}, False) == []


def test_a_typical_case_that_cannot_be_simulated_is_one_line_for_all_angles():
    typical = {"particle_radius_mm": 100, "plate_angle": 0}
    config = study(
        figures={"series_cases": [0], "typical": typical},
        simulation={"factory": {"fall_height_mm": 50, "arc_radius_mm": 0}},
    )
    (line,) = problems_at_start(config, {"scene", "angles"}, False)
    assert line.startswith("figures.typical: cannot be simulated: ")
    assert problems_at_start(config, {"simulate"}, False) == []


ARC = {"kind": "arc", "arc": {"radius_mm": [300, 400]}}


def test_the_factory_of_a_geometry_is_looked_at_before_a_run():
    """For the cases and for the typical one of the pictures."""
    patch = {"patch_length_mm": 50, "patch_width_mm": 50}
    fine = study(simulation={"geometry": ARC, "factory": patch})
    assert problems_at_start(fine, {"simulate", "dataset", "scene"}, False) == []
    aside = {**ARC, "factory_centre_mm": [0, 500, 900]}
    config = study(simulation={"geometry": aside, "factory": patch})
    cases, typical = problems_at_start(config, {"simulate", "dataset", "scene"}, False)
    assert cases.startswith("sampling.ranges: 12 of 12 cases are inconsistent, such as: the jet")
    assert typical.startswith("figures.typical: cannot be simulated: the jet from (0, 0.5, 0.9) m")


def test_a_table_is_refused_with_all_its_problems():
    table = product_law(24)[["case_id", "wear_total_mean"]]
    config = study(dataset={"external": "t.csv"}, learning={"target": "wear_total_mean"})
    assert problems_of_table(config, table) == []
    assert problems_of_table(config, table.assign(wear_total_mean=0.0)) == [
        "t.csv: wear_total_mean is nowhere positive, there is nothing to learn"
    ]
    other = study(dataset={"external": "t.csv"}, learning={"target": "wear_sliding_max"})
    assert problems_of_table(other, table.head(5)) == [
        "t.csv: 5 rows are too few to learn from (allowed from 8)",
        "t.csv: lacks wear_sliding_max, the learning.target (the table has wear_total_mean)",
    ]
