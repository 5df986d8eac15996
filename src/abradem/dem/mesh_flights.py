"""Lower bound of the time until a flying particle can touch a triangulated surface.

The parabola is followed in pieces. At the beginning of each, the grid of each frame gives a
distance that the particle can move, in the coordinates of the frame, before it can touch: to the
nearest triangle if it is in a cell with triangles, otherwise by the cells between. The piece ends
when the particle can have moved that far at the earliest. This is sphere tracing (Hart 1996,
Visual Comput. 12:527) along a parabola.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.bounds import SAFETY, first_time_beyond
from abradem.dem.cache import kernel
from abradem.dem.mesh_search import cell_in, distance2_in_cell, to_frame
from abradem.dem.state import fall, flight

MOST_PIECES = 64
"""Largest number of pieces of a flight; the particle is then examined again."""


@kernel(inline=True)
def _room_in(mesh, frame, x, y, z):
    """Distance that a particle at a point of a frame can move before it can touch a wall, m."""
    radius, reach = mesh.reach[0], mesh.reach[1]
    cell = cell_in(frame, x, y, z)
    if cell < 0:
        away = (
            _outside(x, frame.low_x, frame.nx * frame.width),
            _outside(y, frame.low_y, frame.ny * frame.width),
            _outside(z, frame.low_z, frame.nz * frame.width),
        )
        # The grid ends farther than the reach from all triangles.
        room = math.hypot(math.hypot(away[0], away[1]), away[2]) + reach
    else:
        steps = mesh.cell_steps[cell]
        if steps == 0:
            room = min(math.sqrt(distance2_in_cell(mesh, cell, x, y, z)), reach)
        else:
            room = reach + (steps - 1) * frame.width
    return max(room - radius * (1.0 + SAFETY), 0.0)


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
        px, pz = flight(x, vx, time), flight(z, vz, time)
        py = fall(y, vy, gravity, time)
        down = vy - gravity * time
        speed = math.sqrt(vx * vx + down * down + vz * vz)
        piece = np.inf
        for f in range(mesh.frames.size):
            frame = mesh.frames[f]
            pace = speed
            if frame.spin != 0.0:
                angle = frame.spin * (problem.dt * now + time)
                frame.cos, frame.sin, frame.step = math.cos(angle), math.sin(angle), -1
            fx, fy, fz = to_frame(frame, px, py, pz)
            room = _room_in(mesh, frame, fx, fy, fz)
            if frame.spin != 0.0:
                # In the frame, the particle also moves about the axis.
                arm = math.hypot(math.hypot(px - frame.px, py - frame.py), pz - frame.pz)
                pace += abs(frame.spin) * (arm + room)
            root = math.sqrt(pace * pace + 2.0 * gravity * room)
            if room == 0.0:
                piece = 0.0
            elif pace + root > 0.0:
                piece = min(piece, 2.0 * room / (pace + root))
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
