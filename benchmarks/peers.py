"""The jets of `speed.py` simulated and timed with LIGGGHTS and LAMMPS.

Each peer gets a generated input script with the same particles, step and plate: Hertz-Mindlin
contacts with rolling friction, the plate as one wall of finite size, particles inserted at the
steps, positions and velocities at which this engine released them, and removed below the same
level. There is no wear and no output; one core is used. The time of a peer is the sum of the loop
times in its log. Reading scripts, set-up, insertion of particles and the pair lists built at the
start of a run are not included. At each simulated second the script writes down the computing time
of the process, from `/proc` of Linux.

Differences: LIGGGHTS uses the displacement law with uncapped damping, LAMMPS the incremental law.
In both, contacts are attractive at their end, which gives the same restitution as the default of
this engine. Both resist relative rolling, LIGGGHTS in proportion to the elastic force only, LAMMPS
by a spring and slider; this engine slows the spin of each particle in proportion to the whole
normal force. Beds of the peers therefore have some per cent fewer particles, to their advantage.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from abradem.dem.contact import effective_moduli
from abradem.dem.model import Case, Setup
from abradem.dem.simulation import Engine
from abradem.dem.state import FLYING, GONE, Problem, make_problem

MARGIN = 0.1
"""Largest relative difference of particles and kinetic energy in a fair comparison."""

ROLLING_STEPS = 314
"""Period of the rolling spring of LAMMPS in steps: stiff, but well resolved."""

REMOVAL_STEPS = 1000
"""Number of steps between two checks of LAMMPS for particles below the removal level."""


class Pour(NamedTuple):
    """Releases of this engine, and the particles present during the simulation.

    Attributes
    ----------
    problem : Problem
    end : int
        Last lattice step.
    step : ndarray, shape (n,)
        Lattice step of each release.
    place, velocity : ndarray, shape (n, 3)
        m, m/s.
    particles, energy : ndarray, shape (m,)
        Particles present and their kinetic energy without spin (J) just before each step with a
        release, except for the first.
    low, high : ndarray, shape (3,)
        Box that contained all centres just after those steps, m.
    """

    problem: Problem
    end: int
    step: np.ndarray
    place: np.ndarray
    velocity: np.ndarray
    present: np.ndarray
    energy: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def second(self, step: int) -> int:
        """Simulated second in which a lattice step is, from 0; a last step or two count before."""
        last = math.ceil(self.end * self.problem.dt - 1e-3) - 1
        return min(int(step * self.problem.dt), max(0, last))

    @property
    def releases(self):
        """Releases for `abradem.simulate`."""
        return self.step * self.problem.dt, self.place, self.velocity


@dataclass(frozen=True)
class Run:
    """Result of a peer: version, seconds of its run loop, mean particles and kinetic energy.

    ``seconds`` (s, 2) has the computing time (s) and the mean number of particles in each simulated
    second.
    """

    version: str
    wall: float
    cpu: float
    present: float
    energy: float
    seconds: np.ndarray | None = None


def pour(case: Case, setup: Setup) -> Pour:
    """Simulate a case for the duration of its set-up and record its releases.

    The engine is stopped before and after each step with a release: until its first contact a
    particle keeps the anchor of its flight, which is where it was released.
    """
    problem, schedule = make_problem(case, setup)
    engine = Engine(problem, schedule, "islands")
    sample = max(1, round(setup.sample_interval / problem.dt))
    end = max(1, round(setup.duration / (sample * problem.dt))) * sample
    steps, places, present, energy = [], [], [], []
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    step = int(engine.state.tally["next_release"][0])
    while step < end:
        engine.advance(step, None, None)
        before = _present(engine)
        engine.advance(step + 1, None, None)
        after = _present(engine)
        new = after[after["identity"] >= len(steps)]
        centres = np.stack([after[axis] for axis in "xyz"])
        low = np.minimum(low, centres.min(axis=1, initial=np.inf))
        high = np.maximum(high, centres.max(axis=1, initial=-np.inf))
        if steps and new.size:
            present.append(before.size)
            energy.append(kinetic_energy(problem, before, step))
        for particle in new[np.argsort(new["identity"])]:
            steps.append(int(particle["anchor_step"]))
            places.append([float(particle[f"anchor_{axis}"]) for axis in "xyz"])
        step = int(engine.state.tally["next_release"][0])
    velocity = np.tile([0.0, case.particle_velocity_y, 0.0], (len(steps), 1))
    return Pour(
        problem, end, np.array(steps), np.array(places), velocity,
        np.array(present), np.array(energy), low, high,
    )  # fmt: skip


def _present(engine) -> np.ndarray:
    particles = engine.state.particles[: int(engine.state.tally["live"][0])]
    return particles[particles["motion"] != GONE]


def kinetic_energy(problem: Problem, particles: np.ndarray, step: int) -> float:
    """Return the kinetic energy of all particles without spin, J."""
    flown = np.where(particles["motion"] == FLYING, step - particles["anchor_step"], 0)
    vy = particles["vy"] - problem.gravity * problem.dt * flown
    speed2 = particles["vx"] ** 2 + vy**2 + particles["vz"] ** 2
    return 0.5 * problem.mass * float(speed2.sum())


def unlike(poured: Pour, run: Run) -> str:
    """Return the differences of a peer above `MARGIN` as text, or ""."""
    words = []
    for name, ours, theirs in (
        ("particles", poured.present.mean(), run.present),
        ("kinetic energy", poured.energy.mean(), run.energy),
    ):
        if not abs(theirs / ours - 1.0) <= MARGIN:
            words.append(f"{name} {100.0 * (theirs / ours - 1.0):+.0f} %")
    return ", ".join(words)


TAKE_TIME = ("print second", "shell sh times.sh")

TIMES = """p=$PPID
while [ "$(cat /proc/$p/comm)" = sh ]; do p=$(cut -d' ' -f4 /proc/$p/stat); done
echo $(cut -d' ' -f1 /proc/uptime) $(cut -d' ' -f14,15 /proc/$p/stat) >> times
"""
"""Writes wall time (s) and computing time (user, system, ticks) of the code that calls it."""

# LIGGGHTS

LIGGGHTS = """units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
hard_particles yes
region box block {box} units box
create_box 2 box
neighbor {skin!r} bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype {moduli[0]} {moduli[1]}
fix m2 all property/global poissonsRatio peratomtype {particle.poisson_ratio} {plate.poisson_ratio}
fix m3 all property/global coefficientRestitution peratomtypepair 2 {restitution}
fix m4 all property/global coefficientFriction peratomtypepair 2 {friction}
fix m5 all property/global coefficientRollingFriction peratomtypepair 2 {rolling}
pair_style gran model hertz tangential history rolling_friction cdt
pair_coeff * *
timestep {dt!r}
fix plate all mesh/surface file plate.stl type 2
fix wall all wall/gran model hertz tangential history rolling_friction cdt &
    mesh n_meshes 1 meshes plate
fix g all gravity {gravity} vector 0 -1 0
fix move all nve/sphere
"""

THERMO = """thermo 1000000
thermo_style custom step atoms ke
thermo_modify lost ignore norm no
"""


def _plate_stl(case: Case, setup: Setup) -> str:
    angle = math.radians(case.plate_angle)
    half, width = 0.5 * setup.plate_length, 0.5 * setup.plate_width
    corners = [
        (a * math.cos(angle), a * math.sin(angle), z)
        for a, z in ((-half, -width), (half, -width), (half, width), (-half, width))
    ]
    lines = ["solid plate"]
    for triangle in ((0, 1, 2), (0, 2, 3)):
        lines += ["facet normal 0 1 0", "outer loop"]
        lines += ["vertex {:.17g} {:.17g} {:.17g}".format(*corners[i]) for i in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid plate", ""])


def _box(low, high) -> str:
    return " ".join(f"{float(a)!r} {float(b)!r}" for a, b in zip(low, high, strict=True))


def _room(case: Case, poured: Pour):
    """Return a larger box, for particles that bounce higher and farther than in this engine."""
    room = 10.0 * case.particle_radius
    return poured.low - room, poured.high + room


def _four(value: float) -> str:
    return " ".join([repr(float(value))] * 4)


def liggghts_script(case: Case, setup: Setup, poured: Pour, skin: float) -> str:
    """Return the input of LIGGGHTS, with the plate as a mesh of two triangles.

    Particles are removed at the lower face of the box.
    """
    low, high = _room(case, poured)
    low[1] = poured.problem.removal_height
    head = LIGGGHTS.format(
        box=_box(low, high), skin=skin, particle=case.particle,
        moduli=(case.particle.youngs_modulus, case.plate.youngs_modulus), plate=case.plate,
        restitution=_four(case.restitution), friction=_four(case.static_friction),
        rolling=_four(case.rolling_friction), dt=poured.problem.dt, gravity=setup.gravity,
    )  # fmt: skip
    return head + THERMO + _releases(case, poured, poured.place, poured.velocity)


# LAMMPS

LAMMPS = """units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
region box block {box} units box
create_box 1 box
neighbor {skin!r} bin
neigh_modify delay 0
pair_style granular
pair_coeff * * {pair_law}
timestep {dt!r}
region plate block {plate} side out units box
fix wall all wall/gran/region granular {plate_law} region plate
fix g all gravity {gravity} vector {down}
region below plane {level} {down} units box
fix gone all evaporate {removal_steps} 1000000 below 1
fix move all nve/sphere
"""


def _lammps_law(a, b, case: Case, problem: Problem) -> str:
    """k_n = 4/3 E*, damping for e, k_t = 8 G*, damping in the ratio of the stiffnesses."""
    e_star, g_star = effective_moduli(a, b)
    ratio, mu = math.sqrt(8.0 * g_star / (2.0 * e_star)), case.static_friction
    turn = 2.0 * math.pi / (ROLLING_STEPS * problem.dt)
    return (
        f"hertz {4.0 / 3.0 * e_star!r} {case.restitution} damping coeff_restitution &\n"
        f"    tangential mindlin_rescale/force {8.0 * g_star!r} {ratio!r} {mu} &\n"
        f"    rolling sds {problem.mass * turn**2!r} {2.0 * problem.mass * turn!r} "
        f"{case.rolling_friction}"
    )


def lammps_script(case: Case, setup: Setup, poured: Pour, skin: float) -> str:
    """Return the input of LAMMPS in axes along the plate; tilted regions cost time in each step.

    The plate is the outer surface of a block with a thickness of a tenth of the radius.
    """
    problem = poured.problem
    angle = math.radians(case.plate_angle)
    turn = np.array(
        [[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0],
         [0.0, 0.0, 1.0]]
    )  # fmt: skip
    low, high = _room(case, poured)
    corners = np.array([[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])]) @ turn
    low[:2], high[:2] = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    half = np.array([0.5 * setup.plate_length, 0.0, 0.5 * setup.plate_width])
    thick = np.array([0.0, 0.1 * case.particle_radius, 0.0])
    down = np.array([0.0, -1.0, 0.0]) @ turn
    level = np.array([0.0, problem.removal_height, 0.0]) @ turn
    head = LAMMPS.format(
        box=_box(low, high), skin=skin, dt=problem.dt, gravity=setup.gravity,
        pair_law=_lammps_law(case.particle, case.particle, case, problem),
        plate_law=_lammps_law(case.particle, case.plate, case, problem),
        plate=_box(-half - thick, half), down=_vector(down), level=_vector(level),
        removal_steps=REMOVAL_STEPS,
    )  # fmt: skip
    return head + THERMO + _releases(case, poured, poured.place @ turn, poured.velocity @ turn)


def _vector(values) -> str:
    return " ".join(f"{float(value):.17g}" for value in values)


def _releases(case: Case, poured: Pour, place, velocity) -> str:
    """Return the runs between the releases; the time starts with the first particle.

    The computing time is written down before the first run of each simulated second, and at the
    end.
    """
    lines, now, second = [], poured.step[0], -1
    size = f"diameter {2.0 * case.particle_radius!r} density {case.particle_density!r}"
    for i, step in enumerate([*poured.step, poured.end]):
        if step > now:
            if poured.second(now) > second:
                second = poured.second(now)
                lines += TAKE_TIME
            lines.append(f"run {step - now}")
            now = step
        if i < len(place):
            lines.append(f"create_atoms 1 single {_vector(place[i])} units box")
            speed = "vx {:.17g} vy {:.17g} vz {:.17g}".format(*velocity[i])
            lines.append(f"set atom {i + 1} {size} {speed}")
    return "\n".join([*lines, *TAKE_TIME, ""])


# Both

_VERSION = re.compile(r"\(Version LIGGGHTS-PUBLIC ([\d.]+)|^LAMMPS \(([^)]+)\)")
_ROW = re.compile(r"^\s*\d+\s+(\d+)\s+([-+.\deE]+)\s*$")
_LOOP = re.compile(r"^Loop time of (\S+) on 1 procs")


def read_log(lines) -> tuple[str, np.ndarray, np.ndarray]:
    """Return version, loop times of all runs, and particles and energy at the end of each.

    Parameters
    ----------
    lines : iterable of str
        Output of a peer.

    Returns
    -------
    version : str
    loops : ndarray, shape (runs, 2)
        Number of times that `TAKE_TIME` came before; loop time, s.
    rows : ndarray, shape (runs, 2)
        Particles present, kinetic energy in J.
    """
    version, second, loops, rows, last = "", 0, [], [], None
    for line in lines:
        if found := _VERSION.search(line):
            version = version or found[1] or found[2]
        elif line.strip() == "second":
            second += 1
        elif found := _ROW.match(line):
            last = (int(found[1]), float(found[2]))
        elif found := _LOOP.match(line):
            loops.append((second, float(found[1])))
            rows.append(last)
    return version, _pairs(loops), _pairs(rows)


def _pairs(rows) -> np.ndarray:
    return np.array(rows, dtype=float).reshape(-1, 2)


class Peer(NamedTuple):
    """A code: its program, and the function that writes its input."""

    name: str
    program: str
    script: object


PEERS = (Peer("LIGGGHTS", "liggghts", liggghts_script), Peer("LAMMPS", "lmp", lammps_script))


def installed(peer: Peer) -> str | None:
    """Return the path of the program of a peer, or None."""
    return shutil.which(peer.program)


def timed_run(peer: Peer, case: Case, setup: Setup, poured: Pour, skin: float) -> Run:
    """Simulate the particles of a pour with a peer and read its log.

    Raises
    ------
    RuntimeError
        If the peer fails; the message contains the end of its output.
    """
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "in.jet").write_text(peer.script(case, setup, poured, skin))
        Path(folder, "plate.stl").write_text(_plate_stl(case, setup))
        Path(folder, "times.sh").write_text(TIMES)
        log = Path(folder, "log.txt")
        with log.open("w") as sink:
            done = subprocess.run(
                [installed(peer), "-in", "in.jet", "-log", "none"],
                cwd=folder, stdout=sink, stderr=subprocess.STDOUT,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
            )  # fmt: skip
        if done.returncode != 0:
            raise RuntimeError(f"{peer.name} failed:\n{log.read_text()[-2000:]}")
        with log.open() as lines:
            version, loops, rows = read_log(lines)
        times = np.loadtxt(Path(folder, "times"))
    # The last row is after the last release; the values of this engine are before each release.
    present, energy = (rows[:-1] if len(rows) > 1 else rows).mean(axis=0)
    seconds = by_second(times, loops, rows)
    return Run(
        version, float(loops[:, 1].sum()), float(seconds[:, 0].sum()), float(present),
        float(energy), seconds,
    )  # fmt: skip


def by_second(times, loops, rows) -> np.ndarray:
    """Return computing time of the loops (s) and mean number of particles in each second.

    Loop times are wall times; the same share of a core is assumed for all that a peer does within
    a second.

    Parameters
    ----------
    times : array_like, shape (s + 1, 3)
        What `TIMES` wrote: wall time in s, user and system time in ticks.
    loops, rows : ndarray, shape (runs, 2)
        See `read_log`.
    """
    wall, user, system = np.diff(times, axis=0).T
    share = (user + system) / os.sysconf("SC_CLK_TCK") / wall
    seconds = []
    for i, busy in enumerate(share, start=1):
        here = loops[:, 0] == i
        seconds.append((busy * loops[here, 1].sum(), rows[here, 0].mean()))
    return _pairs(seconds)
