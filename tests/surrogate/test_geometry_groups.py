"""Groups of the quantities of a geometry: definitions, invariance, and nothing of it on a plate."""

import numpy as np
import pytest

from abradem.config import Config, setup_dict
from abradem.quantities import GEOMETRY_NAMES, SAMPLED, SAMPLED_NAMES, quantity
from abradem.surrogate.geometry_groups import numbers_of, places_of, sampled_names
from abradem.surrogate.groups import (
    GROUP_NAMES,
    Jet,
    group_matrix,
    group_names,
    input_names,
    jet_of,
    squared_impact_speed,
    wear_scale,
)

MIDDLE = {row.name: np.full(1, np.mean(row.paper_range)) for row in SAMPLED}
PLATE = {"length_mm": [200, 400], "width_mm": [100, 300], "angle": [20, 40], "gap_mm": [-50, 50],
         "drop_mm": [0, 300], "belt_m_s": [-1, 2]}  # fmt: skip
SCREW = {"length_mm": [300, 500], "radius_mm": [60, 90], "shaft_radius_mm": [10, 20],
         "pitch_mm": [80, 120], "clearance_mm": [2, 10], "rim_mm": [80, 120],
         "rev_per_min": [-90, 60]}  # fmt: skip


def jet(kind, **keys):
    return jet_of(
        setup_dict(Config(study="x", simulation={"geometry": {"kind": kind, kind: keys or []}}))
    )


def plates(*chain):
    geometry = {"kind": "plates", "plates": list(chain)}
    return jet_of(setup_dict(Config(study="x", simulation={"geometry": geometry})))


def groups_at(of, **values):
    """Groups by name for one case."""
    given = {**MIDDLE, **{name: np.array([value]) for name, value in values.items()}}
    return dict(zip(group_names(of), group_matrix(given, of)[0], strict=True)), given


def test_every_number_of_a_plate_has_its_group():
    of = plates({"length_mm": 300, "width_mm": 300, "angle": "plate_angle"}, PLATE)
    found, given = groups_at(
        of, plate_2_length=0.3, plate_2_width=0.2, plate_2_angle=30.0, plate_2_gap=-0.05,
        plate_2_drop=0.0, plate_2_belt=-1.0,
    )  # fmt: skip
    height, speed = of.fall_height, np.sqrt(squared_impact_speed(given, of)[0])
    expected = {
        "log_plate_2_length": np.log(0.3 / height),
        "log_plate_2_width": np.log(0.2 / height),
        "plate_2_angle": np.radians(30.0),
        "plate_2_gap_ratio": -0.05 / height,
        "plate_2_drop_ratio": 0.0,
        "plate_2_belt_ratio": -1.0 / speed,
    }
    assert group_names(of) == (*GROUP_NAMES, *expected)
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-14), name


def test_every_number_of_an_arc_and_of_a_screw_has_its_group():
    arc = jet("arc", radius_mm=[250, 1000], begin=[60, 80], end=[20, 40], width_mm=[100, 300])
    found, _ = groups_at(arc, arc_radius=0.5, arc_begin=70.0, arc_end=30.0, arc_width=0.2)
    assert found["log_arc_radius"] == pytest.approx(np.log(0.5 / arc.fall_height))
    assert found["arc_begin"] == pytest.approx(np.radians(70.0))
    assert found["log_arc_width"] == pytest.approx(np.log(0.2 / arc.fall_height))
    screw = jet("screw", **SCREW)
    sizes = {"screw_length": 0.4, "screw_shaft_radius": 0.015, "screw_pitch": 0.1,
             "screw_clearance": 0.005, "screw_rim": 0.1}  # fmt: skip
    found, given = groups_at(screw, screw_radius=0.08, screw_revolutions=-60.0, **sizes)
    speed = np.sqrt(squared_impact_speed(given, screw)[0])
    # A turn a second: the rim moves by 2 pi R.
    assert found["screw_revolutions_ratio"] == pytest.approx(-2.0 * np.pi * 0.08 / speed)
    assert found["log_screw_clearance"] == pytest.approx(np.log(0.005 / screw.fall_height))
    assert found["log_screw_rim"] == pytest.approx(np.log(0.1 / screw.fall_height))
    # A fixed radius is that of the geometry.
    fixed = jet("screw", **{**SCREW, "radius_mm": 80})
    found, _ = groups_at(fixed, screw_revolutions=-60.0, **sizes)
    assert found["screw_revolutions_ratio"] == pytest.approx(-2.0 * np.pi * 0.08 / speed)
    assert set(input_names(arc)) | set(input_names(screw)) <= {*SAMPLED_NAMES, *GEOMETRY_NAMES}


def test_the_groups_do_not_depend_on_the_units():
    """Buckingham: other units of length and time, other numbers, the same groups."""
    length, time = 3.0, 0.7
    of = plates({**PLATE, "name": "upper"})
    values = {**MIDDLE, **{name: np.array([0.37]) for name in sampled_names(of.geometry)}}
    powers = {"m": length, "m/s": length / time, "deg": 1.0, "1": 1.0, "kg/m3": length**-3,
              "Pa": 1.0 / (length * time**2), "1/Pa": length * time**2}  # fmt: skip
    scaled = {name: powers[quantity(name).unit] * value for name, value in values.items()}
    other = of._replace(
        fall_height=length * of.fall_height, gravity=of.gravity * length / time**2,
        mass_rate=of.mass_rate / time, plate_area=of.plate_area * length**2,
        patch_area=of.patch_area * length**2,
    )  # fmt: skip
    np.testing.assert_allclose(group_matrix(scaled, other), group_matrix(values, of), rtol=1e-12)
    np.testing.assert_allclose(
        wear_scale(scaled, other), wear_scale(values, of) * length / time, rtol=1e-12
    )


def test_a_plate_has_no_more_inputs_and_is_stored_as_it_was():
    of = jet_of(setup_dict(Config(study="x")))
    assert input_names(of) == SAMPLED_NAMES and group_names(of) == GROUP_NAMES
    assert set(of.stored()) == set(Jet._fields) - {"geometry"}


def test_the_scale_of_a_geometry_is_that_of_its_patch():
    """`simulation.plate` and the factory angle mean nothing beside a geometry."""
    of = jet("arc", radius_mm=[250, 1000])
    assert of.plate_area == of.patch_area and (of.angle_acts, of.arc_radius) == ("level", 0.0)
    assert of.stored()["geometry"]["shape"]["radius"] == "arc_radius"
    assert input_names(of) == (*SAMPLED_NAMES, "arc_radius")


def test_numbers_and_places_of_a_geometry():
    of = plates(
        {"length_mm": 300, "width_mm": 250, "angle": "plate_angle", "name": "upper"},
        {"length_mm": [200, 400], "width_mm": 300, "angle": 150},
    )
    assert numbers_of(of.geometry) == {
        "plate_1_length": 0.3, "plate_1_width": 0.25, "plate_1_angle": "plate_angle",
        "plate_2_length": "plate_2_length", "plate_2_width": 0.3, "plate_2_angle": 150,
    }  # fmt: skip
    assert places_of(of.geometry) == {"upper": "plate_1"}
    assert sampled_names(of.geometry) == ("plate_2_length",)
    assert numbers_of(None) == places_of(None) == {}
    mesh = {"shape": {"kind": "mesh", "file": "chute.stl"}}
    assert numbers_of(mesh) == {} and sampled_names(mesh) == ()
