"""Verdicts follow from the numbers; the documentation agrees with the results of the engine."""

import math
import re
from pathlib import Path

import pandas as pd
import pytest

from abradem.config.simulation_keys import Simulation
from abradem.dem.model import Setup
from abradem.quantities import WEAR_MEASURES
from abradem.store.tables import read_table, read_units
from abradem.verification import chutes, codes, laws, time_step
from abradem.verification.checks import FAILS, HOLDS, Check, checks_table, write
from abradem.verification.results_page import (
    HEAD,
    main,
    plain_number,
    results_page,
    verdict_counts,
)

ROOT = Path(__file__).parents[2]
CODES = ROOT / "tests" / "data" / "codes"


@pytest.fixture(scope="module")
def checks():
    return laws.fast_checks()


def test_every_closed_form_holds(checks):
    assert [check.law for check in checks if not check.holds] == []


@pytest.fixture(scope="module")
def comparison():
    reference = codes.read(CODES / "single_impacts.csv")
    return codes.compare_impacts(reference[reference["angle"].isin([30.0, 60.0])])


def test_other_codes_agree_under_the_same_options_or_for_a_named_reason(comparison):
    found = codes.checks(comparison)
    assert {name.split()[0] for name in comparison["code"]} == set(codes.PEERS)
    assert [check.law for check in found if not check.holds] == []
    assert all(check.note for check in found if "under its choices" in check.law)


def test_the_choices_of_another_code_matter(comparison):
    part = comparison[comparison["code"].str.startswith("LAMMPS")]
    part = part[(part["restitution"] < 1.0) & (part["quantity"] == "total")]
    assert codes.largest(part, "ours") > 10.0 * codes.largest(part, "theirs")


def test_wear_is_what_another_code_counts_itself(comparison):
    part = comparison[comparison["quantity"] == "wear"]
    assert set(part["code"].str.split().str[0]) == {"Kratos"}
    assert codes.largest(part, "theirs") < codes.UNEXPLAINED


def test_a_jet_gives_the_plate_the_impulse_of_another_code():
    reference = codes.read(CODES / "jets.csv")
    assert set(reference["code"].str.split().str[0]) == set(codes.PEERS)
    kratos = reference[reference["code"].str.startswith("Kratos")].iloc[0]
    normal, _ = codes.our_jet(kratos["code"], kratos["variant"])
    assert normal == pytest.approx(kratos["normal_impulse"], rel=codes.ALLOWED)


def test_a_chute_gets_the_impulse_and_the_profile_of_other_codes():
    reference = codes.read(CODES / "chutes.csv")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chutes, "_NUDGES", chutes._NUDGES[:2])
        found = chutes.chute_checks(chutes.compare_chutes(reference))
    assert [check.law for check in found if not check.holds] == []
    assert {check.law.split()[0] for check in found} <= {"LIGGGHTS", "Kratos"}


def test_the_verified_steps_are_those_of_the_engine_and_of_the_default_study():
    fractions = {time_step.CHOSEN, time_step.PAPERS}
    assert fractions == {Setup().time_step_fraction, Simulation().time_step_rayleigh_fraction}
    mean = pd.DataFrame(
        [
            {"speed": 3.9, "restitution": 0.5, "measure": measure, "fraction": fraction,
             "bias": stated}
            for (measure, fraction), stated in time_step.STATED.items()
        ]
    )  # fmt: skip
    jet = pd.DataFrame(
        [
            {"plate_angle": time_step.WORST_PLATE, "measure": measure, "fraction": fraction,
             "bias": stated, "bias_stderr": 0.0}
            for (measure, fraction), stated in time_step.STATED_JET.items()
        ]
    )  # fmt: skip
    assert [check.law for check in time_step.checks(mean, jet) if not check.holds] == []
    # The checks would fail with the time step of the paper as the default.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time_step, "CHOSEN", time_step.PAPERS)
        failing = [check.law for check in time_step.checks(mean, jet) if not check.holds]
    assert len(failing) == 2 and all("default step, 0.2" in law for law in failing)


def test_documented_biases_are_those_of_the_study():
    method = (ROOT / "docs" / "method.md").read_text()
    for fraction, words in ((0.15, "15 %, the default"), (0.2, "20 %, the paper's")):
        line = next(line for line in method.splitlines() if line.startswith(f"| {words}"))
        numbers = [float(cell.strip(" <%+")) / 100.0 for cell in line.split("|")[2:8]]
        for measure, single, jet in zip(WEAR_MEASURES, numbers[:3], numbers[3:], strict=True):
            stated = time_step.STATED[measure, fraction]
            assert abs(single) == pytest.approx(stated, abs=1e-9) or (stated == 0.0 < single)
            assert jet == pytest.approx(time_step.STATED_JET[measure, fraction], abs=1e-9)


def stated_angles():
    """The table by angle that the study would return if all is as stated."""
    return pd.DataFrame(
        [
            {"fraction": fraction, "measure": measure, "restitution": 0.5, "angle": angle,
             "bias": 0.0, "largest_bias": bias}
            for (measure, fraction), biases in time_step.STATED_AT_ANGLES.items()
            for angle, bias in zip(time_step.EACH_ANGLE, biases, strict=True)
        ]
    )  # fmt: skip


def test_biases_at_single_angles_are_limited_and_stated():
    angles = stated_angles()
    assert [check.law for check in time_step.angle_checks(angles) if not check.holds] == []
    # A tenth of a percent at one angle is noticed, and so is a default step that is too long.
    one = (angles["measure"] == "total") & (angles["fraction"] == 0.15) & (angles["angle"] == 40.0)
    angles.loc[one, "largest_bias"] += 0.001
    failing = [check.law for check in time_step.angle_checks(angles) if not check.holds]
    assert len(failing) == 1 and "stated biases of total at 0.15" in failing[0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time_step, "CHOSEN", time_step.PAPERS)
        failing = [c.law for c in time_step.angle_checks(stated_angles()) if not c.holds]
    assert len(failing) == 3 and all("default step, 0.2" in law for law in failing)


def test_the_bias_at_an_angle_is_as_stated():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time_step, "EACH_ANGLE", (40.0,))
        found = time_step.by_angle()
    assert sorted(found["fraction"].unique()) == [0.15, 0.2]
    place = time_step.EACH_ANGLE.index(40.0)
    for (fraction, measure), part in found.groupby(["fraction", "measure"]):
        largest = part["largest_bias"].abs().max()
        stated = abs(time_step.STATED_AT_ANGLES[measure, fraction][place])
        assert largest == pytest.approx(stated, abs=6e-4)


def test_documented_biases_at_single_angles_are_those_of_the_study():
    method = (ROOT / "docs" / "method.md").read_text()
    for place, angle in enumerate(time_step.EACH_ANGLE):
        line = next(line for line in method.splitlines() if line.startswith(f"| {angle:.0f}° |"))
        numbers = [float(cell) / 100.0 for cell in line.split("|")[2:10]]
        for fraction, given in ((0.15, numbers[:3]), (0.2, numbers[4:7])):
            stated = [time_step.STATED_AT_ANGLES[m, fraction][place] for m in WEAR_MEASURES]
            assert given == pytest.approx(stated, abs=1e-9)


def test_tangential_force_against_time_is_that_of_another_code():
    found = codes.force_checks(codes.compare_forces(codes.read(CODES / "forces.csv")))
    assert {check.law.split()[0] for check in found} == set(codes.PEERS)
    assert [check.law for check in found if not check.holds] == []


def test_the_documented_page_has_the_numbers_of_the_engine(checks):
    page = (ROOT / "docs" / "verification-table.md").read_text()
    assert page.startswith(HEAD)
    written = dict(re.findall(r"^\| (.+?) \| (\S+)[^|]* \|", page, re.MULTILINE))
    noise = 1e-8
    compared = 0
    for check in checks:
        assert check.law in written, f"{check.law}: run make verify"
        if abs(check.ours) > noise:
            assert float(written[check.law]) == pytest.approx(check.ours, rel=2e-3), check.law
            compared += 1
    assert compared > 40


@pytest.mark.parametrize(
    ("check", "holds"),
    [
        (Check("a", 1.01, 1.0, 0.02), True),
        (Check("a", 1.03, 1.0, 0.02), False),
        (Check("a", -0.5, 0.0, 0.4, kind="absolute"), False),
        (Check("a", 3.0, 2.0, kind="at least"), True),
        (Check("a", 3.0, 2.0, kind="at most"), False),
        (Check("a", math.nan, 2.0, 1.0), False),
        (Check("a", math.nan, 2.0, kind="at most"), False),
    ],
)
def test_a_verdict_follows_from_the_numbers(check, holds):
    assert check.holds is holds
    assert checks_table(1, [check])["verdict"].item() == (HOLDS if holds else FAILS)


def test_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="kind = 'about' is unknown"):
        Check("a", 1.0, 1.0, kind="about")


def test_the_page_states_failures(tmp_path):
    table = checks_table(1, [Check("one | two", 1.0, 1.0), Check("three", 2.0, 1.0, 0.1)])
    page = results_page(table)
    assert page.startswith("1 of 2 checks hold.")
    assert "one \\| two" in page
    assert verdict_counts(table) == {"checks": 2, "hold": 1, "failing": ["three"]}


def test_the_page_of_the_last_study_becomes_a_page_of_the_documentation(tmp_path):
    with pytest.raises(SystemExit, match="run `make verify` first"):
        main(tmp_path)
    (tmp_path / "results" / "verification").mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    page = results_page(checks_table(1, [Check("one", 1.0, 1.0)]))
    (tmp_path / "results" / "verification" / "results.md").write_text(page)
    main(tmp_path)
    written = (tmp_path / "docs" / "verification-table.md").read_text()
    assert written == f"{HEAD}{page.strip()}\n" and "## 1. Closed forms" in written


def test_tables_are_written_with_units_and_as_text(tmp_path):
    table = checks_table(1, [Check("a", 1.0, 1.0, unit="m")])
    write({"checks": table}, {"checks": tmp_path / "checks.parquet"})
    assert read_table(tmp_path / "checks.parquet").equals(table)
    assert read_units(tmp_path / "checks.parquet")["ours"] == "1"
    assert (tmp_path / "checks.csv").read_text().startswith("part,law")


def test_numbers_are_printed_with_four_digits():
    assert plain_number(0.0123456) == "0.01235"
