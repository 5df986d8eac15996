"""Benchmarks with other codes: they get the same particles, and their logs are parsed correctly."""

import math
import os
from dataclasses import replace

import cost
import numpy as np
import peers
import pytest
from speed import particle

from abradem.dem import Setup, simulate

# More particles than fit at once, so that some wait.
CROWDED = Setup(
    plate_length=0.2, plate_width=0.2, patch_length=0.05, patch_width=0.05, fall_height=0.05,
    mass_rate=None, number_rate=600.0, duration=0.12,
)  # fmt: skip


@pytest.fixture(scope="module")
def crowded():
    case = replace(particle(0.01, 20.0), particle_velocity_y=-0.5)
    return case, peers.pour(case, CROWDED)


def test_releases_written_down_replace_the_factory_bit_by_bit(crowded):
    case, poured = crowded
    due = np.ceil((np.arange(poured.step.size) + 0.5) / (600.0 * poured.problem.dt))
    assert np.count_nonzero(poured.step > due) > 3
    ours, again = simulate(case, CROWDED), simulate(case, CROWDED, poured.releases)
    assert again.released == ours.released == poured.step.size
    assert ours.worn[-1, 0] > 0.0
    np.testing.assert_array_equal(again.worn, ours.worn)
    np.testing.assert_array_equal(again.facet_wear_all, ours.facet_wear_all)


def numbers(line, words):
    """The numbers after each of the words in a line of a script."""
    parts = line.split()
    return [float(parts[parts.index(word) + 1]) for word in words]


@pytest.mark.parametrize("peer", peers.PEERS, ids=lambda peer: peer.name)
def test_scripts_put_in_every_particle_at_its_step(peer, crowded):
    case, poured = crowded
    lines = peer.script(case, CROWDED, poured, 0.01).splitlines()
    now, steps = poured.step[0], []
    for line in lines:
        now += int(line.split()[1]) if line.startswith("run ") else 0
        if line.startswith("create_atoms"):
            steps.append(now)
    np.testing.assert_array_equal(steps, poured.step)
    assert now == poured.end
    speeds = [numbers(line, ("vx", "vy", "vz")) for line in lines if line.startswith("set atom")]
    np.testing.assert_allclose(
        np.linalg.norm(speeds, axis=1), np.linalg.norm(poured.velocity, axis=1)
    )


def test_axes_along_the_plate_keep_heights_over_it(crowded):
    case, poured = crowded
    lines = peers.lammps_script(case, CROWDED, poured, 0.01).splitlines()
    places = np.array(
        [[float(x) for x in line.split()[3:6]] for line in lines if line.startswith("create_atoms")]
    )
    angle = math.radians(case.plate_angle)
    over = poured.place @ [-math.sin(angle), math.cos(angle), 0.0]
    np.testing.assert_allclose(places[:, 1], over, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), np.linalg.norm(poured.place, axis=1))
    (gravity,) = (line.split() for line in lines if line.startswith("fix g all gravity"))
    down = np.array([float(x) for x in gravity[-3:]])
    np.testing.assert_allclose(down, [-math.sin(angle), -math.cos(angle), 0.0], atol=1e-12)


LOG = """LAMMPS (22 Jul 2025 - Update 4)
   Step         Atoms          KinEng
         0           1   0.041887902
       226           1   0.042000000
Loop time of 0.25 on 1 procs for 226 steps with 1 atoms

99.1% CPU use with 1 MPI tasks x 1 OpenMP threads
second
       226           2   0.083887902
       452           2   0.084000000
Loop time of 0.5 on 1 procs for 226 steps with 2 atoms
"""


def test_log_gives_the_run_loops_and_what_was_there_at_their_ends():
    version, loops, rows = peers.read_log(LOG.splitlines())
    assert version == "22 Jul 2025 - Update 4"
    np.testing.assert_array_equal(loops, [[0, 0.25], [1, 0.5]])
    np.testing.assert_array_equal(rows, [[1, 0.042], [2, 0.084]])


def test_a_step_after_the_last_second_counts_as_that_second(crowded):
    poured = crowded[1]
    whole = poured._replace(end=round(2.0 / poured.problem.dt) + 1)
    assert [whole.second(round(t / poured.problem.dt) + 1) for t in (0.5, 1.0, 2.0)] == [0, 1, 1]


def test_computing_time_of_the_loops_of_each_second():
    # Within 2 s on the wall 1.5 s were computed, three quarters of a loop of 0.4 s; then all of it.
    ticks = os.sysconf("SC_CLK_TCK")
    times = [[10.0, 0, 0], [12.0, 1.25 * ticks, 0.25 * ticks], [13.0, 2.25 * ticks, 0.25 * ticks]]
    loops = np.array([[1, 0.1], [1, 0.3], [2, 0.5]])
    rows = np.array([[10, 1.0], [30, 1.0], [40, 1.0]])
    np.testing.assert_allclose(
        peers.by_second(times, loops, rows), [[0.3, 20.0], [0.5, 40.0]], rtol=1e-12
    )


def test_other_work_than_ours_is_called_so(crowded):
    poured = crowded[1]
    particles, energy = poured.present.mean(), poured.energy.mean()
    assert peers.unlike(poured, peers.Run("", 1.0, 1.0, 1.05 * particles, 0.95 * energy)) == ""
    assert (
        peers.unlike(poured, peers.Run("", 1.0, 1.0, 0.8 * particles, energy)) == "particles -20 %"
    )
    assert "kinetic" in peers.unlike(poured, peers.Run("", 1.0, 1.0, particles, math.nan))


@pytest.mark.parametrize(
    ("kind", "plate", "pairs"), [("plate", 64, 0), ("pairs", 0, 32), ("rows", 0, 56)]
)
def test_particles_of_the_limit_touch_all_the_time(kind, plate, pairs):
    case, setup, releases = cost.touching_scene(kind)
    census = cost.Census(setup.duration / 4)
    simulate(case, setup, releases, recorder=census)
    assert census.rows[1:] == [(64, 64, plate, pairs)] * 4
