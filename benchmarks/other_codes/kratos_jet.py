"""A jet with Kratos: velocities at its end, wear of each face, and forces on the way."""

import json
from importlib.metadata import version

import KratosMultiphysics as kratos
from kratos_common import parameters, worn_volume, write_materials, write_parts
from KratosMultiphysics.DEMApplication.DEM_analysis_stage import DEMAnalysisStage

kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)


class Jet(DEMAnalysisStage):
    """Particles that are released one by one."""

    def Initialize(self):
        """Release the particles due at the start; the first particle is in the input."""
        super().Initialize()
        self.due = list(task["releases"])
        self.particles, self.done, self.track = [], 0, []
        self._release()

    def FinalizeSolutionStep(self):
        """Release the particles that are due now."""
        super().FinalizeSolutionStep()
        self.done += 1
        self._release()
        if task["track_steps"] and self.done % task["track_steps"] == 0:
            self._track()
        if self.done == task["steps"]:
            self.end = [list(n.GetSolutionStepValue(kratos.VELOCITY)) for n in self.particles]
            self.wear = [worn_volume(face) for face in self.rigid_face_model_part.Conditions]

    def _track(self):
        """Note place and force of the particles that something pushes upwards."""
        for node in self.particles:
            force = node.GetSolutionStepValue(kratos.TOTAL_FORCES)
            if force[1] > 0.0:
                self.track.append([node.X, node.Y, force[0], force[1]])

    def _release(self):
        while self.due and self.due[0][0] <= self.done:
            _, place, velocity = self.due.pop(0)
            if self.particles:
                element = self.creator_destructor.CreateSphericParticle(
                    self.spheres_model_part, len(self.particles) + 1, kratos.Array3(place),
                    self.spheres_model_part.GetProperties()[1], task["radius"],
                    "SphericParticle3D",
                )  # fmt: skip
                node = element.GetNode(0)
            else:
                node = next(iter(self.spheres_model_part.Nodes))
            node.SetSolutionStepValue(kratos.VELOCITY, kratos.Vector(velocity))
            self.particles.append(node)


with open("task.json") as file:
    task = json.load(file)
write_parts(task["radius"], [task["releases"][0][1]], task["corners"], task["triangles"])
write_materials(task)
run = Jet(kratos.Model(), parameters(task, task["gravity"], search_every=50, skin=0.002))
run.Run()
with open("found.json", "w") as file:
    found = {"version": version("KratosDEMApplication"), "end": run.end, "track": run.track,
             "wear": run.wear}  # fmt: skip
    json.dump(found, file)
