"""Numbers of the configuration with a unit of their own, and materials by name."""

from pathlib import Path

import jsonschema
import pytest
import yaml

from abradem.config import ConfigError, load_config, read_config, schema
from abradem.config.materials import PARTICLE_MATERIALS, PLATE_MATERIALS, preset
from abradem.quantities import quantity

ROOT = Path(__file__).parents[2]
SCHEMA = jsonschema.Draft202012Validator(schema())


def ranges_of(**given):
    return load_config({"study": "a", "sampling": {"ranges": given}}).sampling.ranges


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [
        ("particle_radius_mm", "2 cm", (20.0, 20.0)),
        ("particle_radius_mm", ["5mm", "0.04 m"], (5.0, 40.0)),
        ("particle_radius_mm", [5, "4 cm"], (5.0, 40.0)),
        ("plate_angle", "45°", (45.0, 45.0)),
        ("plate_angle", ["−10 deg", "10 degrees"], (-10.0, 10.0)),
        ("particle_velocity_y", ["−18 km/h", 0], (-5.0, 0.0)),
        ("particle_shear_modulus_gpa", "6000 MPa", (6.0, 6.0)),
        ("particle_density", "2.65 g/cm³", (2650.0, 2650.0)),
        ("archard_constant", ["0.1 mm³/(N m)", "1e-9 m²/N"], (1e-10, 1e-9)),
    ],
)
def test_a_value_may_name_its_unit(key, text, value):
    assert getattr(ranges_of(**{key: text}), key) == pytest.approx(value, rel=1e-15)
    assert SCHEMA.is_valid({"study": "a", "sampling": {"ranges": {key: text}}})


@pytest.mark.parametrize(
    ("path", "text", "value"),
    [
        (("simulation", "plate", "length_mm"), "0.3 m", 300.0),
        (("simulation", "stop", "window_s"), "5000 ms", 5.0),
        (("simulation", "factory", "mass_rate_kg_s"), "14.4 t/h", 4.0),
        (("simulation", "gravity"), "9.81 m/s²", 9.81),
        (("wear_rate", "element_size_mm"), "5 cm", 50.0),
        (("figures", "angles", "plate"), [0, "30°"], [0.0, 30.0]),
        (("figures", "typical", "particle_velocity_y"), "-2 m/s", -2.0),
    ],
)
def test_every_key_with_a_unit_takes_one(path, text, value):
    document = text
    for name in reversed(path):
        document = {name: document}
    found = load_config({"study": "a", **document})
    for name in path:
        found = getattr(found, name)
    assert found == pytest.approx(value, rel=1e-15)
    assert SCHEMA.is_valid({"study": "a", **document})


@pytest.mark.parametrize("name", ["granite", "Granite", " IRON ORE ", "iron-ore", "steel"])
def test_a_material_stands_for_its_values(name):
    plain = name.strip().lower().replace(" ", "_").replace("-", "_")
    values = {**PLATE_MATERIALS, **PARTICLE_MATERIALS}[plain].values
    who = "equipment" if plain == "steel" else "particle"
    found = ranges_of(**{f"{who}_shear_modulus_gpa": name, f"{who}_density": [name, name]})
    assert getattr(found, f"{who}_shear_modulus_gpa")[0] == pytest.approx(
        values[f"{who}_shear_modulus"] / 1e9
    )
    assert getattr(found, f"{who}_density") == (values[f"{who}_density"],) * 2


@pytest.mark.parametrize(
    ("key", "text", "words"),
    [
        ("particle_radius_mm", "5 kg", "unit 'kg' has another dimension (allowed m, cm, mm"),
        ("particle_radius_mm", "5 MM", "unit 'MM' is unknown, did you mean mm?"),
        ("particle_radius_mm", "5", "must be a number, not text; write it without quotes"),
        ("particle_radius_mm", "1e1", "YAML reads this as text, write 10.0"),
        ("particle_radius_mm", "5,5 mm", "has a decimal comma; write a decimal point"),
        ("particle_radius_mm", "5 m", "5000 is out of range"),
        ("restitution", "50 %", "must be a number"),
        ("plate_angle", "granite", "granite has no plate_angle (it has particle_shear_modulus"),
        ("plate_angle", "graphite", "must be a number"),
    ],
)
def test_what_is_no_such_quantity_is_one_line(key, text, words):
    with pytest.raises(ConfigError) as error:
        ranges_of(**{key: text})
    (line,) = error.value.problems
    assert words in line and f"sampling.ranges.{key}: " in line


def test_the_resolved_configuration_holds_numbers_alone():
    from abradem.config import to_yaml

    config = load_config({"study": "a", "sampling": {"ranges": {"plate_angle": "45°"}}})
    assert yaml.safe_load(to_yaml(config))["sampling"]["ranges"]["plate_angle"] == [45.0, 45.0]


@pytest.mark.parametrize("particle", PARTICLE_MATERIALS)
def test_the_study_of_materials_holds_every_preset_in_its_ranges(particle):
    ranges = read_config(ROOT / "config.yaml", ROOT / "studies/materials.yaml").sampling.ranges
    for name, value in preset(particle).items():
        row = quantity(name)
        low, high = (end * row.config_factor for end in getattr(ranges, row.config_key))
        assert low <= value <= high, name
