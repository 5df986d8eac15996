"""Lower bound of the time until a flying particle can touch a triangulated surface.

The parabola is followed in pieces. At the beginning of each, the grid of each frame tells how far
the particle can move, in the coordinates of the frame, before it can touch a triangle: by the
cells between, or by the distances of the triangles listed in its cell. Of the latter a particle
can also not touch one before it is within a radius of its plane, which on a parabola is the root
of a quadratic equation: so particles that rebound, or pass by, are not followed in small pieces.
The first is sphere tracing (Hart 1996, Vis. Comput. 12:527) along a parabola.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.bounds import SAFETY, first_time_beyond, first_time_within
from abradem.dem.cache import kernel
from abradem.dem.mesh_search import cell_in, nearest_on_triangle, to_frame, turned
from abradem.dem.state import fall, flight
from abradem.dem.vectors import cross, dot, plus

MOST_PIECES = 64
"""Largest number of pieces of a flight; the particle is then examined again."""


@kernel(inline=True)
def _time_over(room, pace, gravity):
    """Least time in which a particle moves by ``room`` m with a start at ``pace`` m/s, s."""
    if room <= 0.0:
        return 0.0
    speed = pace + math.sqrt(pace * pace + 2.0 * gravity * room)
    return 2.0 * room / speed if speed > 0.0 else np.inf


@kernel(inline=True)
def _piece_in(problem, mesh, frame, place, velocity):
    """Time in which a particle can touch no triangle of a frame, s.

    ``place`` and ``velocity`` are those of the particle in the coordinates of the simulation, at
    a time for which the angle of the frame is set.
    """
    x, y, z = to_frame(frame, place[0], place[1], place[2])
    reach, gravity = mesh.reach[1], problem.gravity
    grown = mesh.reach[0] * (1.0 + SAFETY)
    pace = math.sqrt(dot(velocity, velocity))
    cell = cell_in(frame, x, y, z)
    near = cell >= 0 and mesh.cell_steps[cell] == 0
    room = reach - grown
    if cell < 0:
        # The grid ends farther than the reach from all triangles.
        away = (
            _outside(x, frame.low_x, frame.nx * frame.width),
            _outside(y, frame.low_y, frame.ny * frame.width),
            _outside(z, frame.low_z, frame.nz * frame.width),
        )
        room += math.sqrt(dot(away, away))
    elif not near:
        room += (mesh.cell_steps[cell] - 1) * frame.width
    bend, farthest = 0.0, 0.0
    if frame.spin != 0.0:
        # In the frame the particle also moves about the axis.
        arm = (place[0] - frame.px, place[1] - frame.py, place[2] - frame.pz)
        spin = (frame.spin * frame.dx, frame.spin * frame.dy, frame.spin * frame.dz)
        farthest = math.sqrt(dot(arm, arm)) + room
        pace += abs(frame.spin) * farthest
        velocity = turned(frame, plus(velocity, -1.0, cross(spin, arm)), -frame.sin)
    piece = _time_over(room, pace, gravity)
    if not near:
        return piece
    if frame.spin != 0.0:
        # Gravity, Coriolis and centrifugal acceleration at most.
        fastest = pace + gravity * piece
        bend = gravity + abs(frame.spin) * (2.0 * fastest + abs(frame.spin) * farthest)
    for m in range(mesh.cell_first[cell], mesh.cell_first[cell + 1]):
        i = mesh.cell_triangles[m]
        distance2, _, _, height = nearest_on_triangle(mesh.sides, mesh.normals, i, x, y, z)
        if distance2 >= reach * reach:
            continue
        time = _time_over(math.sqrt(distance2) - grown, pace, gravity)
        if time < piece:
            n = (mesh.normals[i, 0], mesh.normals[i, 1], mesh.normals[i, 2])
            towards = -gravity * n[1]
            if frame.spin != 0.0:
                towards = -bend if height >= 0.0 else bend
            plane = first_time_within(height, dot(velocity, n), towards, grown, 0.0)
            piece = min(piece, max(time, plane))
    return piece


@kernel(inline=True)
def _outside(x, low, extent):
    """Distance of a coordinate from an interval, m."""
    return max(low - x, max(x - low - extent, 0.0))


@kernel
def time_to_surface(problem, mesh, now, until, x, y, z, vx, vy, vz):
    """Lower bound of the time until a flying particle can touch the surface, s.

    Parameters
    ----------
    problem : Problem
    mesh : Mesh
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
    gravity, time = problem.gravity, 0.0
    for _ in range(MOST_PIECES):
        place = (flight(x, vx, time), fall(y, vy, gravity, time), flight(z, vz, time))
        piece = np.inf
        for f in range(mesh.frames.size):
            frame = mesh.frames[f]
            if frame.spin != 0.0:
                angle = frame.spin * (problem.dt * now + time)
                frame.cos, frame.sin, frame.step = math.cos(angle), math.sin(angle), -1
            velocity = (vx, vy - gravity * time, vz)
            piece = min(piece, _piece_in(problem, mesh, frame, place, velocity))
        time += piece
        if time >= until:
            return until
        if piece < problem.dt:
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
