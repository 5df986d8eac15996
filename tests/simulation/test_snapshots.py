"""Snapshots of a case."""

import numpy as np
import pandas as pd
import pytest

from abradem.dem import Case, Setup, simulate
from abradem.simulation.snapshots import PLATE, write_snapshots
from abradem.store.tables import read_units

CASE = Case(6e9, 0.25, 3000, 8e10, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 20.0, -30.0, 0.01, -5.0, 3)
SETUP = Setup(duration=0.3)


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("snapshots")
    write_snapshots(vars(CASE), SETUP, folder, 0.002)
    return {name: folder / f"{name}.parquet" for name in ("particles", "contacts", "wear")}


def test_snapshots_are_taken_at_the_interval(tables):
    times = np.unique(pd.read_parquet(tables["particles"])["time"])
    np.testing.assert_allclose(np.diff(times), 0.002, rtol=2e-3)


def test_a_falling_particle_is_where_gravity_takes_it(tables):
    particles = pd.read_parquet(tables["particles"])
    particle = particles[particles["particle"] == 0].sort_values("time")
    fall = particle[particle["y"] > 0.1]
    assert len(fall) > 5
    drop = np.diff(fall["vy"]) / np.diff(fall["time"])
    np.testing.assert_allclose(drop, -9.81, rtol=1e-9)
    heights = fall["y"] - fall["y"].iloc[0]
    since = fall["time"] - fall["time"].iloc[0]
    expected = fall["vy"].iloc[0] * since - 0.5 * 9.81 * since**2
    np.testing.assert_allclose(heights, expected, atol=1e-12)


def test_contact_forces_obey_coulomb_and_name_their_partner(tables):
    contacts = pd.read_parquet(tables["contacts"])
    assert (contacts["partner"] == PLATE).any() and (contacts["partner"] != PLATE).any()
    force = np.linalg.norm(contacts[[f"tangential_force_{axis}" for axis in "xyz"]], axis=1)
    assert (force <= 0.45 * contacts["normal_force"] * (1 + 1e-9) + 1e-12).all()
    assert (contacts["normal_force"] >= 0.0).all()


def test_the_last_wear_map_is_that_of_the_simulation(tables):
    wear = pd.read_parquet(tables["wear"])
    last = wear[wear["time"] == wear["time"].max()]
    result = simulate(CASE, SETUP)
    assert 0 < last["wear_total"].sum() <= result.worn[-1, 0]
    assert wear.groupby("time")["wear_total"].sum().is_monotonic_increasing


def test_every_column_has_its_unit(tables):
    units = read_units(tables["contacts"])
    assert units["normal_force"] == "N" and units["time"] == "s" and units["partner"] == "1"
