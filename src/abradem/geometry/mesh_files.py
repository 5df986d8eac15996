"""Mesh files: STL, OBJ and PLY, read and written by trimesh.

A file has no unit and no direction of gravity, so both are given. Named solids of an STL file,
and objects and groups of an OBJ file, become the parts; a file without names is one part.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from abradem.geometry.shape import (
    GeometryError,
    Shape,
    combined,
    degenerate,
    given_twice,
    largest_extent,
    selected,
    welded,
)
from abradem.store.files import replacing

SUFFIXES = (".stl", ".obj", ".ply")
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
UPS = {
    "x": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "y": np.eye(3),
    "z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
"""Rotation that makes an axis of the file that of y, by the name of the axis."""

LARGEST, SMALLEST = 100.0, 1e-3
"""Limits of the extent of a mesh, m. Beyond them, the unit is most likely another one."""

MOST_TRIANGLES = 1_000_000


def read_mesh(path: str | Path, unit: str, up: str = "z", repair: bool = False) -> Shape:
    """Return the shape of a mesh file, with y up and its origin where the file has it.

    Parameters
    ----------
    path : path-like
        .stl, .obj or .ply.
    unit : {"mm", "cm", "m", "in"}
        Unit of the coordinates in the file.
    up : {"x", "y", "z"}
        Axis of the file that points up. With z, the file's (x, y, z) become (x, z, -y).
    repair : bool
        Leave out triangles without area and triangles that are in the file twice; otherwise they
        are an error. Holes are allowed.

    Raises
    ------
    GeometryError
        With one line that names the file, the problem and what is allowed.
    """
    path = Path(path)
    if unit not in UNITS:
        raise GeometryError(f"unit = {unit!r} is unknown (allowed: {', '.join(UNITS)})")
    if up not in UPS:
        raise GeometryError(f"up = {up!r} is unknown (allowed: {', '.join(UPS)})")
    shape = _loaded(path)
    if not np.isfinite(shape.vertices).all():
        raise GeometryError(f"{path}: a coordinate is not a finite number (allowed: numbers)")
    _check_extent(path, largest_extent(shape.vertices), unit)
    vertices = UNITS[unit] * shape.vertices @ UPS[up].T
    return _clean(path, welded(shape._replace(vertices=vertices)), repair)


def _loaded(path: Path) -> Shape:
    """Return the triangles of a file in its own unit and axes."""
    if path.suffix.lower() not in SUFFIXES:
        raise GeometryError(f"{path}: is not a mesh file (allowed: {', '.join(SUFFIXES)})")
    if not path.is_file():
        reason = "is a folder" if path.is_dir() else "there is no such file"
        raise GeometryError(f"{path}: {reason} (allowed: a mesh file)")
    # Imported here, as it takes a second and only meshes need it.
    import trimesh

    try:
        # Coordinates that are no numbers are told below.
        with np.errstate(all="ignore"):
            scene = trimesh.load_scene(
                path, process=False, split_objects=True, group_material=False
            )
        meshes = {
            name: mesh for name, mesh in scene.geometry.items() if isinstance(mesh, trimesh.Trimesh)
        }
    except Exception as error:
        # Readers of trimesh fail with errors of many types.
        words = " ".join(str(error).split())[:120] or type(error).__name__
        words = stl_damage(path) or words
        raise GeometryError(f"{path}: cannot be read as a mesh: {words}") from None
    shapes = [
        Shape(
            np.asarray(mesh.vertices, dtype=float),
            np.asarray(mesh.faces, dtype=np.int64),
            np.zeros(len(mesh.faces), dtype=np.int64),
            (str(name) if len(meshes) > 1 else _only_name(path),),
        )
        for name, mesh in sorted(meshes.items())
        if len(mesh.faces)
    ]
    count = sum(len(shape.triangles) for shape in shapes)
    if not count:
        words = stl_damage(path) or "it has no triangles (allowed: at least one)"
        raise GeometryError(f"{path}: cannot be read as a mesh: {words}")
    # A solid that is cut off is left out without a word.
    begun = path.read_bytes().count(b"facet normal") if path.suffix.lower() == ".stl" else 0
    if begun > count:
        raise GeometryError(
            f"{path}: cannot be read as a mesh: of its {begun} facets {begun - count} are in a "
            "solid that is cut off (allowed: an endsolid after each)"
        )
    if count > MOST_TRIANGLES:
        raise GeometryError(f"{path}: has {count} triangles (allowed up to {MOST_TRIANGLES})")
    return combined(shapes)


def _only_name(path: Path) -> str:
    """Name of the only solid of an STL file or object of an OBJ file, or of the file."""
    with open(path, "rb") as file:
        begin = file.read(4096)
    words = (b"o", b"g") if path.suffix.lower() == ".obj" else (b"solid",)
    if path.suffix.lower() == ".stl" and b"facet" not in begin:
        # The first 80 bytes of a binary file may say anything.
        return path.stem
    for line in begin.splitlines() if path.suffix.lower() != ".ply" else []:
        word, _, name = line.strip().partition(b" ")
        if word in words and (text := name.decode("ascii", "replace").strip()):
            return text
    return path.stem


def stl_damage(path: Path) -> str:
    """Return what is wrong with an STL file that gives no triangles, or ""."""
    if path.suffix.lower() != ".stl":
        return ""
    content = path.read_bytes()
    if not content:
        return "the file is empty"
    text = content.decode("ascii", "replace")
    if text.lstrip().startswith("solid") and "facet" in text:
        for number, line in enumerate(text.splitlines(), 1):
            word, *values = line.split() or [""]
            if word == "vertex" and not (len(values) == 3 and all(map(_is_number, values))):
                return (
                    f"line {number}: {line.strip()[:60]!r} (allowed: vertex and three numbers with "
                    "a decimal point)"
                )
        return "it is cut off: no endsolid closes its last solid" if "endsolid" not in text else ""
    if text.lstrip().startswith("solid"):
        return "it has no triangles (allowed: at least one)"
    if text.isprintable() or len(content) < _STL_HEAD:
        return f"it is no STL file, it begins with {text.splitlines()[0][:40]!r}"
    count = int.from_bytes(content[_STL_HEAD - 4 : _STL_HEAD], "little")
    expected = _STL_HEAD + _STL_TRIANGLE * count
    if len(content) == expected:
        return ""
    return (
        f"it is cut off or no STL file: {count} triangles are {expected} bytes, and it has "
        f"{len(content)}"
    )


_STL_HEAD, _STL_TRIANGLE = 84, 50
"""Bytes of a binary STL file: of its head, which ends with the number of triangles, and of each."""


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _check_extent(path: Path, extent: float, unit: str) -> None:
    """Raise if the mesh would be implausibly large or small; name units that would do."""
    metres = extent * UNITS[unit]
    if SMALLEST <= metres <= LARGEST:
        return
    fits = units_between(metres, metres, unit)
    hint = f"; is the unit {fits}?" if fits else ""
    raise GeometryError(
        f"{path}: is {metres:g} m large with unit {unit} (allowed {SMALLEST:g} ... {LARGEST:g} m)"
        f"{hint}"
    )


def units_between(narrow: float, large: float, unit: str, least: float = SMALLEST) -> str:
    """Return the units that make a mesh wide enough and not too large, with its size, or "".

    Parameters
    ----------
    narrow, large : float
        Second largest and largest extent of the mesh in its present unit, m.
    unit : str
        That unit.
    least : float
        Smallest second largest extent, m.
    """
    sizes = {name: large * factor / UNITS[unit] for name, factor in UNITS.items()}
    return " or ".join(
        f"{name} ({size:g} m)"
        for name, size in sizes.items()
        if size <= LARGEST and narrow / large * size >= least
    )


def _clean(path: Path, shape: Shape, repair: bool) -> Shape:
    if degenerate(shape).all():
        raise GeometryError(f"{path}: no triangle has an area (allowed: at least one)")
    for one, several, find in (
        ("triangle without area", "triangles without area", degenerate),
        ("triangle that is in it twice", "triangles that are in it twice", given_twice),
    ):
        wrong = find(shape)
        if wrong.any() and not repair:
            count, first = wrong.sum(), np.flatnonzero(wrong)[0] + 1
            raise GeometryError(
                f"{path}: has {count} {one if count == 1 else several}, the first is number "
                f"{first} (allowed: none, or geometry.mesh.repair: true, which leaves them out)"
            )
        shape = selected(shape, ~wrong)
    return shape


def write_stl(shape: Shape, path: str | Path, unit: str = "mm", up: str = "z") -> None:
    """Write a shape as an ASCII STL file with a solid for each part.

    Parameters
    ----------
    shape : Shape
    path : path-like
    unit, up : str
        As for `read_mesh`, which reads the same shape from it to seven digits.
    """
    vertices = shape.vertices @ UPS[up] / UNITS[unit]
    corners = vertices[shape.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = across / np.linalg.norm(across, axis=1, keepdims=True)

    def row(values) -> str:
        # The sum with 0 turns -0 into 0.
        return " ".join(f"{value:.7g}" for value in np.round(values, 6) + 0.0)

    text = io.StringIO()
    for number, name in enumerate(shape.names):
        text.write(f"solid {name}\n")
        for triangle in np.flatnonzero(shape.part == number):
            text.write(f"facet normal {row(facing[triangle])}\n outer loop\n")
            for corner in corners[triangle]:
                text.write(f"  vertex {row(corner)}\n")
            text.write(" endloop\nendfacet\n")
        text.write(f"endsolid {name}\n")
    with replacing(path) as file:
        file.write(text.getvalue().encode("ascii"))
