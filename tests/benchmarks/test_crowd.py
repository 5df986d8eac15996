"""A state handed to other codes: the same particles, where they are."""

from dataclasses import replace

import crowd
import numpy as np
import peers
import pytest
from speed import particle

from abradem.dem import Setup

SETUP = Setup(
    plate_length=0.2, plate_width=0.2, patch_length=0.05, patch_width=0.05, fall_height=0.2,
    mass_rate=None, number_rate=300.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def handed():
    case = particle(0.01, 0.0)
    engine = crowd.crowd_after(case, SETUP, 0.1)
    return case, engine, crowd.still(engine, 500)


def test_particles_of_a_state_keep_their_places_and_their_energy(handed):
    _, engine, poured = handed
    mass = engine.problem.mass
    assert len(poured.place) == 30
    energy = 0.5 * mass * (poured.velocity**2).sum()
    assert energy == pytest.approx(poured.energy[0], rel=1e-12)
    # The first fell freely from 0.2 m at 3 m/s until it met the plate: none is faster than that.
    fastest = np.sqrt(3.0**2 + 2.0 * engine.problem.gravity * 0.2)
    assert np.abs(poured.velocity[:, 1]).max() < fastest
    falling = poured.velocity[-1, 1]
    fallen = 0.2 - poured.place[-1, 1]
    assert falling**2 == pytest.approx(3.0**2 + 2.0 * engine.problem.gravity * fallen, rel=1e-3)


@pytest.mark.parametrize("peer", peers.PEERS, ids=lambda peer: peer.name)
def test_other_codes_get_them_all_before_the_only_run(peer, handed):
    case, _, poured = handed
    lines = peer.script(case, replace(SETUP, duration=0.1), poured, 0.01).splitlines()
    kinds = [line.split()[0] for line in lines]
    assert kinds.count("create_atoms") == 30
    assert kinds.count("run") == 1
    assert "run 500" in lines
    assert kinds.index("run") > max(i for i, kind in enumerate(kinds) if kind == "set")
    assert kinds.count("shell") == 2
