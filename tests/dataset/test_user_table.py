"""The one reader of users' tables: every way to write the same table, and what it refuses."""

import os
import stat

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from tables import product_law

from abradem.dataset.known_names import PUBLISHED_NAMES
from abradem.dataset.user_table import (
    column_values,
    find_columns,
    local_file,
    read_user_table,
    repeated_rows,
    similar_columns,
    unused_columns,
)
from abradem.quantities import SAMPLED_NAMES, quantity
from abradem.store.files import TableError

TABLE = product_law(6)[list(SAMPLED_NAMES)]


def values_of(path, wanted=SAMPLED_NAMES, mapped=None):
    """The quantities that are found in a table, which must all be clear."""
    table = read_user_table(path)
    places, problems = find_columns(table, wanted, mapped)
    assert not problems
    found = {}
    for name, place in places.items():
        found[name], lines = column_values(table, name, place)
        assert not lines
    return found


def problem_of(path, wanted=SAMPLED_NAMES):
    """The one line with which a table is refused."""
    try:
        table = read_user_table(path)
    except TableError as error:
        return str(error)
    places, problems = find_columns(table, wanted)
    lines = list(problems.values())
    for name, place in places.items():
        lines += column_values(table, name, place)[1]
    (line,) = lines
    return line


def equal(found, rtol=0.0):
    assert list(found) == list(SAMPLED_NAMES)
    for name in SAMPLED_NAMES:
        np.testing.assert_allclose(found[name], TABLE[name], rtol=rtol, err_msg=name)


NAMES = {
    "our own": lambda name: name,
    "published": lambda name: PUBLISHED_NAMES[name],
    "capitals": str.upper,
    "title": lambda name: name.replace("_", " ").title(),
    "hyphens": lambda name: name.replace("_", "-"),
    "blanks around": lambda name: f"  {name}\t",
    "symbols": lambda name: quantity(name).symbol,
    "unit in brackets": lambda name: f"{name} [{quantity(name).unit}]",
    "unit in parentheses": lambda name: f"{name}({quantity(name).unit})",
}


@pytest.mark.parametrize("spelling", NAMES)
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_names_are_understood_however_they_are_written(tmp_path, spelling, suffix):
    table = TABLE.rename(columns=NAMES[spelling])
    path = tmp_path / f"t{suffix}"
    table.to_csv(path, index=False) if suffix == ".csv" else table.to_parquet(path, index=False)
    equal(values_of(path))


@pytest.mark.parametrize("separator", [",", ";", "\t", "|", ", ", " ; "])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_separators_are_found(tmp_path, separator, ends):
    rows = [list(TABLE), *([repr(float(cell)) for cell in row] for row in TABLE.to_numpy())]
    path = tmp_path / "t.csv"
    path.write_text(ends.join(separator.join(row) for row in rows) + ends * 2, newline="")
    equal(values_of(path))


@pytest.mark.parametrize("separator", [";", "\t", "|"])
def test_decimal_commas_are_numbers_where_the_separator_is_another(tmp_path, separator):
    path = tmp_path / "t.csv"
    TABLE.assign(label="a, b").to_csv(path, index=False, sep=separator, decimal=",")
    equal(values_of(path), rtol=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "plate_angle,restitution,,\n45,0.5,,\n",
        "sep=;\nplate_angle;restitution\n45;0,5\n",
        "\u200bplate_angle\u200b,restitution\n45,0.5\n",
        "plate_angle in rad;restitution\n0,7853981633974483;0,5\n",
        '"plate_angle, deg",restitution\n45,0.5\n',
        "plate_angle / deg,Restitution / 1\n45,.5\n",
        "X13,X9\n45,0.5\n",
        "plate_angle;restitution;site\n45;0,5;3,4-dioxane\n",
    ],
)
def test_what_other_programs_write_is_read(tmp_path, text):
    path = tmp_path / "t.csv"
    path.write_text(text)
    found = values_of(path)
    assert found["plate_angle"] == pytest.approx([45.0]) and found["restitution"] == [0.5]


def test_other_columns_are_kept_as_they_are(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("plate_angle;label;x4\n45,5;A,1;7\n")
    table = read_user_table(path)
    assert table.frame["label"][0] == "A,1"
    # A coordinate x4 is not the density X4.
    assert "particle_density" not in find_columns(table, SAMPLED_NAMES)[0]
    assert unused_columns(table, ["plate_angle"]) == ["x4"]


@pytest.mark.parametrize("key", ["units", "unit", "Units", "UOM"])
def test_every_key_that_names_a_unit_is_honoured(tmp_path, key):
    path = tmp_path / "t.parquet"
    schema = pa.schema([pa.field("plate_angle", pa.float64(), metadata={key: "rad"})])
    pq.write_table(pa.table({"plate_angle": [0.5]}, schema=schema), path)
    assert values_of(path)["plate_angle"] == pytest.approx(np.degrees([0.5]))


def test_an_index_that_is_no_column_is_refused(tmp_path):
    path = tmp_path / "t.parquet"
    index = pd.RangeIndex(10, 30, 10, name="plate_angle")
    pd.DataFrame({"restitution": [0.2, 0.3]}, index=index).to_parquet(path)
    assert "its index 'plate_angle' is in the metadata for pandas alone" in problem_of(path)


def test_a_mapping_does_not_override_the_unit_of_a_header(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("slope [rad]\n0.5\n")
    table = read_user_table(path)
    _, problems = find_columns(table, ["plate_angle"], {"plate_angle": ["slope [rad]", "deg"]})
    assert "the units 'deg' and 'rad' of plate_angle contradict" in problems["plate_angle"]


def test_whole_numbers_with_gaps_stay_whole(tmp_path):
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table({"id": pa.array([2**60 + 1, None])}), path)
    assert read_user_table(path).frame["id"].tolist() == [2**60 + 1, None]


@pytest.mark.parametrize("suffix", [".CSV", ".Csv", ".PARQUET", ".Pq"])
def test_suffixes_are_known_whatever_their_case(tmp_path, suffix):
    path = tmp_path / f"t{suffix}"
    TABLE.to_csv(path, index=False) if "c" in suffix.lower() else TABLE.to_parquet(path)
    equal(values_of(path))


def test_the_home_folder_and_relative_paths_are_understood(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    TABLE.to_csv("t.csv", index=False)
    for path in ("~/t.csv", "t.csv", "./t.csv", str(tmp_path / "t.csv")):
        equal(values_of(path))


@pytest.mark.parametrize(
    ("column", "factor"),
    [
        ("particle_radius [mm]", 1e3), ("particle_radius (mm)", 1e3), ("particle_radius_mm", 1e3),
        ("Particle Size (µm)", 1e6), ("PARTICLE RADIUS [cm]", 1e2),
    ],
)  # fmt: skip
def test_a_unit_in_the_name_is_honoured(tmp_path, column, factor):
    table = TABLE.assign(**{column: TABLE["particle_radius"] * factor})
    table.drop(columns="particle_radius").to_csv(tmp_path / "t.csv", index=False)
    found = values_of(tmp_path / "t.csv")["particle_radius"]
    np.testing.assert_allclose(found, TABLE["particle_radius"], rtol=1e-15)


def test_units_of_parquet_fields_and_of_a_mapping_are_honoured(tmp_path):
    path = tmp_path / "t.parquet"
    table = pa.table({"particle_radius": [7.0], "size": [7.0], "length (mm)": [7.0]})
    field = table.schema.field(0).with_metadata({"units": "mm"})
    table = table.cast(pa.schema([field, *list(table.schema)[1:]]))
    pq.write_table(table, path)
    name = ["particle_radius"]
    assert values_of(path, name) == {"particle_radius": [0.007]}
    assert values_of(path, name, {"particle_radius": ["size", "mm"]})["particle_radius"] == 0.007
    assert values_of(path, name, {"particle_radius": "length (mm)"})["particle_radius"] == 0.007


def test_units_that_contradict_each_other_are_one_line(tmp_path):
    path = tmp_path / "t.parquet"
    schema = pa.schema([pa.field("particle_radius [cm]", pa.float64(), metadata={"units": "mm"})])
    pq.write_table(pa.table({"particle_radius [cm]": [1.0]}, schema=schema), path)
    assert "the units 'cm' and 'mm' of particle_radius contradict" in problem_of(path)


def test_a_cell_may_carry_its_unit(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("plate_angle,particle_radius (mm)\n45°,20\n0.5 rad,2 cm\n−3,7.5 mm\n")
    found = values_of(path)
    np.testing.assert_allclose(found["plate_angle"], [45.0, np.degrees(0.5), -3.0], rtol=1e-15)
    np.testing.assert_allclose(found["particle_radius"], [0.02, 0.02, 0.0075], rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("plate_angle,restitution\n1,0.5\n2\n", "row 2 has 1 cells, the header has 2"),
        ("plate_angle,restitution\n1,0.5,3\n", "row 1 has 3 cells, the header has 2"),
        ("plate_angle\n1,5\n", "row 1 has 2 cells, the header has 1"),
        ("plate_angle, plate_angle\n1,2\n", "column 'plate_angle' appears twice"),
        ("x,x\n1,2\n", "column 'x' appears twice"),
        ("plate_angle,Plate Angle\n1,2\n", "both contain plate_angle"),
        ("plate_angle,X13\n1,2\n", "both contain plate_angle"),
        ("a;plate_angle,b\n1;2,3\n", "may be separated by a comma or a semicolon"),
        ("plate_angle\n", "holds no rows"),
        ("", "it is empty"),
        ("\n\n", "it is empty"),
        ("plate_angle\ntrue\n", "row 1: plate_angle = 'true' is not a number"),
        ("plate_angle\n1_0\n", "row 1: plate_angle = '1_0' is not a number"),
        ("plate_angle\n0x10\n", "unit 'x10' is unknown"),
        ("plate_angle\nnan\n", "row 1: plate_angle = 'nan' is not a number"),
        ("plate_angle\n1e999\n", "row 1: plate_angle = '1e999' is not a finite number"),
        ("plate_angle\n٣\n", "is not a number"),
        ('plate_angle\n"45,5"\n', "has a decimal comma; write a decimal point"),
        ('particle_density\n"2,650"\n', "has a decimal comma"),
        ('particle_shear_modulus\n"2,000,000,000"\n', "has separators of thousands"),
        ("plate_angle;a\n1,5;x\n2.5;x\n", "mixes decimal commas with points"),
        ("plate_angle;a\n1.000,5;x\n2,5;x\n", "mixes decimal commas with points"),
        ("particle_density;plate_angle\n11.340;45,5\n", "mixes decimal commas with points"),
        ("particle_density;a\n11,340;x\n", "a separator of thousands; write 11.340 or 11340"),
        ("particle_density|a\n7,850|x\n2,650|y\n", "may have a decimal comma or a separator"),
        ("plate_angle\n26.5*100\n", "row 1: plate_angle = '26.5*100' is not a number"),
        ("plate_angle,a\n,1\n", "row 1: plate_angle is empty"),
        ("sep=!\nplate_angle\n1\n", "separator '!' is unknown"),
        ("plate_angle\n1 mm\n", "unit 'mm' has another dimension"),
        ("plate_angle [mm]\n1\n", "unit 'mm' has another dimension"),
        ("plate_angle [steep]\n1\n", "unit 'steep' is unknown"),
        ('plate_angle\n"1\n', "not a CSV table"),
        ("plate_angle\n1\0\n", "it contains a zero byte"),
        ("\ufeffplate_angle\n\udcff\n", "line 2 is not UTF-8 text (byte 0xff); save it as UTF-8"),
        ("plate_angle (\udcb0)\n1\n", "line 1 is not UTF-8 text (byte 0xb0); save it as UTF-8"),
        ("\x1f\udc8b\x08plate_angle\n1\n", "is a packed file or a workbook"),
        ("PK\x03\x04plate_angle\n1\n", "is a packed file or a workbook"),
    ],
)
def test_what_is_unclear_is_one_line(tmp_path, text, words):
    path = tmp_path / "t.csv"
    path.write_text(text, errors="surrogateescape")
    line = problem_of(path)
    assert words in line and len(line.splitlines()) == 1


@pytest.mark.parametrize(
    "column",
    [
        pa.array([True]), pa.array([[1.0]]), pa.array([None], pa.float64()),
        pa.array([0], pa.timestamp("s")), pa.array([1], pa.duration("s")), pa.array([b"1"]),
        pa.array([{"a": 1.0}]), pa.array(["x"]), pa.array([float("inf")]),
    ],
)  # fmt: skip
def test_what_is_no_number_in_parquet_is_one_line(tmp_path, column):
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table({"plate_angle": column}), path)
    assert problem_of(path).startswith("row 1: plate_angle ")


@pytest.mark.parametrize(
    "column",
    [
        pa.array([1]), pa.array(["1"]), pa.array(["1"]).dictionary_encode(), pa.array(["1 deg"]),
        pa.array([1.0], pa.float32()),
    ],
)  # fmt: skip
def test_numbers_in_parquet_are_read_whatever_their_type(tmp_path, column):
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table({"plate_angle": column}), path)
    assert values_of(path) == {"plate_angle": [1.0]}


def test_an_index_of_pandas_is_a_column(tmp_path):
    for suffix in (".parquet", ".csv"):
        path = tmp_path / f"t{suffix}"
        frame = TABLE.set_index("plate_angle")
        frame.to_parquet(path) if suffix == ".parquet" else frame.to_csv(path)
        np.testing.assert_array_equal(values_of(path)["plate_angle"], TABLE["plate_angle"])


@pytest.mark.parametrize("address", ["http://x.org/t.csv", "https://x.org/t.csv", "s3://b/t.parquet",
                                     "file:///t.csv", "ftp://x/t.csv"])  # fmt: skip
def test_nothing_is_fetched(address):
    with pytest.raises(TableError, match="is an address, not a file on this machine"):
        read_user_table(address)


def test_only_regular_files_are_opened(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    (tmp_path / "folder.csv").mkdir()
    for path, words in (
        (pipe, "is a pipe or a device"), (tmp_path / "folder.csv", "is a folder"),
        (tmp_path / "nowhere.csv", "there is no such file"), ("a\0b.csv", "control character"),
        ("a\nb.csv", "control character"), ("~nobody-of-this-name/t.csv", "home directory"),
    ):  # fmt: skip
        with pytest.raises(TableError, match=words):
            local_file(path)


@pytest.mark.parametrize(
    ("column", "name"),
    [
        ("radius", "particle_radius"), ("particle_radios", "particle_radius"),
        ("mean_particle_radius", "particle_radius"), ("plate_angle_rad", "plate_angle"),
        ("inclination angle", "plate_angle"), ("velocity", "particle_velocity_y"),
        ("Restitution coefficient", "restitution"), ("Archard", "archard_constant"),
        ("particle_diameter", "particle_radius"), ("d50 (mm)", "particle_radius"),
        ("COR", "restitution"), ("speed (m/s)", "particle_velocity_y"), ("mu", "static_friction"),
        ("rho [kg/m3]", "particle_density"), ("theta", "factory_angle"),
        ("plate_angle (steep)", "plate_angle"),
    ],
)  # fmt: skip
def test_a_column_that_may_be_meant_is_told(tmp_path, column, name):
    path = tmp_path / "t.csv"
    pd.DataFrame({column: [1.0], "site": ["x"], "particle": [1], "wear_note": [""]}).to_csv(
        path, index=False
    )
    table = read_user_table(path)
    assert similar_columns(table, name, []) == [column]
    assert similar_columns(table, name, [column]) == []


def test_repeated_rows_are_counted_and_named():
    columns = {"a": np.array([1.0, 2.0, 1.0, 3.0, 2.0, 1.0]), "b": np.zeros(6)}
    assert repeated_rows(columns) == (
        "5 rows repeat the quantities of another, in 2 groups (rows 1+3+6, 2+5)"
    )
    assert repeated_rows({"a": np.arange(3.0)}) == ""
