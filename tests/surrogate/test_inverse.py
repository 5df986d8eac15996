"""Inverse questions, against closed forms of a surrogate whose wear number is constant."""

import math

import numpy as np
import pytest
from flat_surrogate import NUMBER, SPREAD, write_flat_surrogate

from abradem.cli.main import main
from abradem.quantities import SAMPLED
from abradem.surrogate.groups import Jet, wear_scale
from abradem.surrogate.inverse import least_and_greatest, solve
from abradem.surrogate.model import PredictionError, Surrogate
from abradem.surrogate.networks import RateModel

JET = Jet(0.385, 9.81, 42.0, None, 0.09, 0.09)
CASE = {row.name: float(np.mean(row.paper_range)) for row in SAMPLED} | {"archard_constant": 1e-11}
RATE = 5.0 / (1000.0 * 3600.0)


class Cosine(RateModel):
    """A wear number that is the exponential of a cosine of the plate angle, with known roots."""

    def log_number(self, z):
        # Three and a half waves over 70 degrees; the flat surrogate does not scale its groups.
        return np.cos(np.radians(18.0) * np.degrees(z[:, 8].astype(float))), np.full(len(z), -3.0)


def waves(flat):
    surrogate = Surrogate.load(flat)
    surrogate.models = {name: Cosine(*model) for name, model in surrogate.models.items()}
    return surrogate


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    stem = tmp_path_factory.mktemp("flat") / "surrogate"
    write_flat_surrogate(stem, JET)
    return stem


def test_the_wear_constant_follows_in_closed_form(flat):
    found = solve(Surrogate.load(flat), CASE, "archard_constant", RATE)
    per_constant = wear_scale({**CASE, "archard_constant": 1.0}, JET)
    expected = RATE / (NUMBER * per_constant)
    assert found.roots == pytest.approx([expected], rel=1e-6)
    ((low, high),) = found.spans
    # The scores of the flat surrogate are 2 deviations.
    assert low == pytest.approx(expected * math.exp(-2.0 * SPREAD), rel=1e-6)
    assert high == pytest.approx(expected * math.exp(2.0 * SPREAD), rel=1e-6)
    surrogate = Surrogate.load(flat)
    again = surrogate.predict({**CASE, "archard_constant": found.roots[0]})
    assert again.rate[0] == pytest.approx(RATE, rel=1e-9)


def test_the_speed_follows_from_the_energy(flat):
    """s = W m' v^2 / (2 A) and v^2 = v_y^2 + 2 g H, solved for v_y."""
    found = solve(Surrogate.load(flat), CASE, "particle_velocity_y", RATE)
    scale = RATE / NUMBER
    squared = 2.0 * 0.09 * (scale / 1e3) / (1e-11 * 42.0) - 2.0 * 9.81 * 0.385
    assert found.roots == pytest.approx([-math.sqrt(squared)], rel=1e-6)
    ((low, high),) = found.spans
    assert -10.0 <= low < found.roots[0] < high <= 0.0
    assert found.least < RATE < found.greatest


def test_all_roots_are_found(flat):
    surrogate = waves(flat)
    scale = wear_scale(CASE, JET)
    found = solve(surrogate, CASE, "plate_angle", scale * math.exp(0.5))
    # cos(18 x deg) = 0.5 at 18 x = 60, 300, 420, 660, 780, 1020 and 1140 degrees.
    expected = np.array([60.0, 300.0, 420.0, 660.0, 780.0, 1020.0, 1140.0]) / 18.0
    np.testing.assert_allclose(found.roots, expected, atol=2e-5)
    ends = solve(surrogate, CASE, "plate_angle", scale * math.exp(0.5), ends=(20.0, 40.0))
    np.testing.assert_allclose(ends.roots, expected[2:4], atol=2e-5)
    assert len(solve(surrogate, CASE, "plate_angle", scale * math.exp(1.01)).roots) == 0


def test_least_and_greatest_wear_over_a_range(flat):
    surrogate = waves(flat)
    found = least_and_greatest(surrogate, CASE, "plate_angle", ends=(5.0, 24.0))
    assert found.values == pytest.approx((10.0, 20.0), abs=19.0 / 4000.0)
    scale = wear_scale(CASE, JET)
    rates = [float(one.rate[0]) / scale for one in found.predictions]
    assert rates == pytest.approx([math.exp(-1.0), math.exp(1.0)], rel=1e-4)


def test_a_quantity_without_effect_has_neither_all_values_as_roots_nor_none(flat):
    """No group holds the density of the plate; asked for the very rate, each value gives it."""
    surrogate = waves(flat)
    rate = float(surrogate.predict(CASE).rate[0])
    for wanted in (rate, 2.0 * rate):
        with pytest.raises(PredictionError, match="equipment_density has no effect on the pred"):
            solve(surrogate, CASE, "equipment_density", wanted)


def test_a_quantity_that_was_held_fixed_is_not_sought(flat):
    surrogate = Surrogate.load(flat)
    surrogate.ranges["restitution"] = (0.5, 0.5)
    with pytest.raises(PredictionError, match=r"restitution was held fixed at 0.5"):
        solve(surrogate, CASE, "restitution", RATE)


# Command line


def asked(capsys, flat, *words, without=()):
    values = [f"{name}={value!r}" for name, value in CASE.items() if name not in without]
    code = main(["predict", "--model", str(flat), *values, *words])
    return code, *capsys.readouterr()


def test_the_command_solves(capsys, flat):
    wanted = ["--depth", "5mm", "--hours", "1000"]
    code, out, _ = asked(capsys, flat, "--solve", "archard_constant", *wanted,
                         without=["archard_constant"])  # fmt: skip
    found = solve(Surrogate.load(flat), CASE, "archard_constant", RATE)
    assert code == 0 and out.startswith(f"archard_constant = {found.roots[0]:.4g} 1/Pa, 95 % int")
    code, out, _ = asked(capsys, flat, "--solve", "particle_velocity_y", *wanted,
                         without=["particle_velocity_y"])  # fmt: skip
    found = solve(Surrogate.load(flat), CASE, "particle_velocity_y", RATE)
    first, second = out.splitlines()
    assert first.startswith(f"particle_velocity_y = {found.roots[0]:.4g} m/s, for 5 mm in 1000 h")
    assert f"in {found.spans[0][0]:.4g} ... {found.spans[0][1]:.4g} m/s has 5 mm" in second
    code, out, _ = asked(capsys, flat, "--solve", "particle_velocity_y=-2:-1m/s", *wanted,
                         without=["particle_velocity_y"])  # fmt: skip
    assert code == 0 and out.startswith("none: no particle_velocity_y in -2 ... -1 m/s for 5 mm")


def test_the_command_gives_extremes(capsys, flat):
    code, out, _ = asked(capsys, flat, "--extremes", "particle_velocity_y=-8:-2m/s",
                         "--target", "p99", without=["particle_velocity_y"])  # fmt: skip
    least, greatest = out.splitlines()
    assert code == 0 and "at particle_velocity_y = -2 m/s" in least
    assert "at particle_velocity_y = -8 m/s" in greatest and "95 % interval" in greatest


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--solve", "plate_angle", "--depth", "5"], "--solve needs --depth VALUE and --hours"),
        (["--solve", "plate_angle", "--depth", "5", "--hours", "9"], "plate_angle is also given"),
        (["--solve", "colour", "--depth", "5", "--hours", "9"], "--solve colour: colour: no such"),
        (["--extremes", "plate_angle", "--solve", "plate_angle"], "are two questions; ask one"),
        (["--hours", "9"], "--hours is for --solve"),
        (["--target", "max"], "--target is for --solve and --extremes"),
        (["--extremes", "x", "--map", "a.png"], "--map is not for --extremes"),
        (["--extremes", "x", "--table", "a.csv"], "--extremes is for a single case"),
        (["--extremes", "plate_angle", "--target", "worst"], "predicts wear_friction_p99"),
    ],
)
def test_mistakes_are_one_line(capsys, flat, words, line):
    code, out, err = asked(capsys, flat, *words)
    assert code == 2 and out == "" and any(line in said for said in err.splitlines())


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("plate_angle=60:20", "60 is not below 20"),
        ("plate_angle=20", "'20' is not a range FROM:TO"),
        ("plate_angle=20:60m", "unit 'm' has another dimension"),
        ("plate_angle=20:200", "is impossible"),
    ],
)
def test_a_wrong_range_is_one_line(capsys, flat, text, line):
    code, out, err = asked(capsys, flat, "--extremes", text, without=["plate_angle"])
    assert code == 2 and out == "" and line in err and len(err.splitlines()) == 1
