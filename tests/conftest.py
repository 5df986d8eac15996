"""Lets tests import reference implementations and checks from this folder.

`make quick` leaves out the tests that are marked as slow, here by folder and file, as measured by
``pytest --durations=0``.
"""

from pathlib import Path

import pytest

HERE = Path(__file__).parent
SLOW = (
    # Whole studies.
    "workflow",
    # The engine: many compilations, or long jets.
    "dem/test_cache.py",
    "dem/test_cache_robust.py",
    "dem/test_islands.py",
    "dem/test_jet.py",
    "dem/test_mutations.py",
    "dem/test_spheres_and_plate.py",
    # The command, again and again.
    "running/test_environment.py",
    "simulation/test_resources.py",
    "verification",
    # A search over set-ups.
    "calibration",
    # All models are trained first.
    "figures/test_baselines.py",
    "figures/test_physical.py",
    "learning/baselines/test_networks.py",
    "learning/baselines/test_regressions.py",
    "learning/physical/test_models.py",
    "learning/test_protocols.py",
    "report/test_small_studies.py",
    # Hundreds of mutated files.
    "test_fuzz.py",
)
"""Folders and files below this one whose tests are slow."""


def pytest_collection_modifyitems(items):
    slow = [HERE / name for name in SLOW]
    for item in items:
        if any(item.path.is_relative_to(place) for place in slow):
            item.add_marker(pytest.mark.slow)
