"""Where a sphere touches a triangulated surface.

The distance from the centre of the sphere to the surface has local minima, each on a face, an
edge or a vertex, and each within the radius is a contact. A minimum on an edge is one only if the
distance grows into every triangle at the edge, one at a vertex only if it grows along every edge
at the vertex (Ericson 2005, Real-Time Collision Detection, section 5.1.5, for the nearest point
of a triangle). So there is exactly one contact on a plane that is cut into triangles, and none at
the edges inside a surface that is concave there.

The facets of a smooth concave surface may be touched together. Contacts whose normals differ by
less than `SMOOTH` are one, the deepest.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.vectors import cross, dot, fma, plus, scaled

SIDE = 10
"""Numbers that describe a side of a triangle, see `mesh.Mesh.sides`."""

SMOOTH = math.cos(math.radians(15.0))
"""Cosine of the largest angle between normals of contacts that are taken as one, and between
those of one contact in two steps in a row."""

TOLERANCE = 1e-9
"""Length, in radii, by which a nearest point may seem to be beside an edge through rounding."""

FACE, VERTEX = -1, 3
"""Feature of a triangle with the nearest point: `FACE`, side k, or `VERTEX` + k."""


@kernel(inline=True)
def _side(sides, i, k, at):
    return sides[i, k, at], sides[i, k, at + 1], sides[i, k, at + 2]


@kernel(inline=True)
def nearest_on_triangle(sides, normals, i, x, y, z):
    """Return squared distance, feature, position along its side, and height over the plane.

    ``sides`` and ``normals`` are those of `mesh.Mesh`; lengths are in m.
    """
    height = dot(
        (x - sides[i, 0, 0], y - sides[i, 0, 1], z - sides[i, 0, 2]),
        (normals[i, 0], normals[i, 1], normals[i, 2]),
    )
    feature, place, least = FACE, 0.0, np.inf
    for k in range(3):
        arm = (x - sides[i, k, 0], y - sides[i, k, 1], z - sides[i, k, 2])
        beside = dot(arm, _side(sides, i, k, 3))
        if beside < 0.0:
            # Outside this side: the nearest point is on it or on another such side.
            along = dot(arm, _side(sides, i, k, 6))
            on = min(max(along, 0.0), sides[i, k, 9])
            off = along - on
            distance2 = fma(beside, beside, off * off)
            if distance2 < least:
                least, place = distance2, on
                feature = k
                if off < 0.0:
                    feature = VERTEX + k
                elif off > 0.0:
                    feature = VERTEX + (k + 1) % 3
    if feature == FACE:
        least = 0.0
    return fma(height, height, least), feature, place, height


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
def has_walls_near(mesh, x, y, z):
    """Whether a point is in a cell with triangles. All frames are at the angles of the step."""
    for f in range(mesh.frames.size):
        frame = mesh.frames[f]
        fx, fy, fz = to_frame(frame, x, y, z)
        cell = cell_in(frame, fx, fy, fz)
        if cell >= 0 and mesh.cell_steps[cell] == 0:
            return True
    return False


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
            if dot(arm, _side(mesh.sides, side // 3, side % 3, 3)) > tiny:
                return False
        return True
    vertex = mesh.corner_vertex[i, feature - VERTEX]
    for e in range(mesh.vertex_first[vertex], mesh.vertex_first[vertex + 1]):
        along = (mesh.vertex_edges[e, 0], mesh.vertex_edges[e, 1], mesh.vertex_edges[e, 2])
        if dot(arm, along) > tiny:
            return False
    return True


@kernel(inline=True)
def find_contacts(mesh, x, y, z, most_hits, most_contacts):
    """Find the contacts of a sphere; they are the first of ``mesh.hits``, the deepest first.

    Parameters
    ----------
    mesh : Mesh
        With all frames at the angles of the step (`turn_to`).
    x, y, z : float
        Centre, m.
    most_hits, most_contacts : int
        Room for triangles touched, and largest number of contacts.

    Returns
    -------
    int
        Number of contacts.
    """
    hits = mesh.hits
    found = 0
    for f in range(mesh.frames.size):
        frame = mesh.frames[f]
        fx, fy, fz = to_frame(frame, x, y, z)
        cell = cell_in(frame, fx, fy, fz)
        if cell < 0:
            continue
        for m in range(mesh.cell_first[cell], mesh.cell_first[cell + 1]):
            found = _hit(mesh, frame, f, mesh.cell_triangles[m], fx, fy, fz, found, most_hits)
    if found == 0:
        return 0
    # Contacts of one direction are one: the deepest is settled first. It is copied behind the
    # hits, then to the front of the list.
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
def _hit(mesh, frame, f, i, x, y, z, found, most_hits):
    """Note triangle i if the sphere touches it at a local minimum; return the number noted."""
    radius, hits = mesh.reach[0], mesh.hits
    distance2, feature, place, height = nearest_on_triangle(mesh.sides, mesh.normals, i, x, y, z)
    if not distance2 < radius * radius:
        return found
    n = (mesh.normals[i, 0], mesh.normals[i, 1], mesh.normals[i, 2])
    if feature == FACE:
        distance = abs(height)
        if height < 0.0:
            n = (-n[0], -n[1], -n[2])
    else:
        k, along = feature, place
        if feature >= VERTEX:
            k, along = feature - VERTEX, 0.0
        point = plus(_side(mesh.sides, i, k, 0), along, _side(mesh.sides, i, k, 6))
        arm = (x - point[0], y - point[1], z - point[2])
        if not _is_minimum(mesh, i, feature, arm):
            return found
        distance = math.sqrt(dot(arm, arm))
        if distance > 0.0:
            n = scaled(arm, 1.0 / distance)
    at = found
    if found == most_hits:
        # Without room the shallowest gives way.
        at = 0
        for h in range(1, found):
            if hits[h].distance > hits[at].distance:
                at = h
        if hits[at].distance <= distance:
            return found
    hit = hits[at]
    if frame.spin != 0.0:
        n = turned(frame, n, frame.sin)
    hit.nx, hit.ny, hit.nz = n
    hit.distance = distance
    hit.triangle = i
    hit.frame = f
    hit.on_face = 1 if feature == FACE else 0
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
