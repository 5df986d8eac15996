"""Input of Kratos: particles, a plate of two faces, materials, parameters."""

import json

import KratosMultiphysics as kratos
from KratosMultiphysics import DEMApplication as dem

FIRST_NODE, FIRST_FACE = 1001, 2001
FACES = ((0, 1, 2), (0, 2, 3))


def _block(kind, lines, name=""):
    return "\n".join([f"Begin {kind} {name}", *lines, f"End {kind}", ""])


def write_parts(radius, particles, corners, triangles=FACES):
    """Write the model parts of particles at given positions and of a surface of triangles."""
    numbers = range(1, len(particles) + 1)
    spheres = _block("Properties", [], "1")
    spheres += _block(
        "Nodes", [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(particles, 1)]
    )
    spheres += _block("Elements", [f"{i} 1 {i}" for i in numbers], "SphericParticle3D")
    spheres += _block("NodalData", [f"{i} 0 {radius!r}" for i in numbers], "RADIUS")
    with open("runDEM.mdpa", "w") as file:
        file.write(spheres)
    nodes = [f"{FIRST_NODE + i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(corners)]
    faces = [
        " ".join(str(k) for k in (FIRST_FACE + i, 2, *(FIRST_NODE + corner for corner in face)))
        for i, face in enumerate(triangles)
    ]
    plate = _block("Properties", [], "2")
    plate += _block("Nodes", nodes) + _block("Conditions", faces, "RigidFace3D3N")
    part = _block("SubModelPartData", ["RIGID_BODY_MOTION 0", "IDENTIFIER plate"])
    part += _block("SubModelPartNodes", [line.split()[0] for line in nodes])
    part += _block("SubModelPartConditions", [line.split()[0] for line in faces])
    plate += _block("SubModelPart", [part], "plate")
    with open("runDEM_FEM_boundary.mdpa", "w") as file:
        file.write(plate)


def worn_volume(face):
    """Return the worn volume of a face that shares no node, from the depths at its corners, m3.

    Kratos gives each corner the share of a depth that its shape function has at the contact.
    """
    geometry = face.GetGeometry()
    depth = [node.GetSolutionStepValue(dem.NON_DIMENSIONAL_VOLUME_WEAR) for node in geometry]
    return geometry.Area() * sum(depth)


def write_materials(one):
    """Write the materials; the severity of wear is 1 and the hardness 1: wear is F_n ds."""
    contact = {
        "DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME": "DEM_D_Hertz_viscous_Coulomb",
        "COEFFICIENT_OF_RESTITUTION": one["e"],
        "STATIC_FRICTION": one["mu"],
        "DYNAMIC_FRICTION": one["mu"],
        "FRICTION_DECAY": 0.0,
        "ROLLING_FRICTION": 0.0,
        "ROLLING_FRICTION_WITH_WALLS": 0.0,
        "SEVERITY_OF_WEAR": 1.0,
        "IMPACT_WEAR_SEVERITY": 0.0,
        "BRINELL_HARDNESS": 1.0,
    }
    particle = {
        "PARTICLE_DENSITY": one["rho"],
        "YOUNG_MODULUS": one["e1"],
        "POISSON_RATIO": one["nu1"],
    }
    plate = {"YOUNG_MODULUS": one["e2"], "POISSON_RATIO": one["nu2"], "COMPUTE_WEAR": True}
    materials = {
        "materials": [
            {"material_name": "particle", "material_id": 1, "Variables": particle},
            {"material_name": "plate", "material_id": 2, "Variables": plate},
        ],
        "material_relations": [
            {
                "material_names_list": ["particle", other],
                "material_ids_list": [1, number],
                "Variables": contact,
            }
            for number, other in ((1, "particle"), (2, "plate"))
        ],
        "material_assignation_table": [["SpheresPart", "particle"], ["RigidFacePart", "plate"]],
    }
    with open("materials.json", "w") as file:
        json.dump(materials, file)


def parameters(one, gravity=0.0, search_every=1, skin=0.0):
    """Parameters of a run; neighbours are searched within ``skin`` (m) every so many steps."""
    never = 1e9
    values = {
        "problem_name": "run",
        "Dimension": 3,
        "do_print_results_option": False,
        "dem_inlet_option": False,
        "GravityX": 0.0,
        "GravityY": -gravity,
        "GravityZ": 0.0,
        "TranslationalIntegrationScheme": "Velocity_Verlet",
        "RotationalIntegrationScheme": "Direct_Integration",
        "MaxTimeStep": one["dt"],
        "FinalTime": one["dt"] * (one["steps"] - 0.5),
        "NeighbourSearchFrequency": search_every,
        "SearchTolerance": skin,
        "search_tolerance_against_walls": skin,
        "GraphExportFreq": never,
        "VelTrapGraphExportFreq": never,
        "OutputTimeStep": never,
        "ControlTime": never,
        "solver_settings": {
            "strategy": "sphere_strategy",
            "RemoveBallsInitiallyTouchingWalls": False,
            "material_import_settings": {"materials_filename": "materials.json"},
        },
    }
    return kratos.Parameters(json.dumps(values))
