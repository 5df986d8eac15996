"""The data set is byte-identical for any division of the cases into jobs and any order of jobs."""

import pandas as pd
import pytest
from cases import table_of_cases

from abradem.dataset.join import join
from abradem.dem.model import Setup
from abradem.simulation.batch import FILES, TABLES, run_batch
from abradem.store.tables import concatenate, read_table, write_table
from abradem.wear.rates import wear_rates

SETUP = {"window": 1.0, "max_time": 3.0, "facet_size": 0.05, "target_stderr": 0.1}


def dataset(folder, cases, cuts):
    """The data set of cases simulated in the batches given by ``cuts``."""
    parts = {name: [] for name in ("rates", "runs")}
    for start, stop in cuts:
        some = cases.iloc[start:stop]
        outputs = {name: folder / f"{name}-{start}.parquet" for name in FILES}
        run_batch(some, SETUP, outputs, folder / ".finished" / str(start), "code")
        tables = {name: read_table(outputs[name]) for name in TABLES}
        rates = wear_rates(**tables, cases=some, setup=Setup.from_dict(SETUP))
        write_table(rates, folder / "rates.parquet")
        parts["rates"].append(read_table(folder / "rates.parquet"))
        parts["runs"].append(tables["runs"])
    found, failures = join(cases, *(concatenate(parts[name]) for name in ("rates", "runs")))
    write_table(found, folder / "dataset.parquet")
    return (folder / "dataset.parquet").read_bytes(), failures


@pytest.fixture(scope="module")
def cases():
    found = table_of_cases(4).assign(particle_radius=[0.02, 0.03, 0.025, 0.04])
    return found.assign(
        seed=[11, 12, 13, 14], factory_angle=0.0, plate_angle=[20.0, 30.0, 45.0, 60.0]
    )


@pytest.mark.parametrize("cuts", [[(0, 2), (2, 4)], [(3, 4), (1, 3), (0, 1)]])
def test_other_jobs_in_another_order_give_the_same_bytes(cases, tmp_path, cuts):
    (tmp_path / "one").mkdir()
    expected, failures = dataset(tmp_path / "one", cases, [(0, 4)])
    assert len(failures) < len(cases)
    assert dataset(tmp_path, cases, cuts)[0] == expected


def test_a_case_does_not_depend_on_those_before_it(cases):
    from abradem.simulation.batch import run_case

    rows = cases.to_dict("records")
    alone = run_case(rows[2], SETUP)["series"]
    run_case(rows[3], SETUP)
    pd.testing.assert_frame_equal(run_case(rows[2], SETUP)["series"], alone, check_exact=True)
