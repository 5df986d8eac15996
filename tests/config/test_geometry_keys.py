"""Keys of a geometry: what is refused, what they become in SI units, and what is sampled."""

import math

import pytest

from abradem.config import (
    ConfigError,
    geometry_ranges,
    load_config,
    rate_options,
    sampled_ranges,
    setup_dict,
    target_dict,
    typical_case,
)
from abradem.geometry.build import filled_in
from abradem.geometry.kinds import geometry_of

CHAIN = {
    "kind": "plates",
    "plates": [
        {"length_mm": 300, "width_mm": 200, "angle": "plate_angle", "name": "upper"},
        {"length_mm": [250, 500], "width_mm": "20 cm", "angle": [120, 165], "drop_mm": 50,
         "belt_m_s": 1},
    ],
}  # fmt: skip


def configured(geometry, **rest):
    return load_config({"study": "one", "simulation": {"geometry": geometry, **rest}})


def problem(geometry):
    with pytest.raises(ConfigError) as caught:
        configured(geometry)
    (line,) = caught.value.problems
    return line


def test_a_study_of_the_plate_has_the_setup_that_it_had():
    config = load_config({"study": "one"})
    assert "geometry" not in setup_dict(config)
    assert geometry_ranges(config) == {}


def test_a_chain_is_in_si_units_and_its_ranges_are_columns():
    config = configured(CHAIN)
    shape = setup_dict(config)["geometry"]["shape"]
    assert shape["plates"][0] == {
        "name": "upper", "angle": "plate_angle", "length": 0.3, "width": 0.2,
    }  # fmt: skip
    assert shape["plates"][1] == {
        "length": "plate_2_length", "width": 0.2, "angle": "plate_2_angle", "drop": 0.05,
        "belt": 1.0,
    }  # fmt: skip
    assert geometry_ranges(config) == {
        "plate_2_length": [0.25, 0.5], "plate_2_angle": [120.0, 165.0],
    }  # fmt: skip
    case = {"plate_angle": 30.0, "plate_2_length": 0.4, "plate_2_angle": 150.0}
    built = geometry_of(filled_in(shape, case))
    assert built.plates[1].length == 0.4 and built.names() == ["upper", "plate_2"]


@pytest.mark.parametrize("kind", ["arc", "screw"])
def test_the_defaults_of_a_kind_make_a_surface(kind):
    shape = setup_dict(configured({"kind": kind}))["geometry"]["shape"]
    assert len(geometry_of(filled_in(shape, {})).shape(0.05).triangles) > 10


def test_a_range_of_an_arc_is_a_column():
    config = configured({"kind": "arc", "arc": {"radius_mm": [250, 1000]}})
    assert geometry_ranges(config) == {"arc_radius": [0.25, 1.0]}
    assert setup_dict(config)["geometry"]["shape"]["radius"] == "arc_radius"


def test_a_mesh_with_its_motion_and_place():
    config = configured(
        {
            "kind": "mesh",
            "mesh": {"file": "a.stl", "unit": "m", "offset_mm": [0, 100, 0]},
            "moving": [
                {"part": "drum", "rev_per_min": 20, "axis_point_mm": [0, 500, 0], "axis": [0, 0, 1]}
            ],
            "factory_centre_mm": [1, 2, 3],
            "removal_box_mm": [[-1000, -1000, -1000], [1000, 1000, 1000]],
        }
    )
    geometry = setup_dict(config)["geometry"]
    assert geometry["centre"] == [0.001, 0.002, 0.003]
    assert geometry["removal_box"] == [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]
    built = geometry_of(filled_in(geometry["shape"], {}))
    assert built.offset == (0.0, 0.1, 0.0) and built.unit == "m"
    (motion,) = built.motions()
    assert motion.revolutions == 20.0 and motion.axis_point == (0.0, 0.5, 0.0)


def test_elements_are_those_of_the_plate_alone():
    config = configured({"kind": "arc"})
    assert rate_options(config)["element_size"] is None
    assert target_dict(config)["element_size"] is None
    assert math.isclose(rate_options(load_config({"study": "one"}))["element_size"], 0.03)


@pytest.mark.parametrize(
    ("geometry", "line"),
    [
        ({"kind": "plates"}, "geometry.plates: [] (default): kind: plates needs at least one"),
        ({"kind": "mesh"}, "geometry.mesh.file: null (default): kind: mesh needs a file"),
        ({"kind": "cone"}, 'geometry.kind: "cone": is unknown (allowed plate, plates, arc, mesh'),
        (
            {"kind": "arc", "arc": {"begin": 10}},
            "geometry.arc.end: 10.0 (default): must differ from begin",
        ),
        (
            {"kind": "arc", "arc": {"radius_mm": -3}},
            "geometry.arc.radius_mm: -3: -3 is out of range (allowed above 0 up to 100000 mm, or",
        ),
        (
            {"kind": "screw", "screw": {"shaft_radius_mm": [20, 80]}},
            "must be less than that of the flight (allowed below 75 mm)",
        ),
        (
            {"kind": "arc", "moving": [{"part": "arc", "belt_m_s": [1, 0, 0]}]},
            "means nothing beside simulation.geometry.kind: arc (allowed [], the default)",
        ),
        ({"kind": "arc", "jet_direction": [0, 0, 0]}, "must point somewhere"),
        ({"kind": "arc", "jet_direction": [0, 1]}, "must be three numbers, [x, y, z]"),
        (
            {"kind": "arc", "removal_box_mm": [[0, 0, 0], [1, 0, 1]]},
            "the first corner must be lower than the second",
        ),
        (
            {"kind": "plates", "plates": [{"length_mm": 3, "width_mm": 3}]},
            "plate 1: angle is missing (allowed a list of {length_mm",
        ),
        (
            {"kind": "plates", "plates": [{"length_mm": 3, "width_mm": 3, "angle": 3, "long": 3}]},
            "plate 1: unknown key long",
        ),
        (
            {"kind": "plates", "plates": [{"length_mm": "3 kg", "width_mm": 3, "angle": 3}]},
            "plate 1: length_mm: ",
        ),
    ],
)
def test_wrong_keys_are_told_in_one_line(geometry, line):
    assert line in problem(geometry)


def with_key(key, value, **geometry):
    """A study with one key, such as ``figures.typical.plate_angle``, beside a geometry."""
    values = {"study": "one", "simulation": {"geometry": geometry}}
    *above, last = key.split(".")
    section = values
    for name in above:
        section = section.setdefault(name, {})
    section[last] = value
    return values


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("simulation.plate.length_mm", 400),
        ("simulation.plate.width_mm", 400),
        ("simulation.factory.angle_acts", "level"),
        ("simulation.factory.arc_radius_mm", 100),
        ("simulation.geometry.plates", [{"length_mm": 3, "width_mm": 3, "angle": 3}]),
        ("simulation.geometry.mesh.file", "a.stl"),
        ("simulation.geometry.mesh.unit", "m"),
        ("simulation.geometry.screw.rev_per_min", 10),
        ("wear_rate.element_size_mm", 60),
        ("figures.typical.plate_angle", 30),
        ("figures.typical.factory_angle", 0),
        ("figures.angles.duration_s", 3),
        ("figures.movie.plate_angles", [10]),
        ("sampling.ranges.plate_angle", [10, 20]),
        ("sampling.ranges.factory_angle", [-20, 0]),
    ],
)
def test_a_key_that_means_nothing_for_an_arc_is_refused(key, value):
    with pytest.raises(ConfigError) as caught:
        load_config(with_key(key, value, kind="arc"))
    (line,) = caught.value.problems
    assert f"{key}" in line and "means nothing beside simulation.geometry.kind: arc" in line


@pytest.mark.parametrize("kind", ["arc", "mesh", "screw"])
@pytest.mark.parametrize("key", ["factory_centre_mm", "jet_direction", "removal_box_mm"])
def test_keys_of_a_geometry_mean_nothing_for_the_plate(kind, key):
    value = [[-1, -1, -1], [1, 1, 1]] if key == "removal_box_mm" else [1, 2, 3]
    with pytest.raises(ConfigError, match=f"{key}: .*beside simulation.geometry.kind: plate"):
        configured({key: value})
    with pytest.raises(ConfigError, match=f"{kind}.*beside simulation.geometry.kind: plate"):
        configured({kind: {"unit": "m"} if kind == "mesh" else {"width_mm": 5} if kind == "arc"
                    else {"rim_mm": 5}})  # fmt: skip


def test_a_height_beside_a_place_and_a_depth_beside_a_box_mean_nothing():
    geometry = {"kind": "arc", "factory_centre_mm": [0, 500, 0]}
    with pytest.raises(ConfigError, match=r"fall_height_mm: 300: means nothing beside .*centre_mm"):
        configured(geometry, factory={"fall_height_mm": 300})
    geometry = {"kind": "arc", "removal_box_mm": [[-1, -1, -1], [1, 1, 1]]}
    with pytest.raises(ConfigError, match=r"removal_depth_mm: 50: means nothing beside .*box_mm"):
        configured(geometry, removal_depth_mm=50)


def test_a_rate_from_elsewhere_is_for_the_parts_of_a_geometry():
    beside = {"reference_mm_s": 1e-6, "reference_source": "A and B (2021)"}
    known = load_config(with_key("wear_rate", beside, kind="arc")).wear_rate
    assert (known.reference_mm_s, known.reference_source) == (1e-6, "A and B (2021)")
    with pytest.raises(ConfigError, match=r"reference_mm_s: 1.0e-06: means nothing .*kind: plate"):
        load_config(with_key("wear_rate.reference_mm_s", 1e-6))
    alone = with_key("wear_rate.reference_source", "A and B (2021)", kind="arc")
    with pytest.raises(ConfigError, match=r"reference_source: .*beside wear_rate.reference_mm_s"):
        load_config(alone)


def test_the_plate_angle_varies_where_a_chain_takes_it_alone():
    chain = {"kind": "plates", "plates": [{"length_mm": 3, "width_mm": 3, "angle": 30}]}
    assert sampled_ranges(configured(CHAIN))["plate_angle"] == [0.0, 70.0]
    assert sampled_ranges(configured(chain))["plate_angle"] == [0.0, 0.0]
    assert sampled_ranges(configured(CHAIN))["factory_angle"] == [0.0, 0.0]
    with pytest.raises(ConfigError, match=r"kind: plates without angle: plate_angle .allowed one"):
        load_config(with_key("sampling.ranges.plate_angle", [10, 20], **chain))
    number = load_config(with_key("sampling.ranges.plate_angle", 25, **chain))
    assert sampled_ranges(number)["plate_angle"] == [25.0, 25.0]


def test_a_table_from_elsewhere_has_no_geometry():
    values = {"study": "one", "simulation": {"geometry": {"kind": "arc"}},
              "dataset": {"external": "a.csv"}}  # fmt: skip
    with pytest.raises(ConfigError, match=r"kind: .arc.: a table from elsewhere knows the plate"):
        load_config(values)


def test_the_typical_case_of_a_geometry_is_inside_its_ranges():
    config = load_config(
        with_key("sampling.ranges.particle_radius_mm", [20, 30], kind="arc",
                 arc={"radius_mm": [400, 600]})
    )  # fmt: skip
    case = typical_case(config)
    assert case["particle_radius"] == pytest.approx(0.025)
    assert case["particle_velocity_y"] == -3.0
    assert case["arc_radius"] == 0.5 and case["plate_angle"] == 0.0


@pytest.mark.parametrize(
    ("geometry", "learning", "line"),
    [
        ({"kind": "plate"}, {"part": "upper"},
         'learning.part: "upper": is for a simulated geometry'),
        (CHAIN, {"part": "middle"},
         'learning.part: "middle": there is no such plate (allowed upper, plate_2)'),
        (CHAIN, {"part": "upper", "fresh_blocks": 1},
         "learning.fresh_blocks: 1: knows no parts (allowed 0 with learning.part)"),
        (CHAIN, {"part": " "}, 'learning.part: " ": must not be empty'),
    ],
)  # fmt: skip
def test_a_part_that_is_not_there_is_told_in_one_line(geometry, learning, line):
    with pytest.raises(ConfigError) as caught:
        load_config({"study": "x", "simulation": {"geometry": geometry}, "learning": learning})
    (found,) = caught.value.problems
    assert line in found


def test_a_part_is_in_the_target():
    for part in ("upper", "plate_2", None):
        config = load_config(
            {"study": "x", "simulation": {"geometry": CHAIN}, "learning": {"part": part}}
        )
        assert target_dict(config)["part"] == part
