"""Models of a curved chute whose radius and angle were sampled: a planted law comes back."""

import numpy as np
import pytest
from geometry_tables import (
    END_SLOPE,
    JET,
    RADIUS_EXPONENT,
    TARGET,
    VARIED,
    closed_form,
    planted,
    trained,
)

from abradem.learning.baselines.linear import fit_linear
from abradem.learning.model_files import write_model
from abradem.learning.physical.models import fixed_quantities
from abradem.learning.physical.power_law import PowerLaw
from abradem.learning.physical.problem import problem
from abradem.learning.physical.sensitivity import partial_dependence, permutation, sobol
from abradem.learning.rows import learning_table
from abradem.quantities import FEATURE_NAMES
from abradem.surrogate.groups import group_names, input_names
from abradem.surrogate.inverse import least_and_greatest, solve
from abradem.surrogate.model import PredictionError, Surrogate


@pytest.fixture(scope="module")
def table():
    return planted()


@pytest.fixture(scope="module")
def learned(table):
    return trained(table)


@pytest.fixture(scope="module")
def surrogate(learned, tmp_path_factory):
    """The surrogate as it is read from its files."""
    stem = tmp_path_factory.mktemp("arc") / "surrogate"
    write_model(*learned[2], f"{stem}.json")
    return Surrogate.load(stem)


def test_the_power_law_gives_the_planted_exponents(table):
    given = problem(table, JET, TARGET)
    law = PowerLaw(group_names(JET)).fit(given.groups, given.log_number, given.error)
    exponents = law.exponents(fixed_quantities(given)).set_index("term")
    radius = exponents.loc["arc_radius"]
    assert radius["kind"] == "quantity" and radius["standard_error"] < 0.02
    assert abs(radius["exponent"] - RADIUS_EXPONENT) < 4.0 * radius["standard_error"]
    # The slope of ln y along the angle, in the middle of its range.
    angle, square = (exponents.loc[name] for name in ("arc_end", "arc_end_squared"))
    slope = angle["exponent"] + 2.0 * np.radians(30.0) * square["exponent"]
    assert slope == pytest.approx(END_SLOPE, abs=0.1)
    assert law.terms == (*group_names(JET), "plate_angle_squared", "arc_end_squared")
    assert "(arc_radius/H)^(-0." in law.equation() and "arc_end^2" in law.equation()
    assert r"(\text{arc radius}/H)^{-0." in law.equation_tex()
    predicted = given.wear(np.arange(len(table)), law.predict(given.groups))
    np.testing.assert_allclose(predicted, closed_form(table), rtol=0.03)


def test_a_prediction_is_the_closed_form_within_its_interval(surrogate):
    fresh = planted(200, 0.0, 8)
    inside = {name: fresh[name].clip(*np.percentile(fresh[name], [5, 95])) for name in VARIED}
    fresh = fresh.assign(**inside)
    found = surrogate.predict(fresh, 0.95)
    expected = closed_form(fresh)
    np.testing.assert_allclose(found.rate, expected, rtol=0.05)
    assert np.mean((found.lower <= expected) & (expected <= found.upper)) > 0.9


def test_the_files_of_a_surrogate_hold_the_quantities_of_the_geometry(surrogate):
    features = {one["name"]: one for one in surrogate.description["features"]}
    assert tuple(features) == input_names(JET)
    assert features["arc_radius"]["unit"] == "m" and features["arc_end"]["unit"] == "deg"
    assert features["arc_radius"]["training_range"] == pytest.approx([0.25, 1.0], abs=0.03)
    assert surrogate.jet.geometry["shape"]["kind"] == "arc"
    assert surrogate.description["target"]["cells"] is True


@pytest.mark.parametrize(
    ("place", "value", "line"),
    [
        (("jet", "geometry"), 5, "jet.geometry = 5 must be an object"),
        (("jet", "geometry", "shape", "kind"), None, "jet.geometry.shape.kind = None must be text"),
        (("jet", "geometry", "shape", "width"), "wide", "jet.geometry: arc_width = 'wide' must be"),
        (("jet", "geometry", "shape", "radius"), 0.4, "groups = ["),
        (("features", 14, "unit"), "mm", "features[14].unit = 'mm' of arc_radius must be 'm'"),
        (("features", 15, "name"), "arc_width", "features[15].name = 'arc_width' is no quantity"),
    ],
)
def test_a_damaged_geometry_is_one_line(learned, tmp_path, place, value, line):
    import copy

    description, arrays = learned[2]
    broken = copy.deepcopy({**description, "jet": {**description["jet"]}})
    *above, last = place
    inner = broken
    for key in above:
        inner = inner[key]
    inner[last] = value
    write_model(broken, arrays, str(tmp_path / "s.json"))
    with pytest.raises(PredictionError) as error:
        Surrogate.load(tmp_path / "s")
    assert line in str(error.value) and "\n" not in str(error.value)


def test_values_outside_the_range_of_an_arc_are_named(surrogate):
    middle = planted(60).median(numeric_only=True)
    assert surrogate.predict(middle).warnings == []
    far = surrogate.predict({**middle, "arc_radius": 3.0}).warnings
    assert far and far[0].startswith("arc_radius = 3 m is outside the training range")
    with pytest.raises(PredictionError, match="missing: arc_radius"):
        surrogate.predict(middle.drop("arc_radius"))
    with pytest.raises(PredictionError, match=r"arc_radius = 0 m is impossible \(allowed 1e-06"):
        surrogate.predict({**middle, "arc_radius": 0.0})


def test_inverse_questions_take_the_radius(surrogate):
    middle = planted(60).median(numeric_only=True).to_dict()
    rate = float(closed_form({**middle, "arc_radius": 0.5}))
    found = solve(surrogate, middle, "arc_radius", rate)
    assert found.roots == pytest.approx([0.5], rel=0.1)
    extremes = least_and_greatest(surrogate, middle, "arc_radius")
    # The wear falls with the radius.
    assert extremes.values[0] > 0.9 and extremes.values[1] < 0.3


def test_sensitivities_know_the_radius(learned):
    given, process, _ = learned
    indices = sobol(process, given, 256, draws=2, seed=1)
    log = indices[indices["explained"] == "log wear"].set_index("feature")
    assert tuple(log.index) == input_names(JET)
    # ln y is a sum, so that the indices are the shares of its variances: of a uniform radius ...
    rng = np.random.default_rng(0)
    radius = RADIUS_EXPONENT**2 * np.var(np.log(rng.uniform(0.25, 1.0, 100_000)))
    end = END_SLOPE**2 * np.var(np.radians(rng.uniform(20.0, 40.0, 100_000)))
    assert log.loc["arc_end", "total"] / log.loc["arc_radius", "total"] == pytest.approx(
        end / radius, rel=0.4
    )
    falls = permutation(given, repeats=1, seed=1).set_index("feature")["fall"]
    assert falls["arc_radius"] > 0.05
    dependence = partial_dependence(process, given)
    along = dependence[dependence["feature"] == "arc_radius"].sort_values("setting")
    slope = np.polyfit(np.log(along["setting"]), np.log(along["predicted"]), 1)[0]
    assert slope == pytest.approx(RADIUS_EXPONENT, abs=0.05)


def test_baselines_learn_from_the_quantities_of_the_geometry(table):
    rows = learning_table(table, TARGET)
    assert rows.names == (*FEATURE_NAMES, "arc_radius", "arc_end")
    np.testing.assert_array_equal(rows.features[:, 20], table["arc_radius"])
    found = fit_linear(table, TARGET, repeats=2)
    weights = found.coefficients.set_index("feature")["coefficient"]
    assert weights["arc_radius"] < -0.2 and weights["archard_constant"] > 0.5
    assert len(found.published) == 21


def test_a_study_in_which_the_radius_alone_varies_is_learned(table):
    middle = table.iloc[0]
    alone = table.assign(**{name: middle[name] for name in table if name in FEATURE_NAMES})
    alone = alone.assign(arc_end=30.0)
    alone[TARGET] = closed_form(alone)
    given = problem(alone, JET, TARGET)
    says = dict(zip(input_names(JET), given.variation, strict=True))
    assert [name for name, one in says.items() if one == "varied"] == ["arc_radius"]
