"""Mesh files: what is read is what was written, and faults are told in one line."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from abradem.geometry.chute import transfer_chute
from abradem.geometry.mesh_files import read_mesh, write_stl
from abradem.geometry.shape import GeometryError, areas

ROOT = Path(__file__).parents[2]
SHAPE = transfer_chute()


@pytest.fixture
def chute(tmp_path):
    write_stl(SHAPE, tmp_path / "chute.stl")
    return tmp_path / "chute.stl"


def area_by_part(shape):
    found = areas(shape.vertices, shape.triangles)
    return {name: found[shape.part == part].sum() for part, name in enumerate(shape.names)}


def test_an_stl_file_with_named_solids_comes_back(chute):
    found = read_mesh(chute, "mm")
    assert set(found.names) == set(SHAPE.names)
    assert len(found.vertices) == len(SHAPE.vertices)
    before = area_by_part(SHAPE)
    for name, area in area_by_part(found).items():
        assert area == pytest.approx(before[name], rel=1e-6)
    assert np.allclose(found.vertices.min(axis=0), SHAPE.vertices.min(axis=0), atol=1e-7)


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj"])
@pytest.mark.parametrize(("unit", "factor"), [("mm", 1e3), ("m", 1.0), ("in", 1.0 / 0.0254)])
def test_other_formats_and_units_give_the_same_surface(tmp_path, suffix, unit, factor):
    path = tmp_path / f"part.{suffix}"
    trimesh.Trimesh(factor * SHAPE.vertices, SHAPE.triangles, process=False).export(path)
    found = read_mesh(path, unit, up="y")
    assert found.names == ("part",)
    assert len(found.triangles) == len(SHAPE.triangles)
    assert len(found.vertices) == len(SHAPE.vertices)
    total = areas(found.vertices, found.triangles).sum()
    assert total == pytest.approx(areas(SHAPE.vertices, SHAPE.triangles).sum(), rel=1e-6)


def test_objects_of_an_obj_file_are_parts(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    (tmp_path / "two.obj").write_text(f"{corners}o floor\nf 1 2 3\no wall\nf 1 2 4\n")
    found = read_mesh(tmp_path / "two.obj", "m")
    assert found.names == ("floor", "wall")
    assert np.bincount(found.part).tolist() == [1, 1]


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_the_axis_that_points_up_becomes_y_by_a_rotation(tmp_path, up):
    axis = "xyz".index(up)
    vertices = np.zeros((3, 3))
    vertices[1, (axis + 1) % 3] = vertices[2, axis] = 1.0
    path = tmp_path / "one.ply"
    trimesh.Trimesh(vertices, [[0, 1, 2]], process=False).export(path)
    found = read_mesh(path, "m", up=up)
    assert found.vertices[:, 1].max() == pytest.approx(1.0)
    assert np.ptp(found.vertices[:, [0, 2]], axis=0).max() == pytest.approx(1.0)


def test_rotations_keep_right_handedness():
    from abradem.geometry.mesh_files import UPS

    for rotation in UPS.values():
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        assert np.allclose(rotation @ rotation.T, np.eye(3))


def _folder(path):
    path.mkdir()
    return path


def message(*args, **options):
    with pytest.raises(GeometryError) as caught:
        read_mesh(*args, **options)
    text = str(caught.value)
    assert ("\n" not in text and "allowed" in text) or "cannot be read" in text
    return text


def test_a_wrong_unit_is_told_with_those_that_would_do(chute):
    assert "is 1178.98 m large with unit m" in message(chute, "m")
    assert "is the unit mm (1.17898 m)" in message(chute, "m")


FACET = """facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 400 0 0
  vertex 400 300 0
 endloop
endfacet
"""
BINARY = (
    b"x" * 80 + (1).to_bytes(4, "little")
    + np.array([0, 0, 1, 0, 0, 0, 400, 0, 0, 400, 300, 0], "<f4").tobytes() + b"\0\0"
)  # fmt: skip


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "the file is empty"),
        ("<!DOCTYPE html>", "it is no STL file, it begins with '<!DOCTYPE html>'"),
        ("solid a\nendsolid a\n", "it has no triangles"),
        (f"solid a\n{FACET}", "it is cut off: no endsolid closes its last solid"),
        (f"solid a\n{FACET}endsolid a\nsolid b\n{FACET}",
         "of its 2 facets 1 are in a solid that is cut off"),
        (f"solid a\n{FACET.replace('400 0 0', '400,5 0 0')}endsolid a\n",
         "line 5: 'vertex 400,5 0 0' (allowed: vertex and three numbers with a decimal point)"),
        (BINARY[:-9], "it is cut off or no STL file: 1 triangles are 134 bytes, and it has 125"),
        (f"solid a\n{FACET.replace('400 300 0', '800 0 0')}endsolid a\n",
         "no triangle has an area (allowed: at least one)"),
        (f"solid a\n{FACET.replace('400 0 0', 'inf 0 0')}endsolid a\n",
         "a coordinate is not a finite number"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("error")
def test_what_is_wrong_with_an_stl_file_is_told(tmp_path, content, words):
    path = tmp_path / "a.stl"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert words in message(path, "mm")


@pytest.mark.parametrize(
    ("name", "content", "part"),
    [
        ("a.stl", f"solid my chute\n{FACET}endsolid my chute\n", "my chute"),
        ("a.stl", f"solid\n{FACET}endsolid\n", "a"),
        ("a.stl", BINARY, "a"),
        ("a.obj", "o hood\nv 0 0 0\nv 400 0 0\nv 400 300 0\nf 1 2 3\n", "hood"),
        ("a.obj", "v 0 0 0\nv 400 0 0\nv 400 300 0\nf 1 2 3\n", "a"),
    ],
)
def test_a_single_solid_has_its_name_in_the_file(tmp_path, name, content, part):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert read_mesh(path, "mm").names == (part,)


def test_files_that_are_no_meshes_are_told(tmp_path):
    assert "is a folder (allowed: a mesh file)" in message(_folder(tmp_path / "b.stl"), "mm")
    (tmp_path / "words.stl").write_text("no mesh")
    (tmp_path / "empty.ply").write_text("")
    assert "there is no such file" in message(tmp_path / "none.stl", "mm")
    assert "is not a mesh file (allowed: .stl, .obj, .ply)" in message(tmp_path / "a.step", "mm")
    assert "words.stl" in message(tmp_path / "words.stl", "mm")
    assert "empty.ply" in message(tmp_path / "empty.ply", "mm")
    assert "unit = 'yd'" in message(tmp_path / "words.stl", "yd")


def test_faulty_triangles_are_told_and_left_out_on_demand(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\n"
    (tmp_path / "flat.obj").write_text(f"{corners}f 1 2 3\nf 1 2 4\n")
    (tmp_path / "twice.obj").write_text(f"{corners}f 1 2 3\nf 3 1 2\n")
    assert "has 1 triangle without area, the first is number 2" in message(
        tmp_path / "flat.obj", "m"
    )
    assert "has 1 triangle that is in it twice" in message(tmp_path / "twice.obj", "m")
    for name in ("flat", "twice"):
        assert len(read_mesh(tmp_path / f"{name}.obj", "m", repair=True).triangles) == 1


def test_the_chute_of_the_study_is_the_one_that_the_project_generates(chute):
    assert (ROOT / "studies/chute.stl").read_bytes() == chute.read_bytes()
