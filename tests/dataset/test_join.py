"""The join of cases, rates and runs, and the requirements on a data set."""

import numpy as np
import pandas as pd
import pytest

from abradem.dataset import join as ds
from abradem.quantities import FEATURE_NAMES, SAMPLED, STATISTICS, WEAR_MEASURES
from abradem.store.columns import COLUMNS


def sample_cases(n=3, rejected=()):
    middle = {row.name: 0.5 * sum(row.paper_range) for row in SAMPLED}
    cases = pd.DataFrame({"case_id": range(n), "block": 0, "seed": range(10, 10 + n)})
    cases = cases.assign(**middle)
    cases["rejected"] = ["too fast" if key in rejected else "" for key in cases["case_id"]]
    return cases


def sample_runs(n=3, **status):
    numbers = {
        "simulated_time": 6.0,
        "steady_from": 0.5,
        "delivered_rate": 4.0,
        "face_share": 0.9,
    }
    runs = pd.DataFrame({"case_id": range(n), "status": "ok"}).assign(**numbers)
    for key, word in status.items():
        runs.loc[int(key[1:]), "status"] = word
    return runs


def sample_rates(keys):
    rates = pd.DataFrame({"case_id": list(keys)})
    for name in ds.WEAR_COLUMNS:
        rates[name] = 1e-3
    for name in ds.STDERR_COLUMNS:
        rates[name] = 1e-5
    return rates.assign(
        wear_r2=0.99, worn_volume_rate=1e-9, wear_per_kg=1e-10,
        quality="ok",
    )  # fmt: skip


def test_all_columns_of_the_dataset_have_units_and_each_feature_its_own():
    assert set(ds.DATASET_COLUMNS) <= set(COLUMNS)
    assert ds.DATASET_COLUMNS[3:23] == FEATURE_NAMES
    assert [n for n in ds.WEAR_COLUMNS] == [
        f"wear_{r}_{s}" for r in WEAR_MEASURES for s in STATISTICS
    ]
    for row in SAMPLED:
        assert COLUMNS[row.name].unit == row.unit


def test_the_join_has_one_row_for_each_case_that_ended_well():
    cases, runs = (
        sample_cases(7, rejected=(4,)),
        sample_runs(7, c1="overlap", c4="rejected: too fast").drop(index=5),
    )
    rates = sample_rates([0, 2, 3])
    rates.loc[2, "wear_total_mean"] = np.nan
    rates.loc[len(rates)] = [6, *[0.0] * (rates.shape[1] - 2), "stderr"]
    shuffled = cases.sample(frac=1, random_state=1)
    dataset, failures = ds.join(shuffled, rates.iloc[::-1], runs.iloc[::-1])
    assert list(dataset["case_id"]) == [0, 2]
    assert tuple(dataset.columns) == ds.DATASET_COLUMNS
    assert tuple(failures.columns) == ds.FAILURE_COLUMNS
    assert dict(zip(failures["case_id"], failures["status"], strict=True)) == {
        1: "overlap",
        3: "no wear rate: no steady state reached",
        4: "rejected: too fast",
        5: "not simulated",
        6: "no wear: nothing met the plate",
    }
    ds.check(dataset)


def test_the_join_takes_the_seeds_and_features_of_the_right_case():
    cases = sample_cases(4)
    cases["particle_radius"] = [0.01, 0.02, 0.03, 0.04]
    dataset, _ = ds.join(cases.iloc[::-1], sample_rates([3, 1, 0]), sample_runs(4))
    assert list(dataset["particle_radius"]) == [0.01, 0.02, 0.04]
    assert list(dataset["seed"]) == [10, 11, 13]


def test_the_join_refuses_doubled_and_foreign_cases():
    with pytest.raises(ds.TableError, match="wear rates: case 1 appears twice"):
        ds.join(sample_cases(), sample_rates([0, 1, 1]), sample_runs())
    with pytest.raises(ds.TableError, match="case 3 does not belong"):
        ds.join(sample_cases(3), sample_rates([0]), sample_runs(4))


def test_a_case_with_a_number_that_is_not_finite_is_a_failure_and_stops_no_other():
    rates = sample_rates([0, 1, 2])
    rates.loc[1, "wear_per_kg"] = np.nan
    rates.loc[2, "wear_sliding_max"] = np.inf
    dataset, failures = ds.join(sample_cases(3), rates, sample_runs(3))
    assert list(dataset["case_id"]) == [0]
    assert list(failures["status"]) == ["no finite wear_per_kg", "no finite wear_sliding_max"]
    ds.check(dataset)


def test_more_failures_than_allowed_are_one_line():
    runs = sample_runs(4, c0="refused: step 1", c1="refused: step 2", c3="overlap")
    dataset, failures = ds.join(sample_cases(4), sample_rates([2]), runs)
    ds.check_failures(dataset, failures, 0.75)
    with pytest.raises(ds.TableError) as stopped:
        ds.check_failures(dataset, failures, 0.7)
    assert str(stopped.value) == (
        "dataset: 3 of 4 cases failed (2 refused, 1 overlap), more than "
        "simulation.max_failed_share = 0.7 allows; case 0: refused: step 1; "
        "failures.parquet lists all"
    )


def test_a_study_without_a_good_case_says_so():
    dataset, failures = ds.join(sample_cases(2), sample_rates([]), sample_runs(2, c0="x", c1="y"))
    assert list(failures["status"]) == ["x", "y"]
    with pytest.raises(ds.TableError, match="no case was successful"):
        ds.check(dataset)


@pytest.mark.parametrize(
    ("column", "value", "says"),
    [
        ("wear_total_mean", np.nan, "case 1: wear_total_mean = nan mm/s must be finite"),
        ("wear_total_mean", 0.0, "case 1: wear_total_mean = 0.0 mm/s must be positive"),
        ("wear_sliding_max", -1.0, "wear_sliding_max = -1.0 mm/s must not be negative"),
        ("plate_angle", 200.0, "plate_angle = 200.0 deg must lie in"),
    ],
)
def test_the_check_names_case_column_value_and_law(column, value, says):
    dataset, _ = ds.join(sample_cases(), sample_rates(range(3)), sample_runs())
    dataset.loc[1, column] = value
    with pytest.raises(ds.TableError) as error:
        ds.check(dataset)
    assert says in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_facets_that_few_large_particles_leave_unworn_are_no_error():
    dataset, _ = ds.join(sample_cases(), sample_rates(range(3)), sample_runs())
    ds.check(dataset.assign(wear_total_p99=0.0, wear_sliding_mean=0.0))


def test_the_check_finds_doubled_cases_and_missing_columns():
    dataset, _ = ds.join(sample_cases(), sample_rates(range(3)), sample_runs())
    with pytest.raises(ds.TableError, match="case 0 appears"):
        ds.check(pd.concat([dataset, dataset.iloc[:1]]))
    with pytest.raises(ds.TableError, match="lacks column restitution"):
        ds.check(dataset.drop(columns="restitution"))


def test_sampled_quantities_of_a_geometry_are_columns_of_their_case():
    cases = sample_cases(3, rejected=(1,)).assign(plate_2_angle=[120.0, 130.0, 140.0])
    runs = sample_runs(3, c1="rejected: too fast")
    dataset, _ = ds.join(cases.iloc[::-1], sample_rates([0, 2]), runs)
    assert list(dataset) == [*ds.DATASET_COLUMNS, "plate_2_angle"]
    assert list(dataset["plate_2_angle"]) == [120.0, 140.0]
    assert COLUMNS["plate_2_angle"].unit == "deg"
