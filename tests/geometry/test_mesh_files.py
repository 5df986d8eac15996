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


def message(*args, **options):
    with pytest.raises(GeometryError) as caught:
        read_mesh(*args, **options)
    text = str(caught.value)
    assert ("\n" not in text and "allowed" in text) or "cannot be read" in text
    return text


def test_a_wrong_unit_is_told_with_those_that_would_do(chute):
    assert "is 1178.98 m large with unit m" in message(chute, "m")
    assert "is the unit mm (1.17898 m)" in message(chute, "m")


def test_files_that_are_no_meshes_are_told(tmp_path):
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
    assert "has 1 triangles without area, the first is number 2" in message(
        tmp_path / "flat.obj", "m"
    )
    assert "has 1 triangles that are in it twice" in message(tmp_path / "twice.obj", "m")
    for name in ("flat", "twice"):
        assert len(read_mesh(tmp_path / f"{name}.obj", "m", repair=True).triangles) == 1


def test_the_chute_of_the_study_is_the_one_that_the_project_generates(chute):
    assert (ROOT / "studies/chute.stl").read_bytes() == chute.read_bytes()
