"""Exponents of a study beside those of the published data."""

import numpy as np
import pytest
from tables import drawn

from abradem.config import Config, setup_dict
from abradem.learning.exponents import LEAST_SPEED, PUBLISHED, exponents_beside_published
from abradem.store.columns import EXPONENTS
from abradem.store.tables import read_table, write_table

ARC = {"angle_acts": "arc", "fall_height_mm": 385, "arc_radius_mm": 235}
SETUP = setup_dict(Config(study="a", simulation={"factory": ARC}))


def planted(n, seed=4, noise=0.0, **changed):
    """Rows whose rate has the published exponents, apart from those that are changed."""
    rows = drawn(n, seed)
    height = 0.385 - 0.235 * (1.0 - np.cos(np.radians(rows["factory_angle"])))
    values = {
        **{name: rows[name] for name in PUBLISHED if name != "impact_speed"},
        "impact_speed": rows["particle_velocity_y"] ** 2 + 2.0 * 9.81 * height,
        "restitution": 1.0 + rows["restitution"],
    }
    angle = rows["plate_angle"] / 70.0
    wear = np.exp(1.7 * angle - 0.3 * angle**2 + 0.1 * rows["factory_angle"] / 90.0)
    for name, (exponent, _) in PUBLISHED.items():
        wear = wear * values[name] ** changed.get(name, exponent)
    # Another seed than that of the rows, with which the noise would correlate otherwise.
    scatter = np.exp(noise * np.random.default_rng(seed + 1000).standard_normal(n))
    return rows.assign(wear_friction_p99=wear * scatter)


def test_planted_exponents_come_back_with_a_quadratic_in_the_angle():
    changed = {"particle_radius": 0.0, "restitution": 1.5, "equipment_shear_modulus": 0.1}
    rows = planted(120, **changed)
    found = exponents_beside_published(rows, "wear_friction_p99", SETUP).set_index("quantity")
    for name, (exponent, _) in PUBLISHED.items():
        assert found["exponent"][name] == pytest.approx(changed.get(name, exponent), abs=1e-9)
        assert found["verdict"][name] == ("differs" if name in changed else "agrees")
    fast = int((rows["particle_velocity_y"].abs() > LEAST_SPEED).sum())
    assert set(found["rows"]) == {fast} and 0 < fast < 120


def test_slow_cases_and_rates_of_zero_do_not_count():
    rows = planted(120)
    wrong = rows.copy()
    slow = wrong["particle_velocity_y"].abs() < LEAST_SPEED
    wrong.loc[slow, "wear_friction_p99"] *= 7.0
    fast = rows.index[~slow][:2]
    wrong.loc[fast, "wear_friction_p99"] = 0.0
    one = exponents_beside_published(wrong, "wear_friction_p99", SETUP)
    two = exponents_beside_published(rows.drop(fast), "wear_friction_p99", SETUP)
    np.testing.assert_array_equal(one["exponent"], two["exponent"])


def test_errors_hold_the_planted_exponents_as_often_as_they_say():
    """Of exponents with a normal error, 68 % are within one standard error."""
    within = []
    for seed in range(150):
        found = exponents_beside_published(planted(80, seed, 0.1), "wear_friction_p99", SETUP)
        away = (found["exponent"] - found["published_exponent"]).abs()
        within.append(away <= found["exponent_stderr"])
    share = float(np.mean(within))
    # Within one error are 67.6 % of Student's t with some 35 degrees of freedom; of 1200 exponents
    # the share has a standard deviation of 1.4 points.
    assert 0.63 < share < 0.72


def test_the_verdict_is_made_of_both_errors():
    found = exponents_beside_published(planted(90, 1, 0.3), "wear_friction_p99", SETUP)
    for row in found.itertuples():
        error = np.sqrt(row.exponent_stderr**2 + row.published_stderr**2)
        away = abs(row.exponent - row.published_exponent)
        assert row.combined_errors == pytest.approx(away / error)
        assert row.verdict == ("agrees" if away <= 2.0 * error else "differs")


@pytest.mark.parametrize("rows", [1, 12])
def test_too_few_cases_determine_nothing(tmp_path, rows):
    found = exponents_beside_published(planted(rows), "wear_friction_p99", SETUP)
    assert list(found["quantity"]) == list(PUBLISHED)
    assert found["exponent"].isna().all() and set(found["verdict"]) == {"not determined"}
    write_table(found, tmp_path / "e.parquet", extra=EXPONENTS)
    assert len(read_table(tmp_path / "e.parquet")) == len(PUBLISHED)


def test_a_quantity_held_fixed_has_no_exponent_and_the_others_have():
    rows = planted(120).assign(static_friction=0.5)
    rows["plate_angle"] = np.where(rows["plate_angle"] > 35.0, 60.0, 10.0)
    found = exponents_beside_published(rows, "wear_friction_p99", SETUP).set_index("quantity")
    assert found["verdict"]["static_friction"] == "not determined"
    assert found.drop("static_friction")["exponent"].notna().all()
