"""Share of the error by region compared with sums by hand."""

import numpy as np
import pandas as pd
import pytest
from tables import product_law

from abradem.learning.comparison import with_scale
from abradem.learning.regions import error_by_region
from abradem.surrogate.groups import Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


def test_the_error_of_each_region_is_its_sum_of_squares():
    dataset = product_law(60, noise=0.1)
    rng = np.random.default_rng(0)
    # Each case is tested twice, in another order, with errors that are large on flat plates.
    flat = dataset["plate_angle"].to_numpy() < 12.0
    parts = []
    for repeat in range(2):
        kept = rng.permutation(60)
        error = np.where(flat, 0.5, 0.1)[kept] * rng.standard_normal(60)
        actual = dataset["wear_total_mean"].to_numpy()[kept]
        parts.append(
            pd.DataFrame(
                {"model": "ridge", "protocol": "leakage_free", "repeat": repeat, "split": "test",
                 "case_id": dataset["case_id"].to_numpy()[kept], "actual": actual,
                 "predicted": actual * np.exp(error), "floor": 1e-12}
            )
        )  # fmt: skip
    tested = with_scale(pd.concat(parts, ignore_index=True), dataset, JET)
    published = tested.assign(protocol="as_published", predicted=1.0)
    found = error_by_region(pd.concat([tested, published]), dataset).set_index("region")
    assert found["tested"].tolist()[0] == 2 * flat.sum()
    away = np.log(tested["predicted"] / tested["actual"]).to_numpy()
    raw = (tested["predicted"] - tested["actual"]).to_numpy()
    here = flat[tested["case_id"]]
    row = found.loc["below 12 deg"]
    assert row["number_error_share"] == pytest.approx(np.sum(away[here] ** 2) / np.sum(away**2))
    assert row["error_share"] == pytest.approx(np.sum(raw[here] ** 2) / np.sum(raw**2))
    assert row["number_error_share"] > 2.0 * row["case_share"]
    number = np.log(tested["actual"] / tested["scale"]).to_numpy()[here]
    within = 1.0 - np.sum(away[here] ** 2) / np.sum((number - number.mean()) ** 2)
    assert row["r2_number"] == pytest.approx(within)
    for names in (found.index[:4], ["slow", "fast"], ["small", "large"]):
        for share in ("case_share", "error_share", "number_error_share"):
            assert found.loc[names, share].sum() == pytest.approx(1.0)


def test_a_target_that_is_not_positive_has_shares_of_its_own_error_alone():
    dataset = product_law(30)
    actual = dataset["wear_total_mean"].to_numpy() - dataset["wear_total_mean"].max()
    tested = pd.DataFrame(
        {"model": "ridge", "protocol": "leakage_free", "repeat": 0, "split": "test",
         "case_id": dataset["case_id"], "actual": actual, "predicted": 0.0, "floor": -1.0}
    )  # fmt: skip
    found = error_by_region(with_scale(tested, dataset, JET), dataset)
    assert found["number_error_share"].isna().all() and found["r2_number"].isna().all()
    assert found["error_share"].iloc[:4].sum() == pytest.approx(1.0)
