"""Numbers of a geometry by their names on the command line: predict, simulate and sweep."""

import numpy as np
import pandas as pd
import pytest
from flat_surrogate import flat_prediction, write_flat_surrogate

import abradem.simulation.batch
from abradem.cli.given_values import given_values, quantity_named
from abradem.cli.main import main
from abradem.config import load_config, setup_dict
from abradem.quantities import SAMPLED
from abradem.surrogate.groups import jet_of
from abradem.surrogate.model import PredictionError

MIDDLE = {row.name: sum(row.paper_range) / 2 for row in SAMPLED}
CHAIN = """
study: chain
simulation:
  geometry:
    kind: plates
    plates:
      - {length_mm: 300, width_mm: 300, angle: plate_angle, name: upper}
      - {length_mm: [400, 600], width_mm: 300, angle: [120, 165], gap_mm: 400, drop_mm: 250,
         belt_m_s: [0, 2], name: lower}
"""
KEYS = {
    "geometry": {
        "kind": "plates",
        "plates": [
            {"length_mm": 300, "width_mm": 300, "angle": "plate_angle", "name": "upper"},
            {"length_mm": [400, 600], "width_mm": 300, "angle": [120, 165], "gap_mm": 400,
             "drop_mm": 250, "belt_m_s": [0, 2], "name": "lower"},
        ],
    }
}  # fmt: skip
JET = jet_of(setup_dict(load_config({"study": "chain", "simulation": KEYS})))
GEOMETRY = JET.geometry


def words(values):
    return [f"{name}={value!r}" for name, value in values.items()]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").write_text(CHAIN)
    return tmp_path


def run(capsys, *arguments):
    code = main([str(one) for one in arguments])
    out, err = capsys.readouterr()
    return code, out.splitlines(), err.splitlines()


@pytest.mark.parametrize(
    ("text", "name", "value"),
    [
        ("lower.angle=150deg", "plate_2_angle", 150.0),
        ("lower.angle=2.5 rad", "plate_2_angle", np.degrees(2.5)),
        ("plate_2.angle=150", "plate_2_angle", 150.0),
        ("plate_2_angle=150", "plate_2_angle", 150.0),
        ("Lower.Length=450mm", "plate_2_length", 0.45),
        ("lower.length_mm=450", "plate_2_length", 0.45),
        ("lower.belt=1.5m/s", "plate_2_belt", 1.5),
        ("lower.belt_m_s=1.5", "plate_2_belt", 1.5),
        # The angle of the upper plate is the sampled plate angle.
        ("upper.angle=30", "plate_angle", 30.0),
        ("plate_angle=30", "plate_angle", 30.0),
    ],
)
def test_a_number_of_a_part_has_several_names(text, name, value):
    found = given_values([text], None, GEOMETRY).values
    assert found == pytest.approx({name: value}, rel=1e-12)


def test_a_screw_takes_revolutions():
    screw = {"shape": {"kind": "screw", "radius": 0.08, "revolutions": "screw_revolutions"}}
    for text in ("screw.revolutions=60rpm", "screw.rev_per_min=60", "screw.revolutions=1/s"):
        if text.endswith("1/s"):
            with pytest.raises(PredictionError, match="screw_revolutions = '1/s'"):
                given_values([text], None, screw)
        else:
            assert given_values([text], None, screw).values == {"screw_revolutions": 60.0}


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("lower.angel=150", "lower.angel (did you mean "),
        ("lower.radius=1", "lower.radius"),
        ("lower.length=0", "plate_2_length = 0 m is impossible (allowed 1e-06 ... 100 m)"),
        ("lower.angle=1 kg", "plate_2_angle = '1 kg'"),
    ],
)
def test_a_wrong_name_or_value_is_one_line(capsys, here, text, line):
    write_flat_surrogate(here / "s", JET)
    rest = {**MIDDLE, "plate_2_length": 0.5, "plate_2_angle": 150.0, "plate_2_belt": 1.0}
    rest = {name: value for name, value in rest.items() if not line.startswith(name)}
    code, _, err = run(capsys, "predict", *words(rest), text, "--model", here / "s")
    assert code != 0 and line in err[0]


def test_without_a_geometry_its_names_are_unknown():
    assert quantity_named("lower.angle", None) is None
    with pytest.raises(PredictionError, match=r"plate_2_angle.*no such quantity"):
        given_values(["plate_2_angle=150"], None)


def test_predict_takes_the_numbers_of_the_geometry(capsys, here):
    write_flat_surrogate(here / "results/chain/models/surrogate", JET)
    given = [*words(MIDDLE), "lower.length=500mm", "lower.angle=150deg"]
    code, out, err = run(capsys, "predict", *given, "lower.belt=1m/s")
    rate, low, high = flat_prediction(MIDDLE, JET)
    assert code == 0 and err == []
    assert out[0].startswith(
        f"wear depth rate {rate:.4g} mm/s, 95 % interval {low:.4g} to {high:.4g}"
    )
    code, _, err = run(capsys, "predict", *given)
    assert code != 0 and err == ["missing: plate_2_belt"]
    code, _, err = run(capsys, "predict", *given, "lower.belt=1", "lower.width=200mm")
    assert code != 0 and err == [
        "fixed in the study of this surrogate: plate_2_width at 0.3 m (allowed of its "
        "geometry: plate_2_length, plate_2_angle, plate_2_belt)"
    ]
    code, _, err = run(capsys, "predict", *given, "lower.belt=1", "--map", "map.png")
    assert code != 0 and "the map of a geometry is not predicted" in err[0]


def test_inverse_questions_take_the_numbers_of_the_geometry(capsys, here):
    write_flat_surrogate(here / "results/chain/models/surrogate", JET)
    given = [*words(MIDDLE), "lower.length=500mm", "lower.belt=1"]
    code, out, _ = run(capsys, "predict", *given, "--extremes", "lower.angle=120:165deg")
    assert code == 0 and out[0].startswith("least wear depth rate at plate_2_angle = ")
    code, _, err = run(capsys, "predict", *given, "--extremes", "lower.drop")
    assert code != 0 and "fixed in the study of this surrogate: plate_2_drop at 0.25 m" in err[0]


def test_a_table_has_the_numbers_of_the_geometry_as_columns(capsys, here):
    write_flat_surrogate(here / "results/chain/models/surrogate", JET)
    table = pd.DataFrame([MIDDLE, MIDDLE]).assign(
        plate_2_length_mm=[450.0, 500.0], plate_2_angle=[130.0, 150.0]
    )
    table.to_csv("cases.csv", index=False)
    code, out, err = run(capsys, "predict", "lower.belt=1", "--table", "cases.csv")
    assert code == 0, err
    assert len(out) == 3 and "wear_depth_rate" in out[0]
    assert any("plate_2_belt = 1 m/s (command line)" in line for line in err)


@pytest.fixture
def asked(monkeypatch):
    """Cases and set-ups that would be simulated."""
    found = []

    class Enough(Exception):
        pass

    def run_case(row, setup, progress=None, threads=1):
        found.append((row, setup))
        raise Enough

    monkeypatch.setattr(abradem.simulation.batch, "run_case", run_case)
    return found, Enough


def test_simulate_takes_sampled_and_fixed_numbers(capsys, here, asked):
    found, enough = asked
    with pytest.raises(enough):
        main(["simulate", "upper.angle=30", "lower.angle=150deg", "lower.width=250mm",
              "particle_velocity_y=-2", "particle_radius=15mm"])  # fmt: skip
    ((row, setup),) = found
    assert (row["plate_angle"], row["plate_2_angle"], row["plate_2_width"]) == (30.0, 150.0, 0.25)
    # What is sampled and not given is in the middle of its range.
    assert (row["plate_2_length"], row["plate_2_belt"]) == (0.5, 1.0)
    lower = setup["geometry"]["shape"]["plates"][1]
    assert lower["width"] == "plate_2_width" and lower["drop"] == 0.25
    _, err = capsys.readouterr()
    assert "plate_2_length = 0.5 m" in err and "plate_2_angle" not in err


def test_a_surrogate_of_another_kind_of_surface_is_refused_before_the_simulation(capsys, here):
    write_flat_surrogate(here / "plate", jet_of(setup_dict(load_config({"study": "x"}))))
    code, _, err = run(
        capsys, "simulate", "particle_velocity_y=-2", "particle_radius=15mm", "--model",
        here / "plate",
    )  # fmt: skip
    assert code != 0
    assert "predicts the wear of a surface of kind plate, this case has plates" in err[-1]
    code, _, err = run(
        capsys, "sweep", "plate_angle=20,30", "--surrogate", "--model", here / "plate"
    )
    assert code != 0
    assert "predicts the wear of a surface of kind plate, this case has plates" in err[-1]


def test_a_sweep_takes_lists_of_the_numbers_of_the_geometry(capsys, here):
    write_flat_surrogate(here / "results/chain/models/surrogate", JET)
    code, out, err = run(
        capsys, "sweep", "--surrogate", "lower.angle=130,140,150deg", "lower.length=450mm",
        "particle_velocity_y=-2",
    )  # fmt: skip
    assert code == 0 and len(out) == 4, err
    header, *rows = (line.split(",") for line in out)
    place = next(k for k, name in enumerate(header) if name.startswith("plate_2_angle"))
    assert [float(row[place]) for row in rows] == [130.0, 140.0, 150.0]
