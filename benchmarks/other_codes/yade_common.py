"""Common parts of the impacts and the jet with YADE."""

import math

from yade.wrapper import (
    ForceResetter,
    FrictMat,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom_MindlinPhys_Mindlin,
    NewtonIntegrator,
    Omega,
)

scene = Omega()


def materials(one):
    """Materials of the particle and of the plate."""
    angle = math.atan(one["mu"])
    particle = FrictMat(
        young=one["e1"], poisson=one["nu1"], density=one["rho"], frictionAngle=angle
    )
    plate = FrictMat(young=one["e2"], poisson=one["nu2"], density=1e4, frictionAngle=angle)
    scene.materials.append([particle, plate])
    return particle, plate


def engines(one, boxes, contacts, gravity):
    """Contact law, integrator and time step."""
    damping = Ip2_FrictMat_FrictMat_MindlinPhys(en=one["e"], es=one["e"])
    scene.engines = [
        ForceResetter(),
        InsertionSortCollider(boxes),
        InteractionLoop(contacts, [damping], [Law2_ScGeom_MindlinPhys_Mindlin()]),
        NewtonIntegrator(damping=0, gravity=gravity),
    ]
    scene.dt = one["dt"]
