"""Triangulated surfaces: against the plate, closed forms, and between the two steppings."""

import dataclasses
import itertools

import numpy as np
import pytest

from abradem.dem import islands, simulate, synchronous
from abradem.dem.agenda import make_agenda
from abradem.dem.mesh import MOST_HITS, WALLS, make_mesh
from abradem.dem.mesh_contact import clear_walls
from abradem.dem.mesh_flights import time_to_surface
from abradem.dem.mesh_search import find_contacts, surface_distance, turn_to
from abradem.dem.model import Case, Setup
from abradem.dem.state import DONE, GONE, make_problem, make_state
from abradem.dem.surface import CELL_SUMS, Feed, cell_areas, check_surface, standing_surface
from abradem.verification import surfaces as checked
from abradem.verification.surface_scenes import arc, belt, cut_plane, drum, extruded, room_corner

CASE = Case(6e9, 0.25, 3000, 8e10, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 30.0, 0.0, 0.01, -3.0, 3)
CHANNEL = extruded([(-0.1, 0.05), (0.0, 0.0), (0.02, 0.0), (0.1, 0.07)], 0.2, across=4)


# Laws


@pytest.mark.parametrize(
    "checks",
    [
        checked.cut_plane_checks, checked.seam_checks, checked.edge_checks, checked.corner_checks,
        checked.arc_checks, checked.belt_checks, checked.drum_checks,
        checked.bed_in_drum_checks,
    ],
)  # fmt: skip
def test_motions_on_surfaces_match_the_plate_and_closed_forms(checks):
    for check in checks():
        assert check.holds, f"{check.law}: {check.ours} instead of {check.reference}"


# Geometry


def nearest_by_sampling(surface, point, count=400):
    """Distance of a point to the triangles, from a dense grid of points on each."""
    weights = np.array(
        [(u, v) for u, v in itertools.product(np.linspace(0, 1, count), repeat=2) if u + v <= 1]
    )
    least = np.inf
    for corners in surface.vertices[surface.triangles]:
        on = corners[0] + weights @ (corners[1:] - corners[0])
        least = min(least, np.linalg.norm(on - point, axis=1).min())
    return least


def test_the_distance_to_a_surface_is_that_to_its_nearest_point():
    surface = extruded([(-0.03, 0.02), (0.0, 0.0), (0.01, 0.03)], 0.05)
    radius = 0.02
    mesh = make_mesh(surface, radius, 1)
    rng = np.random.default_rng(0)
    near = 0
    for point in rng.uniform(-0.05, 0.05, (150, 3)):
        found, expected = surface_distance(mesh, *point), nearest_by_sampling(surface, point)
        if expected < radius:
            near += 1
            assert found == pytest.approx(expected, abs=1e-4)
        assert found >= expected - 1e-4
    assert near > 30


@pytest.mark.parametrize("irregular", [False, True])
def test_a_sphere_on_a_cut_plane_has_one_contact_everywhere(irregular):
    """Above faces, above edges and vertices to the last bit, and at all depths."""
    surface = cut_plane(0.1, 0.1, 0.0, (8, 8), irregular)
    radius = 0.02
    mesh = make_mesh(surface, radius, 1)
    rng = np.random.default_rng(1)
    middles = 0.5 * (surface.vertices[surface.triangles] + np.roll(
        surface.vertices[surface.triangles], 1, axis=1)).reshape(-1, 3)  # fmt: skip
    places = np.concatenate([surface.vertices, middles, rng.uniform(-0.04, 0.04, (300, 3))])
    places = places[np.abs(places[:, [0, 2]]).max(axis=1) < 0.045]
    for depth in (1e-9, 1e-5, 1e-3, 5e-3):
        for x, _, z in places:
            assert find_contacts(mesh, 0, x, radius - depth, z, MOST_HITS, WALLS) == 1
            hit = mesh.hits[0]
            assert hit["distance"] == pytest.approx(radius - depth, rel=1e-12)
            assert hit["ny"] == pytest.approx(1.0)


def test_a_sphere_in_an_arc_has_one_contact_and_in_a_corner_three():
    radius = 0.01
    mesh = make_mesh(arc(0.1, -80.0, 80.0, 80, 0.1), radius, 1)
    for angle in np.radians(np.linspace(-70.0, 70.0, 101)):
        # Deeper than the corners of the facets are outside the cylinder.
        reach = 0.1 - radius + 1e-4
        x, y = reach * np.sin(angle), -reach * np.cos(angle)
        assert find_contacts(mesh, 0, x, y, 0.001, MOST_HITS, WALLS) == 1
    mesh = make_mesh(room_corner(0.1), radius, 1)
    near = radius - 1e-5
    assert find_contacts(mesh, 0, near, near, near, MOST_HITS, WALLS) == 3
    assert find_contacts(mesh, 0, near, near, 0.05, MOST_HITS, WALLS) == 2
    assert find_contacts(mesh, 0, near, 0.05, 0.05, MOST_HITS, WALLS) == 1
    assert find_contacts(mesh, 0, 0.05, 0.05, 0.05, MOST_HITS, WALLS) == 0


@pytest.mark.parametrize("spin", [0.0, 3.0])
@pytest.mark.parametrize("name", ["irregular plane", "arc", "corner", "roof", "fine"])
def test_contacts_are_the_same_bits_with_and_without_spots(name, spin):
    """A particle that wanders and is looked up by its spots, and one that is always searched."""
    radius = 0.01
    surface = {
        "irregular plane": cut_plane(0.1, 0.1, 20.0, (5, 5), irregular=True),
        "arc": arc(0.06, -80.0, 80.0, 16, 0.06),
        "corner": room_corner(0.05),
        "roof": extruded([(-0.04, -0.03), (0.0, 0.0), (0.04, -0.03)], 0.06, 2),
        "fine": arc(0.06, -60.0, 60.0, 60, 0.004),
    }[name]
    surface = surface._replace(angular_velocity=np.array([spin]))
    problem, _ = make_problem(CASE, Setup(surface=surface, time_step=1e-4))
    mesh = make_mesh(surface, radius, 2)
    rng = np.random.default_rng(3)
    centres = surface.vertices[surface.triangles].mean(axis=1)
    places = centres[rng.integers(len(centres), size=60)] + rng.normal(0.0, 0.7 * radius, (60, 3))
    compared, spared = 0, 0
    for start in places:
        place, velocity = start.copy(), rng.normal(0.0, 1.0, 3)
        clear_walls(mesh, 0)
        for step in range(60):
            turn_to(problem, mesh, step)
            before = mesh.spots[0].copy()
            found = find_contacts(mesh, 0, *place, MOST_HITS, WALLS)
            hits = mesh.hits[:found].copy()
            spared += int(np.array_equal(before, mesh.spots[0]))
            clear_walls(mesh, 1)
            assert find_contacts(mesh, 1, *place, MOST_HITS, WALLS) == found
            fields = ["nx", "ny", "nz", "distance", "triangle", "frame", "on_face"]
            np.testing.assert_array_equal(hits[fields], mesh.hits[:found][fields])
            compared += found
            velocity += rng.normal(0.0, 0.3, 3)
            place += velocity * 1e-4
    assert compared > 300
    assert spared > 1200


# Steppings


def moved(surface, **changes):
    """The surface with a field of its one part changed."""
    return surface._replace(**{name: np.array([value]) for name, value in changes.items()})


SURFACES = {
    "channel": (CHANNEL, Setup(surface=CHANNEL, mass_rate=20.0, patch_length=0.15)),
    "belt": (None, Setup(surface=belt(0.3, 0.2, 20.0, 2.0), mass_rate=20.0)),
    "drum": (
        None,
        Setup(
            surface=drum(0.12, 24, 0.2, 12.0),
            mass_rate=None,
            number_rate=300.0,
            feed=Feed((0.0, 0.03, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.15), (0.3, -1.0, 0.1)),
            removal_box=((-0.5, -0.3, -0.12), (0.5, 0.5, 0.12)),
        ),
    ),
    "blades": (
        None,
        Setup(
            surface=moved(
                extruded([(-0.1, 0.0), (0.1, 0.0)], 0.1, across=3),
                angular_velocity=-30.0,
                axis_point=(0.02, 0.0, 0.0),
                axis_direction=(0.2, 0.1, 1.0),
            ),
            mass_rate=15.0,
        ),
    ),
}


@pytest.mark.parametrize("name", SURFACES)
def test_both_steppings_give_the_same_bits(name):
    setup = SURFACES[name][1]
    problem, schedule = make_problem(CASE, setup)
    slow, fast = (make_state(problem, 1024, setup.surface) for _ in range(2))
    agenda = make_agenda(problem, 1024)
    for until in (0.1, 0.25, 0.4):
        step = int(until / problem.dt)
        outcome = synchronous.advance(problem, schedule, slow, step)
        assert islands.advance(problem, schedule, fast, agenda, step) == outcome == DONE
        for field in slow.tally.dtype.names:
            if field not in ("pairs", "drift", "gone", "live"):
                assert slow.tally[field][0] == fast.tally[field][0], field
        np.testing.assert_array_equal(slow.facet_wear, fast.facet_wear)
        np.testing.assert_array_equal(slow.mesh.sums, fast.mesh.sums)
        rows = []
        for state in (slow, fast):
            live = state.particles[: int(state.tally["live"][0])]
            order = np.argsort(live["identity"], kind="stable")
            order = order[live["motion"][order] != GONE]
            rows.append((live[order], state.mesh.walls[order]))
        for field in ("identity", "motion", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"):
            np.testing.assert_array_equal(rows[0][0][field], rows[1][0][field])
        touching = rows[0][1]["plate_stiffness"] != 0.0
        for field in ("plate_stiffness", "plate_fn", "plate_sx", "nx"):
            np.testing.assert_array_equal(rows[0][1][field][touching], rows[1][1][field][touching])
    assert slow.tally["worn_total"][0] > 0.0
    assert slow.tally["placed"][0] > 20


@pytest.mark.parametrize("name", SURFACES)
def test_no_flight_touches_a_surface_before_its_bound(name):
    setup = dataclasses.replace(SURFACES[name][1], time_step=5e-5)
    problem, _ = make_problem(CASE, setup)
    mesh = make_mesh(setup.surface, problem.radius, 1)
    rng = np.random.default_rng(5)
    met, shares = 0, []
    for place, velocity in zip(
        rng.uniform(-0.15, 0.15, (60, 3)), rng.uniform(-4.0, 4.0, (60, 3)), strict=True
    ):
        turn_to(problem, mesh, 0)
        if surface_distance(mesh, *place) < problem.radius:
            continue
        bound = time_to_surface(problem, mesh, 0, 0, np.inf, *place, *velocity)
        for step in range(600):
            time = step * problem.dt
            x, y, z = place + velocity * time - [0.0, 0.5 * problem.gravity * time**2, 0.0]
            turn_to(problem, mesh, step)
            if find_contacts(mesh, 0, x, y, z, MOST_HITS, WALLS) > 0:
                assert time >= bound * (1.0 - 1e-9)
                met += 1
                shares.append(bound / time)
                break
    assert met >= 8
    # Most flights are bounded closely, so that they are not examined again and again.
    assert np.median(shares) > 0.9


# A case


def test_a_case_on_a_surface_has_its_wear_by_cell():
    setup = Setup(surface=CHANNEL, duration=0.5, mass_rate=10.0)
    result = simulate(CASE, setup)
    cells = len(CHANNEL.triangles)
    assert result.status == "ok"
    assert result.facet_wear_all.shape == (3, cells)
    assert result.cell_sums_all.shape == (len(CELL_SUMS), cells)
    np.testing.assert_allclose(result.facet_wear_all.sum(axis=1), result.worn[-1], rtol=1e-10)
    impacts, speed, angle, normal, tangential, impulse = result.cell_sums_all
    hit = impacts > 0
    assert impacts.sum() >= result.released - 50 and hit.sum() > 5
    fastest = np.sqrt(3.0**2 + 2 * 9.81 * 0.36)
    assert np.all(speed[hit] / impacts[hit] <= fastest)
    assert np.all((angle[hit] / impacts[hit] > 0.0) & (angle[hit] / impacts[hit] < 90.0))
    assert all(np.all(of[hit] > 0.0) for of in (normal, tangential, impulse))
    assert np.all(impacts[~hit] == 0.0)


def test_a_case_on_a_surface_reaches_its_window():
    setup = Setup(surface=CHANNEL, window=0.5, max_time=1.5, target_stderr=0.5)
    result = simulate(dataclasses.replace(CASE, particle_radius=0.02), setup)
    assert np.isfinite(result.window).all()
    np.testing.assert_allclose(result.facet_wear_parts.sum(axis=0), result.facet_wear, rtol=1e-12)
    assert np.all(result.cell_sums <= result.cell_sums_all + 1e-12)


def test_a_feed_aims_a_jet_from_anywhere():
    wall = extruded([(0.3, -0.2), (0.3, 0.2)], 0.4)
    feed = Feed((0.0, 0.02, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.3), (2.0, 0.0, 0.0))
    case = dataclasses.replace(CASE, particle_velocity_y=-6.0)
    setup = Setup(surface=wall, feed=feed, duration=0.25, mass_rate=None, number_rate=50.0)
    result = simulate(case, setup)
    impacts, speed, angle = result.cell_sums_all[:3].sum(axis=1)
    assert impacts >= 8
    # Few of the particles meet one that has rebounded.
    assert speed / impacts == pytest.approx(6.0, rel=0.1)
    assert angle / impacts < 10.0


def test_particles_outside_the_box_are_removed():
    box = ((-0.3, -0.3, -0.11), (0.11, 0.5, 0.3))
    setup = Setup(surface=CHANNEL, duration=0.6, removal_box=box)
    problem, schedule = make_problem(CASE, setup)
    state = make_state(problem, 1024, CHANNEL)
    synchronous.advance(problem, schedule, state, int(0.6 / problem.dt))
    live = state.particles[: int(state.tally["live"][0])]
    present = live[live["motion"] != GONE]
    assert state.tally["removed"][0] > 0
    assert present["x"].max() <= 0.11 and present["z"].min() >= -0.11


# Bad input


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"triangles": np.array([(0, 1, 9)])}, r"triangles refers to 0 to 9; allowed are 0 to 2"),
        ({"triangles": np.array([(0, 1, 1)])}, "triangle 0 of the surface has no area"),
        ({"vertices": np.array([(0, 0, 0), (1, 0, 0), (np.nan, 0, 1)])}, "must be finite"),
        ({"velocity": np.zeros((2, 3))}, r"velocity has the shape \(2, 3\), not \(1, 3\)"),
        ({"angular_velocity": [1.0], "axis_direction": np.zeros((1, 3))}, "axis_direction is 0"),
        ({"angular_velocity": [1.0], "velocity": np.ones((1, 3))}, "allowed is one of them"),
        ({"triangles": np.zeros((0, 3), int), "part": np.zeros(0, int)}, "at least one triangle"),
    ],
)
def test_a_malformed_surface_is_refused_in_words(changes, words):
    surface = standing_surface([(0.0, 0, 0), (1, 0, 0), (0, 0, 1)], [(0, 1, 2)])
    check_surface(surface)
    with pytest.raises(ValueError, match=words):
        check_surface(surface._replace(**changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"surface": None, "removal_box": ((0, 0, 0), (1, 1, 1))}, "but no surface"),
        ({"removal_box": ((0, 0, 0), (1, -1, 1))}, "lowest and the highest corner"),
        ({"feed": Feed((0, 0, 0), (1, 0, 0), (0, 0, 1), (0, 0, 0))}, "direction is 0"),
        ({"feed": Feed((0, np.inf, 0), (1, 0, 0), (0, 0, 1))}, "three finite numbers"),
    ],
)
def test_a_malformed_set_up_of_a_surface_is_refused_in_words(changes, words):
    with pytest.raises(ValueError, match=words):
        Setup(**({"surface": CHANNEL} | changes))


def test_areas_of_cells_sum_up_to_the_area():
    assert cell_areas(cut_plane(0.3, 0.2, 25.0, (7, 5), True)).sum() == pytest.approx(0.06)
