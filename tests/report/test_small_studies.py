"""Small and constant tables: every text made of them has words where there is no number."""

import json
import re
import warnings

import numpy as np
import pytest
from figure_checks import texts
from small_studies import JET, figures_of, learned, texts_of, two_varied
from tables import product_law

from abradem.dataset.external import read_external
from abradem.dataset.features import derive
from abradem.learning.physical.problem import problem
from abradem.learning.rows import learning_table
from abradem.quantities import FEATURE_NAMES, SAMPLED_NAMES
from abradem.surrogate.model import Surrogate

WEAR = "wear_total_mean"
NO_NUMBER = re.compile(
    r"(?<![A-Za-z])([Nn]a[Nn]|[Ii]nf|[Ii]nfinity|None|n/a)(?![A-Za-z])"
    r"|(?<=\d)e\+?([3-9]\d|\d{3})"
)


def alternating(low, high, n=12):
    return product_law(n).assign(**{WEAR: np.where(np.arange(n) % 2, low, high)})


def with_one(value, n=12):
    return product_law(n).assign(**{WEAR: lambda t: t[WEAR].where(np.arange(n) != 5, value)})


TABLES = {
    "8 rows": lambda: product_law(8),
    "12 rows": lambda: product_law(12),
    "20 rows": lambda: product_law(20),
    "constant": lambda: product_law(12).assign(**{WEAR: 1e-4}),
    "constant with noise": lambda: alternating(0.1, 0.1 + 1e-16),
    "one of 1e300": lambda: with_one(1e300),
    "two values": lambda: alternating(1e-4, 3e-4),
    "one value differs": lambda: product_law(12).assign(
        **{WEAR: np.where(np.arange(12) == 3, 1e-4, 3e-4)}
    ),
    "speed and angle": lambda: two_varied(20, "particle_velocity_y", "plate_angle"),
    "radius and restitution": lambda: two_varied(20, "particle_radius", "restitution"),
    "angle": lambda: two_varied(12, "plate_angle"),
    "density of the plate": lambda: two_varied(12, "equipment_density"),
}
VARIED = {
    "speed and angle": {"particle_velocity_y", "plate_angle"},
    "radius and restitution": {"particle_radius", "restitution"},
    "angle": {"plate_angle"},
    "density of the plate": {"equipment_density"},
}


class Small:
    """A table read as an external one, and all that is made of it, without a RuntimeWarning."""

    def __init__(self, name, folder):
        self.name = name
        TABLES[name]().to_csv(folder / "small.csv", index=False)
        self.table = read_external(folder / "small.csv")
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            self.found = learned(self.table, folder)
            self.texts = texts_of(self.table, self.found)


@pytest.fixture(scope="module", params=TABLES)
def small(request, tmp_path_factory):
    return Small(request.param, tmp_path_factory.mktemp("small"))


def test_texts_have_words_where_there_is_no_number(small):
    for name, text in small.texts.items():
        wrong = NO_NUMBER.search(text)
        assert wrong is None, f"{name}: {text[max(0, wrong.start() - 60) : wrong.end() + 20]}"


def test_figures_have_words_where_there_is_no_number(small):
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        for name, figure in figures_of(small.table, small.found):
            text = texts(figure)
            wrong = NO_NUMBER.search(text)
            assert wrong is None, f"{name}: {text[max(0, wrong.start() - 60) : wrong.end() + 20]}"


def test_r2_is_undefined_without_spread_and_else_no_huge_number(small):
    scored = small.found["scores"]
    r2 = scored.scores.loc[scored.scores["metric"] == "R2", "value"]
    assert not (r2 < -1e9).any()
    ends = scored.comparison[["r2_lower", "r2_upper"]]
    assert not (ends < -1e9).any(axis=None)
    if small.name.startswith("constant"):
        # The wrong target is a component, which varies.
        of_wear = scored.scores["model"] != "pca_wrong_target"
        assert r2[of_wear].isna().all()
        of_wear = scored.comparison["model"] != "pca_wrong_target"
        assert scored.comparison.loc[of_wear, ["r2", "r2_lower", "r2_upper"]].isna().all(axis=None)
        assert "R2 is undefined" in small.texts["findings"]
        assert "not determined" in small.texts["numbers"]


def test_nothing_is_said_of_what_was_held_fixed(small):
    if small.name not in VARIED:
        return
    varied, found = VARIED[small.name], small.found
    assert set(found["sensitivity"].summary["held_fixed"]) == set(SAMPLED_NAMES) - varied
    assert set(found["sensitivity"].summary["hardly_any_effect"]) <= varied
    assert set(found["sensitivity"].summary["dominant"]) <= varied
    fixed = [name for name in FEATURE_NAMES if small.table[name].nunique() == 1]
    for table, columns in (
        (found["linear"].coefficients, ["coefficient", "lower", "variance_inflation"]),
        (found["penalised"].weights, ["weight", "survives"]),
        (found["selection"].selection, ["lasso_weight", "leading_share", "survives"]),
        (found["trees"].importance, ["importance"]),
        (found["sensitivity"].indices, ["first", "total", "total_upper"]),
        (found["sensitivity"].falls, ["fall", "fall_lower"]),
    ):
        rows = table[table["feature"].isin(fixed)]
        assert len(rows) and (rows["variation"] == "held fixed").all()
        assert rows[columns].isna().all(axis=None)
    assert not set(found["pca"].loadings["feature"]) & set(fixed)
    assert found["pca"].summary["held_fixed"] == fixed
    chosen = found["selection"].selection
    assert not set(chosen.loc[chosen["chosen_by"] != "", "feature"]) & set(fixed)
    assert not set(found["sensitivity"].dependence["feature"]) & set(fixed)
    assert "These quantities had the same value in all cases" in small.texts["findings"]
    assert "held fixed" in small.texts["features"]


def test_the_surrogate_says_that_it_does_not_know_what_was_held_fixed(small):
    if small.name not in VARIED:
        return
    one = small.found["surrogate"]
    surrogate = Surrogate(json.loads(json.dumps(one.summary)), one.arrays)
    case = small.table.iloc[0][list(SAMPLED_NAMES)].to_dict()
    shaken = {name: value * (1.0 + 1e-12) for name, value in case.items()}
    assert not [line for line in surrogate.predict(shaken).warnings if "held fixed" in line]
    (line,) = [
        line for line in surrogate.predict({**case, "static_friction": 0.6}).warnings
        if line.startswith("static_friction")
    ]  # fmt: skip
    assert "held fixed at 0.475 in training" in line


def test_rows_in_which_nothing_varies_are_one_line():
    fixed = {name: product_law(1)[name][0] for name in SAMPLED_NAMES}
    table = derive(product_law(12).assign(**fixed)).assign(case_id=np.arange(12), **{WEAR: 1e-4})
    for use in (lambda: learning_table(table), lambda: problem(table, JET)):
        with pytest.raises(ValueError, match="all quantities were held fixed") as error:
            use()
        assert "\n" not in str(error.value)
