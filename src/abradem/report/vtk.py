"""Export of snapshots to ParaView: particles and worn plate as VTK XML files.

Each snapshot is a PolyData file (``.vtp``); a collection file (``.pvd``) gives the time of each.
Arrays are little-endian and base64-encoded with a header of eight bytes. Only numpy is needed to
write them. In ParaView, open ``particles.pvd`` and ``plate.pvd`` or ``surface.pvd``, and show the
particles with the filter Glyph, glyph type Sphere (radius 1), scaled by ``radius``.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.dem.surface import Surface
from abradem.geometry.build import case_surface
from abradem.geometry.turning import corners_at
from abradem.quantities import GEOMETRY_NAMES, SAMPLED_NAMES, WEAR_MEASURES
from abradem.store.files import TableError, write_text
from abradem.wear.depths import cell_depth_frames, depth_frames

_TYPES = {"float64": "Float64", "int64": "Int64"}


def case_values(cases: pd.DataFrame, case_id: int) -> dict[str, float]:
    """The sampled quantities of one case of a table; raises `TableError` if it is missing."""
    rows = cases[cases["case_id"] == case_id]
    if len(rows) != 1:
        raise TableError(f"case {case_id}: there is no such case")
    names = [*SAMPLED_NAMES, *(name for name in GEOMETRY_NAMES if name in cases)]
    return {name: float(rows[name].iloc[0]) for name in names}


def write_vtk(
    particles: pd.DataFrame,
    wear: pd.DataFrame,
    case: Mapping[str, float],
    setup: Setup,
    folder: str | Path,
) -> None:
    """Write the snapshots of a case, one file of particles and one of the surface for each time.

    Parameters
    ----------
    particles, wear : pandas.DataFrame
        From `abradem.simulation.snapshots`.
    case : mapping
        Sampled quantities of the case; particle_radius (m), archard_constant (1/Pa) and those of
        the geometry, or plate_angle (deg), are used.
    setup : Setup
    folder : path-like
        The files ``particles.pvd``, ``plate.pvd`` (with a geometry ``surface.pvd``, whose cells
        have the number of their ``part`` too) and those that they list are written here.
        Particles have ``id``, ``radius`` (m), ``velocity`` (m/s) and ``spin`` (rad/s); facets have
        the wear depth of each wear measure, ``depth_<measure>`` (mm).
    """
    folder = Path(folder)
    surface = None if setup.geometry is None else case_surface(setup, case)
    if surface is None:
        kind, (points, faces), parts = "plate", plate_facets(case["plate_angle"], setup), {}
        frames = {one: depth_frames(wear, case, setup, one) for one in WEAR_MEASURES}
    else:
        kind, faces, parts = "surface", np.arange(surface.part.size * 3), {"part": surface.part}
        faces = faces.reshape(-1, 3)
        frames = {one: cell_depth_frames(wear, case, surface, one) for one in WEAR_MEASURES}
    times = frames[WEAR_MEASURES[0]][0]
    by_time = dict(tuple(particles.groupby("time")))
    names: dict[str, list[str]] = {"particles": [], kind: []}
    for index, time in enumerate(times):
        rows = by_time.get(time, particles.iloc[:0])
        if surface is not None:
            # Parts may turn, so triangles share no points.
            points = corners_at(surface, float(time)).reshape(-1, 3)
        depths = {f"depth_{one}": depth[index].ravel() for one, (_, depth) in frames.items()}
        texts = {
            "particles": particles_vtp(rows, case["particle_radius"]),
            kind: polydata(points, faces, "Polys", cells={**parts, **depths}),
        }
        for name, text in texts.items():
            names[name].append(f"{name}_{index:05d}.vtp")
            write_text(text, folder / names[name][-1])
    for name, files in names.items():
        write_text(collection(times, files), folder / f"{name}.pvd")


def surface_vtp(surface: Surface, cells: pd.DataFrame) -> str:
    """XML of a PolyData with the cells of a surface.

    Parameters
    ----------
    surface : Surface
    cells : pandas.DataFrame
        Rows of one case of `abradem.wear.surface_cells.cell_table`. The columns of numbers become
        values of the cells, with their units in docs/chute.md; ``part`` is the number of the part.
    """
    numbers = cells.drop(columns=["case_id", "cell"]).select_dtypes("number")
    return polydata(
        surface.vertices,
        surface.triangles,
        "Polys",
        cells={
            "part": surface.part,
            **{name: numbers[name].to_numpy(dtype=float) for name in numbers},
        },
    )


def particles_vtp(rows: pd.DataFrame, radius: float) -> str:
    """XML of a PolyData with the particles at one time as points; ``radius`` in m."""
    count = len(rows)

    def vectors(*columns: str) -> np.ndarray:
        return rows[list(columns)].to_numpy(dtype=float)

    return polydata(
        vectors("x", "y", "z"),
        np.arange(count)[:, None],
        "Verts",
        points_data={
            "id": rows["particle"].to_numpy(dtype=np.int64),
            "radius": np.full(count, float(radius)),
            "velocity": vectors("vx", "vy", "vz"),
            "spin": vectors("wx", "wy", "wz"),
        },
    )


def plate_facets(angle: float, setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    """Corners and facets of the plate.

    Parameters
    ----------
    angle : float
        Plate angle, degrees.
    setup : Setup

    Returns
    -------
    points : ndarray, shape (n, 3)
        Corners of the facets, m.
    quads : ndarray of int, shape (nx nz, 4)
        Corners of each facet, in the order of a flattened wear map (nx, nz).
    """
    nx, nz = setup.facets
    along = np.linspace(-0.5, 0.5, nx + 1) * setup.plate_length
    across = np.linspace(-0.5, 0.5, nz + 1) * setup.plate_width
    s, z = (grid.ravel() for grid in np.meshgrid(along, across, indexing="ij"))
    slope = np.radians(angle)
    points = np.column_stack([s * np.cos(slope), s * np.sin(slope), z])
    i, j = (index.ravel() for index in np.indices((nx, nz)))
    first = i * (nz + 1) + j
    # Counter-clockwise as seen from above, so that the normal points to the particles.
    return points, np.column_stack([first, first + 1, first + nz + 2, first + nz + 1])


def polydata(
    points: np.ndarray,
    members: np.ndarray,
    kind: str,
    points_data: Mapping[str, np.ndarray] | None = None,
    cells: Mapping[str, np.ndarray] | None = None,
) -> str:
    """XML of a PolyData.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Coordinates, m.
    members : ndarray of int, shape (m, k)
        Points of each cell.
    kind : {"Verts", "Polys"}
        Type of the cells.
    points_data, cells : mapping of str to ndarray, optional
        Values at points, shape (n,) or (n, 3), and in cells, shape (m,) or (m, 3).
    """
    count, width = members.shape
    counts = {"Verts": 0, "Lines": 0, "Strips": 0, "Polys": 0} | {kind: count}
    sizes = " ".join(f'NumberOf{name}="{number}"' for name, number in counts.items())
    offsets = width * np.arange(1, count + 1)
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64">',
            "<PolyData>",
            f'<Piece NumberOfPoints="{len(points)}" {sizes}>',
            "<PointData>",
            *(_array(name, values) for name, values in (points_data or {}).items()),
            "</PointData>",
            "<CellData>",
            *(_array(name, values) for name, values in (cells or {}).items()),
            "</CellData>",
            "<Points>",
            _array("Points", points.reshape(-1, 3)),
            "</Points>",
            f"<{kind}>",
            _array("connectivity", members.ravel()),
            _array("offsets", offsets),
            f"</{kind}>",
            "</Piece>",
            "</PolyData>",
            "</VTKFile>",
            "",
        ]
    )


def collection(times: Iterable[float], files: Sequence[str]) -> str:
    """XML of a collection of files, each with its time (s)."""
    entries = [
        f'<DataSet timestep="{time!r}" file={quoteattr(name)}/>'
        for time, name in zip(map(float, times), files, strict=True)
    ]
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">',
            "<Collection>",
            *entries,
            "</Collection>",
            "</VTKFile>",
            "",
        ]
    )


def _array(name: str, values: np.ndarray) -> str:
    values = np.asarray(values)
    kind = "float64" if values.dtype.kind == "f" else "int64"
    data = np.ascontiguousarray(values, dtype=f"<{kind[0]}8").tobytes()
    width = values.shape[1] if values.ndim == 2 else 1
    content = base64.b64encode(len(data).to_bytes(8, "little") + data).decode("ascii")
    return (
        f'<DataArray type="{_TYPES[kind]}" Name={quoteattr(name)} NumberOfComponents="{width}" '
        f'format="binary">{content}</DataArray>'
    )
