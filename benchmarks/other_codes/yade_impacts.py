"""Impacts with YADE: velocities and forces at every step."""

import json
import sys

from yade import config
from yade.utils import sphere, wall
from yade.wrapper import Bo1_Sphere_Aabb, Bo1_Wall_Aabb, Ig2_Wall_Sphere_ScGeom

sys.path.insert(0, ".")
from yade_common import engines, materials, scene

with open("task.json") as file:
    task = json.load(file)
tracks = []
for one in task["impacts"]:
    scene.reset()
    particle, plate = materials(one)
    ball = sphere((0, one["start"], 0), one["radius"], material=particle)
    scene.bodies.append(ball)
    scene.bodies.append(wall(0.0, axis=1, sense=0, material=plate))
    ball.state.vel = (one["v_t"], -one["v_n"], 0)
    engines(one, [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], [Ig2_Wall_Sphere_ScGeom()], (0, 0, 0))
    track = []
    before = (one["v_t"], -one["v_n"], 0.0)
    for _ in range(one["steps"]):
        scene.step()
        v, w = ball.state.vel, ball.state.angVel
        f = scene.forces.f(ball.id)
        # Velocities are half a step ahead of the force.
        after = (v[0], v[1], w[2])
        vx, vy, wz = (0.5 * (new + old) for new, old in zip(after, before, strict=True))
        track.append([vx, vy, -wz, f[0], f[1]])
        before = after
    tracks.append(track)
with open("found.json", "w") as file:
    json.dump({"version": config.version, "tracks": tracks}, file)
