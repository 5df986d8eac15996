"""The jet with YADE: velocities at its end."""

import json
import math
import sys

from yade import config
from yade.minieigenHP import Quaternion
from yade.utils import box, sphere
from yade.wrapper import (
    Bo1_Box_Aabb,
    Bo1_Sphere_Aabb,
    Ig2_Box_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
)

sys.path.insert(0, ".")
from yade_common import engines, materials, scene

with open("task.json") as file:
    task = json.load(file)
particle, plate = materials(task)
angle, half, thin = task["angle"], 0.5 * task["plate"], 0.5 * task["thin"]
below = (thin * math.sin(angle), -thin * math.cos(angle), 0)
turned = Quaternion((0, 0, 1), angle)
scene.bodies.append(box(below, (half, thin, half), orientation=turned, fixed=True, material=plate))
engines(
    task, [Bo1_Sphere_Aabb(), Bo1_Box_Aabb()],
    [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()], (0, -task["gravity"], 0),
)  # fmt: skip
balls = []
for step, place, velocity in task["releases"]:
    if step > scene.iter:
        scene.run(step - scene.iter, True)
    ball = sphere(place, task["radius"], material=particle)
    scene.bodies.append(ball)
    ball.state.vel = velocity
    balls.append(ball)
scene.run(task["steps"] - scene.iter, True)
with open("found.json", "w") as file:
    json.dump({"version": config.version, "end": [list(ball.state.vel) for ball in balls]}, file)
