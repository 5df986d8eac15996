"""Where a sphere touches a triangulated surface.

The distance from the centre of the sphere to the surface has local minima, each on a face, an
edge or a vertex, and each within the radius is a contact. A minimum on an edge is one only if the
distance grows into every triangle at the edge, one at a vertex only if it grows along every edge
at the vertex (Ericson 2005, Real-Time Collision Detection, section 5.1.5, for the nearest point
of a triangle). So there is exactly one contact on a plane that is cut into triangles, and none at
the edges inside a surface that is concave there.

The facets of a smooth concave surface may be touched together. Contacts whose normals differ by
less than `SMOOTH` are one, the deepest.

Most particles stay for hundreds of steps where they can touch nothing, or the face of one triangle
alone. A *spot* remembers that for a particle and a frame, and how far it holds, so that the
triangles around are searched only after that way. What is found is the same, bit for bit: see
`_slack`.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.borrow import borrowed_mesh
from abradem.dem.cache import kernel
from abradem.dem.triangle import FACE, VERTEX, nearest_on_triangle, side_vector
from abradem.dem.vectors import cross, dot, plus, scaled

SMOOTH = math.cos(math.radians(15.0))
"""Cosine of the largest angle between normals of contacts that are taken as one, and between
those of one contact in two steps in a row."""

TOLERANCE = 1e-9
"""Length, in radii, by which a nearest point may seem to be beside an edge through rounding."""

NOTHING = -1
"""In place of a triangle: none can be touched."""

CAUTION = 1e-6
"""Length, in radii, by which spots are smaller than computed, far above rounding."""


@kernel(inline=True)
def to_frame(frame, x, y, z):
    """Coordinates of a point in a frame, m."""
    if frame.spin == 0.0:
        return x, y, z
    arm = (x - frame.px, y - frame.py, z - frame.pz)
    back = turned(frame, arm, -frame.sin)
    return back[0] + frame.px, back[1] + frame.py, back[2] + frame.pz


@kernel(inline=True)
def turned(frame, v, sin):
    """Vector v turned about the axis of a frame by its angle (Rodrigues 1840)."""
    axis = (frame.dx, frame.dy, frame.dz)
    along = dot(axis, v) * (1.0 - frame.cos)
    return plus(plus(scaled(v, frame.cos), sin, cross(axis, v)), along, axis)


@kernel(inline=True)
def turn_to(problem, mesh, step):
    """Have all frames at their angles at a lattice step."""
    for f in range(mesh.frames.size):
        frame = mesh.frames[f]
        if frame.spin != 0.0 and frame.step != step:
            angle = frame.spin * (problem.dt * step)
            frame.cos, frame.sin = math.cos(angle), math.sin(angle)
            frame.step = step


@kernel(inline=True)
def cell_in(frame, x, y, z):
    """Cell of a point of a frame, or -1 outside its grid."""
    cx = (x - frame.low_x) / frame.width
    cy = (y - frame.low_y) / frame.width
    cz = (z - frame.low_z) / frame.width
    if not (0.0 <= cx < frame.nx and 0.0 <= cy < frame.ny and 0.0 <= cz < frame.nz):
        return np.int64(-1)
    column = np.int64(cx) * frame.ny + np.int64(cy)
    return frame.first + column * frame.nz + np.int64(cz)


@kernel(inline=True)
def _is_minimum(mesh, i, feature, arm):
    """Whether the distance grows from the feature of triangle i into all triangles at it.

    ``arm`` is the vector from the nearest point to the centre of the sphere, m.
    """
    tiny = TOLERANCE * mesh.reach[0]
    if feature < VERTEX:
        edge = mesh.side_edge[i, feature]
        for s in range(mesh.edge_first[edge], mesh.edge_first[edge + 1]):
            side = mesh.edge_sides[s]
            if dot(arm, side_vector(mesh.sides, side // 3, side % 3, 3)) > tiny:
                return False
        return True
    vertex = mesh.corner_vertex[i, feature - VERTEX]
    for e in range(mesh.vertex_first[vertex], mesh.vertex_first[vertex + 1]):
        along = (mesh.vertex_edges[e, 0], mesh.vertex_edges[e, 1], mesh.vertex_edges[e, 2])
        if dot(arm, along) > tiny:
            return False
    return True


@kernel(inline=True)
def find_contacts(mesh, i, x, y, z, most_hits, most_contacts):
    """Find the contacts of a particle; they are the first of ``mesh.hits``, the deepest first.

    Parameters
    ----------
    mesh : Mesh
        With all frames at the angles of the step (`turn_to`).
    i : int
        Particle, whose spots are used and renewed.
    x, y, z : float
        Its centre, m.
    most_hits, most_contacts : int
        Room for triangles touched, and largest number of contacts.

    Returns
    -------
    int
        Number of contacts.
    """
    found = 0
    for f in range(mesh.frames.size):
        frame, spot = mesh.frames[f], mesh.spots[i, f]
        fx, fy, fz = to_frame(frame, x, y, z)
        way = (fx - spot.x, fy - spot.y, fz - spot.z)
        if not dot(way, way) < spot.room2:
            found = _search(mesh, i, f, fx, fy, fz, found, most_hits)
        elif spot.triangle != NOTHING:
            j = spot.triangle
            n = (mesh.normals[j, 0], mesh.normals[j, 1], mesh.normals[j, 2])
            arm = (fx - mesh.sides[j, 0, 0], fy - mesh.sides[j, 0, 1], fz - mesh.sides[j, 0, 2])
            height = dot(arm, n)
            if height * height < mesh.reach[0] * mesh.reach[0]:
                found = _note_hit(mesh, frame, f, j, abs(height), _facing(n, height), 1, found,
                                  most_hits)  # fmt: skip
    return found if found < 2 else _one_of_each_direction(mesh, found, most_hits, most_contacts)


@kernel
def _one_of_each_direction(mesh, found, most_hits, most_contacts):
    """Have contacts of one direction as one, the deepest; return their number."""
    hits = mesh.hits
    # The deepest is settled first. It is copied behind the hits, then to the front of the list.
    contacts = 0
    while contacts < most_contacts:
        deepest = -1
        for h in range(found):
            if hits[h].settled == 0 and (deepest < 0 or hits[h].distance < hits[deepest].distance):
                deepest = h
        if deepest < 0:
            break
        one = hits[deepest]
        hits[most_hits + contacts] = one
        contacts += 1
        for h in range(found):
            other = hits[h]
            if dot((one.nx, one.ny, one.nz), (other.nx, other.ny, other.nz)) >= SMOOTH:
                other.settled = 1
        one.settled = 1
    for c in range(contacts):
        hits[c] = hits[most_hits + c]
    return contacts


@kernel(inline=True)
def _facing(n, height):
    """Normal of a triangle towards a point at a height over it."""
    if height < 0.0:
        return -n[0], -n[1], -n[2]
    return n


@kernel
def _search(mesh, i, f, x, y, z, found, most_hits):
    """Note the triangles of a frame that particle i touches, and renew its spot in the frame.

    ``x``, ``y``, ``z`` are coordinates of the frame; returns the number of triangles noted.
    """
    mesh = borrowed_mesh(mesh)
    frame, spot, radius = mesh.frames[f], mesh.spots[i, f], mesh.reach[0]
    spot.x, spot.y, spot.z = x, y, z
    spot.triangle, spot.room2 = NOTHING, 0.0
    farthest = mesh.reach[1] - radius
    cell = cell_in(frame, x, y, z)
    if cell < 0 or mesh.cell_steps[cell] > 0:
        room = farthest + way_to_cells(mesh, frame, cell, x, y, z) - CAUTION * radius
        spot.room2 = room * room
        return found
    before = found
    least, second, nearest, inside = farthest, farthest, NOTHING, 0.0
    for m in range(mesh.cell_first[cell], mesh.cell_first[cell + 1]):
        j = mesh.cell_triangles[m]
        near = nearest_on_triangle(mesh.sides, mesh.normals, j, x, y, z)
        found = _hit(mesh, frame, f, j, x, y, z, near, found, most_hits)
        slack = math.sqrt(near[0]) - radius
        if slack < farthest:
            slack = max(slack, _slack(mesh, j, x, y, z, near[3], slack))
        if slack < least:
            least, second = slack, least
            nearest = np.int64(j)  # type: ignore[assignment]  # a number to numba
        elif slack < second:
            second = slack
    if found - before > 1:
        return found
    if nearest != NOTHING:
        inside = min(second, -_outside_face(mesh, nearest, x, y, z))
    room = max(least, inside) - CAUTION * radius
    if room > 0.0:
        spot.room2 = room * room
        if inside > least:
            spot.triangle = nearest
    return found


@kernel(inline=True)
def way_to_cells(mesh, frame, cell, x, y, z):
    """Least way from a point of a cell without triangles to a cell with some, m.

    A cell of -1 is outside the grid, whose outermost cells are without triangles.
    """
    if cell < 0:
        away = (
            _beyond(x - frame.low_x, frame.nx * frame.width),
            _beyond(y - frame.low_y, frame.ny * frame.width),
            _beyond(z - frame.low_z, frame.nz * frame.width),
        )
        return math.sqrt(dot(away, away))
    return (mesh.cell_steps[cell] - 1) * frame.width


@kernel(inline=True)
def _beyond(x, extent):
    """Distance of a coordinate from the interval from 0 to ``extent``, m."""
    return max(-x, max(x - extent, 0.0))


@kernel(inline=True)
def _outside_face(mesh, j, x, y, z):
    """How far a point is outside the prism over triangle j, m; negative inside."""
    most = -np.inf
    for k in range(3):
        side = mesh.sides[j, k]
        arm = (x - side[0], y - side[1], z - side[2])
        most = max(most, -dot(arm, (side[3], side[4], side[5])))
    return most


@kernel
def _slack(mesh, j, x, y, z, height, enough):
    """Way that a particle can at least move before triangle j is among its hits, m.

    This is besides its distance: a face is touched by a centre over it alone, an edge if the centre
    is beyond it seen from all triangles at it, a vertex if it is beyond it along all edges at it
    (`_is_minimum`). All these change by at most the way of the centre. The result may be too small,
    and is if it is at most ``enough``.
    """
    mesh = borrowed_mesh(mesh)
    slack = max(_outside_face(mesh, j, x, y, z), abs(height) - mesh.reach[0])
    for k in range(3):
        if slack <= enough:
            break
        edge, vertex = mesh.side_edge[j, k], mesh.corner_vertex[j, k]
        most = -np.inf
        for s in range(mesh.edge_first[edge], mesh.edge_first[edge + 1]):
            at = mesh.edge_sides[s]
            side = mesh.sides[at // 3, at % 3]
            arm = (x - side[0], y - side[1], z - side[2])
            most = max(most, dot(arm, (side[3], side[4], side[5])))
        slack = min(slack, most)
        most = -np.inf
        corner = mesh.sides[j, k]
        arm = (x - corner[0], y - corner[1], z - corner[2])
        for e in range(mesh.vertex_first[vertex], mesh.vertex_first[vertex + 1]):
            along = (mesh.vertex_edges[e, 0], mesh.vertex_edges[e, 1], mesh.vertex_edges[e, 2])
            most = max(most, dot(arm, along))
        slack = min(slack, most)
    return slack


@kernel(inline=True)
def _hit(mesh, frame, f, i, x, y, z, near, found, most_hits):
    """Note triangle i if the sphere touches it at a local minimum; return the number noted.

    ``near`` is what `nearest_on_triangle` returns.
    """
    distance2, feature, place, height = near
    if not distance2 < mesh.reach[0] * mesh.reach[0]:
        return found
    n = (mesh.normals[i, 0], mesh.normals[i, 1], mesh.normals[i, 2])
    if feature == FACE:
        distance, n = abs(height), _facing(n, height)
    else:
        k, along = feature, place
        if feature >= VERTEX:
            k, along = feature - VERTEX, 0.0
        point = plus(side_vector(mesh.sides, i, k, 0), along, side_vector(mesh.sides, i, k, 6))
        arm = (x - point[0], y - point[1], z - point[2])
        if not _is_minimum(mesh, i, feature, arm):
            return found
        distance = math.sqrt(dot(arm, arm))
        if distance > 0.0:
            n = scaled(arm, 1.0 / distance)
    on_face = 1 if feature == FACE else 0
    return _note_hit(mesh, frame, f, i, distance, n, on_face, found, most_hits)


@kernel(inline=True)
def _note_hit(mesh, frame, f, i, distance, n, on_face, found, most_hits):
    """Note a hit of triangle i with a normal in the frame; return the number noted."""
    hits, at = mesh.hits, found
    if found == most_hits:
        # Without room the shallowest gives way.
        at = 0
        for h in range(1, found):
            if hits[h].distance > hits[at].distance:
                at = h
        if hits[at].distance <= distance:
            return found
    if frame.spin != 0.0:
        n = turned(frame, n, frame.sin)
    hit = hits[at]
    hit.nx, hit.ny, hit.nz = n
    hit.distance = distance
    hit.triangle = i
    hit.frame = f
    hit.on_face = on_face
    hit.settled = 0
    return max(found, at + 1)


@kernel
def surface_distance(mesh, x, y, z):
    """Distance of a point to the surface, m, if within the reach of the grids, else infinity.

    All frames are at the angles of the step (`turn_to`).
    """
    least2 = np.inf
    for f in range(mesh.frames.size):
        frame = mesh.frames[f]
        fx, fy, fz = to_frame(frame, x, y, z)
        cell = cell_in(frame, fx, fy, fz)
        if cell >= 0:
            for m in range(mesh.cell_first[cell], mesh.cell_first[cell + 1]):
                i = mesh.cell_triangles[m]
                near = nearest_on_triangle(mesh.sides, mesh.normals, i, fx, fy, fz)
                least2 = min(least2, near[0])
    return math.sqrt(least2)
