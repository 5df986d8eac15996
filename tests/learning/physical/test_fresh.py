"""Coverage on fresh cases: that of a surrogate whose intervals are a closed form."""

import numpy as np
import pytest
from flat_surrogate import NUMBER, SPREAD, write_flat_surrogate
from tables import product_law

from abradem.learning.model_files import write_model
from abradem.learning.physical.fresh import coverage_of_fresh
from abradem.learning.physical.problem import problem
from abradem.store.files import read_arrays, read_json
from abradem.surrogate.groups import Jet
from abradem.surrogate.model import Surrogate
from abradem.surrogate.parts import local_prefix

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
PLACE = "wear_total_footprint"
RATIO = 3.0
"""Of the footprint to the mean, far beyond the intervals of either."""


@pytest.fixture
def surrogate(tmp_path):
    """Of the mean over the plate, and of the footprint, `RATIO` times the mean, with 9 held-out
    errors: at most 90 %."""
    stem = tmp_path / "surrogate"
    write_flat_surrogate(stem, JET, "wear_total_mean")
    description, arrays = read_json(f"{stem}.json"), read_arrays(f"{stem}.safetensors")
    own = {name: array for name, array in arrays.items() if not name.startswith("group_")}
    own["conformal"] = own["conformal"][:9]
    own["mean_biases_0"] = own["mean_biases_0"] + np.float32(np.log(RATIO))
    description["local"] = [{"target": {"name": PLACE, "unit": "mm/s"}}]
    arrays |= {f"{local_prefix(PLACE)}{name}": array for name, array in own.items()}
    write_model(description, arrays, f"{stem}.json")
    return Surrogate.load(stem)


def with_errors(given, error, name):
    """The problem with wear whose logarithm is off from that of the surrogate by ``error``."""
    wear = given.scale * NUMBER * np.exp(error)
    table = given.table._replace(target=wear, target_name=name)
    return given._replace(table=table, log_number=np.log(wear / given.scale))


def test_the_coverage_of_fresh_cases_is_the_share_inside_by_place_and_region(surrogate):
    given = problem(product_law(60), JET)
    fresh = problem(product_law(200, seed=1), JET)
    # Errors of 2 deviations, the reach of all its intervals, and a little less or more.
    flat = np.degrees(fresh.groups[:, 8]) < 12.0
    error = SPREAD * np.where(flat, 2.1, 1.9)
    fresh = with_errors(fresh, error, "wear_total_mean")
    other = with_errors(fresh, np.log(RATIO) + np.where(flat, 2.1, 1.9) * SPREAD, PLACE)
    table, summary = coverage_of_fresh(surrogate, [(given, fresh), (given, other)])
    shown = table.set_index(["target", "region", "level"])["coverage"]
    assert shown["wear_total_mean", "all", 0.95] == pytest.approx(np.mean(~flat))
    assert shown["wear_total_mean", "below 12 deg", 0.8] == 0.0
    assert shown["wear_total_mean", "above 50 deg", 0.5] == 1.0
    assert shown[PLACE, "all", 0.8] == pytest.approx(np.mean(~flat))
    assert shown[PLACE, "below 12 deg", 0.5] == 0.0 and shown[PLACE, "above 50 deg", 0.5] == 1.0
    rows = table.set_index(["target", "region", "level"])["tested"]
    assert rows["wear_total_mean", "all", 0.5] == 200
    assert rows["wear_total_mean", "below 12 deg", 0.5] == flat.sum()
    # What the nine errors of the place cannot promise is not asked.
    assert set(shown[PLACE].index.get_level_values("level")) == {0.5, 0.8}

    assert summary["cases"] == 200
    mean, place = summary["rates"]
    assert (mean["target"], place["target"]) == ("wear_total_mean", PLACE)
    assert mean["shares"] == len(shown["wear_total_mean"]) - 3
    assert place["shares"] == len(shown[PLACE]) - 2
    # Flat plates are outside of all intervals, all others inside.
    inside = table[table["region"] != "all"].groupby("target")["in_joint"].sum()
    assert mean["in_band"] <= mean["in_joint"] == inside["wear_total_mean"] < mean["shares"]
    # The fewer the held-out errors, the more the quantiles scatter.
    mean_share, place_share = (one["expected"] / one["shares"] for one in (mean, place))
    assert place_share < mean_share < 0.95
    assert place["scores"]["MAPE"] == pytest.approx(np.mean(-np.expm1(-error)), rel=1e-4)
    (half, *_) = mean["all"]
    assert half["level"] == 0.5 and half["coverage"] == pytest.approx(np.mean(~flat))
    # Intervals that hold nothing below 12 deg are not faultless, and the numbers say so.
    assert mean["in_band"] < mean["expected"] < mean["shares"]
    assert half["band"][0] < 0.5 < half["band"][1] and not half["in_band"]
    away = np.log(NUMBER) - fresh.log_number
    spread = fresh.log_number - fresh.log_number.mean()
    assert mean["scores"]["R2_number"] == pytest.approx(
        1.0 - np.sum(away**2) / np.sum(spread**2), rel=1e-4
    )
    assert mean["scores"]["MAPE"] == pytest.approx(np.mean(-np.expm1(-error)), rel=1e-4)
