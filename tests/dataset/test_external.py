"""External tables: reading, checking, and one line for each problem."""

import os

import numpy as np
import pandas as pd
import pytest
from tables import drawn, linear_law, product_law

from abradem.dataset.external import read_external
from abradem.dataset.features import derive
from abradem.dataset.known_names import PUBLISHED_NAMES
from abradem.learning.baselines.linear import fit_linear
from abradem.learning.baselines.penalised import fit_penalised
from abradem.learning.rows import learning_table
from abradem.quantities import FEATURE_NAMES, SAMPLED_NAMES
from abradem.store.files import TableError
from abradem.store.tables import write_table

AUTHORS_TABLE = "ABRADEM_AUTHORS_TABLE"
"""Names a file, if there is one: half of the study's table, its even rows."""


@pytest.fixture
def published(tmp_path):
    """A table with the study's column names, without three derived columns."""
    table = product_law(30)[[*FEATURE_NAMES, "wear_total_mean"]]
    left_out = ["effective_youngs_modulus", "effective_shear_modulus", "damping_ratio"]
    table = table.drop(columns=left_out).rename(columns=PUBLISHED_NAMES)
    return table, tmp_path / "table.csv"


def refused(table, path, columns=None, **to_csv):
    table.to_csv(path, index=False, **to_csv)
    with pytest.raises(TableError) as error:
        read_external(path, columns)
    lines = str(error.value).splitlines()
    assert all(line.startswith(str(path)) for line in lines)
    return [line.removeprefix(f"{path}: ") for line in lines]


def test_the_studys_column_names_are_understood_and_derived_features_computed(published):
    table, path = published
    table.to_csv(path, index=False)
    found = read_external(path)
    expected = product_law(30)
    assert list(found) == ["case_id", *FEATURE_NAMES, "wear_total_mean"]
    np.testing.assert_allclose(found[list(FEATURE_NAMES)], expected[list(FEATURE_NAMES)], rtol=1e-9)


def test_derived_columns_are_taken_as_they_stand(published):
    table, path = published
    name = PUBLISHED_NAMES["equipment_youngs_modulus"]
    rounded = table[name].map(lambda value: float(f"{value:.3g}"))
    table.assign(**{name: rounded}).to_csv(path, index=False)
    found = read_external(path)
    np.testing.assert_array_equal(found["equipment_youngs_modulus"], rounded)
    # Derived features are computed from the values in the table.
    exact = derive(drawn(30))["effective_youngs_modulus"]
    assert 0.0 < np.abs(found["effective_youngs_modulus"] / exact - 1.0).max() < 0.01


def test_columns_and_units_of_ones_own_are_mapped(tmp_path):
    table = product_law(20)[[*SAMPLED_NAMES, "wear_total_mean"]]
    own = table.rename(columns={"particle_radius": "grain radius", "plate_angle": "inclination"})
    own = own.assign(**{"grain radius": 1e3 * own["grain radius"]})
    own["inclination"] = np.radians(own["inclination"])
    path = tmp_path / "own.csv"
    own.to_csv(path, index=False)
    mapping = {"particle_radius": ["grain radius", "mm"], "plate_angle": ["inclination", "rad"]}
    found = read_external(path, mapping)
    for name in ("particle_radius", "plate_angle"):
        np.testing.assert_allclose(found[name], table[name], rtol=1e-9)


def test_units_of_parquet_fields_are_read(tmp_path):
    from abradem.store.columns import Column

    table = product_law(20)[["case_id", *SAMPLED_NAMES, "wear_total_mean"]]
    table["particle_shear_modulus"] /= 1e9
    path = tmp_path / "own.parquet"
    write_table(table, path, {"particle_shear_modulus": Column("GPa", "shear modulus")})
    expected = product_law(20)["particle_shear_modulus"]
    np.testing.assert_allclose(read_external(path)["particle_shear_modulus"], expected)


def test_each_bad_row_is_one_line(published):
    table, path = published
    table = table.astype(object)
    table.loc[3, "Plate Angle"] = "steep"
    table.loc[5, "Wear Rate"] = ""
    assert refused(table, path) == [
        "row 4: Plate Angle = 'steep' is not a number",
        "row 6: Wear Rate is empty",
    ]
    table.loc[3, "Plate Angle"], table.loc[5, "Wear Rate"] = 30.0, 1.0
    table.loc[7, "Coefficient of Restitution (Interaction)"] = 1.2
    table.loc[9, "Wear Rate"] = -0.1
    assert refused(table, path) == [
        "row 8: restitution (column 'Coefficient of Restitution (Interaction)') = 1.2 must lie in "
        "[0.05, 1] 1",
        "row 10: wear_total_mean (column 'Wear Rate') = -0.1 mm/s must be positive",
    ]


def test_many_bad_rows_are_counted(tmp_path):
    table = product_law(60)[[*SAMPLED_NAMES, "wear_total_mean"]]
    table.loc[:40, "restitution"] = 3.0
    lines = refused(table, tmp_path / "t.csv")
    assert len(lines) == 21 and lines[-1] == "and 21 more such lines"


def test_a_wrong_unit_is_one_line(published):
    table, path = published
    table["Particle Size"] *= 1e3
    (line,) = refused(table, path)
    assert line.startswith(
        "column particle_radius (column 'Particle Size'): all 30 values are out of"
    )
    assert line.endswith("must lie in [0.0001, 0.1] m; give its unit with dataset.columns")
    table["Particle Size"] /= 1e3
    table["Young's Modulus (Material)"] /= 1e9
    (line,) = refused(table, path)
    assert line.startswith("column particle_youngs_modulus: is 1e-09 times the value of its")


def test_missing_columns_are_one_line_each(published):
    table, path = published
    lines = refused(table.drop(columns=["Plate Angle", "Wear Rate"]), path)
    assert len(lines) == 2
    assert lines[0].startswith("lacks a column for plate_angle (looked for plate_angle, Plate")
    assert lines[1].startswith("lacks a wear rate")


def test_a_wrong_mapping_is_one_line(published):
    table, path = published
    for columns, words in (
        ({"slope": "Plate Angle"}, "mapping of slope: no such quantity; known are "),
        ({"plate_angle": "Slope"}, "lacks column 'Slope', which plate_angle is mapped to"),
        ({"plate_angle": ["Plate Angle", "gon"]},
         "column 'Plate Angle', for plate_angle: unit 'gon' is unknown (allowed deg, rad)"),
    ):  # fmt: skip
        lines = refused(table, path, columns)
        assert any(line.startswith(words) for line in lines), lines


def test_a_column_of_words_is_one_line(published):
    table, path = published
    (line,) = refused(table.assign(**{"Plate Angle": "x"}), path)
    assert line == "column 'Plate Angle': contains no numbers (first 'x' is not a number)"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("t.csv", "", "not a CSV table"),
        ("t.txt", "a", "is neither .csv nor .parquet"),
        ("t.parquet", "a", "not Parquet"),
    ],
)
def test_what_is_no_table_is_one_line(tmp_path, name, text, words):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(TableError, match=words):
        read_external(path)
    with pytest.raises(TableError, match="no such file"):
        read_external(tmp_path / "nowhere.csv")


def test_a_byte_order_mark_and_blanks_in_the_header_do_no_harm(published):
    table, path = published
    table.rename(columns=lambda name: f" {name} ").to_csv(path, index=False, encoding="utf-8-sig")
    assert len(read_external(path)) == 30


@pytest.mark.skipif(AUTHORS_TABLE not in os.environ, reason=f"{AUTHORS_TABLE} names no file")
def test_the_published_figures_come_out_on_half_of_the_studys_table():
    table = read_external(os.environ[AUTHORS_TABLE])
    assert len(table) == 99
    results = fit_penalised(learning_table(table), repeats=2).results.scores
    scores = pd.concat([fit_linear(table, repeats=2).scores, results])
    rows = scores.query("protocol == 'as_published' and split == 'test' and metric == 'R2'")
    found = rows.set_index("model")["value"]
    assert found["linear"] == pytest.approx(0.5958, abs=5e-5)
    assert found["lasso"] == pytest.approx(0.6577, abs=5e-5)
    assert found["ridge"] == pytest.approx(0.6768, abs=5.1e-5)


def test_our_own_names_need_no_mapping(tmp_path):
    path = tmp_path / "t.csv"
    linear_law(20)[[*SAMPLED_NAMES, "wear_total_mean"]].to_csv(path, index=False)
    assert len(read_external(path)) == 20


def test_a_data_set_of_our_own_is_a_table_like_any_other(tmp_path):
    table = product_law(20).assign(wear_sliding_p99=0.0, wear_friction_mean=-0.1)
    table["case_id"] += 7
    path = tmp_path / "dataset.parquet"
    # Rows in another order are the same table: cases keep their numbers.
    write_table(table.sample(frac=1.0, random_state=1), path)
    found = read_external(path).sort_values("case_id", ignore_index=True)
    for name in ("case_id", *FEATURE_NAMES, "wear_total_mean", "wear_sliding_p99"):
        np.testing.assert_array_equal(found[name], table[name])
    lines = refused(table.assign(case_id=3).iloc[:5], tmp_path / "t.csv")
    assert lines == ["column 'case_id': must contain whole numbers, each once"]
    twice = table.assign(**{"case_id ": table["case_id"]})
    assert refused(twice, tmp_path / "t.csv") == ["column 'case_id' appears twice"]
    lines = refused(table.assign(wear_sliding_p99=-0.5).iloc[:1], tmp_path / "t.csv")
    assert lines == ["row 1: wear_sliding_p99 = -0.5 mm/s must not be negative"]


def test_an_elastic_rebound_leaves_no_damping_and_contradicts_nothing(tmp_path):
    cases = product_law(20)
    cases.loc[3, "restitution"] = 1.0
    table = derive(cases).assign(wear_total_mean=cases["wear_total_mean"])
    path = tmp_path / "t.csv"
    table.to_csv(path, index=False)
    assert read_external(path).loc[3, "damping_coefficient"] == 0.0


def test_a_single_derived_value_that_contradicts_its_formula_is_one_line(published):
    table, path = published
    formula = table.loc[4, "Young's Modulus (Material)"]
    table.loc[4, "Young's Modulus (Material)"] *= 10.0
    assert refused(table, path) == [
        f"row 5: particle_youngs_modulus = {10.0 * formula:g} contradicts its formula, which "
        f"gives {formula:g}"
    ]


def test_the_missing_damping_coefficient_takes_the_form_asked_for(tmp_path):
    path = tmp_path / "t.csv"
    product_law(20)[[*SAMPLED_NAMES, "wear_total_mean"]].to_csv(path, index=False)
    table, printed = (read_external(path, None, form) for form in ("table", "printed"))
    ratio = printed["damping_coefficient"] / table["damping_coefficient"]
    np.testing.assert_allclose(ratio, -np.sqrt(6.0 / 5.0))


def test_columns_that_could_be_confused_are_refused(published):
    table, path = published
    twice = table.assign(**{" Plate Angle": 0.0})
    assert refused(twice, path) == ["column 'Plate Angle' appears twice"]
    both = table.assign(plate_angle=0.0)
    assert refused(both, path) == [
        "columns 'Plate Angle' and 'plate_angle' both contain plate_angle; keep one, or choose "
        "with dataset.columns"
    ]
    read_external(path, {"plate_angle": "Plate Angle"})
    lines = refused(table, path, {"factory_angle": "Plate Angle"})
    assert lines == ["column 'Plate Angle' is mapped to both plate_angle and factory_angle"]


def test_a_field_too_many_shifts_no_column(published):
    table, path = published
    header, *rows = table.to_csv(index=False).splitlines()
    path.write_text("\n".join([header, *(f"1,{row}" for row in rows)]))
    with pytest.raises(TableError, match="row 1 has 19 cells, the header has 18"):
        read_external(path)
