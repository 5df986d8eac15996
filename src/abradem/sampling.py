"""Which parameter sets are simulated: drawn in blocks, checked for physical consistency.

A block is a pure function of the study's seed and the block's index. So a study grows by
adding blocks, and no earlier case changes. Each block of a Latin hypercube is a Latin
hypercube of its own; the blocks of a Sobol sequence are its successive pieces.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from abradem.parameters import SAMPLED, SAMPLED_NAMES, check_value

if TYPE_CHECKING:
    import pandas as pd

    from abradem.dem.model import Setup

METHODS = ("lhs", "sobol", "uniform")

LARGEST_OVERLAP = 0.2
"""Overlap at impact, as a share of the radius, beyond which the Hertz theory means nothing."""

FEWEST_STEPS = 8
"""Time steps that an impact must last to be integrated at all."""

HERTZ_DURATION = 2.94327
"""Duration of an elastic impact times its velocity over its largest overlap."""

_SEED_TAG = b"abradem case seed 1"


def block_cases(
    seed: int,
    block: int,
    cases_per_block: int,
    method: str,
    ranges: Mapping[str, tuple[float, float]],
    setup: Setup | None = None,
) -> pd.DataFrame:
    """Draw one block of cases.

    Parameters
    ----------
    seed : int
        Seed of the study.
    block : int
        Index of the block.
    cases_per_block : int
    method : {"lhs", "sobol", "uniform"}
    ranges : mapping of str to (float, float)
        Lower and upper bound of each sampled quantity, in the units of `abradem.parameters`;
        equal bounds keep it fixed.
    setup : Setup, optional
        If given, each set is also checked against it, see `check_case`.

    Returns
    -------
    pandas.DataFrame
        One row per case: ``case_id``, ``block``, ``seed``, the sampled quantities and
        ``rejected``, empty or the reason why the set cannot be simulated. A rejected case
        keeps its ``case_id``.
    """
    import pandas as pd

    missing = [name for name in SAMPLED_NAMES if name not in ranges]
    unknown = [name for name in ranges if name not in SAMPLED_NAMES]
    if missing or unknown:
        raise ValueError(f"ranges: missing {missing}, unknown {unknown}")
    lower, upper = np.array([ranges[name] for name in SAMPLED_NAMES], dtype=float).T
    if not (np.isfinite(lower).all() and np.isfinite(upper).all() and (lower <= upper).all()):
        raise ValueError("ranges: bounds must be finite, the lower not above the upper")

    points = _unit_points(seed, block, cases_per_block, method)
    # Rounding must not lift a value over its bound.
    values = np.clip(lower + points * (upper - lower), lower, upper)

    case_id = block * cases_per_block + np.arange(cases_per_block, dtype=np.int64)
    frame = pd.DataFrame(
        {
            "case_id": case_id,
            "block": np.full(cases_per_block, block, dtype=np.int32),
            "seed": np.array([case_seed(seed, int(case)) for case in case_id], dtype=np.int64),
            **dict(zip(SAMPLED_NAMES, values.T, strict=True)),
        }
    )
    rows = frame[list(SAMPLED_NAMES)].to_dict("records")
    frame["rejected"] = pd.array([check_case(row, setup) for row in rows], dtype="str")
    return frame


def case_seed(study_seed: int, case_id: int) -> int:
    """Return the seed of a case, 63 bits of a hash, so that neighbours have nothing in common."""
    digest = hashlib.sha256(_SEED_TAG + f" {study_seed} {case_id}".encode()).digest()
    return int.from_bytes(digest[:8], "little") >> 1


def check_case(values: Mapping[str, float], setup: Setup | None = None) -> str:
    """Say why a parameter set cannot be simulated, or return an empty string.

    Parameters
    ----------
    values : mapping of str to float
        The sampled quantities, in the units of `abradem.parameters`.
    setup : Setup, optional
        If given, the set is also checked against plate, factory and time step: the particle is
        not wider than the plate and starts clear of it, an impact from the full fall height
        overlaps by less than 20 % of the radius, and it lasts enough time steps.
    """
    for row in SAMPLED:
        problem = check_value(row.name, values[row.name])
        if problem:
            return problem
    if setup is None:
        return ""
    return _check_geometry(values, setup) or _check_impact(values, setup)


def rayleigh_time(radius: float, density: float, shear_modulus: float, poisson_ratio: float):
    """Return the Rayleigh time pi R sqrt(rho/G) / (0.1631 nu + 0.8766), s."""
    travel = math.pi * radius * math.sqrt(density / shear_modulus)
    return travel / (0.1631 * poisson_ratio + 0.8766)


def _unit_points(seed: int, block: int, cases: int, method: str) -> np.ndarray:
    """Return points in the unit cube, shape (cases, 14)."""
    dimensions = len(SAMPLED_NAMES)
    if method == "uniform":
        return _generator(seed, block).random((cases, dimensions))
    from scipy.stats import qmc

    if method == "lhs":
        return qmc.LatinHypercube(dimensions, rng=_generator(seed, block)).random(cases)
    if method == "sobol":
        # All blocks are pieces of one sequence: scrambled anew for each, their points would be
        # reflections of each other instead of filling the gaps.
        sequence = qmc.Sobol(dimensions, scramble=True, rng=_generator(seed, 0))
        if block:
            sequence.fast_forward(block * cases)
        with warnings.catch_warnings():
            # That it is balanced at powers of two only stands in the documentation.
            warnings.filterwarnings("ignore", "The balance properties", UserWarning)
            return sequence.random(cases)
    raise ValueError(f"method = {method!r} is unknown; allowed: {', '.join(METHODS)}")


def _generator(seed: int, block: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(block,)))


def _check_geometry(values: Mapping[str, float], setup: Setup) -> str:
    radius = values["particle_radius"]
    narrow = min(setup.plate_length, setup.plate_width)
    if 2.0 * radius > narrow:
        return f"particle of radius {radius:g} m is wider than the plate ({narrow:g} m)"
    plate = _segment(0.0, setup.plate_length, values["plate_angle"])
    patch = _segment(setup.fall_height, setup.patch_length, values["factory_angle"])
    clearance = _segment_distance(*plate, *patch)
    if clearance <= radius:
        return (
            f"the factory patch comes within {clearance:.3g} m of the plate, "
            f"closer than the radius {radius:.3g} m"
        )
    return ""


def _check_impact(values: Mapping[str, float], setup: Setup) -> str:
    """Check overlap and duration of a head-on elastic impact (Hertz) at the end of the fall."""
    radius = values["particle_radius"]
    speed = math.sqrt(values["particle_velocity_y"] ** 2 + 2.0 * setup.gravity * setup.fall_height)
    if speed == 0.0:
        return "the particle neither starts with a velocity nor falls"
    mass = 4.0 / 3.0 * math.pi * radius**3 * values["particle_density"]
    # 1/E* = (1 - nu_p^2)/E_p + (1 - nu_e^2)/E_e with E = 2 G (1 + nu)
    compliance = sum(
        (1.0 - values[f"{body}_poisson_ratio"]) / (2.0 * values[f"{body}_shear_modulus"])
        for body in ("particle", "equipment")
    )
    stiffness = 4.0 / 3.0 * math.sqrt(radius) / compliance
    overlap = (5.0 * mass * speed**2 / (4.0 * stiffness)) ** 0.4
    if overlap > LARGEST_OVERLAP * radius:
        return (
            f"an impact at {speed:.3g} m/s would overlap by {overlap / radius:.0%} of the radius "
            f"(allowed {LARGEST_OVERLAP:.0%}): too soft for this speed"
        )
    step = setup.time_step or setup.time_step_fraction * rayleigh_time(
        radius,
        values["particle_density"],
        values["particle_shear_modulus"],
        values["particle_poisson_ratio"],
    )
    steps = HERTZ_DURATION * overlap / speed / step
    if steps < FEWEST_STEPS:
        return (
            f"an impact at {speed:.3g} m/s lasts {steps:.1f} time steps "
            f"(allowed at least {FEWEST_STEPS}): the time step is too long"
        )
    return ""


def _segment(height: float, length: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends, shape (2,), of a line about (0, height) tilted by ``angle``, deg."""
    half = 0.5 * length * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    centre = np.array([0.0, height])
    return centre - half, centre + half


def _segment_distance(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Return the distance between the segments ab and cd in the plane."""

    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    if side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0:
        return 0.0

    def to_segment(p, q, r):
        along = np.clip(np.dot(r - p, q - p) / np.dot(q - p, q - p), 0.0, 1.0)
        return float(np.hypot(*(r - p - along * (q - p))))

    return min(to_segment(a, b, c), to_segment(a, b, d), to_segment(c, d, a), to_segment(c, d, b))
