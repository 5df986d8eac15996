"""Plant errors in copies of the engine and check that the tests detect them.

    python benchmarks/planted_errors.py

Each error is one replacement in one file of a temporary copy of the package. The test that must
detect it is then run on the copy in a separate process. The unchanged copy must pass.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
IMPACTS = "tests/dem/test_impact_laws.py"
SPHERES = "tests/dem/test_spheres_and_plate.py"


@dataclass(frozen=True)
class Error:
    """One error: a replacement in a file, and the test that must fail.

    Parameters
    ----------
    name : str
    file : str
        File name in src/abradem/dem.
    before, after : str
        Text and its replacement; ``before`` must occur exactly once in the file.
    tests : str
        File of the test.
    check : str
        Name of the test.
    quick : bool
        Whether the error is also tested in ``make test``; compiling takes most of the time.
    """

    name: str
    file: str
    before: str
    after: str
    tests: str
    check: str
    quick: bool = False


ERRORS = (
    Error("nominal beta in place of the corrected one", "contact.py",
          'exact_beta(interaction.restitution) if model.normal == "exact_e" else nominal',
          "nominal", IMPACTS, "test_a_normal_impact_rebounds_at_e", quick=True),
    Error("damping not capped", "contact.py", "if trial2 > cap2:",
          "if stretched2 > cap2:", IMPACTS,
          "test_uncapped_damping_exceeds_coulomb_and_capped_does_not"),
    Error("4 G* in place of 8 G*", "contact.py", "kt=8.0 * g_star * root",
          "kt=4.0 * g_star * root", IMPACTS, "test_total_at_30_degrees_tells_the_laws_apart"),
    Error("lever arms of a pair without the overlap", "motion.py", "    arm = 0.5 * distance",
          "    arm = problem.radius", IMPACTS,
          "test_an_oblique_pair_keeps_linear_and_angular_momentum"),
    Error("rolling torque doubled", "motion.py",
          "particle.rolling += law.rolling_friction * max(fn, 0.0) * radius",
          "particle.rolling += 2.0 * law.rolling_friction * max(fn, 0.0) * radius", IMPACTS,
          "test_gross_slip_of_an_elastic_impact_matches_its_closed_form"),
    Error("no entry share", "contact.py", "        return overlap / approach",
          "        return 1.0", IMPACTS,
          "test_default_step_biases_total_as_documented"),
    Error("the paper's time step as the default", "model.py",
          "time_step_fraction: float = 0.15", "time_step_fraction: float = 0.2",
          IMPACTS, "test_default_step_biases_total_as_documented"),
    Error("spring set to cap minus damping", "contact.py",
          "    if stretched2 > cap2:\n"
          "        stretched = scaled(stretched, cap / math.sqrt(stretched2))\n"
          "        stretched2 = cap2\n",
          "    if slips:\n        stretched = plus(force, law.ct * q, vt)\n"
          "        stretched2 = dot(stretched, stretched)\n",
          IMPACTS, "test_total_at_30_degrees_tells_the_laws_apart"),
    Error("all motion counts as slip once the limit is active", "contact.py",
          "slip_share(stretched, damping, cap2 - stretched2) if slips else 0.0",
          "1.0 if slips else 0.0", IMPACTS,
          "test_sliding_does_not_jump_where_an_impact_begins_to_slip"),
    Error("cross product turned round", "vectors.py", "fma(a[1], b[2], -(a[2] * b[1]))",
          "fma(a[2], b[1], -(a[1] * b[2]))", "tests/dem/test_vectors.py",
          "test_vectors_are_those_of_numpy"),
    Error("wear takes the new force alone", "motion.py",
          "total = 0.5 * (max(fn_old, 0.0) + max(fn, 0.0))", "total = max(fn, 0.0)", SPHERES,
          "test_a_crowd_moves_as_its_naive_twin"),
    Error("spring of a pair not turned with the contact", "motion.py",
          "spring = rotated((pair.sx, pair.sy, pair.sz), n)",
          "spring = (pair.sx, pair.sy, pair.sz)", SPHERES, "test_a_crowd_moves_as_its_naive_twin"),
    Error("gravity forgotten in contact", "motion.py",
          "particle.fy = -problem.mass * problem.gravity", "particle.fy = 0.0", SPHERES,
          "test_a_resting_sphere_weighs_its_weight"),
    Error("edges ignored", "plate.py", "    side = along - near_along\n",
          "    side = 0.0 * (along - near_along)\n", SPHERES,
          "test_face_edge_and_miss_are_told_apart"),
    Error("pair list made again too late", "synchronous.py",
          "tally.drift > SKIN * problem.radius", "tally.drift > 3.0 * SKIN * problem.radius",
          SPHERES, "test_an_old_pair_list_misses_no_contact"),
)  # fmt: skip


def caught(error: Error | None, folder: Path) -> set[str]:
    """Return the names of the tests that fail with a planted error; None plants no error.

    Parameters
    ----------
    error : Error or None
    folder : Path
        An empty folder for the copy.
    """
    package = Path(folder, "abradem")
    shutil.copytree(ROOT / "src" / "abradem", package, ignore=shutil.ignore_patterns("__pycache__"))
    tests = [IMPACTS, SPHERES]
    choice = []
    if error is not None:
        source = package / "dem" / error.file
        text = source.read_text(encoding="utf-8")
        if text.count(error.before) != 1:
            raise ValueError(
                f"{error.name}: found {text.count(error.before)} times in {error.file}, not once"
            )
        source.write_text(text.replace(error.before, error.after), encoding="utf-8")
        tests, choice = [error.tests], ["-k", error.check]
    environment = os.environ | {
        "PYTHONPATH": str(folder), "ABRADEM_CACHE_DIR": str(Path(folder, "cache")),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *choice, *tests],
        cwd=ROOT, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode not in (0, 1):
        raise RuntimeError(f"pytest ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return set(re.findall(r"^(?:FAILED|ERROR) \S+::(\w+)", done.stdout, re.MULTILINE))


def main() -> int:
    """Plant all errors in turn; return the number of undetected errors."""
    unnoticed = 0
    for error in (None, *ERRORS):
        with tempfile.TemporaryDirectory() as folder:
            failing = caught(error, Path(folder))
        if error is None:
            fine = not failing
            print(f"{'ok' if fine else 'FAILS'}: no error planted, failing tests: {len(failing)}")
        else:
            fine = error.check in failing
            print(f"{'caught' if fine else 'UNNOTICED'}: {error.name}: {error.check}")
        unnoticed += not fine
    return unnoticed


if __name__ == "__main__":
    sys.exit(main())
