"""What the engine holds of a triangulated surface: triangles, their neighbours, grids of cells.

All triangles that move alike are in one *frame*, in which they are at rest. A particle is looked
up in the coordinates of each frame, so grids are made once. Each frame has a grid of cells with
the triangles that are within reach of each cell. A cell without any knows how many cells away the
nearest cell with some is, from which `mesh_flights` has a lower bound of a flight's time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.surface import CELL_SUMS, Surface, check_surface
from abradem.dem.triangle import SIDE, nearest_on_triangle
from abradem.dem.vectors import dot

WALLS = 4
"""Largest number of contacts of a particle with a surface."""

MOST_HITS = 64
"""Room for the triangles that a particle touches, before those of one direction are one contact."""

MARGIN = 0.25
"""How much farther than contact the triangles of a cell are listed, in radii."""

MOST_CELLS = 2**21
"""Largest number of cells of all grids."""

FARTHEST = 2**15 - 1
"""Largest number of cells that is counted up to the nearest cell with triangles."""

WELD = 1e-9
"""Distance of vertices that are taken as one, as a share of the extent of the surface."""

# Memory of the contact of a particle with a wall; stiffness 0: none. The names are those of the
# memory of the plate in a particle, so that one function serves both.
WALL = np.dtype(
    [("triangle", np.int64)]
    + [
        (name, np.float64)
        for name in (
            "plate_stiffness plate_sx plate_sy plate_sz plate_fn plate_tx plate_ty plate_tz "
            "plate_energy plate_slip nx ny nz overlap"
        ).split()
    ]
)

# A triangle that a particle touches: normal towards the particle, distance, m, the triangle, its
# frame, whether the nearest point is inside it, and whether the hit is settled.
HIT = np.dtype(
    [(name, np.float64) for name in ("nx", "ny", "nz", "distance")]
    + [(name, np.int64) for name in ("triangle", "frame", "on_face", "settled")]
)

# What a particle can touch while it is near a place of a frame: the place, m, in the coordinates of
# the frame, the square of the distance from it within which that holds, m2, and the triangle whose
# face alone it can touch there, or `mesh_search.NOTHING`.
SPOT = np.dtype(
    [(name, np.float64) for name in ("x", "y", "z", "room2")] + [("triangle", np.int64)]
)

# A frame: rotation (rad/s, point and unit direction of the axis), the step for which cos and sin
# of its angle are valid, and its grid: corner, width of cells, numbers of cells, first cell.
FRAME = np.dtype(
    [(name, np.float64) for name in "spin px py pz dx dy dz cos sin".split()]
    + [("step", np.int64)]
    + [(name, np.float64) for name in "low_x low_y low_z width".split()]
    + [(name, np.int64) for name in "nx ny nz first".split()]
)


class Mesh(NamedTuple):
    """A surface for the engine, and the contacts of the particles with it.

    Attributes
    ----------
    frames : ndarray of FRAME, shape (f,)
    reach : ndarray, shape (2,)
        Radius of the particles, and distance up to which triangles are listed in a cell, m.
    normals : ndarray, shape (t, 3)
    sides : ndarray, shape (t, 3, SIDE)
        Of each side of a triangle: its first corner, the unit vector across it into the triangle,
        the unit vector along it, and its length.
    side_edge : ndarray of int, shape (t, 3)
        Edge of each side; sides with the same two corners are one edge.
    edge_first, edge_sides : ndarray of int, shapes (e + 1,), (3 t,)
        Sides of each edge: three times the triangle plus the side.
    corner_vertex : ndarray of int, shape (t, 3)
        Vertex at the beginning of each side.
    vertex_first, vertex_edges : ndarray, shapes (v + 1,), (2 e, 3)
        Unit vectors of the edges that begin at each vertex.
    cell_first : ndarray of int, shape (cells + 1,)
    cell_triangles : ndarray of int
        Triangles within reach of each cell, ascending.
    cell_steps : ndarray of int, shape (cells,)
        Number of cells, along the axis with most, to the nearest cell with a triangle.
    part : ndarray of int, shape (t,)
    velocity : ndarray, shape (parts, 3)
        Tangential velocity of each part, m/s.
    frame_of : ndarray of int, shape (t,)
        Frame of each triangle.
    sums : ndarray, shape (t, 6)
        Sums of each cell, in the order of `surface.CELL_SUMS`.
    hits : ndarray of HIT, shape (MOST_HITS + WALLS,)
        Working memory.
    walls : ndarray of WALL, shape (capacity, WALLS)
        Memory of the contacts of each particle.
    open_walls : ndarray of int, shape (capacity,)
        Memories of each particle that hold a contact, as the sum of two to the power of each.
    spots : ndarray of SPOT, shape (capacity, f)
        What each particle can touch in each frame.
    """

    frames: np.ndarray
    reach: np.ndarray
    normals: np.ndarray
    sides: np.ndarray
    side_edge: np.ndarray
    edge_first: np.ndarray
    edge_sides: np.ndarray
    corner_vertex: np.ndarray
    vertex_first: np.ndarray
    vertex_edges: np.ndarray
    cell_first: np.ndarray
    cell_triangles: np.ndarray
    cell_steps: np.ndarray
    part: np.ndarray
    velocity: np.ndarray
    frame_of: np.ndarray
    sums: np.ndarray
    hits: np.ndarray
    walls: np.ndarray
    open_walls: np.ndarray
    spots: np.ndarray


def make_mesh(surface: Surface, radius: float, capacity: int) -> Mesh:
    """Return a surface for the engine.

    Parameters
    ----------
    surface : Surface
    radius : float
        Radius of the particles, m.
    capacity : int
        Number of particles for which there is room.

    Returns
    -------
    Mesh

    Raises
    ------
    ValueError
        If the surface is malformed or a triangle has no area.
    """
    check_surface(surface)
    vertices, triangles = _welded(surface)
    normals, sides = _triangle_shapes(vertices, triangles)
    side_edge, edge_first, edge_sides, pairs = _edges(triangles)
    vertex_first, vertex_edges = _edges_of_vertices(vertices, pairs)
    frame_of, frames = _frames(surface)
    reach = (1.0 + MARGIN) * radius
    lengths = sides[:, :, 9]
    cells = [
        _grid(frames[f], sides, normals, frame_of == f, reach,
              _cell_width(lengths[frame_of == f], radius), MOST_CELLS // len(frames))
        for f in range(len(frames))
    ]  # fmt: skip
    counts = np.concatenate([count for count, _, _ in cells])
    for f in range(1, len(frames)):
        frames["first"][f] = frames["first"][f - 1] + cells[f - 1][0].size
    return Mesh(
        frames=frames,
        reach=np.array([radius, reach]),
        normals=normals,
        sides=sides,
        side_edge=side_edge,
        edge_first=edge_first,
        edge_sides=edge_sides,
        corner_vertex=triangles,
        vertex_first=vertex_first,
        vertex_edges=vertex_edges,
        cell_first=np.concatenate([[0], np.cumsum(counts)]),
        cell_triangles=np.concatenate([listed for _, listed, _ in cells]),
        cell_steps=np.concatenate([steps for _, _, steps in cells]),
        part=np.ascontiguousarray(surface.part, dtype=np.int64),
        velocity=np.ascontiguousarray(surface.velocity, dtype=float),
        frame_of=frame_of,
        sums=np.zeros((len(triangles), len(CELL_SUMS))),
        hits=np.zeros(MOST_HITS + WALLS, HIT),
        walls=np.zeros((capacity, WALLS), WALL),
        open_walls=np.zeros(capacity, np.int64),
        spots=np.zeros((capacity, len(frames)), SPOT),
    )


def _cell_width(lengths, radius: float) -> float:
    """Return the width of the cells of a frame, m.

    A cell as wide as a triangle lists few of them, and a flight passes few such cells. Cells much
    smaller than a particle would all list the same triangles.
    """
    return max(0.5 * radius, float(np.median(lengths)))


def grown_mesh(mesh: Mesh | None, capacity: int) -> Mesh | None:
    """Return the mesh with room for ``capacity`` particles."""
    if mesh is None:
        return None
    walls, open_walls = np.zeros((capacity, WALLS), WALL), np.zeros(capacity, np.int64)
    spots = np.zeros((capacity, len(mesh.frames)), SPOT)
    for larger, before in ((walls, mesh.walls), (open_walls, mesh.open_walls),
                           (spots, mesh.spots)):  # fmt: skip
        larger[: len(before)] = before
    return mesh._replace(walls=walls, open_walls=open_walls, spots=spots)


@kernel(inline=True)
def move_walls(mesh, source, target):
    """Have the contacts of a particle that moves in the arrays move with it."""
    if mesh is None:
        return
    for w in range(WALLS):
        mesh.walls[target, w] = mesh.walls[source, w]
    mesh.open_walls[target] = mesh.open_walls[source]
    for f in range(mesh.frames.size):
        mesh.spots[target, f] = mesh.spots[source, f]


def _welded(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles with coincident vertices as one."""
    vertices = np.asarray(surface.vertices, dtype=float)
    grain = WELD * max(float(np.ptp(vertices, axis=0).max()), np.finfo(float).tiny)
    _, first, inverse = np.unique(
        np.rint((vertices - vertices.min(axis=0)) / grain), axis=0,
        return_index=True, return_inverse=True,
    )  # fmt: skip
    triangles = inverse.reshape(-1)[np.asarray(surface.triangles)].astype(np.int64)
    for k in range(3):
        same = triangles[:, k] == triangles[:, k - 1]
        if same.any():
            raise ValueError(f"triangle {int(same.argmax())} of the surface has no area")
    return vertices[first], triangles


def _triangle_shapes(vertices, triangles):
    """Unit normals and sides of all triangles, see `Mesh`."""
    corners = vertices[triangles]
    along = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(along, axis=2, keepdims=True)
    along = along / length
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    inward = np.cross(normal[:, None, :], along)
    sides = np.concatenate([corners, inward, along, length], axis=2)
    assert sides.shape[2] == SIDE
    return normal, np.ascontiguousarray(sides)


def _edges(triangles):
    """Edge of each side, sides of each edge, and the two vertices of each edge."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    pairs, edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    edge = edge.reshape(-1)
    first = np.concatenate([[0], np.cumsum(np.bincount(edge, minlength=len(pairs)))])
    return edge.reshape(-1, 3), first, np.argsort(edge, kind="stable"), pairs


def _edges_of_vertices(vertices, pairs):
    """Unit vectors of the edges that begin at each vertex."""
    begin = np.concatenate([pairs[:, 0], pairs[:, 1]])
    end = np.concatenate([pairs[:, 1], pairs[:, 0]])
    order = np.argsort(begin, kind="stable")
    along = vertices[end[order]] - vertices[begin[order]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    first = np.concatenate([[0], np.cumsum(np.bincount(begin, minlength=len(vertices)))])
    return first, np.ascontiguousarray(along)


def _frames(surface: Surface):
    """Frame of each triangle, and the frames: parts that move alike share one."""
    kinds: dict[tuple, int] = {}
    frame_of_part = []
    for part in range(len(surface.part_names)):
        spin = float(surface.angular_velocity[part])
        direction = np.array([0.0, 0.0, 1.0])
        point = np.zeros(3)
        if spin != 0.0:
            direction = np.asarray(surface.axis_direction[part], dtype=float)
            direction = direction / np.linalg.norm(direction)
            point = np.asarray(surface.axis_point[part], dtype=float)
        frame_of_part.append(kinds.setdefault((spin, *point, *direction), len(kinds)))
    # Frames without triangles are left out.
    frame_of = np.array(frame_of_part)[np.asarray(surface.part)]
    used, frame_of = np.unique(frame_of, return_inverse=True)
    frames = np.zeros(len(used), FRAME)
    for f, kind in enumerate(np.array(list(kinds))[used]):
        for name, value in zip("spin px py pz dx dy dz".split(), kind, strict=True):
            frames[name][f] = value
    frames["cos"] = 1.0
    return frame_of.reshape(-1), frames


def _grid(frame, sides, normals, mine, reach, width, most_cells):
    """Make the grid of a frame; return triangles per cell, their list, and the steps of cells.

    Cells have the given width, or a larger one if there would be too many of them.
    """
    chosen = np.flatnonzero(mine)
    corners = sides[chosen, :, :3].reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    while True:
        # A layer of cells around all that are within reach of a triangle.
        border = reach + width
        count = np.ceil((high - low + 2.0 * border) / width).astype(np.int64)
        if np.prod(count.astype(float)) <= most_cells:
            break
        width *= 1.1
    low = low - border
    frame["low_x"], frame["low_y"], frame["low_z"] = low
    frame["width"] = width
    frame["nx"], frame["ny"], frame["nz"] = count
    number = np.zeros(int(np.prod(count)), np.int64)
    nothing = np.zeros(0, np.int64)
    reach *= 1.0 + 1e-9
    _list_triangles(sides, normals, chosen, low, width, count, reach, number, nothing, nothing)
    first = np.concatenate([[0], np.cumsum(number)[:-1]])
    listed = np.zeros(int(number.sum()), np.int64)
    _list_triangles(sides, normals, chosen, low, width, count, reach, number, first, listed)
    steps = np.where(number > 0, 0, FARTHEST).astype(np.int16)
    _count_steps(steps, count)
    return number, listed, steps


@kernel(inline=True)
def _is_within(sides, normals, i, half, reach, x, y, z):
    """Whether some point of a cell can be within reach of triangle i; the cell has its centre here.

    A cell of half the width ``half`` m that is farther away along the normal of the triangle, or
    across one of its sides, is not (Gottschalk, Lin & Manocha 1996, SIGGRAPH 96:171).
    """
    n = (normals[i, 0], normals[i, 1], normals[i, 2])
    distance2, _, _, height = nearest_on_triangle(sides, normals, i, x, y, z)
    if distance2 > (reach + math.sqrt(3.0) * half) ** 2 or abs(height) > reach + half * _sum(n):
        return False
    for k in range(3):
        across = (sides[i, k, 3], sides[i, k, 4], sides[i, k, 5])
        arm = (x - sides[i, k, 0], y - sides[i, k, 1], z - sides[i, k, 2])
        if dot(arm, across) < -(reach + half * _sum(across)):
            return False
    return True


@kernel(inline=True)
def _sum(n):
    """Sum of the absolute components of a vector."""
    return abs(n[0]) + abs(n[1]) + abs(n[2])


@kernel
def _list_triangles(sides, normals, chosen, low, width, count, reach, number, first, listed):
    """Count the triangles within reach of each cell, or list them if ``listed`` has room."""
    fill = listed.size > 0
    if fill:
        number[:] = 0
    begin, end = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for i in chosen:
        for axis in range(3):
            least = min(sides[i, 0, axis], min(sides[i, 1, axis], sides[i, 2, axis]))
            most = max(sides[i, 0, axis], max(sides[i, 1, axis], sides[i, 2, axis]))
            begin[axis] = max(int((least - reach - low[axis]) / width), 0)
            end[axis] = min(int((most + reach - low[axis]) / width) + 1, count[axis])
        for cx in range(begin[0], end[0]):
            x = low[0] + (cx + 0.5) * width
            for cy in range(begin[1], end[1]):
                y = low[1] + (cy + 0.5) * width
                for cz in range(begin[2], end[2]):
                    z = low[2] + (cz + 0.5) * width
                    if _is_within(sides, normals, i, 0.5 * width, reach, x, y, z):
                        cell = (cx * count[1] + cy) * count[2] + cz
                        if fill:
                            listed[first[cell] + number[cell]] = i
                        number[cell] += 1


@kernel
def _count_steps(steps, count):
    """Number of cells to the nearest cell with 0, along the axis with most, by two passes.

    The distance transform of Rosenfeld & Pfaltz (1966, J. ACM 13:471) for the chessboard metric.
    """
    nx, ny, nz = count
    for backwards in range(2):
        sign = 1 if backwards == 0 else -1
        for c in range(nx * ny * nz):
            cell = c if backwards == 0 else nx * ny * nz - 1 - c
            cz, cy, cx = cell % nz, cell // nz % ny, cell // nz // ny
            best = np.int64(steps[cell])
            for dx in range(-1, 2):
                for dy in range(-1, 2):
                    for dz in range(-1, 2):
                        # Cells that were visited before this one.
                        if sign * ((dx * 3 + dy) * 3 + dz) >= 0:
                            continue
                        x, y, z = cx + dx, cy + dy, cz + dz
                        if 0 <= x < nx and 0 <= y < ny and 0 <= z < nz:
                            near = np.int64(steps[(x * ny + y) * nz + z])
                            best = min(best, near + 1)
            steps[cell] = best
