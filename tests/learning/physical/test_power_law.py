"""The power law states exponents that the rows determine, and only those."""

import numpy as np
import pytest
from small_studies import JET, two_varied
from tables import drawn, product_law

from abradem.learning.physical.models import fit_physical, fixed_quantities, makers
from abradem.learning.physical.power_law import SHARES, PowerLaw
from abradem.learning.physical.problem import problem
from abradem.quantities import SAMPLED


def fitted(table):
    given = problem(table, JET)
    law = PowerLaw().fit(given.groups, given.log_number, given.error)
    return law, law.exponents(fixed_quantities(given)).set_index("term"), given


def told(exponents, kind="quantity"):
    return set(exponents.index[(exponents["variation"] == "varied") & (exponents["kind"] == kind)])


@pytest.mark.parametrize(
    ("names", "quantities", "groups"),
    [
        # With one density Fr, L and Ca are the same variable; the speed is identified.
        (("particle_velocity_y", "plate_angle"), {"impact_speed"},
         {"plate_angle", "plate_angle_squared"}),
        (("particle_radius", "restitution"), {"particle_radius"},
         {"constant", "log_size", "log_rebound"}),
        (("plate_angle",), set(), {"constant", "plate_angle", "plate_angle_squared"}),
        (("equipment_density",), set(), {"constant"}),
        (("archard_constant",), {"archard_constant"}, {"constant"}),
        (("particle_velocity_y", "particle_density"), {"impact_speed", "particle_density"}, set()),
        # E* and G* are both functions of the one modulus.
        (("particle_shear_modulus",), set(), {"constant", "log_cauchy"}),
    ],
)  # fmt: skip
def test_exponents_are_those_of_what_varied(names, quantities, groups):
    law, exponents, _ = fitted(two_varied(24, *names))
    assert told(exponents) == quantities
    assert told(exponents, "group") == groups
    untold = exponents[exponents["variation"] != "varied"]
    assert untold[["exponent", "standard_error"]].isna().all(axis=None)
    known = exponents[exponents["variation"] == "varied"]
    assert np.isfinite(known[["exponent", "standard_error"]]).all(axis=None)
    for text in (law.equation(), law.equation_tex()):
        assert "nan" not in text and "held fixed" in text


def test_what_is_identified_has_the_exponent_of_the_law():
    rows = two_varied(60, "particle_velocity_y", "plate_angle", noise=0.01)
    speed = rows["particle_velocity_y"] ** 2 + 2.0 * 9.81 * 0.25
    rows["wear_total_mean"] *= speed**1.5 / (rows["particle_velocity_y"] ** 2 + 5.0)
    _, exponents, _ = fitted(rows)
    found = exponents.loc["impact_speed"]
    assert abs(found["exponent"] - 3.0) < 4.0 * found["standard_error"]
    assert found["standard_error"] < 0.05


def test_a_modulus_alone_tells_its_two_functions_not_apart():
    middle = {row.name: sum(row.paper_range) / 2.0 for row in SAMPLED}
    varied = drawn(40)["particle_shear_modulus"]
    # With other Poisson's ratios G*/E* is no constant.
    middle |= {"particle_shear_modulus": varied, "particle_poisson_ratio": 0.2}
    rows = drawn(40, **middle)
    wear = np.exp(0.02 * np.random.default_rng(1).standard_normal(40))
    _, exponents, _ = fitted(rows.assign(wear_total_mean=wear))
    for name in ("effective_youngs_modulus", "effective_shear_modulus", "log_cauchy",
                 "log_stiffness_ratio"):  # fmt: skip
        assert exponents.loc[name, "variation"] == "not identified"


def test_float_noise_identifies_nothing():
    rows = two_varied(24, "plate_angle")
    shake = np.random.default_rng(0).uniform(-1.0, 1.0, 24)
    rows["particle_radius"] *= 1.0 + 1e-12 * shake
    rows["particle_velocity_y"] *= 1.0 + 1e-12 * shake
    _, exponents, given = fitted(rows)
    assert told(exponents) == set()
    assert np.ptp(given.groups[:, 0]) == np.ptp(given.inputs[:, -1]) == 0.0


def test_too_few_rows_determine_no_exponent():
    law, exponents, _ = fitted(product_law(8))
    # That of the wear constant is part of the law.
    assert told(exponents) == {"archard_constant"}
    assert told(exponents, "group") == set()
    assert "C is not determined" in law.equation()


def test_in_an_ordinary_study_all_are_determined():
    law, exponents, given = fitted(product_law(100))
    assert set(exponents["variation"]) == {"varied"}
    assert told(exponents) == set(SHARES)
    assert "held fixed" not in law.equation() and "not identified" not in law.equation()
    _, _, summary, _ = fit_physical(
        given, makers(1, {"trees": 2}, {"members": 1, "hidden": (4,), "steps": 2}), repeats=1
    )
    assert summary["held_fixed"] == summary["not_identified"] == []
