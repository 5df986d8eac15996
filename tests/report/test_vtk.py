"""Files for ParaView: the values written are the values read."""

import base64
import xml.etree.ElementTree as ElementTree

import numpy as np
import pandas as pd
import pytest

from abradem.config import load_config, typical_case
from abradem.dem.model import Setup
from abradem.geometry.build import case_surface
from abradem.geometry.kinds import Screw
from abradem.report.vtk import case_values, particles_vtp, plate_facets, write_vtk
from abradem.store.files import TableError
from abradem.wear.depths import cell_depth_frames, depth_frames

SETUP = Setup(plate_length=0.4, plate_width=0.2, facet_size=0.1)
CASE = typical_case(load_config({"study": "x"}))
TIMES = (0.0, 0.5)


def snapshots():
    rng = np.random.default_rng(0)
    particles = pd.DataFrame(
        rng.normal(size=(3, 9)), columns=["x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
    ).assign(particle=[4, 7, 9], time=0.5)
    x, z = (index.ravel() for index in np.indices(SETUP.facets))
    wear = pd.concat(
        pd.DataFrame(
            {
                "time": time, "facet_x": x, "facet_z": z, "wear_total": time * (10.0 * x + z),
                "wear_sliding": time, "wear_friction": 0.0,
            }
        )
        for time in TIMES
    )  # fmt: skip
    # The order of the rows is not guaranteed.
    return particles, wear.sample(frac=1.0, random_state=0)


def arrays(path):
    """Every array of a file by its name, decoded by hand."""
    found = {}
    for one in ElementTree.parse(path).getroot().iter("DataArray"):
        raw = base64.b64decode(one.text)
        assert int.from_bytes(raw[:8], "little") == len(raw) - 8
        kind = {"Float64": "<f8", "Int64": "<i8"}[one.get("type")]
        width = int(one.get("NumberOfComponents"))
        values = np.frombuffer(raw[8:], dtype=kind)
        found[one.get("Name")] = values.reshape(-1, width) if width > 1 else values
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("vtk")
    particles, wear = snapshots()
    write_vtk(particles, wear, CASE, SETUP, folder)
    return folder


def test_particles_carry_place_radius_velocity_spin_and_number(folder):
    particles, _ = snapshots()
    found = arrays(folder / "particles_00001.vtp")
    np.testing.assert_array_equal(found["Points"], particles[["x", "y", "z"]])
    np.testing.assert_array_equal(found["velocity"], particles[["vx", "vy", "vz"]])
    np.testing.assert_array_equal(found["spin"], particles[["wx", "wy", "wz"]])
    np.testing.assert_array_equal(found["id"], [4, 7, 9])
    np.testing.assert_array_equal(found["radius"], [CASE["particle_radius"]] * 3)
    assert len(arrays(folder / "particles_00000.vtp")["Points"]) == 0


def test_facets_cover_the_plate_once_and_face_the_particles():
    points, quads = plate_facets(30.0, SETUP)
    corners = points[quads]
    sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1]
    normals = np.cross(*sides)
    assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(SETUP.plate_area)
    expected = [-np.sin(np.radians(30.0)), np.cos(np.radians(30.0)), 0.0]
    np.testing.assert_allclose(
        normals / np.linalg.norm(normals, axis=1)[:, None], [expected] * len(quads), atol=1e-12
    )


def test_each_facet_has_the_depth_of_its_place(folder):
    _, wear = snapshots()
    _, depth = depth_frames(wear, CASE, SETUP, "total")
    found = arrays(folder / "plate_00001.vtp")
    np.testing.assert_array_equal(found["depth_total"], depth[1].ravel())
    middles = found["Points"][found["connectivity"].reshape(-1, 4)].mean(axis=1)
    along = middles @ [np.cos(np.radians(35.0)), np.sin(np.radians(35.0)), 0.0]
    # Wear was planted as 10 x + z.
    order = np.lexsort([middles[:, 2], along.round(9)])
    assert (np.diff(found["depth_total"][order]) > 0.0).all()
    area = SETUP.plate_area / 8
    worn = 0.5 * (10.0 * 3 + 1) * CASE["archard_constant"] / area * 1e3
    assert found["depth_total"].max() == pytest.approx(worn)


def test_the_collection_names_every_file_with_its_time(folder):
    for kind in ("particles", "plate"):
        entries = list(ElementTree.parse(folder / f"{kind}.pvd").getroot().iter("DataSet"))
        assert [float(one.get("timestep")) for one in entries] == list(TIMES)
        assert all((folder / one.get("file")).is_file() for one in entries)


def test_a_case_that_is_not_there_is_one_line():
    with pytest.raises(TableError, match="case 3: there is no such case"):
        case_values(pd.DataFrame({"case_id": [1]}), 3)


def test_a_surface_has_the_depth_of_its_cells_and_its_parts_turn(tmp_path):
    """A screw that turns by half in the time of the second snapshot."""
    screw = Screw(0.4, 0.075, 0.02, 0.1, 0.005, 0.1, 60.0)
    setup = Setup(facet_size=0.05, geometry=screw, patch_length=0.05, patch_width=0.05)
    case = {**CASE, "particle_radius": 0.01}
    surface = case_surface(setup, case)
    cells = np.arange(len(surface.triangles))
    wear = pd.concat(
        pd.DataFrame({"time": time, "facet_x": cells, "facet_z": 0, "wear_total": time * cells,
                      "wear_sliding": 0.0, "wear_friction": 0.0})
        for time in TIMES
    )  # fmt: skip
    write_vtk(snapshots()[0], wear, case, setup, tmp_path)
    found = arrays(tmp_path / "surface_00001.vtp")
    _, depth = cell_depth_frames(wear, case, surface, "total")
    np.testing.assert_array_equal(found["depth_total"], depth[1])
    np.testing.assert_array_equal(found["part"], surface.part)
    placed = found["Points"].reshape(-1, 3, 3)
    still = surface.vertices[surface.triangles]
    turning = surface.part != surface.part_names.index("trough")
    np.testing.assert_allclose(placed[turning], still[turning] * [1, -1, -1], atol=1e-12)
    np.testing.assert_array_equal(placed[~turning], still[~turning])
    assert (tmp_path / "surface.pvd").is_file() and not (tmp_path / "plate.pvd").exists()


def test_a_case_has_the_sampled_quantities_of_its_geometry():
    cases = pd.DataFrame([{**CASE, "case_id": 1, "arc_radius": 0.5}])
    assert case_values(cases, 1)["arc_radius"] == 0.5


def test_vtk_itself_reads_the_same(folder):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    def read(name):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(folder / name))
        reader.Update()
        return reader.GetOutput()

    plate = read("plate_00001.vtp")
    assert plate.GetNumberOfCells() == 8
    depth = vtk_to_numpy(plate.GetCellData().GetArray("depth_total"))
    np.testing.assert_array_equal(depth, arrays(folder / "plate_00001.vtp")["depth_total"])
    points = read("particles_00001.vtp")
    assert points.GetNumberOfPoints() == points.GetNumberOfVerts() == 3
    assert points.GetPointData().GetArray("velocity").GetNumberOfComponents() == 3
    assert read("particles_00000.vtp").GetNumberOfPoints() == 0


def test_no_particles_make_a_file_all_the_same():
    particles, _ = snapshots()
    text = particles_vtp(particles.iloc[:0], 0.01)
    assert 'NumberOfPoints="0"' in text
