"""Lower bound of the time until a flying particle can touch a triangulated surface.

The parabola is followed in pieces, each as long as one of these allows:

- the spot of the particle (`mesh_search`): within it nothing is touched, or the face of one
  triangle alone, at a root of the parabola;
- in a frame at rest, the cell: the time to leave it is a root, too, and until then only triangles
  listed in it can be touched;
- in a frame that turns, the way to the next cell with triangles or out of the reach of its list,
  at the largest speed.

A triangle that is listed cannot be touched before the way to it is covered, nor before the particle
is within a radius of its plane, which is a root again. So particles that rebound, or pass by, are
not followed in small pieces. The first is sphere tracing (Hart 1996, Vis. Comput. 12:527) along a
parabola.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.borrow import borrowed_mesh
from abradem.dem.bounds import SAFETY, first_time_beyond, first_time_within
from abradem.dem.cache import kernel
from abradem.dem.mesh_search import (
    NOTHING,
    cell_in,
    to_frame,
    turned,
    way_to_cells,
)
from abradem.dem.state import fall, flight
from abradem.dem.triangle import nearest_on_triangle
from abradem.dem.vectors import cross, dot, plus

MOST_PIECES = 64
"""Largest number of pieces of a flight; the particle is then examined again."""

FEW_STEPS = 16
"""Number of steps for which it is not worth while to leave it at what a spot tells."""

SLACK = 0.5
"""How far beyond a cell a flight is followed with its list, along each axis, as a share of the way
by which the reach of lists exceeds contact; less than the root of a third."""


@kernel(inline=True)
def _time_over(room, pace, gravity):
    """Least time in which a particle moves by ``room`` m with a start at ``pace`` m/s, s."""
    if room <= 0.0:
        return 0.0
    speed = pace + math.sqrt(pace * pace + 2.0 * gravity * room)
    return 2.0 * room / speed if speed > 0.0 else np.inf


@kernel(inline=True)
def _piece_in(problem, mesh, f, spot, place, velocity):
    """Time in which a particle can touch no triangle of frame f, s, and whether it then does.

    ``place`` and ``velocity`` are those of the particle in the coordinates of the simulation, at
    a time for which the angle of the frame is set; ``spot`` is that of the particle in the frame.
    """
    frame = mesh.frames[f]
    x, y, z = to_frame(frame, place[0], place[1], place[2])
    gravity, grown = problem.gravity, mesh.reach[0] * (1.0 + SAFETY)
    pace = math.sqrt(dot(velocity, velocity))
    cell = cell_in(frame, x, y, z)
    near = cell >= 0 and mesh.cell_steps[cell] == 0
    way = (x - spot.x, y - spot.y, z - spot.z)
    way2, left = dot(way, way), 0.0
    if way2 < spot.room2:
        left = math.sqrt(spot.room2) - math.sqrt(way2)
    room = mesh.reach[1] - grown
    if not near:
        room += way_to_cells(mesh, frame, cell, x, y, z)
    bend = 0.0
    if frame.spin != 0.0:
        # In the frame the particle also moves about the axis.
        arm = (place[0] - frame.px, place[1] - frame.py, place[2] - frame.pz)
        spin = (frame.spin * frame.dx, frame.spin * frame.dy, frame.spin * frame.dz)
        farthest = math.sqrt(dot(arm, arm)) + max(room, left)
        pace += abs(frame.spin) * farthest
        velocity = turned(frame, plus(velocity, -1.0, cross(spin, arm)), -frame.sin)
        # Gravity, Coriolis and centrifugal acceleration at most.
        fastest = pace + gravity * _time_over(max(room, left), pace, gravity)
        bend = gravity + abs(frame.spin) * (2.0 * fastest + abs(frame.spin) * farthest)
    piece = _time_over(left, pace, gravity)
    if left > 0.0 and spot.triangle != NOTHING:
        plane = _time_to_plane(mesh, spot.triangle, x, y, z, velocity, gravity, bend, grown)
        if plane < piece:
            piece = plane
            if bend == 0.0:
                return piece, True
    if piece > FEW_STEPS * problem.dt:
        return piece, False
    # From here on, the spot does not matter.
    here = piece
    if frame.spin != 0.0:
        piece = _time_over(room, pace, gravity)
    else:
        piece = _time_in_cells(mesh, frame, cell, x, y, z, velocity, gravity)
    if not near:
        return max(piece, here), False
    for m in range(mesh.cell_first[cell], mesh.cell_first[cell + 1]):
        j = mesh.cell_triangles[m]
        plane = _time_to_plane(mesh, j, x, y, z, velocity, gravity, bend, grown)
        if plane < piece:
            distance2 = nearest_on_triangle(mesh.sides, mesh.normals, j, x, y, z)[0]
            time = _time_over(math.sqrt(distance2) - grown, pace, gravity)
            piece = min(piece, max(time, plane))
    return max(piece, here), False


@kernel(inline=True)
def _time_to_plane(mesh, j, x, y, z, velocity, gravity, bend, grown):
    """Time until a particle can be within ``grown`` of the plane of triangle j, s.

    ``bend`` is the largest acceleration in the frame, m/s2; 0: it is that of gravity.
    """
    n = (mesh.normals[j, 0], mesh.normals[j, 1], mesh.normals[j, 2])
    arm = (x - mesh.sides[j, 0, 0], y - mesh.sides[j, 0, 1], z - mesh.sides[j, 0, 2])
    height, towards = dot(arm, n), -gravity * n[1]
    if bend != 0.0:
        towards = -bend if height >= 0.0 else bend
    return first_time_within(height, dot(velocity, n), towards, grown, 0.0)


@kernel(inline=True)
def _time_in_cells(mesh, frame, cell, x, y, z, v, gravity):
    """Time in which a particle stays where it can touch nothing but the triangles of its cell, s.

    That is a cell with triangles, or the cells around that have none, and as far beyond them as the
    reach of lists allows, in a frame at rest; or outside the grid.
    """
    slack = SLACK * (mesh.reach[1] - mesh.reach[0])
    x, y, z = x - frame.low_x, y - frame.low_y, z - frame.low_z
    if cell < 0:
        time = _time_into(x, v[0], 0.0, frame.nx * frame.width, slack)
        time = max(time, _time_into(y, v[1], -gravity, frame.ny * frame.width, slack))
        return max(time, _time_into(z, v[2], 0.0, frame.nz * frame.width, slack))
    width = frame.width
    more = max(mesh.cell_steps[cell] - 1, 0) * width + slack
    x -= math.floor(x / width) * width
    y -= math.floor(y / width) * width
    z -= math.floor(z / width) * width
    time = first_time_beyond(y + more, width - y + more, v[1], gravity)
    time = min(time, ((width - x if v[0] > 0.0 else x) + more) / abs(v[0]))
    return min(time, ((width - z if v[2] > 0.0 else z) + more) / abs(v[2]))


@kernel(inline=True)
def _time_into(x, v, a, extent, slack):
    """Time until a coordinate can be in an interval from 0 on, and ``slack`` inside, s."""
    half = 0.5 * extent
    return first_time_within(x - half, v, a, half - slack, 0.0)


@kernel
def time_to_surface(problem, mesh, i, now, until, x, y, z, vx, vy, vz):
    """Lower bound of the time until flying particle i can touch the surface, s.

    Parameters
    ----------
    problem : Problem
    mesh : Mesh
    i : int
    now : int
        Lattice step of the place and velocity.
    until : float
        Time after which the bound does not matter, s; it is not larger than this.
    x, y, z, vx, vy, vz : float
        Place, m, and velocity, m/s.

    Returns
    -------
    float
    """
    mesh = borrowed_mesh(mesh)
    gravity, time = problem.gravity, 0.0
    for _ in range(MOST_PIECES):
        place = (flight(x, vx, time), fall(y, vy, gravity, time), flight(z, vz, time))
        velocity = (vx, vy - gravity * time, vz)
        piece, touches = np.inf, False
        for f in range(mesh.frames.size):
            frame = mesh.frames[f]
            if frame.spin != 0.0:
                angle = frame.spin * (problem.dt * now + time)
                frame.cos, frame.sin, frame.step = math.cos(angle), math.sin(angle), -1
            one, meets = _piece_in(problem, mesh, f, mesh.spots[i, f], place, velocity)
            if one < piece:
                piece, touches = one, meets
        time += piece
        if time >= until:
            return until
        if touches or piece < problem.dt:
            break
    return time


@kernel(inline=True)
def time_in_box(problem, box, x, y, z, vx, vy, vz):
    """Time after which a flying particle is outside the box in which particles are kept, s."""
    down = max(y - problem.removal_height, 0.0)
    up = max(box.high_y - y, 0.0)
    # A box without a lid is infinitely high.
    time = first_time_beyond(down, up, vy, problem.gravity)
    time = min(time, _time_beyond(x, vx, box.low_x, box.high_x))
    return min(time, _time_beyond(z, vz, box.low_z, box.high_z))


@kernel(inline=True)
def _time_beyond(x, v, low, high):
    if v == 0.0:
        return np.inf
    return max((high - x) / v if v > 0.0 else (low - x) / v, 0.0)
