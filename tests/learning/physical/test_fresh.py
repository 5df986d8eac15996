"""Coverage on fresh cases: that of a surrogate whose intervals are a closed form."""

import numpy as np
import pytest
from flat_surrogate import NUMBER, SPREAD, write_flat_surrogate
from tables import product_law

from abradem.learning.physical.fresh import coverage_of_fresh
from abradem.learning.physical.problem import problem
from abradem.surrogate.groups import Jet
from abradem.surrogate.model import Surrogate

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


def test_the_coverage_of_fresh_cases_is_the_share_inside_by_region(tmp_path):
    write_flat_surrogate(tmp_path / "surrogate", JET, "wear_total_mean")
    surrogate = Surrogate.load(tmp_path / "surrogate")
    given = problem(product_law(60), JET)
    fresh = problem(product_law(200, seed=1), JET)
    # Errors of 2 deviations, the reach of all its intervals, and a little less or more.
    flat = np.degrees(fresh.groups[:, 8]) < 12.0
    error = SPREAD * np.where(flat, 2.1, 1.9)
    wear = fresh.scale * NUMBER * np.exp(error)
    fresh = fresh._replace(
        table=fresh.table._replace(target=wear), log_number=np.log(wear / fresh.scale)
    )
    table, summary = coverage_of_fresh(surrogate, given, fresh)
    shown = table.set_index(["region", "level"])["coverage"]
    assert shown["all", 0.95] == pytest.approx(np.mean(~flat))
    assert shown["below 12 deg", 0.8] == 0.0 and shown["above 50 deg", 0.5] == 1.0
    rows = table.set_index(["region", "level"])["tested"]
    assert rows["all", 0.5] == 200 and rows["below 12 deg", 0.5] == flat.sum()
    assert summary["cases"] == 200 and summary["shares"] == len(table) - 3
    away = np.log(NUMBER) - fresh.log_number
    spread = fresh.log_number - fresh.log_number.mean()
    assert summary["scores"]["R2_number"] == pytest.approx(
        1.0 - np.sum(away**2) / np.sum(spread**2), rel=1e-4
    )
    assert summary["scores"]["MAPE"] == pytest.approx(np.mean(-np.expm1(-error)), rel=1e-4)
