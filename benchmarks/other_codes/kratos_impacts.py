"""Impacts with Kratos: velocities and forces at every step, and the wear computed by Kratos."""

import json
from importlib.metadata import version

import KratosMultiphysics as kratos
from kratos_common import parameters, worn_volume, write_materials, write_parts
from KratosMultiphysics.DEMApplication.DEM_analysis_stage import DEMAnalysisStage

kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)


class Impact(DEMAnalysisStage):
    """One impact."""

    def __init__(self, model, settings, velocity):
        super().__init__(model, settings)
        self.velocity = velocity
        self.track = []

    def Initialize(self):
        """Give the particle its velocity."""
        super().Initialize()
        self.particle = next(iter(self.spheres_model_part.Nodes))
        self.particle.SetSolutionStepValue(kratos.VELOCITY, kratos.Vector(self.velocity))
        self.face = next(iter(self.rigid_face_model_part.Conditions))

    def FinalizeSolutionStep(self):
        """Record the step."""
        super().FinalizeSolutionStep()
        names = (kratos.VELOCITY, kratos.ANGULAR_VELOCITY, kratos.TOTAL_FORCES)
        v, w, f = (self.particle.GetSolutionStepValue(name) for name in names)
        self.track.append([v[0], v[1], -w[2], f[0], f[1]])
        self.wear = worn_volume(self.face)


with open("task.json") as file:
    task = json.load(file)
tracks, wear = [], []
for one in task["impacts"]:
    side = 10.0 * one["radius"]
    # The particle hits the middle of the first face.
    corners = [(-1, 0, -1), (-1, 0, 2), (2, 0, -1), (2, 0, -2)]
    corners = [tuple(side * c for c in corner) for corner in corners]
    write_parts(one["radius"], [(0.0, one["start"], 0.0)], corners)
    write_materials(one)
    run = Impact(kratos.Model(), parameters(one), [one["v_t"], -one["v_n"], 0.0])
    run.Run()
    tracks.append(run.track)
    wear.append(run.wear)
with open("found.json", "w") as file:
    json.dump({"version": version("KratosDEMApplication"), "tracks": tracks, "wear": wear}, file)
